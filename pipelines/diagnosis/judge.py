"""The diagnosis of a recording against a reference: is it different, and which component is damaged?

The reference is a baseline of healthy recordings, or the control of a simulation: the same machine without the fault.
The diagnosis does not use the known faults of a simulation. It answers two questions from all channels:

- Different (two-sided): a feature deviates from the healthy recordings to either side. At most DIFFERENT of healthy
  machines have such a deviation in any of their features.
- Damaged (one-sided): the evidence of a component (`pipelines.diagnosis.evidence`) is high. At most ALARM of healthy
  machines have such evidence for any of their components.

A rolling bearing is also damaged if it has clear impacts (`pipelines.diagnosis.impacts`) that no healthy recording has.
Clear impacts rank before all other evidence, the highest level first: they also change features of gears and shafts,
but damage of gears and shafts does not cause impacts at pass orders.

Damage of another shaft also raises features of a gear, but reduces the share of the whitened vibration that repeats
with the gear. If a shaft is left out and this share is less than in some healthy recording, the verdict names both.

The recordings of a control are of the same machine and differ only in their sensor noise. With fewer than FEWEST_FOR_P
healthy recordings the components are only ranked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipelines.diagnosis.baseline_checks import check_baseline, outlying
from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_P, limit
from pipelines.diagnosis.evidence import GroupEvidence, HealthyReference
from pipelines.diagnosis.verdict import ALARM, DIFFERENT, Change, Evidence, Finding, Verdict
from pipelines.signals.features.feature_table import FeatureTable
from pipelines.signals.orders.kinematics import Kinematics

_SAME = 1e-3  # relative difference of ratios: in a window of a few hundred turns, such lines are in the same bin


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
    names = names or _numbered(baseline)
    check_baseline(recording, baseline, names, exact)
    reference = HealthyReference(baseline)

    def evidence(one: int, others: np.ndarray) -> GroupEvidence:
        return reference.evidence(baseline[one], others)

    def chance(one: int, others: np.ndarray) -> float:
        return min((found := evidence(one, others)).p_different, found.p_damaged)

    odd = [] if exact else outlying(reference.levels, chance)
    kept = np.delete(np.arange(len(baseline)), odd)
    tested = kept if len(kept) > FEWEST_FOR_P and not exact else kept[:0]
    others = [evidence(one, kept[kept != one]) for one in tested]
    scatter: dict[str, list[float]] = {}
    for one, other in zip(tested, others, strict=True):
        for finding in _findings(other, baseline[one], reference.shares[kept], kinematics):
            scatter.setdefault(finding.component, []).append(finding.evidence.ratio)
    found = reference.evidence(recording, kept)
    findings = tuple(
        replace(finding, healthy=(min(own), max(own)) if (own := scatter.get(finding.component)) else None)
        for finding in _findings(found, recording, reference.shares[kept], kinematics)
    )
    return Verdict(
        findings=findings,
        different=found.p_different <= DIFFERENT if found.enough else None,
        damaged=any(one.damaged for one in findings) if found.enough else None,
        p_different=found.p_different if found.enough else None,
        changes=_changes(found, recording) if found.enough else (),
        exact=exact,
        healthy=len(kept),
        at_speed=len(found.healthy) < len(kept),
        outlying=tuple(names[i] for i in odd),
        tested=len(tested),
        false_differences=tuple(
            names[i] for i, one in zip(tested, others, strict=True) if one.p_different <= DIFFERENT
        ),
        false_alarms=tuple(names[i] for i, one in zip(tested, others, strict=True) if one.p_damaged <= ALARM),
        left_out=recording.left_out,
        not_examined=kinematics.without({component for component, _ in reference.groups}),
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
    check_baseline(recording, baseline, _numbered(baseline))
    return HealthyReference(baseline).evidence(recording, np.arange(len(baseline))).p_damaged


def _numbered(baseline: Sequence[FeatureTable]) -> list[str]:
    return [f"healthy recording {number}" for number in range(1, len(baseline) + 1)]


def _findings(
    found: GroupEvidence, table: FeatureTable, shares: np.ndarray, kinematics: Kinematics
) -> tuple[Finding, ...]:
    """All components of a table: clear impacts first, in the order of their levels, then the others in that of their
    evidence."""
    groups, clear = found.reference.groups, found.clear
    repeating = table.repeating.mean(axis=0) >= shares.max(axis=0)
    increase = np.stack([found.rises[:, own].mean(axis=1) for _, own in groups], axis=1)
    deviation = found.of_groups[0] if found.enough else found.weight * increase + 0.0  # no minus zero
    bounds: list[float] | list[None] = found.limits(ALARM) if found.enough else [None] * len(groups)
    level = found.levels[:, found.reference.first_lines]
    rank = np.where(clear, level, deviation / np.array([bound or 1.0 for bound in bounds]))
    best: dict[str, tuple[tuple[bool, float], Finding]] = {}
    for number, (component, own) in enumerate(groups):
        channel = int(np.lexsort((rank[:, number], clear[:, number]))[-1])
        strength, bound = (bool(clear[channel, number]), float(rank[channel, number])), bounds[number]
        evidence = Evidence(
            features=found.reference.features(own),
            sensor=table.sensor[channel],
            axis=table.axis[channel],
            increase=float(increase[channel, number]),
            deviation=float(deviation[channel, number]),
            limit=bound,
            p=float(found.p[channel, number]) if found.enough else None,
            impacts=float(level[channel, number]) if strength[0] else None,
        )
        one = Finding(
            component=component,
            evidence=evidence,
            damaged=None if bound is None else strength[0] or evidence.deviation >= bound,
            repeating=bool(repeating[own[0]]),
            alike=alike(component, kinematics, table.left_out),
            tooth=table.tooth_of(component) if evidence.increase > 0.0 else None,
        )
        if component not in best or strength > best[component][0]:
            best[component] = (strength, one)
    return tuple(one for _, one in sorted(best.values(), key=lambda pair: pair[0], reverse=True))


def _changes(found: GroupEvidence, table: FeatureTable) -> tuple[Change, ...]:
    """The features of a table that differ at a channel, the largest deviation first."""
    deviation, prior = found.of_lines
    bound = limit(DIFFERENT / (4.0 * deviation.size), len(found.healthy), prior)
    places = [(i, j) for i, j in zip(*np.nonzero(np.abs(deviation) >= bound), strict=True)]
    return tuple(
        Change(
            component=table.component[j],
            feature=table.feature[j],
            sensor=table.sensor[i],
            axis=table.axis[i],
            increase=float(found.rises[i, j]),
            deviation=float(deviation[i, j]),
        )
        for i, j in sorted(places, key=lambda place: -abs(deviation[place]))
    )


def alike(name: str, kinematics: Kinematics, left_out: Sequence[str] = ()) -> tuple[str, ...]:
    """Names of the other shafts, gears or bearing parts with the orders of the named one, or integer multiples of them.

    A fault on the faster of two shafts whose speeds are equal or have an integer ratio also repeats once per revolution
    of the slower one. Gears on one shaft share all of its orders. Pass orders of bearings are not integers. Parts of
    two bearings are therefore alike only if their shaft and their order are the same. A part that is `left_out`,
    because its pass order is not separated from a multiple of a shaft, is like this shaft and its gears.
    """
    shafts = {shaft.name: shaft.ratio for shaft in kinematics.shafts}
    gears = {gear.name: shafts[gear.shaft] for gear in kinematics.gears}
    for places in (shafts, gears):
        if name in places:
            others = [other for other, ratio in places.items() if other != name and _nested(places[name], ratio)]
            multiple = f" x {kinematics.shaft_of(name)} ("
            return (*others, *(one.partition(": ")[0] for one in left_out if multiple in one))
    passing = {
        strike: (bearing.shaft, order) for bearing in kinematics.bearings for strike, order in bearing.strikes.items()
    }
    return tuple(other for other, place in passing.items() if other != name and place == passing.get(name))


def _nested(one: float, other: float) -> bool:
    quotient = max(one, other) / min(one, other)
    return abs(quotient - round(quotient)) < _SAME * quotient
