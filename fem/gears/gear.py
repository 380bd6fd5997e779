"""One cylindrical involute gear: basic rack and gear, with the quantities of ISO 21771:2007.

Symbols: z teeth, m_n normal module, beta helix angle, x profile shift, alpha pressure angle, r radius, s tooth
thickness; index n normal, t transverse, b base, a tip, f root. Lengths m, angles rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

from fem.gears.gear_checks import GeometryError, require
from fem.gears.rack import Rack
from fem.gears.wheel_body import check_body
from fem.options import check_options, option

HANDS = ("right", "left")


def involute(angle: float) -> float:
    """inv(alpha) = tan(alpha) - alpha (rad)."""
    return math.tan(angle) - angle


@dataclass(frozen=True, kw_only=True)
class GearDetails:
    """Tip, tooth thickness and body of a gear beyond its main data (m)."""

    tip_alteration: float = option(
        0.0, text="tip alteration k m_n of the tip radius; negative: shorter teeth", unit="mm"
    )
    tip_chamfer: float = option(0.0, text="radial height of the tip chamfer", unit="mm", ge=0)
    tip_rounding: float = option(0.0, text="radius of the tip rounding", unit="mm", ge=0)
    thickness_allowance: float = option(
        0.0,
        text="tooth thickness allowance A_sn in the normal section; negative: more backlash",
        unit="um",
        ge=-1000,
        le=1000,
    )
    rim_thickness: float | None = option(
        None, text="rim thickness s_R below the root circle; without it: solid gear body", unit="mm", gt=0
    )
    web_thickness: float | None = option(None, text="web thickness b_s below the rim", unit="mm", gt=0)
    web_offset: float = option(0.0, text="y of the middle of the web from the middle of the face", unit="mm")


@dataclass(frozen=True, kw_only=True)
class Gear(GearDetails):
    """An external cylindrical involute gear.

    teeth z, normal_module m_n (m), helix_angle beta >= 0 (rad) with hand "right" or "left", face_width b (m),
    profile_shift x (modules), bore_radius (m): the gear body is elastic from the bore outwards,
    tip_alteration k m_n (m, negative shortens the tooth).
    thickness_allowance A_sn (m, normal section, negative thins the tooth; DIN 3967): the tool is fed deeper, so that
    the tooth is generated with x_E = x + A_sn / (2 m_n tan alpha_n); the tip circle is unchanged. tip_chamfer h_K (m,
    radial height), or tip_rounding rho_an (m, radius): the involute ends at the tip form circle. rim_thickness s_R (m,
    from the root circle inwards; None: solid body), web_thickness b_s (m, default the face width) and web_offset (m,
    middle of the web from mid face): below the rim the body is a web down to the bore. A hub is part of the shaft: set
    the bore to its outer diameter.

    Raises
    ------
    GeometryError : bore >= root circle, thin rim, pointed teeth, no involute above the fillet
    """

    teeth: int
    normal_module: float
    helix_angle: float = 0.0
    face_width: float
    profile_shift: float = 0.0
    rack: Rack = field(default_factory=Rack)
    bore_radius: float
    hand: str = "right"

    def __post_init__(self) -> None:
        label = f"gear z={self.teeth}"
        require(
            abs(self.profile_shift) <= 2.0,
            f"{label}: the profile shift coefficient {self.profile_shift:g} is not between -2 and 2. Correct it",
        )
        self._check_thickness(label)
        check_body(
            label,
            normal_module=self.normal_module,
            face_width=self.face_width,
            root_radius=self.root_radius,
            bore_radius=self.bore_radius,
            rim_thickness=self.rim_thickness,
            web_thickness=self.web_thickness,
            web_offset=self.web_offset,
        )
        self._check_tip(label)

    def _check_thickness(self, label: str) -> None:
        limit = 0.5 * self.normal_module
        require(
            abs(self.thickness_allowance) <= limit,
            f"{label}: thickness_allowance_um = {1e6 * self.thickness_allowance:g} is more than half a module. Set "
            f"{-1e6 * limit:.4g} to {1e6 * limit:.4g}; negative values make the tooth thinner",
        )

    def _check_tip(self, label: str) -> None:
        require(
            self.tip_radius > max(self.base_radius, self.root_radius),
            f"{label}: the tip circle of {2000 * self.tip_radius:.6g} mm is not outside the base circle of "
            f"{2000 * self.base_radius:.6g} mm and the root circle of {2000 * self.root_radius:.6g} mm. Raise the "
            "profile shift or tip_alteration_mm",
        )
        require(
            self.tip_thickness > 0.0,
            f"{label}: the tooth is pointed below its tip circle (tip thickness {1000 * self.tip_thickness:.3g} mm, it "
            "must be above 0). Reduce the profile shift, or set a negative tip_alteration_mm",
        )
        check_options(self, GeometryError)
        require(
            self.tip_chamfer == 0.0 or self.tip_rounding == 0.0,
            f"{label}: tip_chamfer_mm = {1000 * self.tip_chamfer:.4g} and tip_rounding_mm = "
            f"{1000 * self.tip_rounding:.4g} are both set; a tip edge is either chamfered or rounded. Delete one",
        )
        require(
            self.tip_rounding <= 0.5 * self.tip_thickness * math.cos(self.base_helix_angle) or self.tip_rounding == 0.0,
            f"{label}: tip_rounding_mm = {1000 * self.tip_rounding:.4g} does not fit on the tip land. Set at most half "
            f"of its width, {500 * self.tip_thickness * math.cos(self.base_helix_angle):.4g}",
        )
        floor = max(self.base_radius, self.reference_radius - 0.5 * self.normal_module)
        require(
            self.tip_form_radius > floor,
            f"{label}: the tip chamfer or rounding leaves the involute up to a diameter of only "
            f"{2000 * self.tip_form_radius:.6g} mm; it must reach {2000 * floor:.6g} mm. Reduce tip_chamfer_mm or "
            "tip_rounding_mm",
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
        """+1 right hand: with increasing y the tooth rotates in the positive sense about +y; -1 left hand."""
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
    def tip_form_radius(self) -> float:
        """Tip form radius r_Fa: end of the involute below a chamfered or rounded tip edge; r_a if sharp (m).

        A rounding is tangent to tip circle and flank, so that its height is rho_an (1 - sin alpha_a).
        """
        if self.tip_rounding > 0.0:
            return self.tip_radius - self.tip_rounding * (1.0 - math.sin(self.pressure_angle_at(self.tip_radius)))
        return self.tip_radius - self.tip_chamfer

    @property
    def generating_shift(self) -> float:
        """x_E = x + A_sn / (2 m_n tan alpha_n): generating profile shift of the thinned tooth (modules)."""
        return self.profile_shift + self.thickness_allowance / (
            2.0 * self.normal_module * math.tan(self.rack.pressure_angle)
        )

    @property
    def root_radius(self) -> float:
        """r_f = r - m_n (h_fP* - x_E) (m)."""
        return self.reference_radius - self.normal_module * (self.rack.dedendum - self.generating_shift)

    @property
    def rim_inner_radius(self) -> float:
        """Inner radius of the rim, r_f - s_R; the bore of a solid body (m)."""
        return self.bore_radius if self.rim_thickness is None else self.root_radius - self.rim_thickness

    @property
    def web_ratio(self) -> float:
        """b_s / b; 1 for a solid body."""
        if self.rim_thickness is None or self.web_thickness is None:
            return 1.0
        return self.web_thickness / self.face_width

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
        """Transverse tooth thickness on the reference circle, s_t = m_t (pi/2 + 2 x_E tan alpha_n) (m, arc)."""
        return self.transverse_module * (
            math.pi / 2.0 + 2.0 * self.generating_shift * math.tan(self.rack.pressure_angle)
        )

    def pressure_angle_at(self, radius: float) -> float:
        """Transverse pressure angle of the involute at `radius` >= r_b (rad)."""
        ratio = self.base_radius / radius
        require(
            ratio <= 1.0 + 1e-12,
            f"gear z={self.teeth}: the diameter {2000 * radius:.6g} mm is inside the base circle of "
            f"{2000 * self.base_radius:.6g} mm, where the involute starts",
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
        """True if the rounded tip of the tool undercuts the involute at its root.

        The straight tool flank ends at the depth v = m_n (h_fP* - x_E - rho_fP* (1 - sin alpha_n)) below the reference
        circle; undercut begins at v > r sin^2 alpha_t.
        """
        rack = self.rack
        depth = rack.dedendum - self.generating_shift - rack.tip_radius * (1.0 - math.sin(rack.pressure_angle))
        return depth * self.normal_module > self.reference_radius * math.sin(self.transverse_pressure_angle) ** 2
