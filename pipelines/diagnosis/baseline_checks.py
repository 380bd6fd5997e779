"""Checks of a baseline of healthy recordings: duplicates, and outlying recordings.

Outlying recordings are found by a forward search (Hadi 1992, J. R. Stat. Soc. B 54(3), 761-771). The most central
recordings are accepted first, then the others one by one, the most similar first. If a healthy recording differs as
much from the accepted ones as the next one with a probability of at most OUTLYING, it and all others are outlying.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_TREND
from pipelines.signals.features.feature_table import WHOLE, FeatureTable

FEWEST_FOR_OUTLYING = FEWEST_FOR_TREND + 1  # recordings; the most central ones are accepted without a comparison
OUTLYING = 0.01  # probability that a healthy recording differs so much from the accepted ones
_SAME = 1e-6  # relative difference of features below which two files contain the same recording


class BaselineError(ValueError):
    """Recordings cannot be compared: different channels or features, a duplicate, or no recording."""


def check_baseline(
    recording: FeatureTable, baseline: Sequence[FeatureTable], names: Sequence[str], exact: bool = False
) -> None:
    """Raise BaselineError if recordings cannot be compared, or if two of them are the same.

    Parameters
    ----------
    recording, baseline : features of the diagnosed recording and of the healthy ones
    names : of the healthy ones, for messages
    exact : the healthy ones are the control; it may be equal to the diagnosed recording if a fault has no effect
    """
    if not baseline:
        raise BaselineError("no healthy recording to compare with. Give at least one.")
    if all(component == WHOLE for component, _ in recording.lines):
        raise BaselineError(
            f"no shaft, gear or bearing has a feature in all recordings. {'. '.join(recording.left_out)}. Set "
            "another --window, or add bearings to the machine file."
        )
    for number, (name, other) in enumerate(zip(names, baseline, strict=True)):
        if (other.sensor, other.axis) != (recording.sensor, recording.axis):
            raise BaselineError(
                f"{name} has the channels {_channels(other)}, the recording to diagnose has "
                f"{_channels(recording)}. Give recordings of the same channels."
            )
        if other.lines != recording.lines:
            unlike = sorted({" ".join(line) for line in set(other.lines) ^ set(recording.lines)})
            raise BaselineError(
                f"{name} does not have the same features ({', '.join(unlike[:3])}, ...). Give "
                "recordings of about the same speed, length and sampling rate."
            )
        if exact:
            continue
        if _same(other, recording):
            raise BaselineError(
                f"{name} has the same signals as the recording to diagnose. Remove it from the healthy recordings."
            )
        twice = [first for first, one in zip(names[:number], baseline, strict=False) if _same(one, other)]
        if twice:
            raise BaselineError(f"{name} is the same recording as {twice[0]}. Give each healthy recording once.")


def outlying(healthy: np.ndarray, difference: Callable[[int, np.ndarray], float]) -> list[int]:
    """Numbers of the outlying recordings; empty if there are too few recordings.

    Parameters
    ----------
    healthy : levels (recording, channel, line), dB
    difference : function that returns the probability that a healthy recording differs as much from accepted ones;
        its arguments are the number of the recording and those of the accepted ones (accepted,)
    """
    core = max(FEWEST_FOR_TREND, len(healthy) // 2 + 1)
    if len(healthy) < FEWEST_FOR_OUTLYING:
        return []
    away = np.abs(healthy - np.median(healthy, axis=0))
    size = np.median(away, axis=0)
    distance = np.divide(away, size, out=np.zeros_like(away), where=size > 0.0).mean(axis=(1, 2))
    taken, rest = np.split(np.argsort(distance), [core])
    while len(rest):
        chances = [difference(int(one), taken) for one in rest]
        best = int(np.argmax(chances))
        if chances[best] <= OUTLYING:
            return sorted(rest.tolist())
        taken, rest = np.append(taken, rest[best]), np.delete(rest, best)
    return []


def _same(one: FeatureTable, other: FeatureTable) -> bool:
    """Whether two tables of the same channels and lines have the same values."""
    return bool((np.abs(one.value - other.value) <= _SAME * np.abs(other.value)).all())


def _channels(table: FeatureTable) -> str:
    return ", ".join(f"{sensor} {axis}" for sensor, axis in zip(table.sensor, table.axis, strict=True))
