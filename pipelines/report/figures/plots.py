"""Figures of stiffness, transmission error, speeds and signals.

Every function returns the figure; the caller shows or saves it.
Figures use matplotlib's object interface: no display, no global state, no change of the global style.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from fem.contact.evaluation.mesh_cycle import ORDERS, order_amplitudes
from pipelines.report.figures.colours import FAULTY, HEALTHY
from pipelines.signals.analysis import channel

FIRST, SECOND = "#2a6f97", "#e08e0b"
MARK, GRID = "#6b6b6b", "#dddddd"
WIDTH = 10.0  # inches
LETTER = 0.085  # inches, mean width of a letter of 10 points
HEADLINE = 0.3  # inches, height of a title of the whole figure
LABEL_BELOW, LABEL_LEFT = 0.29, 0.62  # inches from the axes to their labels, with room for the numbers
RPM = 30 / np.pi
_LISTED = 5  # of the mesh frequency, in tables


@dataclass(frozen=True, eq=False, kw_only=True)
class StiffnessPlot:
    """Stiffness while a damaged tooth passes: cycle (mesh cycles), k in N/m; `faulty` with the fault `label`, or
    None."""

    title: str
    cycle: np.ndarray
    healthy: np.ndarray
    faulty: np.ndarray | None = None
    label: str = ""


def new_figure(height: float, width: float = WIDTH, title: str = "") -> Figure:
    """Empty figure (inches) with automatic layout and a title, "" for none."""
    figure = Figure(figsize=(width, height), layout="constrained")
    if title:
        figure.suptitle(title)
    return figure


def fixed_figure(
    height: float,
    width: float = WIDTH,
    *,
    title: str = "",
    rows: int = 1,
    columns: int = 1,
    left: float = 0.85,
    right: float = 0.15,
    bottom: float = 0.54,
    down: float = 0.84,
    across: float = 0.6,
) -> Figure:
    """Empty figure with fixed margins, for a report: an automatic layout takes longer than the drawing.

    Parameters
    ----------
    height, width : of the figure, inches
    title : of the whole figure, "" for none
    rows, columns : number of panels
    left, right, bottom : margins, inches; the top margin contains the titles
    down, across : distances between panels, inches
    """
    top = 0.34 + (HEADLINE if title else 0.0)
    inside = width - left - right, height - bottom - top
    panel = (inside[0] - (columns - 1) * across) / columns, (inside[1] - (rows - 1) * down) / rows
    figure = Figure(figsize=(width, height))
    figure.subplots_adjust(
        left=left / width,
        right=1.0 - right / width,
        bottom=bottom / height,
        top=1.0 - top / height,
        wspace=across / panel[0],
        hspace=down / panel[1],
    )
    if title:
        figure.suptitle(title, y=1.0 - 0.08 / height)
    return figure


def stiffness_figure(curves: Sequence[StiffnessPlot]) -> Figure:
    """Stiffness curves, one panel per gear stage, healthy and with the faults."""
    title = "Mesh stiffness along the transverse line of action"
    figure = fixed_figure(2.0 + 1.9 * len(curves), title=title, rows=len(curves))
    for curve, axes in zip(curves, np.atleast_1d(figure.subplots(len(curves), 1)), strict=True):
        draw_stiffness(axes, curve)
    return figure


def draw_stiffness(axes: Axes, curve: StiffnessPlot) -> None:
    """Draw one stiffness curve, in N/µm over the mesh cycle."""
    axes.plot(curve.cycle, curve.healthy / 1e6, color=HEALTHY, label="healthy")
    if curve.faulty is not None:
        axes.plot(curve.cycle, curve.faulty / 1e6, color=FAULTY, label=curve.label)
    axes.set_ylim(0, None)
    axes.margins(x=0)
    dress(axes, curve.title, "mesh cycle", "stiffness, N/µm")
    legend(axes)


def drive_figure(run: xarray.Dataset, windows: Mapping[str, tuple[float, float]]) -> Figure:
    """Speeds of the motors and the input shaft, and the force of a rope; windows are shaded."""
    motors: tuple[tuple[str, dict[str, Any]], ...] = (
        ("motor 1", {"lw": 3.2, "alpha": 0.45, "color": FIRST}),
        ("motor 2", {"ls": "--", "color": SECOND}),
    )
    has_rope = "rope_force" in run
    figure = fixed_figure(5.6 if has_rope else 3.2, rows=1 + has_rope, down=0.45)
    panels = np.atleast_1d(figure.subplots(1 + has_rope, 1, sharex=True))
    time = run.time.values
    speeds = run.motor_speed.transpose("motor", "time").values if "motor_speed" in run else ()
    for (name, style), speed in zip(motors, speeds, strict=False):
        panels[0].plot(time, speed * RPM, label=name, **style)
    if "shaft_speed" in run:
        panels[0].plot(time, run.shaft_speed.isel(shaft=0).values * RPM, label="input shaft", color="black", lw=0.8)
    dress(panels[0], "Speed of motors and input shaft", "" if has_rope else "time, s", "speed, rpm")
    if has_rope:
        panels[1].plot(time, run.rope_force.values / 1e3, color=FIRST, lw=0.9)
        dress(panels[1], "Rope force", "time, s", "force, kN")
    for panel in panels:
        panel.margins(x=0, y=0.16)
        _shade(panel, windows)
    legend(panels[0])
    return figure


def waveform_figure(
    runs: Mapping[str, xarray.Dataset], sensor: str, axis: str, windows: Mapping[str, tuple[float, float]]
) -> Figure:
    """Acceleration over the whole run and, in a second panel, a tenth of a second from the middle of the first window.

    Parameters
    ----------
    runs : responses by the name of their state
    sensor, axis : the channel, e.g. "sensor_3", "z"
    windows : (start, end) by name, s
    """
    figure = fixed_figure(1.0 + 1.9 * len(runs), rows=len(runs), columns=2, down=0.45)
    grid = figure.subplots(len(runs), 2, sharex="col", sharey="col", squeeze=False, width_ratios=[3, 2])
    middle = float(np.mean(next(iter(windows.values())))) if windows else None
    for (name, run), (whole, detail) in zip(runs.items(), grid, strict=True):
        time, signal = run.time.values, channel(run, sensor).sel(axis=axis).values
        colour = HEALTHY if name.startswith("healthy") else FAULTY
        start = time[-1] / 2 if middle is None else middle
        near = (time >= start) & (time <= start + 0.1)
        whole.plot(time, signal, color=colour, lw=0.4)
        detail.plot(time[near], signal[near], color=colour, lw=0.9)
        last = name == list(runs)[-1]
        dress(whole, f"{sensor} {axis}, {name}", "time, s" if last else "", "acceleration, m/s²")
        dress(detail, f"0.1 s from {start:.3g} s, {name}", "time, s" if last else "", "")
        whole.margins(x=0, y=0.16)
        _shade(whole, windows)
        detail.margins(x=0)
    return figure


def legend(axes: Axes, letters: float = 9.0) -> None:
    """Legend at the right of the title, where it hides no curve; `letters` in points."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, 0.99), ncols=5, frameon=False, fontsize=letters, borderaxespad=0.1
    )


