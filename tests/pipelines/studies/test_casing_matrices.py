"""The exported free body is the casing, whatever file holds it; frequency responses are those of its modes."""

from __future__ import annotations

import argparse
import math
import re
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.io
import scipy.linalg as la
import scipy.sparse as sp
from factored_casing import factored
from housings import short_housing
from scipy.sparse.linalg import LinearOperator, eigsh
from sources import ROOT

from fem.casing.imported.imported_body import MatrixError
from fem.casing.imported.imported_casing import imported_casing
from fem.casing.imported.matrix_checks import check_matrices
from fem.casing.imported.matrix_files import MatrixFiles, read_body
from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.models.rigid_casing import RigidCasing
from fem.casing.reduced.attachment import mean_motion_rows
from fem.casing.reduced.casing_modes import casing_modes, natural_modes, reduced_body
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.reduction import reduce_body
from fem.elements.materials import CAST_IRON
from fem.numerics.linear_solver import factorize
from pipelines.cli.casing import casing_facts, modal_ratios
from pipelines.cli.main import main
from pipelines.io.errors import InputError, SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.machine.scene_casing import imported_matrices
from pipelines.runs.checked_scene import check_scene
from pipelines.runs.single_results import Casing
from pipelines.scene.load_scene import load_scene
from pipelines.scene.tables.housing import MatricesHousingTable
from pipelines.steps.casing import casing_warnings
from pipelines.studies.housings.casing_export import FORMATS, free_body, write_casing
from pipelines.studies.housings.responses import (
    accelerance,
    accelerance_figure,
    accelerances,
    checked_names,
    damping_words,
    table_lines,
)
from pipelines.studies.housings.superelement import housing_table

FACTOR = 0.97  # of the stiffness, as extrapolation gives one


@pytest.fixture(scope="module")
def full():
    """Mesh and full model of a small casing."""
    housing = short_housing()
    mesh = mesh_housing(housing, element_size=0.05)
    return housing, mesh, factored(assembled_casing(mesh, CAST_IRON))


@pytest.fixture(scope="module")
def casing(full):
    """The reduced casing as the command builds it."""
    housing, mesh, grounded = full
    reduction = reduce_body(grounded.interface, grounded.K_free, grounded.M_free, count=25)
    modes = casing_modes(grounded, reduction, model="craig-bampton", band_limit=float(reduction.frequencies[-1]))
    body = reduced_body(modes, sensors=housing.sensors[:2], stiffness_factor=FACTOR, damping=[(0.0, 0.01), (4e3, 0.03)])
    return Casing(
        body=body,
        mesh=mesh,
        modes=modes,
        natural=natural_modes(modes, stiffness_factor=FACTOR),
        participation=modes.participation,
        checkup=None,
        limits=None,
        error=None,
        records=(),
        band=2000.0,
    )


def rigid(places, centre):
    """Rigid motions (3 n, 6) of places (n, 3) about a centre, independent of the product: t + r x arm."""
    columns = [np.tile(axis, (len(places), 1)) for axis in np.eye(3)]
    columns += [np.cross(axis, places - centre) for axis in np.eye(3)]
    return np.column_stack([column.ravel() for column in columns])


def hertz(K, M, count=12):
    return np.sqrt(np.maximum(la.eigvalsh(K, M)[:count], 0.0)) / (2 * math.pi)


def squares(K, M, count):
    """The lowest squares of the angular frequencies (rad^2/s^2) of a free body."""
    shift = -((2 * math.pi * 50.0) ** 2)
    inverse = LinearOperator(K.shape, matvec=factorize(sp.csr_matrix(K - shift * M)).solve)
    return np.sort(eigsh(K, k=count, M=M, sigma=shift, OPinv=inverse, return_eigenvectors=False))


