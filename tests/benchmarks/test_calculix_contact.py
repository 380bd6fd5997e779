"""The contact model handed to CalculiX: whole wheels that touch at zero approach, seamless between fine and coarse."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from benchmarks.gear_pairs import gear_pair
from benchmarks.peers.contact_deck import ContactModel
from benchmarks.peers.tooth_mesh import Sizes
from benchmarks.peers.wheel_mesh import HEXAHEDRON
from fem.gears.profile import half_tooth_profile

FINE = Sizes(contact=0.06e-3, below=3, above=3, fillet=2, across=4, land=1, layers=3, face=2)
COARSE = Sizes(contact=0.8e-3, below=1, above=1, fillet=1, across=2, land=1, layers=3, face=2)


@pytest.fixture(scope="module")
def model():
    return ContactModel(pair=gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5)), cycle=0.1, fine=FINE, coarse=COARSE)


def test_all_teeth_that_can_touch_are_fine(model):
    assert model.candidates() == [0, 1]


def test_flanks_touch_and_do_not_overlap(model):
    """In the rigid, error-free position the nodes of both contact lines coincide at the middle of the path."""
    pinion, wheel = model.wheels
    shift = np.array([1000.0 * model.pair.axis_distance, 0.0, 0.0])
    first = np.unique(pinion.elements[pinion.flanks[0]])
    second = np.unique(wheel.elements[wheel.flanks[0]])
    apart, _ = cKDTree(pinion.nodes[first]).query(wheel.nodes[second] + shift)
    assert np.sort(apart)[: FINE.face + 1].max() < 1e-9  # mm; one node at every end of an element along the face


@pytest.mark.parametrize("number", [0, 1])
def test_constraints_carry_rigid_motion(model, number):
    wheel = model.wheels[number]
    assert wheel.constraints
    turn = np.cross([0.3, -0.2, 1.0], wheel.nodes) + [1.0, 2.0, 3.0]
    size = np.abs(turn).max()
    for dependent, nodes, weights in wheel.constraints:
        assert weights.sum() == pytest.approx(1.0, abs=1e-12)
        assert np.abs(weights @ turn[nodes] - turn[dependent]).max() < 2e-3 * size


def shape_gradients(point):
    """Gradients (3, 20) of the serendipity hexahedron in the order of HEXAHEDRON."""
    out = np.zeros((3, 20))
    for node, place in enumerate(HEXAHEDRON - 1.0):
        for axis in range(3):
            others = [k for k in range(3) if k != axis]
            if not place.any() or (place == 0).sum() > 1:
                continue
            if (place == 0).any():
                middle = int(np.flatnonzero(place == 0)[0])
                factors = [1 - point[k] ** 2 if k == middle else 1 + place[k] * point[k] for k in range(3)]
                slope = -2 * point[axis] if axis == middle else place[axis]
                out[axis, node] = slope * factors[others[0]] * factors[others[1]] / 4
            else:
                factors, rest = 1 + place * point, (place * point).sum() - 2
                slope = place[axis] * (rest + factors[axis])
                out[axis, node] = slope * factors[others[0]] * factors[others[1]] / 8
    return out


@pytest.mark.parametrize("number", [0, 1])
def test_elements_are_not_inverted_and_fill_the_wheel(model, number):
    """Volume by Gauss points against the area of the true profile times the face width."""
    wheel, gear = model.wheels[number], (model.pair.pinion, model.pair.wheel)[number]
    nodes, volume = wheel.nodes[wheel.elements], 0.0
    places, weights = np.polynomial.legendre.leggauss(3)
    for i, j, k in np.ndindex(3, 3, 3):
        jacobian = np.linalg.det(np.einsum("an,end->ead", shape_gradients(places[[i, j, k]]), nodes))
        assert jacobian.min() > 0.0
        volume += weights[i] * weights[j] * weights[k] * jacobian.sum()
    x, y = np.vstack([half_tooth_profile(gear, 400, 400, 50), [[0.0, 0.0]]]).T
    half = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    area = 2 * gear.teeth * half - math.pi * gear.bore_radius**2
    assert volume == pytest.approx(area * gear.face_width * 1e9, rel=2e-4)


def test_a_missing_tooth_leaves_its_neighbours(model):
    _, wheel = replace(model, missing=0).wheels
    assert set(wheel.flanks) == {1}
    assert len(wheel.elements) < len(model.wheels[1].elements)


@pytest.mark.slow
def test_the_equations_for_other_integrators_are_those_of_the_machine():
    """SciPy's DOP853 on the equations handed to the peers finds the motion that the library finds."""
    from benchmarks.peers.scipy_mesh import gearcase, scipy
    from benchmarks.peers.single_stage import Equations, error, system

    machine = system()
    equations = Equations.of(machine)
    exact = scipy(equations, equations.rate(), "DOP853", 1e-6)
    assert error(gearcase(machine, 2.5e-6), exact) < 1e-3
