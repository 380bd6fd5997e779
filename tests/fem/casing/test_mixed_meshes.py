"""Meshes of hexahedra, wedges, pyramids and tetrahedra together: divided into tetrahedra between the same nodes."""

import math

import meshio
import numpy as np
import pytest

from benchmarks.solids import box_mesh
from fem.casing.geometry.locators import ByBox, ByCylinder, ByGroup
from fem.casing.imported.matrix_checks import lowest_frequencies
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.gmsh_session import session
from fem.casing.mesh.imported_housing import ImportedHousing, Seat, content_hash
from fem.casing.mesh.mesh_file import read_quietly
from fem.casing.mesh.sizes import Sizes
from fem.casing.models.casing_model import Structure
from fem.casing.models.craig_bampton import CraigBamptonCasing
from fem.casing.recognition.read_geometry import geometry_contents
from fem.elements.division import divided
from fem.elements.facets import corner_triangles, outer_facets
from fem.elements.materials import CAST_IRON
from fem.elements.solid_elements import SOLIDS, ElementError, converted, curved
from fem.elements.solids import assemble, mass_properties

SIZES = Sizes(element=0.02)
IRON = {"elastic_modulus": 1.1e11, "poisson_ratio": 0.26, "density": 7200.0}
FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
EDGES = {
    5: ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)),
    6: ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    8: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
}


def grid(seed, quadratic):
    """A block of 3 x 3 x 3 mm whose cells are hexahedra, a column of wedges, and cells of six pyramids; any numbering.

    Inner corners stand where chance puts them, so that no side of an inner element is flat.
    """
    chance = np.random.default_rng(seed)
    nodes, cells = box_mesh((3.0, 3.0, 3.0), (3, 3, 3), element="hexahedron-8")
    cells = cells[:, SOLIDS["hexahedron-8"].in_vtk]
    inside = ((nodes > 0.1) & (nodes < 2.9)).all(axis=1)
    nodes = nodes + np.where(inside[:, None], chance.uniform(-0.15, 0.15, nodes.shape), 0.0)
    middle = nodes[cells].mean(axis=1)
    column = (abs(middle[:, 0] - 0.5) < 0.3) & (abs(middle[:, 1] - 0.5) < 0.3)
    cored = ~column & (chance.uniform(size=len(cells)) < 0.4)
    wedges = np.vstack([cells[column][:, list(own)] for own in ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))])
    tops = len(nodes) + np.arange(cored.sum())
    # a face of the cell as the base of a pyramid is seen from the apex counter-clockwise
    pyramids = np.vstack([np.column_stack([cells[cored][:, list(face[::-1])], tops]) for face in FACES])
    nodes = np.vstack([nodes, middle[cored]])
    number = chance.permutation(len(nodes))
    places = np.empty_like(nodes)
    places[number] = nodes
    blocks = [number[block] for block in (cells[~column & ~cored], wedges, pyramids)]
    return with_middles(places, blocks) if quadratic else (places, blocks)


def with_middles(nodes, blocks):
    """The same with a node in the middle of every edge."""
    pairs = np.vstack([np.sort(block[:, edge], axis=1) for block in blocks for edge in EDGES[block.shape[1]]])
    edges, which = np.unique(pairs, axis=0, return_inverse=True)
    which, start, made = which.ravel() + len(nodes), 0, []
    for block in blocks:
        count = len(EDGES[block.shape[1]]) * len(block)
        made.append(np.column_stack([block, which[start : start + count].reshape(-1, len(block)).T]))
        start += count
    return np.vstack([nodes, nodes[edges].mean(axis=1)]), made


