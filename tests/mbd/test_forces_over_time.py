"""Forces over time on shafts and on the casing: a swept sine finds the frequency response of the linearised machine."""

import dataclasses

import numpy as np
import pytest
from factored_casing import factored
from housings import small_housing
from mbd_rigs import no_casing, rigid_casing, train

import gearcase
from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.reduced.casing_modes import casing_modes, reduced_body
from fem.casing.reduced.grounded import ForcedPoint, assembled_casing
from fem.casing.reduced.reduction import reduce_body
from fem.casing.reduced.reduction_error import sensor_rows
from fem.elements.materials import CAST_IRON
from mbd.excitations.outside_force import CasingForce, ForceSweep, ForceTable, ShaftForce
from mbd.excitations.waveform import wave_value
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.part_checks import MachineError
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.frequency_response import frequency_response
from mbd.system.system import assemble
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.steps.machine_steps import machine_steps

RATE = 5e3
SWEEP = ForceSweep(start=0.0, end=0.6, first=20.0, last=1200.0, ramp=0.05, amplitude=2.0)
ON_CASING = CasingForce(name="push", point="sensor_1", axis="z", force=SWEEP)
ON_SHAFT = ShaftForce(name="push", shaft="shaft_2", y=0.0, axis="x", force=SWEEP)


def test_a_sweep_has_its_amplitude_between_the_ramps_and_a_phase_of_the_integral_of_its_frequency():
    time = np.linspace(-0.05, 0.65, 701)
    t = np.clip(time, SWEEP.start, SWEEP.end)
    rise = np.sin(np.pi / 2 * np.minimum(np.minimum(t, SWEEP.end - t) / SWEEP.ramp, 1.0)) ** 2
    turns = SWEEP.first * t + (SWEEP.last - SWEEP.first) * t**2 / (2 * SWEEP.end)
    exact = SWEEP.amplitude * rise * np.sin(2 * np.pi * turns)
    assert [wave_value(SWEEP.packed, one) for one in time] == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("force", [ON_CASING, ON_SHAFT], ids=["casing", "shaft"])
def test_a_sweep_finds_the_frequency_response_of_the_linearised_machine(force):
    """FFT(out)/FFT(in) within 0.1 dB wherever the answer is within 40 dB of the channel's largest."""
    standing = SpeedProfile(times=np.zeros(1), speeds=np.zeros(1))
    machine = train(1, profile=standing, coupling_damping=20.0, bearing_tau=3e-4, shaft_tau=5e-5)
    machine = dataclasses.replace(machine, forces=(force,))
    channels = ("push:outside_force", "sensor_2:az", "sensor_1:ax", "motor_1:torque", "bearing_1:fx")
    system = assemble(machine, rigid_casing(machine, extra=3, ratio=0.03), channels, np.inf)
    run = simulate(system, MotionSettings(end=1.0, output_rate=RATE, step=2e-5))
    assert run.counter("stage_1:contact_losses") == 0
    frequencies = np.fft.rfftfreq(len(run.time), 1 / RATE)
    some = np.flatnonzero((frequencies > 60.0) & (frequencies < 1100.0))[::5]
    exact = frequency_response(system, "push", frequencies[some])
    push = np.fft.rfft(run.channel("push:outside_force"))[some]
    for name, wanted in zip(channels, exact, strict=True):
        signal = run.channel(name) - run.channel(name)[0]
        assert abs(signal[-200:]).max() < 1e-6 * abs(signal).max()  # at rest again
        found = np.fft.rfft(signal)[some] / push
        heard = abs(wanted) > 0.01 * abs(wanted).max()
        assert heard.sum() > 50
        assert abs(20 * np.log10(abs(found / wanted)[heard])).max() < 0.1, name


def test_a_sweep_is_a_sine_of_rising_frequency_that_starts_and_ends_at_rest():
    times = np.linspace(-0.1, 0.7, 80001)
    values = SWEEP.values(times)
    assert not values[(times <= 0.0) | (times >= 0.6)].any()
    assert abs(values).max() == pytest.approx(2.0, rel=1e-3)
    assert abs(np.diff(values[:10102])).max() < 1e-4  # smooth where it starts
    up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    turns = 0.6 * (20.0 + 1200.0) / 2
    assert len(up) == pytest.approx(turns, abs=1.0)
    middle = (times[up] > 0.29) & (times[up] < 0.31)
    assert 1 / np.diff(times[up][middle]).mean() == pytest.approx(610.0, rel=0.01)


def test_a_table_is_linear_between_its_times_and_constant_outside():
    wave = ForceTable(times=np.array([0.1, 0.2, 0.5]), levels=np.array([1.0, 3.0, -3.0]))
    times = np.linspace(0.0, 0.7, 57)
    np.testing.assert_allclose(wave.values(times), np.interp(times, wave.times, wave.levels), atol=1e-12)


def test_a_force_that_is_raised_slowly_ends_in_the_static_answer():
    standing = SpeedProfile(times=np.zeros(1), speeds=np.zeros(1))
    wave = ForceTable(times=np.array([0.0, 0.2]), levels=np.array([0.0, 50.0]))
    push = ShaftForce(name="push", shaft="shaft_2", y=-0.1, axis="y", force=wave)
    machine = dataclasses.replace(train(1, profile=standing, bearing_tau=3e-4), forces=(push,))
    run = simulate(
        assemble(machine, no_casing(), ("bearing_3:fy", "bearing_4:fy")),
        MotionSettings(end=0.3, output_rate=2e3, step=5e-5),
    )
    # helical teeth share nothing of a thrust on shaft 2 as long as the motors hold shaft 1 in both bearings
    carried = sum(run.channel(name) - run.channel(name)[0] for name in ("bearing_3:fy", "bearing_4:fy"))
    assert carried[-1] == pytest.approx(50.0, rel=0.05)


