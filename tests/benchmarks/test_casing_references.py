"""References of casing frequencies: graded meshes of the same body, cubic elements, and one half for the whole."""

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse.linalg as sla

from benchmarks.casing_limits.__main__ import BLOCK, PAGE, RESULTS, table
from benchmarks.casing_limits.cubic import cubic_matrices, numbered
from benchmarks.casing_limits.graded import SHARE, graded, singular_edges
from benchmarks.casing_limits.housings import drum
from benchmarks.casing_limits.reference import half_mesh, half_modes
from benchmarks.page import filled
from benchmarks.solids import box_mesh
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.uncertainty.extrapolation import lowest_modes
from fem.casing.uncertainty.pairing import counterparts
from fem.elements.materials import CAST_IRON
from fem.elements.solids import assemble, mass_properties, rigid_body_modes

SIZE = np.array([0.1, 0.08, 0.06])
LAMINA = {"elastic_modulus": 110e9, "poisson_ratio": 0.26, "density": 7200.0}


@pytest.fixture(scope="module")
def box():
    """A box on its bottom, one half at y < 0; y = 0 is a side of it."""
    nodes, elements = box_mesh(SIZE * [1.0, 0.5, 1.0], (2, 1, 2), distortion=0.15)
    return nodes - [0.0, SIZE[1] / 2, 0.0], elements


def bent(nodes):
    """The same nodes on a curved body."""
    return nodes + np.column_stack([np.zeros(len(nodes)), np.zeros(len(nodes)), 0.1 * nodes[:, 0] ** 2])


def held(nodes):
    return nodes[:, 2] < 1e-9


def lowest(stiffness, mass, nodes, count=6):
    """Hz of a body on its lowest plane."""
    free = np.flatnonzero(np.repeat(~held(nodes), 3))
    values = sla.eigsh(stiffness[free][:, free], count, mass[free][:, free], sigma=0.0, return_eigenvectors=False)
    return np.sqrt(np.sort(values)) / (2.0 * np.pi)


def step_mesh():
    """A step of two cells below and one above, whose one inner edge is straight along y."""
    nodes, elements = box_mesh((2.0, 1.0, 2.0), (2, 1, 2))
    middle = nodes[elements[:, :4]].mean(axis=1)
    kept = elements[~((middle[:, 0] > 1.0) & (middle[:, 2] > 1.0))]
    used, own = np.unique(kept, return_inverse=True)
    return nodes[used], own.reshape(kept.shape)


def test_the_inner_edge_of_a_step_is_found_and_no_outer_one():
    nodes, elements = step_mesh()
    found = np.array(np.divmod(singular_edges(nodes, elements, np.zeros(len(nodes), bool)), 1 << 32)).T
    assert nodes[found[:, 0], [0]] == pytest.approx(1.0)
    assert nodes[found.ravel()][:, [0, 2]] == pytest.approx(1.0)
    assert np.ptp(nodes[found.ravel()][:, 1]) == pytest.approx(1.0)


def test_the_rim_of_a_clamped_face_is_found():
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    clamped = nodes[:, 2] < 1e-9
    ends = nodes[np.array(np.divmod(singular_edges(nodes, elements, clamped), 1 << 32))]
    assert ends.shape[1] == 8
    assert ends[..., 2] == pytest.approx(0.0)
    assert np.isclose(ends.mean(axis=0)[:, :2] % 1.0, 0.0).any(axis=1).all()


@pytest.mark.parametrize("levels", [1, 2])
def test_a_graded_mesh_is_the_same_body_with_thin_elements_at_its_edges(levels):
    nodes, elements = step_mesh()
    nodes = bent(nodes)
    finer, parts = graded(nodes, elements, np.zeros(len(nodes), bool), levels)
    for one, other in zip(mass_properties(nodes, elements, 1.0), mass_properties(finer, parts, 1.0), strict=True):
        assert other == pytest.approx(one, rel=1e-9, abs=1e-12)
    edge, corners = np.array([1.0, 1.1]), np.unique(parts[:, :4])
    distance = np.linalg.norm(finer[corners][:, [0, 2]] - edge, axis=1)
    nearest = np.unique(distance.round(6))[1]
    assert nearest == pytest.approx(SHARE**levels, rel=0.1)


