"""Acceleration of the ground: the same motion in the frame of the ground and in one that stands still."""

import dataclasses

import numpy as np
import pytest
from factored_casing import factored
from housings import short_housing
from mbd_rigs import no_casing, rigid_casing, train

from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.reduced.casing_modes import casing_modes, reduced_body
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.reduction import reduce_body
from fem.casing.reduced.reduction_error import sensor_rows
from fem.elements.materials import CAST_IRON
from mbd.excitations.base_acceleration import AccelerationSweep, AccelerationTable, BaseAcceleration
from mbd.excitations.unbalance import Unbalance
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.frequency_response import frequency_response
from mbd.system.linearised import tangent
from mbd.system.statics import equilibrium
from mbd.system.system import assemble
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene

STANDING = SpeedProfile(times=np.zeros(1), speeds=np.zeros(1))
SWEEP = AccelerationSweep(start=0.0, end=0.6, first=20.0, last=1200.0, ramp=0.05, amplitude=1.0)
CHANNELS = (
    "base:ground_acceleration",
    "sensor_2:az",
    "sensor_1:ax",
    "bearing_3:fz",
    "bearing_1:journal_az",
    "motor_1:torque",
)
RATE = 5e3


def shaken(axis="z", wave=SWEEP, channels=CHANNELS):
    base = BaseAcceleration(name="base", axis=axis, acceleration=wave)
    machine = train(1, profile=STANDING, coupling_damping=20.0, bearing_tau=3e-4, shaft_tau=5e-5)
    machine = dataclasses.replace(machine, forces=(base,))
    return assemble(machine, rigid_casing(machine, extra=3, ratio=0.03), channels, np.inf)


@pytest.mark.parametrize("axis", ["x", "z"])
def test_the_answer_is_that_of_a_machine_whose_mounts_are_moved(axis):
    """Independent of all inertia: (K + i w C - w^2 M) q = (K + i w C) X with absolute q, driven through the mounts."""
    system = shaken(axis)
    frequencies = np.array([5.0, 60.0, 130.0, 400.0, 900.0])
    found = frequency_response(system, "base", frequencies)
    small, k = tangent(system, equilibrium(system)), "xyz".index(axis)
    moved = system.layout.translation[:, k].copy()
    moved[system.layout.index("casing")[k]] = 1.0  # the first coordinates of this casing are its translation
    for i, omega in enumerate(2 * np.pi * frequencies):
        springs = small.stiffness + 1j * omega * small.damping
        q = np.linalg.solve(springs - omega**2 * system.mass, springs @ moved)
        for name in CHANNELS[1:5]:
            at = system.channels.names.index(name)
            if name == "bearing_3:fz":
                wanted = (system.channels.displacement + 1j * omega * system.channels.velocity)[at] @ q / -(omega**2)
            else:
                wanted = system.channels.acceleration[at] @ q
            assert found[at, i] == pytest.approx(wanted, rel=1e-6, abs=1e-9 * abs(found[at]).max())


def test_a_sweep_of_the_ground_finds_the_frequency_response():
    system = shaken()
    run = simulate(system, MotionSettings(end=1.0, output_rate=RATE, step=2e-5))
    frequencies = np.fft.rfftfreq(len(run.time), 1 / RATE)
    some = np.flatnonzero((frequencies > 60.0) & (frequencies < 1100.0))[::5]
    exact = frequency_response(system, "base", frequencies[some])
    push = np.fft.rfft(run.channel("base:ground_acceleration"))[some]
    for name, wanted in zip(CHANNELS, exact, strict=True):
        signal = run.channel(name) - run.channel(name)[0]
        found = np.fft.rfft(signal)[some] / push
        heard = abs(wanted) > 0.01 * abs(wanted).max()
        assert abs(20 * np.log10(abs(found / wanted)[heard])).max() < 0.1, name


def test_slowly_everything_goes_with_the_ground():
    """All accelerometers read the acceleration of the ground; the mounts carry all mass times it."""
    wave = AccelerationTable(times=np.array([0.0, 0.3]), levels=np.array([0.0, 2.0]))
    system = shaken(wave=wave, channels=("sensor_1:az", "sensor_3:ax", "bearing_1:journal_az"))
    run = simulate(system, MotionSettings(end=0.5, output_rate=RATE, step=5e-5))
    for name, read in (("sensor_1:az", 2.0), ("sensor_3:ax", 0.0), ("bearing_1:journal_az", 2.0)):
        assert run.channel(name)[-1] == pytest.approx(read, abs=1e-3)
    inertia = system.element("base").rows[0]
    whole = system.layout.translation[:, 2].copy()
    whole[system.layout.index("casing")[2]] = 1.0
    assert inertia @ whole == pytest.approx(-whole @ system.mass @ whole, rel=1e-9)


