"""Rendered pictures with labels: a gear pair with its stiffness curve, a casing with its key points."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipelines.report.figures.colours import FAULTY, POINTS, WEAR_COLOURS
from pipelines.report.figures.damaged_tooth import DrawnTooth
from pipelines.report.figures.plots import StiffnessPlot, draw_stiffness, fixed_figure, new_figure, plain
from pipelines.report.figures.render import AXES_PLACES, KINDS, kind_of
from pipelines.report.figures.views import Picture

AXES = ("x", "y", "z")
LABEL_HEIGHT = 34.0  # rows of the picture for a label


def gear_figure(
    picture: Picture,
    curve: StiffnessPlot | None,
    names: Mapping[str, str],
    title: str = "",
    near: Picture | None = None,
    tooth: DrawnTooth | None = None,
) -> Figure:
    """Gear pair in three dimensions, with its damaged tooth enlarged and its stiffness curve.

    Parameters
    ----------
    picture, curve : the rendered gears, and their curve or None
    names : labels for the places of the picture: "pinion", "wheel" and "marked" (the damaged tooth)
    title : above both, "" for none
    near, tooth : the enlarged damaged tooth, and its surface, or None
    """
    shown = 1 + (near is not None) + (curve is not None)
    height, width = 5.0, 6.25 * shown
    if title:  # of several lines, and perhaps a scale of wear: a layout engine makes room for them
        figure = new_figure(height, width, plain(title))
    else:
        figure = fixed_figure(height, width, columns=shown, left=0.05, across=0.85)
    left, *rest = np.atleast_1d(figure.subplots(1, shown, width_ratios=[1.05 if title else 0.95, *[1.0] * (shown - 1)]))
    if near is not None:
        _draw_tooth(rest.pop(0), near, tooth)
    if curve is not None:
        draw_stiffness(rest.pop(0), curve)
    box = show(left, picture)
    for place, name in names.items():
        if place not in picture.places:
            continue
        column, row = picture.places[place]
        marked = place == "marked"
        left.annotate(
            name,
            (column, row),
            xytext=_free_corner(box, column, row) if marked else (column, row),
            ha=("left" if column < (box[0] + box[1]) / 2 else "right") if marked else "center",
            va="center",
            fontsize=10,
            color=FAULTY if marked else "black",
            fontweight="bold" if marked else "normal",
            arrowprops={"arrowstyle": "-|>", "color": FAULTY, "shrinkB": 4} if marked else None,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5},
        )
    return figure


def _free_corner(box: tuple[float, float, float, float], column: float, row: float) -> tuple[float, float]:
    """Corner of the picture that is nearest to a pixel."""
    left, right, top, bottom = box
    across, down = 0.04 * (right - left), 0.03 * (bottom - top)
    return (
        left + across if column < (left + right) / 2 else right - across,
        top + down if row < (top + bottom) / 2 else bottom - down,
    )


def _draw_tooth(axes: Axes, near: Picture, tooth: DrawnTooth | None) -> None:
    """Damaged tooth with a description of its damage, and a scale of depth if it is worn."""
    _, right, _, bottom = show(axes, near, whole=True)
    draw_axes(axes, near, (0.09 * right, 0.88 * bottom))
    if tooth is None:
        return
    axes.set_title(textwrap.fill(tooth.words, 52), fontsize=11, color=FAULTY, fontweight="bold")
    if tooth.depth.any():
        scale = ScalarMappable(Normalize(0.0, 1e6 * float(tooth.depth.max())), cmap=WEAR_COLOURS)
        axes.figure.colorbar(scale, ax=axes, shrink=0.6, pad=0.01).set_label("depth of the missing material, µm")


def casing_figure(picture: Picture, title: str = "Casing and key points") -> Figure:
    """Casing with the names of all key points at the sides of the picture: yellow ground, red bearing, green sensor."""
    figure = fixed_figure(7.0, 11.5, title=plain(title), left=0.1, right=0.1, bottom=0.4)
    axes = figure.subplots()
    left, right, top, bottom = show(axes, picture)
    points = {name: place for name, place in picture.places.items() if name not in AXES_PLACES}
    middle = float(np.median([column for column, _ in points.values()])) if points else 0.0
    margin = 0.03 * (right - left)
    sides = (
        ([n for n, (column, _) in points.items() if column <= middle], left - margin, "right"),
        ([n for n, (column, _) in points.items() if column > middle], right + margin, "left"),
    )
    for chosen, place, alignment in sides:
        chosen.sort(key=lambda name: points[name][1])
        rows = spread([points[name][1] for name in chosen], LABEL_HEIGHT)
        for name, row in zip(chosen, rows, strict=True):
            colour = POINTS[kind_of(name)]
            axes.annotate(
                name,
                points[name],
                xytext=(place, row),
                ha=alignment,
                va="center",
                fontsize=9,
                annotation_clip=False,
                arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.9, "shrinkB": 3},
            )
    draw_axes(axes, picture, (right - 0.06 * (right - left), bottom))
    width = 0.16 * (right - left)
    axes.set(xlim=(left - width, right + width), ylim=(bottom + LABEL_HEIGHT, top - LABEL_HEIGHT))
    counts = {kind: sum(kind_of(name) == kind for name in points) for kind in KINDS}
    handles = [
        Line2D([], [], marker="o", ls="", color=POINTS[kind], label=f"{kind} points ({counts[kind]})") for kind in KINDS
    ]
    figure.legend(handles=handles, loc="lower center", ncols=3, frameon=False)
    return figure


def spread(places: Sequence[float], distance: float) -> np.ndarray:
    """Ascending positions nearest to the given ones, at a distance of at least `distance` (least squares, pooled
    blocks)."""
    from scipy.optimize import isotonic_regression

    steps = distance * np.arange(len(places))
    return isotonic_regression(np.array(places) - steps).x + steps


def show(axes: Axes, picture: Picture, *, whole: bool = False) -> tuple[float, float, float, float]:
    """Draw the picture, `whole` or without its white margin; left, right, top, bottom of the visible part, in
    pixels."""
    axes.imshow(picture.image, interpolation="bilinear")
    axes.set_axis_off()
    if whole:
        return 0.0, float(picture.image.shape[1]), 0.0, float(picture.image.shape[0])
    ink = np.any(picture.image < 250, axis=2)
    rows, columns = np.flatnonzero(ink.any(axis=1)), np.flatnonzero(ink.any(axis=0))
    if rows.size == 0:
        rows, columns = np.array([0, ink.shape[0] - 1]), np.array([0, ink.shape[1] - 1])
    border = 0.02 * float(columns[-1] - columns[0])
    box = (columns[0] - border, columns[-1] + border, rows[0] - border, rows[-1] + border)
    axes.set(xlim=box[:2], ylim=(box[3], box[2]))
    return box


def draw_axes(axes: Axes, picture: Picture, corner: tuple[float, float]) -> None:
    """Draw the global directions as arrows from a corner of the picture (column, row)."""
    origin = np.array(picture.places["origin"])
    for axis in AXES:
        arrow = np.array(picture.places[axis]) - origin
        tip, label = corner + arrow, corner + 1.2 * arrow
        style = {"arrowstyle": "-|>", "lw": 1.6, "color": "black", "shrinkA": 0}
        axes.annotate("", (tip[0], tip[1]), xytext=corner, arrowprops=style)
        axes.annotate(axis, (label[0], label[1]), ha="center", va="center", fontsize=11, fontweight="bold",
                      bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8})  # fmt: skip
