"""Standard basic rack of the generating tool (ISO 53)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fem.gears.gear_checks import require


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
        low, high = math.radians(10.0), math.radians(35.0)
        require(
            low <= self.pressure_angle <= high,
            f"the pressure angle of {math.degrees(self.pressure_angle):g} deg is not between 10 and 35 deg. Correct "
            "pressure_angle_deg",
        )
        half_land = self.tip_land
        largest = self.tip_radius + half_land * math.cos(self.pressure_angle) / (1.0 - math.sin(self.pressure_angle))
        require(
            half_land >= -1e-12,
            f"rack_tip_radius = {self.tip_radius:g} does not fit between the flanks of the basic rack with "
            f"rack_dedendum = {self.dedendum:g}; at most {largest:.4f} fits. Reduce rack_tip_radius or rack_dedendum",
        )

    @property
    def tip_land(self) -> float:
        """Half the flat width of the tool tip between its two roundings, modules (ISO 6336-3 auxiliary value E)."""
        alpha = self.pressure_angle
        return math.pi / 4 - self.dedendum * math.tan(alpha) - self.tip_radius * (1 - math.sin(alpha)) / math.cos(alpha)
