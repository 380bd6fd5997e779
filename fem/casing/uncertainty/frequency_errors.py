"""Remaining errors of the natural frequencies of a casing after extrapolation of its stiffness.

One factor corrects all modes, so the extrapolated frequency of a mode (`fem.casing.uncertainty.frequency_limits`)
differs from its frequency in the corrected body. This difference is its mean error. Its band is twice the standard
deviation.

Modes above those compared, and the flexibility of the seats that they represent, are corrected without an extrapolated
frequency. They share one error whose standard deviation is half of the correction: at the seats of the rig a correction
of 1.6 % compared with a true one of 0.8 % (`fem.casing.uncertainty.extrapolation`). Their individual errors have the
root-mean-square standard deviation of the compared modes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.casing.uncertainty.frequency_limits import WIDTH, FrequencyLimits

REST_SHARE = 0.5  # of the correction


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyErrors:
    """Relative errors of natural frequencies: true frequency = frequency (1 + error).

    `means` and `spreads` (standard deviations) belong to the compared modes, from number `first` on; modes below it are
    motions on mounts, without error. All others share an error of standard deviation `rest`, and their individual
    errors have the standard deviation `rest_spread`.
    """

    first: int
    means: np.ndarray  # (mode,)
    spreads: np.ndarray  # (mode,)
    rest: float
    rest_spread: float


def frequency_errors(limits: FrequencyLimits, first: int = 0) -> FrequencyErrors:
    """The frequency errors of a body whose stiffness was corrected by `limits`.

    Parameters
    ----------
    limits : of the lowest modes, without motions on mounts
    first : number of the motions on mounts, 6 on springs
    """
    corrected = limits.frequencies * (1.0 - limits.correction)
    spreads = limits.bands / WIDTH / corrected
    return FrequencyErrors(
        first=first,
        means=limits.limits / corrected - 1.0,
        spreads=spreads,
        rest=REST_SHARE * abs(limits.correction),
        rest_spread=math.sqrt(float(np.mean(spreads**2))),
    )
