"""What orders cannot tell apart: shafts that turn alike, or one a whole number of times as often as the other.

A fault on the faster of two such shafts repeats with the slower one, too; gears on one shaft share all of its orders.
"""

from __future__ import annotations

from pipelines.signals.orders.kinematics import Kinematics

SAME = 1e-3  # of a ratio; over a window of some hundred turns lines this close fall together


def alike(name: str, kinematics: Kinematics) -> tuple[str, ...]:
    """Names of the other shafts, gears or bearings whose orders coincide with those of one, or nest in them.

    Pass orders of bearings are no whole numbers, so that bearings are alike only if one shaft carries equal ones.
    """
    shafts = {shaft.name: shaft.ratio for shaft in kinematics.shafts}
    gears = {gear.name: shafts[gear.shaft] for gear in kinematics.gears}
    for places in (shafts, gears):
        if name in places:
            return tuple(other for other, ratio in places.items() if other != name and _nested(places[name], ratio))
    passing = {
        strike: (bearing.shaft, order) for bearing in kinematics.bearings for strike, order in bearing.strikes.items()
    }
    return tuple(other for other, place in passing.items() if other != name and place == passing.get(name))


def _nested(one: float, other: float) -> bool:
    quotient = max(one, other) / min(one, other)
    return abs(quotient - round(quotient)) < SAME * quotient
