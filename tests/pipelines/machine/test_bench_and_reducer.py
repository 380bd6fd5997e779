"""Machines without a hoist: statics of the shipped bench and reducer by hand, recorded speeds, and their words."""

import json
import math
import re

import numpy as np
import pytest

import gearcase
from mbd.system.statics import equilibrium
from pipelines.engine.storage import digest
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.machine.system_assembly import assemble_machine, assemble_system
from pipelines.scene.load_scene import load_scene
from pipelines.scene.merge import Whole
from pipelines.steps.machine_steps import machine_steps

QUICK = {"casing": {"model": "none"}, "sensors": [], "faults": [], "control": None}
HOIST = re.compile(r"\b(hoist\w*|drums?|ropes?|containers?|lift|lifting|lowering|lowered|crane)\b", re.IGNORECASE)


def standing(name, **settings):
    """The scene's machine at rest under its load, error-free gears, bearings on the ground."""
    scene = load_scene(name, QUICK | {"deviations.enabled": False, "diagnosis": {"windows_s": {}}} | settings).scene
    model = make_machine(scene)
    laws = [spec.mesh.laws(spec.pair) for spec in model.laws]
    machine = assemble_machine(model.parts, laws)
    from mbd_rigs import no_casing

    system = assemble_system(machine, no_casing(), model.recorded)
    return model, system, equilibrium(system)


def bearing_forces(system, state, shaft):
    """Forces (bearing, 3) that the bearings of a shaft take, and their places y."""
    bearings = [bearing for bearing in system.machine.bearings if bearing.shaft == shaft]
    lay, found = system.layout, []
    for bearing in bearings:
        found.append(
            np.array(bearing.stiffness[:3])
            * np.array([lay.axis_row(shaft, bearing.y, a) @ state.displacement for a in range(3)])
        )
    return np.array(found), np.array([bearing.y for bearing in bearings])


@pytest.mark.parametrize(("name", "torque"), [("bench", 100.0), ("reducer", 145.0)])
def test_statics_by_hand(name, torque):
    """Torque at the motor, mesh forces and bearing forces from the load alone: ratios, base radii and levers."""
    load = {"load": Whole({"model": "torque", "torque_N_m": torque})}
    meshes = {f"stages.{number}.mesh": {"model": "iso"} for number in (1, 2)[: 1 + (name == "reducer")]}
    model, system, state = standing(name, **load, **meshes)
    ratios = [pair.ratio for pair in model.layout.pairs]
    assert state.motor_torque == pytest.approx(torque / math.prod(ratios), rel=1e-6)
    held = torque
    for pair, force in reversed(list(zip(model.layout.pairs, state.mesh_force, strict=True))):
        assert force == pytest.approx(held / pair.wheel.base_radius, rel=1e-6)
        held /= pair.ratio
    shaft = system.machine.shafts[0]
    forces, _ = bearing_forces(system, state, shaft.name)
    pair, mesh = model.layout.pairs[0], state.mesh_force[0]
    weight = 9.80665 * shaft_mass(shaft)
    axial = mesh * math.tan(pair.base_helix_angle)
    assert np.hypot(forces[:, 0].sum(), forces[:, 2].sum() + weight) == pytest.approx(mesh, rel=1e-6)
    assert abs(forces[:, 1].sum()) == pytest.approx(axial, rel=1e-6)


def shaft_mass(shaft):
    area = sum((s.outer_diameter**2 - s.inner_diameter**2) * (s.y_end - s.y_start) for s in shaft.sections)
    return math.pi / 4 * shaft.density * area + sum(disk.mass for disk in shaft.disks)


def csv(tmp_path, text):
    file = tmp_path / "speed.csv"
    file.write_text(text, encoding="utf-8")
    return {
        "drive.times_s": {"file": str(file), "column": "t"}, "drive.speeds_rpm": {"file": str(file), "column": "rpm"},
        "diagnosis.windows_s": {}, "control": None, "faults": [],
    }  # fmt: skip


def test_a_recorded_speed_is_read_and_its_content_is_in_the_key(tmp_path):
    keys = []
    for last in ("900", "901"):
        scene = load_scene("bench", csv(tmp_path, f"t;rpm\n0;0\n0.1;300.5\n0.35;{last}\n")).scene
        profile = scene.drive.profile()
        np.testing.assert_allclose(profile.speeds * 30 / np.pi, [0.0, 300.5, float(last)])
        assert profile.smooth
        keys.append(digest(machine_steps(make_machine(scene))[-1].spec))
    assert keys[0] != keys[1]


def test_a_dataset_of_an_hdf5_file_is_read_as_well(tmp_path):
    import h5py

    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["time"], file["rig/rpm"] = [0.0, 0.5, 1.0], [0.0, 500.0, 600.0]
    settings = {
        "drive.times_s": {"file": str(tmp_path / "run.h5"), "column": "time"},
        "drive.speeds_rpm": {"file": str(tmp_path / "run.h5"), "column": "rig/rpm"},
    }
    profile = load_scene("bench", settings).scene.drive.profile()
    np.testing.assert_allclose(profile.speeds * 30 / np.pi, [0.0, 500.0, 600.0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,rpm\n0,0\n0.2,600\n0.1,900\n", "0.1 follows 0.2 .*line 4"),
        ("t,rpm\n0,0\n0.1,\n0.2,900\n", "line 3, column rpm: the cell is empty"),
        ("t,rpm\n0,0\n0.1,fast\n", "line 3, column rpm: fast is not a number"),
        ("t,rpm\n0,0\n0.1,nan\n", "line 3"),
        ("t,speed\n0,0\n0.1,3\n", "columns t, speed"),
        ("t,rpm\n", "has no values"),
        ("t,rpm\n0.5,0\n0.6,3\n", "starts at 0.5 s"),
    ],
)
def test_a_bad_recording_is_refused_with_its_line(tmp_path, text, message):
    with pytest.raises(SceneError, match=message):
        make_machine(load_scene("bench", csv(tmp_path, text)).scene)


