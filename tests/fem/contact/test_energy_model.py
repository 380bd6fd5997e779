"""Model energy: exact cantilevers, published tooth compliances, limits, and its bias against model plane."""

import math
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair, line_length
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.faults.cracked_tooth import CrackedTooth
from fem.contact.models.energy import Energy, foundation_factors, tooth_parts
from fem.contact.models.plane import Plane
from fem.contact.slice_frame import ModelError
from fem.contact.wheels.cantilever import cantilever
from fem.elements.materials import Material
from fem.gears.path import path_points


def test_cantilever_of_constant_section():
    """Timoshenko: L^3 / (3 E I) + 1.2 L / (G A); along the axis L / (E A)."""
    young, shear, length, half = 200e9, 80e9, 5e-3, 1e-3
    u, y = np.linspace(0, length, 4001), np.full(4001, half)
    bending, shearing, _ = cantilever(u, y, length, 0.0, 0.0, young, shear)
    assert bending == pytest.approx(length**3 / (3 * young * 2 / 3 * half**3), rel=1e-6)
    assert shearing == pytest.approx(1.2 * length / (shear * 2 * half), rel=1e-9)
    _, _, axial = cantilever(u, y, length, 0.0, math.pi / 2, young, shear)
    assert axial == pytest.approx(length / (young * 2 * half), rel=1e-9)


def test_cantilever_with_a_linear_taper():
    """y = y0 (1 - u / H), load at u = L < H: the integrals of (L - u)^2 / y^3 and 1 / y in closed form."""
    young, shear, height, length, half = 206e9, 79e9, 6e-3, 3.5e-3, 1.5e-3
    u = np.linspace(0, length, 4001)
    bending, shearing, _ = cantilever(u, half * (1 - u / height), length, 0.0, 0.0, young, shear)
    a = height - length  # L - u = v - a with v = H - u
    integral = [math.log(height / a), 2 * a * (1 / height - 1 / a), -(a**2) / 2 * (1 / height**2 - 1 / a**2)]
    assert bending == pytest.approx(1.5 / young * (height / half) ** 3 * sum(integral), rel=1e-5)
    assert shearing == pytest.approx(1.2 / shear * height / (2 * half) * math.log(height / a), rel=1e-5)


def test_published_tooth():
    """z 62, m 2 mm, alpha 20 deg, E 211 GPa, G 81.2 GPa at the pitch circle: what ROSS 2.3.0 (petrobras/ross,
    GearElementTVMS) computes with an integration of its own, in m2/N."""
    pair = gear_pair((62, 62), 2, 0, 20, bores_mm=(17.5, 17.5))
    steel = Material(name="steel", elastic_modulus=211e9, poisson_ratio=211 / 162.4 - 1, density=7810)
    gear = pair.pinion
    roll = np.array([gear.base_radius * math.tan(gear.transverse_pressure_angle)])
    found = tooth_parts(gear, steel, roll)
    assert found.bending[0] == pytest.approx(1.69822e-12, rel=5e-4)
    assert found.shear[0] == pytest.approx(8.71971e-12, rel=5e-4)
    assert found.axial[0] == pytest.approx(3.14825e-13, rel=5e-4)
    # its body, with u_f taken to the contact point and its own root angle, from the same fit
    ratio, theta = 59.5 / 17.5, 0.04565848466736457
    big_l, big_m, big_p, big_q = foundation_factors(ratio, theta)
    alpha = 0.349066
    lever = (gear.reference_radius * math.cos(gear.half_thickness_angle(gear.reference_radius)) - gear.root_radius) / (
        2 * gear.root_radius * theta
    )
    angle = alpha - gear.half_thickness_angle(gear.reference_radius)
    body = big_l * lever**2 + big_m * lever + big_p * (1 + big_q * math.tan(angle) ** 2)
    assert math.cos(angle) ** 2 / 211e9 * body == pytest.approx(3.07205e-11, rel=2e-3)


def test_a_thin_ring_is_softer():
    pair = gear_pair((30, 40), 2, 0, 20, bores_mm=(8.0, 8.0))
    thick, thin = (
        tooth_parts(
            gear_pair((30, 40), 2, 0, 20, bores_mm=(bore, 8.0)).pinion, pair.pinion_material, np.array([0.0095])
        )
        for bore in (17.0, 8.0)
    )
    assert thin.bending == pytest.approx(thick.bending, rel=1e-12)
    assert thin.foundation[0] > thick.foundation[0]  # compliance counted from the bore: more body, more of it


