"""Cubic displacements added to ten-node tetrahedra and 20-node hexahedra: orders, other codes of them, bounds."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
from factored_casing import factored
from housings import angle_casing, short_housing
from scipy.sparse.linalg import eigsh
from test_element_order import plate, ring

from benchmarks.casing_limits.cubic import cubic_matrices
from fem.casing.enrichment.added_unknowns import added_functions
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.sizes import Sizes
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.uncertainty.extrapolation import lowest_modes
from fem.elements.cubic import cubic_functions
from fem.elements.cubic_shapes import cubic_shapes
from fem.elements.materials import CAST_IRON, Material
from fem.elements.solid_elements import SOLIDS, rule, shapes
from fem.elements.solids import assemble, lame, rigid_body_modes

UNIT = Material(name="unit", elastic_modulus=1e6, poisson_ratio=0.3, density=1.0)
FREE = np.zeros((0, 6), int)
KINDS = [SOLIDS["tetrahedron-20"], SOLIDS["hexahedron-32"]]


def whole(nodes, elements, material, held=FREE):
    """Functions, stiffness and mass of a free body."""
    functions = cubic_functions(nodes, elements, held)
    constants = {key: getattr(material, key) for key in ("elastic_modulus", "poisson_ratio", "density")}
    return functions, *assemble(nodes, elements, **constants, cubic=functions)


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: kind.name)
def housing(request):
    return mesh_geometry(short_housing(), Sizes(element=0.06), request.param.name)


@pytest.fixture
def few_modes(monkeypatch):
    """The tests compare 20 modes at most."""
    monkeypatch.setattr("fem.casing.uncertainty.extrapolation.MODES", 20)


def lattice(kind, n=33):
    """Points (3, q) of a regular lattice in the reference element."""
    places = np.stack(np.meshgrid(*[np.arange(n + 1)] * 3, indexing="ij")).reshape(3, -1)
    return (places if kind.corners == 8 else places[:, places.sum(axis=0) <= n]) / n


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_functions_vanish_at_all_nodes_and_reach_one(kind):
    values, _ = cubic_shapes(kind, kind.library.doflocs.T)
    assert values[:, : kind.nodes] == pytest.approx(np.eye(kind.nodes), abs=1e-14)
    assert values[:, kind.nodes :] == pytest.approx(0.0, abs=1e-14)
    largest = abs(cubic_shapes(kind, lattice(kind))[0][:, kind.nodes :]).max(axis=0)
    assert largest == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_slopes_are_those_of_the_functions(kind):
    points, step = np.random.default_rng(0).uniform(0.0, 0.3, (3, 20)), 1e-6
    _, slopes = cubic_shapes(kind, points)
    for axis in range(3):
        move = step * np.eye(3)[:, [axis]]
        difference = (cubic_shapes(kind, points + move)[0] - cubic_shapes(kind, points - move)[0]) / (2.0 * step)
        assert slopes[:, :, axis] == pytest.approx(difference, abs=1e-7)


def serendipity(points):
    """The functions (q, 32) and slopes (q, 32, 3) of 32 nodes, from the monomials of superlinear degree three."""
    powers = np.stack(np.meshgrid(*[np.arange(4)] * 3)).reshape(3, -1).T
    powers = powers[np.where(powers > 1, powers, 0).sum(axis=1) <= 3]
    line, ends = np.array([0.0, 1.0, 1.0 / 3.0, 2.0 / 3.0]), np.array([True, True, False, False])
    number = np.stack(np.meshgrid(*[np.arange(4)] * 3)).reshape(3, -1).T
    places = line[number[ends[number].sum(axis=1) >= 2]]
    of_node = np.linalg.inv(np.prod(places[:, None, :] ** powers, axis=2))
    values, slopes = np.prod(points.T[:, None, :] ** powers, axis=2) @ of_node, []
    for axis in range(3):
        lower = np.maximum(powers - np.eye(3, dtype=int)[axis], 0)
        slopes.append((powers[:, axis] * np.prod(points.T[:, None, :] ** lower, axis=2)) @ of_node)
    return values, np.stack(slopes, axis=2)


@pytest.mark.parametrize(("curvature", "closeness"), [(0.0, 1e-9), (0.003, 4e-3)])  # 3 points for those of the nodes
def test_one_hexahedron_is_the_one_with_32_nodes(curvature, closeness):
    """Frequencies of a free element by Lagrange functions of its 32 nodes, integrated with more points."""
    kind = SOLIDS["hexahedron-32"]
    nodes = kind.library.doflocs * [1.0, 0.7, 0.3]
    nodes = nodes + curvature * np.random.default_rng(3).standard_normal(nodes.shape)
    _, K, M = whole(nodes, np.arange(20)[None], UNIT)
    points, weights = rule(kind.library, 11)
    (values, slopes), (_, of_map) = serendipity(points), shapes(kind.library, points)
    assert values.shape[1] == 32
    J = np.einsum("qar,ad->qdr", of_map, nodes)
    volume, gradient = weights * np.linalg.det(J), np.einsum("qar,qrd->qad", slopes, np.linalg.inv(J))
    lam, mu = lame(UNIT.elastic_modulus, UNIT.poisson_ratio)
    G = np.einsum("q,qai,qbj->aibj", volume, gradient, gradient, optimize=True)
    other_K = lam * G + mu * (G.transpose(0, 3, 2, 1) + np.einsum("akbk,ij->aibj", G, np.eye(3)))
    other_M = np.kron((volume * values.T) @ values, np.eye(3))
    found = la.eigvalsh(K.toarray(), M.toarray())[6:40]
    assert found == pytest.approx(la.eigvalsh(other_K.reshape(96, 96), other_M)[6:40], rel=closeness)


def frequency_error(n, element):
    """Of the plate between smooth walls (`test_element_order`); functions on a wall have no part across it."""
    nodes, elements, free = plate(n, element)
    functions, K, M = whole(nodes, elements, UNIT)
    moving = (functions.places > 1e-9) & (functions.places < [1.0 - 1e-9, 1.0 - 1e-9, 1.0 / n - 1e-9])
    added = np.flatnonzero(moving[np.arange(len(functions)), functions.numbers] & (functions.numbers < 2))
    kept = np.concatenate([free, 3 * len(nodes) + added])
    exact = 2.0 * np.pi**2 * lame(UNIT.elastic_modulus, UNIT.poisson_ratio)[1]
    K, M = (matrix[kept][:, kept] for matrix in (K, M))
    return np.sqrt(eigsh(K, 1, M, sigma=0.5 * exact, return_eigenvectors=False)[0] / exact) - 1.0


@pytest.mark.parametrize("element", ["tetrahedron-10", "hexahedron-20"])
def test_errors_of_frequencies_fall_with_the_sixth_power_of_the_size(element):
    coarse, fine = frequency_error(4, element), frequency_error(6, element)
    assert fine > 0.0
    assert np.log(coarse / fine) / np.log(1.5) == pytest.approx(6.0, abs=0.3)


@pytest.mark.parametrize("body", [plate, ring], ids=["straight", "curved"])
def test_frequencies_are_those_of_tetrahedra_with_twenty_nodes(body):
    """Another code of the same displacements, with Lagrange functions (`benchmarks.casing_limits.cubic`)."""
    nodes, elements, _ = body(2, "tetrahedron-10")
    _, K, M = whole(nodes, elements, CAST_IRON)
    _, other_K, other_M = cubic_matrices(nodes, elements, CAST_IRON)
    found, others = (la.eigvalsh(k.toarray(), m.toarray())[6:40] for k, m in ((K, M), (other_K, other_M)))
    assert found == pytest.approx(others, rel=1e-9)


def test_rigid_motions_store_no_energy_and_have_the_mass_of_the_body(housing):
    functions, K, M = whole(housing.nodes, housing.elements, CAST_IRON)
    rigid = np.concatenate([rigid_body_modes(housing.nodes), np.zeros((len(functions), 6))])
    assert abs(K @ rigid).max() < 1e-12 * abs(K).max()
    assert abs(M - M.T).max() < 1e-15 * abs(M).max()
    assert abs(K - K.T).max() < 1e-14 * abs(K).max()


@pytest.mark.parametrize("housing", KINDS[:1], indirect=True)  # hexahedra: test_edge_singularities.py
def test_parts_of_the_body_add_up(housing):
    added = added_functions(housing, CAST_IRON, held=())
    halves = np.array_split(np.arange(len(housing.elements)), 2)
    for all_of_it, *parts in zip(added.matrices(), *(added.matrices(half) for half in halves), strict=True):
        assert abs(all_of_it - sum(parts)).max() < 1e-12 * abs(all_of_it).max()


def test_held_facets_have_no_functions_of_their_own(housing):
    feet = housing.facets_of(housing.patches("ground_"))
    free, held = (cubic_functions(housing.nodes, housing.elements, one) for one in (feet[:0], feet))
    corners = feet[:, : 3 if housing.element.corners == 4 else 4]
    sides = np.stack([corners, np.roll(corners, 1, axis=1)], axis=2).reshape(-1, 2)
    faces = len(feet) if housing.element.corners == 4 else 0
    assert len(free) - len(held) == 3 * (faces + len(np.unique(np.sort(sides, axis=1), axis=0)))
    lowest = housing.nodes[:, 2].min()
    assert held.places[:, 2].min() > lowest + 1e-6


@pytest.mark.parametrize(
    ("housing", "attachment", "ground"),
    [
        (KINDS[0], "mean", "fixed"),
        (KINDS[1], "rigid", "springs"),
        # the other pairs: every element, attachment and ground is in one of the two above
        *(
            pytest.param(kind, attachment, ground, marks=pytest.mark.slow)
            for kind in KINDS
            for attachment, ground in (("mean", "springs"), ("rigid", "fixed"))
        ),
        pytest.param(KINDS[0], "rigid", "springs", marks=pytest.mark.slow),
        pytest.param(KINDS[1], "mean", "fixed", marks=pytest.mark.slow),
    ],
    indirect=["housing"],
)
def test_a_casing_is_softer_than_on_the_same_mesh_without(housing, ground, attachment, few_modes):
    """More displacements to choose from: by Ritz no natural frequency rises, on no ground."""

    def frequencies(mesh):
        casing = assembled_casing(mesh, CAST_IRON, ground=ground, attachment=attachment)
        unknowns.append(casing.expansion.shape[0])
        return lowest_modes(casing, static=False).frequencies

    unknowns = []
    tetrahedra = housing.element.corners == 4
    body = housing if tetrahedra else angle_casing(housing.element.name)  # few edges, whose functions take seconds
    cubic, quadratic = frequencies(body), frequencies(replace(body, cubic=0))
    assert unknowns[0] > 1.4 * unknowns[1]
    assert (cubic < quadratic).all()
    assert np.median(quadratic / cubic) > (1.02 if tetrahedra else 1.004)  # walls of one element


def test_cubic_elements_are_nearer_to_the_limit_than_as_many_unknowns_of_quadratic_ones(few_modes):
    """Hexahedra with functions at edges stand for the limit."""

    def frequencies(size, element):
        mesh = mesh_geometry(short_housing(), Sizes(element=size), element)
        return lowest_modes(assembled_casing(mesh, CAST_IRON), static=False)

    limit = frequencies(0.03, "hexahedron-20").frequencies[:12]
    cubic, quadratic = frequencies(0.04, "tetrahedron-20"), frequencies(0.014, "tetrahedron-10")
    assert cubic.unknowns < 1.2 * quadratic.unknowns
    errors = [np.median(one.frequencies[:12] / limit - 1.0) for one in (cubic, quadratic)]
    assert 0.0 < errors[0] < 0.7 * errors[1]


@pytest.mark.parametrize("housing", KINDS[:1], indirect=True)
def test_the_unknowns_of_the_casing_are_those_of_nodes_and_functions(housing):
    casing = factored(assembled_casing(housing, CAST_IRON))
    assert casing.expansion.shape[0] > 1.5 * 3 * len(housing.nodes)
    assert casing.K_free.shape[0] == casing.expansion.shape[0] - len(casing.clamped)