def test_cubic_elements_hold_quadratic_displacements_and_no_energy_in_rigid_motion(box):
    nodes, elements = box
    places, stiffness, mass = cubic_matrices(nodes, elements, CAST_IRON)
    quadratic = np.column_stack([places[:, 0] * places[:, 1], places[:, 2] ** 2, -places[:, 0] * places[:, 2]]).ravel()
    K, _ = assemble(nodes, elements, **LAMINA)
    same = np.column_stack([nodes[:, 0] * nodes[:, 1], nodes[:, 2] ** 2, -nodes[:, 0] * nodes[:, 2]]).ravel()
    scale = CAST_IRON.elastic_modulus / LAMINA["elastic_modulus"]
    assert CAST_IRON.poisson_ratio == LAMINA["poisson_ratio"]
    assert quadratic @ stiffness @ quadratic == pytest.approx(scale * (same @ K @ same), rel=1e-9)
    assert abs(stiffness @ rigid_body_modes(places)).max() < 1e-9 * abs(stiffness).max()
    moved = rigid_body_modes(places)[:, :3]
    assert moved.T @ mass @ moved == pytest.approx(CAST_IRON.density * SIZE.prod() / 2 * np.eye(3), rel=1e-9)


def test_richer_elements_are_softer(box):
    """Ten nodes on a mesh, cubic ones on it, and cubic ones on its parts hold one another (Ritz)."""
    nodes, elements = box
    K, M = assemble(nodes, elements, **LAMINA)
    ten = lowest(K, M, nodes)
    parts = graded(nodes, elements, held(nodes), 1)
    twenty, divided = (
        lowest(stiffness, mass, places)
        for places, stiffness, mass in (cubic_matrices(*mesh, CAST_IRON) for mesh in (box, parts))
    )
    assert (twenty < ten).all()
    assert (divided < twenty).all()
    assert divided == pytest.approx(twenty, rel=0.05)


def test_halves_have_the_modes_of_the_whole(box):
    nodes, elements = graded(*box, held(box[0]), 0)
    places, stiffness, mass = cubic_matrices(*mirrored(nodes, elements), CAST_IRON)
    whole = lowest(stiffness, mass, places, count=8)
    found, shapes, unknowns = half_modes(nodes, elements, CAST_IRON, 0, 1.02 * whole[-1])
    assert unknowns == 3 * numbered(elements)[1]
    assert found[:8] == pytest.approx(whole, rel=1e-6)
    assert shapes.shape == (3 * 216, len(found))


def mirrored(nodes, elements):
    """A half and its mirror image about y = 0 as one mesh."""
    both = np.concatenate([nodes, nodes * [1.0, -1.0, 1.0]])
    _, first, same = np.unique(np.round(both, 9), axis=0, return_index=True, return_inverse=True)
    turned = elements[:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]  # so that images are not inside out
    return both[first], same.ravel()[np.concatenate([elements, turned + len(nodes)])]


def test_the_page_shows_the_figures_that_were_measured():
    text = PAGE.read_text(encoding="utf-8")
    results = json.loads(RESULTS.read_text(encoding="utf-8"))["housings"]
    assert filled(text, BLOCK, table(results)) == text, "run: python -m benchmarks.casing_limits"


@pytest.mark.slow
def test_the_reference_of_a_drum_is_softer_than_the_mesh_of_the_preset_and_has_its_modes(tmp_path: Path):
    case = drum(tmp_path)
    tested = lowest_modes(
        assembled_casing(mesh_geometry(case.geometry, case.sizes, case.element), case.material), static=False
    )
    mesh = half_mesh(case.build, 0.03, 6.0)
    found, shapes, _ = half_modes(*mesh, case.material, 1, 1.02 * tested.frequencies[11])
    number = counterparts(tested.shapes[:, :10], shapes)
    assert (number >= 0).all()
    error = tested.frequencies[:10] / found[number] - 1.0
    assert (error > 0.0).all()
    assert 0.01 < error.mean() < 0.03
