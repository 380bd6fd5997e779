"""Cage slip: a random walk of the cage about its kinematic angle, sampled over angle, not over time.

The contact angles of the elements differ and only the cage holds them together, so that the speed of the cage varies
by a per cent or two at random (Randall & Antoni 2011, Mech. Syst. Signal Process. 25, 485-520, section 2). Here
the slip at each pitch of the elements is share times a normal deviate xi_k, and it is linear in the kinematic angle chi
in between; its integral is the lag of the cage. So the lag is a random walk whose variance grows by
(share times pitch)^2 at every pitch, with a continuous rate. Because it depends on the angle alone, the time step does
not change it, and a shaft that turns back finds the same lag. The sequence repeats after ``PITCHES``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.numerics.inner_functions import inner

PITCHES = 4096


@dataclass(frozen=True, kw_only=True)
class CageSlip:
    """Standard deviation ``share`` of the slip at a pitch, per speed of the cage; ``seed`` of the sequence."""

    share: float
    seed: tuple[int, ...]

    def walk(self, pitch: float) -> np.ndarray:
        """Lag (rad) and slip of the cage at every pitch (PITCHES + 1, 2), ``pitch`` in rad; the first lag is 0."""
        slip = self.share * np.random.default_rng(list(self.seed)).standard_normal(PITCHES)
        slip = np.append(slip, slip[0])
        lag = np.concatenate([[0.0], np.cumsum(0.5 * pitch * (slip[1:] + slip[:-1]))])
        return np.column_stack([lag, slip])


@inner()
def lag_at(angle, pitch, walk):
    """Lag (rad) of the cage.

    Parameters
    ----------
    angle : rad, kinematic angle of the cage in the sense of the shaft
    pitch : rad, angle between two elements
    walk : (PITCHES + 1, 2) from `CageSlip.walk`, or (0, 2): no slip
    """
    n = len(walk) - 1
    if n < 1:
        return 0.0
    whole = math.floor(angle / pitch)
    part = angle / pitch - whole
    rounds = whole // n
    k = int(whole - rounds * n)
    lag, slip, next_slip = walk[k, 0], walk[k, 1], walk[k + 1, 1]
    return rounds * walk[n, 0] + lag + pitch * part * (slip + 0.5 * part * (next_slip - slip))
