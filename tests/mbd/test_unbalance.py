"""Unbalance turns with its shaft, whirls it as the closed form says, and takes its energy from the motors."""

import cmath
import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing, train
from rotors import CRITICAL, DAMPING, LENGTH, MASS, MOVING, PROBE, STIFFNESS, jeffcott, line

from mbd.excitations.unbalance import Unbalance
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.part_checks import MachineError
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.linearised import linear_modes
from mbd.system.system import assemble
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene

ECCENTRIC = 10e-6  # m
ANGLE = 0.3


def unbalance(**changes):
    fields = {"name": "unbalance", "shaft": "shaft_1", "y": LENGTH / 2, "size": MASS * ECCENTRIC, "angle": ANGLE}
    return Unbalance(**fields | changes)


def whirl(machine, channels=PROBE, end=1.2, rate=2000.0, step=1e-4):
    return simulate(assemble(machine, no_casing(), channels), MotionSettings(end=end, output_rate=rate, step=step))


@pytest.mark.parametrize("r", [0.6, 1.0, 1.6])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_jeffcott_rotor_whirls_by_the_closed_form_in_size_and_phase(r, sense):
    """x + i z = e mu r^2/(1 - r^2 + 2 i zeta r) e^(i (alpha - s Omega t)) about its stiffness line."""
    speed = r * CRITICAL
    run = whirl(jeffcott(unbalance(), speed=speed, sense=sense))
    late = run.time > 0.8
    time = run.time[late]
    size = ECCENTRIC * MASS / MOVING * r * r
    answer = size / complex(1 - r * r, 2 * DAMPING * r) * cmath.exp(-1j * sense * ANGLE)
    for name, quarter in (("probe:x", 1.0), ("probe:z", 1j * sense)):
        found = line(time, run.channel(name)[late], speed)
        assert abs(found / (answer * quarter) - 1) < 5e-3


def test_what_the_whirl_dissipates_comes_from_the_motor():
    """At the critical speed: the works of the force and of its torque cancel but for what was stored at first."""
    run = whirl(jeffcott(unbalance(), speed=CRITICAL), ("motor_1:torque",), end=1.0, step=2e-5)
    lost = run.energy("shaft_1", "dissipated")
    assert lost > 0.1
    assert abs(run.energy("unbalance", "dissipated")) < 1e-3 * lost
    late = run.time > 0.8
    amplitude = ECCENTRIC * MASS / MOVING / (2 * DAMPING)
    drag = 2 * DAMPING * CRITICAL * MOVING * CRITICAL**2 * amplitude**2 / CRITICAL  # c v^2 over the speed
    assert run.channel("motor_1:torque")[late].mean() == pytest.approx(drag, rel=0.01)
    assert not run.open_parts()


def test_a_run_up_takes_up_as_much_as_the_lagrangian_stores():
    """Through the critical speed with tangential force: work of the unbalance is the change of T = U beta' v . t."""
    profile = SpeedProfile(times=np.array([0.0, 0.5]), speeds=np.array([0.0, 1.5 * CRITICAL]))
    channels = ("motor_1:torque", "shaft_1:angle", "shaft_1:speed", *PROBE)
    run = whirl(jeffcott(unbalance(), profile=profile), channels, end=0.5, rate=50e3, step=2e-5)
    x, z = (np.gradient(run.channel(name), run.time, edge_order=2)[-1] for name in PROBE)
    beta, rate = ANGLE - run.channel("shaft_1:angle")[-1], -run.channel("shaft_1:speed")[-1]
    stored = MASS * ECCENTRIC * rate * (z * math.cos(beta) - x * math.sin(beta))
    assert abs(stored) > 1e-4
    assert run.energy("unbalance", "dissipated") == pytest.approx(stored, rel=0.02)


def test_a_change_of_speed_pushes_across_the_heavy_spot():
    """From rest, heavy towards +x, the first force is U phi'' along +z: the answer to a step."""
    profile = SpeedProfile(times=np.array([0.0, 1.0]), speeds=np.array([0.0, 100.0]))
    run = whirl(jeffcott(unbalance(angle=0.0), profile=profile), end=0.0127, rate=20e3, step=5e-5)
    static, turned = MASS * ECCENTRIC * 100.0 / STIFFNESS, CRITICAL * run.time[-1]
    step = 1 - math.exp(-DAMPING * turned) * (math.cos(turned) + DAMPING * math.sin(turned))
    assert run.channel("probe:z")[-1] == pytest.approx(static * step, rel=0.05)


def test_its_weight_turns_the_shaft_at_rest():
    run = whirl(jeffcott(unbalance(angle=0.0), gravity=9.81), ("motor_1:torque",), end=0.01)
    # heavy towards +x: it would turn the shaft about +y, the motor holds against it
    assert run.channel("motor_1:torque")[0] == pytest.approx(-MASS * ECCENTRIC * 9.81, rel=1e-4)


def test_seismic_masses_are_no_modes_of_the_machine():
    machine = train(1)
    with_it = dataclasses.replace(machine, forces=(unbalance(y=-0.05), unbalance(name="other", y=0.1)))
    found, without = (
        linear_modes(assemble(m, no_casing(), (), np.inf), up_to=8e3).frequencies for m in (with_it, machine)
    )
    np.testing.assert_allclose(found, without, rtol=1e-4)


def test_it_turns_with_the_gears_when_a_run_starts_elsewhere():
    machine = dataclasses.replace(train(1), forces=(unbalance(shaft="shaft_2", y=0.0),))
    start = assemble(machine.turned(0.5), no_casing(), ()).element("unbalance").values[1]
    assert start == pytest.approx(ANGLE + 0.5 * machine.ratios()["shaft_2"])  # shaft 2 turns about -y


@pytest.mark.parametrize("size", [0.0, -1.0, math.nan])
def test_no_unbalance_is_refused(size):
    with pytest.raises(MachineError, match="size"):
        unbalance(size=size)


def forces_of(**changes):
    return make_machine(load_scene("minimal", changes).scene).parts.forces


def test_unbalance_and_eccentric_disks_of_a_scene_in_si():
    table = {"model": "unbalance", "shaft": 2, "position_mm": 10.0, "unbalance_g_mm": 40.0, "angle_deg": 90.0}
    disk = {
        "shaft": 1, "position_mm": 5.0, "mass_kg": 2.0, "polar_inertia_kg_m2": 0.01, "diametral_inertia_kg_m2": 0.005,
        "eccentricity_um": 20.0, "eccentricity_angle_deg": 180.0,
    }  # fmt: skip
    given, disk_one = forces_of(forces=[table], disks=[disk, disk | {"position_mm": 6.0, "eccentricity_um": 0.0}])
    assert (given.name, given.shaft, given.y, given.size) == ("force_1", "shaft_2", 0.01, pytest.approx(4e-5))
    assert given.angle == pytest.approx(math.pi / 2)
    assert (disk_one.name, disk_one.shaft, disk_one.y) == ("disk_1 eccentricity", "shaft_1", 0.005)
    assert (disk_one.size, disk_one.angle) == (pytest.approx(4e-5), pytest.approx(math.pi))


def test_an_eccentric_disk_without_mass_is_refused():
    disk = {
        "shaft": 1, "position_mm": 5.0, "mass_kg": 0.0, "polar_inertia_kg_m2": 0.01, "diametral_inertia_kg_m2": 0.005,
        "eccentricity_um": 20.0,
    }  # fmt: skip
    with pytest.raises(SceneError, match="eccentricity_um"):
        load_scene("minimal", {"disks": [disk]})
