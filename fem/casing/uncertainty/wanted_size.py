"""Element size whose natural frequencies have the error that is asked for, predicted from those of a coarse mesh.

Part of the bands falls with the order of the error, the rest does not (`fem.casing.uncertainty.hexahedral_limits`).
What is predicted is the band that half of the modes have or less.
"""

from __future__ import annotations

import math

import numpy as np

from fem.casing.uncertainty.extrapolation import ExtrapolationError, LowestModes
from fem.casing.uncertainty.frequency_limits import FrequencyLimits

MOST_UNKNOWNS = 400_000  # about 5 GB for the factors
_OF_WALLS = 2.0
_FACTORS = np.arange(1.0, 0.195, -0.02)


def wanted_factor(limits: FrequencyLimits, error: float, trial: LowestModes, coarser: LowestModes) -> float:
    """Factor <= 1 of all element sizes of the trial mesh.

    Parameters
    ----------
    limits : of the trial mesh
    error : median band that is asked for, in parts of the frequencies
    trial, coarser : modes on the trial mesh and on one with larger elements, whose unknowns tell how they grow; with
        elements of the same size, of lower degree, they are taken to grow as in walls one element thick

    Raises
    ------
    ExtrapolationError : the mesh would have more than `MOST_UNKNOWNS`, or no size is enough
    """
    larger = coarser.element_size / trial.element_size
    growth = math.log(trial.unknowns / coarser.unknowns) / math.log(larger) if larger > 1.0 else _OF_WALLS
    enough = [float(factor) for factor in _FACTORS if limits.median_band_at(float(factor)) <= error]
    if not enough:
        left = limits.median_band_at(float(_FACTORS[-1]))
        raise ExtrapolationError(
            f"casing.error: smaller elements do not reach {100 * error:g} %: with a fifth of "
            f"{1000 * trial.element_size:.3g} mm the median uncertainty band is {100 * left:.2g} %. Set more than that"
        )
    factor = enough[0]
    unknowns = trial.unknowns * factor**-growth
    if unknowns > MOST_UNKNOWNS:
        largest = min((trial.unknowns / MOST_UNKNOWNS) ** (1.0 / growth), 1.0)
        raise ExtrapolationError(
            f"casing.error: {100 * error:g} % would need elements of {1000 * factor * trial.element_size:.3g} mm with "
            f"about {unknowns:,.0f} unknowns (limit {MOST_UNKNOWNS:,}, about 5 GB). Set "
            f"{100 * limits.median_band_at(largest):.2g} %, the error with that limit, or more"
        )
    return factor
