"""Pictures of the mesh of a stage: contact lines in three dimensions, stiffness and load share, healthy above
faulty.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipelines.io.user_files import write_whole
from pipelines.report.figures.colours import FAULTY, GONE, HEALTHY, LOAD_COLOURS, PAIR_COLOURS, PINION, WHEEL
from pipelines.report.figures.frame_files import film_page, png, save_figure, write_gif
from pipelines.report.figures.labelled_pictures import draw_axes, show
from pipelines.report.figures.plots import dress, legend, new_figure, plain
from pipelines.report.figures.render import render_mesh
from pipelines.report.figures.tooth_mesh_frames import MeshFrames, MeshView
from pipelines.report.figures.views import Picture

MILLISECONDS = 160  # per frame of an animation
STILL_SIZE, FILM_SIZE = (1000, 690), (600, 414)  # pixels of a rendered state


def write_still(view: MeshView, stem: Path) -> Path:
    """Write <stem>.png of the middle frame."""
    pictures = _rendered(view)
    middle, still = len(view.cycles) // 2, stem.with_suffix(".png")
    save_figure(mesh_figure(view, [frames[middle] for frames in pictures], middle, view.most_load), still, dpi=115)
    return still


def write_film(view: MeshView, stem: Path, on_progress: Callable[[int, int], None]) -> list[Path]:
    """Write <stem>.gif and .html with all frames.

    Parameters
    ----------
    view : gears and states
    stem : of the files
    on_progress : called with the number of finished pictures and that of all
    """
    pictures = _rendered(view, FILM_SIZE)
    frames = []
    for n in range(len(view.cycles)):
        frames.append(png(mesh_figure(view, [of_state[n] for of_state in pictures], n, view.most_load)))
        on_progress(len(frames), len(view.cycles))
    film, page = stem.with_suffix(".gif"), stem.with_suffix(".html")
    write_gif(frames, film, MILLISECONDS)
    labels = [f"mesh cycle {cycle:.3f}" for cycle in view.cycles]
    write_whole(page, film_page(view.title, frames, "position", labels, MILLISECONDS))
    return [film, page]


def _rendered(view: MeshView, size: tuple[int, int] = STILL_SIZE) -> list[list[Picture]]:
    """All frames of every state; the states are rendered in parallel, because each takes one processor."""
    gears = [view.of_state(n) for n in range(len(view.states))]
    with ThreadPoolExecutor(len(gears)) as pool:
        return list(pool.map(lambda g, s: render_mesh(g, view.cycles, s, view.most_load, size), gears, view.states))


def mesh_figure(view: MeshView, pictures: Sequence[Picture], frame: int, most: float) -> Figure:
    """One frame: a row for each state of the teeth, and both curves with the position marked.

    Parameters
    ----------
    view : gears and states
    pictures : the rendered frame of every state
    frame : its number, from 0
    most : N/m, line load at the end of the colour scale
    """
    rows = len(pictures)
    cycle = float(view.cycles[frame])
    title = f"{plain(view.title)}\nmesh cycle {cycle:.3f}, load {view.force:.4g} N, model {view.model}"
    figure = new_figure(2.4 + 3.4 * rows, 13.0, title)
    halves: Any = figure.subfigures(1, 2, width_ratios=[1.15, 1.0])
    left, right = halves
    boxes = np.atleast_1d(left.subplots(rows, 1))
    for axes, picture, state in zip(boxes, pictures, view.states, strict=True):
        _draw_picture(axes, picture, view, state, frame)
    scale = ScalarMappable(Normalize(0.0, most / 1000), cmap=LOAD_COLOURS)
    left.colorbar(scale, ax=boxes.tolist(), location="bottom", shrink=0.7, aspect=40).set_label("line load, N/mm")
    stiffness, *shares = np.atleast_1d(right.subplots(1 + rows, 1, sharex=True))
    _draw_stiffness(stiffness, view, cycle)
    for axes, state in zip(shares, view.states, strict=True):
        _draw_shares(axes, state, cycle)
    shares[-1].set_xlabel("mesh cycle")
    return figure


def _draw_picture(axes: Axes, picture: Picture, view: MeshView, state: MeshFrames, frame: int) -> None:
    _, right, _, bottom = show(axes, picture, whole=True)
    draw_axes(axes, picture, (0.09 * right, 0.88 * bottom))
    most = np.nanmax(state.pressure[frame]) / 1e6 if np.isfinite(state.pressure[frame]).any() else 0.0
    axes.set_title(
        f"{state.name}: Hertz pressure up to {most:.0f} MPa at this position\n"
        f"face width {1000 * view.gears.pair.face_width:.4g} mm along y; x, y, z 1:1",
        fontsize=9,
        loc="left",
    )
    handles: list[Patch | Line2D] = [
        Patch(color=PINION, alpha=0.6, label="pinion"),
        Patch(color=WHEEL, alpha=0.6, label="wheel"),
        Line2D([], [], color="#21918c", lw=4, label="contact lines (colour: load)"),
    ]
    if state is not view.states[0] and view.marked:
        handles.append(
            Patch(color=GONE, alpha=0.5 if view.damaged and view.damaged.missing else 1.0, label=view.marked)
        )
    # below the picture, because a legend over it would hide contact lines
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=2, fontsize=8, frameon=False)


def _draw_stiffness(axes: Axes, view: MeshView, cycle: float) -> None:
    for state, colour in zip(view.states, (HEALTHY, FAULTY), strict=False):
        curve = state.curve
        axes.plot(curve.cycle, curve.secant / 1e6, color=colour, label=state.name)
        here = float(np.interp(cycle, curve.cycle, curve.secant)) / 1e6
        axes.plot([cycle], [here], "o", color=colour, ms=7)
    axes.axvline(cycle, color="black", lw=0.9, ls=":")
    axes.set_ylim(0, None)
    axes.margins(x=0)
    dress(axes, "Mesh stiffness (secant)", "", "stiffness, N/µm")
    legend(axes)


def _draw_shares(axes: Axes, state: MeshFrames, cycle: float) -> None:
    curve = state.curve
    for number, share in zip(curve.pair, curve.share.T, strict=True):
        loaded = np.where(share > 0.0, share, np.nan)
        colour = PAIR_COLOURS[int(number) % len(PAIR_COLOURS)]
        axes.plot(curve.cycle, 100 * loaded, color=colour, lw=1.3, label=f"pair {number}")
        here = float(np.interp(cycle, curve.cycle, share))
        if here > 0.0:
            axes.plot([cycle], [100 * here], "o", color=colour, ms=6)
    axes.axvline(cycle, color="black", lw=0.9, ls=":")
    axes.set_ylim(0, 105)
    axes.margins(x=0)
    dress(axes, f"Load share of the tooth pairs, {state.name}", "", "share, %")
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
