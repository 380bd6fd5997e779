"""Probability of detection: the share of damaged machines that are found, and found at the right component.

A recording is an alarm if its p-value of damage is at most ALARM (`pipelines.diagnosis.verdict`). The p-value assumes a
distribution of the levels. The rate of false alarms is therefore measured as well, with healthy machines that are not
in the baseline, and again with other baselines. A criterion without this assumption: a damaged recording is above all
of n healthy ones if its p-value is less than theirs. A further healthy recording is so with a probability of 1/(n + 1).

References
----------
MIL-HDBK-1823A (2009), Nondestructive Evaluation System Reliability Assessment, appendix G (hit/miss data); Clopper &
Pearson (1934), Biometrika 26(4), 404-413 (intervals).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipelines.diagnosis.deviation_statistics import clopper_pearson
from pipelines.diagnosis.judge import damage_p, judge
from pipelines.diagnosis.verdict import ALARM
from pipelines.signals.features.feature_table import FeatureTable
from pipelines.signals.orders.kinematics import Kinematics

Damage = tuple[str, int | None]  # component and tooth, None if it has none


@dataclass(frozen=True, kw_only=True)
class Share:
    """Share `count` of `trials`, which may be 0."""

    count: int
    trials: int

    @property
    def value(self) -> float:
        """The share; NaN without trials."""
        return self.count / self.trials if self.trials else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of the probability."""
        return clopper_pearson(self.count, self.trials)


@dataclass(frozen=True, eq=False, kw_only=True)
class Machines:
    """Features of machines at one noise: those of the baseline, other healthy ones, and damaged ones with their damage.

    All machines have the same load and speed, and all damaged ones the same size of damage.
    """

    kinematics: Kinematics
    baseline: Sequence[FeatureTable]
    healthy: Sequence[FeatureTable]
    damaged: Sequence[tuple[FeatureTable, Sequence[Damage]]]


@dataclass(frozen=True, kw_only=True)
class Detection:
    """Shares of machines.

    Of the healthy machines that are not in the baseline:

    - `false_alarms`: alarms
    - `other_baselines`: alarms if each is compared with a different baseline, the healthy machines that follow it

    Of the damaged machines:

    - `detected`: alarms
    - `above_healthy`: p-value less than those of all tested healthy machines
    - `shaft_first`: a component of the damaged shaft ranks first, with or without alarm
    - `tooth_found`: the damaged tooth or a neighbour is found; None if no tooth is damaged
    """

    false_alarms: Share
    other_baselines: Share
    detected: Share
    above_healthy: Share
    shaft_first: Share
    tooth_found: Share | None


def detection(machines: Machines) -> Detection:
    """Shares of damaged machines that are found, and of healthy ones that give a false alarm.

    Raises
    ------
    BaselineError : the machines do not have the same channels or features
    """
    healthy = [damage_p(table, machines.baseline) for table in machines.healthy]
    lowest = min(healthy, default=1.0)
    damaged = [damage_p(table, machines.baseline) for table, _ in machines.damaged]
    first, teeth = [], []
    for table, damage in machines.damaged:
        verdict = judge(table, machines.baseline, machines.kinematics)
        shafts = {machines.kinematics.shaft_of(component) for component, _ in damage}
        first.append(machines.kinematics.shaft_of(verdict.first.component) in shafts)
        teeth += [_tooth_found(table, one, machines.kinematics) for one in damage[:1] if one[1] is not None]
    return Detection(
        false_alarms=share([p <= ALARM for p in healthy]),
        other_baselines=_against_others(machines),
        detected=share([p <= ALARM for p in damaged]),
        above_healthy=share([p < lowest for p in damaged]),
        shaft_first=share(first),
        tooth_found=share(teeth) if teeth else None,
    )


def _against_others(machines: Machines) -> Share:
    """False alarms of healthy machines, each with a different baseline of other healthy machines.

    The rate of false alarms is ALARM only on average over baselines. A single baseline whose levels happen to scatter
    little always gives more of them. The baselines overlap, so the confidence interval is somewhat too narrow.
    """
    count = len(machines.baseline)
    ring = [*machines.healthy, *machines.baseline, *machines.healthy]
    return share([damage_p(own, ring[i + 1 : i + 1 + count]) <= ALARM for i, own in enumerate(machines.healthy)])


def share(found: Sequence[bool]) -> Share:
    """Share of the true values."""
    return Share(count=sum(map(bool, found)), trials=len(found))


def _tooth_found(table: FeatureTable, damage: Damage, kinematics: Kinematics) -> bool:
    """Whether the tooth that is found is the damaged one or a neighbour of it."""
    gear, tooth = damage
    found = table.tooth_of(gear)
    if found is None or tooth is None:
        return False
    count = next(one.teeth for one in kinematics.gears if one.name == gear)
    return min((found - tooth) % count, (tooth - found) % count) <= 1
