"""Figures of a comparison, a panel for each recording over the same axes. Every function returns the figure."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from pipelines.diagnosis.comparison.compared_features import Features
from pipelines.diagnosis.comparison.compared_recording import ComparedRecording
from pipelines.diagnosis.comparison.curves import RAHMONICS, Curves
from pipelines.report.figures.plots import FIRST, LETTER, MARK, SECOND, WIDTH, dress, fixed_figure, new_figure, plain
from pipelines.report.figures.spectrum_plots import DECADES
from pipelines.signals.orders.kinematics import Kinematics

MESH_ORDERS = 3  # of the fastest mesh, in the spectra
SIDEBANDS = 6  # on either side of a mesh order
ENVELOPE_ORDERS = 10.0  # least range of the envelope spectra
_NO_WIDTH = str.maketrans("", "", "${}_")  # characters of formulas that are not shown
_NAME = 0.09  # of the height of a panel: row of names
_ROWS = 3  # of names; more would shrink the curves by more than a third of the height
BEHIND = "#c9c9c9"  # the first recording, behind the others


def comparison_figures(
    found: Curves, features: Features, parts: Sequence[ComparedRecording], names: Sequence[str]
) -> dict[str, Figure]:
    """All figures of a comparison by name.

    Parameters
    ----------
    found, features, parts, names : curves, features and parts of the recordings, and their names in the figures
    """
    kinematics = parts[0].kinematics
    return {
        "orders": spectra_figure(found, names, kinematics),
        **{
            f"sidebands-{stage}": sidebands_figure(found, names, kinematics, stage)
            for stage, order in kinematics.mesh_orders().items()
            if order < found.orders[-1]
        },
        "envelope-orders": envelopes_figure(found, names, kinematics),
        "cepstrum": cepstra_figure(found, names, kinematics),
        "average": averages_figure(found, names),
        "rms": rms_figure(features.rms, features.tables[0].sensor, names),
    }


def sidebands_figure(found: Curves, names: Sequence[str], kinematics: Kinematics, stage: int) -> Figure:
    """Order spectra around the mesh order of a gear pair, with the sidebands of both shafts marked.

    Parameters
    ----------
    found, names, kinematics : as for `spectra_figure`
    stage : number of the pair
    """
    mesh = kinematics.mesh_orders()[stage]
    shafts = [kinematics.shaft(gear.shaft) for gear in kinematics.gears if gear.stage == stage]
    ratios = {shaft.name: shaft.ratio for shaft in shafts}
    reach = (SIDEBANDS + 0.5) * min(max(ratios.values()), 0.5 * mesh / (SIDEBANDS + 0.5))
    marks = {f"$f_{{m{stage}}}$": mesh}
    for name, ratio in sorted(ratios.items(), key=lambda one: -one[1]):
        sides = [k for k in range(-SIDEBANDS, SIDEBANDS + 1) if k and abs(k * ratio) <= reach]
        marks |= {f"{k:+d} {plain(name)}": mesh + k * ratio for k in sides}
    title = f"Order spectra at {' '.join(found.channel)} around the mesh order of stage {stage}, {_blocks(found)}"
    span = (mesh - reach, mesh + reach)
    return _spectra(found.orders, found.spectrum, names, title, "amplitude, m/s²", span, marks)


def spectra_figure(found: Curves, names: Sequence[str], kinematics: Kinematics) -> Figure:
    """Order spectra, with the mesh orders of the first recording's machine marked."""
    meshes = kinematics.mesh_orders()
    marks = {
        f"{'' if n == 1 else n} $f_{{m{stage}}}$": n * order
        for stage, order in meshes.items()
        for n in range(1, MESH_ORDERS + 1)
    }
    top = min(float(found.orders[-1]), (MESH_ORDERS + 0.4) * max(meshes.values(), default=found.orders[-1]))
    title = f"Order spectra at {' '.join(found.channel)}, {_blocks(found)}"
    return _spectra(found.orders, found.spectrum, names, title, "amplitude, m/s²", (0.0, top), marks)


