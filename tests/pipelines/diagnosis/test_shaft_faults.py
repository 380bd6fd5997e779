"""Faults of shafts: what is told of them, the control without them, and their orders in the diagnosis."""

import json
from dataclasses import replace

import numpy as np
import pytest

import gearcase
from pipelines.cli.main import main
from pipelines.diagnosis.control_diagnosis import diagnose
from pipelines.diagnosis.line_words import lines_grid
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import control_differences, control_of, load_scene
from pipelines.steps.reporting import shaft_rows

UNBALANCE = {"model": "unbalance", "shaft": 1, "position_mm": 20.0, "unbalance_g_mm": 500.0}
BOW = {"model": "bent-shaft", "shaft": 2, "position_mm": 0.0, "bow_um": 50.0, "straight_at_mm": [-60.0, 60.0]}
RIPPLE = {"model": "torque-ripple", "shaft": 1, "position_mm": 0.0, "amplitude_N_m": 0.5, "order": 6.0}
PUSH = {
    "model": "shaft-force", "shaft": 1, "position_mm": 0.0, "axis": "x",
    "force": {"model": "table", "times_s": [0.0, 1.0], "forces_N": [0.0, 1.0]},
}  # fmt: skip
SHAKE = {
    "model": "base-acceleration", "axis": "x",
    "acceleration": {"model": "table", "times_s": [0.0, 1.0], "accelerations_m_s2": [0.0, 1.0]},
}  # fmt: skip
DISK = {
    "shaft": 2, "position_mm": 10.0, "mass_kg": 2.0, "polar_inertia_kg_m2": 1e-3, "diametral_inertia_kg_m2": 1e-3,
}  # fmt: skip
ECCENTRIC = DISK | {"eccentricity_um": 30.0, "eccentricity_angle_deg": 90.0}
STEADY = {  # one stage at 3,000 rpm in a rigid casing; error-free gears
    "control": "without-faults", "deviations.enabled": False, "shaft_model.model": "timoshenko",
    "drive.times_s": [0.0, 0.4], "drive.speeds_rpm": [3000.0, 3000.0], "simulation.end_s": 0.4,
    "diagnosis.gear": "pinion", "diagnosis.noise_m_s2": 1e-4, "diagnosis.windows_s": {"steady": [0.1, 0.4]},
}  # fmt: skip
STRAIGHT = {  # a motor's shaft in front of shaft 1, behind a coupling that is stiffer along one of its axes
    "shafts": [3, 1], "positions_mm": [-110.0, -100.0], "torsional_stiffness_N_m_per_rad": 1e4,
    "radial_stiffness_N_per_um": 2.0, "radial_stiffness_across_N_per_um": 1.0, "damping_time_us": 20.0,
}  # fmt: skip
OFFSET = STRAIGHT | {"offset_um": [100.0, 0.0]}
TURN = 50.0, 50.0 * 20 / 55


def loaded(**changes):
    return load_scene("minimal", STEADY | changes)


def machine(**changes):
    return make_machine(loaded(**changes).scene)


def test_a_scene_tells_the_faults_of_its_shafts_with_their_place_and_severity():
    found = machine(forces=[PUSH, UNBALANCE, BOW], disks=[DISK, ECCENTRIC])
    assert found.labels["state"] == "bent-shaft+unbalance"
    assert found.fault_words == (
        "unbalance of shaft 1 at y = 20 mm",
        "bent shaft of shaft 2 at y = 0 mm",
        "unbalance of shaft 2 by disk 2 at y = 10 mm",
    )
    faults = json.loads(found.labels["faults"])
    assert [(fault["kind"], fault["shaft"]) for fault in faults] == [
        ("unbalance", 1), ("bent-shaft", 2), ("unbalance", 2),
    ]  # fmt: skip
    assert [fault["unbalance_g_mm"] for fault in faults if fault["kind"] == "unbalance"] == [500.0, 60.0]


def coupled(table):
    """Scene with a coupling between a third shaft, at the motors, and shaft 1; the bearings stand on the ground."""
    shafts = [shaft.model_dump(exclude_none=True) for shaft in load_scene("minimal").scene.shafts]
    front = {
        "sections": [{"start_mm": -350.0, "end_mm": -110.0, "diameter_mm": 25.0}],
        "bearing_positions_mm": [-320.0, -140.0],
    }
    return {
        "shafts": [*shafts, front], "couplings": [table], "stages.1.pinion_shaft": 1, "stages.1.wheel_shaft": 2,
        "drive.shaft": 3, "drive.motors": 1, "load.shaft": 2, "casing": {"model": "none"}, "sensors": [],
    }  # fmt: skip


def test_a_coupling_is_at_fault_only_where_its_shafts_lie_apart():
    assert machine(**coupled(STRAIGHT)).labels["state"] == "healthy"  # two stiffness axes are a design
    found = machine(**coupled(OFFSET))
    assert found.labels["state"] == "misaligned-coupling"
    assert found.fault_words == ("misaligned coupling 1 of shafts 3 and 1",)
    (fault,) = json.loads(found.labels["faults"])
    assert (fault["shaft"], fault["offset_um"]) == (3, [100.0, 0.0])
    faulty = loaded(**coupled(OFFSET))
    control = control_of(faulty)
    assert control.scene.couplings == loaded(**coupled(STRAIGHT)).scene.couplings
    assert control_differences(faulty, control) == []


