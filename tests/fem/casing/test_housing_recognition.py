"""`gearcase housing`: bores, seats, tilt and unit are found in a file; the block it writes makes the scene fit."""

import base64
import json
import math
import re
import tomllib
from itertools import permutations, product
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp
from factored_casing import factored
from housings import small_housing
from matplotlib.figure import Figure

from fem.casing.imported.imported_body import imported_body
from fem.casing.imported.reduce_at_points import Point, reduce_imported_body
from fem.casing.mesh.cad_file import import_solids
from fem.casing.mesh.gmsh_mesh import mesh_housing, write_step
from fem.casing.mesh.gmsh_session import session
from fem.casing.mesh.sizes import Sizes
from fem.casing.recognition.bores_and_faces import bolt_patterns
from fem.casing.recognition.housing_contents import FoundBore
from fem.casing.recognition.read_geometry import geometry_contents
from fem.casing.recognition.shaft_fit import FittedShaft, fit_shafts
from fem.casing.reduced.grounded import assembled_casing
from fem.elements.materials import Material
from fem.elements.solids import assemble
from pipelines.cli.main import main
from pipelines.runs.checked_scene import check_scene
from pipelines.scene.load_scene import load_scene
from pipelines.studies.housings.bore_picture import _draw, _seen
from pipelines.studies.housings.housing_block import housing_block
from pipelines.studies.housings.housing_page import housing_page, thinned

IRON = Material(name="iron", elastic_modulus=1.1e11, poisson_ratio=0.26, density=7200.0)
TILT = math.radians(4.3)


@pytest.fixture(scope="module")
def small():
    return small_housing()


@pytest.fixture(scope="module")
def step(small, tmp_path_factory):
    path = tmp_path_factory.mktemp("survey") / "housing.step"
    write_step(small, path)
    return path


def shafts(small, **changes):
    """The shafts that run in the bores of a housing."""
    pairs = zip(small.bores[::2], small.bores[1::2], strict=True)
    return [
        FittedShaft(
            x=one.x + changes.get("x", {}).get(one.name, 0.0),
            z=one.z,
            bearings=tuple((bore.name, float(small.bore_centre(bore)[1])) for bore in (one, two)),
            diameter=0.02,
        )
        for one, two in pairs
    ]


def test_a_survey_finds_every_bore_and_no_boss(small, step):
    contents = geometry_contents(step)
    wanted = sorted(bore.diameter for bore in small.bores)
    assert sorted(bore.diameter for bore in contents.bores) == pytest.approx(wanted, rel=1e-6)
    for bore in small.bores:
        nearest = min(contents.bores, key=lambda one, bore=bore: np.linalg.norm(one.centre - small.bore_centre(bore)))
        assert np.abs(nearest.centre - small.bore_centre(bore)).max() < 1e-6
        assert nearest.length == pytest.approx(bore.boss_length, rel=1e-6)
        assert nearest.ends[1] - nearest.ends[0] == pytest.approx(bore.boss_length * nearest.axis, abs=1e-8)
        assert abs(nearest.axis[1]) == pytest.approx(1.0)
    assert contents.parts == len(contents.solids) == 1
    assert contents.declared == "mm"
    low, high = small.box
    assert contents.flats[0].area == pytest.approx((high - low)[0] * (high - low)[1])


def test_a_mesh_shows_the_same_bores_as_its_solid(small, tmp_path):
    import meshio

    mesh = mesh_housing(small, sizes=Sizes(element=0.03))
    path = tmp_path / "housing.vtu"
    meshio.write(path, meshio.Mesh(1000 * mesh.nodes, [("tetra10", mesh.elements)]))
    found = geometry_contents(path)
    diameters = sorted(bore.diameter for bore in found.bores)
    assert diameters == pytest.approx(sorted(bore.diameter for bore in small.bores), rel=1e-6)
    assert fit_shafts(found.bores, shafts(small)).off < 1e-6