def envelopes_figure(found: Curves, names: Sequence[str], kinematics: Kinematics) -> Figure:
    """Order spectra of the squared envelope, with the orders of the shafts and of the bearings marked."""
    marks = {plain(shaft.name): shaft.ratio for shaft in kinematics.shafts}
    bearings: dict[tuple[str, float], list[str]] = {}  # by part and order
    for bearing in kinematics.bearings:
        for strike, order in bearing.strikes.items():
            place = strike.removeprefix(bearing.name), order * kinematics.shaft(bearing.shaft).ratio
            bearings.setdefault(place, []).append(bearing.name)
    passes = {plain(", ".join(names) + part): order for (part, order), names in bearings.items()}
    top = min(float(found.orders[-1]), max(ENVELOPE_ORDERS, 2.2 * max(passes.values(), default=0.0)))
    low, high = found.band
    title = (
        f"Envelope order spectra at {' '.join(found.channel)}, of the orders {low:.4g} to {high:.4g}, {_blocks(found)}"
    )
    return _spectra(found.orders, found.envelope, names, title, "share of the mean", (0.0, top), marks | passes)


def cepstra_figure(found: Curves, names: Sequence[str], kinematics: Kinematics) -> Figure:
    """Real cepstra from half a turn of the fastest shaft on, with the rahmonics of the shafts marked and summed."""
    title = plain(f"Real cepstra at {' '.join(found.channel)}, {_blocks(found)}")
    figure = fixed_figure(1.2 + 1.7 * len(names), title=title, rows=len(names), down=0.45)
    ratios = {shaft.name: shaft.ratio for shaft in kinematics.shafts}
    end = min(float(found.quefrency[-1]), (RAHMONICS + 0.5) / min(ratios.values()))
    span = (0.5 / max(ratios.values()), end)
    marks = {
        f"{'' if n == 1 else n} {plain(name)}".strip(): n / ratio
        for name, ratio in ratios.items()
        for n in range(1, RAHMONICS + 1)
    }
    sums = {name: found.rahmonics(ratio) for name, ratio in ratios.items()}
    titles = []
    for number, name in enumerate(names):
        known = ", ".join(f"{shaft} {own[number]:.2f}" for shaft, own in sums.items() if np.isfinite(own[number]))
        titles.append(f"{name}; sum of {RAHMONICS} rahmonics: {known}" if known else name)
    shown = (found.quefrency > span[0]) & (found.quefrency <= end)
    labels = "quefrency, turns of the first shaft", "cepstrum"
    _panels(figure, titles, found.quefrency[shown], found.cepstrum[:, shown], span, labels, marks)
    return figure


def averages_figure(found: Curves, names: Sequence[str]) -> Figure:
    """Time-synchronous averages over a turn of the shaft."""
    title = plain(f"Time-synchronous averages at {' '.join(found.channel)}, mean over the turns")
    figure = new_figure(0.9 + 1.7 * len(names), title=title)
    angle = np.arange(found.average.shape[1]) * 360.0 / found.average.shape[1]
    titles = [name + ", shifted to match A" * bool(turned) for name, turned in zip(names, found.turned, strict=True)]
    _panels(figure, titles, angle, found.average, (0.0, 360.0), (f"angle of {found.shaft}, °", "m/s²"))
    return figure


def rms_figure(rms: np.ndarray, sensors: Sequence[str], names: Sequence[str]) -> Figure:
    """Bar chart of the RMS values (recording, channel), a group for each sensor: the root of the sum over its axes.

    Parameters
    ----------
    rms : m/s2
    sensors : of the channels
    names : of the recordings
    """
    known = list(dict.fromkeys(sensors))
    sums = np.array(
        [[np.sqrt(sum(row[i] ** 2 for i, s in enumerate(sensors) if s == one)) for one in known] for row in rms]
    )
    figure = new_figure(3.4 + 0.2 * len(names))
    axes = figure.subplots()
    width = 0.8 / len(names)
    for number, (name, row) in enumerate(zip(names, sums, strict=True)):
        axes.bar(np.arange(len(known)) + (number + 0.5) * width - 0.4, row, width, label=plain(name))
    axes.set_xticks(range(len(known)), [plain(one) for one in known], rotation=0 if len(known) < 10 else 90)
    dress(axes, "RMS of each sensor in its windows, root sum square of the common axes", "", "m/s²")
    figure.legend(loc="outside lower left", ncols=1, frameon=False, fontsize=9)
    return figure


