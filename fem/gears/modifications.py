"""Flank modifications and misalignment of the axes, as gaps along the transverse line of action.

ISO 21771 measures profile modifications normal to the involute in the transverse section and helix modifications in the
base tangent plane. Both are along the transverse line of action, so the amounts equal the gaps. Positive amounts remove
material, so that the flank touches later. Positions on the profile are roll lengths L = sqrt(r^2 - r_b^2); on the face
they are y from mid face along the face coordinate of the mesh law.

    relief             C ((L - L_s) / (L_e - L_s))^n beyond its start L_s, n = 1 linear, 2 parabolic; C at the end L_e
    profile crowning   C_alpha ((L - L_m) / (L_e - L_m))^2 about the middle L_m of the active profile
    lead crowning      C_beta (2 y / b)^2
    end relief         C ((|y| - y_s) / (b/2 - y_s))^n from y_s = b/2 - length to the end of the face
    helix slope        C_Hbeta y / b on the drive flank: the helix is rotated, so the coast flank gets the opposite

The ends L_e are those of the active profile: the tip form circle, and at the root the circle reached by the tip of the
mate. Beyond the root end the curve continues; beyond the tip the edge keeps its amount. Modifications of both gears are
added. They are the sum of a function of the position on the path and one of the face coordinate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Literal

import numpy as np

from fem.gears.gear import Gear
from fem.gears.gear_checks import GeometryError, require
from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints
from fem.options import check_options, option

SHAPES = {"linear": 1, "parabolic": 2}
_WORDS = {  # of a user, by name
    "tip_relief": "the tip relief",
    "root_relief": "the root relief",
    "profile_crowning": "the profile crowning",
    "lead_crowning": "the lead crowning",
    "end_relief_low": "an end relief",
    "end_relief_high": "an end relief",
    "helix_slope": "the helix slope modification",
}
LEAD_POINTS = 257  # between two of them a parabola deviates from its chord by 4e-6 of its height over the face
LARGEST_PART = 0.1  # modules; a larger amount indicates wrong units


@dataclass(frozen=True, kw_only=True)
class Relief:
    """Tip or root relief. Its start is given either by length_mm or by diameter_mm."""

    amount: float = option(unit="um", ge=0, le=1000, text="material removed at the end of the active profile")
    length: float | None = option(
        None, unit="mm", gt=0, text="length of the relief along the line of action, from that end"
    )
    diameter: float | None = option(None, unit="mm", gt=0, text="diameter where the relief starts")
    shape: Literal["linear", "parabolic"] = option("linear", text="how the relief grows from its start")

    def __post_init__(self) -> None:
        check_options(self, GeometryError)
        require(
            (self.length is None) != (self.diameter is None),
            "a relief needs one start, either length_mm or diameter_mm. "
            + ("Set one" if self.length is None else "Delete one"),
        )


@dataclass(frozen=True, kw_only=True)
class EndRelief:
    """Relief of one end of the face."""

    amount: float = option(unit="um", ge=0, le=1000, text="material removed at the end of the face")
    length: float = option(unit="mm", gt=0, text="length of the relief along the face")
    shape: Literal["linear", "parabolic"] = option("linear", text="how the relief grows from its start")

    def __post_init__(self) -> None:
        check_options(self, GeometryError)


@dataclass(frozen=True, kw_only=True)
class FlankModifications:
    """Modifications of all teeth of one gear, on both flanks (m); crownings may be negative (hollow).

    end_relief_low is at y = -b/2, end_relief_high at y = +b/2; helix_slope C_Hbeta is the material removed from the
    drive flank at y = +b/2, relative to y = -b/2.
    """

    tip_relief: Relief | None = option(None, text="tip relief")
    root_relief: Relief | None = option(None, text="root relief")
    profile_crowning: float = option(
        0.0, text="profile crowning C_alpha, at both ends of the active profile", unit="um", ge=-1000, le=1000
    )
    lead_crowning: float = option(
        0.0, text="lead crowning C_beta, at both ends of the face", unit="um", ge=-1000, le=1000
    )
    end_relief_low: EndRelief | None = option(
        None, text="end relief at the -y end of the face", key="end_relief_minus_y"
    )
    end_relief_high: EndRelief | None = option(
        None, text="end relief at the +y end of the face", key="end_relief_plus_y"
    )
    helix_slope: float = option(
        0.0,
        text="helix slope modification: material removed at the +y end of the drive flank, and added there on the "
        "coast flank",
        unit="um",
        ge=-1000,
        le=1000,
    )

    @property
    def turned(self) -> FlankModifications:
        """The modifications along the opposite face coordinate."""
        return replace(
            self,
            end_relief_low=self.end_relief_high,
            end_relief_high=self.end_relief_low,
            helix_slope=-self.helix_slope,
        )


@dataclass(frozen=True, kw_only=True)
class Misalignment:
    """Angles between the axes (rad), with the components of ISO 6336-1 and ISO/TR 10064-3.

    in_plane f_Sigma_delta / L: the centre distance increases towards +y; out_of_plane f_Sigma_beta / L: skew, positive
    if it opens the drive flank at +y and closes the coast flank. In the plane of action the gap opens by in_plane
    sin(alpha_wt) +- out_of_plane cos(alpha_wt) per face width, drive and coast.
    """

    in_plane: float = 0.0
    out_of_plane: float = 0.0

    def opening(self, pressure_angle: float, sign: float = 1.0) -> float:
        """Gap over the face (m/m) in the plane of action; sign 1 for drive flanks, -1 for coast flanks."""
        return self.in_plane * math.sin(pressure_angle) + sign * self.out_of_plane * math.cos(pressure_angle)

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            require(
                abs(value) <= 0.02, f"misalignment: {item.name} is {value!r} rad; give a value in [-0.02, 0.02] rad"
            )


@dataclass(frozen=True, kw_only=True)
class PairModifications:
    """Modifications and misalignment of a pair; all zero by default."""

    pinion: FlankModifications = field(default_factory=FlankModifications)
    wheel: FlankModifications = field(default_factory=FlankModifications)
    misalignment: Misalignment = field(default_factory=Misalignment)

    @property
    def none(self) -> bool:
        """True if all are zero."""
        return self == PairModifications()


def active_roll(pair: GearPair, gear: str) -> tuple[float, float]:
    """Roll lengths (m) at root and tip end of the active profile of "pinion" or "wheel"."""
    ends = [pair.roll_lengths(xi)[0 if gear == "pinion" else 1] for xi in (pair.xi_start, pair.xi_end)]
    return min(ends), max(ends)


def relief_lengths(pair: GearPair) -> tuple[float, float]:
    """Shortest and longest roll length (m) of linear tip reliefs that are equal on both gears.

    Two of the shortest leave a whole number of base pitches of the path of contact unmodified. With shorter ones,
    unmodified teeth still enter contact under load. The longest is half of the path of contact: two longer reliefs
    overlap, and their sum is constant in the overlap. So reliefs of length L and amount C give the same gaps, except
    for a constant, as those of length g_alpha - L and amount C (g_alpha - L) / L.

    References
    ----------
    ISO 21771-1: path of contact g_alpha = eps_alpha p_et; Smith 2003, Gear Noise and Vibration, chapter 3: short and
    long relief
    """
    ratio = pair.transverse_contact_ratio
    return max(ratio - 1.0, 0.0) % 1.0 * pair.base_pitch / 2, ratio * pair.base_pitch / 2


def check_modifications(pair: GearPair, modifications: PairModifications) -> None:
    """Refuse modifications that do not fit on the flanks of the pair.

    Raises
    ------
    GeometryError : a relief that starts outside the active profile or face, amounts above 0.1 m_n, tip and root relief
        that cover the whole involute
    """
    limit = LARGEST_PART * pair.pinion.normal_module
    for name in ("pinion", "wheel"):
        own, gear = getattr(modifications, name), getattr(pair, name)
        label = f"{pair.label}, {name}"
        amounts = {item.name: getattr(own, item.name) for item in fields(own)}
        for key, value in amounts.items():
            amount = abs(getattr(value, "amount", value) or 0.0)
            require(
                amount <= limit,
                f"{label}: the amount of {_WORDS[key]} is {1e6 * amount:.4g} um, more than 0.1 modules. Set at most "
                f"{1e6 * limit:.4g} um",
            )
        low, high = active_roll(pair, name)
        starts = [
            _relief_start(gear, relief, end, low, high, f"{label}: {_WORDS[key]}")
            for key, relief, end in (("root_relief", own.root_relief, low), ("tip_relief", own.tip_relief, high))
            if relief is not None
        ]
        require(
            len(starts) < 2 or starts[0] <= starts[1],
            f"{label}: the root relief ends at roll length {1000 * starts[0]:.5g} mm, above the start of the tip "
            "relief "
            f"at {1000 * starts[-1]:.5g} mm. Reduce length_mm of one of them"
            if starts
            else "",
        )
        for key in ("end_relief_low", "end_relief_high"):
            relief = amounts[key]
            require(
                relief is None or relief.length <= pair.face_width / 2,
                f"{label}: length_mm = {1000 * getattr(relief, 'length', 0.0):.5g} of an end relief is more than half "
                "the "
                f"face width. Set at most {500 * pair.face_width:.5g}",
            )


def _relief_start(gear: Gear, relief: Relief, end: float, low: float, high: float, label: str) -> float:
    """Roll length (m) at which a relief that ends at `end` starts, checked against the active profile low .. high."""
    if relief.length is not None:
        start = end - relief.length if end == high else end + relief.length
    else:
        assert relief.diameter is not None  # one of the two is given
        radius = relief.diameter / 2
        start = math.sqrt(max(radius**2 - gear.base_radius**2, 0.0))
    bounds = [2 * math.hypot(gear.base_radius, value) for value in (low, high)]
    require(
        low - 1e-12 <= start <= high + 1e-12 and start != end,
        f"{label} is {1000 * abs(end - start):.5g} mm long, and must start on the active profile. Set diameter_mm "
        f"between {1000 * bounds[0]:.6g} and {1000 * bounds[1]:.6g}, or length_mm up to {1000 * (high - low):.5g}",
    )
    return start


def profile_gap(pair: GearPair, modifications: PairModifications, points: PathPoints) -> np.ndarray:
    """Gap (position,), m, that the profile modifications of both gears add at the positions of `points`.

    It is the least over the flanks around the contact point of involutes. The gap between these is s^2 / (2 rho) at the
    distance s along the flanks, and at a tip edge that already has a gap it is larger by s sqrt(2 gap / rho).
    """
    gears = ((pair.pinion, modifications.pinion, 1.0), (pair.wheel, modifications.wheel, -1.0))
    bounds = [active_roll(pair, name) for name in ("pinion", "wheel")]
    radii = (points.pinion_radius, points.wheel_radius)

    def material(shift: np.ndarray) -> np.ndarray:
        total = np.zeros(shift.shape)
        for (gear, own, sign), (low, high), radius in zip(gears, bounds, radii, strict=True):
            moved = np.minimum(radius**2 + 2 * gear.base_radius * sign * shift, gear.tip_form_radius**2)
            roll = np.sqrt(np.maximum(moved - gear.base_radius**2, 0.0))
            for relief, end in ((own.tip_relief, high), (own.root_relief, low)):
                if relief is not None:
                    start = _relief_start(gear, relief, end, low, high, pair.label)
                    part = np.maximum((roll - start) / (end - start), 0.0)
                    total += relief.amount * part ** SHAPES[relief.shape]
            total += own.profile_crowning * ((2 * roll - low - high) / (high - low)) ** 2
        return total

    most = sum(
        abs(own.profile_crowning) + sum(relief.amount for relief in (own.tip_relief, own.root_relief) if relief)
        for _, own, _ in gears
    )
    place = np.zeros((1, len(points.xi)))
    reach = np.sqrt(2 * points.relative_radius * most)  # farther away the gap is larger than that
    edge = np.sqrt(8 * points.relative_radius * np.where(np.isfinite(points.gap), points.gap, 0.0))
    steps = np.linspace(-1.0, 1.0, 41)[:, None]
    for size in (1.0, 0.05):  # the second time between the neighbours of the best one
        shift = place + size * reach * steps
        gap = material(shift) + (shift**2 + edge * np.abs(shift)) / (2 * points.relative_radius)
        best = gap.argmin(axis=0)[None]
        place = np.take_along_axis(shift, best, 0)
    return np.asarray(gap.min(axis=0))


def lead_points(pair: GearPair, modifications: PairModifications) -> np.ndarray:
    """Face coordinates (point,), m: equal steps over the face, and the starts of the end reliefs."""
    half = pair.face_width / 2
    starts = [
        outwards * (half - relief.length)
        for own in (modifications.pinion, modifications.wheel)
        for relief, outwards in ((own.end_relief_low, -1.0), (own.end_relief_high, 1.0))
        if relief is not None
    ]
    return np.concatenate([np.linspace(-half, half, LEAD_POINTS), starts])


def lead_gap(pair: GearPair, modifications: PairModifications, flank: str, face: np.ndarray) -> np.ndarray:
    """Gap (slice,), m, from helix modifications and misalignment; of either sign.

    Parameters
    ----------
    pair, modifications : the gears in mesh and their modifications
    flank : "drive" or "coast"
    face : (slice,) face coordinates, m from mid face
    """
    b, sign = pair.face_width, 1.0 if flank == "drive" else -1.0
    face = np.asarray(face, dtype=float)
    total = np.zeros(len(face))
    for own in (modifications.pinion, modifications.wheel):
        total += own.lead_crowning * (2 * face / b) ** 2 + sign * own.helix_slope * face / b
        for relief, outwards in ((own.end_relief_low, -face), (own.end_relief_high, face)):
            if relief is not None:
                part = np.maximum((outwards - b / 2) / relief.length + 1.0, 0.0)
                total += relief.amount * part ** SHAPES[relief.shape]
    return total + modifications.misalignment.opening(pair.working_pressure_angle, sign) * face