def test_a_file_that_was_turned_and_moved_is_put_back(small, step, tmp_path):
    """Turned by 4.3 degrees about the shafts and moved: the fit undoes it, and every bearing gets its own bore."""
    path = tmp_path / "turned.step"
    with session() as gmsh:
        solids = [(3, tag) for tag in import_solids(gmsh, step, "mm")]
        gmsh.model.occ.rotate(solids, 0, 0, 0, 0, 1, 0, TILT)
        gmsh.model.occ.translate(solids, 12.0, -7.0, 30.0)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    contents = geometry_contents(path)
    fit = fit_shafts(contents.bores, shafts(small))
    back = np.array([[np.cos(TILT), 0.0, np.sin(TILT)], [0.0, 1.0, 0.0], [-np.sin(TILT), 0.0, np.cos(TILT)]])
    assert np.abs(fit.axes - back).max() < 1e-6
    assert np.abs(fit.placed(np.array([[0.012, -0.007, 0.030]]))).max() < 1e-6
    assert {seat.bearing for seat in fit.seats} == {bore.name for bore in small.bores}
    for seat in fit.seats:
        assert seat.bore.diameter == pytest.approx(
            next(one for one in small.bores if one.name == seat.bearing).diameter
        )
        assert seat.middle == pytest.approx(seat.y, abs=1e-6)
    block = housing_block(contents, "turned.step", ".step", fit, load_scene("minimal").scene)
    assert tomllib.loads(block)["casing"]["housing"]["axes"] == pytest.approx(back, abs=1e-6)


def test_a_bore_a_little_off_its_shaft_is_offered_with_the_distance(small, step):
    """0.65 mm: too far to run, near enough to be meant; half of it at each end of the centre distance."""
    fit = fit_shafts(geometry_contents(step).bores, shafts(small, x={"bearing_3": 0.00065}))
    assert len(fit.seats) == 4
    assert fit.off == pytest.approx(0.00065 / 2, rel=1e-3)
    assert fit_shafts(geometry_contents(step).bores, shafts(small, x={"bearing_3": 0.03})) is None


def test_the_wider_bores_are_taken_for_the_thicker_shaft_of_a_file_whose_shafts_run_along_x():
    """Turned by 90 degrees to either side the file fits equally well: only the diameters differ."""
    along, places = np.array([1.0, 0.0, 0.0]), {0.055: (0.0, 0.1, 0.0), 0.068: (0.0, 0.19, 0.0)}
    bores = [
        FoundBore(
            number=n,
            solid=1,
            centre=np.array(places[d]) + x * along,
            axis=along,
            diameter=d,
            length=0.02,
            angle=2 * np.pi,
        )
        for n, (d, x) in enumerate(product(places, (0.0, 0.2)), 1)
    ]
    for thick, thin in permutations((0.03, 0.04)):
        diameters = (thick, thin)
        machine = [
            FittedShaft(x=0.09 * i, z=0.0, bearings=((f"{i}a", -0.1), (f"{i}b", 0.1)), diameter=d)
            for i, d in enumerate(diameters)
        ]
        for seat in fit_shafts(bores, machine).seats:
            assert seat.bore.diameter == (0.068 if diameters[seat.shaft] == 0.04 else 0.055)


def test_a_file_whose_y_axis_points_up_is_not_put_on_its_cover():
    """Two parallel shafts fit in four positions, in two of them upside down."""
    along, places = np.array([0.0, 0.0, 1.0]), {0.062: (0.5, 0.2, 0.0), 0.080: (0.38, 0.2, 0.0)}
    bores = [
        FoundBore(
            number=n, solid=1, centre=np.array(places[d]) + z * along, axis=along, diameter=d, length=0.02, angle=6.3
        )
        for n, (d, z) in enumerate(product(places, (-0.08, 0.08)), 1)
    ]
    machine = [
        FittedShaft(x=0.12 * i, z=0.0, bearings=((f"{i}a", -0.08), (f"{i}b", 0.08)), diameter=d)
        for i, d in enumerate((0.03, 0.04))
    ]
    fit = fit_shafts(bores, machine)
    assert fit.axes[1] == pytest.approx([0.0, 0.0, 1.0])
    assert [seat.bore.diameter for seat in fit.seats] == [0.062, 0.062, 0.080, 0.080]