def test_the_free_body_is_the_mesh_with_rigid_feet(full, casing):
    """Frequencies of the free body, and with a spring under one bearing, which reads its absolute motion."""
    mesh = full[1]
    found, whole = free_body(casing), assembled_casing(mesh, CAST_IRON, ground="springs")
    feet = np.unique(np.concatenate([np.unique(mesh.patch(name)) for name in mesh.patches("ground_")]))
    held = (3 * feet[:, None] + np.arange(3)).ravel()
    free = np.setdiff1d(np.arange(3 * len(mesh.nodes)), held)
    tied = np.zeros((3 * len(mesh.nodes), 6))
    tied[held] = rigid(mesh.nodes, casing.modes.centre)[held]
    take = sp.csr_matrix((np.ones(len(free)), (free, np.arange(len(free)))), shape=(3 * len(mesh.nodes), len(free)))
    E = sp.csr_matrix(sp.hstack([take, sp.csr_matrix(tied)]))
    K, M = sp.csc_matrix(FACTOR * (E.T @ whole.K_free @ E)), sp.csc_matrix(E.T @ whole.M_free @ E)
    exact = squares(K, M, 10)
    assert np.abs(exact[:6]).max() < 1e-6 * exact[6]
    mine = la.eigvalsh(found.stiffness, found.mass)[:10]
    assert np.abs(mine[:6]).max() < 1e-6 * mine[6]
    assert np.sqrt(mine[6:9] / exact[6:9]) == pytest.approx(1.0, abs=2e-3)
    row = sp.csr_matrix(mean_motion_rows(mesh.nodes, mesh.patch("bearing_2"), mesh.point("bearing_2")))[[2]] @ E
    spring = 1e6
    sprung = squares(sp.csc_matrix(K + spring * (row.T @ row)), M, 8)
    place = [found.node_names.index("bearing_2") + 1, 3]
    at = int(np.flatnonzero((found.equations == place).all(axis=1))[0])
    stiffness = found.stiffness.copy()
    stiffness[at, at] += spring
    mine = la.eigvalsh(stiffness, found.mass)[:8]
    assert math.sqrt(mine[5] / sprung[5]) == pytest.approx(1.0, abs=1e-4)
    assert mine[5] > 1e3  # the spring carries


def test_sensors_of_the_free_body_follow_a_rigid_motion(full, casing):
    housing, found = full[0], free_body(casing)
    centre, body = casing.modes.centre, casing.body
    motion = np.zeros((len(found.mass), 6))
    for row, (node, axis) in zip(motion, found.equations, strict=True):
        if axis:
            arm = found.nodes[node - 1, 1:] - centre
            row[:] = np.vstack([rigid(arm[None], np.zeros(3)), np.hstack([np.zeros((3, 3)), np.eye(3)])])[axis - 1]
    assert np.abs(found.stiffness @ motion).max() < 1e-9 * np.abs(found.stiffness).max()
    assert np.trace(motion[:, :3].T @ found.mass @ motion[:, :3]) / 3 == pytest.approx(casing.modes.total_mass)
    for sensor in housing.sensors[:2]:
        place = body.point_positions[body.point_names.index(sensor.name)]
        expected = np.array(sensor.axes) @ rigid(place[None], centre)
        rows = [found.row_names.index(f"{sensor.name}:{axis}") for axis in ("ux", "uy", "uz")]
        assert found.rows[rows] @ motion == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("ending", "precision"), [(".npz", 1e-9), (".mtx", 1e-9), (".op4", 1e-9), (".pch", 1e-6)])
def test_what_is_exported_is_read_again_with_the_same_frequencies_in_its_ground(casing, tmp_path, ending, precision):
    if ending in (".op4", ".pch"):
        pytest.importorskip("pyyeti")
    written = write_casing(casing, "a casing", tmp_path / f"c{ending}")
    assert written[0] == tmp_path / f"c{ending}"
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in written)
    further = {path.name: str(path) for path in written}
    files = MatrixFiles(
        stiffness=str(written[0]),
        mass=further.get("c-mass.mtx"),
        nodes=further.get("c-nodes.csv"),  # .pch holds its nodes
        equations=further.get("c-equations.csv"),
    )
    body = read_body(files)
    unused = {".npz": ["damping"], ".op4": ["baa"], ".pch": ["baax"], ".mtx": []}[ending]
    assert [note.split(". ")[0] for note in body.notes] == [
        f"c{ending}: the matrix {name} is not used" for name in unused
    ]
    check = check_matrices(body)
    assert check.wrong == ()
    assert check.doubtful == ()
    assert check.mass == pytest.approx(casing.modes.total_mass, rel=1e-6)
    assert check.inertia == pytest.approx(casing.modes.inertia, rel=1e-5, abs=1e-6)
    free = body.node != len(body.numbers)  # its last node is the ground
    K, M = (matrix.toarray()[np.ix_(free, free)] for matrix in (body.stiffness, body.mass))
    assert hertz(K, M) == pytest.approx(casing.frequencies[:12], rel=precision)


