"""The blind verdict: how far every component of a machine stands above healthy recordings, highest first.

Nothing here knows of a fault. The rise of a component is the mean of the rises of its features, in dB over the mean of
the healthy recordings. With FEWEST_FOR_P of them or more each feature has a p-value, corrected for the number of all
features (Holm), and the recording is an alarm if one of them falls below ALARM. With fewer there is no p-value and no
alarm, only the order of the rises.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.storage import shown_html
from pipelines.diagnosis.alike import alike
from pipelines.diagnosis.prediction import FEWEST_FOR_P, clopper_pearson, holm, p_values
from pipelines.signals.features.recorded import OF_SHAFT
from pipelines.signals.features.table import WHOLE, FeatureTable
from pipelines.signals.orders.kinematics import Kinematics

LEAST_ORDER = -40.0  # dB over the rms of healthy recordings: weaker orders of a shaft come and go
ALARM = 0.001  # chance of an alarm from a healthy recording in the mean over baselines, if the model holds


class BaselineError(ValueError):
    """Recordings cannot be compared: other channels, other features, or none."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """A feature of a component: `rise` (dB) over the healthy mean, corrected p-value, None with a small baseline."""

    feature: str
    rise: float
    p: float | None


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A component: the mean of its rises (dB), the least of its p-values, what it cannot be told from, and the tooth
    that stands out most of a gear, None if its place is not known or the gear has no increase."""

    component: str
    rise: float
    p: float | None
    evidence: tuple[Evidence, ...]
    alike: tuple[str, ...]
    tooth: int | None


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """`findings` highest rise first; `alarm` None with a small baseline; `whole` what the signal as such shows.

    `false_alarms` of `tested` healthy recordings are alarms against the others, none tested if the others would be too
    few; `left_out` are components that turn too seldom, in words.
    """

    findings: tuple[Finding, ...]
    whole: Finding
    alarm: bool | None
    healthy: int
    tested: int
    false_alarms: int
    left_out: tuple[str, ...]

    @property
    def first(self) -> Finding:
        """The component that stands out most."""
        return self.findings[0]

    def __repr__(self) -> str:
        return f"<Verdict: {self._words()}; first {self.first.component}, {decibels(self.first.rise)} dB>"

    def _words(self) -> str:
        alarm = {True: "alarm", False: "no alarm", None: "baseline too small for an alarm"}[self.alarm]
        return f"{alarm}, against {self.healthy} healthy recording{'' if self.healthy == 1 else 's'}"

    def _repr_html_(self) -> str:
        """The findings as a table, for a notebook."""
        rows = [
            (
                found.component,
                decibels(found.rise),
                None if found.p is None else f"{found.p:.1g}",
                found.tooth,
                ", ".join(found.alike),
            )
            for found in (*self.findings, self.whole)
        ]
        head = ("component", "increase, dB", "p-value", "tooth", "same orders as")
        return shown_html.table(self._words(), head, rows)

    @property
    def false_alarm_interval(self) -> tuple[float, float]:
        """95 % interval of the rate of false alarms, from the healthy recordings themselves."""
        return clopper_pearson(self.false_alarms, self.tested)


def decibels(rise: float) -> str:
    """A rise (dB) as it is shown, without minus zero."""
    return f"{round(rise, 1) + 0.0:+.1f}"


