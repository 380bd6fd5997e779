"""One cylindrical involute gear: basic rack and gear, with the quantities of ISO 21771:2007.

Symbols: z teeth, m_n normal module, beta helix angle, x profile shift, alpha pressure angle, r radius, s tooth
thickness; index n normal, t transverse, b base, a tip, f root. Lengths m, angles rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

HANDS = ("right", "left")
MAX_HELIX = math.radians(45.0)


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


@dataclass(frozen=True, kw_only=True)
class Gear:
    """An external cylindrical involute gear.

    teeth z, normal_module m_n (m), helix_angle beta >= 0 (rad) with hand "right" or "left", face_width b (m),
    profile_shift x (modules), bore_radius (m): the gear body is elastic from the bore outwards,
    tip_alteration k m_n (m, negative shortens the tooth).

    Raises
    ------
    GeometryError : a value out of range, bore >= root circle, pointed teeth, no involute left above the fillet
    """

    teeth: int
    normal_module: float
    helix_angle: float = 0.0
    face_width: float
    profile_shift: float = 0.0
    rack: Rack = field(default_factory=Rack)
    bore_radius: float
    tip_alteration: float = 0.0
    hand: str = "right"

    def __post_init__(self) -> None:
        for name in ("normal_module", "helix_angle", "face_width", "profile_shift", "bore_radius", "tip_alteration"):
            value = getattr(self, name)
            require(math.isfinite(value), f"gear: {name} is {value!r}; give a finite number in SI")
        require(
            isinstance(self.teeth, int) and 6 <= self.teeth <= 2000,
            f"gear: teeth is {self.teeth!r}; give a whole number in [6, 2000]",
        )
        label = f"gear z={self.teeth}"
        for name in ("normal_module", "face_width", "bore_radius"):
            value = getattr(self, name)
            require(value > 0.0, f"{label}: {name} is {value!r} m; give a value > 0")
        require(
            0.0 <= self.helix_angle <= MAX_HELIX,
            f"{label}: helix_angle is {self.helix_angle!r} rad; give a value in [0, {MAX_HELIX:.4f}] rad (0 to 45 deg) "
            "and the direction as hand",
        )
        require(self.hand in HANDS, f"{label}: hand is {self.hand!r}; choose one of {', '.join(HANDS)}")
        require(
            abs(self.profile_shift) <= 2.0,
            f"{label}: profile_shift is {self.profile_shift!r} modules; give a value in [-2, 2]",
        )
        require(
            self.bore_radius < self.root_radius,
            f"{label}: bore_radius {self.bore_radius:.6g} m reaches the root circle; the limit is r_f = "
            f"{self.root_radius:.6g} m: reduce the bore or raise teeth or module",
        )
        require(
            self.tip_radius > max(self.base_radius, self.root_radius),
            f"{label}: tip radius {self.tip_radius:.6g} m is not above the base circle {self.base_radius:.6g} m and "
            f"the root circle {self.root_radius:.6g} m: raise profile_shift or tip_alteration",
        )
        require(
            self.tip_thickness > 0.0,
            f"{label}: the tooth is pointed, its transverse thickness at the tip circle is {self.tip_thickness:.3g} m "
            "(limit > 0): reduce profile_shift or give a negative tip_alteration",
        )

    @cached_property
    def transverse_module(self) -> float:
        """m_t = m_n / cos beta (m)."""
        return self.normal_module / math.cos(self.helix_angle)

    @cached_property
    def transverse_pressure_angle(self) -> float:
        """alpha_t: tan alpha_t = tan alpha_n / cos beta (rad)."""
        return math.atan(math.tan(self.rack.pressure_angle) / math.cos(self.helix_angle))

    @cached_property
    def base_helix_angle(self) -> float:
        """beta_b: sin beta_b = sin beta cos alpha_n (rad, >= 0)."""
        return math.asin(math.sin(self.helix_angle) * math.cos(self.rack.pressure_angle))

    @property
    def hand_sign(self) -> int:
        """+1 right hand: seen at growing y the tooth turns in the positive sense about +y; -1 left hand."""
        return 1 if self.hand == "right" else -1

    @property
    def reference_radius(self) -> float:
        """r = z m_t / 2 (m)."""
        return self.teeth * self.transverse_module / 2.0

    @property
    def base_radius(self) -> float:
        """r_b = r cos alpha_t (m)."""
        return self.reference_radius * math.cos(self.transverse_pressure_angle)

    @property
    def tip_radius(self) -> float:
        """r_a = r + m_n (h_aP* + x) + k m_n (m)."""
        return (
            self.reference_radius + self.normal_module * (self.rack.addendum + self.profile_shift) + self.tip_alteration
        )

    @property
    def root_radius(self) -> float:
        """r_f = r - m_n (h_fP* - x) (m)."""
        return self.reference_radius - self.normal_module * (self.rack.dedendum - self.profile_shift)

    @property
    def base_pitch(self) -> float:
        """Transverse base pitch p_bt = 2 pi r_b / z (m)."""
        return 2.0 * math.pi * self.base_radius / self.teeth

    @property
    def virtual_teeth(self) -> float:
        """z_n = z / (cos^2 beta_b cos beta): teeth of the virtual spur gear (ISO 21771)."""
        return self.teeth / (math.cos(self.base_helix_angle) ** 2 * math.cos(self.helix_angle))

    @property
    def reference_thickness(self) -> float:
        """Transverse tooth thickness on the reference circle, s_t = m_t (pi/2 + 2 x tan alpha_n) (m, arc)."""
        return self.transverse_module * (math.pi / 2.0 + 2.0 * self.profile_shift * math.tan(self.rack.pressure_angle))

    def pressure_angle_at(self, radius: float) -> float:
        """Transverse pressure angle of the involute at `radius` >= r_b (rad)."""
        ratio = self.base_radius / radius
        require(
            ratio <= 1.0 + 1e-12,
            f"gear z={self.teeth}: radius {radius:.6g} m is inside the base circle {self.base_radius:.6g} m; "
            "the involute starts there",
        )
        return math.acos(min(1.0, ratio))

    def half_thickness_angle(self, radius: float) -> float:
        """Angle between tooth centre line and involute flank at `radius` >= r_b (rad)."""
        return (
            self.reference_thickness / (2.0 * self.reference_radius)
            + involute(self.transverse_pressure_angle)
            - involute(self.pressure_angle_at(radius))
        )

    def tooth_thickness(self, radius: float) -> float:
        """Transverse tooth thickness at `radius` >= r_b (m, arc)."""
        return 2.0 * radius * self.half_thickness_angle(radius)

    @property
    def tip_thickness(self) -> float:
        """Transverse tooth thickness on the tip circle s_at (m, arc)."""
        return self.tooth_thickness(self.tip_radius)

    @property
    def undercut(self) -> bool:
        """True when the tool's rounded tip cuts into the involute at its foot.

        The straight tool flank ends at the depth v = m_n (h_fP* - x - rho_fP* (1 - sin alpha_n)) below the reference
        circle; undercut begins at v > r sin^2 alpha_t.
        """
        rack = self.rack
        depth = rack.dedendum - self.profile_shift - rack.tip_radius * (1.0 - math.sin(rack.pressure_angle))
        return depth * self.normal_module > self.reference_radius * math.sin(self.transverse_pressure_angle) ** 2
