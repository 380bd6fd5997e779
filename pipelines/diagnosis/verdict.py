"""The diagnosis of a recording against a reference: is it different, and which component is damaged?

The reference is a baseline of healthy recordings, or the control of a simulation: the same machine without the fault.
The diagnosis does not use the known faults of a simulation. It answers two questions from all channels:

- Different (two-sided): a feature deviates from the healthy recordings to either side. At most DIFFERENT of healthy
  machines have such a deviation in any of their features.
- Damaged (one-sided): the evidence of a component, the mean deviation of its features, is high. At most ALARM of
  healthy machines have such evidence for any of their components.

`pipelines.diagnosis.verdict_words` words the answers.

Damage of a gear repeats with its shaft, impacts of a bearing do not. But an average over N revolutions retains 1/N of
their power, and they raise all features of gears. Let A be the power of the average, n the part of it that does not
repeat with the shaft, and n_h the largest n of the healthy recordings. The evidence of a gear counts by

    1 - 2 (n - n_h)/A,     at least 0 and at most 1,     with the mean of (n - n_h)/A over the channels.

So it counts completely if the average retains no more than in healthy recordings, and not at all if half of its power
is more than that. This also applies to a shaft whose gears are not known.

A rolling bearing is also damaged if it has clear impacts (`pipelines.diagnosis.impacts`) that no healthy recording has.
Clear impacts rank before all other evidence, the highest level first: they also change features of gears and shafts,
but damage of gears and shafts does not cause impacts at pass orders.

Damage of another shaft also raises features of a gear, but reduces the share of the whitened vibration that repeats
with the gear. If a shaft is left out and this share is less than in some healthy recording, the verdict names both.

Features of the whole signal are not evidence of a component. The recordings of a control are of the same machine and
differ only in their sensor noise. With fewer than FEWEST_FOR_P healthy recordings the components are only ranked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fem.storage import shown_html
from pipelines.diagnosis.alike import alike
from pipelines.diagnosis.baseline_checks import check_baseline, outlying
from pipelines.diagnosis.deviation_statistics import (
    FEWEST_FOR_P,
    LEAST_SPREAD,
    at_speed,
    clopper_pearson,
    deviations,
    limit,
    moderated,
    probability,
)
from pipelines.diagnosis.impacts import CLEAR, in_race_or_element
from pipelines.signals.features.feature_table import OF_SHAFT, OF_WHITENED
from pipelines.signals.features.passing import SIDEBANDS
from pipelines.signals.features.table import WHOLE, FeatureTable
from pipelines.signals.orders.kinematics import Kinematics

LEAST_ORDER = -40.0  # dB over the rms of healthy recordings; weaker orders of a shaft are no evidence
DIFFERENT, ALARM = 0.01, 0.001  # probabilities that a healthy machine is called different, or damaged
_OVER_HEALTHY = 6.0  # dB, least level of clear impacts over every healthy recording


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Evidence of a component at the channel where it is strongest: the mean over a group of its `features`.

    `increase` is in dB over the healthy mean, `deviation` in standard deviations of the healthy recordings. A component
    whose deviation reaches `limit` is damaged. `p` is corrected for the number of components and channels, 0 for clear
    impacts. `limit` and `p` are None with fewer than FEWEST_FOR_P healthy recordings; `deviation` is then the increase.
    `impacts` is the level (dB) of clear impacts over the envelope spectrum around them, None if there are none.
    """

    features: tuple[str, ...]
    sensor: str
    axis: str
    increase: float
    deviation: float
    limit: float | None
    p: float | None
    impacts: float | None = None


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A component with its evidence, and `alike`, the components with the same orders.

    `tooth` of a gear is in mesh when an impact begins; None if its position is not known or the gear shows no increase.
    `damaged` is None if the evidence has no limit. `repeating` is False if a smaller share of the vibration repeats
    with the shaft than in some healthy recording, so that damage of another shaft can be the cause of the evidence.
    `healthy` is the range of the evidence over its limit in the healthy recordings, each compared with the others; None
    if they are too few.
    """

    component: str
    evidence: Evidence
    damaged: bool | None
    repeating: bool
    alike: tuple[str, ...]
    tooth: int | None
    healthy: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Change:
    """A feature that differs at a channel: its increase (dB) and its deviation in standard deviations."""

    component: str
    feature: str
    sensor: str
    axis: str
    increase: float
    deviation: float


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Result of a diagnosis: is the recording different or damaged, and `findings`, the strongest evidence first.

    `different`, `damaged` and `p_different` are None with fewer than FEWEST_FOR_P healthy recordings. `p_different` is
    corrected for the number of features and channels. `changes` are the features that differ, the largest deviation
    first. `exact` means that the reference is a control. `at_speed` means that the levels of the healthy recordings
    depend on the speed and were taken at that of the recording.

    `tested` healthy recordings were diagnosed against the others; `false_differences` and `false_alarms` of them were
    called different or damaged. `tested` is 0 if the others are too few. `healthy` counts the recordings of the
    reference without those that are `outlying`. `left_out` names shafts with too few turns or of conditional speed, and
    the reason.
    """

    findings: tuple[Finding, ...]
    different: bool | None
    damaged: bool | None
    p_different: float | None
    changes: tuple[Change, ...]
    exact: bool
    healthy: int
    at_speed: bool
    outlying: tuple[str, ...]
    tested: int
    false_differences: int
    false_alarms: int
    left_out: tuple[str, ...]

    @property
    def first(self) -> Finding:
        """The component with the strongest evidence."""
        return self.findings[0]

    @property
    def candidates(self) -> tuple[str, ...]:
        """Shafts that are left out and whose damage can be the cause of the strongest evidence."""
        return () if self.first.repeating else tuple(one.partition(":")[0] for one in self.left_out)

    def __repr__(self) -> str:
        return f"<Verdict: {self._words()}; first {self.first.component}, {decibels(self.first.evidence.increase)} dB>"

    def _words(self) -> str:
        found = {True: "damaged", False: "no damage", None: "baseline too small to decide"}[self.damaged]
        return f"{found}, against {self.healthy} healthy recording{'' if self.healthy == 1 else 's'}"

    def _repr_html_(self) -> str:
        """The findings as a table, for a notebook."""
        rows = [
            (
                one.component,
                decibels(one.evidence.increase),
                f"{one.evidence.sensor} {one.evidence.axis}",
                None if one.evidence.p is None else f"{one.evidence.p:.1g}",
                one.tooth,
                ", ".join(one.alike),
            )
            for one in self.findings
        ]
        head = ("component", "increase, dB", "channel", "p-value", "tooth", "same orders as")
        return shown_html.table(self._words(), head, rows)

    def interval(self, count: int) -> tuple[float, float]:
        """95 % confidence interval of the rate of false answers, `count` of the tested healthy recordings."""
        return clopper_pearson(count, self.tested)