def judge(recording: FeatureTable, baseline: Sequence[FeatureTable], kinematics: Kinematics) -> Verdict:
    """The verdict on a recording against healthy ones.

    Parameters
    ----------
    recording, baseline : features of the same machine at the same channels
    kinematics : its machine

    Raises
    ------
    BaselineError : no healthy recording, or one with other channels or features
    """
    levels, healthy = _compared(recording, baseline)
    rises = levels - healthy.mean(axis=0)
    enough = len(baseline) >= FEWEST_FOR_P
    p = holm(p_values(levels, healthy)) if enough else None
    findings = {name: _finding(name, recording, rises, p, kinematics) for name in dict.fromkeys(recording.component)}
    whole = findings.pop(WHOLE)
    tested = len(baseline) if len(baseline) > FEWEST_FOR_P else 0
    return Verdict(
        findings=tuple(sorted(findings.values(), key=lambda finding: -finding.rise)),
        whole=whole,
        alarm=None if p is None else bool(p.min() <= ALARM),
        healthy=len(baseline),
        tested=tested,
        false_alarms=sum(_least_p(healthy[i], np.delete(healthy, i, axis=0)) <= ALARM for i in range(tested)),
        left_out=recording.left_out,
    )


def least_p(recording: FeatureTable, baseline: Sequence[FeatureTable]) -> float:
    """Least p-value of all features, corrected for their number: the recording is an alarm if it is at most ALARM.

    Parameters
    ----------
    recording, baseline : as `judge` takes them, FEWEST_FOR_P healthy ones or more

    Raises
    ------
    BaselineError : as `judge`
    """
    return _least_p(*_compared(recording, baseline))


def _least_p(levels: np.ndarray, healthy: np.ndarray) -> float:
    return float(holm(p_values(levels, healthy)).min())


def _compared(recording: FeatureTable, baseline: Sequence[FeatureTable]) -> tuple[np.ndarray, np.ndarray]:
    """Levels of the recording (line,) and the healthy ones (recording, line), dB; weak orders raised to the least."""
    healthy = _levels(recording, baseline)
    rms = healthy[:, recording.lines.index((WHOLE, "rms"))].mean()
    least = least_levels(recording.feature, float(rms))
    return np.maximum(recording.levels, least), np.maximum(healthy, least)


def _levels(recording: FeatureTable, baseline: Sequence[FeatureTable]) -> np.ndarray:
    """Levels (recording, line) of the healthy ones, if they can be compared."""
    if not baseline:
        raise BaselineError("no healthy recording to compare with. Give at least one.")
    for number, other in enumerate(baseline, 1):
        if (other.sensor, other.axis) != (recording.sensor, recording.axis):
            raise BaselineError(
                f"healthy recording {number} has the channels {_channels(other)}, the recording to diagnose has "
                f"{_channels(recording)}. Give recordings of the same channels."
            )
        if other.lines != recording.lines:
            unlike = sorted({" ".join(line) for line in set(other.lines) ^ set(recording.lines)})
            raise BaselineError(
                f"healthy recording {number} does not have the same features ({', '.join(unlike[:3])}, ...). Give "
                "recordings of about the same speed, length and sampling rate."
            )
    return np.array([other.levels for other in baseline])


def least_levels(features: Sequence[str], rms: float) -> np.ndarray:
    """Levels (feature,), dB, below which nothing is evidence: orders of a shaft that hardly add to the vibration.

    Parameters
    ----------
    features : names
    rms : level of the healthy vibration, dB
    """
    return np.where(np.isin(features, list(OF_SHAFT)), rms + LEAST_ORDER, -np.inf)


def _finding(
    name: str, recording: FeatureTable, rises: np.ndarray, p: np.ndarray | None, kinematics: Kinematics
) -> Finding:
    own = [i for i, component in enumerate(recording.component) if component == name]
    evidence = tuple(
        Evidence(feature=recording.feature[i], rise=float(rises[i]), p=None if p is None else float(p[i])) for i in own
    )
    rise = float(np.mean(rises[own]))
    return Finding(
        component=name,
        rise=rise,
        p=None if p is None else float(p[own].min()),
        evidence=evidence,
        alike=alike(name, kinematics),
        tooth=recording.tooth_of(name) if round(rise, 1) > 0.0 else None,
    )


def _channels(table: FeatureTable) -> str:
    return ", ".join(f"{sensor} {axis}" for sensor, axis in zip(table.sensor, table.axis, strict=True))
