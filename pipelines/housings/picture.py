"""A numbered picture of a housing from a file: its bores from two sides."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fem.casing.survey.contents import Contents

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_LABELS = 60
_HEIGHT = 25.0  # deg above the horizon
_LIGHT = np.array([0.35, -0.75, 0.56])
_WALL, _SEAT, _OTHER = "#b9c2cc", "#c0392b", "#1f4e79"


def housing_picture(contents: Contents, seats: dict[int, str]) -> Figure:
    """The surface from two sides, with the numbers of the widest bores; seats in red with the name of their bearing.

    Parameters
    ----------
    contents : what the file holds
    seats : name of the bearing by number of the bore
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.0, 7.0), layout="tight")
    for place, azimuth in enumerate((-60.0, 120.0), 1):
        axes = figure.add_subplot(1, 2, place, projection="3d")
        _draw(axes, contents, azimuth)
        for bore in contents.bores[:MOST_LABELS]:
            name, colour = str(bore.number), _OTHER
            if bore.number in seats:
                name, colour = f"{bore.number}: {seats[bore.number]}", _SEAT
            if (bore.centre - contents.box.mean(axis=0)) @ _eye(azimuth) < 0.0:
                continue  # the other view shows it
            x, y, z = 1000 * bore.ends[int((bore.ends @ _eye(azimuth)).argmax())]
            axes.text(x, y, z, name, color=colour, fontsize=8, ha="center", zorder=10)
    figure.suptitle(f"{contents.name}: bores by number, the widest first (mm)")
    return figure


def _draw(axes: object, contents: Contents, azimuth: float) -> None:
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = 1000 * contents.points[contents.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    seen = normal @ _eye(azimuth) > 0.0
    corners, normal = corners[seen], normal[seen]
    turn = np.radians(azimuth + 60.0)
    light = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]) @ _LIGHT
    bright = 0.45 + 0.55 * np.clip(normal @ light, 0.0, 1.0)
    colours = np.outer(bright, to_rgb(_WALL))
    axes.add_collection3d(Poly3DCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.1))  # type: ignore[attr-defined]
    low, high = 1000 * contents.box
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))  # type: ignore[attr-defined]
    axes.set(xlabel="x", ylabel="y", zlabel="z")  # type: ignore[attr-defined]
    axes.set_box_aspect(np.maximum(high - low, 1e-3 * (high - low).max()))  # type: ignore[attr-defined]
    axes.view_init(elev=_HEIGHT, azim=azimuth)  # type: ignore[attr-defined]


def _eye(azimuth: float) -> np.ndarray:
    """Direction (3,) to the eye."""
    return np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), np.tan(np.radians(_HEIGHT))])
