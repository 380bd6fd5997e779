"""Direction that turns with a shaft, in the plane across it.

A direction fixed to the shaft has the angle beta = alpha - s phi from +x towards +z: alpha at t = 0, s the sense of
the shaft, phi = ratio phi_m + its angle row the true rotation, of the train and of the vibration together. Its unit
vector is n = (cos beta, sin beta) in (x, z), and n' = beta' t with t = (-sin beta, cos beta).
"""

from __future__ import annotations

import math

from fem.numerics.inner_functions import INLINE, inner


@inner(**INLINE)
def turned_direction(start, sense, roll, angle, own):
    """(cos beta, sin beta) of a direction that turns with a shaft.

    Parameters
    ----------
    start, sense, roll : alpha (rad), s and the ratio of the shaft's angle to the motor's
    angle, own : of the motor, and the shaft's angle row, rad
    """
    beta = start - sense * (roll * angle + own)
    return math.cos(beta), math.sin(beta)