def _shade(axes: Axes, windows: Mapping[str, tuple[float, float]]) -> None:
    for name, (start, end) in windows.items():
        axes.axvspan(start, end, color="black", alpha=0.05, lw=0)
        axes.annotate(
            plain(name),
            ((start + end) / 2, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, -3),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=8,
            color=MARK,
        )


def plain(text: str) -> str:
    """A user's text for a figure, with $ escaped: matplotlib would show the text between two of them as a formula."""
    return text.replace("$", r"\$")


def plain_symbols(name: str) -> str:
    """A label such as "2 f_r" with its subscript, all else unchanged."""
    return plain(name).replace("f_r", "fᵣ").replace("f_m", "fₘ")


def dress(axes: Axes, title: str, x: str, y: str, *, letters: float = 10.0) -> None:
    """Add title, labels and grid.

    Parameters
    ----------
    axes : the axes
    title, x, y : texts, those of the axes with their units
    letters : size of all texts, points
    """
    axes.set_title(title, fontsize=letters, loc="left", y=1.0)
    axes.set_xlabel(x, fontsize=letters)
    axes.set_ylabel(y, fontsize=letters)
    axes.tick_params(labelsize=letters)
    figure = axes.get_figure()
    if figure is not None and figure.get_layout_engine() is None:  # fixed places: else matplotlib measures all numbers
        below = axes.transAxes + ScaledTranslation(0.0, -LABEL_BELOW, figure.dpi_scale_trans)
        left = axes.transAxes + ScaledTranslation(-LABEL_LEFT, 0.0, figure.dpi_scale_trans)
        axes.xaxis.set_label_coords(0.5, 0.0, below)
        axes.yaxis.set_label_coords(0.0, 0.5, left)
    axes.grid(visible=True, color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


@dataclass(frozen=True, eq=False, kw_only=True)
class TransmissionErrors:
    """Transmission error of one pair at one load, without deviations.

    `unmodified` is None for flanks without modifications. `passages` are empty without tooth faults.
    """

    stage: int  # from 1
    title: str
    torque: float  # N m, on the pinion
    cycle: np.ndarray  # (position,), mesh cycles over one of them
    unmodified: np.ndarray | None  # (position,), m
    actual: np.ndarray  # (position,), m
    place: np.ndarray  # (place,), mesh cycles from contact of a damaged tooth at the pitch point
    passages: Mapping[str, np.ndarray]  # "healthy", and each damaged tooth -> (place,), m

    @property
    def states(self) -> dict[str, np.ndarray]:
        """Curves by state of the flanks, "unmodified" first."""
        if self.unmodified is None:
            return {"unmodified": self.actual}
        return {"unmodified": self.unmodified, "modified": self.actual}

    def rows(self) -> list[dict[str, Any]]:
        """The first orders of every state, um."""
        return [
            {
                "stage": self.stage,
                "torque N m": self.torque,
                "flanks": state,
                **{f"order {k} um": 1e6 * float(size) for k, size in enumerate(order_amplitudes(error)[:_LISTED], 1)},
            }
            for state, error in self.states.items()
        ]


def transmission_error_figure(title: str, errors: Sequence[TransmissionErrors]) -> Figure:
    """A row for each stage: the curves less their means on the left, the orders on the right; a colour for each torque.

    Below a stage with damaged teeth: the curves while each of them passes.
    """
    from matplotlib import colormaps

    stages = list(dict.fromkeys(error.stage for error in errors))
    faulty = {error.stage for error in errors if error.passages}
    entries = max(sum(len(error.states) for error in errors if error.stage == stage) for stage in stages)
    height = 0.7 + (3.6 + 0.1 * max(0, entries - 6)) * (len(stages) + len(faulty))
    figure = new_figure(height, 11.0, f"{plain(title)}\ntransmission error without deviations")
    grid, row = figure.add_gridspec(len(stages) + len(faulty), 2, width_ratios=[1.2, 1.0]), 0
    for stage in stages:
        curves, lines = (figure.add_subplot(grid[row, column]) for column in (0, 1))
        row += 1
        own = [error for error in errors if error.stage == stage]
        colours = colormaps["viridis"](np.linspace(0.0, 0.8, len(own)))
        count = sum(len(error.states) for error in own)
        place = 0
        for error, colour in zip(own, colours, strict=True):
            for state, values in error.states.items():
                before = state == "unmodified" and error.unmodified is not None
                label = f"{error.torque:.4g} N m" + (f", {state}" if error.unmodified is not None else "")
                label += f", mean {1e6 * values.mean():.3g} µm"
                varying = 1e6 * (values - values.mean())
                curves.plot(error.cycle, varying, color=colour, ls="--" if before else "-", label=label)
                at = np.arange(1, ORDERS + 1) + 0.8 * ((place + 0.5) / count - 0.5)
                lines.bar(at, 1e6 * order_amplitudes(values), 0.8 / count, facecolor="none" if before else colour,
                          edgecolor=colour, lw=0.8)  # fmt: skip
                place += 1
        curves.margins(x=0)
        dress(curves, f"healthy pair of {own[0].title}", "mesh cycle", "transmission error less its mean, µm")
        dress(lines, "orders of the mesh frequency", "order", "amplitude, µm")
        lines.set_xticks(range(1, ORDERS + 1))
        curves.legend(
            fontsize=8, ncols=1 if count < 3 else 2, loc="upper left", bbox_to_anchor=(0.0, -0.18), frameon=False
        )
        if stage in faulty:
            _draw_passages(figure.add_subplot(grid[row, :]), own, colours)
            row += 1
    return figure


def _draw_passages(axes: Axes, errors: Sequence[TransmissionErrors], colours: np.ndarray) -> None:
    """The healthy pair, and each damaged tooth while it passes: a colour for each torque, a style for each state."""
    styles = ("--", "-", "-.", ":")
    for error, colour in zip(errors, colours, strict=True):
        for number, (state, values) in enumerate(error.passages.items()):
            style = styles[0] if number == 0 else styles[1 + (number - 1) % (len(styles) - 1)]
            axes.plot(
                error.place, 1e6 * values, color=colour, ls=style, label=f"{error.torque:.4g} N m, {plain(state)}"
            )
    axes.margins(x=0)
    dress(
        axes,
        f"while a damaged tooth passes, {errors[0].title}",
        "mesh cycles from contact of the damaged tooth at the pitch point",
        "transmission error, µm",
    )
    axes.legend(fontsize=8, ncols=2, loc="upper left", bbox_to_anchor=(0.0, -0.16), frameon=False)
