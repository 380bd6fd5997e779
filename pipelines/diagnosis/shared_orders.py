"""Components that cannot be distinguished by their orders: shafts whose speeds are equal or have an integer ratio.

A fault on the faster of two such shafts also repeats once per revolution of the slower one. Gears on one shaft share
all of its orders.
"""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.signals.orders.kinematics import Kinematics

SAME = 1e-3  # relative difference of ratios: in a window of a few hundred turns, such lines are in the same bin


def alike(name: str, kinematics: Kinematics, left_out: Sequence[str] = ()) -> tuple[str, ...]:
    """Names of the other shafts, gears or bearing parts with the orders of the named one, or integer multiples of them.

    Pass orders of bearings are not integers. Parts of two bearings are therefore alike only if their shaft and their
    order are the same. A part that is `left_out`, because its pass order is not separated from a multiple of a shaft,
    is like this shaft and its gears.
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
    return abs(quotient - round(quotient)) < SAME * quotient
