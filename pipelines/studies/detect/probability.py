"""Probability of detection: how many damaged machines are found, and how many of them in the right place.

A recording is an alarm if its p-value of damage is at most ALARM (`pipelines.diagnosis.verdict`), and that
p-value holds if levels are normal. So the rate of false alarms is measured, too, with healthy machines that are not in
the baseline, and a second time with others as the baseline. Independently of the model, a damaged recording is above
all of n healthy ones if its p-value is less than theirs: another healthy one is that with a chance of 1 / (n + 1).

References
----------
MIL-HDBK-1823A (2009), Nondestructive Evaluation System Reliability Assessment, appendix G (hit/miss data); Clopper &
Pearson (1934), Biometrika 26(4), 404-413 (intervals).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipelines.diagnosis.prediction import clopper_pearson
from pipelines.diagnosis.verdict import ALARM, damage_p, judge
from pipelines.signals.features.table import FeatureTable
from pipelines.signals.orders.kinematics import Kinematics

Damage = tuple[str, int | None]  # component and tooth, None where it has none


@dataclass(frozen=True, kw_only=True)
class Share:
    """`count` of `trials`, which may be none."""

    count: int
    trials: int

    @property
    def value(self) -> float:
        """The share, NaN of none."""
        return self.count / self.trials if self.trials else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of the probability."""
        return clopper_pearson(self.count, self.trials)


@dataclass(frozen=True, eq=False, kw_only=True)
class Machines:
    """Features of machines at one noise: those of the baseline, other healthy ones, and damaged ones with their damage.

    Only what the damaged ones have set apart differs between them: size of the damage, load and speed are the same.
    """

    kinematics: Kinematics
    baseline: Sequence[FeatureTable]
    healthy: Sequence[FeatureTable]
    damaged: Sequence[tuple[FeatureTable, Sequence[Damage]]]


@dataclass(frozen=True, kw_only=True)
class Detection:
    """Shares of machines.

    `false_alarms` of the healthy ones that are not in the baseline; `other_baselines`: the same with each against as
    many healthy ones that come next to it; and of the damaged ones `detected` (alarms), `above_healthy` (above all
    these healthy ones), `shaft_first` (a component of the damaged shaft ranks first, alarm
    or not), and `tooth_found` within one (None if no tooth is damaged).
    """

    false_alarms: Share
    other_baselines: Share
    detected: Share
    above_healthy: Share
    shaft_first: Share
    tooth_found: Share | None


def detection(machines: Machines) -> Detection:
    """How the damaged machines are found.

    Raises
    ------
    BaselineError : they do not have the same channels or features
    """
    healthy = [damage_p(table, machines.baseline) for table in machines.healthy]
    lowest = min(healthy, default=1.0)
    alarms, above, first, teeth = [], [], [], []
    for table, damage in machines.damaged:
        verdict = judge(table, machines.baseline, machines.kinematics)
        p = damage_p(table, machines.baseline)
        alarms.append(p <= ALARM)
        above.append(p < lowest)
        shafts = {machines.kinematics.shaft_of(component) for component, _ in damage}
        first.append(machines.kinematics.shaft_of(verdict.first.component) in shafts)
        teeth += [_tooth_found(table, one, machines.kinematics) for one in damage[:1] if one[1] is not None]
    return Detection(
        false_alarms=share([p <= ALARM for p in healthy]),
        other_baselines=_against_others(machines),
        detected=share(alarms),
        above_healthy=share(above),
        shaft_first=share(first),
        tooth_found=share(teeth) if teeth else None,
    )


def _against_others(machines: Machines) -> Share:
    """False alarms of healthy machines, each against others in the place of the baseline.

    The model of the p-values holds on average over baselines. One baseline whose levels happen to lie close together
    gives more false alarms than that, for good. Neighbours overlap, so that the interval is somewhat too narrow.
    """
    count = len(machines.baseline)
    ring = [*machines.healthy, *machines.baseline, *machines.healthy]
    return share([damage_p(own, ring[i + 1 : i + 1 + count]) <= ALARM for i, own in enumerate(machines.healthy)])


def share(found: Sequence[bool]) -> Share:
    """How many are true."""
    return Share(count=sum(map(bool, found)), trials=len(found))


def _tooth_found(table: FeatureTable, damage: Damage, kinematics: Kinematics) -> bool:
    """True if the tooth that stands out is the damaged one or next to it."""
    gear, tooth = damage
    found = table.tooth_of(gear)
    if found is None or tooth is None:
        return False
    count = next(one.teeth for one in kinematics.gears if one.name == gear)
    return min((found - tooth) % count, (tooth - found) % count) <= 1
