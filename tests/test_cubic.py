"""Cubic displacements that are added to ten-node tetrahedra: exact orders, another code of the same element, bounds."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from housings import small_housing
from scipy.sparse.linalg import eigsh
from test_element_order import plate

from benchmarks.casing_limits.cubic import cubic_matrices
from fem.casing.mesh_error.extrapolation import lowest_modes
from fem.casing.meshing.sizes import Sizes
from fem.casing.meshing.source import mesh_geometry
from fem.casing.reduced.grounded import ground_casing
from fem.elements.cubic import cubic_functions, cubic_shapes
from fem.elements.materials import CAST_IRON, Material
from fem.elements.solid_elements import SOLIDS
from fem.elements.solids import assemble, lame, rigid_body_modes

UNIT = Material(name="unit", elastic_modulus=1.0, poisson_ratio=0.3, density=1.0)
FREE = np.zeros((0, 6), int)


def whole(nodes, elements, material, held=FREE):
    """Functions, stiffness and mass of a free body."""
    functions = cubic_functions(nodes, elements, held, material)
    constants = {key: getattr(material, key) for key in ("elastic_modulus", "poisson_ratio", "density")}
    return functions, *functions.added_to(*assemble(nodes, elements, **constants))


@pytest.fixture(scope="module")
def housing():
    return mesh_geometry(small_housing(), Sizes(element=0.05), "tetrahedron-20")


def test_functions_vanish_at_all_nodes_and_reach_one():
    values, _ = cubic_shapes(SOLIDS["tetrahedron-10"].library.doflocs.T)
    assert values[:, :10] == pytest.approx(np.eye(10), abs=1e-14)
    assert values[:, 10:] == pytest.approx(0.0, abs=1e-14)
    lattice = np.array([(x, y, z) for x in range(61) for y in range(61 - x) for z in range(61 - x - y)]).T / 60
    assert abs(cubic_shapes(lattice)[0][:, 10:]).max(axis=0) == pytest.approx(1.0, abs=1e-3)


def test_slopes_are_those_of_the_functions():
    points, step = np.random.default_rng(0).uniform(0.0, 0.3, (3, 20)), 1e-6
    _, slopes = cubic_shapes(points)
    for axis in range(3):
        move = step * np.eye(3)[:, [axis]]
        difference = (cubic_shapes(points + move)[0] - cubic_shapes(points - move)[0]) / (2.0 * step)
        assert slopes[:, :, axis] == pytest.approx(difference, abs=1e-7)


def frequency_error(n):
    """Of the plate between smooth walls (`test_element_order`); functions on a wall have no part across it."""
    nodes, elements, free = plate(n, "tetrahedron-10")
    functions, K, M = whole(nodes, elements, UNIT)
    moving = (functions.places > 1e-9) & (functions.places < [1.0 - 1e-9, 1.0 - 1e-9, 1.0 / n - 1e-9])
    added = np.flatnonzero(moving[np.arange(len(functions)), functions.numbers] & (functions.numbers < 2))
    kept = np.concatenate([free, 3 * len(nodes) + added])
    exact = 2.0 * np.pi**2 * lame(UNIT.elastic_modulus, UNIT.poisson_ratio)[1]
    K, M = (matrix[kept][:, kept] for matrix in (K, M))
    return np.sqrt(eigsh(K, 1, M, sigma=0.5 * exact, return_eigenvectors=False)[0] / exact) - 1.0


def test_errors_of_frequencies_fall_with_the_sixth_power_of_the_size():
    coarse, fine = frequency_error(4), frequency_error(6)
    assert fine > 0.0
    assert np.log(coarse / fine) / np.log(1.5) == pytest.approx(6.0, abs=0.3)


def test_frequencies_are_those_of_tetrahedra_with_twenty_nodes(housing):
    """Another code of the same displacements, with Lagrange functions (`benchmarks.casing_limits.cubic`)."""
    _, K, M = whole(housing.nodes, housing.elements, CAST_IRON)
    _, other_K, other_M = cubic_matrices(housing.nodes, housing.elements, CAST_IRON)
    found, others = (eigsh(k, 12, m, sigma=-1e6)[0][6:] for k, m in ((K, M), (other_K, other_M)))
    assert found == pytest.approx(others, rel=1e-9)


def test_rigid_motions_store_no_energy_and_have_the_mass_of_the_body(housing):
    functions, K, M = whole(housing.nodes, housing.elements, CAST_IRON)
    rigid = np.concatenate([rigid_body_modes(housing.nodes), np.zeros((len(functions), 6))])
    assert abs(K @ rigid).max() < 1e-12 * abs(K).max()
    plain, _ = functions.added_to(*(2 * [sp.csr_matrix((3 * len(housing.nodes),) * 2)]))
    assert abs(M - M.T).max() < 1e-15 * abs(M).max()
    assert abs(plain - plain.T).max() < 1e-15 * abs(plain).max()


def test_parts_of_the_body_add_up(housing):
    functions, _, _ = whole(housing.nodes, housing.elements, CAST_IRON)
    halves = np.array_split(np.arange(len(housing.elements)), 2)
    for all_of_it, *parts in zip(functions.matrices(), *(functions.matrices(half) for half in halves), strict=True):
        assert abs(all_of_it - sum(parts)).max() < 1e-12 * abs(all_of_it).max()


def test_held_facets_have_no_functions_of_their_own(housing):
    feet = housing.facets_of(housing.patches("ground_"))
    free, held = (cubic_functions(housing.nodes, housing.elements, one, CAST_IRON) for one in (feet[:0], feet))
    sides = np.unique(np.sort(feet[:, [0, 1, 1, 2, 0, 2]].reshape(-1, 2), axis=1), axis=0)
    assert len(free) - len(held) == 3 * (len(feet) + len(sides))
    lowest = housing.nodes[:, 2].min()
    assert held.places[:, 2].min() > lowest + 1e-6


@pytest.mark.parametrize("ground", ["fixed", "springs"])
@pytest.mark.parametrize("attachment", ["mean", "rigid"])
def test_a_casing_is_softer_than_on_the_same_mesh_without(housing, ground, attachment):
    """More displacements to choose from: by Ritz no natural frequency rises, on no ground."""

    def frequencies(mesh):
        found = lowest_modes(mesh, CAST_IRON, static=False, ground=ground, attachment=attachment)
        return found.frequencies[:20]

    cubic, quadratic = frequencies(housing), frequencies(replace(housing, cubic=0))
    assert (cubic < quadratic).all()
    assert np.median(quadratic / cubic) > 1.02  # walls of one element


def test_cubic_elements_are_nearer_to_the_limit_than_as_many_unknowns_of_quadratic_ones():
    """Hexahedra with functions at edges stand for the limit."""

    def frequencies(size, element):
        return lowest_modes(mesh_geometry(small_housing(), Sizes(element=size), element), CAST_IRON, static=False)

    limit = frequencies(0.012, "hexahedron-20").frequencies[:12]
    cubic, quadratic = frequencies(0.036, "tetrahedron-20"), frequencies(0.013, "tetrahedron-10")
    assert cubic.unknowns < 1.2 * quadratic.unknowns
    errors = [np.median(one.frequencies[:12] / limit - 1.0) for one in (cubic, quadratic)]
    assert 0.0 < errors[0] < 0.7 * errors[1]


def test_the_unknowns_of_the_casing_are_those_of_nodes_and_functions(housing):
    casing = ground_casing(housing, CAST_IRON)
    assert casing.K.shape[0] > 2 * 3 * len(housing.nodes)
    assert casing.K_free.shape[0] == casing.K.shape[0] - len(casing.clamped)