def test_an_unbalance_on_shaken_ground_feels_its_true_acceleration():
    """Heavy towards +x, ground pushed up by a: its weight turns the shaft with U (g + a)."""
    wave = AccelerationTable(times=np.zeros(1), levels=np.full(1, 5.0))
    heavy = Unbalance(name="heavy", shaft="shaft_1", y=0.0, size=1e-2)
    torques = []
    for forces in ((), (heavy,), (heavy, BaseAcceleration(name="base", axis="z", acceleration=wave))):
        machine = dataclasses.replace(train(1, profile=STANDING), forces=forces)
        torques.append(equilibrium(assemble(machine, no_casing(), ())).motor_torque)
    assert torques[1] - torques[0] == pytest.approx(-1e-2 * 9.80665, rel=1e-3)
    assert torques[2] - torques[0] == pytest.approx(-1e-2 * (9.80665 + 5.0), rel=1e-3)


def reduced(mesh, **ground):
    casing = factored(assembled_casing(mesh, CAST_IRON, **ground))
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=5000.0)
    return casing, casing_modes(casing, reduction, model="craig-bampton", band_limit=5000.0)


def test_a_clamped_casing_sags_under_its_inertia_as_the_full_model():
    """Static answer of the sensors to a constant acceleration along z; its modes alone hold no translation."""
    mesh = mesh_housing(short_housing(), element_size=0.07)
    casing, modes = reduced(mesh)
    sensors = short_housing().sensors
    body = reduced_body(modes, sensors=sensors)
    load = casing.expansion.T @ casing.inertial[:, 2:3]
    exact = sensor_rows(casing, sensors) @ casing.interface.factor.solve(load)[:, 0]
    answer = body.rows @ np.linalg.solve(body.stiffness, body.ground_inertia[:, 2])
    found = [answer[body.row_names.index(f"{s.name}:u{axis}")] for s in sensors for axis in "xyz"]
    assert abs(found - exact).max() < 0.05 * abs(exact).max()  # what the modes beyond 5 kHz would add


def test_the_mounts_of_a_casing_on_springs_carry_its_mass():
    mesh = mesh_housing(short_housing(), element_size=0.07, element="tetrahedron-4")  # exact on every mesh
    _, modes = reduced(mesh, ground="springs")
    body = reduced_body(modes, sensors=short_housing().sensors, mounts=((2e7, 3e7, 5e7),))
    for k, (axis, stiffness) in enumerate(zip(("ux", "uy", "uz"), (2e7, 3e7, 5e7), strict=True)):
        q = np.linalg.solve(body.stiffness, body.ground_inertia[:, k])
        feet = [n for n in body.row_names if n.startswith("ground_") and n.endswith(axis)]
        carried = stiffness * sum(body.row(name) @ q for name in feet)
        assert carried == pytest.approx(modes.total_mass, rel=1e-6)


def test_base_acceleration_of_a_scene_in_si():
    sweep = {
        "model": "sweep", "start_s": 0.0, "end_s": 0.4, "from_Hz": 10.0, "to_Hz": 500.0, "ramp_s": 0.05,
        "amplitude_m_s2": 3.0,
    }  # fmt: skip
    table = {"model": "table", "times_s": [0.0, 0.1], "accelerations_m_s2": [0.0, 2.0]}
    forces = [{"model": "base-acceleration", "axis": "z", "acceleration": wave} for wave in (sweep, table)]
    one, other = make_machine(load_scene("minimal", {"forces": forces}).scene).parts.forces
    assert (one.axis, one.acceleration.amplitude) == ("z", 3.0)
    np.testing.assert_array_equal(other.acceleration.levels, [0.0, 2.0])


def test_a_single_foot_is_not_moved():
    force = {
        "model": "base-acceleration", "axis": "z", "foot": "ground_1",
        "acceleration": {"model": "table", "times_s": [0.0], "accelerations_m_s2": [1.0]},
    }  # fmt: skip
    with pytest.raises(SceneError, match=r"foot.*is not a key"):
        load_scene("minimal", {"forces": [force]})