def decibels(increase: float) -> str:
    """An increase (dB) as text with a sign, without minus zero."""
    return f"{round(increase, 1) + 0.0:+.1f}"


def judge(
    recording: FeatureTable,
    baseline: Sequence[FeatureTable],
    kinematics: Kinematics,
    names: Sequence[str] = (),
    exact: bool = False,
) -> Verdict:
    """The verdict on a recording, compared with healthy ones.

    Parameters
    ----------
    recording, baseline : features of the same machine at the same channels
    kinematics : of the machine
    names : of the healthy recordings; by default "healthy recording 1", ...
    exact : the healthy recordings are the control of a simulation with several samples of the sensor noise

    Raises
    ------
    BaselineError : recordings cannot be compared, one is given twice, one is the recording itself, or most are outlying
    """
    names = names or [f"healthy recording {number}" for number in range(1, len(baseline) + 1)]
    check_baseline(recording, baseline, names, exact)
    levels, healthy, speed, speeds, retained = _compared(recording, baseline)
    lines = _Lines(recording)

    def compared(one: int, others: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        accepted = at_speed(healthy[others], speeds[others], speeds[one])
        return healthy[one], accepted, lines.repeating(baseline[one], retained[others])

    def chances(one: int, others: np.ndarray) -> tuple[float, float]:
        return lines.chances(*compared(one, others))

    odd = [] if exact else outlying(healthy, lambda one, others: min(chances(one, others)))
    kept = np.delete(np.arange(len(healthy)), odd)
    tested = len(kept) if len(kept) > FEWEST_FOR_P and not exact else 0
    others = [chances(one, kept[kept != one]) for one in kept[:tested]]
    reference = at_speed(healthy[kept], speeds[kept], speed)
    enough = len(reference) >= FEWEST_FOR_P
    weight = lines.repeating(recording, retained[kept])
    different = lines.chances(levels, reference, weight)[0] if enough else None
    shares = np.array([other.repeating for other in baseline])[kept]
    scatter: dict[str, list[float]] = {}
    for one in kept[:tested]:
        for finding in _findings(lines, *compared(one, kept[kept != one]), shares, kinematics):
            own = scatter.setdefault(finding.component, [])
            own.append(finding.evidence.deviation / (finding.evidence.limit or 1.0))
    findings = tuple(
        replace(finding, healthy=(min(own), max(own)) if (own := scatter.get(finding.component, [])) else None)
        for finding in _findings(lines, levels, reference, weight, shares, kinematics)
    )
    return Verdict(
        findings=findings,
        different=None if different is None else different <= DIFFERENT,
        damaged=any(one.damaged for one in findings) if enough else None,
        p_different=different,
        changes=_changes(lines, levels, reference) if enough else (),
        exact=exact,
        healthy=len(kept),
        at_speed=len(reference) < len(kept),
        outlying=tuple(names[i] for i in odd),
        tested=tested,
        false_differences=sum(one <= DIFFERENT for one, _ in others),
        false_alarms=sum(one <= ALARM for _, one in others),
        left_out=recording.left_out,
    )


def damage_p(recording: FeatureTable, baseline: Sequence[FeatureTable]) -> float:
    """Probability that any component of a healthy machine has evidence as high as the highest of the recording.

    Parameters
    ----------
    recording, baseline : as for `judge`, with FEWEST_FOR_P healthy recordings or more

    Raises
    ------
    BaselineError : as for `judge`
    """
    check_baseline(recording, baseline, [f"healthy recording {number}" for number in range(1, len(baseline) + 1)])
    levels, healthy, speed, speeds, retained = _compared(recording, baseline)
    lines = _Lines(recording)
    return lines.chances(levels, at_speed(healthy, speeds, speed), lines.repeating(recording, retained))[1]


class _Lines:
    """The features of a table, and their groups; each group is the evidence of one component.

    Each order of a shaft is a group, since unbalance raises the first order only. A gear has two groups, features of
    the whitened signal and all others. Whitening shows small damage that flank deviations mask, but it removes an
    increase of the level.
    """

    def __init__(self, table: FeatureTable) -> None:
        self.table = table
        groups: dict[tuple[str, str | bool], list[int]] = {}
        for number, (component, feature) in enumerate(table.lines):
            if component != WHOLE:
                kind = feature if feature in OF_SHAFT or feature == SIDEBANDS else feature in OF_WHITENED
                groups.setdefault((component, kind), []).append(number)
        self.groups = [(component, tuple(own)) for (component, _), own in groups.items()]
        self.of_impacts = np.array([in_race_or_element(*table.lines[own[0]]) for _, own in self.groups])

    def features(self, own: Sequence[int]) -> tuple[str, ...]:
        """Names of the features of a group."""
        return tuple(self.table.feature[i] for i in own)

    def means(self, values: np.ndarray) -> np.ndarray:
        """Sums (..., group) of values (..., line), each divided by the square root of the size of the group."""
        return np.stack([values[..., own].sum(axis=-1) / math.sqrt(len(own)) for _, own in self.groups], axis=-1)

    def standardised(self, levels: np.ndarray, healthy: np.ndarray) -> tuple[np.ndarray, int, np.ndarray, int]:
        """Deviations of features (channel, line) and of groups (channel, group), each with its prior degrees of freedom
        d0 of `moderated`."""
        spread, prior = moderated(healthy, self.table.feature, LEAST_SPREAD)
        centred = (healthy - healthy.mean(axis=0)) / spread
        own = (levels - healthy.mean(axis=0)) / spread
        kinds = [" ".join(self.features(group)) for _, group in self.groups]
        together, prior_of_groups = moderated(self.means(centred), kinds, 1.0)
        of_groups = deviations(self.means(own), self.means(centred), together)
        return deviations(levels, healthy, spread), prior, of_groups, prior_of_groups

    def repeating(self, table: FeatureTable, healthy: np.ndarray) -> np.ndarray:
        """Factor (group,) of the evidence by the power that averages retain, `healthy` (recording, channel, line)."""
        more = np.maximum(table.retained - healthy.max(axis=0), 0.0)
        share = np.divide(more, table.of_average, out=np.zeros_like(more), where=more > 0.0).mean(axis=0)
        factor = np.maximum(1.0 - 2.0 * share, 0.0)
        return np.asarray(factor[[own[0] for _, own in self.groups]])

    def clear(self, levels: np.ndarray, healthy: np.ndarray) -> np.ndarray:
        """Whether groups (channel, group) are clear impacts of a bearing that no healthy recording has."""
        first = [own[0] for _, own in self.groups]
        over = (levels - healthy.max(axis=0))[:, first]
        return np.asarray(self.of_impacts & (levels[:, first] >= CLEAR) & (over >= _OVER_HEALTHY))

    def group_chances(self, deviation: np.ndarray, count: int, prior: int, clear: np.ndarray) -> np.ndarray:
        """p-values (channel, group) corrected for their number, 0 for clear impacts."""
        columns = [
            probability(column, count, prior, len(own))
            for column, (_, own) in zip(deviation.T, self.groups, strict=True)
        ]
        return np.where(clear, 0.0, np.minimum(np.stack(columns, axis=1) * deviation.size, 1.0))

    def chances(self, levels: np.ndarray, healthy: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
        """Probabilities that a healthy machine deviates as much, and that any of its components has as strong
        evidence."""
        count = len(healthy)
        of_lines, prior, of_groups, prior_of_groups = self.standardised(levels, healthy)
        p = self.group_chances(weight * of_groups, count, prior_of_groups, self.clear(levels, healthy))
        damaged = float(p.min())
        apart = 2.0 * of_lines.size * float(probability(np.abs(of_lines).max(), count, prior))
        return min(2.0 * min(apart, damaged), 1.0), damaged


def _findings(
    lines: _Lines,
    levels: np.ndarray,
    healthy: np.ndarray,
    weight: np.ndarray,
    shares: np.ndarray,
    kinematics: Kinematics,
) -> tuple[Finding, ...]:
    """All components: clear impacts first, in the order of their levels, then the others in that of their evidence."""
    table, count = lines.table, len(healthy)
    repeating = table.repeating.mean(axis=0) >= shares.mean(axis=1).max(axis=0)
    rises = levels - healthy.mean(axis=0)
    increase = np.stack([rises[:, own].mean(axis=1) for _, own in lines.groups], axis=1)
    deviation, p = weight * increase + 0.0, None
    clear = lines.clear(levels, healthy)
    bounds: list[float | None] = [None] * len(lines.groups)
    if count >= FEWEST_FOR_P:
        _, _, deviation, prior = lines.standardised(levels, healthy)
        deviation = weight * deviation + 0.0  # no minus zero
        p = lines.group_chances(deviation, count, prior, clear)
        bounds = [limit(ALARM / deviation.size, count, prior, len(own)) for _, own in lines.groups]
    scaled = deviation / np.array([bound or 1.0 for bound in bounds])
    rank = np.where(clear, levels[:, [own[0] for _, own in lines.groups]], scaled)
    best: dict[str, tuple[tuple[bool, float], Finding]] = {}
    for number, (component, own) in enumerate(lines.groups):
        channel = int(np.lexsort((rank[:, number], clear[:, number]))[-1])
        strength, bound = (bool(clear[channel, number]), float(rank[channel, number])), bounds[number]
        evidence = Evidence(
            features=lines.features(own),
            sensor=table.sensor[channel],
            axis=table.axis[channel],
            increase=float(increase[channel, number]),
            deviation=float(deviation[channel, number]),
            limit=bound,
            p=None if p is None else float(p[channel, number]),
            impacts=float(levels[channel, own[0]]) if strength[0] else None,
        )
        found = Finding(
            component=component,
            evidence=evidence,
            damaged=None if bound is None else strength[0] or evidence.deviation >= bound,
            repeating=bool(repeating[own[0]]),
            alike=alike(component, kinematics),
            tooth=table.tooth_of(component) if evidence.increase > 0.0 else None,
        )
        if component not in best or strength > best[component][0]:
            best[component] = (strength, found)
    return tuple(found for _, found in sorted(best.values(), key=lambda one: one[0], reverse=True))


def _changes(lines: _Lines, levels: np.ndarray, healthy: np.ndarray) -> tuple[Change, ...]:
    """The features that differ at a channel, the largest deviation first."""
    table, count = lines.table, len(healthy)
    deviation, prior, _, _ = lines.standardised(levels, healthy)
    rises = levels - healthy.mean(axis=0)
    bound = limit(DIFFERENT / (4.0 * deviation.size), count, prior)
    places = [(i, j) for i, j in zip(*np.nonzero(np.abs(deviation) >= bound), strict=True)]
    return tuple(
        Change(
            component=table.component[j],
            feature=table.feature[j],
            sensor=table.sensor[i],
            axis=table.axis[i],
            increase=float(rises[i, j]),
            deviation=float(deviation[i, j]),
        )
        for i, j in sorted(places, key=lambda place: -abs(deviation[place]))
    )


def _compared(
    recording: FeatureTable, baseline: Sequence[FeatureTable]
) -> tuple[np.ndarray, np.ndarray, float, np.ndarray, np.ndarray]:
    """What is compared: levels, speeds, and the power that averages of the healthy recordings retain.

    Weak orders of a shaft have little weight, see `counted`.

    Returns
    -------
    levels : (channel, line) of the recording, dB
    healthy : (recording, channel, line) of the healthy ones, dB
    speed, speeds : mean speed (Hz) of the recording, and of the healthy ones (recording,)
    retained : (recording, channel, line) of the healthy ones
    """
    healthy = np.array([other.channel_levels for other in baseline])
    rms = healthy[:, :, recording.lines.index((WHOLE, "rms"))].mean(axis=0)
    return (
        counted(recording.channel_levels, recording.feature, rms),
        counted(healthy, recording.feature, rms),
        float(recording.speed.mean()),
        np.array([other.speed.mean() for other in baseline]),
        np.array([other.retained for other in baseline]),
    )


def counted(levels: np.ndarray, features: Sequence[str], rms: np.ndarray) -> np.ndarray:
    """Levels (..., feature), dB, for a diagnosis: the power at LEAST_ORDER is added to that of an order of a shaft.

    Lines that hardly contribute to the vibration, or consist of noise, then scatter little. The maximum of the level
    and LEAST_ORDER is not suitable: levels just below it would be equal in all healthy recordings, without any scatter,
    and the next recording may exceed it.

    Parameters
    ----------
    levels : (..., feature), dB
    features : names
    rms : level (...) of the healthy vibration, dB
    """
    least = np.where(np.isin(features, list(OF_SHAFT)), np.asarray(rms)[..., None] + LEAST_ORDER, -np.inf)
    neper = math.log(10.0) / 10.0  # of powers, per dB
    with np.errstate(invalid="ignore"):  # the level of a feature that a recording lacks is NaN
        return np.asarray(np.logaddexp(levels * neper, least * neper) / neper)
