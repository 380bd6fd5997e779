"""A bolt with its clamped parts: stiffness by the deformation cone of VDI 2230, and the closed contact area.

The pressure under the head (bearing diameter d_W) spreads into the clamped parts as a cone of half angle phi, from both
ends of a through bolt (w = 1) or from the head of a bolt in a tapped hole (w = 2). Where the cone reaches the outer
diameter D_A of the parts, it continues as a sleeve. With the hole d_h and the clamped length l_K their resilience is

    delta_P = (2/w) delta_V + 4 l_H / (E pi (D_A^2 - d_h^2)),
    delta_V = ln[(d_W + d_h)(D - d_h) / ((d_W - d_h)(D + d_h))] / (E pi d_h tan phi),   D = d_W + 2 l_V tan phi
    l_V = min[(D_A - d_W)/(2 tan phi), w l_K/2],   l_H = l_K - 2 l_V/w
    tan phi = 0.362 + 0.032 ln(l_K/(2 d_W)) + 0.153 ln(D_A/d_W)      w = 1
    tan phi = 0.348 + 0.013 ln(l_K/d_W) + 0.193 ln(D_A/d_W)          w = 2

The resilience of the bolt, threaded over its clamped length, is delta_S: head, thread, engaged thread and nut in
series. Bolt and parts act in parallel, k = 1/delta_P + 1/delta_S.

Reference: VDI 2230 part 1 (2015), equations 5.1/3 to 5.1/15 and 5.1/23 to 5.1/34; default of D_A: the width up to which
the contact plane stays closed, 5.1/38 and 5.1/39. Sizes: ISO 724 (thread), ISO 4014 (smallest bearing diameter of a
hexagon head), ISO 273 medium (hole).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Size = Literal["M5", "M6", "M8", "M10", "M12", "M16", "M20", "M24", "M30"]
STEEL_OF_BOLTS = 205e9  # Pa, VDI 2230
_SIZES: Mapping[Size, tuple[float, float, float]] = {  # pitch, bearing diameter of the head, hole, mm
    "M5": (0.8, 6.88, 5.5),
    "M6": (1.0, 8.88, 6.6),
    "M8": (1.25, 11.63, 9.0),
    "M10": (1.5, 14.63, 11.0),
    "M12": (1.75, 16.63, 13.5),
    "M16": (2.0, 22.49, 17.5),
    "M20": (2.5, 28.19, 22.0),
    "M24": (3.0, 33.61, 26.0),
    "M30": (3.5, 42.75, 33.0),
}
_HEAD, _THREAD, _NUT, _TAPPED = 0.5, 0.5, 0.4, 0.33  # substitutional lengths over the nominal diameter


class BoltError(ValueError):
    """A bolt does not fit its clamped parts."""


@dataclass(frozen=True, kw_only=True)
class Bolt:
    """A bolt through two clamped parts; all lengths in m.

    `clamped` are the thicknesses under the head and beyond the contact plane; the second is ignored for a tapped hole.
    """

    diameter: float  # nominal, d
    pitch: float  # of the thread
    head: float  # bearing diameter d_W
    hole: float  # d_h
    clamped: tuple[float, float]
    tapped: bool = False
    outer: float | None = None  # D_A of the clamped parts; None: as far as the joint stays closed

    def __post_init__(self) -> None:
        if not self.outer_diameter > self.hole:
            raise BoltError(
                f"clamped parts of outer diameter {_mm(self.outer_diameter)} leave nothing around a hole of "
                f"{_mm(self.hole)}; enlarge the diameter or take a smaller bolt"
            )

    @classmethod
    def of_size(
        cls, size: Size, *, clamped: tuple[float, float], tapped: bool = False, outer: float | None = None
    ) -> Bolt:
        """A bolt with a hexagon head, from its size.

        Parameters
        ----------
        size : of the thread, which gives pitch, head and hole
        clamped, tapped, outer : those of the class
        """
        pitch, head, hole = (value / 1000 for value in _SIZES[size])
        diameter = int(size[1:]) / 1000
        return cls(diameter=diameter, pitch=pitch, head=head, hole=hole, clamped=clamped, tapped=tapped, outer=outer)

    @property
    def length(self) -> float:
        """Clamped length l_K, m."""
        return self.clamped[0] if self.tapped else sum(self.clamped)

    @property
    def outer_diameter(self) -> float:
        """D_A, m."""
        if self.outer is not None:
            return self.outer
        return 1.5 * self.head if self.tapped else self.head + min(self.clamped)

    @property
    def cone_slope(self) -> float:
        """tan phi; parts that are not wider than the head have no cone."""
        long, wide = self.length / self.head, max(self.outer_diameter / self.head, 1.0)
        if self.tapped:
            return 0.348 + 0.013 * math.log(long) + 0.193 * math.log(wide)
        return 0.362 + 0.032 * math.log(long / 2.0) + 0.153 * math.log(wide)

    @property
    def contact_diameter(self) -> float:
        """Outer diameter of the cone at the contact plane, m."""
        depth = self.clamped[0] if self.tapped else min(self.clamped)
        return min(self.outer_diameter, self.head + 2.0 * depth * self.cone_slope)

    @property
    def contact_area(self) -> float:
        """Area of the closed ring, m2."""
        return math.pi / 4.0 * (self.contact_diameter**2 - self.hole**2)

    def clamped_resilience(self, modulus: float) -> float:
        """delta_P, m/N, of parts with an elastic modulus (Pa)."""
        ends, slope, wide = (1.0 if self.tapped else 2.0), self.cone_slope, self.outer_diameter
        cone = max(min((wide - self.head) / (2.0 * slope), self.length / ends), 0.0)  # length of one cone
        start, end = min(self.head, wide), min(self.head, wide) + 2.0 * cone * slope
        spread = (start + self.hole) * (end - self.hole) / ((start - self.hole) * (end + self.hole))
        cones = ends * math.log(spread) / (modulus * math.pi * self.hole * slope)
        sleeve = 4.0 * (self.length - ends * cone) / (modulus * math.pi * (wide**2 - self.hole**2))
        return cones + sleeve

    def bolt_resilience(self, modulus: float) -> float:
        """delta_S, m/N; `modulus` (Pa) of the parts is used for the engaged thread of a tapped hole."""
        core = math.pi / 4.0 * (self.diameter - 1.22687 * self.pitch) ** 2
        nominal = math.pi / 4.0 * self.diameter**2
        inner = _TAPPED / modulus if self.tapped else _NUT / STEEL_OF_BOLTS
        thread = (self.length + _THREAD * self.diameter) / (STEEL_OF_BOLTS * core)
        return (_HEAD / STEEL_OF_BOLTS + inner) * self.diameter / nominal + thread

    def stiffness(self, modulus: float) -> float:
        """Stiffness of bolt and clamped parts in parallel, N/m."""
        return 1.0 / self.clamped_resilience(modulus) + 1.0 / self.bolt_resilience(modulus)


def _mm(length: float) -> str:
    return f"{1000 * length:.4g} mm"