def test_a_short_wide_bore_and_a_void_are_known(tmp_path):
    """A plate of 6.35 mm with bores of 38.1 and 28.575 mm, and a block with a closed void beside its bore."""
    path = tmp_path / "plate.step"
    with session() as gmsh:
        occ = gmsh.model.occ
        occ.addBox(0, 0, 0, 254, 6.35, 170)
        wide = [occ.addCylinder(60, -1, 60, 0, 9, 0, 38.1 / 2), occ.addCylinder(120, -1, 60, 0, 9, 0, 28.575 / 2)]
        occ.cut([(3, 1)], [(3, tag) for tag in wide])
        block = occ.addBox(0, 50, 0, 60, 30, 40)
        hollow = [occ.addBox(5, 55, 5, 15, 20, 15), occ.addCylinder(40, 49, 20, 0, 32, 0, 10)]
        occ.cut([(3, block)], [(3, tag) for tag in hollow])
        occ.synchronize()
        gmsh.write(str(path))
    contents = geometry_contents(path)
    assert [bore.diameter for bore in contents.bores] == pytest.approx([0.0381, 0.028575, 0.020], rel=1e-6)
    assert contents.parts == 2
    ((one, two, gap, _),) = contents.gaps
    assert (one, two) == (1, 2)
    assert gap == pytest.approx(0.05 - 0.00635)


def test_parts_are_led_to_each_other_by_their_narrowest_gaps(tmp_path):
    """Five blocks in a row, two of which touch: three gaps, each to the neighbour; none across another block."""
    path = tmp_path / "row.step"
    with session() as gmsh:
        for start in (0, 12, 22, 35, 49):
            gmsh.model.occ.addBox(start, 0, 0, 10, 10, 10)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    contents = geometry_contents(path)
    assert [solid.part for solid in contents.solids] == [1, 2, 2, 3, 4]
    found = {(one, two): gap for one, two, gap, _ in contents.gaps}
    assert found == pytest.approx({(1, 2): 0.002, (3, 4): 0.003, (4, 5): 0.004})


def test_a_bolt_circle_is_known_by_its_bore(tmp_path):
    path = tmp_path / "flange.step"
    with session() as gmsh:
        occ = gmsh.model.occ
        occ.addBox(-50, -50, 0, 100, 100, 10)
        middle = (12, -7)  # off the origin of the file
        holes = [occ.addCylinder(*middle, -1, 0, 0, 12, 15)]
        for k in range(6):
            x, y = middle[0] + 32 * math.cos(math.pi * k / 3), middle[1] + 32 * math.sin(math.pi * k / 3)
            holes.append(occ.addCylinder(x, y, -1, 0, 0, 12, 3))
        occ.cut([(3, 1)], [(3, tag) for tag in holes])
        occ.synchronize()
        gmsh.write(str(path))
    contents = geometry_contents(path)
    (pattern,) = bolt_patterns(contents.bores)
    assert len(pattern.bores) == 6
    assert pattern.hole_diameter == pytest.approx(0.006)
    assert pattern.circle_diameter == pytest.approx(0.064)
    assert pattern.around == contents.bores[0].number


def test_rounding_errors_of_the_height_do_not_divide_a_bolt_pattern():
    z = np.array([0.0, 0.0, 1.0])
    bores = [
        FoundBore(
            number=i + 1, solid=1, axis=z, centre=np.array([*place, height]), diameter=0.011, length=0.023, angle=6.28
        )
        for i, (place, height) in enumerate(
            [((0, 0), -2.5e-3), ((0.2, 0), -2.5e-3 - 1e-15), ((0, 0.3), -2.5e-3 + 1e-15), ((0.2, 0.3), -2.5e-3)]
            + [((0.1 * k, 0.1), 0.02) for k in range(2)]  # in another plane
        )
    ]
    (pattern,) = bolt_patterns(bores)
    assert pattern.bores == (1, 2, 3, 4)


