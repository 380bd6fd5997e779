"""A casing from a file of hexahedra: a thick ring, its bore the seat of a bearing, held at a strip of its outside."""

import math

import meshio
import numpy as np
import pytest

from benchmarks.solids import box_mesh
from fem.casing.geometry.locators import ByBox, ByCylinder, ByGroup
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.imported_housing import ImportedHousing, Seat, content_hash
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.mesh_file import read_mesh_file, write_fields
from fem.casing.mesh.sizes import Sizes
from fem.casing.models.casing_model import Structure
from fem.casing.models.craig_bampton import CraigBamptonCasing
from fem.casing.reduced.attachment import nearest_surface_point
from fem.elements.facets import corner_triangles, outer_facets, surface_weights
from fem.elements.materials import CAST_IRON
from fem.elements.solid_elements import CHOICES, SOLIDS, converted
from fem.elements.solids import mass_properties

INNER, OUTER, WIDTH = 0.04, 0.06, 0.08  # m, the axis of the ring along y
SIZES = Sizes(element=0.02)
SEAT = ByCylinder(through=(0.0, WIDTH / 2, 0.0), diameter=2 * INNER)
QUADRATIC = [name for name in CHOICES if SOLIDS[name].degree == 2]


def ring(element, around=16):
    """Nodes on the true cylinders, and elements; the first and the last cell around share their nodes."""
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (1, around, 4), element=element)
    radius, angle = INNER + (OUTER - INNER) * nodes[:, 0], 2 * math.pi * nodes[:, 1]
    places = np.column_stack([radius * np.cos(angle), WIDTH * nodes[:, 2], -radius * np.sin(angle)])
    _, first, same = np.unique(np.round(places, 9), axis=0, return_index=True, return_inverse=True)
    return places[first], same.ravel()[elements]


def written(path, element, **more):
    nodes, elements = ring(element)
    kind = SOLIDS[element]
    form = "gmsh22" if path.suffix == ".msh" else None
    cells = [(kind.meshio, elements[:, kind.in_vtk])]
    meshio.write(path, meshio.Mesh(1000 * nodes, cells, **more), file_format=form)
    return path


def housing(path, seat=SEAT, **more):
    return ImportedHousing(
        path=str(path),
        sha256=content_hash(path),
        unit="mm",
        seats=(Seat(name="bearing_1", locator=seat, shaft_point=(0.0, WIDTH / 2, 0.0)),),
        grounds=(ByBox(box=((0.042, -1.0, -0.06), (0.07, 1.0, 0.06))),),
        **more,
    )


def frequencies(mesh):
    modes, found = CraigBamptonCasing(band=8000.0).reduction(Structure(material=CAST_IRON)).build(mesh=mesh)
    assert not found.failures
    return modes.fixed_frequencies[:6]


@pytest.mark.parametrize("element", QUADRATIC)
def test_every_quadratic_element_gives_the_same_ring(tmp_path, element):
    mesh = mesh_geometry(housing(written(tmp_path / "ring.vtu", element)), SIZES, element)
    assert mesh.elements.shape[1] == SOLIDS[element].nodes
    assert mesh.curved
    volume = math.pi * (OUTER**2 - INNER**2) * WIDTH
    assert mass_properties(mesh.nodes, mesh.elements, 1.0)[0] == pytest.approx(volume, rel=1e-4)
    seat, foot = (surface_weights(mesh.nodes, mesh.patch(name))[2].sum() for name in ("bearing_1", "ground_1"))
    assert seat == pytest.approx(2 * math.pi * INNER * WIDTH, rel=1e-4)
    assert foot == pytest.approx(2 * math.pi * OUTER * WIDTH / 4, rel=1e-4)
    about = {  # Hz; coarse, and singular where the ring is held, which hexahedra follow; 7320 Hz with 64 around
        4: [7760.0, 7930.0, 7970.0, 8790.0, 9750.0, 11510.0],
        8: [7500.0, 7850.0, 7930.0, 8600.0, 9610.0, 11400.0],
    }
    assert frequencies(mesh) == pytest.approx(about[SOLIDS[element].corners], rel=0.015)


