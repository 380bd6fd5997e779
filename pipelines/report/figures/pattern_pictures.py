"""Contact pattern of a tooth over its whole engagement on the unrolled flank, healthy next to faulty."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from fem.contact.evaluation.contact_pattern import ContactPattern
from pipelines.report.figures.colours import GONE, LOAD_COLOURS
from pipelines.report.figures.plots import new_figure, plain


def pattern_figure(
    title: str,
    patterns: Sequence[ContactPattern],
    *,
    load: str,
    gear: str,
    damaged: np.ndarray,
    crack: tuple[float, float] | None,
    pitch_diameter: float,
    sense: int,
) -> Figure:
    """A flank for each state: the face across, along the global y, and the diameter upwards; one scale of pressure.

    Parameters
    ----------
    title, load : of the figure: machine and tooth, load and mesh model
    patterns : contact patterns of a tooth of `gear`, the healthy one first
    gear : "pinion" | "wheel"
    damaged : (row, slice), from 0 to 1 where the damage is deepest
    crack : ends of a crack along the face, m, or None
    pitch_diameter : m
    sense : +1 if the face coordinate runs along the global y, else -1
    """
    figure = new_figure(4.8, max(8.0, 6.0 * len(patterns)))
    words = "grey: no contact" + ("; red outline: damage" if damaged.any() else "")
    figure.suptitle(f"{plain(title)}\ncontact pattern over a whole engagement, {load}\n{words}", fontsize=10, wrap=True)
    boxes = np.atleast_1d(figure.subplots(1, len(patterns), sharey=True))
    most = max(float(np.nanmax(one.pressure, initial=0.0)) for one in patterns) / 1e6 or 1.0
    plotted = None
    for number, (axes, one) in enumerate(zip(boxes, patterns, strict=True)):
        face, diameter = 1000 * sense * one.face, 1000 * one.diameter
        plotted = draw_pattern(axes, face, diameter, one.pressure / 1e6, most, 1000 * pitch_diameter)
        if number and damaged.any():
            axes.contour(face, diameter, damaged, levels=[0.05], colors=GONE, linewidths=2.2)
        if number and crack is not None:
            low, high = sorted(1000 * sense * end for end in crack)
            axes.plot([low, high], [diameter[0]] * 2, color=GONE, lw=5, clip_on=False, solid_capstyle="butt")
            axes.annotate("crack in the fillet below", ((low + high) / 2, diameter[0]), xytext=(0, 8), ha="center",
                          textcoords="offset points", fontsize=9, color=GONE, fontweight="bold")  # fmt: skip
        greatest = float(np.nanmax(one.pressure, initial=0.0)) / 1e6
        axes.set_title(f"{one.name}: greatest Hertz pressure {greatest:.0f} MPa", fontsize=10, loc="left")
        axes.set_xlabel("y along the face from mid face, mm")
    boxes[0].set_ylabel(f"diameter on the {gear}, mm (tip above)")
    if plotted is not None:
        figure.colorbar(plotted, ax=list(boxes), shrink=0.9, pad=0.01).set_label("Hertz pressure, MPa")
    return figure


def draw_pattern(
    axes: Axes, face: np.ndarray, diameter: np.ndarray, pressure: np.ndarray, most: float, pitch_diameter: float
) -> QuadMesh:
    """Draw the pressure on a flank.

    Parameters
    ----------
    axes : on which it is plotted
    face, diameter : (face,) and (diameter,), mm
    pressure, most : (diameter, face), and the end of the colour scale, MPa
    pitch_diameter : mm
    """
    plotted = axes.pcolormesh(
        face, diameter, pressure, cmap=LOAD_COLOURS, vmin=0.0, vmax=most, shading="gouraud", rasterized=True
    )
    axes.set_facecolor("#e8e8e8")
    axes.axhline(pitch_diameter, color="black", lw=0.9, ls=":")
    axes.set_xlim(face.min(), face.max())
    axes.annotate("pitch circle", (face.min(), pitch_diameter), xytext=(3, 3), textcoords="offset points", fontsize=8)
    return plotted
