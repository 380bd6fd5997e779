"""Standard basic rack of the generating tool (ISO 53), and what all gear modules share: errors, inv(alpha)."""

from __future__ import annotations

import math
from dataclasses import dataclass


class GeometryError(ValueError):
    """Gear data that describe no working gear or pair."""


def involute(angle: float) -> float:
    """inv(alpha) = tan(alpha) - alpha (rad)."""
    return math.tan(angle) - angle


def require(condition: bool, message: str) -> None:
    """Raise GeometryError(message) unless the condition holds."""
    if not condition:
        raise GeometryError(message)


@dataclass(frozen=True, kw_only=True)
class Rack:
    """Standard basic rack in modules (ISO 53 profile A by default) that generates the gear.

    addendum h_aP*, dedendum h_fP*, tip_radius rho_fP* of the generating tool (the root fillet of the gear),
    pressure_angle alpha_n (rad).
    """

    addendum: float = 1.0
    dedendum: float = 1.25
    tip_radius: float = 0.38
    pressure_angle: float = math.radians(20.0)

    def __post_init__(self) -> None:
        for name in ("addendum", "dedendum"):
            value = getattr(self, name)
            require(0.3 <= value <= 2.5, f"rack: {name} is {value!r} modules; give a value in [0.3, 2.5]")
        low, high = math.radians(10.0), math.radians(35.0)
        require(
            low <= self.pressure_angle <= high,
            f"rack: pressure_angle is {self.pressure_angle!r} rad; give a value in "
            f"[{low:.4f}, {high:.4f}] rad (10 to 35 deg)",
        )
        require(self.tip_radius >= 0.0, f"rack: tip_radius is {self.tip_radius!r} modules; give a value >= 0")
        half_land = self.tip_land
        largest = self.tip_radius + half_land * math.cos(self.pressure_angle) / (1.0 - math.sin(self.pressure_angle))
        require(
            half_land >= -1e-12,
            f"rack: tip_radius {self.tip_radius!r} modules does not fit between the flanks of the tool at dedendum "
            f"{self.dedendum!r}; the limit is {largest:.4f} modules: reduce tip_radius or dedendum",
        )

    @property
    def tip_land(self) -> float:
        """Half the flat width of the tool tip between its two roundings, modules (ISO 6336-3 auxiliary value E)."""
        alpha = self.pressure_angle
        return math.pi / 4 - self.dedendum * math.tan(alpha) - self.tip_radius * (1 - math.sin(alpha)) / math.cos(alpha)
