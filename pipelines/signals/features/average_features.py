"""Features of the time-synchronous average of a shaft and of its gears.

The average is computed in `pipelines.signals.features.synchronous_averages`; the
formulae are in `pipelines.signals.features.definitions`.
"""

from __future__ import annotations

import numpy as np

from pipelines.signals.features.statistics import kurtosis, root_mean_square
from pipelines.signals.features.synchronous_averages import Average

MESH_ORDERS = (1, 2, 3)
RATIO_SIDEBANDS = 6  # on each side, of the sideband ratio
SIDES = (("", 0), ("_lower", -1), ("_upper", 1))


def synchronous(average: Average) -> dict[str, np.ndarray]:
    """Features (channel,) of an average, which are those of its shaft or of all gears on it."""
    difference = average.difference
    return {
        "tsa_rms": average.values.std(axis=-1),
        "tsa_peak_to_peak": np.ptp(average.values, axis=-1),
        "tsa_kurtosis": kurtosis(average.values),
        "residual_rms": root_mean_square(average.residual),
        "difference_rms": root_mean_square(difference),
        "fm4": kurtosis(difference),
    }


def meshing(average: Average, teeth: int) -> dict[str, np.ndarray]:
    """Features (channel,) of the mesh orders of a gear; orders beyond half of the sampling rate are NaN, 0 in sums."""
    found = {
        f"mesh_{number}{suffix}": average.amplitude(number * teeth + side)
        for number in MESH_ORDERS
        for suffix, side in SIDES
    }
    orders = np.nansum([found[f"mesh_{number}"] for number in MESH_ORDERS], axis=0)
    steps = [sign * side for side in range(1, RATIO_SIDEBANDS + 1) for sign in (-1, 1) if teeth > side]
    sidebands = np.nansum([average.amplitude(teeth + step) for step in steps], axis=0)
    ratios = {"fm0": np.ptp(average.values, axis=-1) / orders, "sideband_ratio": sidebands / found["mesh_1"]}
    return found | ratios
