"""Housings from STEP and mesh files: the same body as the one they were made from, key points, and refusals."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from housings import short_housing, small_housing

from fem.casing.geometry.dimensions import HousingError
from fem.casing.geometry.locators import ByBox, ByCylinder, ByGroup, ByPlane, ByPoint
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.gmsh_mesh import mesh_housing, session, write_step
from fem.casing.mesh.imported_housing import ImportedHousing, Seat, content_hash
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.quality import checked_quality, measure
from fem.casing.mesh.sizes import Sizes
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.rigid_on_mounts import rigid_body
from fem.casing.uncertainty.extrapolation import limits_from, lowest_modes
from fem.elements.facets import surface_weights
from fem.elements.materials import CAST_IRON
from fem.elements.solid_elements import SOLIDS, converted
from fem.elements.solids import mass_properties

SIZES = Sizes(element=0.05)


@pytest.fixture(scope="module")
def small():
    return short_housing()


@pytest.fixture(scope="module")
def native(small):
    return mesh_housing(small, sizes=SIZES)


@pytest.fixture(scope="module")
def step(small, tmp_path_factory):
    path = tmp_path_factory.mktemp("step") / "housing.step"
    write_step(small, path)
    return path


def floor(small, lift=0.0):
    """The underside of the feet, or so much (m) above it."""
    height = lift - small.axis_height - small.feet.height
    return ByPlane(through=(0.0, 0.0, height), normal=(0.0, 0.0, -1.0))


def imported(path, small, **changes):
    seats = tuple(
        Seat(
            name=b.name,
            locator=ByCylinder(through=(b.x, b.side * (small.width / 2 - 0.010), b.z), diameter=b.diameter),
            shaft_point=(b.x, b.side * (small.width / 2 - 0.015), b.z),
        )
        for b in small.bores
    )
    usual = {"path": str(path), "sha256": content_hash(path), "unit": "mm", "seats": seats, "grounds": (floor(small),)}
    return ImportedHousing(**(usual | changes))


@pytest.fixture(scope="module")
def stepped(step, small):
    return mesh_geometry(imported(step, small), SIZES)


def write(path, native, *, swapped=False, elements=None, nodes=None, **more):
    """The native mesh in millimetres with node groups of its patches."""
    nodes = 1000 * (native.nodes if nodes is None else nodes)
    elements = native.elements if elements is None else elements
    if swapped:
        elements = elements[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]
    kind = "tetra10" if elements.shape[1] == 10 else "tetra"
    form = "gmsh22" if path.suffix == ".msh" else None  # the suffix alone means another program to meshio
    meshio.write(path, meshio.Mesh(nodes, [(kind, elements)], **more), file_format=form)
    return path


def same_body(mesh, native):
    assert len(mesh.elements) == len(native.elements)
    for a, b in zip(body(mesh), body(native), strict=True):
        assert np.allclose(a, b, rtol=1e-9, atol=1e-12)
    for name in native.patch_names:
        area, wanted = (surface_weights(m.nodes, m.patch(name))[2].sum() for m in (mesh, native))
        assert area == pytest.approx(wanted, rel=1e-9)
        assert np.abs(mesh.point(name) - native.point(name)).max() < 1e-5


def body(mesh):
    return mass_properties(mesh.nodes, mesh.elements, 7200.0)


def test_a_step_file_gives_the_body_and_the_points_it_was_written_from(stepped, native):
    assert stepped.patch_names == native.patch_names
    assert body(stepped)[0] == pytest.approx(body(native)[0], rel=2e-4)
    for name in native.patch_names:
        assert np.abs(stepped.point(name) - native.point(name)).max() < 1e-6
        area, wanted = (surface_weights(m.nodes, m.patch(name))[2].sum() for m in (stepped, native))
        assert area == pytest.approx(wanted, rel=1e-3)


def test_same_step_same_mesh_and_same_file(step, stepped, small, tmp_path):
    assert mesh_geometry(imported(step, small), SIZES).digest() == stepped.digest()
    write_step(small, tmp_path / "housing.step")
    assert content_hash(tmp_path / "housing.step") == content_hash(step)


def test_a_step_file_does_not_depend_on_what_was_written_before_nor_on_its_name(step, small, tmp_path):
    with session() as gmsh:
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "box.step"))
        gmsh.model.occ.importShapes(str(tmp_path / "box.step"))
    for name in ("again.step", "other.step"):
        write_step(small, tmp_path / name)
        assert (tmp_path / name).read_bytes() == step.read_bytes()


def test_a_rigid_body_from_the_mesh_is_the_one_from_the_dimensions(small, native):
    settings = {"density": 7200.0, "mount_stiffness": 1e8, "sensors": small.sensors}
    exact, meshed = rigid_body(small, **settings), rigid_body(native, **settings)
    assert exact.row_names == meshed.row_names
    for name in ("mass", "stiffness", "rows"):
        a, b = getattr(exact, name), getattr(meshed, name)
        assert np.abs(a - b).max() < 1e-3 * np.abs(a).max()


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtu"])
def test_a_mesh_file_is_read_as_it_is(native, small, tmp_path, suffix):
    path = write(tmp_path / f"housing{suffix}", native)
    same_body(mesh_geometry(imported(path, small), SIZES), native)


def test_nastran_ten_node_tetrahedra_are_read(native, small, tmp_path):
    """Free-field GRID* and CTETRA cards as a preprocessor writes them: node order 12 23 13 14 24 34."""
    lines = ["BEGIN BULK"]
    lines += [f"GRID,{i},,{x!r},{y!r},{z!r}" for i, (x, y, z) in enumerate((1000 * native.nodes).tolist(), 1)]
    for number, corners in enumerate((native.elements + 1).tolist(), 1):
        lines += [f"CTETRA,{number},1,{','.join(map(str, corners[:6]))},+", f"+,{','.join(map(str, corners[6:]))}"]
    path = tmp_path / "housing.bdf"
    path.write_text("\n".join([*lines, "ENDDATA", ""]), encoding="utf-8")
    same_body(mesh_geometry(imported(path, small), SIZES), native)


def test_mid_side_nodes_in_swapped_order_are_put_right(native, small, tmp_path):
    path = write(tmp_path / "housing.vtu", native, swapped=True)
    same_body(mesh_geometry(imported(path, small), SIZES), native)


def test_key_points_by_group_box_and_point(native, small, tmp_path):
    sets = {name: np.unique(native.patch(name)) for name in native.patch_names}
    path = write(tmp_path / "housing.inp", native, point_sets=sets)
    seats = tuple(Seat(name=b.name, locator=ByGroup(group=b.name)) for b in small.bores)
    low, high = small.foot_boxes()["ground_2"]
    grounds = [ByGroup(group=f"ground_{i}") for i in range(1, 5)]
    grounds[0] = ByPoint(point=tuple(native.point("ground_1") + [0.01, 0.0, -0.001]))
    grounds[1] = ByBox(box=(tuple(low - 1e-4), (high[0] + 1e-4, high[1] + 1e-4, low[2] + 1e-4)))
    same_body(mesh_geometry(imported(path, small, seats=seats, grounds=tuple(grounds)), SIZES), native)


def test_physical_groups_of_gmsh_are_known_by_name(native, small, tmp_path):
    facets, owner = native.facets, native.facet_patch
    names = dict.fromkeys(native.patch_names)
    cells = [("tetra10", native.elements), *(("triangle6", facets[owner == i]) for i in range(len(names)))]
    tags = [np.full(len(block), number) for number, (_, block) in enumerate(cells, 1)]
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    fields = {name: np.array([number, 2]) for number, name in enumerate(names, 2)}
    path = tmp_path / "housing.msh"
    meshio.write(path, meshio.Mesh(1000 * native.nodes, cells, cell_data=data, field_data=fields), file_format="gmsh22")
    seats = tuple(Seat(name=b.name, locator=ByGroup(group=b.name)) for b in small.bores)
    same_body(mesh_geometry(imported(path, small, seats=seats), SIZES), native)
    with pytest.raises(MeshError, match=r"no group 'BORE'; it has: .*bearing_1"):
        mesh_geometry(imported(path, small, seats=(Seat(name="bearing_1", locator=ByGroup(group="BORE")),)), SIZES)


def test_four_node_tetrahedra_stand_between_the_corners_of_those_of_ten(native, small):
    linear = mesh_housing(small, sizes=SIZES, element="tetrahedron-4")
    assert np.array_equal(linear.elements, native.elements[:, :4])
    assert np.array_equal(linear.nodes, native.nodes[: len(linear.nodes)])
    assert np.array_equal(linear.facets, native.facets[:, :3])
    assert np.array_equal(linear.facet_patch, native.facet_patch)
    assert not linear.curved


def test_linear_tetrahedra_are_upgraded_on_request_only(native, small, tmp_path):
    path = write(tmp_path / "housing.vtu", native, elements=native.elements[:, :4])
    with pytest.raises(MeshError, match=r"has linear elements .* tetrahedra.*Set upgrade = true"):
        mesh_geometry(imported(path, small), SIZES)
    mesh = mesh_geometry(imported(path, small, upgrade=True), SIZES)
    assert mesh.elements.shape == native.elements.shape
    assert len(mesh.nodes) == len(native.nodes)
    assert not mesh.curved
    corners = native.nodes[native.elements[:, :4]]
    assert body(mesh)[0] == pytest.approx(7200.0 * np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6, rel=1e-9)


def test_ten_node_tetrahedra_of_a_file_carry_cubic_displacements_as_they_are(native, small, tmp_path, monkeypatch):
    """No new nodes are needed; the error of such a mesh is told without another."""
    monkeypatch.setattr("fem.casing.uncertainty.extrapolation.MODES", 20)
    path = tmp_path / "housing.inp"
    write(path, native)
    mesh = mesh_geometry(imported(path, small), SIZES, "tetrahedron-20")
    assert mesh.cubic
    assert mesh.element.name == "tetrahedron-20"
    assert mesh.elements.shape == native.elements.shape
    fine, coarse = (
        lowest_modes(assembled_casing(one, CAST_IRON), static=False) for one in (mesh, replace(mesh, cubic=0))
    )
    limits = limits_from(fine.frequencies, fine.shapes, fine.element_size, [coarse])
    assert 0.0 < limits.correction < 0.05
    assert (limits.bands > 0.0).all()


def test_a_file_in_another_frame_is_placed(native, small, tmp_path):
    """Axes of the file turned about z by a quarter and shifted: x = origin + x_file @ axes."""
    origin, axes = np.array([0.3, -0.2, 0.1]), ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    path = write(tmp_path / "housing.vtu", native, nodes=(native.nodes - origin) @ np.array(axes).T)
    same_body(mesh_geometry(imported(path, small, origin=tuple(origin), axes=axes), SIZES), native)
    with pytest.raises(HousingError, match="right-handed"):
        imported(path, small, axes=((0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))


@pytest.mark.parametrize(("unit", "right"), [("m", "mm"), ("um", "mm"), ("inch", "mm")])
def test_a_wrong_unit_is_named_by_the_shafts(native, small, tmp_path, unit, right):
    path = write(tmp_path / "housing.vtu", native)
    with pytest.raises(MeshError, match=f'read in {unit} spans .*seems to be in {right}: set unit = "{right}"'):
        mesh_geometry(imported(path, small, unit=unit), SIZES)


def test_a_step_file_knows_its_unit(step, small):
    with pytest.raises(MeshError, match='declares its unit of length as mm, the scene states unit = "inch"'):
        mesh_geometry(imported(step, small, unit="inch"), SIZES)


def test_a_step_file_in_metres_is_the_same_body(step, stepped, small, tmp_path):
    """The same numbers declared as metres, then stated so: a thousand times larger, and refused; as mm: refused."""
    path = tmp_path / "metres.step"
    path.write_text(step.read_text(encoding="latin-1").replace(".MILLI.", "$"), encoding="latin-1")
    with pytest.raises(MeshError, match="declares its unit of length as m"):
        mesh_geometry(imported(path, small), SIZES)
    with pytest.raises(MeshError, match=r"read in m spans 1\.4e\+05 x"):
        mesh_geometry(imported(path, small, unit="m"), SIZES)


def test_a_bore_that_is_not_there_is_answered_with_the_nearest(tmp_path):
    small, step = small_housing(), tmp_path / "small.step"
    write_step(small, step)
    housing = imported(step, small)
    seat = replace(housing.seats[0], locator=ByCylinder(through=(0.0, -0.07, 0.0), diameter=0.048))
    with pytest.raises(
        MeshError, match=r"bearing_1: no cylinder of diameter 48 mm.*nearest.*diameter 47 mm at \(.*-65"
    ):
        mesh_geometry(replace(housing, seats=(seat,)), SIZES)
    turned = replace(seat, locator=ByCylinder(through=(0.0, -0.07, 0.0), diameter=0.047, axis=(1.0, 0.0, 0.0)))
    with pytest.raises(
        MeshError, match=r"no cylinder along this axis, along y: diameter 47 mm at .* Correct through_mm"
    ):
        mesh_geometry(replace(housing, seats=(turned,)), SIZES)
    with pytest.raises(MeshError, match=r"ground_1: no flat face.*-5 mm along the normal|\+5 mm along the normal"):
        mesh_geometry(replace(housing, grounds=(floor(small, 0.005),)), SIZES)
    with pytest.raises(MeshError, match=r"the point \(0, 0, -120\) mm is .* mm from the surface"):
        mesh_geometry(replace(housing, grounds=(ByPoint(point=(0.0, 0.0, -0.12)),)), SIZES)
    with pytest.raises(MeshError, match="a STEP file has no groups"):
        mesh_geometry(replace(housing, grounds=(ByGroup(group="FEET"),)), SIZES)


def test_a_wrong_bore_of_a_mesh_file_is_answered_with_the_bores_of_the_mesh(native, small, tmp_path):
    """Normals of coarse facets are up to 4 degrees from perpendicular to the axis. Flat faces are no bores."""
    housing = imported(write(tmp_path / "housing.vtu", native), small)
    seat = replace(housing.seats[0], locator=ByCylinder(through=(0.0, -0.05, 0.0), diameter=0.048))
    nearest = r"nearest cylinders along it: diameter 47 mm at \(0, -50, 0\) mm; diameter 65 mm at \(0, -45, 0\) mm"
    with pytest.raises(MeshError, match=nearest):
        mesh_geometry(replace(housing, seats=(seat,)), SIZES)


def test_a_bore_off_its_shaft_is_refused(step, small):
    housing = imported(step, small)
    for point, message in (
        ((0.002, -0.045, 0.0), "2 mm from the axis of its shaft"),
        ((0.0, -0.03, 0.0), "the bearing at y = -30 mm is outside its seat"),
    ):
        seat = replace(housing.seats[0], shaft_point=point)
        with pytest.raises(MeshError, match=message):
            mesh_geometry(replace(housing, seats=(seat,)), SIZES)


def test_a_step_file_without_a_solid_is_refused(tmp_path, small):
    path = tmp_path / "skin.step"
    with session() as gmsh:
        gmsh.model.occ.addRectangle(0, 0, 0, 100, 50)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    with pytest.raises(MeshError, match="has no volume: it holds 1 surfaces"):
        mesh_geometry(imported(path, small), SIZES)
    path.write_text("not a STEP file", encoding="utf-8")
    with pytest.raises(MeshError, match=r"skin\.step"):
        mesh_geometry(imported(path, small), SIZES)


def test_two_solids_that_touch_are_bonded(tmp_path, small):
    """Cover and lower part as two solids: one connected mesh, the face between them is no surface."""
    path = tmp_path / "two.step"
    with session() as gmsh:
        occ = gmsh.model.occ
        occ.addBox(-50, -50, 0, 100, 100, 40)
        occ.addBox(-50, -50, 40, 100, 100, 20)
        occ.cut([(3, 1)], [(3, occ.addCylinder(0, -60, 20, 0, 120, 0, 10))])
        occ.synchronize()
        gmsh.write(str(path))
    seats = (Seat(name="bearing_1", locator=ByCylinder(through=(0.0, 0.0, 0.02), diameter=0.02)),)
    ground = ByPlane(through=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0))
    mesh = mesh_geometry(imported(path, small, seats=seats, grounds=(ground,), glue=True), Sizes(element=0.03))
    assert body(mesh)[0] == pytest.approx(7200 * (0.1**2 * 0.06 - np.pi * 0.01**2 * 0.1), rel=1e-4)
    assert np.abs(mesh.nodes[mesh.facets[:, :3]].mean(axis=1)[:, 2] - 0.04).min() > 1e-4


def test_an_unconnected_part_is_refused(native, small, tmp_path):
    nodes = np.vstack([native.nodes, native.nodes[native.elements[0]] + 0.01])
    loose = np.arange(len(native.nodes), len(nodes))[None]
    path = write(tmp_path / "housing.vtu", native, nodes=nodes, elements=np.vstack([native.elements, loose]))
    with pytest.raises(MeshError, match="2 unconnected parts; the smallest has 1 of"):
        mesh_geometry(imported(path, small), SIZES)


def test_inverted_and_flat_elements_are_refused_with_their_place(native, small, tmp_path):
    elements = native.elements.copy()
    elements[7] = elements[7][[1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
    path = write(tmp_path / "inverted.vtu", native, elements=elements)
    place = 1000 * native.nodes[elements[7, :4]].mean(axis=0)
    with pytest.raises(MeshError, match=rf"1 of \d+ tetrahedra are inverted .*near \({place[0]:.5g}, {place[1]:.5g}"):
        mesh_geometry(imported(path, small), SIZES)
    nodes = native.nodes.copy()
    nodes[elements[20, 3]] = nodes[elements[20, :3]].mean(axis=0) + 1e-6
    linear = write(tmp_path / "flat.vtu", native, elements=native.elements[:, :4], nodes=nodes)
    with pytest.raises(MeshError, match=r"tetrahedra (are inverted|have quality)"):
        mesh_geometry(imported(linear, small, upgrade=True), SIZES)


def test_other_files_are_refused(native, small, tmp_path):
    hexahedra = tmp_path / "hexahedra.vtu"
    cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    meshio.write(hexahedra, meshio.Mesh(cube, [("hexahedron", np.arange(8)[None])]))
    with pytest.raises(MeshError, match=r"has 1 hexahedra.*Set casing\.element to 'hexahedron-20' or 'hexahedron-27'"):
        mesh_geometry(imported(hexahedra, small), SIZES)
    wedge = tmp_path / "wedge.vtu"
    meshio.write(wedge, meshio.Mesh(cube[[0, 1, 3, 4, 5, 7]], [("wedge", np.arange(6)[None])]))
    with pytest.raises(MeshError, match=r"has linear elements \(1 wedges\), far too stiff"):
        mesh_geometry(imported(wedge, small, seats=()), SIZES)
    broken = tmp_path / "broken.msh"
    broken.write_text("$MeshFormat\n", encoding="utf-8")
    with pytest.raises(MeshError, match="cannot be read as a mesh"):
        mesh_geometry(imported(broken, small), SIZES)
    with pytest.raises(HousingError, match=r"the file is none of \.step"):
        imported(write(tmp_path / "housing.obj.vtu", native).rename(tmp_path / "housing.xyz"), small)
    changed = imported(broken, small)
    broken.write_text("changed", encoding="utf-8")
    with pytest.raises(MeshError, match="was changed"):
        mesh_geometry(changed, SIZES)


REGULAR = np.array([[0, 0, 0], [1, 0, 0], [0.5, 3**0.5 / 2, 0], [0.5, 3**0.5 / 6, (2 / 3) ** 0.5]])


def one_element(corners, mid=None):
    nodes, elements = converted(corners, np.arange(4)[None], SOLIDS["tetrahedron-10"])
    if mid is not None:
        nodes[elements[0, 4]] += mid
    return measure(nodes, elements)


def test_a_bad_element_is_named_with_its_place_in_millimetres():
    """The second of two tetrahedra is flat, then inside out; its corners have their mean at (0.1, 0.2, 0.3) m."""
    sound = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]])
    for height, words in ((1e-5, "have quality"), (-0.01, "are inverted")):
        bad = sound * [1.0, 1.0, height / 0.01]
        nodes = np.vstack([sound, bad - bad.mean(axis=0) + [0.1, 0.2, 0.3]])
        with pytest.raises(MeshError, match=rf"1 of 2 tetrahedra {words} .* near \(100, 200, 300\) mm\)?\. Repair"):
            checked_quality(nodes, np.array([[0, 1, 2, 3], [4, 5, 6, 7]]), "Repair it")


def test_a_needle_of_good_shape_is_refused_for_its_edges():
    """A regular tetrahedron stretched 54 and 7.3 times square to an edge: the largest ratio that SICN 0.05 admits."""
    half = 0.125**0.5
    regular = np.array([[0.5, 0, -half], [-0.5, 0, -half], [0, -0.5, half], [0, 0.5, half]])
    with pytest.raises(MeshError, match=r"1 of 1 tetrahedra have an inverse edge ratio below 0\.02 \(worst 0\.0185 "):
        checked_quality(regular * [1.0, 54.0, 7.3], np.arange(4)[None], "Repair it")


def test_quality_of_single_elements():
    """1 for the equilateral one at any size, the sign follows the orientation; flat is 0."""
    assert one_element(1e-3 * REGULAR).sicn[0] == pytest.approx(1.0)
    assert one_element(REGULAR[[1, 0, 2, 3]]).sicn[0] == pytest.approx(-1.0)
    assert abs(one_element(REGULAR * [1.0, 1.0, 1e-9]).sicn[0]) < 1e-8
    assert one_element(REGULAR * [100.0, 1.0, 1.0]).edge_ratio[0] > 50


def test_a_mid_side_node_beyond_the_quarter_point_folds_the_element():
    """The edge 0-1 is folded when its mid-side node leaves the middle half (Barsoum's quarter point)."""
    assert one_element(REGULAR, np.array([0.24, 0.0, 0.0])).jacobian[0] > 0.0
    assert one_element(REGULAR, np.array([0.26, 0.0, 0.0])).jacobian[0] < 0.0
    assert one_element(REGULAR, np.array([0.0, 0.0, 0.3])).sicn[0] < 0.9
