"""Halves that hold together by bolts: the cone of VDI 2230, rings of springs, and the limits of a glued housing."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
import skfem
from factored_casing import factored
from housings import small_housing
from scipy.sparse.linalg import eigsh

from fem.casing.geometry.housing_features import Flange
from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.mesh.mesh import MeshError
from fem.casing.parts.bolted_joint import BoltedJoint, contact_areas, joint_stiffness
from fem.casing.parts.bolts import Bolt, BoltError
from fem.casing.parts.split_mesh import SplitPlane, split_mesh
from fem.casing.reduced.casing_modes import casing_modes, natural_modes
from fem.casing.reduced.checkup import check_up
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.reduction import reduce_body
from fem.elements.materials import CAST_IRON, Material
from fem.elements.solids import mass_properties, rigid_body_modes

HARD = Material(name="hard", elastic_modulus=1e15, poisson_ratio=0.3, density=7850.0)
PLANE = SplitPlane(through=(0.0, 0.0, 0.1), normal=(0.0, 0.0, 1.0))


def test_the_cone_of_a_published_example():
    """M12 in a piston of a hydraulic cylinder: tan phi 0.566, limiting diameter 44.9 mm, delta_P 0.3546e-6 mm/N.

    S. Voigt, Schraubenverbindungen: Tragfaehigkeitsnachweis nach VDI 2230, exercises of Hochschule Anhalt.
    """
    bolt = Bolt(diameter=0.012, pitch=0.00175, head=0.02111, hole=0.0135, clamped=(0.021, 0.021), outer=0.08)
    assert bolt.cone_slope == pytest.approx(0.566, abs=5e-4)
    assert bolt.contact_diameter == pytest.approx(0.0449, abs=5e-5)
    assert bolt.clamped_resilience(210e9) == pytest.approx(0.3546e-9, rel=1e-3)


@pytest.mark.parametrize("tapped", [False, True])
@pytest.mark.parametrize("outer", [0.012, 0.016, 0.020, 0.028, 0.060])
def test_the_resilience_is_the_integral_over_the_cone(tapped, outer):
    """dz/(E A(z)) with A between the hole and the cone or, where this is narrower, the outer diameter."""
    bolt = Bolt.of_size("M10", clamped=(0.014, 0.010), tapped=tapped, outer=outer)
    z = (np.arange(200000) + 0.5) / 200000 * bolt.length
    from_end = z if tapped else np.minimum(z, bolt.length - z)
    wide = np.minimum(bolt.head + 2 * from_end * bolt.cone_slope, outer)
    exact = np.mean(4 / (np.pi * (wide**2 - bolt.hole**2))) * bolt.length / 110e9
    assert bolt.clamped_resilience(110e9) == pytest.approx(exact, rel=1e-6)


def test_a_bolt_is_a_chain_of_bars():
    """M10 x 24: head 0.5 d, nut 0.4 d on the nominal section, thread 24 mm + 0.5 d on the core; by hand."""
    bolt = Bolt.of_size("M10", clamped=(0.012, 0.012))
    nominal, core = np.pi / 4 * 0.010**2, np.pi / 4 * (0.010 - 1.22687 * 0.0015) ** 2
    chain = (0.9 * 0.010 / nominal + (0.024 + 0.005) / core) / 205e9
    assert bolt.bolt_resilience(110e9) == pytest.approx(chain, rel=1e-12)
    assert bolt.stiffness(110e9) == pytest.approx(1 / chain + 1 / bolt.clamped_resilience(110e9))
    tapped = replace(bolt, tapped=True).bolt_resilience(110e9)
    chain = (0.5 / 205e9 + 0.33 / 110e9) * 0.010 / nominal + (0.012 + 0.005) / core / 205e9
    assert tapped == pytest.approx(chain, rel=1e-12)


def test_bolts_that_clamp_nothing_are_refused():
    with pytest.raises(BoltError, match="outer diameter 10 mm leave nothing around a hole of 11 mm"):
        Bolt.of_size("M10", clamped=(0.012, 0.012), outer=0.010)


SIDES = (0.1, 0.1, 0.2)


def finished(nodes, elements, element):
    """A mesh whose underside is `ground_1`."""

    def patches(surface):
        bottom = (surface.corners[..., 2] < 1e-9).all(axis=1)
        return {"ground_1": np.flatnonzero(bottom)}, {"ground_1": np.zeros(3)}

    raw = RawMesh(nodes=nodes, elements=elements)
    return finished_mesh(raw, patches, name="blocks", element=element, element_size=0.02, remedy="")


def blocks(pieces=(6, 6, 2), element="hexahedron-20"):
    """A block of 100 x 100 x 200 mm, or two that touch at mid height."""
    mesh = skfem.MeshHex.init_tensor(*(np.linspace(0, s, n + 1) for s, n in zip(SIDES, pieces, strict=True)))
    return finished([-0.05, -0.05, 0.2] + mesh.p.T * [1, 1, -1], mesh.t.T, element)  # left-handed as they are made


def tetrahedral_blocks():
    """The same of tetrahedra."""
    mesh = skfem.MeshTet.init_tensor(*(np.linspace(0, s, n + 1) for s, n in zip(SIDES, (6, 6, 2), strict=True)))
    nodes, elements = mesh.p.T - [0.05, 0.05, 0.0], mesh.t.T.copy()
    turned = np.linalg.det(nodes[elements][:, 1:] - nodes[elements][:, :1]) < 0
    elements[turned] = elements[turned][:, [0, 2, 1, 3]]
    return finished(nodes, elements, "tetrahedron-10")


def above(mesh):
    """Elements (e,) of the upper block."""
    return mesh.nodes[mesh.elements].mean(axis=1)[:, 2] > 0.1


def joint(*places, stiffness=None, bolt=None):
    bolt = bolt or Bolt.of_size("M20", clamped=(0.03, 0.03))
    return BoltedJoint(plane=PLANE, bolt=bolt, places=places, stiffness=stiffness)


def frequencies(casing, count=6):
    theta, _ = block_lanczos(casing.interface.factor.solve, casing.M_free, count=count)
    return 1 / (2 * np.pi * np.sqrt(theta))


def test_a_split_keeps_volume_surface_and_patches():
    mesh = blocks()
    split = split_mesh(mesh, PLANE)
    assert mass_properties(split.mesh.nodes, split.mesh.elements, 1.0)[0] == pytest.approx(0.002)
    assert len(split.mesh.nodes) - len(mesh.nodes) == (mesh.nodes[:, 2] == 0.1).sum()
    assert np.array_equal(split.mesh.nodes[split.below], split.mesh.nodes[split.above])
    assert len(split.mesh.facets) == len(mesh.facets) + 2 * 36
    bottom = split.mesh.patch("ground_1")
    assert np.array_equal(np.sort(bottom.ravel()), np.sort(mesh.patch("ground_1").ravel()))
    assert not np.intersect1d(split.below, split.mesh.elements[above(split.mesh)]).size
    assert not np.intersect1d(split.above, split.mesh.elements[~above(split.mesh)]).size


def test_planes_that_cut_elements_or_touch_none_are_refused():
    with pytest.raises(MeshError, match=r"36 of 72 elements cross this plane, one around"):
        split_mesh(blocks(), replace(PLANE, through=(0.0, 0.0, 0.05)))
    with pytest.raises(MeshError, match="no facet of the mesh lies in it"):
        split_mesh(blocks(), replace(PLANE, through=(0.0, 0.0, 0.2)))


def test_a_rigid_motion_strains_no_bolt():
    split = split_mesh(blocks(), PLANE)
    K = joint_stiffness(joint((0.02, 0.01, 0.1), (-0.03, 0.0, 0.1)), split, CAST_IRON)
    R = rigid_body_modes(split.mesh.nodes)
    assert abs(K @ R).max() < 1e-12 * abs(K).max()
    assert abs(K - K.T).max() < 1e-14 * abs(K).max()


@pytest.mark.parametrize("element", ["hexahedron-20", "hexahedron-27", "tetrahedron-10"])
def test_the_ring_of_a_bolt_holds_translation_tilt_and_twist_as_by_hand(element):
    """Of a ring with radii r, R: k_n, k_t, k_n (R^2 + r^2)/4 about a diameter, k_t (R^2 + r^2)/2 about its axis."""
    mesh = tetrahedral_blocks() if element.startswith("tetra") else blocks(element=element)
    split = split_mesh(mesh, PLANE)
    place = (0.01, -0.005, 0.1)
    held = joint(place, stiffness=(3e8, 2e8))
    K, areas = joint_stiffness(held, split, CAST_IRON), contact_areas(held, split)
    inner, outer = held.bolt.hole / 2, held.bolt.contact_diameter / 2
    assert areas[0] == pytest.approx(np.pi * (outer**2 - inner**2), rel=0.03)
    R = rigid_body_modes(split.mesh.nodes, np.array(place))
    upper = np.unique(split.mesh.elements[above(split.mesh)])
    moved = np.zeros_like(R)
    rows = (3 * upper[:, None] + np.arange(3)).ravel()
    moved[rows] = R[rows]
    square = (outer**2 + inner**2) / 2
    expected = [2e8, 2e8, 3e8, 3e8 * square / 2, 3e8 * square / 2, 2e8 * square]
    assert np.diag(moved.T @ K @ moved) == pytest.approx(expected, rel=0.02)


def test_a_hard_block_on_a_bolt_swings_as_a_rigid_body_on_springs():
    """The upper block on the ring: six frequencies from its mass matrix and the stiffness by hand."""
    mesh, held = blocks(), joint((0.0, 0.0, 0.1), stiffness=(3e8, 2e8))
    casing = factored(assembled_casing(mesh, HARD, interfaces={}, joint=held))
    found = frequencies(casing)
    inner, outer = held.bolt.hole / 2, held.bolt.contact_diameter / 2
    square = (outer**2 + inner**2) / 2
    K = np.diag([2e8, 2e8, 3e8, 3e8 * square / 2, 3e8 * square / 2, 2e8 * square])
    m, side = 7850.0 * 1e-3, 0.1
    J = m * side**2 / 6
    to_centre = rigid_body_modes(np.array([[0.0, 0.0, side / 2]]))  # motion of the centre by that of the ring
    M = m * to_centre.T @ to_centre + np.diag([0, 0, 0, J, J, J])
    expected = np.sqrt(la.eigh(K, M, eigvals_only=True)) / (2 * np.pi)
    assert found == pytest.approx(expected, rel=0.01)


def test_stiff_bolts_over_all_of_the_interface_glue_it():
    """A disk that covers everything: with its stiffness the frequencies rise, from below, to those of one block.

    Up to 0.4 %, by which the functions at the rim of the clamped end differ where the block is in two.
    """
    mesh, closeness = blocks(pieces=(3, 3, 2), element="hexahedron-20"), 5e-3
    glued = frequencies(factored(assembled_casing(mesh, CAST_IRON, interfaces={})))
    wide = Bolt(diameter=1e-6, pitch=1e-7, head=0.2, hole=1e-6, clamped=(0.05, 0.05), outer=0.5)
    before = np.zeros(6)
    for size in (1e7, 1e9, 1e11, 1e13):
        held = joint((0.0, 0.0, 0.1), stiffness=(size, size), bolt=wide)
        found = frequencies(factored(assembled_casing(mesh, CAST_IRON, interfaces={}, joint=held)))
        assert (found > before).all()
        assert (found < glued * (1 + closeness)).all()
        before = found
    assert before == pytest.approx(glued, rel=closeness)


def test_more_and_larger_rings_hold_better():
    mesh = blocks(pieces=(4, 4, 2))
    corners = [(x, y, 0.1) for x in (-0.03, 0.03) for y in (-0.03, 0.03)]
    glued = frequencies(factored(assembled_casing(mesh, CAST_IRON, interfaces={})))
    one, two, four = (
        frequencies(factored(assembled_casing(mesh, CAST_IRON, interfaces={}, joint=joint(*corners[:n]))))
        for n in (1, 2, 4)
    )
    assert (one < two).all()
    assert (two < four).all()
    assert (four < glued).all()


def test_springs_of_the_cone_do_not_depend_on_the_mesh():
    place = (0.01, 0.0, 0.1)
    coarse, fine = (
        frequencies(factored(assembled_casing(blocks(pieces=(n, n, 2)), CAST_IRON, interfaces={}, joint=joint(place))))
        for n in (4, 12)
    )
    assert coarse == pytest.approx(fine, rel=0.02)


@pytest.mark.parametrize("slip", [6e6, 6e7, 6e8])
def test_two_planks_bolted_along_their_length_bend_as_a_beam_with_slip(slip):
    """Simply supported, first bending: EI = 2 E I + E A*h^2 / (1 + pi^2 E A* s/(K L^2)), A* = A/2.

    Newmark, Siess & Viest (1951), Proc. SESA 9(1), 75-92. Twelve bolts, s apart, of K each; planks of height h.
    """
    length, wide, high, count = 0.6, 0.04, 0.02, 12
    grid = (np.linspace(0, length, 25), np.linspace(0, wide, 3), np.linspace(0, 2 * high, 3))
    mesh = skfem.MeshHex.init_tensor(*grid)
    planks = finished([0.0, -wide / 2, 2 * high] + mesh.p.T * [1, 1, -1], mesh.t.T, "hexahedron-20")
    thirds = np.where(planks.facet_patch == 0, np.arange(len(planks.facets)) % 3, planks.facet_patch)
    feet = ("ground_1", "ground_2", "ground_3")  # on springs, so that the matrices are those of the free body
    planks = replace(planks, facet_patch=thirds, patch_names=feet, patch_points=np.zeros((3, 3)))
    stuff = replace(CAST_IRON, poisson_ratio=0.0)
    places = tuple(((i + 0.5) * length / count, 0.0, high) for i in range(count))
    held = BoltedJoint(
        plane=SplitPlane(through=(0.0, 0.0, high), normal=(0.0, 0.0, 1.0)),
        bolt=Bolt.of_size("M10", clamped=(high, high), outer=0.03),
        places=places,
        stiffness=(1e11, slip),
    )
    casing = assembled_casing(planks, stuff, interfaces={}, joint=held, ground="springs")
    nodes = casing.mesh.nodes
    fixed = np.zeros((len(nodes), 3), bool)
    fixed[:, 1] = True  # bends in one plane
    fixed[(nodes[:, 0] < 1e-9) | (nodes[:, 0] > length - 1e-9), 2] = True
    fixed[np.abs(nodes - [length / 2, 0.0, high]).sum(axis=1).argmin(), 0] = True
    free = np.flatnonzero(~fixed.ravel())
    K, M = (matrix[free][:, free].tocsc() for matrix in (casing.K_free, casing.M_free))
    found = np.sqrt(eigsh(K, 1, M, sigma=0.0, return_eigenvectors=False)[0]) / (2 * np.pi)
    E, area = stuff.elastic_modulus, wide * high
    apart = np.pi**2 * E * (area / 2) * (length / count) / (slip * length**2)
    bending = 2 * E * wide * high**3 / 12 + E * area / 2 * high**2 / (1 + apart)
    expected = np.pi / (2 * length**2) * np.sqrt(bending / (2 * area * stuff.density))
    assert found == pytest.approx(expected, rel=0.01)  # less what shear takes off, 0.6 % of the stiffest


def test_a_bolt_where_nothing_touches_is_refused():
    with pytest.raises(MeshError, match=r"do not touch around bolt 2 at \(200, 0, 100\) mm"):
        factored(assembled_casing(blocks(), CAST_IRON, interfaces={}, joint=joint((0.0, 0.0, 0.1), (0.2, 0.0, 0.1))))


FLANGED = replace(
    small_housing(boss_diameters=(0.065, 0.080)), flange=Flange(split=0.0, width=0.025, height=0.024), bolted=True
)


@pytest.fixture(scope="module")
def flanged():
    return mesh_housing(FLANGED, element_size=0.06)


BOLTS = (
    *((x, y, 0.0) for x in (-0.08, 0.13, 0.2) for y in (-0.0925, 0.0925)),
    *((x, y, 0.0) for x in (-0.0825, 0.2025) for y in (-0.05, 0.05)),
)  # along the flange, beside the bosses


def test_a_bolted_housing_is_softer_than_a_glued_one_and_passes_the_check_up(flanged):
    plane = SplitPlane(through=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0))
    held = BoltedJoint(plane=plane, bolt=Bolt.of_size("M10", clamped=(0.012, 0.012)), places=BOLTS)
    found = {}
    for name, option in (("glued", None), ("bolted", held)):
        casing = factored(assembled_casing(flanged, CAST_IRON, joint=option))
        reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=10)
        assert check_up(casing, reduction).failures == ()
        modes = casing_modes(casing, reduction, model="craig-bampton", band_limit=0.0)
        found[name] = natural_modes(modes)
    assert (found["bolted"].frequencies[:10] < found["glued"].frequencies[:10]).all()
    assert found["bolted"].part_names == ("joints",)
    assert (found["bolted"].shares[0, :10] > 0).all()
    assert found["bolted"].total[0] == pytest.approx(found["glued"].total[0], rel=1e-12)
