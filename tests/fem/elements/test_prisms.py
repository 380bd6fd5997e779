"""Twisted prisms of quadratic hexahedra: patch test, rigid motions, nested condensation, rings in space."""

import math

import numpy as np
import pytest
from scipy import sparse

from benchmarks.gear_pairs import gear
from fem.contact.wheels.ring import flank_compliance
from fem.contact.wheels.sector_face_functions import CutFunctions
from fem.contact.wheels.solid_ring import sector_prism, solid_flank
from fem.elements.dissection import Dissection
from fem.elements.nested_condensation import INNER, TIED, CondensationError
from fem.elements.twisted_hexahedra import axial_matrices, product_stiffness, section_blocks, slice_means
from fem.gears.sector_mesh import sector_mesh
from fem.numerics.linear_solver import factorize
from fem.numerics.quadratic_grids import with_middles

YOUNG, POISSON = 206e9, 0.3


def prism_matrix(mesh, ends, twist):
    """Dense stiffness matrix of 16 section elements, points (axial node, section node, 3), nodes inside elements."""
    elements = mesh.elements[-16:]
    nodes, at = np.unique(elements, return_inverse=True)
    at = at.reshape(elements.shape)
    blocks = section_blocks(mesh.points[nodes], at, YOUNG, POISSON, twist, np.ones(16))
    dofs = (3 * at[:, :, None] + np.arange(3)).reshape(-1, 27)
    z = with_middles(ends)
    points = np.zeros((len(z), len(nodes), 3))
    points[..., :2], points[..., 2] = mesh.points[nodes], z[:, None]
    place = dofs[:, None] + 3 * len(nodes) * np.arange(len(z))[:, None]
    return product_stiffness(blocks, axial_matrices(ends), place, points.size), points, at[:, 4]


def test_straight_prism_passes_the_patch_test_and_has_six_rigid_motions():
    """A linear displacement strains evenly: no force on any inner node; its energy is the exact one."""
    mesh = sector_mesh(gear(20), 0.2)
    matrix, points, inside = prism_matrix(mesh, np.array([0.0, 1e-3, 3e-3]), 0.0)
    slope = np.array([[1.0, 0.3, -0.2], [0.1, -0.4, 0.6], [0.5, 0.2, 0.7]]) * 1e-4
    force = (matrix @ (points @ slope.T).ravel()).reshape(points.shape)
    assert abs(force[1:-1][:, inside]).max() < 1e-10 * abs(force).max()
    for motion in (
        *np.eye(3)[:, None, None, :] * np.ones((1, *points.shape)),
        *(np.cross(e, points) for e in np.eye(3)),
    ):
        assert abs(matrix @ motion.ravel()).max() < 1e-9 * abs(matrix).max() * abs(motion).max()


