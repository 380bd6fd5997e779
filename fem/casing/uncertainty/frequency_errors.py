"""What is known of the errors of a casing's natural frequencies after its stiffness was extrapolated.

The limit of a mode at elements of size zero (`fem.casing.uncertainty.frequency_limits`) lies beside its frequency in
the corrected body, because one factor corrects all modes: that is its mean error. Its band, twice a root mean square,
gives the standard deviation.

Modes that were not compared, and the flexibility of the seats that the highest of them make, have the correction but no
limit of their own. They share one error whose standard deviation is half of the correction: at the rig's seats the
correction of the flexibility was 1.6 % where 0.8 % were missing (`fem.casing.uncertainty.extrapolation`). Each of them
spreads about it as the compared ones do in the mean.
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

    `means` and `spreads` (standard deviations) belong to the modes from number `first` on that were compared; modes
    below it are motions on mounts, without error. All others share an error of standard deviation `rest` and spread
    about it by `rest_spread`.
    """

    first: int
    means: np.ndarray  # (mode,)
    spreads: np.ndarray  # (mode,)
    rest: float
    rest_spread: float


def frequency_errors(limits: FrequencyLimits, first: int = 0) -> FrequencyErrors:
    """The errors of the body whose stiffness was corrected by `limits`.

    Parameters
    ----------
    limits : of the lowest modes, motions on mounts left out
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
