"""A numbered picture of a housing from a file: its bores from two sides."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from fem.casing.recognition.housing_contents import GeometryContents

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_LABELS = 60
_HEIGHT = 25.0  # deg above the horizon
_FAR = 0.5  # brightness of the farthest triangle, of that of the nearest
_LIGHT = np.array([0.35, -0.75, 0.56])
_LABEL = {"facecolor": "white", "alpha": 0.7, "linewidth": 0.0, "pad": 1.0}
_WALL, _SEAT, _OTHER = "#b9c2cc", "#c0392b", "#1f4e79"


def housing_picture(contents: GeometryContents, seats: dict[int, str]) -> Figure:
    """The surface from two sides, with the numbers of the widest bores; seats in red with the name of their bearing.

    A bore has its number where its end is seen; the title lists those that no side shows.

    Parameters
    ----------
    contents : what the file holds
    seats : name of the bearing by number of the bore
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.0, 7.0), layout="tight")
    hidden = {bore.number for bore in contents.bores[:MOST_LABELS]}
    for place, azimuth in enumerate((-60.0, 120.0), 1):
        axes = figure.add_subplot(1, 2, place, projection="3d")
        _draw(axes, contents, azimuth)
        for bore in contents.bores[:MOST_LABELS]:
            name, colour = str(bore.number), _OTHER
            if bore.number in seats:
                name, colour = f"{bore.number}: {seats[bore.number]}", _SEAT
            end = bore.ends[int((bore.ends @ _eye(azimuth)).argmax())]
            if not _seen(contents, end, _eye(azimuth)):
                continue
            hidden.discard(bore.number)
            x, y, z = 1000 * end
            axes.text(x, y, z, name, color=colour, fontsize=8, ha="center", zorder=10, bbox=_LABEL)
    title = f"{contents.name}: bores by number, the widest first (mm)"
    if hidden:
        title += "\n" + textwrap.fill(f"not visible from these sides: {', '.join(map(str, sorted(hidden)))}", 140)
    figure.suptitle(title)
    return figure


def _seen(contents: GeometryContents, place: np.ndarray, eye: np.ndarray) -> bool:
    """Whether no triangle lies between a place and the eye (Moller & Trumbore 1997, J. Graphics Tools 2, 21-28)."""
    first, second, third = contents.points[contents.triangles].transpose(1, 0, 2)
    along, across = second - first, third - first
    normal = np.cross(eye, across)
    volume = np.einsum("ij,ij->i", along, normal)
    met = abs(volume) > 1e-12 * np.linalg.norm(along, axis=1) * np.linalg.norm(across, axis=1)
    first, along, across, normal, volume = (part[met] for part in (first, along, across, normal, volume))
    away = place - first
    turned = np.cross(away, along)
    u, v = np.einsum("ij,ij->i", away, normal) / volume, turned @ eye / volume
    distance = np.einsum("ij,ij->i", across, turned) / volume
    near = 1e-6 * float(np.ptp(contents.box, axis=0).max())
    return not bool(((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > near)).any())


def _draw(axes: object, contents: GeometryContents, azimuth: float) -> None:
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
    depth = corners.mean(axis=1) @ _eye(azimuth)
    bright *= np.interp(depth, (depth.min(), depth.max()), (_FAR, 1.0))  # or a bore looks closed by the far wall
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