def test_the_block_of_a_file_makes_the_scene_fit(tmp_path, monkeypatch, capsys):
    """A housing written by a scene, read back by one command and one paste: the seats are where the bearings are."""
    monkeypatch.chdir(tmp_path)
    assert main(["casing", "minimal", "--export", "box.step"]) == 0
    far = 'extends = "minimal"\n[[sensors]]\nname = "sensor_3"\nposition_mm = [0.0, -400.0, 0.0]\n'
    (tmp_path / "far.toml").write_text(far, encoding="utf-8")
    assert main(["housing", "box.step", "--scene", "far.toml", "--out", "found"]) == 0
    told = capsys.readouterr().out
    assert "4 bores, the widest first" in told
    assert "units of length in which bores match the shafts of the scene: mm" in told
    block = (tmp_path / "found" / "housing.toml").read_text(encoding="utf-8")
    assert block in told
    assert re.search(r"\ngrounds = .* through_mm = \[.*, -95\.0\], normal = \[0\.0, 0\.0, -1\.0\]", block)  # the feet
    assert re.search(r"# sensor sensor_3 is \d+ mm away from the housing \(limit 50 mm\): set position_mm = \[", block)
    (tmp_path / "mine.toml").write_text(f'extends = "minimal"\n{block}', encoding="utf-8")
    assert check_scene(load_scene("mine.toml")).machine.structure.housing.is_step
    page = (tmp_path / "found" / "box.html").read_text(encoding="utf-8")
    assert "bearing_1" in page
    assert (tmp_path / "found" / "box.png").stat().st_size > 10_000


def test_a_thinned_sphere_is_a_sphere_of_fewer_triangles():
    """20,000 triangles as 3000 at most: every point is one of the sphere, and its volume is lost by little."""
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 101), np.linspace(0.0, np.pi, 101), indexing="ij")
    points = np.column_stack([(np.sin(v) * np.cos(u)).ravel(), (np.sin(v) * np.sin(u)).ravel(), np.cos(v).ravel()])
    corner = (101 * np.arange(100)[:, None] + np.arange(100)).ravel()
    triangles = np.vstack(
        [np.column_stack([corner, corner + 1, corner + 102]), np.column_stack([corner, corner + 102, corner + 101])]
    )
    fewer, left = thinned(points, triangles, most=3000)
    assert 1000 < len(left) <= 3000
    assert np.linalg.norm(fewer, axis=1) == pytest.approx(1.0)
    volume = abs(np.linalg.det(fewer[left]).sum()) / 6.0
    assert volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.03)