def test_a_misaligned_coupling_raises_the_second_order_over_its_control():
    """Listened to at the journal of bearing 1, there is no casing."""
    faulty = loaded(**coupled(OFFSET))
    runs = [gearcase.simulate(gearcase.Scene(one)) for one in (faulty, control_of(faulty))]
    made = make_machine(faulty.scene)
    made = replace(made, monitored=replace(made.monitored, sensor="bearing_1", possible=True))
    found = diagnose(*runs, made.diagnosis)
    own = found.lines.where(kind="shaft")
    assert own.label[1] == "2x shaft_3"
    assert own.difference[1] > 20.0
    assert own.detected[1]


def test_forces_from_outside_and_the_ripple_of_a_motor_are_no_faults():
    found = machine(forces=[PUSH, SHAKE, RIPPLE])
    assert found.labels["state"] == "healthy"
    assert found.labels["faults"] == "[]"
    assert found.fault_words == ()


def test_the_control_keeps_excitations_and_leaves_out_faults():
    """Whatever is no fault stays, to the last value: the disk without its eccentricity, the forces in their order."""
    faulty = loaded(forces=[PUSH, UNBALANCE, RIPPLE, BOW], disks=[ECCENTRIC])
    control = control_of(faulty)
    healthy = loaded(forces=[PUSH, RIPPLE], disks=[DISK])
    assert control.scene.forces == healthy.scene.forces
    assert control.scene.disks == healthy.scene.disks
    assert make_machine(control.scene).labels["state"] == "healthy"
    assert control_differences(faulty, control) == []


def test_a_control_of_its_own_takes_no_fault_from_the_settings():
    settings = STEADY | {"control": "minimal", "forces": [UNBALANCE, RIPPLE], "disks": [ECCENTRIC]}
    faulty = load_scene("minimal", settings)
    control = control_of(faulty)
    assert [force.model for force in control.scene.forces] == ["torque-ripple"]
    assert control.scene.disks[0].eccentricity_um == 0.0
    assert control_differences(faulty, control) == []


def test_orders_of_every_faulty_shaft_are_looked_for_and_listed():
    found = machine(forces=[UNBALANCE, BOW])
    assert [line.shaft for line in found.diagnosis.turning] == ["shaft_1", "shaft_2"]
    for line, turn in zip(found.diagnosis.turning, TURN, strict=True):
        assert [frequency for _, _, frequency in line.monitored()] == pytest.approx([turn, 2 * turn])
    rows = shaft_rows(found)
    assert [row["fault"] for row in rows] == list(found.fault_words)
    assert [(row["1x Hz"], row["2x Hz"]) for row in rows] == [pytest.approx((turn, 2 * turn)) for turn in TURN]


@pytest.fixture(scope="module")
def unbalanced():
    """An unbalance, alone in the scene, against the control that the scene makes of itself."""
    faulty = loaded(forces=[UNBALANCE])
    runs = [gearcase.simulate(gearcase.Scene(one)) for one in (faulty, control_of(faulty))]
    return runs, diagnose(*runs, make_machine(faulty.scene).diagnosis)


def test_an_unbalance_alone_raises_the_first_order_over_its_control(unbalanced):
    (faulty, healthy), found = unbalanced
    assert (faulty.attrs["state"], healthy.attrs["state"]) == ("unbalance", "healthy")
    own = found.lines.where(kind="shaft")
    assert own.label == ("1x shaft_1", "2x shaft_1")
    assert own.frequency == pytest.approx([50.0, 100.0])
    assert own.difference[0] > 20.0
    assert own.detected[0]


def test_the_level_of_an_order_is_the_amplitude_of_its_sine(unbalanced):
    """Read off the signal by its Fourier sum over whole turns, up to the noise of the diagnosis."""
    (faulty, _), found = unbalanced
    signal = faulty.acceleration.sel(sensor=found.settings.sensor, axis="z").sel(time=slice(0.2, 0.39999))
    sine = np.exp(-2j * np.pi * 50.0 * signal.time.values)
    amplitude = 2 * abs(np.mean(signal.values * sine))
    assert found.lines.where(kind="shaft").faulty[0] == pytest.approx(amplitude, rel=0.01)


def test_the_table_has_the_order_of_the_shaft(unbalanced):
    _, found = unbalanced
    row = next(row for row in lines_grid(found, "steady").rows if row[0] == "1x shaft_1")
    assert row[-1] == "detected"


def test_an_order_that_the_window_does_not_hold_is_left_out(unbalanced):
    (faulty, healthy), _ = unbalanced
    slow = machine(forces=[UNBALANCE | {"shaft": 2}], **{"diagnosis.windows_s": {"short": [0.27, 0.4]}}).diagnosis
    found = diagnose(faulty, healthy, slow)
    assert found.lines.where(kind="shaft").label == ("2x shaft_2",)


def test_check_lists_faults_of_shafts_with_their_orders(tmp_path, capsys):
    path = tmp_path / "unbalanced.toml"
    scene = gearcase.Scene.from_file("minimal").changed(STEADY | {"forces": [UNBALANCE]})
    path.write_text(scene.to_toml(), encoding="utf-8")
    assert main(["check", str(path)]) == 0
    text = capsys.readouterr().out
    assert "unbalance of shaft 1 at y = 20 mm: 1x shaft_1 50 Hz, 2x shaft_1 100 Hz" in text
    assert "faults: unbalance of shaft 1 at y = 20 mm" in text
