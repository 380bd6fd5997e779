"""Cage slip: a random walk of the cage about its kinematic angle, drawn over angle and never over time.

Each element rolls on a contact angle of its own and is held by the cage alone, so that the cage runs ahead and falls
behind by a per cent or two at random (Randall & Antoni 2011, Mech. Syst. Signal Process. 25, 485-520, section 2). Here
the slip has a normal deviate of its own at every pitch of the elements, share times xi_k, and is linear in the
kinematic angle chi in between; its integral is the lag of the cage. So the lag is a random walk whose variance grows by
(share times pitch)^2 at every pitch, with a steady rate. It depends on the angle alone: a finer step finds the same
cage at the same place, and so does a shaft that turns back. The sequence starts anew after ``PITCHES``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.numerics.inner import inner
from mbd.parts.checks import MachineError

PITCHES = 4096
LARGEST = 0.05


@dataclass(frozen=True, kw_only=True)
class CageSlip:
    """``share`` of the cage's speed that the slip at a pitch has as standard deviation; ``seed`` of the sequence."""

    share: float
    seed: tuple[int, ...]

    def __post_init__(self) -> None:
        if not 0.0 <= self.share <= LARGEST:
            raise MachineError(
                f"cage slip: {self.share!r} must be from 0 to {LARGEST}; cages with more skid, which is not modelled."
            )

    def walk(self, pitch: float) -> np.ndarray:
        """Lag (rad) and slip at every pitch (PITCHES + 1, 2) of the cage, ``pitch`` in rad; zero lag at the first."""
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
