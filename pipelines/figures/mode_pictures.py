"""Moving pictures of a casing's natural mode: a still, a GIF and a page that needs nothing but itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fem.elements.facets import drawn_triangles
from pipelines.border.user_files import write_whole
from pipelines.figures.film import film_page, png, write_gif
from pipelines.figures.render import render_mode
from pipelines.figures.views import LeftOut, Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRAMES = 16  # of one period
_MILLISECONDS = 70  # per frame


@dataclass(frozen=True, eq=False, kw_only=True)
class ModeView:
    """A mode to be shown: surface of the body at rest and displacements of length at most 1."""

    title: str  # of the body
    number: int  # from 1
    frequency: float  # Hz
    nodes: np.ndarray  # (n, 3), m
    facets: np.ndarray  # (f, k), see fem.elements.facets
    shape: np.ndarray  # (n, 3)


def write_mode(view: ModeView, folder: Path) -> list[Path] | LeftOut:
    """casing_mode_<n>.png, .gif and .html in a folder; the reason if they cannot be rendered."""
    triangles = drawn_triangles(view.facets)
    used, place = np.unique(triangles, return_inverse=True)
    pictures = render_mode(view.nodes[used], place.reshape(-1, 3), view.shape[used], FRAMES)
    if isinstance(pictures, LeftOut):
        return pictures
    size = np.ptp(view.nodes, axis=0)
    frames = [png(mode_figure(view, picture, size)) for picture in pictures]
    stem = folder / f"casing_mode_{view.number}"
    still, film, page = (stem.with_suffix(ending) for ending in (".png", ".gif", ".html"))
    write_whole(still, frames[FRAMES // 4])  # the largest deflection
    write_gif(frames, film, _MILLISECONDS)
    title = f"{view.title}: mode {view.number}, {view.frequency:.1f} Hz"
    degrees = [f"{360 * n / FRAMES:.0f}\u00b0" for n in range(FRAMES)]
    write_whole(page, film_page(title, frames, "phase", degrees, _MILLISECONDS))
    return [still, film, page]


def mode_figure(view: ModeView, picture: Picture, size: np.ndarray) -> Figure:
    """One frame with title, axes and colour scale."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    from pipelines.figures.callouts import draw_axes, show
    from pipelines.figures.plots import new_figure, plain

    figure = new_figure(6.2, 9.5)
    axes = figure.subplots()
    _, right, _, bottom = show(axes, picture, whole=True)
    draw_axes(axes, picture, (0.86 * right, 0.95 * bottom))
    figure.suptitle(f"{plain(view.title)}\nmode {view.number}: {view.frequency:.1f} Hz")
    length, width, height = (1000 * v for v in size)
    axes.text(
        0.0,
        0.0,
        f"body {length:.0f} x {width:.0f} x {height:.0f} mm (x, y, z); deflection exaggerated",
        transform=axes.transAxes,
        fontsize=9,
        va="bottom",
    )
    bar = figure.colorbar(ScalarMappable(Normalize(0.0, 1.0), cmap="viridis"), ax=axes, shrink=0.7, pad=0.01)
    bar.set_label("displacement amplitude relative to its maximum")
    return figure
