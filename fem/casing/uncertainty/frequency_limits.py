"""Natural frequencies at elements of size zero, with a band for each mode, from three meshes of one body.

On meshes of sizes h_1 < h_2 < h_3 the frequency of a mode is taken as f = f_0 (1 + c g(h)), with an amplitude c of its
own and a law g that all modes share: where the error comes from (edges, seats, thin walls) is the same for all. With
r_i = h_i/h_1 and the changes e_i = f(h_i)/f(h_1) - 1

    e_2 / e_3 = rho = (g(r_2) - g(1))/(g(r_3) - g(1)),    f_0 = f(h_1) (1 - gamma e_3),    gamma = g(1)/(g(r_3) - g(1))

The median of e_2/e_3 can be read in two ways that give the same three frequencies and different limits:

- one power, g = h^p, with p between that of a re-entrant edge (1.09 at a right angle: Szabo & Babuska 1991, Finite
  Element Analysis, section 10.1) and that of smooth bodies;
- these two orders together, g = theta h^1.09 + (1 - theta) h^4. What falls slowly is small on the coarse meshes and
  most of what is left on the fine ones, so this limit lies lower.

Nothing in three frequencies tells them apart. The limit is the lower one, whose orders are those of theory. The band
reaches to the other, and below to the limit of a mode whose error comes from edges alone, h^1.09: where it comes from
is the same for most modes, not for all (in a tube on rails, those that bend the tube and those that move the rails).
On a small housing with walls of 10 mm (tetrahedra of 17.6, 22.9 and 29.9 mm, 60 modes to 9 kHz, against hexahedra of
16 mm with three layers at the edges) one power leaves 1.08 +- 0.34 %, both orders 0.25 +- 0.39 %. What a mode
deviates from the common law by, d = e_2 - rho e_3, is scatter of the three meshes. It adds to the band twice the
standard deviation that it leaves in the limit, the larger one of scatter that is the same on all meshes and of
scatter in proportion to their errors. An order of one mode alone is told where its values are monotone; its limit is
not used: on meshes that are made anew for every size it scatters four times as much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.numerics.root import brentq

EDGE_ORDER = 1.09  # of a right-angled re-entrant edge
SMOOTH_ORDER = 4.0  # of a smooth body, the largest that is believed
WIDTH = 2.0  # of a band, in standard deviations
LEAST_MODES = 3  # from which a common order can be told


class LimitError(ValueError):
    """Meshes that no common order can be drawn from."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyLimits:
    """Limits and bands of the modes of the finest mesh."""

    frequencies: np.ndarray  # (mode,), Hz, on the finest mesh
    order: float  # of what smaller elements take off all modes
    orders: np.ndarray  # (mode,) of each alone, nan where its values are not monotone or not three
    limits: np.ndarray  # (mode,), Hz
    bands: np.ndarray  # (mode,), Hz: half width about the limit
    fixed_bands: np.ndarray  # (mode,), Hz: part of them that smaller elements leave as it is
    correction: float  # mean of 1 - limit / frequency on the finest mesh

    def median_band_at(self, factor: float) -> float:
        """Median band, in parts of the limit, that elements smaller by a factor would have."""
        rest = (self.bands - self.fixed_bands) * factor**self.order
        return float(np.median((self.fixed_bands + rest) / self.limits))

    @property
    def median_band(self) -> float:
        """Half the modes have a narrower band, in parts of their limit."""
        return float(np.median(self.bands / self.limits))

    @property
    def widest_band(self) -> float:
        """In parts of the limit."""
        return float(np.max(self.bands / self.limits))


