"""Convergence of a quantity under refinement: observed order, Richardson value, grid convergence index.

With the values v_1, v_2, v_3 at the sizes h_1 < h_2 < h_3 and r_21 = h_2/h_1, r_32 = h_3/h_2, the observed order p of
v = v_0 + c h^p solves

    p = |ln|e_32/e_21| + ln((r_21^p - s)/(r_32^p - s))| / ln r_21,    e_ij = v_i - v_j, s = sign(e_32/e_21),

the Richardson value is v_0 = v_1 + (v_1 - v_2)/(r_21^p - 1). The half width of the uncertainty band of a value at the
size h is the grid convergence index, 1.25 |v_0 - v_1| (h/h_1)^p in the units of v; p is limited to the formal order
there. If the values do not converge monotonically there is no order. The half width is then three times the largest
change between neighbouring levels.

References
----------
Roache (1998), Verification and Validation in Computational Science and Engineering, ch. 5; Celik et al. (2008),
Procedure for estimation and reporting of uncertainty due to discretization in CFD applications, J. Fluids Eng. 130,
078001.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

SAFETY = 1.25  # factor of the band if an order was observed on three levels
CAUTION = 3.0  # factor of the band otherwise
ROUND_OFF = 1e-12  # relative change below which two levels are equal
LARGEST_ORDER = 16.0


class ConvergenceError(ValueError):
    """Levels that are not sufficient for a convergence study."""


@dataclass(frozen=True, kw_only=True)
class Convergence:
    """A quantity at several sizes, the finest first; `order` is None unless the values converge monotonically."""

    sizes: tuple[float, ...]
    values: tuple[float, ...]
    kind: str  # "monotone" | "oscillating" | "diverging" | "unchanged"
    order: float | None
    limit: float  # Richardson value if there is an order, else the finest value
    bands: tuple[float, ...]  # half width of the uncertainty band of each value

    @property
    def errors(self) -> tuple[float, ...]:
        """Distance of every value from the limit, relative to the limit (absolute if that is 0)."""
        scale = abs(self.limit) or 1.0
        return tuple(abs(value - self.limit) / scale for value in self.values)

    @property
    def relative_bands(self) -> tuple[float, ...]:
        """The bands relative to the limit (absolute if that is 0)."""
        scale = abs(self.limit) or 1.0
        return tuple(band / scale for band in self.bands)


def study(sizes: Sequence[float], values: Sequence[float], formal_order: float | None = None) -> Convergence:
    """Order, limit and bands from the three finest levels; the limit and the bands also apply to further levels.

    Parameters
    ----------
    sizes : element size, step, ... of each of three levels or more, any unit, the finest first
    values : the quantity at each level
    formal_order : upper bound of the order in the bands; it does not limit the observed order

    Raises
    ------
    ConvergenceError : values that are not finite
    """
    if not all(math.isfinite(v) for v in values):
        raise ConvergenceError(f"values {list(values)} are not all finite; the coarsest level may be too coarse")
    h, v = tuple(sizes), tuple(values)
    kind, order = _order(h[:3], v[:3])
    if kind == "unchanged":
        return Convergence(sizes=h, values=v, kind=kind, order=None, limit=v[0], bands=tuple(abs(x - v[0]) for x in v))
    if order is None:
        step = CAUTION * max(abs(a - b) for a, b in zip(v, v[1:], strict=False))
        return Convergence(sizes=h, values=v, kind=kind, order=None, limit=v[0], bands=(step,) * len(v))
    limit = _limit(h, v, order)
    assumed = order if formal_order is None else min(order, formal_order)
    finest = SAFETY * abs(_limit(h, v, assumed) - v[0])
    bands = tuple(finest * (size / h[0]) ** assumed for size in h)
    return Convergence(sizes=h, values=v, kind=kind, order=order, limit=limit, bands=bands)


def _limit(h: Sequence[float], v: Sequence[float], order: float) -> float:
    return v[0] + (v[0] - v[1]) / math.expm1(order * math.log(h[1] / h[0]))


def _order(h: Sequence[float], v: Sequence[float]) -> tuple[str, float | None]:
    """Kind of convergence of the three finest values, and their order if it is monotone."""
    from scipy.optimize import brentq

    fine, coarse = v[1] - v[0], v[2] - v[1]
    scale = max(abs(x) for x in v)
    if abs(fine) <= ROUND_OFF * scale:
        return "unchanged", None
    if coarse * fine < 0:
        return "oscillating", None
    if coarse == 0:
        return "diverging", None
    low, high = 1e-6, LARGEST_ORDER
    if _excess(h, coarse / fine, low) > 0:  # the changes grow, or fall more slowly than those of a logarithm
        return "diverging", None
    if _excess(h, coarse / fine, high) < 0:
        return "monotone", LARGEST_ORDER
    return "monotone", float(brentq(lambda order: _excess(h, coarse / fine, order), low, high))


def _excess(h: Sequence[float], ratio: float, order: float) -> float:
    """(h_3^p - h_2^p)/(h_2^p - h_1^p) less the observed ratio of changes; increases with p."""
    r21, r32 = math.log(h[1] / h[0]), math.log(h[2] / h[1])
    return math.exp(order * r21) * math.expm1(order * r32) / math.expm1(order * r21) - ratio