@pytest.mark.parametrize(("ending", "precision"), [(".npz", 1e-6), (".mtx", 1e-6), (".op4", 1e-6), (".pch", 1e-3)])
def test_the_printed_table_imports_an_export_whose_sensors_move_as_those_of_the_casing(
    full, casing, tmp_path, monkeypatch, ending, precision
):
    """Also along the own axes of a sensor that is not parallel to the axes of the scene."""
    if ending in (".op4", ".pch"):
        pytest.importorskip("pyyeti")
    sensors = full[0].sensors[:2]
    tilted = (sensors[0], replace(sensors[1], axes=((0.0, 0.0, 1.0), (0.6, 0.8, 0.0), (-0.8, 0.6, 0.0))))
    body = reduced_body(casing.modes, sensors=tilted, stiffness_factor=FACTOR)
    exported = replace(casing, body=body)
    text = housing_table(free_body(exported), write_casing(exported, "a casing", tmp_path / f"c{ending}"), 1e3)
    table = MatricesHousingTable(**tomllib.loads(text)["casing"]["housing"])
    places = dict(zip(body.point_names, body.point_positions.tolist(), strict=True))
    bearings = [seat.name for seat in table.bearings]
    assert bearings == sorted(name for name in places if name.startswith("bearing_"))
    monkeypatch.chdir(tmp_path)
    housing = imported_matrices(table, tilted, [tuple(places[name]) for name in bearings])
    interfaces = dict.fromkeys(bearings, ("ux", "uy", "uz", "rx", "rz"))
    options = {"model": "craig-bampton", "ground": "fixed", "attachment": "mean", "limit": 1e5}
    modes, _ = imported_casing(housing, interfaces=interfaces, **options)
    again = reduced_body(modes, sensors=tilted)
    assert not any("rows" in note for note in again.notes)
    force, frequencies = "bearing_1:uz", np.array([100.0, 700.0])
    for sensor in tilted:
        assert again.point_positions[again.point_names.index(sensor.name)] == pytest.approx(places[sensor.name])
        rows = [f"{sensor.name}:{axis}" for axis in ("ux", "uy", "uz")]
        mine, exact = (
            accelerances(one, np.array([one.row(row) for row in rows]), one.row(force)[None], frequencies)
            for one in (again, body)
        )
        assert mine == pytest.approx(exact, abs=precision * np.abs(exact).max())


def test_rows_that_do_not_fit_the_nodes_are_reported(casing, tmp_path):
    (path,) = write_casing(casing, "a casing", tmp_path / "c.npz")
    arrays = dict(np.load(path))
    np.savez(path, **arrays | {"rows": arrays["rows"][:-1]})
    assert any("rows is not used" in note for note in read_body(MatrixFiles(stiffness=str(path))).notes)