@dataclass(frozen=True, eq=False)
class Changes:
    """How the frequencies of two or more meshes differ, read and checked.

    Parameters
    ----------
    sizes : element sizes, ascending, in any unit
    frequencies : float (size, mode), Hz, of the same modes; nan where a coarser mesh has no counterpart
    formal_order : of frequencies in a smooth body, the largest that is believed

    Raises
    ------
    LimitError : sizes that do not rise, fewer than three modes with counterparts, or none that changes
    """

    sizes: np.ndarray
    frequencies: np.ndarray
    formal_order: float = SMOOTH_ORDER

    def __post_init__(self) -> None:
        h, f = self.sizes, self.frequencies
        if len(h) < 2 or f.ndim != 2 or len(f) != len(h) or not (h[0] > 0.0 and (np.diff(h) > 0.0).all()):
            raise LimitError(f"sizes {h.tolist()} and frequencies {f.shape}: give rising sizes, a row of modes each")
        if self.known.sum() < LEAST_MODES or not abs(self.large[self.known]).max() > 0.0:
            raise LimitError(
                f"{int(self.known.sum())} modes of the finest mesh have counterparts that differ on the others (least "
                f"{LEAST_MODES}); use smaller elements on all meshes"
            )

    @property
    def middle(self) -> np.ndarray:
        """e_2 (mode,) of three meshes."""
        return np.asarray(self.frequencies[1] / self.frequencies[0] - 1.0)

    @property
    def large(self) -> np.ndarray:
        """The change (mode,) to the largest size, e_3 of three meshes."""
        return np.asarray(self.frequencies[-1] / self.frequencies[0] - 1.0)

    @property
    def known(self) -> np.ndarray:
        """Bool (mode,): on all meshes."""
        return np.asarray(np.isfinite(self.frequencies).all(axis=0))

    @property
    def monotone(self) -> np.ndarray:
        """Bool (mode,): from mesh to mesh in one direction."""
        steps = np.diff(self.frequencies, axis=0)
        return np.asarray(self.known & (steps * self.large > 0.0).all(axis=0))

    @property
    def scale(self) -> np.ndarray:
        """|`large`| (mode,), at least its median."""
        usual = float(np.median(abs(self.large[self.known])))
        return np.maximum(abs(np.where(self.known, self.large, usual)), usual)

    def limits(
        self, order: float, *, share: float, reach: float, walls: tuple[float, float] = (0.0, 0.0)
    ) -> FrequencyLimits:
        """Limits f (1 - w - share `large`) and bands f (dw + reach `scale`), at least the spread where not monotone.

        Parameters
        ----------
        order : with which smaller elements change what depends on their size
        share, reach : of `large`
        walls : least and most of what does not, w - dw and w + dw
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
        """Of every mode alone, nan where it is not monotone."""
        logs = np.log(self.sizes[1:] / self.sizes[0])
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = np.where(self.monotone, self.middle / self.large, np.nan)
        return np.array([_order(float(one), logs, 2.0 * self.formal_order) for one in ratios])


def frequency_limits(
    sizes: Sequence[float], frequencies: np.ndarray, *, formal_order: float = SMOOTH_ORDER
) -> FrequencyLimits:
    """Limits and bands of natural frequencies of tetrahedra.

    Parameters
    ----------
    sizes, frequencies, formal_order : those of `Changes`

    Raises
    ------
    LimitError : as `Changes`, or other than three sizes
    """
    if len(sizes) != 3:
        raise LimitError(f"{len(sizes)} sizes: three are needed for a common order. Set three")
    changes = Changes(np.asarray(sizes, float), np.asarray(frequencies, float), formal_order)
    logs, known = np.log(changes.sizes[1:] / changes.sizes[0]), changes.known
    middle, large = changes.middle, changes.large
    order = _order(float(np.median((middle / large)[known & (large != 0.0)])), logs, formal_order)
    ratio = _ratio(order, logs)
    one, both = share_at(order, logs[1]), _mixed_share(ratio, logs, formal_order)
    scatter = math.sqrt(float(np.mean(((middle - ratio * large)[known] / changes.scale[known]) ** 2)))
    apart = max(abs(both - one), share_at(EDGE_ORDER, logs[1]) - both)
    return changes.limits(order, share=both, reach=apart + WIDTH * _gain(order, both, logs) * scatter)


def share_at(order: float, log_ratio: float) -> float:
    """gamma of one power: the error over the change to elements whose size is larger by exp(log_ratio)."""
    return 1.0 / math.expm1(order * log_ratio)


def _ratio(order: float, logs: np.ndarray) -> float:
    return math.expm1(order * logs[0]) / math.expm1(order * logs[1])


def _mixed_share(ratio: float, logs: np.ndarray, formal_order: float) -> float:
    """gamma of two orders together that give the same ratio of changes."""
    slow, fast = np.expm1(EDGE_ORDER * logs), np.expm1(formal_order * logs)
    of_slow, of_fast = slow[0] - ratio * slow[1], ratio * fast[1] - fast[0]
    if of_slow + of_fast <= 0.0:
        return share_at(EDGE_ORDER, logs[1])
    theta = min(max(of_fast / (of_slow + of_fast), 0.0), 1.0)
    return 1.0 / float(theta * slow[1] + (1.0 - theta) * fast[1])


def _gain(order: float, share: float, logs: np.ndarray) -> float:
    """Standard deviation of a limit over that of the deviations, by scatter of the three meshes."""
    ratio, gains = _ratio(order, logs), []
    for middle, large in (np.ones(2), np.exp(order * logs)):
        of_limit = math.hypot(1.0 + share, share * large)
        gains.append(of_limit / math.sqrt(middle**2 + (1.0 - ratio) ** 2 + (ratio * large) ** 2))
    return max(gains)


def _order(ratio: float, logs: np.ndarray, largest: float) -> float:
    """The order of a ratio of changes, which falls with it; nan of nan."""
    if math.isnan(ratio):
        return math.nan
    if ratio >= _ratio(EDGE_ORDER, logs):
        return EDGE_ORDER
    if ratio <= _ratio(largest, logs):
        return largest
    return float(brentq(lambda order: _ratio(order, logs) - ratio, EDGE_ORDER, largest))