def _spectra(
    orders: np.ndarray,
    rows: np.ndarray,
    names: Sequence[str],
    title: str,
    unit: str,
    span: tuple[float, float],
    marks: Mapping[str, float],
) -> Figure:
    """Logarithmic panels, whose curves are below the names of the marks."""
    figure = new_figure(0.9 + 1.7 * len(names), title=plain(title))
    shown = (orders > span[0]) & (orders <= span[1])
    labels = "order of the first shaft", unit
    panels, lines = _panels(figure, names, orders[shown], rows[:, shown], span, labels, marks)
    high = 2.0 * float(rows[:, shown].max())
    low = max(0.5 * float(rows[:, shown].min()), high / 10**DECADES)
    share = 1.0 - _NAME * lines  # of the height for the curves, below the names
    panels[0].set_yscale("log")
    panels[0].set_ylim(low, low * (high / low) ** (1.0 / share))
    for axes in panels:
        axes.yaxis.set_minor_locator(NullLocator())  # minor ticks of a logarithmic axis take half the time of a figure
    return figure


def _panels(
    figure: Figure,
    titles: Sequence[str],
    places: np.ndarray,
    rows: np.ndarray,
    span: tuple[float, float],
    labels: tuple[str, str],
    marks: Mapping[str, float] | None = None,
) -> tuple[Sequence[Axes], int]:
    """A panel for each recording with the first one behind; the first panel has the names of the marks, in rows.

    Returns the panels and the number of these rows.
    """
    panels = figure.subplots(len(titles), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    lines = 0
    inside = {label: place for label, place in (marks or {}).items() if place <= span[1]}
    for number, (axes, title, row) in enumerate(zip(panels, titles, rows, strict=True)):
        if number:
            axes.plot(places, rows[0], color=BEHIND, lw=0.9)
        axes.plot(places, row, color=SECOND if number else FIRST, lw=0.8)
        lines = max(lines, _mark(axes, inside, span, named=not number))
        dress(axes, plain(title), labels[0] if number == len(titles) - 1 else "", labels[1])
    panels[0].set_xlim(*span)
    return list(panels), lines


def _mark(axes: Axes, marks: Mapping[str, float], span: tuple[float, float], *, named: bool) -> int:
    """Dashed lines; names of lines that are close are in rows below each other. Returns the number of rows.

    Names without a free row are below the figure, with their places.
    """
    letter = LETTER / WIDTH * (span[1] - span[0])
    ends: list[float] = []  # of the last name in each row
    below = []
    for label, order in sorted(marks.items(), key=lambda one: one[1]):
        axes.axvline(order, color=MARK, lw=0.6, ls=(0, (4, 3)), zorder=0)
        if named:
            row = next((n for n, end in enumerate(ends) if end <= order), len(ends))
            if row == _ROWS:
                below.append(f"{label}: {order:.4g}")
                continue
            ends[row : row + 1] = [order + letter * len(label.translate(_NO_WIDTH))]
            axes.annotate(
                label, (order, 1.0), xycoords=("data", "axes fraction"), xytext=(2, -2 - 10 * row),
                textcoords="offset points", ha="left", va="top", fontsize=8, color=MARK,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
            )  # fmt: skip
    if below:
        axes.figure.supxlabel(textwrap.fill(f"Also marked: {', '.join(below)}", 150), fontsize=8, color=MARK)
    return len(ends)


def _blocks(found: Curves) -> str:
    return f"blocks of {found.turns} turn{'' if found.turns == 1 else 's'}"