@pytest.fixture(scope="module")
def star(tmp_path_factory):
    """Scene `minimal` on an invented body: a node for the ground, springs to its bearings, a passive sensor."""
    bearings = np.array(make_machine(load_scene("minimal").scene).bearing_points)
    ground, n = bearings.mean(axis=0), len(bearings)
    moved = np.zeros((6 * n, 6 * (n + 1)))  # of the bearings relative to the ground
    for number, place in enumerate(bearings):
        own = slice(6 * number, 6 * number + 6)
        moved[own, own] = np.eye(6)
        moved[own, -6:] = -np.vstack([rigid(place[None], ground), np.hstack([np.zeros((3, 3)), np.eye(3)])])
    path = tmp_path_factory.mktemp("star") / "star.npz"
    numbers = [*range(1, n + 1), n + 2]
    arrays = {
        "stiffness": moved.T @ np.diag(np.tile([1e8] * 3 + [1e5] * 3, n)) @ moved,
        "mass": np.diag(np.tile([2.0] * 3 + [0.01] * 3, n + 1)),
        "equations": [[number, axis] for number in numbers for axis in range(1, 7)],
        "nodes": np.column_stack([np.arange(1, n + 3), np.vstack([bearings, ground + [0.0, 0.0, 0.1], ground])]),
        "rows": np.eye(3, 6 * (n + 1)),
    }
    np.savez(path, **arrays)
    table = {
        "model": "matrices",
        "file": str(path),
        "units": "kg-m-s",
        "bearings": [{"name": f"bearing_{number}", "nodes": [number]} for number in range(1, n + 1)],
        "grounds": [{"nodes": [n + 2]}],
    }
    sensor = {"name": "sensor_3", "position_mm": (1000 * (ground + [0.0, 0.0, 0.1])).tolist()}
    casing = {"casing.model": "craig-bampton", "casing.band_Hz": 1000.0, "casing.housing": table}
    return arrays, path, casing | {"sensors": [sensor]}


def test_a_housing_of_matrices_needs_no_material_and_a_shape_does(star):
    scene = load_scene("minimal", star[2]).scene
    bare = scene.model_copy(update={"casing": scene.casing.model_copy(update={"material": None})})
    assert make_machine(bare).structure.material is None
    shaped = load_scene("minimal").scene
    with pytest.raises(SceneError, match=r"casing.material: is missing"):
        make_machine(shaped.model_copy(update={"casing": shaped.casing.model_copy(update={"material": None})}))


def test_a_scene_of_matrices_with_a_sensor_at_a_node_is_accepted(star):
    assert check_scene(load_scene("minimal", star[2])).machine.title


FORCE = {"model": "table", "times_s": [0.0, 1.0], "forces_N": [0.0, 0.0]}
FAR = {"name": "sensor_3", "position_mm": [0.0, 900.0, 0.0]}


@pytest.mark.parametrize(
    ("housing", "tables", "words"),
    [
        ({}, {"sensors": [FAR]}, "sensors.1.position_mm.*nearest node.*limit 50 mm"),
        ({"grounds": [{"nodes": [99]}]}, {}, "has no node 99"),
        ({"origin_mm": [0.0, 5.0, 0.0]}, {}, "bearing_1: .*5 mm from the bearing.*Correct the nodes"),
        (
            {},
            {"forces": [{"model": "casing-force", "point": "sensor_3", "axis": "z", "force": FORCE}]},
            "forces: a casing-force acts on a mesh",
        ),
    ],
)
def test_matrices_that_the_casing_refuses_are_refused_by_the_check(star, housing, tables, words):
    settings = star[2] | {"casing.housing": star[2]["casing.housing"] | housing} | tables
    with pytest.raises(SceneError, match=words):
        check_scene(load_scene("minimal", settings))


def test_a_held_body_is_refused_by_the_check(star, tmp_path):
    arrays, path, settings = star
    held = tmp_path / path.name
    np.savez(held, **arrays | {"stiffness": arrays["stiffness"] + 1e6 * np.eye(len(arrays["mass"]))})
    with pytest.raises(SceneError, match=r"star.npz: a rigid-body motion needs force"):
        check_scene(
            load_scene("minimal", settings | {"casing.housing": settings["casing.housing"] | {"file": str(held)}})
        )


def test_a_casing_on_its_ground_is_refused_with_what_can_be_imported(casing, tmp_path):
    (written,) = write_casing(casing, "a casing", tmp_path / "c.h5")
    with pytest.raises(MatrixError, match=r"a casing on its ground.*--export casing\.npz"):
        read_body(MatrixFiles(stiffness=str(written)))


def test_a_rigid_casing_is_no_free_body_of_finite_elements(full, tmp_path):
    body = RigidCasing(mount_stiffness=1e8, damping_ratio=0.02).reduce(full[0], CAST_IRON)
    rigid_casing = SimpleNamespace(body=body, modes=None)
    with pytest.raises(InputError, match=r"rigid casing has no elastic modes. Set casing.model to craig-bampton"):
        write_casing(rigid_casing, "a casing", tmp_path / "c.npz")
    assert list(tmp_path.iterdir()) == []


