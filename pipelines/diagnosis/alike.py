"""What orders cannot tell apart: shafts that turn alike, or one a whole number of times as often as the other.

A fault on the faster of two such shafts repeats with the slower one, too; gears on one shaft share all of its orders.
"""

from __future__ import annotations

from pipelines.orders.kinematics import Kinematics

SAME = 1e-3  # of a ratio; over a window of some hundred turns lines this close fall together


def alike(name: str, kinematics: Kinematics) -> tuple[str, ...]:
    """Names of the other components whose orders coincide with those of a shaft or gear, or nest in them.

    Pass orders of bearings are no whole numbers, so that bearings are alike only if one shaft carries equal ones.
    """
    bearings = {bearing.name: bearing for bearing in kinematics.bearings}
    if name in bearings:
        own = bearings[name]
        return tuple(
            other.name
            for other in kinematics.bearings
            if other.name != name and other.shaft == own.shaft and dict(other.orders) == dict(own.orders)
        )
    places = {shaft.name: shaft.ratio for shaft in kinematics.shafts}
    places |= {gear.name: kinematics.shaft(gear.shaft).ratio for gear in kinematics.gears}
    if name not in places:
        return ()
    return tuple(other for other, ratio in places.items() if other != name and _nested(places[name], ratio))


def _nested(one: float, other: float) -> bool:
    quotient = max(one, other) / min(one, other)
    return abs(quotient - round(quotient)) < SAME * quotient
