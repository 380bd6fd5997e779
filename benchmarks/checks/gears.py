"""Gear geometry after ISO 21771, tolerances after ISO 1328-1, mesh stiffness after ISO 6336-1."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache

import numpy as np

from benchmarks.checks.record import Check, Values
from fem.contact.evaluation.evaluator import evaluate_law
from fem.contact.models.iso import Iso, blank_factor, rack_factor
from fem.gears.deviations import pitch_tolerance
from fem.gears.geometry import Gear, GearPair
from fem.gears.path import line_length

KISSSOFT = "KISSsoft report 03/2017, published in gfsReboucas/Drivetrain"
GEOMETRY, STIFFNESS = "Gear geometry and tolerances", "Mesh stiffness, rung iso"


def pair_of(
    teeth: tuple[int, int],
    module_mm: float,
    helix_deg: float,
    face_mm: float,
    shifts: tuple[float, float] = (0.0, 0.0),
    centre_mm: float | None = None,
    tip_mm: float = 0.0,
    bores_mm: tuple[float, float] = (2.0, 2.0),
) -> GearPair:
    """A steel pair on the rack 1 / 1.25 / 0.38 at 20 degrees; bores are diameters."""
    gears = [
        Gear(
            teeth=z,
            normal_module=module_mm / 1000,
            helix_angle=math.radians(helix_deg),
            face_width=face_mm / 1000,
            profile_shift=x,
            bore_radius=bore / 2000,
            tip_alteration=tip_mm / 1000,
            hand=hand,
        )
        for z, x, bore, hand in zip(teeth, shifts, bores_mm, ("right", "left"), strict=True)
    ]
    centre = None if centre_mm is None else centre_mm / 1000
    return GearPair(pinion=gears[0], wheel=gears[1], centre_distance=centre)


@cache
def helical() -> GearPair:
    """The helical pair of the KISSsoft report: z 24/95, m_n 14 mm, beta 10 deg."""
    return pair_of((24, 95), 14, 10, 360, (0.4800, 0.6691), 861, -0.938, (179.10, 1193.32))


@cache
def spur() -> GearPair:
    """Its spur pair: sun and planet, z 18/36, m 21 mm."""
    return pair_of((18, 36), 21, 0, 550, (0.3890, 0.5039), 584, -1.75)


@cache
def standard(helix_deg: float) -> GearPair:
    """z 20/55, m_n 2 mm, b 30 mm."""
    return pair_of((20, 55), 2, helix_deg, 30)


def _diameters() -> Values:
    pair = helical()
    return [
        2000 * r for gear in (pair.pinion, pair.wheel) for r in (gear.base_radius, gear.tip_radius, gear.root_radius)
    ]


def _ratios(helix_deg: float) -> Values:
    pair = standard(helix_deg)
    return [pair.transverse_contact_ratio, pair.overlap_ratio][: 2 if helix_deg else 1]


def _stiffness(pair: GearPair, **options: float) -> Values:
    found = Iso(**options).stiffness(pair)
    return [value / 1e9 for value in (found.single, found.mean, found.mean_for_distribution)]


def _mean_line() -> Values:
    pair = standard(15.0)
    mean = line_length(pair, (np.arange(20000) + 0.5) / 20000).mean()
    return [mean * math.cos(pair.base_helix_angle) / pair.face_width / pair.transverse_contact_ratio]


def _missing_line() -> Values:
    pair = standard(15.0)
    middle = np.array([(pair.xi_start + pair.xi_end) / 2])
    mean = pair.transverse_contact_ratio * pair.face_width / math.cos(pair.base_helix_angle)
    lost = line_length(pair, middle) - line_length(pair, middle, missing=True)
    return [float(lost[0] / mean) * max(pair.transverse_contact_ratio, pair.overlap_ratio)]


def _integer_overlap() -> Values:
    base = pair_of((20, 55), 2, 12, 12)
    pair = pair_of((20, 55), 2, 12, 1000 * base.base_pitch / math.tan(base.base_helix_angle))
    eps = pair.transverse_contact_ratio
    length = line_length(pair, np.linspace(-2, 2, 1601), missing=True)
    return [float(length.min()) * math.cos(pair.base_helix_angle) / pair.face_width / (eps - 1.0)]


def _law_mean(helix_deg: float) -> Callable[[], Values]:
    def compute() -> Values:
        pair = standard(helix_deg)
        found = evaluate_law(Iso().law(pair), (np.arange(2000) + 0.5) / 2000, 5e-6).stiffness.mean()
        return [float(found) / (Iso().stiffness(pair).mean * pair.face_width)]

    return compute


def _tolerances() -> Values:
    pair = pair_of((20, 55), 2, 12, 12)
    found = [pitch_tolerance(gear, grade) for gear, grade in ((pair.pinion, 5), (pair.wheel, 5), (pair.pinion, 7))]
    return [1e6 * value for one in found for value in (one.single, one.cumulative)]


def checks() -> Iterator[Check]:
    """All rows of this subject."""
    yield Check(
        subject=GEOMETRY,
        quantity="d_b, d_a, d_f of pinion and wheel, z 24/95, m_n 14 mm, β 10°, x 0.48/0.6691",
        source=KISSSOFT,
        unit="mm",
        reference=(320.026, 380.747, 319.623, 1266.770, 1395.376, 1334.252),
        gate=1e-3,
        kind="absolute",
        compute=_diameters,
        test="test_involute.py::test_diameters_of_a_published_pair",
    )
    yield Check(
        subject=GEOMETRY,
        quantity="ε_α and ε_β of the same pair",
        source=KISSSOFT,
        unit="",
        reference=(1.463, 1.421),
        gate=1e-3,
        compute=lambda: [helical().transverse_contact_ratio, helical().overlap_ratio],
        test="test_involute.py::test_diameters_of_a_published_pair",
    )
    for helix, ratios in ((0, (1.6638,)), (12, (1.6140, 0.9927)), (15, (1.5863, 1.2358))):
        yield Check(
            subject=GEOMETRY,
            quantity=f"{'ε_α and ε_β' if helix else 'ε_α'}, z 20/55, m_n 2 mm, b 30 mm, β {helix}°",
            source="ISO 21771:2007, evaluated independently",
            unit="",
            reference=ratios,
            gate=5e-5,
            kind="absolute",
            compute=lambda beta=float(helix): _ratios(beta),
            test="test_involute.py::test_contact_ratios",
        )
    yield Check(
        subject=GEOMETRY,
        quantity="mean length of the contact lines over ε_α b / cos β_b, z 20/55, β 15°",
        source="exact",
        unit="",
        reference=(1.0,),
        gate=1e-4,
        compute=_mean_line,
        test="test_involute.py::test_mean_line_length",
    )
    yield Check(
        subject=GEOMETRY,
        quantity="line lost by a missing tooth at its middle, times max(ε_α, ε_β)",
        source="exact",
        unit="",
        reference=(1.0,),
        gate=1e-6,
        compute=_missing_line,
        test="test_involute.py::test_line_length_without_a_tooth",
    )
    yield Check(
        subject=GEOMETRY,
        quantity="least line length with a missing tooth and ε_β = 1, over (ε_α - 1) b / cos β_b",
        source="exact",
        unit="",
        reference=(1.0,),
        gate=1e-6,
        compute=_integer_overlap,
        test="test_involute.py::test_integer_overlap_has_a_constant_line_and_a_known_floor",
    )
    yield Check(
        subject=GEOMETRY,
        quantity="f_pT and F_pT: z 20 grade 5, z 55 grade 5, z 20 grade 7 (m_n 2 mm, β 12°)",
        source="ISO 1328-1:2013, 5.3, by hand",
        unit="µm",
        reference=(6.0, 17.0, 6.0, 19.0, 12.0, 34.0),
        gate=1e-9,
        kind="absolute",
        compute=_tolerances,
        test="test_deviations.py::test_tolerances_by_hand",
    )
    yield from _stiffness_checks()


def _stiffness_checks() -> Iterator[Check]:
    yield Check(
        subject=STIFFNESS,
        quantity="C_R (b_s/b 0.25, s_R/m_n 5) and C_B of the helical pair",
        source=KISSSOFT,
        unit="",
        reference=(0.898, 0.975),
        gate=1e-3,
        compute=lambda: [blank_factor(0.25, 5.0), rack_factor(helical().pinion)],
        test="test_iso_stiffness.py::test_published_helical_pair",
    )
    yield Check(
        subject=STIFFNESS,
        quantity="c', c_γα, c_γβ of the helical pair at 666.85 N/mm",
        source=KISSSOFT,
        unit="N/(mm µm)",
        reference=(13.832, 18.632, 15.837),
        gate=1e-3,
        compute=lambda: _stiffness(helical(), blank_factor=blank_factor(0.25, 5.0), line_load=666.85e3),
        test="test_iso_stiffness.py::test_published_helical_pair",
    )
    yield Check(
        subject=STIFFNESS,
        quantity="c', c_γα of the spur pair z 18/36, m 21 mm, C_R 0.862",
        source=KISSSOFT,
        unit="N/(mm µm)",
        reference=(12.240, 15.640),
        gate=1e-3,
        compute=lambda: _stiffness(spur(), blank_factor=0.862)[:2],
        test="test_iso_stiffness.py::test_published_spur_pair",
    )
    for helix, values in ((0, (13.07, 19.57)), (12, (12.94, 18.90)), (15, (12.87, 18.52))):
        yield Check(
            subject=STIFFNESS,
            quantity=f"c', c_γα, z 20/55, m_n 2 mm, solid disc, β {helix}°",
            source="ISO 6336-1:2019, clause 9, evaluated independently",
            unit="N/(mm µm)",
            reference=values,
            gate=2e-3,
            compute=lambda beta=float(helix): _stiffness(standard(beta))[:2],
            test="test_iso_stiffness.py::test_standard_arithmetic",
        )
    yield Check(
        subject=STIFFNESS,
        quantity="mean of dF/dδ of the law over a pitch, over c_γα b, β 15°",
        source="exact",
        unit="",
        reference=(1.0,),
        gate=1e-6,
        compute=_law_mean(15.0),
        test="test_iso_stiffness.py::test_mean_over_a_pitch_is_the_standard_value",
    )
