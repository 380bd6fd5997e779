"""Features of the time-synchronous average of a signal over the revolutions of a shaft.

The signal is read at even steps of the shaft's own recorded angle, and whole revolutions are averaged: what repeats
with the shaft stays, all else is divided by the root of their number. A revolution has whole orders, so that every
order of the average is one line of its Fourier transform and nothing leaks.

References
----------
McFadden (1987), Mech. Syst. Signal Process. 1(1), 83-95 (average); McFadden (1986), J. Vib. Acoust. 108(2), 165-170
(mesh orders and their sidebands); Stewart (1977), Report MHM/R/10/77, University of Southampton, as given by
Zakrajsek, Townsend & Decker (1993), NASA TM-105950 (residual and difference signal, FM4).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.features.statistics import kurtosis, root_mean_square
from pipelines.orders.order_spectra import OrderError, over_angle
from pipelines.signals.spectrum import amplitudes

FEWEST_REVOLUTIONS = 3  # of an average
MESH_ORDERS = (1, 2, 3)

Meshes = Mapping[int, int]  # number of the stage -> teeth of its gear on the shaft


def synchronous(
    signal: np.ndarray, time: np.ndarray, angle: np.ndarray, shaft: str, meshes: Meshes
) -> dict[str, np.ndarray]:
    """Features (...,) of the average over a shaft's revolutions, in the unit of the signal or without one.

    tsa_rms            root mean square of the average less its mean
    tsa_peak_to_peak   its range
    tsa_kurtosis       its kurtosis, 3 for Gaussian noise
    residual_rms       that of the average without its mean, the first order of the shaft and all orders of its meshes
    fm4                kurtosis of the residual without the first sidebands of the mesh orders, too (difference signal)
    stage_I_mesh_N     peak amplitude at order N z of stage I; `_lower` and `_upper` at N z - 1 and N z + 1

    All are NaN where the shaft turns less than FEWEST_REVOLUTIONS times; orders above half the sampling rate, too.

    Parameters
    ----------
    signal, time, angle : (..., n) signal, (n,) time (s) and angle of the shaft (rad)
    shaft : its name
    meshes : teeth of the gears on it
    """
    shape = signal.shape[:-1]
    average, orders = _average(signal.reshape(-1, signal.shape[-1]), time, angle, shaft)
    found = {name: values.reshape(shape) for name, values in _shape_features(average, orders, meshes).items()}
    lines = amplitudes(average.T, "boxcar")
    for stage, teeth in meshes.items():
        for number in MESH_ORDERS:
            for suffix, order in (("", 0), ("_lower", -1), ("_upper", 1)):
                at = number * teeth + order
                value = lines[at] if at < orders else np.full(len(average), np.nan)
                found[f"stage_{stage}_mesh_{number}{suffix}"] = value.reshape(shape)
    return found if orders else {name: np.full(shape, np.nan) for name in found}


def _average(signal: np.ndarray, time: np.ndarray, angle: np.ndarray, shaft: str) -> tuple[np.ndarray, int]:
    """Averages (channel, place in the revolution) and how many orders they hold; NaN where the shaft hardly turns."""
    try:
        turned = over_angle(signal.T, time, angle, shaft=shaft, revolutions=FEWEST_REVOLUTIONS)
    except OrderError:
        return np.full((len(signal), 2), np.nan), 0
    whole = len(turned.values) // turned.per_turn
    laid = turned.values[: whole * turned.per_turn].reshape(whole, turned.per_turn, -1)
    return laid.mean(axis=0).T, int(turned.samples / 2)


def _shape_features(average: np.ndarray, orders: int, meshes: Meshes) -> dict[str, np.ndarray]:
    of_mesh = {number * teeth for teeth in meshes.values() for number in range(1, orders // teeth + 1)}
    beside = {order + side for order in of_mesh for side in (-1, 1)}
    return {
        "tsa_rms": average.std(axis=-1),
        "tsa_peak_to_peak": np.ptp(average, axis=-1),
        "tsa_kurtosis": kurtosis(average),
        "residual_rms": root_mean_square(_without(average, {0, 1} | of_mesh)),
        "fm4": kurtosis(_without(average, {0, 1} | of_mesh | beside)),
    }


def _without(average: np.ndarray, orders: set[int]) -> np.ndarray:
    """Averages less some of their orders."""
    lines = np.fft.rfft(average, axis=-1)
    lines[:, [order for order in orders if order < lines.shape[1]]] = 0.0
    return np.fft.irfft(lines, average.shape[-1], axis=-1)
