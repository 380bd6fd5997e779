"""Diagnosis of machines that torques drive: lines at the speed that was measured, and how even it must be."""

from dataclasses import replace

import numpy as np
import pytest

import gearcase
from pipelines.diagnosis.control_diagnosis import diagnose
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import control_of, load_scene
from pipelines.scene.merge import Whole
from pipelines.signals.analysis import DiagnosisError
from pipelines.signals.measured_speed import QUARTER_PERIOD, at_measured_speed

MOTOR = {
    "model": "induction-motor", "synchronous_rpm": 3000.0, "rated_rpm": 2900.0, "rated_torque_N_m": 20.0,
    "start_rpm": 2900.0,
}  # fmt: skip
SCENE = {
    "control": "without-faults", "deviations.enabled": False,
    "faults": [{"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}],
    "load": Whole({"model": "torque", "torque_N_m": 30.0}), "simulation.end_s": 0.4, "diagnosis.gear": "pinion",
    "diagnosis.windows_s": {"steady": [0.1, 0.4]},
    "diagnosis.envelope_band_Hz": [515.0, 1445.0],  # f_m / 2 is a line of the fault: in or out by rounding
}  # fmt: skip


def loaded(drive, **changes):
    return load_scene("minimal", SCENE | {"drive": Whole(drive)} | changes)


@pytest.fixture(scope="module")
def driven():
    """Both runs under an induction motor, and what is looked for."""
    scene = loaded(MOTOR)
    runs = [gearcase.simulate(gearcase.Scene(one)) for one in (scene, control_of(scene))]
    return runs, make_machine(scene.scene).diagnosis


def test_lines_are_looked_for_where_the_shafts_turned(driven):
    """The speed by hand: at 11 N m the motor slips by some 53 of the 100 rpm of its rated torque."""
    (faulty, healthy), settings = driven
    found = diagnose(faulty, healthy, settings)
    turned = found.settings.revolution_frequency
    slip = 1 - 60 * turned / 3000.0
    assert turned != settings.revolution_frequency
    kloss = 2 * 2.5 * 20.0 / (slip / critical() + critical() / slip)
    assert kloss == pytest.approx(30.0 * 20 / 55, rel=5e-3)
    assert found.settings.mesh_frequency == pytest.approx(20 * turned)
    assert found.lines.where(kind="sideband").detected.sum() >= 3


def critical():
    """Slip of the breakdown torque, 2.5 times the rated one at 1/30."""
    return (2.5 + np.sqrt(2.5**2 - 1)) / 30


@pytest.mark.slow
def test_levels_are_those_of_the_same_machine_at_a_prescribed_speed():
    """Two heavy rotors behind the couplings of the motors of prescribed speed: all clear lines agree to 0.001 dB."""
    torque = 30.0 * 20 / 55
    slip = critical() * (50.0 - np.sqrt(50.0**2 - torque**2)) / torque
    couplings = {"motors": 2, "coupling_stiffness_N_m_per_rad": 2000.0, "coupling_damping_N_m_s_per_rad": 0.5}
    rpm = 3000.0 * (1 - slip)
    heavy = MOTOR | couplings | {"rated_torque_N_m": 10.0, "inertia_kg_m2": 5.0, "start_rpm": rpm}
    found = []
    for drive in (heavy, couplings | {"times_s": [0.0, 0.4], "speeds_rpm": [rpm, rpm]}):
        scene = loaded(drive)
        runs = [gearcase.simulate(gearcase.Scene(one)) for one in (scene, control_of(scene))]
        found.append(diagnose(*runs, make_machine(scene.scene).diagnosis))
    measured, known = found
    assert measured.settings.revolution_frequency == pytest.approx(rpm / 60, rel=1e-4)
    clear = known.lines.over_floor > 20.0
    assert clear.sum() > 8
    apart = 20 * np.log10(measured.lines.faulty / known.lines.faulty)[clear]
    assert abs(apart).max() < 1e-3


def test_a_window_in_which_the_speed_still_changes_is_refused_with_the_limit(driven):
    started = loaded(MOTOR | {"start_rpm": 1500.0}, **{"diagnosis.windows_s": {"start": [0.0, 0.4]}})
    runs = [gearcase.simulate(gearcase.Scene(one)) for one in (started, control_of(started))]
    with pytest.raises(DiagnosisError, match=r"window 'start': shaft_1 turns at .* rad from an even rotation.*settled"):
        diagnose(*runs, make_machine(started.scene).diagnosis)


def test_the_limit_is_a_quarter_period_of_the_highest_line(driven):
    """A speed that drifts evenly, the angle off its line by less or more than pi/2 over the highest order."""
    (faulty, _), settings = driven
    order = 2 * 20 + 4
    assert settings.highest_line / settings.revolution_frequency == pytest.approx(order)
    start, end = settings.windows["steady"]
    time = (faulty.time - start) / (end - start)
    for share, allowed in ((0.9, True), (1.1, False)):
        bend = share * QUARTER_PERIOD / order * 8 * (time**2 - time)  # its range about its own line: +-share
        even = 2 * np.pi * 49.0 * faulty.time
        drifting = faulty.assign(shaft_angle=(even + bend).expand_dims(shaft=faulty.shaft.values, axis=-1))
        if allowed:
            found = at_measured_speed(settings, (drifting,))
            assert found.revolution_frequency == pytest.approx(49.0, rel=1e-4)
        else:
            with pytest.raises(DiagnosisError, match=r"of the order 44, allows 0\.0357 rad"):
                at_measured_speed(settings, (drifting,))


def test_all_frequencies_that_follow_the_shafts_move_together(driven):
    (faulty, _), settings = driven
    spalled = replace(settings, bearings={"bearing_1 BPFO": 3.58 * settings.revolution_frequency})
    found = at_measured_speed(spalled, (faulty,))
    factor = found.revolution_frequency / settings.revolution_frequency
    assert found.bearings["bearing_1 BPFO"] == pytest.approx(3.58 * found.revolution_frequency)
    assert found.mesh_frequency / settings.mesh_frequency == pytest.approx(factor)
    assert found.speed_is_known


def test_a_drive_that_starts_from_standstill_says_about_how_fast_it_will_turn():
    bench, drive = gearcase.Scene.from_file("bench"), {"model": "torque", "torque_N_m": 45.0, "start_rpm": 0.0}
    with pytest.raises(SceneError, match=r"highest_rpm"):
        gearcase.check(bench.changed({"drive": drive}))
    gearcase.check(bench.changed({"drive": drive | {"highest_rpm": 1500.0}}))
