"""Frequencies extrapolated to zero element size with uncertainty bands, from three meshes of one body (Richardson).

On meshes of sizes h_1 < h_2 < h_3 the frequency of a mode is assumed to be f = f_0 (1 + c g(h)). The amplitude c
depends on the mode. All modes share the function g, as their errors have the same sources (edges, seats, thin walls).
With r_i = h_i/h_1 and the changes e_i = f(h_i)/f(h_1) - 1

    e_2 / e_3 = rho = (g(r_2) - g(1))/(g(r_3) - g(1)),    f_0 = f(h_1) (1 - gamma e_3),    gamma = g(1)/(g(r_3) - g(1))

Two functions g fit the median of e_2/e_3, and hence the three frequencies, with different extrapolated values:

- one power, g = h^p, with p between that of a re-entrant edge (1.09 at a right angle: Szabo & Babuska 1991, Finite
  Element Analysis, section 10.1) and that of smooth bodies;
- these two orders together, g = theta h^1.09 + (1 - theta) h^4. The slowly decreasing term is small on the coarse
  meshes but dominates on fine ones, so this extrapolated frequency is lower.

Three frequencies cannot distinguish them. The lower one is used, as its orders are those of theory. The band extends
upwards to the other, and downwards to that of a mode with errors from edges alone, h^1.09, because not all modes have
the same sources of error (for example bending of a tube and motions of the rails under it).

On a small housing with walls of 10 mm (tetrahedra of 17.6, 22.9 and 29.9 mm, 60 modes to 9 kHz, against hexahedra of 16
mm with three layers at the edges) the error is 1.08 +- 0.34 % with one power and 0.25 +- 0.39 % with both orders. The
deviation of a mode from the common g, d = e_2 - rho e_3, is mesh scatter. The band includes twice its standard
deviation in the extrapolated frequency: the larger value for equal scatter on all meshes, or for scatter in proportion
to their errors. The order of a single mode is given where its values are monotone, but not used: its extrapolated
frequency scatters four times as much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.numerics.root_finding import brentq

EDGE_ORDER = 1.09  # of a right-angled re-entrant edge
SMOOTH_ORDER = 4.0  # of a smooth body, the upper bound that is accepted
WIDTH = 2.0  # of a band, in standard deviations
LEAST_MODES = 3  # least number of modes for a common order


class LimitError(ValueError):
    """No common order can be determined from the meshes."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyLimits:
    """Extrapolated frequencies and uncertainty bands of the modes of the finest mesh."""

    frequencies: np.ndarray  # (mode,), Hz, on the finest mesh
    order: float  # of the part of the error that decreases with the element size
    orders: np.ndarray  # (mode,) of each mode; nan unless it has three monotone values
    limits: np.ndarray  # (mode,), Hz: extrapolated frequencies
    bands: np.ndarray  # (mode,), Hz: half width about these
    fixed_bands: np.ndarray  # (mode,), Hz: part of them independent of the element size
    correction: float  # mean of 1 - limit / frequency on the finest mesh

    def median_band_at(self, factor: float) -> float:
        """Median relative band predicted for elements smaller by a factor."""
        rest = (self.bands - self.fixed_bands) * factor**self.order
        return float(np.median((self.fixed_bands + rest) / self.limits))


class Changes:
    """Checked differences between the frequencies of two or more meshes.

    Parameters
    ----------
    sizes : element sizes, ascending, in any unit
    frequencies : (size, mode), Hz, of the same modes; nan where a coarser mesh has no counterpart
    formal_order : of frequencies in a smooth body, the upper bound that is accepted

    Attributes
    ----------
    middle, large : changes (mode,) to the second and to the largest size, e_2 and e_3 of three meshes
    known, monotone : bool (mode,), known on all meshes; changes from mesh to mesh have the same sign
    scale : |`large`| (mode,), at least its median

    Raises
    ------
    LimitError : fewer than three modes with counterparts, or no change of any frequency
    """

    def __init__(self, sizes: Sequence[float], frequencies: np.ndarray, formal_order: float = SMOOTH_ORDER) -> None:
        self.sizes, self.formal_order = np.asarray(sizes, float), formal_order
        self.frequencies = f = np.asarray(frequencies, float)
        self.middle, self.large = f[1] / f[0] - 1.0, f[-1] / f[0] - 1.0
        self.known = np.isfinite(f).all(axis=0)
        if self.known.sum() < LEAST_MODES or not abs(self.large[self.known]).max() > 0.0:
            raise LimitError(
                f"{int(self.known.sum())} modes of the finest mesh have counterparts of other frequency on the other "
                f"meshes, at least {LEAST_MODES} are needed; use smaller elements on all meshes"
            )
        self.monotone = self.known & (np.diff(f, axis=0) * self.large > 0.0).all(axis=0)
        usual = float(np.median(abs(self.large[self.known])))
        self.scale = np.maximum(abs(np.where(self.known, self.large, usual)), usual)

    def limits(
        self, order: float, *, share: float, reach: float, walls: tuple[float, float] = (0.0, 0.0)
    ) -> FrequencyLimits:
        """Limits f (1 - w - share `large`) and bands f (dw + reach `scale`); non-monotone modes: at least their spread.

        Parameters
        ----------
        order : order in the element size of the part that depends on it
        share, reach : factors of `large` and `scale`
        walls : range w - dw to w + dw of the part that does not depend on it
        """
        f, known = self.frequencies, self.known
        change = np.where(known, self.large, float(np.mean(self.large[known])))
        limits = f[0] * (1.0 - 0.5 * sum(walls) - share * change)
        fixed = 0.5 * (walls[1] - walls[0]) * f[0]
        bands = fixed + reach * self.scale * f[0]
        return FrequencyLimits(
            frequencies=f[0],
            order=order,
            orders=self._orders() if len(f) == 3 else np.full(f.shape[1], np.nan),
            limits=limits,
            bands=np.where(self.monotone, bands, np.maximum(bands, np.nanmax(f, axis=0) - np.nanmin(f, axis=0))),
            fixed_bands=fixed,
            correction=float(np.mean(1.0 - limits[known] / f[0, known])),
        )

    def _orders(self) -> np.ndarray:
        """Order (mode,) of every mode; nan where it is not monotone."""
        logs = np.log(self.sizes[1:] / self.sizes[0])
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = np.where(self.monotone, self.middle / self.large, np.nan)
        return np.array([_order(float(one), logs, 2.0 * self.formal_order) for one in ratios])


