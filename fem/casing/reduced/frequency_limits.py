"""Natural frequencies at elements of size zero, with a band for each mode, from three meshes of one body.

On meshes of sizes h_1 < h_2 < h_3 the frequency of a mode is taken as f = f_0 (1 + c h^p), with an amplitude c of its
own and an order p that all modes share: where the error comes from (edges, seats, thin walls) is the same for all. With
r_i = h_i/h_1 and the changes e_i = f(h_i)/f(h_1) - 1

    e_2 / e_3 = rho(p) = (r_2^p - 1)/(r_3^p - 1),    f_0 = f(h_1) (1 - gamma e_3),    gamma(p) = 1/(r_3^p - 1)

p is that of the median of e_2/e_3, held between 1, below that of any re-entrant edge (1.09 at a right angle: Szabo &
Babuska 1991, Finite Element Analysis, section 10.1), and the order of smooth bodies. What a mode deviates from the
common order by, d = e_2 - rho e_3, is read in the worse of two ways, as an order of its own: its limit is then off by
d (d gamma/d rho). The band is twice the root mean square of that over the modes, each in proportion to its change (at
least the median change). An order of one mode alone is told where its values are monotone; its limit is not used: on
meshes that are made anew for every size it scatters four times as much (rig, 60 modes: 0.76 against 0.15 %).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

LEAST_ORDER = 1.0
WIDTH = 2.0  # of a band, in root mean squares
LEAST_MODES = 3  # from which a common order can be told


class LimitError(ValueError):
    """Meshes that no common order can be drawn from."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyLimits:
    """Limits and bands of the modes of the finest mesh."""

    frequencies: np.ndarray  # (mode,), Hz, on the finest mesh
    order: float  # that all modes share
    orders: np.ndarray  # (mode,) of each alone, nan where its values are not monotone
    limits: np.ndarray  # (mode,), Hz
    bands: np.ndarray  # (mode,), Hz: half width about the limit
    correction: float  # mean of 1 - limit / frequency on the finest mesh

    @property
    def median_band(self) -> float:
        """Half the modes have a narrower band, in parts of their limit."""
        return float(np.median(self.bands / self.limits))

    @property
    def widest_band(self) -> float:
        """In parts of the limit."""
        return float(np.max(self.bands / self.limits))


def frequency_limits(sizes: Sequence[float], frequencies: np.ndarray, *, formal_order: float = 4.0) -> FrequencyLimits:
    """Limits and bands of natural frequencies.

    Parameters
    ----------
    sizes : three element sizes, ascending, in any unit
    frequencies : float (3, mode), Hz, of the same modes; nan where a coarser mesh has no counterpart
    formal_order : of frequencies in a smooth body, the largest that is believed

    Raises
    ------
    LimitError : sizes that do not rise, fewer than three modes with counterparts, or none that changes
    """
    h, f = np.asarray(sizes, float), np.asarray(frequencies, float)
    if h.shape != (3,) or f.ndim != 2 or len(f) != 3 or not (0.0 < h[0] < h[1] < h[2]):
        raise LimitError(f"sizes {h.tolist()} and frequencies {f.shape}: give three rising sizes, a row of modes each")
    logs = np.log(h[1:] / h[0])
    middle, large = f[1:] / f[0] - 1.0
    known = np.isfinite(middle) & np.isfinite(large)
    if known.sum() < LEAST_MODES or not abs(large[known]).max() > 0.0:
        raise LimitError(
            f"{int(known.sum())} modes of the finest mesh have counterparts that differ on both others (least "
            f"{LEAST_MODES}); use smaller elements on all meshes"
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = middle / large
    order = _order(float(np.median(ratios[known & (large != 0.0)])), logs, formal_order)
    share, slope = _share(order, logs), _slope(order, logs)
    usual = float(np.median(abs(large[known])))
    size = np.maximum(abs(np.where(known, large, usual)), usual)
    off = (middle - _ratio(order, logs) * large)[known] / size[known]
    change = np.where(known, large, float(np.mean(large[known])))
    limits = f[0] * (1.0 - share * change)
    bands = WIDTH * abs(slope) * math.sqrt(float(np.mean(off**2))) * size * f[0]
    monotone = known & (middle * (large - middle) > 0.0)
    spread = np.nanmax(f, axis=0) - np.nanmin(f, axis=0)
    bands = np.where(monotone, bands, np.maximum(bands, spread))
    return FrequencyLimits(
        frequencies=f[0],
        order=order,
        orders=np.array([_order(float(one), logs, 2.0 * formal_order) for one in np.where(monotone, ratios, np.nan)]),
        limits=limits,
        bands=bands,
        correction=float(np.mean(1.0 - limits[known] / f[0, known])),
    )


def _ratio(order: float, logs: np.ndarray) -> float:
    return math.expm1(order * logs[0]) / math.expm1(order * logs[1])


def _share(order: float, logs: np.ndarray) -> float:
    return 1.0 / math.expm1(order * logs[1])


def _slope(order: float, logs: np.ndarray) -> float:
    """d gamma / d rho at an order."""
    step = 1e-4
    shares = _share(order + step, logs) - _share(order - step, logs)
    return shares / (_ratio(order + step, logs) - _ratio(order - step, logs))


def _order(ratio: float, logs: np.ndarray, largest: float) -> float:
    """The order of a ratio of changes, which falls with it; nan of nan."""
    if math.isnan(ratio):
        return math.nan
    if ratio >= _ratio(LEAST_ORDER, logs):
        return LEAST_ORDER
    if ratio <= _ratio(largest, logs):
        return largest
    return float(brentq(lambda order: _ratio(order, logs) - ratio, LEAST_ORDER, largest))
