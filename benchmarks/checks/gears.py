"""Gear geometry after ISO 21771, tolerances after ISO 1328-1, mesh stiffness after ISO 6336-1."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.checks.record import Check, Subject, Values
from benchmarks.gear_pairs import gear_pair, kisssoft_helical, kisssoft_spur, line_length
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.models.iso import Iso, blank_factor, rack_factor
from fem.gears.deviations import pitch_tolerance
from fem.gears.geometry import GearPair

KISSSOFT = "KISSsoft report 03/2017, published in gfsReboucas/Drivetrain"
ISO_21771 = "ISO 21771:2007, evaluated independently"
REXS = "SEW_3-stage_cylindrical_gearbox_1.0.rexs and FVA-Industriegetriebe_2stufig_1-4.rexs, public"
ISO_6336 = "ISO 6336-1:2019, clause 9, evaluated independently"


def _standard(helix_deg: float) -> GearPair:
    """z 20/55, m_n 2 mm, b 30 mm."""
    return gear_pair((20, 55), 2, helix_deg, 30)


def _diameters() -> Values:
    pair = kisssoft_helical()
    return [
        2000 * r for gear in (pair.pinion, pair.wheel) for r in (gear.base_radius, gear.tip_radius, gear.root_radius)
    ]


def _centre_distances() -> Values:
    """From the profile shifts, free of backlash."""
    pairs = (
        gear_pair((23, 67), 1, 30, 11, (0.581, 0.5131)),
        gear_pair((13, 76), 1.25, 10, 15, (0.521, -0.094), tip_mm=-0.016855),
        gear_pair((14, 87), 1.5, 10, 36, (0.536, -0.4815)),
        gear_pair((27, 51), 4.5, 21, 50, (0.231415, 0.231415)),
        gear_pair((23, 34), 6.5, 10, 74, (0.15074, 0.15074)),
    )
    return [1000 * pair.axis_distance for pair in pairs]


def _ratios(pair: GearPair) -> Values:
    return [pair.transverse_contact_ratio, pair.overlap_ratio]


def _stiffness(pair: GearPair, **options: float) -> Values:
    found = Iso(**options).stiffness(pair)
    return [value / 1e9 for value in (found.single, found.mean, found.mean_for_distribution)]


def _mean_line() -> Values:
    pair = _standard(15.0)
    mean = line_length(pair, (np.arange(20000) + 0.5) / 20000).mean()
    return [mean * math.cos(pair.base_helix_angle) / pair.face_width / pair.transverse_contact_ratio]


def _missing_line() -> Values:
    pair = _standard(15.0)
    middle = np.array([(pair.xi_start + pair.xi_end) / 2])
    mean = pair.transverse_contact_ratio * pair.face_width / math.cos(pair.base_helix_angle)
    lost = line_length(pair, middle) - line_length(pair, middle, missing=True)
    return [float(lost[0] / mean) * max(pair.transverse_contact_ratio, pair.overlap_ratio)]


def _integer_overlap() -> Values:
    base = gear_pair((20, 55), 2, 12, 12)
    pair = gear_pair((20, 55), 2, 12, 1000 * base.base_pitch / math.tan(base.base_helix_angle))
    eps = pair.transverse_contact_ratio
    length = line_length(pair, np.linspace(-2, 2, 1601), missing=True)
    return [float(length.min()) * math.cos(pair.base_helix_angle) / pair.face_width / (eps - 1.0)]


def _law_mean() -> Values:
    pair = _standard(15.0)
    found = LawEvaluator(Iso().law(pair)).evaluate((np.arange(2000) + 0.5) / 2000, 5e-6).stiffness.mean()
    return [float(found) / (Iso().stiffness(pair).mean * pair.face_width)]


def _tolerances() -> Values:
    pair = gear_pair((20, 55), 2, 12, 12)
    found = [pitch_tolerance(gear, grade) for gear, grade in ((pair.pinion, 5), (pair.wheel, 5), (pair.pinion, 7))]
    return [1e6 * value for one in found for value in (one.single, one.cumulative)]


SUBJECTS = (
    Subject("Gear geometry and tolerances", (
        Check("base, tip, root diameter of pinion and wheel, z 24/95, m_n 14 mm, β 10°, x 0.48/0.6691", KISSSOFT, "mm",
              (320.026, 380.747, 319.623, 1266.770, 1395.376, 1334.252), 1e-3, _diameters,
              "test_involute.py::test_diameters_of_a_published_pair", "absolute"),
        Check("ε_α and ε_β of the same pair", KISSSOFT, "", (1.463, 1.421), 1e-3, lambda: _ratios(kisssoft_helical()),
              "test_involute.py::test_diameters_of_a_published_pair"),
        Check("centre distances of the five stages of two gear units in REXS, from their profile shifts", REXS, "mm",
              (53.0, 57.0, 77.0, 190.0, 190.0), 1e-4, _centre_distances,
              "test_rexs.py::test_profile_shifts_of_the_public_units_give_their_centre_distances"),
        Check("ε_α, z 20/55, m_n 2 mm, b 30 mm, β 0°", ISO_21771, "", (1.6638,), 5e-5,
              lambda: _ratios(_standard(0.0))[:1], "test_involute.py::test_contact_ratios", "absolute"),
        Check("ε_α and ε_β, z 20/55, m_n 2 mm, b 30 mm, β 12°", ISO_21771, "", (1.6140, 0.9927), 5e-5,
              lambda: _ratios(_standard(12.0)), "test_involute.py::test_contact_ratios", "absolute"),
        Check("ε_α and ε_β, z 20/55, m_n 2 mm, b 30 mm, β 15°", ISO_21771, "", (1.5863, 1.2358), 5e-5,
              lambda: _ratios(_standard(15.0)), "test_involute.py::test_contact_ratios", "absolute"),
        Check("mean length of the contact lines divided by ε_α b / cos β_b, z 20/55, β 15°", "exact", "", (1.0,), 1e-4,
              _mean_line, "test_involute.py::test_mean_line_length"),
        Check("share of contact lines lost by a missing tooth at mid-engagement, times max(ε_α, ε_β)", "exact", "",
              (1.0,), 1e-6,
              _missing_line, "test_involute.py::test_line_length_without_a_tooth"),
        Check("least contact line length with a missing tooth and ε_β = 1, divided by (ε_α - 1) b / cos β_b", "exact",
              "", (1.0,), 1e-6, _integer_overlap,
              "test_involute.py::test_integer_overlap_has_a_constant_line_and_a_known_floor"),
        Check("f_pT and F_pT: z 20 class 5, z 55 class 5, z 20 class 7 (m_n 2 mm, β 12°)",
              "ISO 1328-1:2013, 5.3, by hand", "µm", (6.0, 17.0, 6.0, 19.0, 12.0, 34.0), 1e-9, _tolerances,
              "test_pitch_deviations.py::test_tolerances_by_hand", "absolute"),
    )),
    Subject("Mesh stiffness, model iso", (
        Check("C_R (b_s/b 0.25, s_R/m_n 5) and C_B of the helical pair z 24/95", KISSSOFT, "", (0.898, 0.975), 1e-3,
              lambda: [blank_factor(0.25, 5.0), rack_factor(kisssoft_helical().pinion)],
              "test_iso_stiffness.py::test_published_helical_pair"),
        Check("c', c_γα, c_γβ of the helical pair z 24/95 at 666.85 N/mm", KISSSOFT, "N/(mm µm)",
              (13.832, 18.632, 15.837), 1e-3,
              lambda: _stiffness(kisssoft_helical(), blank_factor=blank_factor(0.25, 5.0), line_load=666.85e3),
              "test_iso_stiffness.py::test_published_helical_pair"),
        Check("c', c_γα of the spur pair z 18/36, m 21 mm, C_R 0.862", KISSSOFT, "N/(mm µm)", (12.240, 15.640), 1e-3,
              lambda: _stiffness(kisssoft_spur(), blank_factor=0.862)[:2],
              "test_iso_stiffness.py::test_published_spur_pair"),
        Check("c', c_γα, z 20/55, m_n 2 mm, solid disc, β 0°", ISO_6336, "N/(mm µm)", (13.07, 19.57), 2e-3,
              lambda: _stiffness(_standard(0.0))[:2], "test_iso_stiffness.py::test_standard_arithmetic"),
        Check("c', c_γα, z 20/55, m_n 2 mm, solid disc, β 12°", ISO_6336, "N/(mm µm)", (12.94, 18.90), 2e-3,
              lambda: _stiffness(_standard(12.0))[:2], "test_iso_stiffness.py::test_standard_arithmetic"),
        Check("c', c_γα, z 20/55, m_n 2 mm, solid disc, β 15°", ISO_6336, "N/(mm µm)", (12.87, 18.52), 2e-3,
              lambda: _stiffness(_standard(15.0))[:2], "test_iso_stiffness.py::test_standard_arithmetic"),
        Check("mean tangent stiffness dF/dδ over a pitch divided by c_γα b, z 20/55, β 15°", "exact", "", (1.0,),
              1e-6, _law_mean,
              "test_iso_stiffness.py::test_mean_over_a_pitch_is_the_standard_value"),
    )),
)  # fmt: skip
