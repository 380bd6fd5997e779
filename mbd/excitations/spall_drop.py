"""The path of a rolling element over a spall.

The element, a circle of radius r in the rolling plane, turns about the edge of the spall as it comes in and goes out:
its centre follows a circular arc about that edge, tangent to its path on the undamaged race. At the distance s from the
nearer edge, measured along the chord, it has come closer to the race by

    drop = min(depth, r - sqrt(r^2 - s^2) -+ (rho - sqrt(rho^2 - s^2))),

with the radius rho of the race in the rolling plane, minus for the outer race, which is hollow, plus for the inner one.
At most it is the sagitta of the element across the chord of the spall, measured from the race. The same holds for a
spall in the element, whose two edges roll over the race. A deep spall is left with a corner at its middle, where the
element goes over from one edge to the other; a shallow one lets it roll along the bottom.

References
----------
Sawalhi & Randall (2008), Mech. Syst. Signal Process. 22, 1924-1951, part I (depth of a local fault over its angle);
Sawalhi & Randall (2011), Mech. Syst. Signal Process. 25, 846-870 (entry on an arc, impact where the element meets the
other edge).
"""

from __future__ import annotations

import math

from fem.numerics.inner import inner

STEEP = 0.9  # of the element's radius: further from the edge every spall of `DEEPEST` is at its bottom


@inner()
def drop_at(place, width, depth, surface, element, race):
    """Drop (m) of an element over a spall.

    Parameters
    ----------
    place : m, of the contact along the surface, from the middle of the spall
    width, depth : m, of the spall
    surface : m, radius of the surface that has it
    element, race : m, radii of the element and of the race, the latter negative where it bulges
    """
    inside = 0.5 * width - abs(place)
    if inside <= 0.0:
        return 0.0
    across = surface * math.sin(inside / surface)
    if across >= STEEP * element:
        return depth
    return min(depth, _sagitta(element, across) - _sagitta(race, across))


@inner()
def _sagitta(radius, across):
    """r - sqrt(r^2 - s^2) without cancellation; negative with the radius."""
    return across * across / (radius + math.copysign(math.sqrt(radius * radius - across * across), radius))
