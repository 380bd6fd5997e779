"""The same body through every door (CAD, meshes of others, matrices) has the same natural frequencies."""

import re

import meshio
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from benchmarks.solids import box_mesh
from fem.casing.geometry.locators import ByCylinder, ByGroup, ByPlane
from fem.casing.imported.ansys import mapped_equations
from fem.casing.imported.imported_body import MatrixError, imported_body
from fem.casing.imported.matrix_checks import check_matrices, lowest_frequencies
from fem.casing.imported.matrix_files import MatrixFiles, read_body, read_matrices
from fem.casing.mesh.cad_file import fill_surface, read_triangles
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.gmsh_session import session
from fem.casing.mesh.imported_housing import ImportedHousing, Seat, content_hash
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.mesh_file import read_mesh_file
from fem.casing.mesh.sizes import Sizes
from fem.elements.solids import assemble
from pipelines.machine.scene_casing import imported_matrices
from pipelines.scene.tables.housing import MatricesHousingTable

IRON = {"elastic_modulus": 1.1e11, "poisson_ratio": 0.26, "density": 7200.0}
STRAIGHT, FINE = "straight.msh", "fine.msh"
MESHES = ("block.msh", "block22.msh", "block.inp", "block.bdf", "block.unv", "block.med", "block.vtu")
SOLIDS = ("block.step", "block.brep", "block.iges", "block.stl")
SIZES = Sizes(element=0.014)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A block of 60 x 30 x 20 mm with a bore of 12 mm in every format that gmsh writes, in millimetres."""
    made = tmp_path_factory.mktemp("block")
    with session() as gmsh:
        occ = gmsh.model.occ
        occ.addBox(0, 0, 0, 60, 30, 20)
        occ.cut([(3, 1)], [(3, occ.addCylinder(30, -1, 10, 0, 32, 0, 6))])
        occ.synchronize()
        for name in SOLIDS[:3]:
            gmsh.write(str(made / name))
        gmsh.option.setNumber("Mesh.MeshSizeMax", 12)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(made / FINE))
        gmsh.model.mesh.clear()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 30)
        gmsh.model.mesh.setOrder(1)
        gmsh.model.mesh.generate(3)
        seat = [tag for _, tag in gmsh.model.getEntities(2) if gmsh.model.getType(2, tag) == "Cylinder"]
        gmsh.model.addPhysicalGroup(2, seat, 7, "SEAT")
        gmsh.model.addPhysicalGroup(3, [1], 8, "BODY")
        gmsh.model.mesh.setOrder(2)
        gmsh.option.setNumber("Mesh.BdfFieldFormat", 0)
        for name in MESHES[:1] + MESHES[2:6]:
            gmsh.write(str(made / name))
        gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
        gmsh.write(str(made / MESHES[1]))
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
        gmsh.model.mesh.setOrder(1)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(made / STRAIGHT))
        gmsh.model.removePhysicalGroups()
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 48)
        gmsh.model.mesh.clear()
        gmsh.model.mesh.setOrder(1)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(made / SOLIDS[3]))
    meshio.read(made / "block.msh").write(made / "block.vtu")
    return made


def imported(path, **changes):
    seat = Seat(name="bearing_1", locator=ByCylinder(through=(0.03, 0.015, 0.01), diameter=0.012))
    ground = ByPlane(through=(0.0, 0.0, 0.0), normal=(0.0, 0.0, -1.0))
    usual = {"path": str(path), "sha256": content_hash(path), "unit": "mm", "seats": (seat,), "grounds": (ground,)}
    return ImportedHousing(**(usual | changes))


def matrices(mesh):
    return assemble(mesh.nodes, mesh.elements, **IRON)


def frequencies(K, M):
    """The first 20 elastic ones of the free body."""
    return lowest_frequencies(K, M, 26)[0][6:]


@pytest.fixture(scope="module")
def native(folder):
    return mesh_geometry(imported(folder / "block.msh"), SIZES)


@pytest.fixture(scope="module")
def wanted(native):
    return frequencies(*matrices(native))


@pytest.mark.parametrize("name", MESHES[1:])
def test_the_same_mesh_in_another_format_has_the_same_frequencies(folder, wanted, name):
    mesh = mesh_geometry(imported(folder / name), SIZES)
    assert np.abs(frequencies(*matrices(mesh)) / wanted - 1).max() < 1e-6


def test_straight_elements_of_the_same_mesh_have_a_smaller_bore_and_nearly_the_same_frequencies(folder, native, wanted):
    """A bore of twelve sides leaves 0.4 % more material than a round one."""
    mesh = mesh_geometry(imported(folder / STRAIGHT), SIZES)
    assert native.curved
    assert not mesh.curved
    assert 0.0 < np.abs(frequencies(*matrices(mesh)) / wanted - 1).max() < 0.02


@pytest.fixture(scope="module")
def stepped(folder):
    return frequencies(*matrices(mesh_geometry(imported(folder / "block.step"), SIZES)))


def test_elements_of_the_same_size_on_the_solid_give_lower_frequencies_within_the_error_of_the_mesh(folder, stepped):
    """The solid is meshed finer around its bore; more elements soften (Rayleigh)."""
    fine = frequencies(*matrices(mesh_geometry(imported(folder / FINE), SIZES)))
    assert (stepped < fine * (1 + 1e-3)).all()
    assert np.abs(stepped / fine - 1).max() < 0.1


@pytest.mark.parametrize(("name", "error"), [("block.brep", 5e-3), ("block.iges", 5e-3), ("block.stl", 2e-2)])
def test_the_same_body_from_other_cad_files_has_the_frequencies_of_the_step_file(folder, stepped, name, error):
    """The bore of a closed surface is a polygon of 48 sides or so."""
    mesh = mesh_geometry(imported(folder / name), SIZES)
    assert np.abs(frequencies(*matrices(mesh)) / stepped - 1).max() < error


@pytest.mark.parametrize("name", ["block.msh", "block.inp", "block.unv", "block.med"])
def test_a_named_surface_is_known_in_every_format_that_has_names(folder, name):
    mesh = mesh_geometry(imported(folder / name, seats=(Seat(name="bearing_1", locator=ByGroup(group="SEAT")),)), SIZES)
    corners = mesh.nodes[mesh.patch("bearing_1")[:, :3]]
    assert np.abs(np.hypot(corners[..., 0] - 0.03, corners[..., 2] - 0.01) - 0.006).max() < 1e-4


def test_folded_elements_of_a_file_are_straightened_and_counted(folder, native, tmp_path):
    """A mid-side node of the bore pushed through its element: the file is used, and says so."""
    raw = read_mesh_file(folder / "block.msh", 1.0)
    edge = raw.nodes[raw.elements[:, 4]] - raw.nodes[raw.elements[:, :2]].mean(axis=1)
    worst = int(np.linalg.norm(edge, axis=1).argmax())
    nodes = raw.nodes.copy()
    a, b, c = raw.nodes[raw.elements[worst, :3]]
    nodes[raw.elements[worst, 4]] = 0.5 * (a + b) + 0.29 * np.linalg.norm(b - a) * (c - a) / np.linalg.norm(c - a)
    path = tmp_path / "folded.vtu"
    meshio.write(path, meshio.Mesh(nodes, [("tetra10", raw.elements)]))
    mesh = mesh_geometry(imported(path), SIZES)
    assert mesh.straightened > native.straightened
    assert mesh.quality > 0.05


@pytest.mark.parametrize("name", [*MESHES[:6], *SOLIDS])
def test_a_file_cut_off_is_refused_in_one_sentence_and_nothing_else_is_printed(folder, tmp_path, name, capfd):
    whole = (folder / name).read_bytes()
    path = tmp_path / name
    path.write_bytes(whole[: len(whole) // 3])
    with pytest.raises(MeshError, match=f"^{name}") as refused:
        mesh_geometry(imported(path), SIZES)
    assert "\x1b" not in str(refused.value)
    assert capfd.readouterr() == ("", "")


def test_an_open_surface_is_refused_with_the_place_of_the_hole(folder, tmp_path):
    points, triangles = read_triangles(folder / "block.stl")
    kept = triangles[np.linalg.norm(points[triangles].mean(axis=1) - [0.0, 15.0, 10.0], axis=1).argsort()[1:]]
    path = tmp_path / "open.stl"
    meshio.write(path, meshio.Mesh(points, [("triangle", kept)]), binary=True)
    with pytest.raises(MeshError, match=r"open: 3 edges belong to one triangle only, around \(0, "):
        mesh_geometry(imported(path), SIZES)


@pytest.mark.parametrize(("sides", "kept"), [(8, True), (12, False)])
def test_edges_of_a_closed_surface_are_kept_above_40_degrees(tmp_path, sides, kept):
    """A prism with edges of 45 degrees keeps its volume when it is meshed; with 30 degrees elements span its edges."""
    angle, here = 2 * np.pi * np.arange(sides) / sides, np.arange(sides)
    ring = np.column_stack([10 * np.cos(angle), 10 * np.sin(angle), 0 * angle])
    points = np.vstack([ring, ring + [0, 0, 20], [[0, 0, 0], [0, 0, 20]]])
    after, low, high = (here + 1) % sides, np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    rows = [(here, after, after + sides), (here, after + sides, here + sides), (after, here, low)]
    triangles = np.hstack([*rows, (here + sides, after + sides, high)]).T
    meshio.write(tmp_path / "prism.stl", meshio.Mesh(points, [("triangle", triangles)]), binary=True)
    with session() as gmsh:
        fill_surface(gmsh, tmp_path / "prism.stl", "mm")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 6)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(tmp_path / "prism.msh"))
    corners = meshio.read(tmp_path / "prism.msh")
    places = corners.points[corners.cells_dict["tetra"]]
    lost = 1 - np.abs(np.linalg.det(places[:, 1:] - places[:, :1])).sum() / 6 / (1000 * sides * np.sin(angle[1]))
    assert abs(lost) < 1e-6 if kept else lost > 0.01


def test_solids_are_chosen_and_bonded_and_loose_ones_are_found_before_meshing(tmp_path):
    """Two touching blocks and one 2 mm away."""
    path = tmp_path / "three.step"
    with session() as gmsh:
        occ = gmsh.model.occ
        occ.addBox(0, 0, 0, 60, 30, 20)
        occ.cut([(3, 1)], [(3, occ.addCylinder(30, -1, 10, 0, 32, 0, 6))])
        occ.addBox(0, 0, 20, 60, 30, 10)
        occ.addBox(62, 0, 0, 20, 30, 20)
        occ.synchronize()
        gmsh.write(str(path))

    def volume(**changes):
        mesh = mesh_geometry(imported(path, **changes), SIZES)
        return assemble(mesh.nodes, mesh.elements, **(IRON | {"density": 1.0}))[1].sum() / 3

    bored = 60e-3 * 30e-3 * 20e-3 - np.pi * 6e-3**2 * 30e-3
    assert volume(solids=(1,)) == pytest.approx(bored, rel=1e-3)
    assert volume(solids=(1, 2), glue=True) == pytest.approx(bored + 60e-3 * 30e-3 * 10e-3, rel=1e-3)
    with pytest.raises(MeshError, match=r"has 2 solids .* set glue = true .*solids = \[1\]"):
        volume(solids=(1, 2))
    with pytest.raises(
        MeshError, match=r"2 parts that do not touch: solids 1 and 2; 3; solids 1 and 3 have a gap of 2 mm at \(61, "
    ):
        volume(glue=True)
    with pytest.raises(MeshError, match="has 3 solids, there is no solid 4"):
        volume(solids=(4,))


def write_harwell_boeing(path, matrix):
    """The lower triangle in the fixed fields of Fortran, with a right-hand side, as HBMAT writes it."""
    lower = sp.csc_array(sp.tril(matrix))
    lower.sort_indices()

    def lines(values, per_line, form):
        fields = [form(value) for value in values]
        return ["".join(fields[at : at + per_line]) for at in range(0, len(fields), per_line)]

    pointers = lines(lower.indptr + 1, 8, "{:10d}".format)
    indices = lines(lower.indices + 1, 8, "{:10d}".format)
    values = lines(lower.data, 3, lambda value: f"{value:25.16E}".replace("E", "D"))
    forces = lines(np.zeros(matrix.shape[0]), 3, "{:25.16E}".format)
    counts = [len(pointers), len(indices), len(values), len(forces)]
    head = [
        f"{'STIFFNESS':<72}{'K':<8}",
        "".join(f"{count:14d}" for count in (sum(counts), *counts)),
        f"{'RSA':<14}" + "".join(f"{count:14d}" for count in (*matrix.shape, lower.nnz, 0)),
        f"{'(8I10)':<16}{'(8I10)':<16}{'(3D25.16)':<20}{'(3E25.16)':<20}",
        f"{'F':<14}{1:14d}{0:14d}",
    ]
    path.write_text("\n".join([*head, *pointers, *indices, *values, *forces]) + "\n", encoding="utf-8")


def saved(folder, form, K, M, nodes):
    """Files of the matrices in t, mm, s."""
    per_mm = sp.diags_array(np.full(K.shape[0], 1e-3))
    K, M = (per_mm @ K @ per_mm) * 1e3, (per_mm @ M @ per_mm) * 1e3  # energy in t mm2/s2 = mJ, mass in t
    np.savetxt(folder / "nodes.csv", np.column_stack([np.arange(1, len(nodes) + 1), 1e3 * nodes]), delimiter=",")
    if form == "mtx":
        for name, matrix in (("K", K), ("M", M)):
            scipy.io.mmwrite(folder / f"{name}.mtx", sp.coo_matrix(matrix), precision=17, symmetry="symmetric")
    elif form == "npz":
        for name, matrix in (("K", K), ("M", M)):
            sp.save_npz(folder / f"{name}.npz", sp.csr_matrix(matrix))
    elif form == "ansys":  # the equations in the order of a solver, not of the nodes
        order = np.random.default_rng(7).permutation(K.shape[0])
        for name, matrix in (("K", K), ("M", M)):
            write_harwell_boeing(folder / f"{name}.matrix", sp.csr_array(matrix)[order][:, order])
        rows = [f"{row:10d}{one // 3 + 1:10d}   U{'XYZ'[one % 3]}" for row, one in enumerate(order, 1)]
        (folder / "K.mapping").write_text("\n".join(["Matrix Eqn      Node   DOF", *rows]), encoding="utf-8")
    elif form == "coordinate":  # of Abaqus, beside its input file
        for name, matrix in (("K", K), ("M", M)):
            full = sp.coo_matrix(matrix)
            rows = np.column_stack([full.row + 1, full.col + 1, full.data])
            np.savetxt(folder / f"{name}.mtx", rows, fmt=["%d", "%d", "%.17g"])
        cards = [f"{number}, {x!r}, {y!r}, {z!r}" for number, (x, y, z) in enumerate((1e3 * nodes).tolist(), 1)]
        lines = ["*Heading", "*Node, nset=ALL", "** a comment", *cards, "*Node output", "U"]
        (folder / "nodes.inp").write_text("\n".join(lines), encoding="utf-8")
    elif form == "abaqus":
        for name, matrix in (("K", K), ("M", M)):
            lower = sp.coo_matrix(sp.tril(matrix))
            places = (lower.row // 3 + 1, lower.row % 3 + 1, lower.col // 3 + 1, lower.col % 3 + 1)
            rows = np.column_stack([*places, lower.data])
            np.savetxt(
                folder / f"{name}.mtx", rows, fmt=["%d"] * 4 + ["%.17g"], delimiter=",", header="Abaqus", comments="** "
            )
    else:
        op4 = pytest.importorskip("pyyeti.nastran.op4")
        for name, matrix in (("K", K), ("M", M)):
            op4.write(str(folder / f"{name}.op4"), {f"{name}GG": sp.coo_matrix(matrix)}, sparse="bigmat")
    ending = {"abaqus": "mtx", "coordinate": "mtx", "ansys": "matrix"}.get(form, form)
    K_file, M_file = (str(folder / f"{name}.{ending}") for name in "KM")
    equations = str(folder / "K.mapping") if form == "ansys" else None
    nodes_file = str(folder / ("nodes.inp" if form == "coordinate" else "nodes.csv"))
    return MatrixFiles(stiffness=K_file, mass=M_file, nodes=nodes_file, equations=equations, system="t-mm-s")


@pytest.mark.parametrize("form", ["mtx", "npz", "abaqus", "coordinate", "ansys", "op4"])
def test_matrices_in_another_system_of_units_have_the_same_frequencies_and_mass(tmp_path, form):
    """A block without a bore: long files only take long to write."""
    nodes, elements = box_mesh((60e-3, 30e-3, 20e-3), (3, 2, 1))
    K, M = assemble(nodes, elements, **IRON)
    body = read_body(saved(tmp_path, form, K, M, nodes))
    check = check_matrices(body)
    assert np.abs(frequencies(body.stiffness, body.mass) / frequencies(K, M) - 1).max() < 1e-6
    assert check.mass == pytest.approx(7200 * 60e-3 * 30e-3 * 20e-3, rel=1e-6)
    assert np.abs(check.centre - [0.03, 0.015, 0.01]).max() < 1e-5
    assert check.rigid_modes == 6
    assert check.wrong == ()


def test_every_file_of_a_scene_is_read_for_what_it_is_named_for(tmp_path):
    names = ("file", "mass_file", "nodes_file", "equations_file", "rows_file")
    for name in names:
        (tmp_path / name).write_text(name, encoding="utf-8")
    table = MatricesHousingTable(
        **{name: str(tmp_path / name) for name in names},
        units="kg-m-s",
        bearings=({"name": "bearing_1", "nodes": [1]},),
        grounds=({"nodes": [2]},),
    )
    files = imported_matrices(table, (), [(0.0, 0.0, 0.0)]).files
    found = [files.stiffness, files.mass, files.nodes, files.equations, files.rows]
    assert found == [str(tmp_path / name) for name in names]


def test_harwell_boeing_files_that_are_cut_off_or_of_another_kind_are_refused(tmp_path):
    path = tmp_path / "K.matrix"
    write_harwell_boeing(path, sp.eye_array(300))
    text = path.read_text(encoding="utf-8")
    for words, changed in (
        ("is cut off: it holds", "\n".join(text.splitlines()[:100])),
        ("is of the type CSA", text.replace("RSA", "CSA")),
        ("is no Harwell-Boeing file", "nothing"),
    ):
        path.write_text(changed, encoding="utf-8")
        with pytest.raises(MatrixError, match=f"^K.matrix {words}"):
            read_matrices(path)
    heat = tmp_path / "K.mapping"
    for words, rows in (
        ("has the unknowns TEMP", "1 1 TEMP"),
        ("does not number the equations from 1 without gaps", "2 1 UX"),
    ):
        heat.write_text(f"Matrix Eqn  Node  DOF\n{rows}\n", encoding="utf-8")
        with pytest.raises(MatrixError, match=words):
            mapped_equations(heat)


def test_unknowns_without_mass_may_have_any_stiffness():
    """A mass on two soft springs in a row, no mass between them, beside one tied to a massless unknown by 1e9 N/m."""
    soft, stiff, mass = 1e-4, 1e9, 1e-4
    one, other = [[soft, -soft], [-soft, 2 * soft]], [[soft + stiff, -stiff], [-stiff, stiff]]
    K = sp.block_diag([sp.coo_matrix(one), other], format="csr")
    M = sp.diags_array([mass, 0.0, mass, 0.0], format="csr")
    wanted = np.sqrt(soft / 2 / mass) / (2.0 * np.pi)
    assert lowest_frequencies(K, M, 4)[0][0] == pytest.approx(wanted, rel=1e-9)


def test_a_direction_without_mass_and_with_negative_stiffness_has_no_frequencies_and_is_counted():
    K, M = sp.diags_array([1.0, -2.0], format="csr"), sp.diags_array([1.0, 0.0], format="csr")
    frequencies, negative = lowest_frequencies(K, M, 2)
    assert len(frequencies) == 0
    assert negative == 1


@pytest.mark.parametrize("count", [40, 800])  # dense, and factorised
def test_an_indefinite_stiffness_is_wrong_and_named_with_node_and_axis(count):
    """Nodes in a row on springs along x, y and z, of which one spring along y is negative."""
    ends, springs = np.arange(count - 1), np.full((count - 1, 3), 1e8)
    springs[7, 1] *= -1.0
    difference = sp.csr_matrix((np.r_[0 * ends - 1.0, 0 * ends + 1.0], (np.r_[ends, ends], np.r_[ends, ends + 1])))
    K = sum(
        sp.kron(difference.T @ sp.diags_array(springs[:, axis]) @ difference, np.diag(np.eye(3)[axis]))
        for axis in range(3)
    )
    places = np.column_stack([0.01 * np.arange(count), np.zeros((count, 2))])
    body = imported_body("row", K, sp.eye_array(3 * count) / count, nodes=places)
    (words,) = [words for words in check_matrices(body).wrong if "negative stiffness" in words]
    node = int(re.search(r"found at node (\d+) along y: .*inverted elements", words)[1])
    assert 1 <= node <= count


def test_rotations_have_no_unit_of_length():
    """Two nodes of six unknowns in t, mm, s: displacements in mm, rotations in rad, energies in mJ, M also in s2."""
    body, size = np.cov(np.random.default_rng(3).normal(size=(12, 40))), np.tile([1e-3] * 3 + [1.0] * 3, 2)
    stated = 1e3 * body * np.outer(size, size)
    found = imported_body("any", stated, stated, nodes=1e3 * np.eye(3)[:2], system="t-mm-s")
    assert found.axis.tolist() == 2 * list(range(6))
    for matrix in (found.stiffness, found.mass):
        assert matrix.toarray() == pytest.approx(body, rel=1e-12)


def test_the_check_up_says_what_is_wrong_with_a_foreign_body(native):
    K, M = matrices(native)

    def found(stiffness=K, mass=M, **more):
        check = check_matrices(imported_body("body", stiffness, mass, nodes=native.nodes, **more))
        return " ".join(check.wrong + check.doubtful)

    grounded = K + sp.diags_array(np.where(np.arange(K.shape[0]) < 30, abs(K).max(), 0.0))
    assert "the body is held" in found(grounded)
    assert "its mass is zero" in found(mass=0.0 * M)
    assert "check the units" in found(system="kg-mm-s")
    skew = sp.lil_matrix(K)
    skew[0, 3] += 0.5 * abs(K).max()
    assert "not symmetric" in found(skew)
    with pytest.raises(MatrixError, match=r"stiffness has .* equations, mass .* Export both for the same set"):
        found(mass=sp.eye_array(9))
    with pytest.raises(MatrixError, match="neither three nor six per node"):
        imported_body("body", sp.eye_array(7), sp.eye_array(7), nodes=np.eye(3))
