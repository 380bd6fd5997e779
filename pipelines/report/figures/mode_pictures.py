"""Pictures of a casing's natural modes: a sheet of stills; of one mode a still, a GIF and a self-contained page."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fem.elements.facets import drawn_triangles
from pipelines.io.user_files import write_whole
from pipelines.report.figures.frame_files import film_page, png, write_gif
from pipelines.report.figures.labelled_pictures import draw_axes, show
from pipelines.report.figures.plots import LETTER, new_figure, plain
from pipelines.report.figures.render import render_mode
from pipelines.report.figures.views import Picture

FRAMES = 16  # of one period
STILL = 4  # frames of one for a still: the second one shows the largest deflection
ON_A_SHEET = 24  # modes
_COLUMNS = 4
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


def write_mode(view: ModeView, stem: str) -> list[Path]:
    """<stem>-mode_<n>.png, .gif and .html."""
    pictures = render_mode(*_surface(view), FRAMES)
    size = np.ptp(view.nodes, axis=0)
    frames = [png(mode_figure(view, picture, size)) for picture in pictures]
    still, film, page = (Path(f"{stem}-mode_{view.number}{ending}") for ending in (".png", ".gif", ".html"))
    write_whole(still, frames[FRAMES // 4])  # the largest deflection
    write_gif(frames, film, _MILLISECONDS)
    title = f"{view.title}: mode {view.number}, {view.frequency:.1f} Hz"
    degrees = [f"{360 * n / FRAMES:.0f}\u00b0" for n in range(FRAMES)]
    write_whole(page, film_page(title, frames, "phase", degrees, _MILLISECONDS))
    return [still, film, page]


def write_modes(
    views: Iterable[ModeView], count: int, stem: str, on_progress: Callable[[int, int], None]
) -> list[Path]:
    """<stem>-modes.png with a still of every mode, or <stem>-modes_<n>.png of `ON_A_SHEET` each.

    Parameters
    ----------
    views, count : the modes and their number
    stem : begin of the names of the files, with their folder
    on_progress : called with the number of finished stills and that of all
    """
    written: list[Path] = []
    remaining = iter(views)
    while sheet := list(islice(remaining, ON_A_SHEET)):
        stills: list[Picture] = []
        for view in sheet:
            stills.append(render_mode(*_surface(view), STILL, (560, 400))[STILL // 4])
            on_progress(ON_A_SHEET * len(written) + len(stills), count)
        number = f"_{len(written) + 1}" if count > ON_A_SHEET else ""
        written.append(Path(f"{stem}-modes{number}.png"))
        write_whole(written[-1], png(sheet_figure(sheet, stills), dpi=100))
    return written


def _surface(view: ModeView) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, triangles and displacements of the surface alone."""
    triangles = drawn_triangles(view.facets)
    used, place = np.unique(triangles, return_inverse=True)
    return view.nodes[used], place.reshape(-1, 3), view.shape[used]


def sheet_figure(views: Sequence[ModeView], stills: Sequence[Picture]) -> Figure:
    """Largest deflections side by side, each with its number and frequency, on one colour scale."""

    columns = min(_COLUMNS, len(views))
    rows = -(-len(views) // columns)
    width = 3.0 * columns + 1.0
    title = f"{views[0].title}: natural modes, deflections exaggerated"
    figure = new_figure(0.7 + 2.3 * rows, width)
    figure.suptitle(textwrap.fill(plain(title), int(width / (1.1 * LETTER))), fontsize=11)
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.ravel():
        axes.set_axis_off()
    for axes, view, still in zip(grid.ravel(), views, stills, strict=False):
        _, right, _, bottom = show(axes, still, whole=True)
        if view is views[0]:
            draw_axes(axes, still, (0.86 * right, 0.95 * bottom))
        axes.set_title(f"mode {view.number}: {view.frequency:.1f} Hz", fontsize=10)
    scale = ScalarMappable(Normalize(0.0, 1.0), cmap="viridis")
    bar = figure.colorbar(scale, ax=list(grid.ravel()), shrink=0.6, pad=0.01, aspect=30)
    bar.set_label("displacement amplitude relative to its maximum")
    return figure


def mode_figure(view: ModeView, picture: Picture, size: np.ndarray) -> Figure:
    """One frame with title, axes and colour scale."""
    title = f"{plain(view.title)}\nmode {view.number}: {view.frequency:.1f} Hz"
    figure = new_figure(6.2, 9.5, title)
    axes = figure.subplots()
    _, right, _, bottom = show(axes, picture, whole=True)
    draw_axes(axes, picture, (0.86 * right, 0.95 * bottom))
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
