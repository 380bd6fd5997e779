"""A study of detectability as text, as a table of plain values, and as a figure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.diagnosis.verdict import ALARM
from pipelines.io.shown_text import number_of
from pipelines.io.text_table import Grid, grid
from pipelines.signals.features.definitions import BY_NAME
from pipelines.studies.detect.detection_study import Detectability, DetectionPoint
from pipelines.studies.detect.probability import Detection, Share

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOSTLY = 0.9  # of the damaged machines: a size that is found reliably


def text(found: Detectability) -> str:
    """All of it for the terminal and for detectability.txt."""
    parts = [
        headline(found),
        conditions(found),
        probability_grid(found).to_text(),
        false_alarm_grid(found).to_text(),
        channel_grid(found).to_text(),
    ]
    return "\n\n".join(parts) + "\n"


def headline(found: Detectability) -> str:
    """What is found, noise by noise, in one sentence each."""
    return " ".join(_answer(found, noise) for noise in found.noises)


def _answer(study: Detectability, noise: float) -> str:
    own = [point for point in study.points if point.noise == noise]
    seen = [point for point in own if point.detection.detected.value >= MOSTLY]
    where = f"With {noise:g} m/s2 of noise"
    if len(own) == 1:
        return f"{where}, {words(own[0].detection.detected)} are detected."
    if not seen:
        most = max(own, key=lambda point: point.detection.detected.value)
        share = words(most.detection.detected)
        mostly = f"{100 * MOSTLY:g} % of the machines with all channels"
        return f"{where}, no value is detected in {mostly}; the most is {share}."
    found = ", ".join(f"{_values(point.values)}: {words(point.detection.detected)}" for point in seen)
    return f"{where}, {100 * MOSTLY:g} % of the simulated machines or more are detected at {found}."


def conditions(found: Detectability) -> str:
    """What was damaged, what it was compared with, and what an alarm is."""
    design = found.design
    return (
        f"Damage: {found.damage}; the number of the tooth increases by one from machine to machine. {design.damaged} "
        f"damaged machines per value are compared with a baseline of {design.baseline} healthy ones; {design.healthy} "
        "further healthy machines are tested for false alarms. No two machines have the same deviations. A machine is "
        f"called damaged if its p-value, corrected for the number of components and channels, is at most {ALARM:g}. So "
        "one channel alone can detect more than all together. Intervals have 95 % confidence."
    )


def probability_grid(found: Detectability) -> Grid:
    """A row per value and noise."""
    keys = [over.key.rpartition(".")[2] for over in found.design.over]
    headers = (*keys, "noise m/s2", "detected", "above all healthy", "shaft ranks first", "tooth within one")
    return Grid(title="Probability of detection", headers=headers, rows=tuple(map(_cells, found.points)))


def _cells(point: DetectionPoint) -> tuple[str, ...]:
    one = point.detection
    shares = (one.detected, one.above_healthy, one.shaft_first, one.tooth_found)
    return (*map(str, point.values.values()), f"{point.noise:g}", *("-" if s is None else words(s) for s in shares))


def false_alarm_grid(found: Detectability) -> Grid:
    """A row per noise, and per value that healthy machines have, too."""
    rows: dict[tuple[str, str], Detection] = {}
    for point in found.points:
        shared = {key: value for key, value in point.values.items() if key in found.shared}
        rows.setdefault((_values(shared) or "all", f"{point.noise:g}"), point.detection)
    return Grid(
        title="False alarms of healthy machines, against this baseline and against as many other healthy machines",
        headers=("machines", "noise m/s2", "this baseline", "other baselines"),
        rows=tuple((*names, words(one.false_alarms), words(one.other_baselines)) for names, one in rows.items()),
    )


def channel_grid(found: Detectability) -> Grid:
    """A row per sensor and axis alone, the best first."""
    rows = [
        {
            "rank": rank,
            "sensor": one.sensor,
            "axis": one.axis,
            "d'": f"{one.index:.1f}",
            "by": f"{one.component} {BY_NAME[one.feature].words}",
            "detected": words(one.detected),
        }
        for rank, one in enumerate(found.channels, 1)
    ]
    return grid(f"Each channel alone, over all values, with {found.noises[0]:g} m/s2 of noise", rows)


def words(one: Share) -> str:
    """ "9 of 10 (55 to 100 %)"."""
    low, high = one.interval
    return f"{one.count} of {one.trials} ({_percent(low)} to {_percent(high)} %)"


def _percent(value: float) -> str:
    return f"{100 * value:.2g}" if value < 0.995 else "100"


def plain(found: Detectability) -> dict[str, Any]:
    """All of it as detectability.json holds it."""
    return {
        "name": found.name,
        "damage": found.damage,
        "alarm_p": ALARM,
        "baseline": found.design.baseline,
        "points": [
            {"values": dict(point.values), "noise_m_s2": point.noise}
            | {name: _share(value) for name, value in vars(point.detection).items()}
            for point in found.points
        ],
        "channels": [
            {**vars(one), "rank": rank, "detected": _share(one.detected)} for rank, one in enumerate(found.channels, 1)
        ],
    }


def _share(one: Share | None) -> dict[str, Any] | None:
    return None if one is None else {"count": one.count, "trials": one.trials, "interval": list(one.interval)}


def figure(found: Detectability) -> Figure:
    """Probability of detection with its intervals over the first key that is varied; a line per noise and the rest."""
    from pipelines.report.figures.plots import dress, new_figure
    from pipelines.report.figures.plots import plain as plain_words

    made = new_figure(4.5)
    axes = made.subplots()
    lines: dict[tuple[float, str], list[DetectionPoint]] = {}
    for point in found.points:
        rest = _values(dict(list(point.values.items())[1:]))
        lines.setdefault((point.noise, rest), []).append(point)
    steps = list(dict.fromkeys(str(next(iter(point.values.values()), "")) for point in found.points))
    numbers = [number_of(step) for step in steps]
    even = any(math.isnan(number) for number in numbers)
    width = len(steps) - 1 if even else max(numbers) - min(numbers)
    for number, ((noise, rest), points) in enumerate(lines.items()):
        at = [str(next(iter(point.values.values()), "")) for point in points]
        aside = 0.006 * number * width  # so that bars of equal values do not hide one another
        places = [aside + (steps.index(one) if even else number_of(one)) for one in at]
        shares = (point.detection.detected for point in points)
        values, low, high = 100 * np.array([(one.value, *one.interval) for one in shares]).T
        label = ", ".join(filter(None, (f"noise {noise:g} m/s²", rest)))
        axes.errorbar(
            places,
            values,
            yerr=(values - low, high - values),
            marker="o",
            ms=4,
            lw=1.2,
            capsize=3,
            label=plain_words(label),
        )
    if even:
        axes.set_xticks(range(len(steps)), labels=[plain_words(step) for step in steps])
    axes.set_ylim(-3, 103)
    key = found.design.over[0].key if found.design.over else ""
    dress(axes, plain_words(f"{found.damage}: alarms with 95 % confidence intervals"), plain_words(key), "detected, %")
    axes.legend(frameon=False, fontsize=9)
    return made


def _values(values: Mapping[str, Any]) -> str:
    """ "depth_mm 0.5, torque_N_m 50"."""
    return ", ".join(f"{key.rpartition('.')[2]} {value}" for key, value in values.items())
