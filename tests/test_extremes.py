"""Extreme machines: finite with closed books, or refused with a reason."""

import dataclasses

import numpy as np
import pytest
from mbd_rigs import no_casing, rigid_casing, train

from mbd.checks import EquilibriumError, MachineError, StepError
from mbd.drive import SpeedProfile
from mbd.losses import Coulomb, Efficiency
from mbd.simulate import Settings, simulate
from mbd.system import assemble

REFUSALS = (MachineError, EquilibriumError, StepError)
SPEED = 94.2477796


def ramp(factor=1.0):
    return SpeedProfile(
        times=np.array([0.005, 0.02, 0.03, 0.04]), speeds=np.array([0.0, 1.0, 1.0, -1.0]) * SPEED * factor
    )


def runs(machine, casing=None, step=5e-6, end=0.05, parts=0.02):
    """Run it; finite and closed."""
    system = assemble(machine, rigid_casing(machine) if casing is None else casing)
    result = simulate(system, Settings(end=end, output_rate=5e3, step=step))
    assert np.isfinite(result.values).all()
    assert abs(result.book("total", "residual")) <= max(5e-6 * result.book("total", "scale"), 1e-9)
    total = result.book("total", "scale")
    for part in result.book_parts[:-1]:
        limit = max(parts * result.book(part, "scale"), 1e-6 * total, 1e-9)
        assert abs(result.book(part, "residual")) <= limit, part
    return result


def lifted(**options):
    rope = {"container_mass": 300.0} | options.pop("rope", {})
    return train(2, load="rope", profile=options.pop("profile", ramp()), rope=rope, **options)


@pytest.mark.parametrize("factor", [0.0, 10.0])
def test_speed(factor):
    runs(lifted(profile=ramp(factor)), step=2.5e-6 if factor else 5e-6)


def test_no_container_and_no_torque_rattles_in_the_backlash():
    result = runs(train(2, torque=0.0, profile=ramp()))
    assert result.counter("stage_1:contact_losses") + result.counter("stage_1:coast_contacts") > 0


def test_twenty_times_the_container():
    result = runs(lifted(rope={"container_mass": 6000.0}))
    assert result.channel("motor_1:torque").max() > 15 * 300 * 9.81 * 0.05 * 20 / 55 * 21 / 62 / 2


def test_no_damping_at_all():
    machine = lifted(
        rope={"damping_ratio": 0.0}, shaft_tau=0.0, bearing_tau=0.0, coupling_damping=0.0, stage={"tau": 0.0}
    )
    result = runs(machine, no_casing(), step=2.5e-6)
    assert result.book("total", "dissipated") == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e10, 1e12])
def test_bearing_stiffness(stiffness):
    machine = lifted(rope={"container_mass": 50.0})
    bearings = tuple(
        dataclasses.replace(
            b, stiffness_x=stiffness, stiffness_z=stiffness, stiffness_axial=stiffness, damping_time=1e-6
        )
        for b in machine.bearings
    )
    machine = dataclasses.replace(machine, bearings=bearings)
    runs(machine)


@pytest.mark.parametrize("backlash", [0.0, 1e-3])
def test_backlash(backlash):
    runs(lifted(stage={"backlash": backlash}))


def test_a_missing_tooth_on_every_wheel_at_once():
    machine = lifted()
    meshes = []
    for mesh in machine.meshes:
        wheel = np.zeros(mesh.drive.wheel_teeth)
        wheel[2] = np.inf
        meshes.append(dataclasses.replace(mesh, drive_clearance_wheel=wheel, coast_clearance_wheel=wheel))
    runs(dataclasses.replace(machine, meshes=tuple(meshes)))


@pytest.mark.parametrize("length", [0.5, 100.0])
def test_rope_length(length):
    runs(lifted(rope={"length": length}))


def test_winding_more_rope_than_there_is_is_refused():
    machine = lifted(rope={"length": 0.02}, profile=ramp(5.0))
    with pytest.raises(MachineError, match="wound up"):
        runs(machine)


@pytest.mark.parametrize(
    "losses", [Efficiency(mesh_efficiency=0.6), Coulomb(tooth_friction=0.3, bearing_friction=0.05)]
)
def test_large_losses(losses):
    runs(dataclasses.replace(lifted(), losses=losses))


def test_reversal_within_a_sample():
    profile = SpeedProfile(times=np.array([0.0, 0.02, 0.02005]), speeds=np.array([SPEED, SPEED, -SPEED]))
    runs(lifted(profile=profile), step=2.5e-6)