def frequency_limits(
    sizes: Sequence[float],
    frequencies: np.ndarray,
    *,
    formal_order: float = SMOOTH_ORDER,
    walls: tuple[float, float] = (0.0, 0.0),
) -> FrequencyLimits:
    """Extrapolated natural frequencies and uncertainty bands of tetrahedra.

    Parameters
    ----------
    sizes, frequencies, formal_order : those of `Changes`
    walls : range of the relative error that does not depend on the size

    Raises
    ------
    LimitError : as `Changes`, or other than three sizes
    """
    if len(sizes) != 3:
        raise LimitError(f"{len(sizes)} sizes: three are needed for a common order. Set three")
    changes = Changes(sizes, frequencies, formal_order)
    logs, known = np.log(changes.sizes[1:] / changes.sizes[0]), changes.known
    middle, large = changes.middle, changes.large
    order = _order(float(np.median((middle / large)[known & (large != 0.0)])), logs, formal_order)
    ratio = _ratio(order, logs)
    one, both = share_at(order, logs[1]), _mixed_share(ratio, logs, formal_order)
    scatter = math.sqrt(float(np.mean(((middle - ratio * large)[known] / changes.scale[known]) ** 2)))
    apart = max(abs(both - one), share_at(EDGE_ORDER, logs[1]) - both)
    return changes.limits(order, share=both, reach=apart + WIDTH * _gain(order, both, logs) * scatter, walls=walls)


def share_at(order: float, log_ratio: float) -> float:
    """gamma of one power: the error over the change to elements whose size is larger by exp(log_ratio)."""
    return 1.0 / math.expm1(order * log_ratio)


def _ratio(order: float, logs: np.ndarray) -> float:
    return math.expm1(order * logs[0]) / math.expm1(order * logs[1])


def _mixed_share(ratio: float, logs: np.ndarray, formal_order: float) -> float:
    """gamma of two orders together, for the same ratio of changes."""
    slow, fast = np.expm1(EDGE_ORDER * logs), np.expm1(formal_order * logs)
    of_slow, of_fast = slow[0] - ratio * slow[1], ratio * fast[1] - fast[0]
    if of_slow + of_fast <= 0.0:
        return share_at(EDGE_ORDER, logs[1])
    theta = min(max(of_fast / (of_slow + of_fast), 0.0), 1.0)
    return 1.0 / float(theta * slow[1] + (1.0 - theta) * fast[1])


def _gain(order: float, share: float, logs: np.ndarray) -> float:
    """Standard deviation of an extrapolated frequency over that of the deviations d, by scatter of the three meshes."""
    ratio, gains = _ratio(order, logs), []
    for middle, large in (np.ones(2), np.exp(order * logs)):
        of_limit = math.hypot(1.0 + share, share * large)
        gains.append(of_limit / math.sqrt(middle**2 + (1.0 - ratio) ** 2 + (ratio * large) ** 2))
    return max(gains)


def _order(ratio: float, logs: np.ndarray, largest: float) -> float:
    """The order that gives a ratio of changes; the ratio decreases with the order; nan for nan."""
    if math.isnan(ratio):
        return math.nan
    if ratio >= _ratio(EDGE_ORDER, logs):
        return EDGE_ORDER
    if ratio <= _ratio(largest, logs):
        return largest
    return float(brentq(lambda order: _ratio(order, logs) - ratio, EDGE_ORDER, largest))
