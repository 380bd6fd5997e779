"""Stress of the surface of a fillet from its displacement: exact solutions, and finer sections of a tooth."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from benchmarks.gear_pairs import gear
from fem.contact.models.solid import PATCH, SECTION
from fem.contact.models.solid_stress import ROOT_LAYERS, _LoadedSector, _surface_von_mises
from fem.contact.wheels.ring import FlankCompliance, flank_loads
from fem.elements.materials import STEEL
from fem.elements.sections import stiffness
from fem.gears.sector_mesh import sector_mesh
from fem.numerics.quadratic_grids import cells_of, with_middles

YOUNG, POISSON = STEEL.elastic_modulus, STEEL.poisson_ratio


def surface_stress(mesh, local, ends):
    """`_LoadedSector.surface_stress` of displacements (axial node, section node, 3)."""
    return _LoadedSector.surface_stress(SimpleNamespace(mesh=mesh, material=STEEL, ends=ends), local[None])[0]


def in_plane_strain(mesh, fixed, motion, loads):
    """Displacements (section node, 2) with given ones of the nodes `fixed`."""
    matrix = stiffness(mesh.points, mesh.elements, YOUNG, POISSON)
    held = (2 * np.asarray(fixed)[:, None] + [0, 1]).ravel()
    free = np.setdiff1d(np.arange(matrix.shape[0]), held)
    out = np.zeros(matrix.shape[0])
    out[held] = motion.ravel()
    out[free] = spsolve(matrix[free][:, free], loads[free] - matrix[free] @ out)
    return out.reshape(-1, 2)


def largest_in_plane_strain(mesh, plane):
    local = np.broadcast_to(np.pad(plane, ((0, 0), (0, 1))), (3, len(plane), 3))
    stress = surface_stress(mesh, local, np.array([0.0, 1e-3]))
    np.testing.assert_allclose(stress[..., 1], POISSON * stress[..., 0], atol=1e-9 * abs(stress).max())
    return _surface_von_mises(stress).max() / np.sqrt(1 - POISSON + POISSON**2)


def plate_with_a_hole(first, count):
    """Quarter of a plate around a hole of radius 1 m: `count` elements around, of the size `first` (m) at the hole."""
    radius = with_middles(1 + first * (1.5 ** np.arange(count + 1) - 1) / 0.5)
    angle = with_middles(np.linspace(0.0, np.pi / 2, count + 1))
    r, t = (one.ravel() for one in np.meshgrid(radius, angle, indexing="ij"))
    nodes = np.arange(r.size).reshape(len(radius), len(angle))
    points = np.column_stack([r * np.cos(t), r * np.sin(t)])
    mesh = SimpleNamespace(points=points, elements=cells_of(nodes).reshape(-1, 9), twist=0.0, fillet=nodes[0])
    edge = np.concatenate([nodes[-1], nodes[:-1, 0], nodes[:-1, -1]])
    return mesh, edge, r, t


def kirsch(r, t):
    """Displacement (node, 2), m, of a plate under a tension of 1 Pa along x (Kirsch, 1898), in plane strain."""
    kappa, shear = 3 - 4 * POISSON, YOUNG / (2 + 2 * POISSON)
    radial = r * (kappa - 1 + 2 * np.cos(2 * t)) + 2 / r * (1 + (kappa + 1) * np.cos(2 * t)) - 2 / r**3 * np.cos(2 * t)
    around = (-2 * r + 2 / r * (1 - kappa) - 2 / r**3) * np.sin(2 * t)
    x, y = radial * np.cos(t) - around * np.sin(t), radial * np.sin(t) + around * np.cos(t)
    return np.column_stack([x, y]) / (8 * shear)


def test_the_stress_concentration_of_a_hole_is_three():
    """With three elements on a quarter of the hole, as on a fillet, the error is 3 %; it falls almost as h^2."""
    errors = []
    for size in (1, 2, 4):
        mesh, edge, r, t = plate_with_a_hole(0.5 / size, 3 * size)
        mesh.fillet = mesh.fillet[::-1]
        exact = kirsch(r, t)
        found = in_plane_strain(mesh, edge, exact[edge], np.zeros(exact.size))
        stress = surface_stress(
            mesh, np.broadcast_to(np.pad(found, ((0, 0), (0, 1))), (3, len(r), 3)), np.array([0.0, 1.0])
        )
        errors.append(abs(stress[0, :, 0] - (1 - 2 * np.cos(2 * t[mesh.fillet[2:-1]]))).max() / 3)
    assert errors[0] < 0.05
    assert errors[2] < errors[1] / 3


def test_a_uniform_strain_gives_the_plane_stress_of_the_tangent_plane():
    mesh, z = sector_mesh(gear(25, helix_deg=20), 1.0), np.linspace(-6e-3, 6e-3, 17)
    gradient = np.random.default_rng(1).normal(size=(3, 3))
    local, turns = [], []
    for height in z:
        c, s = np.cos(mesh.twist * height), np.sin(mesh.twist * height)
        turns.append(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
        points = np.column_stack([mesh.points, np.zeros(len(mesh.points))]) @ turns[-1].T + [0, 0, height]
        local.append(points @ gradient.T @ turns[-1])
    found = surface_stress(mesh, np.array(local), z[::2])
    line = mesh.points[mesh.fillet]
    x, y = line[2:-1].T
    arc = np.append(0.0, np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum())
    first = np.pad(np.gradient(line, arc, axis=0)[2:-1], ((0, 0), (0, 1)))
    first /= np.linalg.norm(first, axis=1)[:, None]
    helix = np.column_stack([-mesh.twist * y, mesh.twist * x, np.ones(len(x))])
    second = helix - (helix * first).sum(axis=1)[:, None] * first
    second /= np.linalg.norm(second, axis=1)[:, None]
    for stress, turn in zip(found, turns, strict=True):
        strain = turn.T @ (gradient + gradient.T) @ turn / 2
        one, two, both = (
            np.einsum("ni,ij,nj->n", a, strain, b) for a, b in ((first, first), (second, second), (first, second))
        )
        exact = np.column_stack([one + POISSON * two, two + POISSON * one, (1 - POISSON) * both])
        exact *= YOUNG / (1 - POISSON**2)
        assert abs(stress - exact).max() < 0.01 * abs(exact).max()


@pytest.mark.parametrize("teeth", [20, 55])
def test_the_coarse_section_of_the_model_finds_the_stress_of_a_fine_one(teeth):
    """Stresses extrapolated to the surface from the Gauss points of the elements are 6 to 9 % too small there."""
    own, largest = gear(teeth), []
    for refinement in (SECTION, 2.0):
        mesh = sector_mesh(own, refinement, layers=ROOT_LAYERS)
        flank = FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={})
        loads = flank_loads(mesh) @ flank.patches(np.array([0.6 * mesh.tip_arc]), PATCH * own.normal_module)[0][0]
        held = np.concatenate([mesh.bore, mesh.cut_bore, mesh.cut_low, mesh.cut_high])
        largest.append(largest_in_plane_strain(mesh, in_plane_strain(mesh, held, np.zeros((len(held), 2)), loads)))
    assert largest[0] == pytest.approx(largest[1], rel=0.02)
