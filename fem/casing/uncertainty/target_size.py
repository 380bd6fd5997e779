"""Inverse problem: the element size for a target error of the natural frequencies, predicted from a coarse mesh.

One part of the bands decreases with the order of the error, the other is constant
(`fem.casing.uncertainty.limits_by_element`). The prediction is that of the median band.
"""

from __future__ import annotations

import math

import numpy as np

from fem.casing.uncertainty.extrapolation import ExtrapolationError, LowestModes
from fem.casing.uncertainty.frequency_limits import FrequencyLimits

MOST_UNKNOWNS = 400_000  # about 5 GB for the factors
_OF_WALLS = 2.0
_FACTORS = np.arange(1.0, 0.195, -0.02)


def target_factor(limits: FrequencyLimits, error: float, trial: LowestModes, coarser: LowestModes) -> float:
    """Factor <= 1 of all element sizes of the trial mesh.

    Parameters
    ----------
    limits : of the trial mesh
    error : target median band, relative to the frequencies
    trial, coarser : modes on the trial mesh and on one with larger elements, whose unknowns give their growth; for
        elements of the same size and lower degree, growth as in walls one element thick is assumed

    Raises
    ------
    ExtrapolationError : the mesh would have more than `MOST_UNKNOWNS`, or no size is sufficient
    """
    larger = coarser.element_size / trial.element_size
    growth = math.log(trial.unknowns / coarser.unknowns) / math.log(larger) if larger > 1.0 else _OF_WALLS
    enough = [float(factor) for factor in _FACTORS if limits.median_band_at(float(factor)) <= error]
    if not enough:
        left = limits.median_band_at(float(_FACTORS[-1]))
        raise ExtrapolationError(
            f"casing.error: smaller elements do not reach {100 * error:g} %. With the smallest size, "
            f"{1000 * _FACTORS[-1] * trial.element_size:.3g} mm, the median uncertainty band is {100 * left:.2g} %. "
            "Set more"
        )
    factor = enough[0]
    unknowns = trial.unknowns * factor**-growth
    if unknowns > MOST_UNKNOWNS:
        largest = min((float(f) for f in _FACTORS if trial.unknowns * f**-growth <= MOST_UNKNOWNS), default=1.0)
        raise ExtrapolationError(
            f"casing.error: {100 * error:g} % would need elements of {1000 * factor * trial.element_size:.3g} mm with "
            f"about {unknowns:,.0f} unknowns (limit {MOST_UNKNOWNS:,}, about 5 GB). Set "
            f"{math.ceil(1e4 * limits.median_band_at(largest)) / 100:g} %, the error with that limit, or more"
        )
    return factor