def test_a_missing_recording_is_named():
    settings = {
        "drive.times_s": {"file": "none.csv", "column": "t"},
        "drive.speeds_rpm": {"file": "none.csv", "column": "v"},
    }
    with pytest.raises(SceneError, match=r"drive.times_s.file.*no such file"):
        make_machine(load_scene("bench", settings).scene)


TORQUE_DRIVE = {"model": "torque", "torque_N_m": 3.0, "start_rpm": 900.0}
INDUCTION = {"model": "induction-motor", "synchronous_rpm": 1500.0, "rated_rpm": 1510.0, "rated_torque_N_m": 3.0}


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"load.torques_N_m": [1.0]}, "torque_N_m is constant, and torques_N_m varies"),
        ({"load": {"model": "torque"}}, "Set torque_N_m"),
        ({"drive": TORQUE_DRIVE | {"motors": 2, "position_mm": 0.0}}, "Delete position_mm"),
        ({"drive": INDUCTION}, "below synchronous"),
        ({"sensors.1.name": "bearing_7"}, "name of another point"),
        ({"sensors.1.name": "motor side"}, "motor side"),
    ],
)
def test_contradictions_are_refused(settings, message):
    with pytest.raises(SceneError, match=message):
        load_scene("bench", settings)


def test_a_motor_that_the_load_overcomes_is_said():
    weak = {"drive": TORQUE_DRIVE | {"torque_N_m": 30.0}, "diagnosis.windows_s": {}, "control": None, "faults": []}
    said = " ".join(gearcase.check(gearcase.Scene.from_file("bench").changed(weak)).warnings)
    assert "the motors give at most 30 N m, and the load takes 40.32 N m" in said


def test_a_probe_reads_where_the_bearing_forces_push_the_shaft():
    """At a bearing on the ground the axis moves by the bearing's force over its stiffness."""
    place = 1000 * load_scene("bench").scene.shafts[1].bearing_positions_mm[0] / 1000
    probes = {"probes": [{"name": "eddy-1", "shaft": 2, "position_mm": place}]}
    _, system, state = standing("bench", **probes, **{"stages.1.mesh": {"model": "iso"}})
    forces, _ = bearing_forces(system, state, "shaft_2")
    stiffness = system.machine.bearings[2].stiffness[:3]
    names = system.channels.names
    for axis, force, k in zip("xyz", forces[0], stiffness, strict=True):
        row = system.channels.displacement[names.index(f"eddy-1:displacement_{axis}")]
        assert row @ state.displacement == pytest.approx(force / k, rel=1e-9)


def test_a_probe_beside_its_shaft_or_given_twice_is_refused():
    one = {"name": "a", "shaft": 2, "position_mm": 0.0}
    with pytest.raises(SceneError, match="occurs 2 times"):
        load_scene("bench", {"probes": [one, one]})
    with pytest.raises(SceneError, match="not on shaft 2"):
        gearcase.check(gearcase.Scene.from_file("bench").changed({"probes": [one | {"position_mm": 900.0}]}))


SHORT = {
    "probes": [{"name": "eddy-1", "shaft": 2, "position_mm": 60.0}],
    "simulation.end_s": 0.6, "drive.times_s": [0.0, 0.05, 0.6], "drive.speeds_rpm": [0.0, 3000.0, 3000.0],
    "diagnosis.windows_s": {"steady": [0.1, 0.6]}, "stages.1.mesh": {"model": "iso"}, "simulation.step_us": 26.1,
"casing.model": "rigid", "casing.mount_stiffness_N_per_um": 200.0,
}  # fmt: skip


MISSING = [{"kind": "missing-tooth", "stage": 1, "gear": "wheel", "tooth": 3}]


@pytest.mark.slow
def test_a_bench_speaks_of_no_hoist_in_any_output(tmp_path):
    folder = tmp_path / "run"
    gearcase.run(gearcase.Scene.from_file("bench").changed(SHORT | {"faults": MISSING}), out=folder)
    for file in sorted(folder.iterdir()):
        text = file.read_bytes().decode("utf-8", errors="ignore") if file.suffix != ".html" else file.read_text("utf-8")
        if file.suffix == ".nc":
            import h5netcdf

            with h5netcdf.File(file) as data:
                text = json.dumps([str(dict(data.attrs)), [f"{n} {dict(v.attrs)}" for n, v in data.variables.items()]])
        text = re.sub(r"base64,[A-Za-z0-9+/=]+", "", text)
        assert not HOIST.findall(text), file.name


def test_check_and_messages_of_a_bench_speak_of_no_hoist(capsys):
    from pipelines.cli.main import main

    assert main(["check", "bench"]) == 0
    assert main(["check", "reducer"]) == 0
    for words in (["run", "--help"], ["--help"]):
        with pytest.raises(SystemExit):
            main(words)
    assert not HOIST.findall(capsys.readouterr().out)


def test_torque_of_the_load_and_displacement_at_a_probe_are_recorded():
    data = gearcase.simulate(gearcase.Scene.from_file("bench").changed(SHORT | {"faults": MISSING}))
    assert data.probe_displacement.sizes == {"time": 7680, "probe": 1, "axis": 3}
    assert 1e-7 < float(abs(data.probe_displacement).max()) < 1e-4
    np.testing.assert_allclose(data.source_torque.sel(source="load"), -100.0)