def test_an_accelerance_is_the_sum_over_the_modes(casing):
    """The damping of the body is modal, so that both are equal; independent of the solution of the matrices."""
    body = casing.body
    found = accelerance(body, ["bearing_1:z", "sensor_1", "bearing_2:x"], casing.band, "words")
    assert tuple(found.output.values) == ("sensor_1:x", "sensor_1:y", "sensor_1:z", "bearing_2:x")
    assert found.frequency.values[-1] == casing.band
    squares, phi = la.eigh(body.stiffness, body.mass)
    omega_m, ratios = np.sqrt(squares), modal_ratios(body)
    assert ratios.max() > 1.5 * ratios.min()
    for line in (20, 700, int(np.argmax(np.abs(found.values[:, 2]))), 1999):
        w = 2 * math.pi * found.frequency.values[line]
        for number, row in enumerate(("sensor_1:ux", "sensor_1:uy", "sensor_1:uz", "bearing_2:ux")):
            shares = (body.row(row) @ phi) * (body.row("bearing_1:uz") @ phi)
            summed = (-(w**2) * shares / (squares - w**2 + 2j * ratios * omega_m * w)).sum()
            assert found.values[line, number] == pytest.approx(summed, rel=1e-8)


def test_a_response_at_one_frequency_solves_the_equation_of_motion(casing):
    body, hz = casing.body, 432.1
    force, out = body.row("bearing_1:uz"), body.row("sensor_1:ux")
    w = 2 * math.pi * hz
    moved = la.solve(body.stiffness + 1j * w * body.damping - w**2 * body.mass, force)
    ((found,),) = accelerances(body, out[None], force[None], np.array([hz]))[0]
    assert found == pytest.approx(-(w**2) * (out @ moved), rel=1e-10)


def test_all_sensors_respond_by_default_and_the_table_reads_back(casing, tmp_path):
    words = damping_words(modal_ratios(casing.body), casing.frequencies, casing.band)
    assert words.startswith("damping ratio of the modes 1.")
    found = accelerance(casing.body, ["bearing_1:uz"], casing.band, words)
    assert tuple(found.output.values) == tuple(f"sensor_{n}:{axis}" for n in (1, 2) for axis in "xyz")
    path = tmp_path / "r.csv"
    path.write_text("".join(table_lines(found, "a casing")))
    assert f"force at bearing_1:z; {words}" in path.read_text().splitlines()[0]
    table = np.genfromtxt(path, delimiter=",", names=True, skip_header=2)
    assert table["frequency"] == pytest.approx(found.frequency.values)
    back = table["sensor_2y_amplitude"] * np.exp(1j * np.radians(table["sensor_2y_phase"]))
    assert back == pytest.approx(found.values[:, 4], rel=1e-6)
    figure = accelerance_figure(found, "a casing")
    assert [axes.get_title(loc="left") for axes in _all_axes(figure)] == ["sensor_1", "", "sensor_2", ""]
    lines = _all_axes(figure)[2].get_lines()
    assert lines[1].get_ydata() == pytest.approx(np.abs(found.values[:, 4]))


def _all_axes(figure):
    return [axes for box in figure.subfigs for axes in box.axes]


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["bearing_9:z"], r"bearing_9:z: no such point. Choose one of bearing_1, sensor_1"),
        (["bearing_1"], r"bearing_1: add the axis :x, :y or :z after the name of the point, as in bearing_1:z"),
        (["bearing_1:z", "sensor_1:q"], r"sensor_1:q: add the axis"),
    ],
)
def test_names_of_a_response_are_refused_before_anything_is_built(names, message):
    with pytest.raises(InputError, match=message):
        checked_names(names, ["bearing_1"], ["sensor_1"])


def test_a_casing_without_sensors_needs_a_point_that_responds(casing):
    with pytest.raises(InputError, match=r"has no sensors\. Name a point"):
        checked_names(["bearing_1:z"], ["bearing_1"], [])
    checked_names(["bearing_1:z", "bearing_1:z"], ["bearing_1"], [])


