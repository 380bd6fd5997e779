"""Hexahedra with functions of the edges where stresses grow without bound: closer, and never too soft."""

import numpy as np
import pytest
from housings import short_housing

from benchmarks.bracket import END, LEG, THICKNESS, bracket, frequencies, matrices
from benchmarks.solids import box_mesh
from fem.casing.enrichment.added_unknowns import added_functions
from fem.casing.enrichment.edge_unknowns import edge_functions
from fem.casing.enrichment.graded_functions import NODES, graded
from fem.casing.enrichment.singular_edges import chains, singular_sides
from fem.casing.enrichment.topology import Topology
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.mesh.sizes import Sizes
from fem.elements.materials import CAST_IRON
from fem.elements.sections import lagrange
from fem.elements.solids import rigid_body_modes


def test_the_re_entrant_edge_and_the_rim_of_the_clamped_end_are_found():
    mesh = bracket()
    topology = Topology(mesh.nodes, mesh.elements, mesh.facets, mesh.facet_patch)
    clamped = topology.patch == 0
    sides = singular_sides(topology, clamped)
    ends = mesh.nodes[topology.ends[sides]]
    along_edge = (abs(ends[..., [0, 2]] - THICKNESS) < 1e-9).all(axis=(1, 2))
    on_rim = (abs(ends[..., 0] - LEG) < 1e-9).all(axis=1)
    assert along_edge.sum() == 3
    assert on_rim.sum() == 2 * (3 + 1)
    assert len(sides) == 3 + 8
    lengths = sorted((len(chain.fans), len(chain.fans[0].sectors)) for chain in chains(topology, clamped))
    assert lengths == [(1, 1), (1, 1), (3, 1), (3, 1), (3, 3)]
    assert len(singular_sides(topology, np.zeros_like(clamped))) == 3


@pytest.mark.parametrize(
    "element",
    [
        "hexahedron-20",
        "hexahedron-27",
        # the functions of hexahedron-20; `test_cubic_elements` and `test_extrapolation` check them beside cubic ones
        pytest.param("hexahedron-32", marks=pytest.mark.slow),
    ],
)
def test_most_of_the_error_goes_and_no_frequency_falls_below_that_of_finer_elements(element):
    """Displacements that are continuous bound every frequency from above."""
    (plain, _), (closer, _) = (frequencies(bracket(2, element), functions=both) for both in (False, True))
    fine, _ = frequencies(bracket(3, element))
    assert (plain > closer).all()
    assert (closer > fine).all()
    assert (closer / fine - 1.0).max() < 0.12 * (plain / fine - 1.0).max()


@pytest.mark.parametrize("element", ["hexahedron-20", "hexahedron-32"])
def test_rigid_motions_need_no_force_and_nodes_keep_their_own_entries(element):
    mesh = bracket(element=element)
    K, M, _ = matrices(mesh)
    plain, masses, _ = matrices(mesh, functions=False)
    n = 3 * len(mesh.nodes)
    assert abs(K[:n, :n] - plain).max() == abs(M[:n, :n] - masses).max() == 0.0
    assert abs(K - K.T).max() <= 1e-12 * abs(K).max()
    motions = np.zeros((K.shape[0], 6))
    motions[:n] = rigid_body_modes(mesh.nodes)
    assert abs(K @ motions).max() < 1e-12 * abs(K).max()
    values = np.linalg.eigvalsh(K.toarray())
    assert values[:6] == pytest.approx(0.0, abs=1e-9 * values[-1])
    assert values[6] > 1e-6 * values[-1]


@pytest.mark.parametrize("element", ["hexahedron-20", "hexahedron-32"])
def test_a_turned_bracket_has_the_same_frequencies(element):
    turn, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))
    turn *= np.linalg.det(turn)
    turned, _ = frequencies(bracket(element=element, move=lambda places: places @ turn.T))
    assert turned == pytest.approx(frequencies(bracket(element=element))[0], rel=1e-8)


@pytest.mark.parametrize("element", ["hexahedron-20", "hexahedron-32"])
def test_parts_of_the_body_add_up(element):
    mesh = bracket(element=element)
    edges = added_functions(mesh, CAST_IRON, held=(END,))
    halves = np.array_split(np.arange(len(mesh.elements)), 2)
    for whole, *parts in zip(edges.matrices(), *(edges.matrices(half) for half in halves), strict=True):
        assert abs(whole - sum(parts)).max() < 1e-12 * abs(whole).max()


def test_a_block_without_edges_and_tetrahedra_have_no_functions():
    nodes, elements = box_mesh((0.1, 0.1, 0.1), (2, 2, 2), element="hexahedron-20")
    block = finished_mesh(
        RawMesh(nodes=nodes, elements=elements),
        lambda surface: ({"bearing_1": np.arange(2)}, {"bearing_1": np.zeros(3)}),
        name="block", element="hexahedron-20", element_size=0.05, remedy="",
    )  # fmt: skip
    assert not len(edge_functions(block, CAST_IRON, held=()))
    tetrahedra = mesh_geometry(short_housing(), Sizes(element=0.03))
    assert not len(edge_functions(tetrahedra, CAST_IRON, held=tetrahedra.patches("ground_")))


def test_the_rim_of_a_foot_inside_a_floor_has_functions_up_to_its_corners():
    """There they go on into the elements behind, between which they do not vanish, and fade."""
    nodes, elements = box_mesh((0.04, 0.04, 0.01), (4, 4, 1), element="hexahedron-20")
    inside = (abs(nodes - [0.02, 0.02, 0.0]) < [0.0101, 0.0101, 1e-9]).all(axis=1)
    mesh = finished_mesh(
        RawMesh(nodes=nodes, elements=elements, node_sets={"foot": np.flatnonzero(inside)}),
        lambda surface: ({"ground_1": np.flatnonzero(surface.groups["foot"])}, {"ground_1": np.zeros(3)}),
        name="floor", element="hexahedron-20", element_size=0.01, remedy="",
    )  # fmt: skip
    found = edge_functions(mesh, CAST_IRON, held=("ground_1",))
    assert (found.numbers == 0).sum() == 4 * 5  # nodes of the four sides of two elements each, with both ends


def test_graded_functions_hold_what_plain_ones_do():
    t = np.linspace(0.0, 1.0, 41)
    plain, slopes = lagrange(t)
    at_nodes, _ = lagrange(NODES)
    values, own = graded(t)
    assert values @ at_nodes == pytest.approx(plain, abs=1e-12)
    assert own @ at_nodes == pytest.approx(slopes, abs=1e-11)
