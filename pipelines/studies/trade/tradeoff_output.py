"""A trade-off as a table, a work-precision diagram, and the fastest and most accurate choices as text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from pipelines.io.text_table import Grid, grid
from pipelines.studies.trade.tradeoff import Priced, Tradeoff
from pipelines.studies.trade.tradeoff_choices import PRESET

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {
    "preset": "#111111", "mesh law": "#c23b22", "casing": "#2a6f97", "shafts": "#3a7d44", "bearings": "#7b4ea3",
    "step": "#e08e0b", "integrator": "#b5651d", "output rate": "#6b6b6b", "combination": "#00897b",
}  # fmt: skip
COLUMNS = {"gears": "gears %", "casing": "casing Hz %", "machine": "machine Hz %", "signals": "sensor rms %"}
LEVELS = {"frf": "FRF dB", "lines": "lines dB"}


def trade_table(found: Tradeoff) -> Grid:
    """One row for each choice: seconds by group of steps, peak memory, largest errors; the Pareto front is marked."""
    marked = frozenset(n for n, one in enumerate(found.priced) if not one.dominated)
    title = f"{found.name}: cost and largest error of every choice against the reference"
    return grid(title, map(_row, found.priced), marked)


def _row(one: Priced) -> dict[str, object]:
    seconds = one.measured.seconds
    return {
        "choice": one.choice.name,
        "time s": one.seconds,
        "laws s": sum(s for name, s in seconds.items() if "law_" in name),
        "casing s": sum(s for name, s in seconds.items() if "casing" in name),
        "motion s": seconds.get("simulate", 0.0),
        "memory MB": f"{one.measured.peak_bytes / 1e6:.0f}",
        **{head: _percent(one.errors.get(probe)) for probe, head in COLUMNS.items()},
        **{head: f"{one.errors[probe]:.2g}" if probe in one.errors else "-" for probe, head in LEVELS.items()},
        "Pareto": "" if one.dominated else "front",
    }


def _percent(error: float | None) -> str:
    return "-" if error is None or math.isnan(error) else f"{100 * error:.2g}"


def answers(found: Tradeoff, error: float, seconds: float) -> list[str]:
    """Sentences: the fastest choice within an error, the most accurate one within a time, and refused choices."""
    fastest, exact = found.cheapest(error), found.most_accurate(seconds)
    lines = [
        f"Within {100 * error:g} % error of sensor rms the least expensive is {_words(fastest)}."
        if fastest
        else f"No choice has at most {100 * error:g} % error of sensor rms. Raise --error.",
        f"Within {seconds:g} s the most accurate is {_words(exact)}."
        if exact
        else f"No choice takes at most {seconds:g} s. Raise --time.",
    ]
    lines += [f"Reference: {found.known}"] if found.known else []
    return lines + [f"{name} is left out: {reason}" for name, reason in found.refused.items()]


def _words(one: Priced) -> str:
    return f'"{one.choice.name}" ({one.seconds:.3g} s, {_percent(one.error)} %)'


def trade_figure(found: Tradeoff) -> Figure:
    """Figure of the error of the sensor rms over computing time; circles mark the Pareto front."""
    from matplotlib.ticker import NullFormatter, ScalarFormatter

    from pipelines.report.figures.plots import dress, new_figure, plain

    shown = [one for one in found.priced if not math.isnan(one.error)]
    figure = new_figure(max(6.0, 0.2 * len(shown) + 1.5), 13.0)
    axes = figure.subplots()
    least = min((one.error for one in shown if one.error > 0.0), default=0.01) / 3
    places = {one.choice.name: (one.seconds, 100 * max(one.error, least)) for one in shown}
    for effect in dict.fromkeys(one.choice.effect for one in shown):
        x, y = zip(*(places[one.choice.name] for one in shown if one.choice.effect == effect), strict=True)
        axes.scatter(x, y, s=50 if effect == PRESET else 24, color=COLOURS[effect], label=effect, zorder=3)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(ScalarFormatter() if len(axes.get_xticks()) < 6 else NullFormatter())
    axes.yaxis.set_major_formatter(ScalarFormatter())
    front = [places[one.choice.name] for one in found.front]
    x, y = zip(*front, strict=True)
    axes.scatter(
        x, y, s=110, facecolors="none", edgecolors="black", linewidths=0.9, zorder=4,
        label="Pareto front: no choice is better in time, rms and fault lines",
    )  # fmt: skip
    axes.margins(x=0.12, y=0.06)
    dress(
        axes, f"{plain(found.name)}: computing time and error", "time of all steps without the cache, s",
        f"largest error of a sensor's rms against the reference, % (0 is shown at {100 * least:.2g})",
    )  # fmt: skip
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=6, frameon=False, fontsize=9)
    _label(axes, [(one, *places[one.choice.name]) for one in shown])
    return figure


def _label(axes: Axes, points: list[tuple[Priced, float, float]]) -> None:
    """Label the points: presets next to the point, all others in a column at the right with a line to the point."""
    aside = sorted((p for p in points if p[0].choice.effect != PRESET), key=lambda p: p[2])
    for one, x, y in points:
        if one.choice.effect == PRESET:
            axes.annotate(
                one.choice.label, (x, y), xytext=(-7, 3), textcoords="offset points", ha="right", fontsize=9, zorder=5
            )
    for number, (one, x, y) in enumerate(aside):
        colour = COLOURS[one.choice.effect]
        axes.annotate(
            f"{one.choice.name} ({one.seconds:.0f} s, {_percent(one.error)} %)", (x, y),
            xytext=(1.06, (number + 0.5) / len(aside)), textcoords="axes fraction", va="center", fontsize=8,
            color=colour, arrowprops={"arrowstyle": "-", "lw": 0.4, "color": colour, "relpos": (0.0, 0.5)},
        )  # fmt: skip