def test_the_facts_of_a_casing_hold_every_frequency(casing):
    facts = casing_facts(casing, "mine")
    assert facts["frequency_Hz"] == pytest.approx(casing.frequencies)
    assert len(facts["damping_ratio"]) == len(facts["frequency_Hz"])
    assert facts["extrapolation"] is None
    assert facts["coordinates"] == casing.body.coordinate_names


def test_a_sensor_is_reported_that_measures_elsewhere_or_not_along_every_axis():
    body = SimpleNamespace(
        notes=("box.npz: the matrix damping is not used.",),
        point_names=("near", "far"),
        point_positions=np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]),
        row_names=("near:ux", "near:uy", "near:uz", "far:ux", "far:uy", "far:uz"),
        rows=np.array([[1.0], [0.0], [0.0], [1.0], [1.0], [1.0]]),
    )
    unused, still, distant = casing_warnings(body, {"near": (0.004, 0.0, 0.0), "far": (0.106, 0.0, 0.0)})
    assert unused == "box.npz: the matrix damping is not used."
    assert still.startswith("near reads 0 along y and z")
    assert "rows_file" in still
    assert distant.startswith("far measures")
    assert "6 mm from its position_mm. Correct" in distant


def test_the_number_of_a_mode_is_a_number_or_all():
    from pipelines.io.argument_types import mode_number

    assert (mode_number("all"), mode_number("3")) == ("all", 3)
    with pytest.raises(argparse.ArgumentTypeError, match="whole number from 1"):
        mode_number("any")


def page_block(language):
    """The block of code of a language in the section of the page on exported matrices."""
    section = (ROOT / "docs" / "housings.md").read_text(encoding="utf-8").partition("exported matrices\n")[2]
    (text,) = re.findall(rf"^```{language}\n(.*?)^```", section, re.M | re.S)
    return text.replace("sensor_3", "sensor_2")  # the casing of these tests has two


def test_the_examples_of_the_page_read_the_files_and_give_the_same_response(casing, tmp_path, monkeypatch):
    """The Python example as it is printed; the MATLAB one with the names and products that it takes."""
    monkeypatch.chdir(tmp_path)
    for name in ("casing.npz", "casing.mat"):
        write_casing(casing, "a casing", tmp_path / name)
    body, found = casing.body, {}
    exec(page_block("python"), found)
    rows = (body.row("sensor_2:uz")[None], body.row("bearing_1:uz")[None])
    exact = accelerances(body, *rows, np.array([500.0]))[0, 0, 0]
    assert found["frequencies"] == pytest.approx(casing.frequencies, rel=1e-9)
    assert found["response"] == pytest.approx(exact, rel=1e-7)
    c = scipy.io.loadmat("casing.mat", simplify_cells=True)
    text = page_block("matlab")
    assert set(re.findall(r"\bc\.(\w+)", text)) <= c.keys()
    out, into = (list(c["row_names"]).index(name) for name in re.findall(r"'(\w+:u\w)'", text))
    w = 2 * math.pi * 500.0
    dynamic = c["stiffness"] + 1j * w * c["damping"] - w**2 * c["mass"]
    assert -(w**2) * c["rows"][out] @ la.solve(dynamic, c["rows"][into]) == pytest.approx(exact, rel=1e-9)


def test_the_page_names_every_format_of_an_export():
    text = (ROOT / "docs" / "housings.md").read_text(encoding="utf-8").partition("exported matrices\n")[2]
    heads = " ".join(re.findall(r"^\| (`\.[^|]*)\|", text, re.M))
    assert set(re.findall(r"`(\.\w+)`", heads)) == set(FORMATS)


def test_responses_go_into_the_folder_of_out(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["casing", "minimal", "--response", "bearing_1:z", "--out", "here", "--quiet"]) == 0
    names = [f"response-minimal-bearing_1-z{ending}" for ending in (".csv", ".png")]
    assert [path.name for path in sorted((tmp_path / "here").iterdir())] == names
    assert capsys.readouterr().out.splitlines()[-2:] == [f"here/{name}" for name in names]
    assert main(["casing", "minimal", "--out", "there", "--quiet"]) == 2
    assert "Add --response, or delete --out" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["here"]
