"""Features of the time-synchronous average of a shaft.

References
----------
Stewart (1977), Report MHM/R/10/77, University of Southampton, as given by Zakrajsek, Townsend & Decker (1993),
NASA TM-105950 (FM0, FM4, residual and difference signal); McFadden (1986), J. Vib. Acoust. 108(2), 165-170 (mesh orders
and their sidebands); Hanna, Hatch, Kalb, Weiss & Luo (2011), patent US 7,912,659, and Pattabiraman, Parthasarathy &
O'Connor (2010), Orbit 30(3) (sideband energy ratio: six sidebands on each side over the mesh order).
"""

from __future__ import annotations

import numpy as np

from pipelines.signals.features.average import Average
from pipelines.signals.features.statistics import kurtosis, root_mean_square

MESH_ORDERS = (1, 2, 3)
RATIO_SIDEBANDS = 6  # on each side, of the sideband ratio
SIDES = (("", 0), ("_lower", -1), ("_upper", 1))


def synchronous(average: Average) -> dict[str, np.ndarray]:
    """Features (channel,) of an average, in the unit of the signal or without one.

    tsa_rms                 root mean square of the average less its mean
    tsa_peak_to_peak        its range
    tsa_kurtosis            its kurtosis, 3 for Gaussian noise
    residual_rms            of the residual signal, see `pipelines.signals.features.average`
    difference_rms          of the difference signal
    fm4                     kurtosis of the difference signal
    order_1, order_2        peak amplitudes of the orders of the shaft
    stage_I_mesh_N          peak amplitude at order N z of pair I; `_lower` and `_upper` at N z - 1 and N z + 1
    stage_I_fm0             range of the average over the sum of the amplitudes at N z, N = 1, 2, 3
    stage_I_sideband_ratio  sum of the amplitudes at z +- 1 ... z +- 6 over that at z

    Orders beyond half of the sampling rate are NaN, and left out of sums.
    """
    difference = average.difference
    found = {
        "tsa_rms": average.values.std(axis=-1),
        "tsa_peak_to_peak": np.ptp(average.values, axis=-1),
        "tsa_kurtosis": kurtosis(average.values),
        "residual_rms": root_mean_square(average.residual),
        "difference_rms": root_mean_square(difference),
        "fm4": kurtosis(difference),
        "order_1": average.amplitude(1),
        "order_2": average.amplitude(2),
    }
    for stage, teeth in average.meshes.items():
        meshing = [average.amplitude(number * teeth) for number in MESH_ORDERS]
        for number in MESH_ORDERS:
            for suffix, side in SIDES:
                found[f"stage_{stage}_mesh_{number}{suffix}"] = average.amplitude(number * teeth + side)
        sides = range(1, RATIO_SIDEBANDS + 1)
        sidebands = [average.amplitude(teeth + sign * side) for side in sides for sign in (-1, 1) if teeth > side]
        found[f"stage_{stage}_fm0"] = found["tsa_peak_to_peak"] / np.nansum(meshing, axis=0)
        found[f"stage_{stage}_sideband_ratio"] = np.nansum(sidebands, axis=0) / meshing[0]
    return found
