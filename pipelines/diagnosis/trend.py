"""Trend over recordings of one machine: the evidence of its components and the levels of its channels, with limits.

Evidence is divided by its limit (`pipelines.diagnosis.verdict`). Without healthy recordings it is the level of impacts
of a bearing part. The levels are the rms of acceleration and velocity. At most DIFFERENT of healthy machines exceed
any of their limits; as for features, they follow from the scatter of the healthy levels in dB.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_P, LEAST_SPREAD, limit, moderated
from pipelines.diagnosis.impacts import CLEAR, Impacts
from pipelines.diagnosis.verdict import DIFFERENT, Verdict
from pipelines.diagnosis.verdict_words import STRENGTH
from pipelines.io.text_table import Grid, grid
from pipelines.signals.levels import ChannelLevel

_LEVELS = (("acceleration", "m/s²", 1.0), ("velocity", "mm/s", 1000.0))  # name, unit, factor from SI
LEVELS = {"m/s²": "Acceleration, m/s²", "mm/s": "Velocity from 10 to 1000 Hz (ISO 20816-1), mm/s"}  # by unit


@dataclass(frozen=True, eq=False, kw_only=True)
class Course:
    """A quantity of a component or channel over recordings: `values` (recording,), NaN where a recording lacks it.

    `above` (recording,) marks values that reach the `limit`. `healthy` is the range of the healthy recordings. Limit
    and range are None if the healthy recordings are too few.
    """

    name: str
    unit: str
    values: np.ndarray
    above: np.ndarray
    limit: float | None
    healthy: tuple[float, float] | None

    @property
    def first(self) -> int | None:
        """Number, from 1, of the first recording that reaches the limit; None if none does."""
        return int(self.above.argmax()) + 1 if self.above.any() else None


def evidence_courses(verdicts: Sequence[Verdict]) -> list[Course]:
    """The evidence of each component over its limit; its increase (dB) if the healthy recordings are too few."""
    known = verdicts[-1].damaged is not None
    found = [{one.component: one for one in verdict.findings} for verdict in verdicts]
    courses = []
    for name in dict.fromkeys(name for findings in reversed(found) for name in findings):
        own = [findings.get(name) for findings in found]
        values = [math.nan if one is None else one.evidence.ratio for one in own]
        ranges = [one.healthy for one in own if one is not None]
        above = np.array([one is not None and bool(one.damaged) for one in own])
        unit, bound = (STRENGTH, 1.0) if known else ("increase dB", None)
        courses.append(
            Course(name=name, unit=unit, values=np.array(values), above=above, limit=bound, healthy=ranges[-1])
        )
    return courses


def impact_courses(found: Sequence[Sequence[Impacts]]) -> list[Course]:
    """The levels of impacts at the pass orders of each recording, without healthy recordings."""
    levels = [{one.component: one.level for one in impacts} for impacts in found]
    names = dict.fromkeys(name for own in reversed(levels) for name in own)
    courses = {name: np.array([own.get(name, math.nan) for own in levels]) for name in names}
    return [
        Course(name=name, unit="impacts dB", values=values, above=values >= CLEAR, limit=CLEAR, healthy=None)
        for name, values in courses.items()
    ]


def level_courses(levels: Sequence[Sequence[ChannelLevel]], healthy: Sequence[Sequence[ChannelLevel]]) -> list[Course]:
    """The levels of each channel that all recordings have.

    Parameters
    ----------
    levels, healthy : of each recording, and of each healthy one
    """
    own, others = ([_by_channel(one) for one in group] for group in (levels, healthy))
    if not (common := [one for one in own[0] if all(one in other for other in (*own, *others))]):
        return []
    values, reference = (np.array([[one[channel] for channel in common] for one in group]) for group in (own, others))
    limits = _limits(reference) if len(others) >= FEWEST_FOR_P else np.full(values.shape[1:], math.nan)
    courses = []
    for kind, (name, unit, factor) in enumerate(_LEVELS):
        for number, channel in enumerate(common):
            course, bound = factor * values[:, number, kind], factor * float(limits[number, kind])
            scatter = factor * reference[:, number, kind] if others else np.empty(0)
            courses.append(
                Course(
                    name=f"{name} {' '.join(channel)}",
                    unit=unit,
                    values=course,
                    above=course >= bound,
                    limit=None if math.isnan(bound) else bound,
                    healthy=(float(scatter.min()), float(scatter.max())) if len(scatter) >= FEWEST_FOR_P else None,
                )
            )
    return courses


def trend_grid(courses: Sequence[Course]) -> Grid:
    """Table with a row for each course and a column for each recording by its number."""
    rows = [
        {
            "component or channel": one.name,
            "unit": one.unit,
            "healthy": "-" if one.healthy is None else " to ".join(_cell(end, one.unit) for end in one.healthy),
            "limit": "-" if one.limit is None else _cell(one.limit, one.unit),
            "first above": one.first or "-",
            **{str(n): "-" if math.isnan(value) else _cell(value, one.unit) for n, value in enumerate(one.values, 1)},
        }
        for one in courses
    ]
    return grid("Trend over the recordings 1, 2, ...", rows)


def trend_facts(courses: Sequence[Course], names: Sequence[str]) -> list[Mapping[str, Any]]:
    """The courses for a program; `first_above` is the name of a recording."""
    return [
        {
            "name": one.name,
            "unit": one.unit,
            "healthy": one.healthy,
            "limit": one.limit,
            "values": one.values,
            "first_above": None if one.first is None else names[one.first - 1],
        }
        for one in courses
    ]


def _cell(value: float, unit: str) -> str:
    return f"{value:.3g}" if unit in LEVELS else f"{round(value, 2) + 0.0:.2f}"  # without minus zero


def _by_channel(levels: Sequence[ChannelLevel]) -> dict[tuple[str, str], np.ndarray]:
    """Acceleration and velocity (2,) of each channel, the root mean square over its windows."""
    squares: dict[tuple[str, str], list[np.ndarray]] = {}
    for one in levels:
        squares.setdefault((one.sensor, one.axis), []).append(np.array([one.acceleration, one.velocity]) ** 2)
    return {channel: np.sqrt(np.mean(own, axis=0)) for channel, own in squares.items()}


def _limits(healthy: np.ndarray) -> np.ndarray:
    """Limits (channel, kind) from healthy levels (recording, channel, kind)."""
    decibels = 20.0 * np.log10(np.maximum(healthy, np.finfo(float).tiny))
    spread, prior = moderated(decibels, [name for name, _, _ in _LEVELS], LEAST_SPREAD)
    bound = limit(DIFFERENT / spread.size, len(healthy), prior) * math.sqrt(1.0 + 1.0 / len(healthy))
    return np.asarray(10.0 ** ((decibels.mean(axis=0) + bound * spread) / 20.0))
