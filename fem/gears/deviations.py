"""Pitch deviations of the teeth: tolerances after ISO 1328-1:2013 and seeded samples inside them.

With the reference diameter d and m_n in mm the tolerances of class 5 are (um; clause 5.3, formulae 5 and 6)

    f_pT  = 0.001 d + 0.4 m_n + 5                  single pitch
    F_pT  = 0.002 d + 0.55 sqrt(d) + 0.7 m_n + 12  total cumulative pitch
    F_rT  = 0.9 F_pT                               runout (informative)

and each class multiplies by sqrt(2). Values are rounded to 1 um above 10 um, 0.5 um from 5 to 10 um, 0.1 um below.
Deviations of profile and helix are those of `fem.gears.flank_deviations`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.gears.gear import Gear
from fem.gears.gear_checks import GeometryError
from fem.options import option

GRADES = range(1, 12)
ECCENTRIC_PART = 0.7  # share of eccentricity in the total cumulative deviation, before scaling


@dataclass(frozen=True, kw_only=True)
class RandomDeviations:
    """Random deviations of every tooth, within the tolerances of ISO 1328-1."""

    grade: int = option(
        5, key="iso_grade", ge=GRADES[0], le=GRADES[-1], text="flank tolerance class of ISO 1328-1:2013"
    )
    seed: int = option(1, ge=0, le=2**31, text="seed of the random deviations")
    include: tuple[Literal["pitch", "profile", "helix"], ...] = option(
        ("pitch",),
        text="kinds of deviations: cumulative pitch, profile (slope and form), helix (slope and form)",
    )


@dataclass(frozen=True, kw_only=True)
class PitchTolerance:
    """Tolerances in m: single pitch f_pT, total cumulative pitch F_pT, runout F_rT."""

    single: float
    cumulative: float
    runout: float


def pitch_tolerance(gear: Gear, grade: int) -> PitchTolerance:
    """ISO 1328-1:2013 tolerances of the gear.

    Raises
    ------
    GeometryError : grade or gear size outside the standard (grades 1 to 11, 5 <= z <= 1000, 5 mm <= d <= 15 m,
        0.5 mm <= m_n <= 70 mm)
    """
    d, m_n, _, factor = class_factors(gear, grade)
    single = (0.001 * d + 0.4 * m_n + 5.0) * factor
    cumulative = (0.002 * d + 0.55 * math.sqrt(d) + 0.7 * m_n + 12.0) * factor
    return PitchTolerance(
        single=rounded(single) / 1e6, cumulative=rounded(cumulative) / 1e6, runout=rounded(0.9 * cumulative) / 1e6
    )


def class_factors(gear: Gear, grade: int) -> tuple[float, float, float, float]:
    """Reference diameter d, m_n and b in mm, and the factor sqrt(2)^(grade - 5) of ISO 1328-1:2013, 5.2.2.

    Raises
    ------
    GeometryError : outside the range of the standard
    """
    d, m_n, b = 2000.0 * gear.reference_radius, 1000.0 * gear.normal_module, 1000.0 * gear.face_width
    for bad, what in (
        (grade not in GRADES, f"iso_grade = {grade!r} is not a whole number from {GRADES[0]} to {GRADES[-1]}"),
        (not 5 <= gear.teeth <= 1000, f"ISO 1328-1 covers 5 to 1000 teeth, not {gear.teeth}"),
        (not 5.0 <= d <= 15000.0, f"ISO 1328-1 covers reference diameters of 5 to 15000 mm, not {d:.4g} mm"),
        (not 0.5 <= m_n <= 70.0, f"ISO 1328-1 covers normal modules of 0.5 to 70 mm, not {m_n:.4g} mm"),
    ):
        if bad:
            raise GeometryError(f"tolerances of gear z={gear.teeth}: {what}")
    return d, m_n, b, math.sqrt(2.0) ** (grade - 5)


def rounded(value: float) -> float:
    """Rounding rule of ISO 1328-1:2013, 5.2.3 (um)."""
    if value > 10.0:
        return float(round(value))
    if value >= 5.0:
        return round(2.0 * value) / 2.0
    return round(10.0 * value) / 10.0


def sample_pitch_deviations(gear: Gear, grade: int, seed: int, *, use: float = 0.9) -> dict[str, np.ndarray]:
    """Sampled deviations that reach the share `use` of the governing tolerance; equal arguments give equal values.

    They are clearances (tooth,) in m along the transverse line of action, by flank, "drive" and "coast". A positive
    value sets the flank back, so that its pair touches later. Values have either sign and zero mean over each flank:
    delta = 0 remains the position of the average tooth. Deviations along the pitch circle are the clearance divided by
    cos alpha_t, with the opposite sign.

    The sample is an eccentricity (in both flanks, with a phase of plus and minus the pressure angle) plus an
    independent random part of each flank. It is scaled so that the largest single pitch deviation is at most use * f_pT
    and the range of the cumulative deviation at most use * F_pT, one of them exactly, over both flanks.

    Parameters
    ----------
    gear : the gear whose teeth deviate
    grade : int, tolerance class of ISO 1328-1
    seed : int, of the random numbers
    use : (0, 1], share of the tolerance

    Raises
    ------
    GeometryError : outside ISO 1328-1
    """
    tolerance = pitch_tolerance(gear, grade)
    draw = np.random.default_rng(seed)
    direction = draw.uniform(0.0, 2.0 * math.pi)
    scatter = draw.uniform(-1.0, 1.0, size=(2, gear.teeth)) * 0.5 * tolerance.single
    # tooth i + 1 follows tooth i, so it is one pitch behind it in the direction of rotation
    angle = direction + 2.0 * math.pi / gear.teeth * np.arange(gear.teeth)
    alpha = gear.transverse_pressure_angle
    eccentric = 0.5 * ECCENTRIC_PART * tolerance.cumulative * np.array([-np.sin(angle + alpha), np.sin(angle - alpha)])
    arc = eccentric + scatter
    arc -= arc.mean(axis=1, keepdims=True)
    single = np.abs(arc - np.roll(arc, 1, axis=1)).max()
    scale = use * min(tolerance.single / single, tolerance.cumulative / np.ptp(arc, axis=1).max())
    clearance = arc * scale * math.cos(alpha)
    return {"drive": clearance[0], "coast": clearance[1]}
