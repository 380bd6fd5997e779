"""Profile and helix deviations of single teeth: tolerances after ISO 1328-1:2013 and seeded samples inside them.

With the reference diameter d, m_n and the face width b in mm the tolerances of class 5 are (um; clause 5.3, formulae 7
to 12; step factor and rounding as in `fem.gears.deviations`)

    f_HaT = 0.4 m_n + 0.001 d + 4                 profile slope     F_aT = sqrt(f_HaT^2 + f_faT^2)   total profile
    f_faT = 0.55 m_n + 5                          profile form
    f_HbT = 0.05 sqrt(d) + 0.35 sqrt(b) + 4       helix slope       F_bT = sqrt(f_HbT^2 + f_fbT^2)   total helix
    f_fbT = 0.07 sqrt(d) + 0.45 sqrt(b) + 4       helix form

The contribution of a tooth to the gap in a mesh law is (position xi in base pitches from the pitch point, increasing
towards the tip of the pinion; xi_m, l: middle and length of the active profile; u = 2 (xi - xi_m) / l, v = 2 y / b)

    f_Ha u / 2 * s + f_fa u^2 + f_Hb v / 2 + f_fb v^2     s = +1 pinion, -1 wheel

so that the slope deviation is the difference between the ends. The form deviation is the height of a parabola, the
long-wave part of the standard's form deviation; waviness and roughness are neglected. At the middle of the flank, where
pitch is measured, the terms vanish, so that they do not change the pitch deviations. Both are measured along the
transverse line of action, so no projection is needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.gears.deviations import class_factors, rounded
from fem.gears.gear import Gear
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair

COMMON_PART = 0.5  # share of the slope deviations common to all teeth of a gear (machine setting)


@dataclass(frozen=True, kw_only=True)
class FlankTolerance:
    """Tolerances in m: slope, form and total of profile and helix."""

    profile_slope: float
    profile_form: float
    profile: float
    helix_slope: float
    helix_form: float
    helix: float


def flank_tolerance(gear: Gear, grade: int) -> FlankTolerance:
    """ISO 1328-1:2013 tolerances of profile and helix.

    Raises
    ------
    GeometryError : outside the range of the standard, including 4 mm <= b <= 1200 mm
    """
    d, m_n, b, factor = class_factors(gear, grade)
    if not 4.0 <= b <= 1200.0:
        raise GeometryError(
            f"tolerances of gear z={gear.teeth}: ISO 1328-1 covers face widths of 4 to 1200 mm for profile and helix "
            f"deviations, not {b:.4g} mm"
        )
    profile = (0.4 * m_n + 0.001 * d + 4.0) * factor, (0.55 * m_n + 5.0) * factor
    helix = (
        (0.05 * math.sqrt(d) + 0.35 * math.sqrt(b) + 4.0) * factor,
        (0.07 * math.sqrt(d) + 0.45 * math.sqrt(b) + 4.0) * factor,
    )
    values = (*profile, math.hypot(*profile), *helix, math.hypot(*helix))
    names = ("profile_slope", "profile_form", "profile", "helix_slope", "helix_form", "helix")
    return FlankTolerance(**{name: rounded(value) / 1e6 for name, value in zip(names, values, strict=True)})


def sample_flank_deviations(
    pair: GearPair,
    gear: str,
    grade: int,
    seed: int,
    *,
    profile: bool = True,
    helix: bool = True,
    use: float = 0.9,
) -> dict[str, dict[str, np.ndarray]]:
    """Sampled deviations of all teeth of one gear by flank, "drive" and "coast"; equal arguments give equal values.

    Those of a flank are terms (tooth,), the arguments of `fem.contact.teeth.tooth_terms` by name: clearance m,
    profile_slope m per base pitch, profile_curvature m per base pitch squared, lead_slope and lead_curvature m over the
    face width.

    Half of a slope is common to all teeth of a flank, half belongs to the single tooth. Each of the four quantities is
    scaled so that the largest over the teeth of both flanks reaches the share `use` of its tolerance. Slope and form of
    a tooth together remain within `use` of the total tolerance. Form deviations are concave or convex at random.

    Parameters
    ----------
    pair : the gears in mesh
    gear : "pinion" or "wheel"
    grade : int, tolerance class of ISO 1328-1
    seed : int, of the random numbers
    profile, helix : False leaves the deviations of the profile or of the helix at 0
    use : (0, 1], share of the tolerance

    Raises
    ------
    GeometryError : outside ISO 1328-1
    """
    own: Gear = getattr(pair, gear)
    tolerance = flank_tolerance(own, grade)
    draw = np.random.default_rng([seed, 1328])  # separate sequence: pitch deviations do not change
    shape = (2, own.teeth)
    sampled = []
    for wanted, slope, form, total in (
        (profile, tolerance.profile_slope, tolerance.profile_form, tolerance.profile),
        (helix, tolerance.helix_slope, tolerance.helix_form, tolerance.helix),
    ):
        common = draw.uniform(-1.0, 1.0, size=(2, 1))
        slopes = COMMON_PART * common + (1.0 - COMMON_PART) * draw.uniform(-1.0, 1.0, size=shape)
        forms = draw.uniform(-1.0, 1.0, size=shape)
        slopes *= use * slope / np.abs(slopes).max()
        forms *= use * form / np.abs(forms).max()
        excess = np.maximum(np.hypot(slopes, forms) / (use * total), 1.0)
        sampled += [slopes / excess * wanted, forms / excess * wanted]
    side = 1.0 if gear == "pinion" else -1.0
    middle, length = (pair.xi_start + pair.xi_end) / 2.0, pair.xi_end - pair.xi_start
    found = {}
    for k, flank in enumerate(("drive", "coast")):
        slope, curve = side * sampled[0][k] / length, sampled[1][k] * (2.0 / length) ** 2
        found[flank] = {
            "clearance": -slope * middle + curve * middle**2,
            "profile_slope": slope - 2.0 * curve * middle,
            "profile_curvature": curve,
            "lead_slope": sampled[2][k].copy(),
            "lead_curvature": 4.0 * sampled[3][k],
        }
    return found