@pytest.mark.parametrize("element", QUADRATIC)
def test_the_facets_of_a_body_face_outwards_and_close_it(element):
    """int x . n dA over the corner triangles is three times the volume between the corners."""
    nodes, elements = ring(element, around=8)
    corners = nodes[corner_triangles(outer_facets(nodes, elements)).reshape(-1, 3)]
    flow = np.einsum("td,td->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    edge = math.sin(math.pi / 4) * 4  # area of an octagon in a unit circle is 2 sqrt(2)
    assert flow == pytest.approx(edge * (OUTER**2 - INNER**2) * WIDTH, rel=1e-9)


@pytest.mark.parametrize(("given", "wanted"), [("hexahedron-27", "hexahedron-20"), ("hexahedron-20", "hexahedron-27")])
def test_one_hexahedron_becomes_the_other_where_it_was(tmp_path, given, wanted):
    mesh = mesh_geometry(housing(written(tmp_path / "ring.vtu", given)), SIZES, wanted)
    same = mesh_geometry(housing(written(tmp_path / "ring.vtu", wanted)), SIZES, wanted)
    assert mesh.elements.shape == same.elements.shape
    bodies = [mass_properties(m.nodes, m.elements, 1.0) for m in (mesh, same)]
    assert bodies[0][0] == pytest.approx(bodies[1][0], rel=1e-5)


def test_eight_nodes_are_upgraded_on_request_only(tmp_path):
    path = written(tmp_path / "ring.vtu", "hexahedron-8")
    with pytest.raises(MeshError, match=r"has linear elements .*hexahedra.*Set upgrade = true"):
        mesh_geometry(housing(path), SIZES, "hexahedron-20")
    mesh = mesh_geometry(housing(path, upgrade=True), SIZES, "hexahedron-20")
    assert not mesh.curved
    polygon = 8 * math.sin(math.pi / 8) * (OUTER**2 - INNER**2) * WIDTH  # of 16 corners
    assert mass_properties(mesh.nodes, mesh.elements, 1.0)[0] == pytest.approx(polygon, rel=1e-9)


def test_a_group_of_quadrilaterals_is_a_seat(tmp_path):
    nodes, elements = ring("hexahedron-27")
    facets = outer_facets(nodes, elements)
    inside = (np.hypot(nodes[facets, 0], nodes[facets, 2]) < INNER + 1e-9).all(axis=1)
    kind = SOLIDS["hexahedron-27"]
    cells = [(kind.meshio, elements[:, kind.in_vtk]), ("quad9", facets[inside])]
    tags = [np.ones(len(elements), int), np.full(int(inside.sum()), 2)]
    mesh = meshio.Mesh(1000 * nodes, cells, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags})
    mesh.field_data = {"iron": np.array([1, 3]), "SEAT": np.array([2, 2])}
    meshio.write(tmp_path / "ring.msh", mesh, file_format="gmsh22")
    found = mesh_geometry(housing(tmp_path / "ring.msh", seat=ByGroup(group="SEAT")), SIZES, "hexahedron-27")
    assert len(found.patch("bearing_1")) == inside.sum() == 16 * 4


def test_the_nodes_of_a_file_stand_in_the_order_of_vtk():
    """Corners, then edges 01 12 23 30 45 56 67 74 04 15 26 37, then faces -x +x -y +y -z +z, then the middle."""
    kind = SOLIDS["hexahedron-27"]
    places = kind.library.doflocs[kind.in_vtk]
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    assert np.array_equal(places[:8], corners)
    ends = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    assert np.array_equal(places[8:20], [(places[a] + places[b]) / 2 for a, b in ends])
    faces = [[0, 0.5, 0.5], [1, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 1, 0.5], [0.5, 0.5, 0], [0.5, 0.5, 1]]
    assert np.array_equal(places[20:], [*faces, [0.5, 0.5, 0.5]])
    for name in ("hexahedron-8", "hexahedron-20"):
        smaller = SOLIDS[name]
        assert np.array_equal(smaller.library.doflocs[smaller.in_vtk], places[: smaller.nodes])


@pytest.mark.parametrize("element", ["hexahedron-20", "hexahedron-27", "hexahedron-32"])
def test_fields_on_hexahedra_are_read_back(tmp_path, element):
    mesh = mesh_geometry(housing(written(tmp_path / "ring.vtu", element)), SIZES, element)
    write_fields(mesh, {"place": mesh.nodes}, tmp_path / "out.vtu")
    assert np.array_equal(read_mesh_file(tmp_path / "out.vtu", 1000.0).elements, mesh.elements)


@pytest.mark.parametrize("element", QUADRATIC)
def test_a_sensor_off_the_surface_moves_to_the_nearest_point_of_it(element):
    nodes, elements = converted(*ring(element), SOLIDS[element])
    facets = outer_facets(nodes, elements)
    away = np.array([math.cos(0.3), 0.0, -math.sin(0.3)])
    corners, weights, point = nearest_surface_point(nodes, facets, 1.02 * OUTER * away + [0.0, 0.031, 0.0])
    assert point == pytest.approx(OUTER * away + [0.0, 0.031, 0.0], abs=2e-4)  # of the flat facet
    assert weights @ nodes[corners] == pytest.approx(point, abs=1e-12)
