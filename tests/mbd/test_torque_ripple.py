"""Torque ripple goes by the angle of its shaft, at its order, and makes no energy."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing, train
from rotors import jeffcott, line

from mbd.excitations.ripple import TorqueRipple
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.part_checks import MachineError
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.frequency_response import frequency_response
from mbd.system.system import assemble
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene

SPEED = 100.0  # rad/s


def ripple(**changes):
    fields = {"name": "ripple", "shaft": "shaft_1", "y": 0.25, "amplitude": 0.5, "order": 3.0, "angle": 0.7}
    return TorqueRipple(**fields | changes)


def test_a_ripple_makes_the_line_of_its_order_in_size_and_phase():
    """On a rotor that turns evenly the answer is that of a torque A cos(n Omega t + alpha)."""
    machine = jeffcott(ripple(), speed=SPEED)
    system = assemble(machine, no_casing(), ("motor_1:torque", "shaft_1:angle"))
    run = simulate(system, MotionSettings(end=1.0, output_rate=2e3, step=5e-5))
    late = run.time > 0.6
    order = 3.0 * SPEED
    exact = frequency_response(system, "ripple", np.array([order / (2 * math.pi)]))[:, 0] * 0.5 * np.exp(0.7j)
    rolled = run.channel("shaft_1:angle") - SPEED * run.time
    assert abs(line(run.time[late], run.channel("motor_1:torque")[late], order) / exact[0] - 1) < 5e-3
    assert abs(line(run.time[late], rolled[late], order) / exact[1] - 1) < 5e-3


def test_a_ripple_of_a_geared_shaft_goes_by_the_angle_of_that_shaft():
    """On shaft 2 the line is at n times its own frequency, in the mesh force as well."""
    quiet = train(1, speed=SPEED, stage={"ripple": 0.0})
    machine = dataclasses.replace(quiet, forces=(ripple(shaft="shaft_2", y=0.0),))
    settings = MotionSettings(end=0.8, output_rate=2e3, step=2e-5)
    found = []
    for one in (machine, quiet):
        run = simulate(assemble(one, no_casing(), ("stage_1:drive_force",)), settings)
        late = run.time > 0.5
        order = 3.0 * SPEED * machine.ratios()["shaft_2"]
        found.append(abs(line(run.time[late], run.channel("stage_1:drive_force")[late], order)))
    radius = machine.meshes[0].base_radius_driven
    assert found[0] == pytest.approx(0.5 / radius, rel=0.1)  # well below the modes: statically
    assert found[1] < 0.01 * found[0]


def test_a_ripple_goes_by_the_angle_not_by_the_time():
    """Up to speed: the work over whole periods of the angle is nothing, at any speed."""
    profile = SpeedProfile(times=np.array([0.0, 0.3]), speeds=np.array([0.0, 300.0]))
    run = simulate(
        assemble(jeffcott(ripple(), profile=profile), no_casing(), ("shaft_1:angle",)),
        MotionSettings(end=0.4, output_rate=20e3, step=5e-5),
    )
    angle = run.channel("shaft_1:angle")[[0, -1]]
    stored = -0.5 / 3.0 * np.diff(np.sin(3.0 * angle + 0.7))[0]
    assert run.energy("ripple", "stored") == pytest.approx(stored, abs=1e-4)
    assert abs(run.energy("ripple", "dissipated")) < 1e-12
    assert abs(run.energy("ripple", "residual")) < 1e-4 * run.energy("ripple", "scale")


def test_a_ripple_of_a_scene_in_si():
    table = {
        "model": "torque-ripple", "shaft": 2, "position_mm": 10.0,
        "amplitude_N_m": 2.0, "order": 6.0, "phase_deg": 90.0,
    }  # fmt: skip
    (force,) = make_machine(load_scene("minimal", {"forces": [table]}).scene).parts.forces
    assert (force.shaft, force.y, force.amplitude, force.order) == ("shaft_2", 0.01, 2.0, 6.0)
    assert force.angle == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("changes", [{"order": 0.0}, {"amplitude": -1.0}, {"angle": math.inf}])
def test_impossible_ripples_are_refused(changes):
    with pytest.raises(MachineError, match=f"^ripple:? {next(iter(changes))}"):
        ripple(**changes)


def test_a_ripple_of_order_zero_is_named_as_a_constant_torque():
    with pytest.raises(MachineError, match=r"^ripple order: 0 .* The order 0 is a constant torque\.$"):
        ripple(order=0)