def test_a_forced_point_of_an_elastic_casing_gives_way_as_the_full_model():
    """Static answer to a force at a sensor: exact with the point as an interface, too stiff without."""
    housing = small_housing()
    mesh, sensor = mesh_housing(housing, element_size=0.07, element="tetrahedron-4"), housing.sensors[0]
    moved = {}
    for forced in ((), (ForcedPoint(sensor=sensor, axes=("uz",)),)):
        casing = factored(assembled_casing(mesh, CAST_IRON, forced=forced))
        reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=600.0)
        modes = casing_modes(casing, reduction, model="craig-bampton", band_limit=600.0)
        body = reduced_body(modes, sensors=housing.sensors)
        row = body.row(f"{sensor.name}:uz")
        moved[bool(forced)] = row @ np.linalg.solve(body.stiffness, row)
        assert len(set(body.row_names)) == len(body.row_names)
    row = sensor_rows(casing, (sensor,)).toarray()[2]
    exact = row @ casing.interface.factor.solve(row[:, None])[:, 0]
    assert moved[True] == pytest.approx(exact, rel=1e-8)
    assert moved[False] < 0.99 * exact


SCENE_SWEEP = {
    "model": "sweep", "start_s": 0.0, "end_s": 0.4, "from_Hz": 10.0, "to_Hz": 500.0, "ramp_s": 0.05,
    "amplitude_N": 30.0,
}  # fmt: skip
PUSHED = {"model": "casing-force", "point": "sensor_3", "axis": "z", "force": SCENE_SWEEP}


def test_forces_of_a_scene_in_si_and_the_casing_that_bears_them():
    table = {"model": "table", "times_s": [0.0, 0.1], "forces_N": [0.0, 20.0]}
    shaft = {"model": "shaft-force", "shaft": 2, "position_mm": 10.0, "axis": "x", "force": table}
    elastic = {"casing.model": "craig-bampton", "casing.band_Hz": 1000.0, "casing.element_size_mm": 40.0}
    model = make_machine(load_scene("minimal", elastic | {"forces": [PUSHED, shaft]}).scene)
    casing, on_shaft = model.parts.forces
    assert (casing.casing_rows, casing.force.amplitude, casing.force.last) == (("sensor_3:uz",), 30.0, 500.0)
    assert (on_shaft.shaft, on_shaft.y, on_shaft.axis) == ("shaft_2", 0.01, "x")
    np.testing.assert_array_equal(on_shaft.force.levels, [0.0, 20.0])
    modes = next(step for step in machine_steps(model) if step.name == "casing modes")
    assert [(point.sensor.name, point.axes) for point in modes.spec.forced] == [("sensor_3", ("uz",))]


@pytest.mark.parametrize(
    ("force", "message"),
    [
        (PUSHED | {"point": "sensor_99"}, 'forces.1.point = "sensor_99".*Set one of sensor_3'),
        (PUSHED | {"force": SCENE_SWEEP | {"ramp_s": 0.3}}, "ramp_s = 0.3 is more than half of"),
        (PUSHED | {"axis": "w"}, "axis"),
        (
            {"model": "shaft-force", "shaft": 1, "position_mm": 5000.0, "axis": "x", "force": SCENE_SWEEP},
            "forces.1.position_mm",
        ),
    ],
)
def test_forces_that_cannot_be_are_refused(force, message):
    with pytest.raises(SceneError, match=message):
        checked_machine(load_scene("minimal", {"forces": [force]}).scene, "minimal")


def test_a_casing_that_stands_still_cannot_be_forced():
    machine = dataclasses.replace(train(1), forces=(ON_CASING,))
    with pytest.raises(MachineError, match="sensor_1 does not move"):
        assemble(machine, no_casing(), ())


def test_the_response_holds_what_excited_it(tmp_path, monkeypatch):
    monkeypatch.setenv("GEARCASE_CACHE", str(tmp_path))
    ground = {
        "model": "base-acceleration", "axis": "x",
        "acceleration": {"model": "table", "times_s": [0.0, 0.01], "accelerations_m_s2": [0.0, 0.5]},
    }  # fmt: skip
    scene = gearcase.Scene.from_file("minimal").changed(
        {"forces": [PUSHED, ground], "simulation.end_s": 0.1, "drive.times_s": [0.0, 0.05, 0.1],
         "diagnosis.windows_s": {}}
    )  # fmt: skip
    response = gearcase.simulate(scene)
    assert response.outside_force.dims == ("time", "force")
    assert list(response.force.values) == ["force_1"]
    assert list(response.base.values) == ["force_2"]
    (wave,) = (force.force for force in make_machine(load_scene("minimal", {"forces": [PUSHED]}).scene).parts.forces)
    inside = slice(None, -20)
    wanted = wave.values(response.time.values)
    assert abs(response.outside_force.values[inside, 0] - wanted[inside]).max() < 0.02 * abs(wanted).max()
    assert float(response.ground_acceleration[-1, 0]) == pytest.approx(0.5, rel=1e-6)
