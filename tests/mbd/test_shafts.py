"""Shafts: beam theory, rigid motion, the two models."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh

from mbd.parts.beam import shear_coefficient
from mbd.parts.checks import MachineError
from mbd.parts.shafts import (
    Disk,
    Section,
    ShaftSpec,
    free_shaft,
    rigid_body_modes,
    shaft_basis,
    shaft_nodes,
)

LENGTH, DIAMETER = 0.5, 0.05
AREA, SECOND = math.pi * DIAMETER**2 / 4, math.pi * DIAMETER**4 / 64


def shaft(**changes):
    fields = {
        "name": "shaft_1",
        "x": 0.0,
        "z": 0.0,
        "sense": 1,
        "sections": (Section(y_start=0.0, y_end=LENGTH, outer_diameter=DIAMETER),),
        "element_length": LENGTH / 40,
    }
    return ShaftSpec(**(fields | changes))


def matrices(spec):
    nodes = shaft_nodes(spec)
    part = free_shaft(spec, nodes)
    return nodes, part.mass, part.stiffness


def frequencies(mass, stiffness, fixed):
    free = np.setdiff1d(np.arange(len(mass)), fixed)
    return np.sqrt(np.abs(eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)))


def test_rigid_motion_needs_no_force_and_has_the_mass_of_the_body():
    disk = Disk(name="gear", y=0.2, mass=3.0, polar_inertia=0.02, diametral_inertia=0.01)
    spec = shaft(disks=(disk,))
    nodes, mass, stiffness = matrices(spec)
    rigid = rigid_body_modes(nodes)
    assert abs(stiffness @ rigid).max() < 1e-9 * abs(stiffness).max()
    total = rigid.T @ mass @ rigid
    beam = spec.density * AREA * LENGTH
    assert total[0, 0] == pytest.approx(beam + 3.0, rel=1e-12)
    assert total[4, 4] == pytest.approx(beam * DIAMETER**2 / 8 + 0.02, rel=1e-12)
    tilt = beam * LENGTH**2 / 3 + beam * DIAMETER**2 / 16 + 3.0 * 0.2**2 + 0.01
    assert total[3, 3] == pytest.approx(tilt, rel=1e-12)
    assert total[2, 3] == pytest.approx(beam * LENGTH / 2 + 3.0 * 0.2, rel=1e-12)


@pytest.mark.parametrize(("force", "motion"), [(0, 0), (2, 2), (3, 3), (5, 5)])
def test_cantilever_is_exact_under_end_loads(force, motion):
    spec = shaft(element_length=LENGTH / 3)
    nodes, _, stiffness = matrices(spec)
    answer = np.linalg.solve(stiffness[6:, 6:], np.eye(6 * (len(nodes) - 1))[-6 + force])
    ei = spec.elastic_modulus * SECOND
    shear = shear_coefficient(0.3, 0.0) * spec.elastic_modulus / 2.6 * AREA
    expected = LENGTH**3 / (3 * ei) + LENGTH / shear if force in (0, 2) else LENGTH / ei
    assert answer[-6 + motion] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("plane", [(0,), (2,)])
def test_pinned_beam_has_the_frequencies_of_timoshenko_theory(plane):
    spec = shaft()
    nodes, mass, stiffness = matrices(spec)
    others = [6 * i + a for i in range(len(nodes)) for a in ((1, 2, 3, 4) if plane == (0,) else (0, 1, 4, 5))]
    pins = [plane[0], 6 * (len(nodes) - 1) + plane[0]]
    found = frequencies(mass, stiffness, sorted({*others, *pins}))[:3]
    kappa_g = shear_coefficient(0.3, 0.0) * spec.elastic_modulus / 2.6
    for n, omega in enumerate(found, start=1):
        k, rho, e = n * math.pi / LENGTH, spec.density, spec.elastic_modulus
        # rho^2 I/(kappa G) w^4 - (rho A + rho I k^2 (1 + E/(kappa G))) w^2 + E I k^4 = 0
        a, b = rho**2 * SECOND / kappa_g, rho * AREA + rho * SECOND * k**2 * (1 + e / kappa_g)
        exact = math.sqrt((b - math.sqrt(b * b - 4 * a * e * SECOND * k**4)) / (2 * a))
        assert omega == pytest.approx(exact, rel=5e-4)


def test_a_slender_beam_approaches_euler_theory():
    thin = Section(y_start=0.0, y_end=LENGTH, outer_diameter=0.004)
    spec = shaft(sections=(thin,))
    nodes, mass, stiffness = matrices(spec)
    held = [6 * i + a for i in range(len(nodes)) for a in (1, 2, 3, 4)] + [0, 5]
    radius = math.sqrt(spec.elastic_modulus * (0.004 / 4) ** 2 / spec.density)
    expected = [(x / LENGTH) ** 2 * radius for x in (1.8751040687, 4.6940911330)]  # clamped-free roots
    np.testing.assert_allclose(frequencies(mass, stiffness, held)[:2], expected, rtol=1e-3)


@pytest.mark.parametrize("model", ["timoshenko", "torsion"])
def test_torsion_of_a_clamped_bar(model):
    spec = shaft(model=model)
    nodes, mass, stiffness = matrices(spec)
    basis, names = shaft_basis(spec, nodes)
    mass, stiffness = basis.T @ mass @ basis, basis.T @ stiffness @ basis
    twist = [i for i, name in enumerate(names) if name.endswith(":ry")]
    at = np.ix_(twist[1:], twist[1:])
    first = math.sqrt(eigh(stiffness[at], mass[at], eigvals_only=True)[0])
    wave = math.sqrt(spec.elastic_modulus / 2.6 / spec.density)
    assert first == pytest.approx(math.pi / 2 * wave / LENGTH, rel=1e-3)


def test_the_torsion_model_moves_rigidly_and_keeps_the_mass():
    spec = shaft(model="torsion")
    nodes, mass, stiffness = matrices(spec)
    basis, names = shaft_basis(spec, nodes)
    assert len(names) == 5 + len(nodes)
    assert abs(basis.T @ stiffness @ basis)[:5].max() < 1e-9 * abs(stiffness).max()
    lift = np.tile([0, 0, 1.0, 0, 0, 0], len(nodes))
    assert (basis.T @ mass @ lift)[2] == pytest.approx(spec.density * AREA * LENGTH, rel=1e-12)


def test_steps_and_stations_are_nodes():
    sections = (
        Section(y_start=-0.1, y_end=0.0, outer_diameter=0.03),
        Section(y_start=0.0, y_end=0.2, outer_diameter=0.05, inner_diameter=0.02),
    )
    nodes = shaft_nodes(shaft(sections=sections, element_length=0.06), (0.033,))
    for y in (-0.1, 0.0, 0.033, 0.2):
        assert abs(nodes - y).min() < 1e-12
    assert np.diff(nodes).max() <= 0.06 + 1e-12


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"model": "euler"}, "timoshenko"),
        ({"disks": (Disk(name="far", y=1.0, mass=1, polar_inertia=1, diametral_inertia=1),)}, "not on shaft_1"),
        ({"element_length": 0.0}, "element_length"),
    ],
)
def test_impossible_shafts_are_refused(changes, message):
    with pytest.raises(MachineError, match=message):
        shaft(**changes)


def test_a_shaft_of_too_many_elements_is_refused_with_its_numbers():
    long = shaft(sections=(Section(y_start=0.0, y_end=100.0, outer_diameter=0.1),), element_length=0.004)
    with pytest.raises(
        MachineError, match=r"150006 coordinates, more than 1998.*100000 mm long.*4 mm.*element_length_mm"
    ):
        shaft_nodes(long)