@pytest.mark.parametrize("quadratic", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_elements_of_every_kind_are_divided_without_gap_or_overlap(seed, quadratic):
    """The tetrahedra fill the block, all of them upright, and none has a side inside that is not shared."""
    nodes, blocks = grid(seed, quadratic)
    nodes, elements = divided(nodes, blocks)
    assert elements.shape[1] == (10 if quadratic else 4)
    hexahedra, wedges, pyramids = map(len, blocks)
    assert len(elements) == 6 * hexahedra + 3 * wedges + 2 * pyramids
    nodes, elements = converted(nodes, elements, SOLIDS["tetrahedron-4"])
    mass, centre, _ = mass_properties(nodes, elements, 1.0)
    assert mass == pytest.approx(27.0, rel=1e-12)
    assert centre == pytest.approx([1.5, 1.5, 1.5], rel=0.01)
    assert len(corner_triangles(outer_facets(nodes, elements))) == 2 * 6 * 9


def test_the_middle_of_a_diagonal_lies_on_the_side_of_the_element():
    """One straight hexahedron of 20 nodes, one bent: the sides of the tetrahedra follow the bend of the edges."""
    nodes, blocks = with_middles(*unit_cube())
    straight, elements = divided(nodes, blocks)
    assert not curved(straight, elements).any()
    top = nodes[:, 2] > 0.9
    bent = nodes.copy()
    bent[:, 2] += np.where(top, 0.2 * bent[:, 0] * (1 - bent[:, 0]), 0.0)  # a parabola along x
    places, elements = divided(bent, blocks)
    on_top = places[np.isclose(straight[:, 2], 1.0)]
    assert on_top[:, 2] == pytest.approx(1.0 + 0.2 * on_top[:, 0] * (1 - on_top[:, 0]), abs=1e-12)
    assert mass_properties(*converted(places, elements, SOLIDS["tetrahedron-10"]), 1.0)[0] == pytest.approx(
        1.0 + 0.2 / 6, rel=1e-12
    )


def unit_cube():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    return corners, [np.arange(8)[None]]


def test_mid_side_nodes_are_known_by_their_places():
    """The order of a Nastran CHEXA, in which the upright edges stand before the upper ones."""
    nodes, (cell,) = with_middles(*unit_cube())
    other = cell[:, [*range(12), *range(16, 20), *range(12, 16)]]
    same = [divided(nodes, [one]) for one in (cell, other)]
    assert np.array_equal(same[0][1], same[1][1])
    nodes[cell[0, 9]] = nodes[cell[0, 14]]
    with pytest.raises(ElementError, match=r"mid-side nodes do not lie near .* one of the hexahedra near \(0.5, 0.5"):
        divided(nodes, [cell])


def test_what_does_not_fit_together_is_refused():
    nodes, (cell,) = unit_cube()
    above = np.vstack([nodes, [[0.5, 0.5, 1.5]]])
    tetrahedra = np.array([[4, 5, 6, 8], [4, 6, 7, 8]])
    with pytest.raises(
        ElementError, match=r"2 triangles lie on quadrilaterals .* near \(0\.\d+, 0\.\d+, 1\) mm.*pyramid"
    ):
        divided(above, [cell, tetrahedra])
    quadratic, (bent,) = with_middles(nodes, [cell])
    with pytest.raises(ElementError, match="1 hexahedra of 20 nodes, 1 pyramids of 5 nodes"):
        divided(np.vstack([quadratic, [[0.5, 0.5, 1.5]]]), [bent, np.array([[4, 5, 6, 7, 20]])])


def test_a_missing_pyramid_between_a_hexahedron_and_tetrahedra_is_refused():
    """As gmsh writes universal files. The four tetrahedra hold the sides of the pyramid; with it all is one body."""
    nodes, (cell,) = unit_cube()
    more = np.array([[0.5, 0.5, 1.5], [0.5, -0.5, 1.4], [1.5, 0.5, 1.4], [0.5, 1.5, 1.4], [-0.5, 0.5, 1.4]])
    every = np.vstack([nodes, more])
    around = np.array([[4, 5, 8, 9], [5, 6, 8, 10], [6, 7, 8, 11], [7, 4, 8, 12]])
    assert len(divided(every, [cell, around, np.array([[4, 5, 6, 7, 8]])])[1]) == 6 + 4 + 2
    with pytest.raises(ElementError, match=r"1 pyramids are missing .* near \(0\.5, 0\.5, 1\) mm: gmsh writes none"):
        divided(every, [cell, around])


MIXED = ("msh", "inp", "bdf", "unv", "med", "vtu")
INNER, TALL = 0.006, 0.020


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A plate with a bore of 12 mm, half of it bricks of 20 nodes, half wedges of 15, in every format."""
    made = tmp_path_factory.mktemp("mixed")
    with session() as gmsh:
        occ = gmsh.model.occ
        plain, bored = occ.addRectangle(0, 0, 0, 30, 30), occ.addRectangle(30, 0, 0, 30, 30)
        occ.cut([(2, bored)], [(2, occ.addDisk(45, 15, 0, 6, 6))])
        occ.fragment([(2, plain)], [(2, bored)])
        occ.synchronize()
        gmsh.model.mesh.setTransfiniteSurface(plain)
        gmsh.model.mesh.setRecombine(2, plain)
        occ.extrude(gmsh.model.getEntities(2), 0, 0, 20, [2], recombine=True)
        occ.synchronize()
        for option, value in {
            "Mesh.MeshSizeMax": 8,
            "Mesh.MeshSizeFromCurvature": 12,
            "Mesh.SecondOrderIncomplete": 1,
            "Mesh.BdfFieldFormat": 0,
        }.items():
            gmsh.option.setNumber(option, value)
        gmsh.model.mesh.generate(3)
        seat = gmsh.model.getEntitiesInBoundingBox(38, 8, -1, 52, 22, 21, 2)
        seat = [tag for _, tag in seat if gmsh.model.getType(2, tag) != "Plane"]
        gmsh.model.addPhysicalGroup(2, seat, 7, "SEAT")
        gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], 8, "BODY")
        gmsh.model.mesh.setOrder(2)
        for name in MIXED[:5]:
            gmsh.write(str(made / f"plate.{name}"))
    mesh = read_quietly(made / "plate.msh")
    meshio.Mesh(mesh.points, mesh.cells).write(made / "plate.vtu")
    return made


def plate(path, **changes):
    locator = ByCylinder(through=(0.045, 0.015, 0.01), diameter=2 * INNER, axis=(0.0, 0.0, 1.0))
    usual = {
        "path": str(path),
        "sha256": content_hash(path),
        "unit": "mm",
        "seats": (Seat(name="bearing_1", locator=locator),),
        "grounds": (ByBox(box=((-1.0, -1.0, -1.0), (1e-6, 1.0, 1.0))),),
    }
    return ImportedHousing(**(usual | changes))


def frequencies(mesh):
    modes, found = CraigBamptonCasing(band=30000.0).reduction(Structure(material=CAST_IRON)).build(mesh=mesh)
    assert not found.failures
    return modes.fixed_frequencies[:6]


@pytest.fixture(scope="module")
def native(folder):
    return mesh_geometry(plate(folder / "plate.msh"), SIZES)


def test_a_mixed_mesh_has_the_volume_and_the_bore_of_its_body(folder, native):
    assert "hexahedra" in native.divided
    assert "wedges" in native.divided
    volume = 0.06 * 0.03 * TALL - math.pi * INNER**2 * TALL
    assert mass_properties(native.nodes, native.elements, 1.0)[0] == pytest.approx(volume, rel=2e-4)
    contents = geometry_contents(folder / "plate.msh")
    assert contents.bores[0].diameter == pytest.approx(2 * INNER, rel=1e-3)
    assert native.patch("bearing_1").shape[1] == 6


@pytest.mark.parametrize("name", MIXED[1:])
def test_a_mixed_mesh_in_another_format_is_the_same_body(folder, native, name):
    mesh = mesh_geometry(plate(folder / f"plate.{name}"), SIZES)
    assert mesh.divided == native.divided
    assert frequencies(mesh) == pytest.approx(frequencies(native), rel=1e-6)


@pytest.mark.parametrize("name", ["msh", "inp", "unv", "med"])
def test_a_group_of_quadrilaterals_and_triangles_is_a_seat_of_a_mixed_mesh(folder, native, name):
    mesh = mesh_geometry(
        plate(folder / f"plate.{name}", seats=(Seat(name="bearing_1", locator=ByGroup(group="SEAT")),)), SIZES
    )
    assert len(mesh.patch("bearing_1")) == len(native.patch("bearing_1"))


def test_divided_hexahedra_have_the_frequencies_of_whole_ones_within_their_error():
    """A beam of 27-node bricks, whole and as tetrahedra between the same nodes: stiffer, by little."""
    nodes, elements = box_mesh((0.06, 0.03, 0.03), (5, 2, 2), element="hexahedron-27")
    cut = divided(nodes, [elements[:, SOLIDS["hexahedron-27"].in_vtk]])
    assert len(cut[0]) == len(nodes)

    def elastic(nodes, elements):
        return lowest_frequencies(*assemble(nodes, elements, **IRON), 16)[0][6:]

    whole, parts = elastic(nodes, elements), elastic(*converted(*cut, SOLIDS["tetrahedron-10"]))
    assert (parts > whole).all()
    assert np.median(parts / whole - 1) < 0.02
    assert (parts / whole - 1).max() < 0.05