def test_every_unknown_is_eliminated_in_the_smallest_box_that_holds_all_its_elements():
    mesh, layers = sector_mesh(gear(20), 0.2), 3
    filled = np.random.default_rng(2).random((len(mesh.elements), layers)) > 0.2
    found = Dissection(mesh.elements, mesh.grid, np.full(len(mesh.points), 3), filled)
    holds = np.zeros((len(found.boxes), len(mesh.elements), layers), dtype=bool)
    for number, box in enumerate(found.boxes):
        holds[number, box.members, box.low : box.high] = True
        assert not box.halves or (holds[list(box.halves)].sum(axis=0)[filled] == holds[number][filled]).all()
    owners = found.owners()
    for place, node in np.ndindex(owners.shape):
        touching = np.zeros_like(filled)
        touching[(mesh.elements == node).any(axis=1), max((place - 1) // 2, 0) : place // 2 + 1] = True
        touching &= filled
        wanted = [n for n, box in enumerate(holds) if (box | ~touching).all()] if touching.any() else [-1]
        assert owners[place, node] == wanted[0]


def test_twisted_prism_turns_and_slides_without_force_and_tilts_with_little():
    """Turning and sliding are exact in the turned frame; translations across need cos(twist z): error of order h^6."""
    mesh = sector_mesh(gear(20, helix_deg=29), 0.2)
    energies = []
    for elements in (1, 2):
        ends = np.linspace(0.0, 12e-3, elements + 1)
        matrix, points, _ = prism_matrix(mesh, ends, mesh.twist)
        turning, sliding = np.cross([0, 0, 1.0], points) / 20e-3, np.ones(points.shape) * [0, 0, 1.0]
        for motion in (turning, sliding):
            assert abs(matrix @ motion.ravel()).max() < 1e-9 * abs(matrix).max()
        angle = mesh.twist * points[..., 2]
        across = np.stack([np.cos(angle), -np.sin(angle), 0 * angle], axis=-1)
        energies.append(across.ravel() @ matrix @ across.ravel())
    assert math.log2(energies[0] / energies[1]) > 3.5


def test_condensation_equals_the_schur_complement_of_the_assembled_matrix():
    mesh = sector_mesh(gear(12, helix_deg=23), 0.2)
    ends = np.array([-6e-3, -3e-3, 0.0, 6e-3])
    rows = np.array([10, 14])
    prism = sector_prism(mesh, YOUNG, POISSON, ends, rows, CutFunctions(radial=None, axial=None))
    numbers, found = prism.condense()
    dofs = (3 * mesh.elements[:, :, None] + np.arange(3)).reshape(-1, 27)
    at, size = (np.repeat(dofs, 27, axis=1).ravel(), np.tile(dofs, (1, 27)).ravel()), 3 * len(mesh.points)
    plane, mixed, along = (sparse.csr_matrix((block.ravel(), at), shape=(size, size)) for block in prism.blocks)
    axial = axial_matrices(ends)
    across = sparse.kron(axial[1], mixed)
    matrix = sparse.kron(axial[0], plane) + across + across.T + sparse.kron(axial[2], along)
    matrix = matrix.tocsr()
    roles = np.tile(prism.roles.ravel(), 2 * len(ends) - 1)
    inner = np.flatnonzero(roles == INNER)
    kept = numbers[numbers < prism.size]
    tied = np.flatnonzero(roles == TIED)
    node, place = tied // 3 % len(mesh.points), tied // (3 * len(mesh.points))
    order = []  # full cut: every tied unknown is one function
    for n, z, c in zip(node, place, tied % 3, strict=True):
        weights, columns = prism.ties.rows(np.array([n]), np.array([z]), np.array([c]))
        order.append(columns[np.argmax(weights[0])])
    border = np.concatenate([kept, tied[np.argsort(order)]])
    right = matrix[inner][:, border].toarray()
    answer = factorize(matrix[inner][:, inner]).solve(right)
    schur = matrix[border][:, border].toarray() - right.T @ answer
    assert abs(found - schur).max() < 1e-9 * abs(schur).max()


def test_an_unheld_or_void_part_is_refused():
    mesh = sector_mesh(gear(20), 0.2)
    prism = sector_prism(mesh, -YOUNG, POISSON, np.linspace(0, 1e-2, 3), np.array([10]), CutFunctions())
    with pytest.raises(CondensationError, match="not positive definite"):
        prism.condense()


def test_slice_means_are_exact_for_quadratics():
    ends, bounds = np.array([-1.0, -0.4, 0.5, 1.0]), np.linspace(-1, 1, 6)
    z = with_middles(ends)
    exact = np.diff(bounds**3 / 3 + bounds**2 - 2 * bounds) / np.diff(bounds)
    assert slice_means(ends, bounds) @ (z**2 + 2 * z - 2) == pytest.approx(exact, rel=1e-12)


# --- rings ------------------------------------------------------------------------------------------------------------


DEFAULT = CutFunctions()


def ring(g, elements=4, refinement=0.2, cut=DEFAULT, reach=1, rows=(8, 12, 16)):
    mesh = sector_mesh(g, refinement)
    ends = np.linspace(-g.face_width / 2, g.face_width / 2, elements + 1)
    return mesh, ends, solid_flank(mesh, YOUNG, POISSON, ends, np.array(rows), reach, cut)


def test_compliances_are_reciprocal_positive_and_mirror_at_mid_face_when_straight():
    _mesh, _ends, flank = ring(gear(13, helix_deg=17))
    own, other = flank.matrix[0], flank.matrix[1]
    assert abs(own - own.T).max() < 1e-9 * abs(own).max()
    assert abs(other - flank.matrix[-1].T).max() < 1e-9 * abs(own).max()
    assert np.linalg.eigvalsh(np.block([[own, other.T], [other, own]]))[0] > 0
    _, _, flank = ring(gear(13))
    cube = flank.matrix[0].reshape(3, 9, 3, 9)
    assert abs(cube - cube[:, ::-1, :, ::-1]).max() < 1e-8 * abs(cube).max()


def test_few_functions_on_the_cuts_do_for_all_of_their_nodes():
    full = ring(gear(20, helix_deg=12), elements=4, cut=CutFunctions(radial=None, axial=None))[2].matrix
    error = {}
    for radial, axial in ((3, 4), (5, 7)):
        few = ring(gear(20, helix_deg=12), elements=4, cut=CutFunctions(radial=radial, axial=axial))[2].matrix
        error[radial] = max(abs(few[n] - full[n]).max() for n in (0, 1)) / full[0].max()
    assert error[5] < 5e-4
    assert error[5] < error[3]


def test_wind_up_of_the_body_is_that_of_an_annulus():
    """All teeth loaded alike, two bores: the difference is T / (4 pi G b) (1/r1^2 - 1/r2^2) times r_b, exactly."""
    seen, bores = [], (6e-3, 9e-3)
    g = [gear(15, bore_mm=1000 * r, face_mm=6) for r in bores]
    for one in g:
        _, ends, flank = ring(one, elements=2, reach=7)
        load = slice_means(ends, np.array([ends[0], ends[-1]]))[0]
        total = sum(flank.matrix[n].reshape(3, 5, 3, 5)[2, :, 2] for n in range(-7, 8))
        seen.append(load @ total @ load)
    shear = YOUNG / 2 / (1 + POISSON)
    exact = 15 * g[0].base_radius ** 2 / (4 * math.pi * shear * 6e-3) * (bores[0] ** -2 - bores[1] ** -2)
    assert seen[0] - seen[1] == pytest.approx(exact, rel=0.01)


def test_wide_gear_at_mid_face_is_in_plane_strain():
    g = gear(20, face_mm=60)
    mesh, ends, flank = ring(g, elements=8, rows=(12,), reach=0)
    plane = flank_compliance(mesh, YOUNG, POISSON, 1).matrix[0][12, 12]
    slices = slice_means(ends, np.linspace(ends[0], ends[-1], 8))
    seen = slices @ flank.matrix[0] @ slices.mean(axis=0) * g.face_width
    assert seen[3] == pytest.approx(plane, rel=0.005)
    assert seen[0] > 1.005 * plane