def test_single_pair_against_finite_elements():
    """Spur 20/55 at the pitch point, 2-D contact FE of both rings: c' 15.55 N/(mm um) at 100 N/mm; bias below 5 %."""
    pair = gear_pair((20, 55), 2, 0, 1, bores_mm=(12.5, 37.5))
    path = path_points(pair, np.array([0.0]))
    single = 1.0 / Energy().pair_compliance(pair, path.pinion_radius, path.wheel_radius)[0]
    assert single / 1e9 == pytest.approx(15.5, rel=0.05)


def test_double_contact_is_too_stiff():
    """The known bias: without coupling the two pairs of a spur gear add up, FE finds less."""
    pair = gear_pair((20, 55), 2, 0, 10, bores_mm=(12.5, 17.5))
    cycle = np.array([0.0, 0.5])
    energy = stiffness_curve(Energy(slices=1).laws(pair)[0], 1000.0, cycle).secant
    plane = stiffness_curve(Plane(slices=1).laws(pair)[0], 1000.0, cycle).secant
    bias = energy / plane - 1
    assert bias[1] > bias[0] + 0.05


def test_spur_limit_and_shape():
    """beta -> 0 gives the spur law; the mean follows the length of the contact lines."""
    cycle = np.linspace(0.05, 0.95, 7)
    slim = LawEvaluator(Energy().laws(gear_pair((20, 55), 2, 1e-6, 12, bores_mm=(12.5, 17.5)))[0]).evaluate(cycle, 5e-6)
    spur = LawEvaluator(Energy().laws(gear_pair((20, 55), 2, 0, 12, bores_mm=(12.5, 17.5)))[0]).evaluate(cycle, 5e-6)
    assert slim.force == pytest.approx(spur.force, rel=1e-4)
    pair = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))
    k = LawEvaluator(Energy(slices=61).laws(pair)[0]).evaluate(cycle, 1e-7).stiffness
    assert np.corrcoef(k, line_length(pair, cycle))[0, 1] > 0.97


def test_coast_flank_is_the_mirror_image():
    right = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))
    drive, coast = Energy().laws(right)
    c = np.linspace(0, 1, 9)
    assert LawEvaluator(coast).evaluate(coast.cycle_offset - c, 4e-6).force == pytest.approx(
        LawEvaluator(drive).evaluate(c, 4e-6).force, rel=1e-12
    )


@pytest.mark.parametrize("options", [{"slices": 0}, {"positions": 8}])
def test_refused_options(options):
    with pytest.raises(ModelError, match=next(iter(options))):
        Energy(**options)


def test_a_crack_takes_the_section_of_the_papers_from_a_beam():
    """Rectangular cantilever with a share of its section cut: bending by (2 y / H)^3, shear by 2 y / H."""
    u, y = np.linspace(0.0, 4e-3, 2001), np.full(2001, 1e-3)
    load = (4e-3, 1e-3, 0.0, 206e9, 79e9)
    sound, cracked = cantilever(u, y, *load), cantilever(u, y, *load, lost=np.full(u.size, 0.5e-3))
    assert cracked[0] / sound[0] == pytest.approx((2.0 / 1.5) ** 3)
    assert cracked[1] / sound[1] == pytest.approx(2.0 / 1.5)
    assert cracked[2] == sound[2]


def test_a_cracked_beam_tooth_grows_softer_with_depth_and_towards_the_tip():
    pair = gear_pair((20, 55), 2, 0, 12, bores_mm=(12.5, 17.5))
    law = Energy(slices=1).law(pair)
    added = [CrackedTooth(depth=q).compliance(law, pair, "pinion")[0] for q in (1e-6, 0.5e-3, 1e-3, 1.5e-3)]
    assert abs(added[0]).max() < 5e-3 * added[-1].max()
    assert all((deeper >= less).all() for less, deeper in pairwise(added))
    inside = np.isfinite(law.gap) & (law.gap == 0.0)
    assert (np.diff(added[-1][inside]) > 0.0).all()  # the pinion is loaded from its root to its tip