def test_what_is_no_housing_is_refused_in_a_sentence(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.step").write_text("nothing", encoding="utf-8")
    (tmp_path / "a.op4").write_text("nothing", encoding="utf-8")
    (tmp_path / "a.txt").write_text("nothing", encoding="utf-8")
    for name, words in (
        ("a.step", "is not a STEP file, or it is cut off"),
        ("a.op4", "cannot be read"),
        ("a.txt", "a mesh file must end in one of"),
    ):
        assert main(["housing", name]) == 2
        assert words in capsys.readouterr().err
    assert main(["housing", "none.step"]) == 2


def test_rbe2_and_rbe3_of_foreign_matrices_are_those_of_the_mesh(small):
    """The interface stiffness of the rigid coupling is the same; that of the mean motion is a little softer."""
    mesh = mesh_housing(small, sizes=Sizes(element=0.05))
    K, M = assemble(mesh.nodes, mesh.elements, elastic_modulus=1.1e11, poisson_ratio=0.26, density=7200.0)
    axes = ("ux", "uy", "uz", "rx", "rz")
    numbers = {name: tuple((np.unique(mesh.patch(name)) + 1).tolist()) for name in mesh.patch_names}
    held = sorted({number for name, own in numbers.items() if name.startswith("ground_") for number in own})
    body = imported_body("small", K, M, nodes=mesh.nodes)
    found = {}
    for coupling in ("rigid", "mean"):
        points = {
            name: Point(nodes=numbers[name], place=tuple(mesh.point(name)), axes=axes, coupling=coupling)
            for name in mesh.patches("bearing_")
        }
        found[coupling] = reduce_imported_body(body, points, held=held, band=None).reduction.stiffness
    wanted = factored(
        assembled_casing(mesh, IRON, interfaces=dict.fromkeys(mesh.patches("bearing_"), axes), attachment="rigid")
    )
    stiff = wanted.interface.stiffness
    size = np.sqrt(np.outer(np.diag(stiff), np.diag(stiff)))
    assert (np.abs(found["rigid"] - stiff) / size).max() < 1e-6
    assert (np.diag(found["mean"]) < np.diag(found["rigid"])).all()
    assert (np.diag(found["mean"]) > 0.2 * np.diag(found["rigid"])).all()


@pytest.mark.slow
def test_matrices_as_the_housing_of_a_scene_give_the_casing_of_its_mesh(tmp_path, monkeypatch):
    """The mesh of a scene, assembled and written as another program would: the same natural frequencies."""
    import gearcase

    monkeypatch.setenv("GEARCASE_CACHE", str(tmp_path / "cache"))
    table = {"model": "craig-bampton", "element_size_mm": 40.0, "band_Hz": 4000.0, "attachment": "rigid"}
    meshed = gearcase.Scene.from_file("minimal").changed(casing=table, sensors=[])
    native = gearcase.casing(meshed, processes=1)
    mesh, iron = native.mesh, meshed.loaded.scene.casing.material
    K, M = assemble(
        mesh.nodes,
        mesh.elements,
        elastic_modulus=1e9 * iron.elastic_modulus_GPa,
        poisson_ratio=iron.poisson_ratio,
        density=iron.density_kg_m3,
    )
    for name, matrix in (("K", K), ("M", M)):
        sp.save_npz(tmp_path / f"{name}.npz", sp.csr_matrix(matrix))
    np.savetxt(tmp_path / "nodes.csv", np.column_stack([np.arange(1, len(mesh.nodes) + 1), mesh.nodes]), delimiter=",")

    def numbered(prefix):
        return [(name, (np.unique(mesh.patch(name)) + 1).tolist()) for name in mesh.patches(prefix)]

    housing = {
        "model": "matrices",
        "file": str(tmp_path / "K.npz"),
        "mass_file": str(tmp_path / "M.npz"),
        "nodes_file": str(tmp_path / "nodes.csv"),
        "units": "kg-m-s",
        "bearings": [{"name": name, "nodes": nodes} for name, nodes in numbered("bearing_")],
        "grounds": [{"nodes": nodes} for _, nodes in numbered("ground_")],
    }
    foreign = gearcase.casing(meshed.changed(casing={"housing": housing}), processes=1)
    count = int((native.frequencies < 4000.0).sum())
    assert count >= 3
    assert np.abs(foreign.frequencies[:count] / native.frequencies[:count] - 1).max() < 1e-6
    assert foreign.checkup.mass == pytest.approx(native.checkup.mass, rel=1e-9)
    assert foreign.mesh is None


def test_a_wall_seen_through_a_bore_is_darker_than_the_wall_around_it():
    """Equal brightness would make the bore look closed."""
    eye = np.array([np.cos(np.radians(-60.0)), np.sin(np.radians(-60.0)), 0.0])
    near = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    points = np.vstack([near, near - 0.2 * eye])
    box = np.array([[-1.0] * 3, [1.0] * 3])
    contents = SimpleNamespace(points=points, triangles=np.arange(6).reshape(2, 3), box=box)
    axes = Figure().add_subplot(projection="3d")
    _draw(axes, contents, -60.0)
    back, front = axes.collections[0].get_facecolor()[:, :3].mean(axis=1)  # in the order in which they are painted
    assert back < 0.6 * front


def test_a_picture_numbers_a_bore_only_where_no_wall_hides_it():
    corners = np.array([[0.0, -1.0, -1.0], [0.0, 1.0, -1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]])
    wall = SimpleNamespace(
        points=corners, triangles=np.array([[0, 1, 2], [0, 2, 3]]), box=np.array([[-1.0] * 3, [1.0] * 3])
    )
    eye = np.array([1.0, 0.2, 0.4])
    places = {-0.5: False, 0.0: True, 0.5: True}
    assert {x: _seen(wall, np.array([x, 0.3, -0.4]), eye) for x in places} == places


def test_the_page_of_a_housing_holds_its_corners_in_millimetres():
    points = np.array([[0.4, -0.2, 1.0], [0.6, -0.2, 1.0], [0.4, 0.3, 1.1]])
    box = np.array([points.min(axis=0), points.max(axis=0)])
    contents = SimpleNamespace(name="plate", points=points, triangles=np.array([[0, 1, 2]]), box=box, bores=())
    page = housing_page(contents, {}, "")
    data = json.loads(re.search(r'id="data" type="application/json">(.*?)</script>', page)[1])
    corners = np.frombuffer(base64.b64decode(data["corners"]), dtype="<u2").reshape(-1, 3)
    np.testing.assert_allclose(data["box"][0] + data["step"] * corners, 1000 * points, atol=data["step"])
