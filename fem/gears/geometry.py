"""A pair of external cylindrical gears on parallel axes: working geometry after ISO 21771:2007."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from fem.elements.materials import STEEL, Material
from fem.gears.gear import Gear, involute
from fem.gears.gear_checks import require
from fem.gears.profile import form_point, form_radius, generate_trochoid
from fem.numerics.root_finding import brentq


def sum_of_shifts(
    teeth: int, normal_module: float, helix_angle: float, pressure_angle: float, distance: float
) -> float:
    """Sum of the profile shift coefficients of two gears without backlash at a centre distance (ISO 21771).

    Parameters
    ----------
    teeth : of both gears together
    normal_module, distance : m, and centre distance, m
    helix_angle, pressure_angle : rad, the latter that of the rack

    Raises
    ------
    GeometryError : the distance is not above the sum of the base radii
    """
    transverse = math.atan(math.tan(pressure_angle) / math.cos(helix_angle))
    cosine = teeth * normal_module * math.cos(transverse) / (2 * math.cos(helix_angle) * distance)
    require(cosine < 1.0, f"{1000 * distance:.6g} mm is not above the sum of the base radii. Raise centre_distance_mm")
    return (involute(math.acos(cosine)) - involute(transverse)) * teeth / (2 * math.tan(pressure_angle))


_Places = TypeVar("_Places", float, np.ndarray)

logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class GearPair:
    """Pinion (driving in lifting) and wheel on parallel axes.

    Parameters
    ----------
    pinion, wheel : Gear with equal module, helix angle and rack pressure angle; opposite hands when helical
    centre_distance : m, or None for the distance without backlash that follows from the profile shifts
    backlash_allowance : m along the transverse line of action, added to the backlash from the centre distance and the
        tooth thickness allowances of the gears; it does not change the elastic teeth
    pinion_material, wheel_material : Material

    Raises
    ------
    GeometryError : the gears do not fit together, teeth jam, tips meet roots, contact below the involute, or the total
        contact ratio is below 1

    Position along the transverse line of action: xi in base pitches from the pitch point, positive in recess. With the
    pinion driving, contact runs from xi_start = -approach / p_bt (wheel tip) to xi_end = recess / p_bt (pinion tip).
    """

    pinion: Gear
    wheel: Gear
    centre_distance: float | None = None
    backlash_allowance: float = 0.0
    pinion_material: Material = STEEL
    wheel_material: Material = STEEL

    def __post_init__(self) -> None:
        p, w = self.pinion, self.wheel
        label = self.label
        for name in ("normal_module", "helix_angle"):
            a, b = getattr(p, name), getattr(w, name)
            require(
                math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-15),
                f"{label}: {name} differs, pinion {a!r}, wheel {b!r}; meshing gears need the same",
            )
        require(
            math.isclose(p.rack.pressure_angle, w.rack.pressure_angle, rel_tol=1e-12),
            f"{label}: rack pressure_angle differs, pinion {p.rack.pressure_angle!r}, wheel "
            f"{w.rack.pressure_angle!r} rad; meshing gears need the same",
        )
        require(
            p.helix_angle == 0.0 or p.hand != w.hand,
            f"{label}: both gears are {p.hand} hand; one must be right-handed and the other left-handed",
        )
        require(
            math.isfinite(self.backlash_allowance),
            f"{label}: backlash_allowance is {self.backlash_allowance!r} m; give a finite number",
        )
        if self.centre_distance is None:
            object.__setattr__(self, "centre_distance", self._tight_centre_distance())
        base_sum = p.base_radius + w.base_radius
        require(
            math.isfinite(self.axis_distance) and self.axis_distance > base_sum,
            f"{label}: the centre distance of {1000 * self.axis_distance:.6g} mm is not above the sum of the base "
            "radii, "
            f"{1000 * base_sum:.6g} mm. Raise centre_distance_mm",
        )
        self._check_backlash()
        self._check_clearance()
        self._check_contact()
        for gear, name in ((p, "pinion"), (w, "wheel")):
            if gear.undercut and form_radius(gear) > gear.base_radius + 1e-3 * gear.normal_module:
                logger.warning(
                    "%s: the %s (z=%d, x=%.4g) is undercut; its involute starts at the diameter %.6g mm "
                    "(base circle %.6g mm). Raise its profile shift to avoid this.",
                    label, name, gear.teeth, gear.profile_shift, 2000 * form_radius(gear), 2000 * gear.base_radius,
                )  # fmt: skip

    @property
    def label(self) -> str:
        """Short name for messages."""
        return f"gear pair {self.pinion.teeth}/{self.wheel.teeth}"

    def _tight_centre_distance(self) -> float:
        p, w = self.pinion, self.wheel
        shift = p.profile_shift + w.profile_shift
        target = involute(p.transverse_pressure_angle) + 2.0 * shift / (p.teeth + w.teeth) * math.tan(
            p.rack.pressure_angle
        )
        require(
            target > 0.0,
            f"{self.label}: with the sum of profile shifts {shift:.4g} there is no working pressure angle (inv "
            "alpha_wt "
            f"= {target:.3g}, it must be above 0). Raise pinion_profile_shift or wheel_profile_shift",
        )
        angle = brentq(lambda alpha: involute(alpha) - target, 1e-9, math.radians(60.0), xtol=1e-15)
        return (p.base_radius + w.base_radius) / math.cos(angle)

    def _check_backlash(self) -> None:
        # profile shifts are tabulated to 4 digits, so a pair without backlash may overlap by about 1e-4 modules
        limit = -1e-4 * self.pinion.normal_module
        require(
            self._raw_backlash >= limit,
            f"{self.label}: the teeth jam: at the centre distance of {1000 * self.axis_distance:.6g} mm the backlash "
            "along "
            f"the line of action is {1e6 * self._raw_backlash:.4g} um. Without thickness allowances it is 0 at "
            f"{1000 * self._tight_centre_distance():.6g} mm. Raise centre_distance_mm, or reduce a profile shift or "
            "thickness_allowance_um",
        )

    def _check_clearance(self) -> None:
        for tip, root, name in ((self.pinion, self.wheel, "pinion"), (self.wheel, self.pinion, "wheel")):
            clearance = self.axis_distance - tip.tip_radius - root.root_radius
            require(
                clearance > 0.0,
                f"{self.label}: the tips of the {name} touch the root circle of the mating gear: the tip clearance is "
                f"{1000 * clearance:.4g} mm, usual are 0.1 to 0.4 modules. Set a negative {name}.tip_alteration_mm",
            )

    def _check_contact(self) -> None:
        for name, lowest, form in zip(("pinion", "wheel"), self._lowest_rolls(), self.form_rolls, strict=True):
            if lowest >= form - 1e-9 * self.pinion.base_radius:
                continue
            other = "wheel" if name == "pinion" else "pinion"
            own, tip = getattr(self, name), getattr(self, other)
            depth = root_penetration(own, tip, self.axis_distance, self.working_pressure_angle)
            limit = 1e-5 * self.pinion.normal_module
            require(
                depth <= limit,
                f"{self.label}: interference at the root of the {name}: the tip of the {other} would touch it at roll "
                f"length {1000 * lowest:.6g} mm, but the involute starts at {1000 * form:.6g} mm, and the tip cuts "
                f"{1e6 * depth:.4g} um into the fillet (limit {1e6 * limit:.2g} um). Correct {name}_profile_shift, or "
                "set "
                f"a negative {other}.tip_alteration_mm",
            )
        require(
            self.transverse_contact_ratio > 0.0,
            f"{self.label}: the teeth do not touch (eps_alpha {self.transverse_contact_ratio:.4f}), as the tip circles "
            "overlap too little. Reduce the centre distance, or raise rack_addendum or tip_alteration_mm",
        )
        require(
            self.total_contact_ratio >= 1.0,
            f"{self.label}: the total contact ratio {self.total_contact_ratio:.4f} (eps_alpha "
            f"{self.transverse_contact_ratio:.4f}, eps_beta {self.overlap_ratio:.4f}) is below 1, the least for "
            "continuous motion. Reduce the centre distance, or raise rack_addendum, tip_alteration_mm, "
            "helix_angle_deg, face_width_mm or the profile shift of a gear with few teeth",
        )

    @property
    def axis_distance(self) -> float:
        """Working centre distance a_w (m)."""
        assert self.centre_distance is not None  # set on creation
        return self.centre_distance

    @property
    def ratio(self) -> float:
        """Tooth ratio u = z2 / z1."""
        return self.wheel.teeth / self.pinion.teeth

    @property
    def face_width(self) -> float:
        """Common face width b (m)."""
        return min(self.pinion.face_width, self.wheel.face_width)

    @property
    def base_pitch(self) -> float:
        """Transverse base pitch p_bt (m)."""
        return self.pinion.base_pitch

    @property
    def base_helix_angle(self) -> float:
        """beta_b (rad)."""
        return self.pinion.base_helix_angle

    @cached_property
    def working_pressure_angle(self) -> float:
        """alpha_wt = arccos((r_b1 + r_b2) / a) (rad)."""
        return math.acos((self.pinion.base_radius + self.wheel.base_radius) / self.axis_distance)

    @property
    def working_radii(self) -> tuple[float, float]:
        """Operating pitch radii r_w1, r_w2 (m)."""
        cosine = math.cos(self.working_pressure_angle)
        return self.pinion.base_radius / cosine, self.wheel.base_radius / cosine

    @property
    def working_pitch(self) -> float:
        """Transverse pitch on the operating pitch circles p_wt (m)."""
        return 2.0 * math.pi * self.working_radii[0] / self.pinion.teeth

    @property
    def working_thicknesses(self) -> tuple[float, float]:
        """Transverse tooth thicknesses on the operating pitch circles s_w1, s_w2 (m, arcs)."""
        r1, r2 = self.working_radii
        return self.pinion.tooth_thickness(r1), self.wheel.tooth_thickness(r2)

    @property
    def thickness_cycle(self) -> float:
        """tau = s_w1 / p_wt: lag of the coast flank of a pinion tooth behind its drive flank, in mesh cycles."""
        return self.working_thicknesses[0] / self.working_pitch

    @property
    def _raw_backlash(self) -> float:
        play = self.working_pitch - sum(self.working_thicknesses)
        return play * math.cos(self.working_pressure_angle) + self.backlash_allowance

    @property
    def backlash(self) -> float:
        """j_bt: backlash along the transverse line of action, from centre distance and allowance (m, >= 0)."""
        return max(0.0, self._raw_backlash)

    @cached_property
    def form_rolls(self) -> tuple[float, float]:
        """Roll lengths at which the involutes of pinion and wheel start above their fillets (m)."""
        p, w = (math.sqrt(max(form_radius(g) ** 2 - g.base_radius**2, 0.0)) for g in (self.pinion, self.wheel))
        return p, w

    def _lowest_rolls(self) -> tuple[float, float]:
        """Roll lengths on pinion and wheel reached by the tip form circle of the mate (m)."""
        p, w = self.pinion, self.wheel
        whole = self.axis_distance * math.sin(self.working_pressure_angle)
        return (
            whole - math.sqrt(w.tip_form_radius**2 - w.base_radius**2),
            whole - math.sqrt(p.tip_form_radius**2 - p.base_radius**2),
        )

    @cached_property
    def _lengths(self) -> tuple[float, float]:
        """Approach and recess: up to the tip of the mate, or to the form circle of an undercut gear."""
        tangent = math.tan(self.working_pressure_angle)
        (low1, low2), (form1, form2) = self._lowest_rolls(), self.form_rolls
        return self.pinion.base_radius * tangent - max(low1, form1), self.wheel.base_radius * tangent - max(low2, form2)

    @property
    def shortened_by_undercut(self) -> tuple[bool, bool]:
        """Whether undercut of the pinion shortens the approach, and that of the wheel the recess."""
        (low1, low2), (form1, form2) = self._lowest_rolls(), self.form_rolls
        return low1 < form1, low2 < form2

    @property
    def approach_length(self) -> float:
        """Path of contact before the pitch point: from the wheel's tip, or the undercut pinion's form circle (m)."""
        return self._lengths[0]

    @property
    def recess_length(self) -> float:
        """Path of contact after the pitch point: to the pinion's tip, or the undercut wheel's form circle (m)."""
        return self._lengths[1]

    @property
    def xi_start(self) -> float:
        """First position of the path of contact, cycles from the pitch point (< 0)."""
        return -self.approach_length / self.base_pitch

    @property
    def xi_end(self) -> float:
        """Last position of the path of contact, cycles from the pitch point."""
        return self.recess_length / self.base_pitch

    @property
    def transverse_contact_ratio(self) -> float:
        """eps_alpha."""
        return sum(self._lengths) / self.base_pitch

    @property
    def overlap_ratio(self) -> float:
        """eps_beta = b tan beta_b / p_bt."""
        return self.face_width * math.tan(self.base_helix_angle) / self.base_pitch

    @property
    def total_contact_ratio(self) -> float:
        """eps_gamma = eps_alpha + eps_beta."""
        return self.transverse_contact_ratio + self.overlap_ratio

    def roll_lengths(self, xi: _Places) -> tuple[_Places, _Places]:
        """Roll lengths from the base tangent points of pinion and wheel to the contact point at xi (m)."""
        tangent, shift = math.tan(self.working_pressure_angle), xi * self.base_pitch
        return self.pinion.base_radius * tangent + shift, self.wheel.base_radius * tangent - shift


def root_penetration(own: Gear, tip: Gear, axis_distance: float, working_pressure_angle: float) -> float:
    """Largest depth (m, along the circle) to which the tip of one gear cuts into the root fillet of the other.

    Below 0 the tip stays clear by that much. Frame and symbols of `fem.gears.path`. At the position xi the flank of the
    pinion that is in mesh has, at the radius R, the polar angle -alpha_wt + L1/r_b1 - (s_b - s(R)): s(R) is its half
    thickness angle, below the form circle that of the trochoid, and s_b that of the involute at the base circle. The
    tip edge of the wheel must not reach it.

    Parameters
    ----------
    own : the gear whose root fillet is looked at
    tip : the gear whose tip edge comes there
    axis_distance : m
    working_pressure_angle : rad, transverse
    """
    alpha = working_pressure_angle
    radius, junction = form_point(own)
    troch_r, troch_s = generate_trochoid(own, np.linspace(junction, math.pi / 2, 400))
    order = np.argsort(troch_r)
    troch_r, troch_s = troch_r[order], troch_s[order]
    whole = axis_distance * math.sin(alpha)
    first = whole - math.sqrt(tip.tip_form_radius**2 - tip.base_radius**2)  # roll length of its contact, below the form
    inv_tip = math.tan(tip.pressure_angle_at(tip.tip_form_radius)) - tip.pressure_angle_at(tip.tip_form_radius)
    roll = np.linspace(first - 2.0 * own.base_pitch, math.sqrt(max(radius**2 - own.base_radius**2, 0.0)), 2000)
    corner = math.pi - alpha + (whole - roll) / tip.base_radius - inv_tip
    x = axis_distance + tip.tip_form_radius * np.cos(corner)
    y = tip.tip_form_radius * np.sin(corner)
    at, place = np.hypot(x, y), np.arctan2(y, x)
    inside = at < radius
    half = np.interp(at, troch_r, troch_s)
    flank = -alpha + roll / own.base_radius - (own.half_thickness_angle(own.base_radius) - half)
    depth = (flank - place) * at
    return float(depth[inside].max()) if inside.any() else -math.inf
