"""Forces from outside in a scene: a torque over time on a shaft."""

import numpy as np
import pytest

from mbd.forces.torque import Torque
from mbd.parts.part_checks import MachineError
from pipelines.engine.storage import digest
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.steps.machine_steps import machine_steps

TORQUE = {"model": "torque", "shaft": 2, "position_mm": 0.0, "times_s": [0.0, 0.5], "torques_N_m": [0.0, 12.0]}


def scene(**changes):
    return load_scene("minimal", {"forces": [TORQUE | changes]}).scene


def test_a_torque_of_a_scene_in_si():
    force = scene(position_mm=10.0).forces[0].spec(1)
    assert (force.name, force.shaft, force.y) == ("force_1", "shaft_2", 0.01)
    np.testing.assert_array_equal(force.times, [0.0, 0.5])
    np.testing.assert_array_equal(force.torques, [0.0, 12.0])


def test_the_motion_is_computed_anew_for_another_torque():
    plants = [make_machine(scene(torques_N_m=[0.0, value])) for value in (12.0, 13.0)]
    one, other = (digest(machine_steps(machine)[-1].spec) for machine in plants)
    assert one != other


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"torques_N_m": [1.0]}, "times_s has 2 values, torques_N_m has 1"),
        ({"times_s": [0.5, 0.5]}, "must increase strictly"),
        ({"shaft": 7}, "there is no shaft 7"),
        ({"position_mm": 5000.0}, "forces.1.position_mm"),
        ({"model": "thrust"}, "torque"),
    ],
)
def test_impossible_forces_are_refused(changes, message):
    with pytest.raises(SceneError, match=message):
        checked_machine(scene(**changes), "scene")


@pytest.mark.parametrize("times", [(0.5, 0.5), (0.5, 0.2)])
def test_times_of_a_torque_that_do_not_rise_are_refused(times):
    with pytest.raises(MachineError, match=r"must increase strictly\. Spread a jump over at least one sample"):
        Torque(name="push", shaft="shaft_1", y=0.0, times=np.array(times), torques=np.zeros(2))
