"""The trade as a table, a work-precision plot, and answers to "how cheap" and "how exact"."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from pipelines.grid import Grid
from pipelines.report_contents import grid
from pipelines.trade.tradeoff import Priced, Tradeoff

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {
    "preset": "#111111", "mesh law": "#c23b22", "casing": "#2a6f97", "shafts": "#3a7d44", "bearings": "#7b4ea3",
    "step": "#e08e0b", "integrator": "#b5651d", "output rate": "#6b6b6b", "together": "#00897b",
}  # fmt: skip
COLUMNS = {"gears": "gears %", "casing": "casing Hz %", "machine": "machine Hz %", "signals": "sensor rms %"}
LEVELS = {"frf": "FRF dB", "lines": "lines dB"}
LEAST = 1e-3  # per cent, errors below are drawn here


def trade_table(found: Tradeoff) -> Grid:
    """One row per choice: seconds by stage group, peak memory, largest errors; the front is set off."""
    rows = []
    for one in found.priced:
        seconds = one.measured.seconds
        row: dict[str, object] = {"what is chosen": one.choice.name, "s": one.seconds}
        row["laws s"] = sum(s for name, s in seconds.items() if name.startswith("law"))
        row["casing s"] = sum(s for name, s in seconds.items() if name.startswith("casing"))
        row["motion s"] = seconds.get("simulate", 0.0)
        row["MB"] = f"{one.measured.peak_bytes / 1e6:.0f}"
        row |= {head: _percent(one.errors.get(probe)) for probe, head in COLUMNS.items()}
        row |= {head: _level(one.decibels.get(probe)) for probe, head in LEVELS.items()}
        row["worth it"] = "" if one.dominated else "front"
        rows.append(row)
    table = grid(f"{found.name}: cost and largest error of every choice against the reference", rows)
    marked = frozenset(n for n, one in enumerate(found.priced) if not one.dominated)
    return Grid(title=table.title, headers=table.headers, rows=table.rows, marked=marked)


def _percent(error: float | None) -> str:
    return "-" if error is None or math.isnan(error) else f"{100 * error:.2g}"


def _level(decibels: float | None) -> str:
    return "-" if decibels is None else f"{decibels:.2g}"


def answers(found: Tradeoff, error: float, seconds: float) -> list[str]:
    """The cheapest choice within an error, the most accurate within a time, and what could not be chosen."""
    cheap, exact = found.cheapest(error), found.most_accurate(seconds)
    lines = [
        f"Within {100 * error:g} % of sensor rms the cheapest is {_words(cheap)}."
        if cheap
        else f"No choice stays within {100 * error:g} % of sensor rms.",
        f"Within {seconds:g} s the most accurate is {_words(exact)}." if exact else f"No choice takes {seconds:g} s.",
    ]
    return lines + [f"{name} is left out: {reason}" for name, reason in found.refused.items()]


def _words(one: Priced) -> str:
    return f"{one.choice.name} ({one.seconds:.3g} s, {_percent(one.error)} %)"


def trade_figure(found: Tradeoff) -> Figure:
    """Error of sensor rms over seconds, every choice with its label, and the front as a line."""
    from pipelines.plots import dress, new_figure

    figure = new_figure(7.5, 12.0)
    axes = figure.subplots()
    shown = [one for one in found.priced if not math.isnan(one.error)]
    places = {one.choice.name: (one.seconds, max(100 * one.error, LEAST)) for one in shown}
    for effect in dict.fromkeys(one.choice.effect for one in shown):
        group = [one for one in shown if one.choice.effect == effect]
        x, y = zip(*(places[one.choice.name] for one in group), strict=True)
        axes.scatter(x, y, s=46 if effect == "preset" else 24, color=COLOURS[effect], label=effect, zorder=3)
    axes.set_xscale("log")
    axes.set_yscale("log")
    front = [places[one.choice.name] for one in found.front]
    axes.plot(*zip(*front, strict=True), color="black", lw=0.9, ls="--", label="front: nothing is better in both")
    axes.margins(x=0.18, y=0.1)
    dress(
        axes, f"{found.name}: speed against accuracy", "time of all stages, cold, s",
        f"largest error of a sensor's rms against the reference, % (at least {LEAST:g})",
    )  # fmt: skip
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)
    _label(axes, [(one, *places[one.choice.name]) for one in shown])
    return figure


def _label(axes: Axes, points: list[tuple[Priced, float, float]]) -> None:
    """Write every label beside its point, moved up where it would cover one written before."""
    transform = axes.transData
    axes.figure.canvas.draw()
    taken: list[tuple[float, float, float]] = []
    for one, x, y in sorted(points, key=lambda p: (p[2], p[1])):
        left, level = transform.transform((x, y))
        width, place = 6.2 * len(one.choice.label), level
        while any(abs(place - t) < 11 and left < r and left + width > s for s, r, t in taken):
            place += 11
        taken.append((left, left + width, place))
        axes.annotate(
            one.choice.label, (x, y), xytext=(6, (place - level) * 0.72 - 3), textcoords="offset points", fontsize=8,
            color=COLOURS[one.choice.effect],
        )  # fmt: skip
