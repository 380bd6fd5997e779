"""Contact pattern of a tooth over its whole engagement on the unrolled flank, healthy next to faulty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pipelines.report.figures.colours import GONE, LOAD_COLOURS
from pipelines.report.figures.film import save_figure
from pipelines.report.figures.pattern import ContactPattern
from pipelines.report.figures.plots import new_figure, plain


@dataclass(frozen=True, eq=False, kw_only=True)
class PatternView:
    """Contact patterns of a tooth, the healthy one first, and the place of its damage.

    `damaged` (row, slice) is from 0 to 1 at the deepest, `crack` the ends of a crack along the face (m) or None;
    `sense` is +1 if the face coordinate runs along the global y, else -1.
    """

    title: str
    model: str
    force: float  # N
    gear: str
    patterns: Sequence[ContactPattern]
    damaged: np.ndarray
    crack: tuple[float, float] | None
    pitch_diameter: float  # m
    face_width: float  # m
    sense: int


def write_pattern(view: PatternView, path: Path) -> Path:
    """Write the picture to a file."""
    save_figure(pattern_figure(view), path, dpi=115)
    return path


def pattern_figure(view: PatternView) -> Figure:
    """A flank for each state: the face across, along the global y, and the diameter upwards; one scale of pressure."""

    figure = new_figure(4.6, 6.0 * len(view.patterns))
    load = f"load {view.force:.4g} N, model {view.model}"
    words = "grey: no contact" + ("; red outline: damage" if view.damaged.any() else "")
    figure.suptitle(f"{plain(view.title)}\ncontact pattern over a whole engagement, {load}\n{words}")
    boxes = np.atleast_1d(figure.subplots(1, len(view.patterns), sharey=True))
    most = max(float(np.nanmax(one.pressure, initial=0.0)) for one in view.patterns) / 1e6 or 1.0
    drawn = None
    for number, (axes, one) in enumerate(zip(boxes, view.patterns, strict=True)):
        half = 1000 * view.face_width / 2
        face, diameter = 1000 * view.sense * one.face, 1000 * one.diameter
        drawn = axes.pcolormesh(
            face, diameter, one.pressure / 1e6, cmap=LOAD_COLOURS, vmin=0.0, vmax=most, shading="gouraud"
        )
        axes.set_facecolor("#e8e8e8")
        axes.axhline(1000 * view.pitch_diameter, color="black", lw=0.9, ls=":")
        axes.set_xlim(-half, half)
        axes.annotate("pitch circle", (-half, 1000 * view.pitch_diameter), xytext=(3, 3),
                      textcoords="offset points", fontsize=8)  # fmt: skip
        if number and view.damaged.any():
            axes.contour(face, diameter, view.damaged, levels=[0.05], colors=GONE, linewidths=2.2)
        if number and view.crack is not None:
            low, high = sorted(1000 * view.sense * end for end in view.crack)
            axes.plot([low, high], [diameter[0]] * 2, color=GONE, lw=5, clip_on=False, solid_capstyle="butt")
            axes.annotate("crack in the fillet below", ((low + high) / 2, diameter[0]), xytext=(0, 8), ha="center",
                          textcoords="offset points", fontsize=9, color=GONE, fontweight="bold")  # fmt: skip
        greatest = float(np.nanmax(one.pressure, initial=0.0)) / 1e6
        axes.set_title(f"{one.name}: greatest Hertz pressure {greatest:.0f} MPa", fontsize=10, loc="left")
        axes.set_xlabel("y along the face from mid face, mm")
    boxes[0].set_ylabel(f"diameter on the {view.gear}, mm (tip above)")
    if drawn is not None:
        figure.colorbar(drawn, ax=list(boxes), shrink=0.9, pad=0.01).set_label("Hertz pressure, MPa")
    return figure
