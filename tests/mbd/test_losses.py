"""Losses: torque by efficiency, friction that reverses at the pitch point, drag, brake; all in the energy balance."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import mesh_law, rigid_casing, train

from mbd.forces.sliding import sliding_rows
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.checks import MachineError
from mbd.parts.losses import Brake, Coulomb, Efficiency, NoLosses
from mbd.parts.mesh_reference import sliding_shares
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

SPEED = 94.2477796


def weight_torque(machine):
    load = machine.load
    return load.hoist.container_mass * machine.gravity * load.travel_per_radian * machine.ratios()[load.shaft]


def held(machine, speed):
    return equilibrium(assemble(machine, rigid_casing(machine)), speed)


@pytest.mark.parametrize("stages", [1, 3])
@pytest.mark.parametrize("eta", [1.0, 0.98, 0.9])
def test_every_mesh_passes_on_its_efficiency(stages, eta):
    """Lifting T = W R/(reeving i eta^n), lowering W R eta^n/(reeving i), at rest no loss."""
    machine = dataclasses.replace(train(stages, load="rope"), losses=Efficiency(mesh_efficiency=eta))
    exact = weight_torque(machine)
    assert held(machine, SPEED).motor_torque == pytest.approx(exact / eta**stages, rel=1e-9)
    assert held(machine, -SPEED).motor_torque == pytest.approx(exact * eta**stages, rel=1e-9)
    assert held(machine, 0.0).motor_torque == pytest.approx(exact, rel=1e-9)


def test_tooth_friction_costs_what_the_sliding_says():
    """Power lost over power in = mu sum of shares |xi| (1/r_b1 + 1/r_b2) at the place of the mesh cycle."""
    mu = 0.06
    for cycle in (0.1, 0.45, 0.8):
        machine = train(1, load="rope", stage={"start": cycle})
        machine = dataclasses.replace(machine, losses=Coulomb(tooth_friction=mu, bearing_friction=0.0))
        mesh, none = machine.meshes[0], dataclasses.replace(machine, losses=NoLosses())
        state = held(machine, SPEED)
        arms = sliding_shares(mesh.drive, state.mesh_force[0])[1]
        share = np.interp(cycle * len(arms), np.arange(len(arms) + 1), np.append(arms, arms[0]))
        lost = mu * share * (1 / mesh.base_radius_driving + 1 / mesh.base_radius_driven)
        assert state.motor_torque / held(none, SPEED).motor_torque == pytest.approx(1 + lost, rel=0.03 * lost)
        assert held(machine, -SPEED).motor_torque < held(none, SPEED).motor_torque


def test_the_sliding_force_reverses_at_the_pitch_point():
    """One pair at a time: S jumps from -1 to +1 where its contact passes the pitch point, Q touches 0 there."""
    law = mesh_law(helix=0.0, ripple=0.0)
    signs, arms = sliding_shares(law, 500.0)
    assert signs.min() == pytest.approx(-0.97, abs=0.05)
    assert arms.min() == pytest.approx(0.0, abs=2e-4)
    assert arms.mean() == pytest.approx(law.base_pitch / 3, rel=0.02)  # two hats: mean of (1-x) x and x (1-x) is 1/3


@pytest.mark.parametrize("flank", [1, -1])
def test_sliding_rows_balance_and_do_not_turn_the_pitch_point(flank):
    machine = train(1)
    mesh, a, b = machine.meshes[0], machine.shafts[0], machine.shafts[1]
    rows = sliding_rows(mesh, a, b, flank)
    for k in range(3):
        theta = np.eye(3)[k]
        shift = np.cross(theta, [b.x - a.x, 0.0, b.z - a.z])
        assert abs(rows[0] @ np.tile(np.eye(6)[k], 2)) < 1e-15
        assert abs((rows @ np.concatenate([np.zeros(3), theta, shift, theta]))[0]) < 1e-15
    roll = np.zeros(12)
    roll[4], roll[10] = a.sense, b.sense * mesh.ratio
    np.testing.assert_allclose(rows @ roll, [0.0, 1 + mesh.ratio], atol=1e-15)


def there_and_back(losses, **options):
    profile = SpeedProfile(times=np.array([0.01, 0.04, 0.08, 0.11]), speeds=np.array([0.0, SPEED, SPEED, -SPEED]))
    machine = train(2, load="rope", profile=profile, rope={"container_mass": 300.0}, bearing_tau=1e-5)
    machine = dataclasses.replace(machine, losses=losses, **options)
    system = assemble(machine, rigid_casing(machine), ("motor_1:torque", "motor_2:torque"))
    return machine, simulate(system, MotionSettings(end=0.16, output_rate=5e3, step=1e-5))


@pytest.mark.parametrize(
    "losses", [Efficiency(mesh_efficiency=0.97), Coulomb(tooth_friction=0.08, bearing_friction=0.002)]
)
def test_lowering_differs_from_lifting_and_the_books_hold_what_is_lost(losses):
    machine, run = there_and_back(losses)
    torque = run.channel("motor_1:torque") + run.channel("motor_2:torque")
    up, down = (torque[(run.time > a) & (run.time < b)].mean() for a, b in ((0.045, 0.08), (0.12, 0.16)))
    assert up > 1.02 * down
    assert abs(run.energy("total", "residual")) <= 1e-6 * run.energy("total", "scale")
    parts = [p for p in run.energy_parts if "losses" in p or "drag" in p]
    assert len(parts) == (2 if isinstance(losses, Efficiency) else 8)
    for part in parts:
        assert run.energy(part, "dissipated") > 0.0
        assert abs(run.energy(part, "residual")) <= 1e-5 * run.energy(part, "dissipated")
    if isinstance(losses, Efficiency):
        work = abs(torque[1:] * np.diff(machine.profile.angle(run.time))).sum()
        lost = sum(run.energy(p, "dissipated") for p in parts)
        assert lost == pytest.approx(2 * 0.03 * work, rel=0.1)


def test_the_brake_takes_part_of_a_swing_at_standstill_only():
    _, free = there_and_back(NoLosses())
    _, braked = there_and_back(NoLosses(), brake=Brake(shaft="shaft_1", y=-0.2, torque=40.0))
    assert "brake" in braked.energy_parts
    assert 0.0 < braked.energy("brake", "dissipated") < 1.0
    moving = (free.time > 0.05) & (free.time < 0.075)
    np.testing.assert_allclose(
        braked.channel("motor_1:torque")[moving], free.channel("motor_1:torque")[moving], atol=0.25
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Efficiency(mesh_efficiency=1.1), "at most 1"),
        (lambda: Efficiency(mesh_efficiency=0.3), "above 0.5"),
        (lambda: Coulomb(tooth_friction=-0.1), "tooth_friction"),
        (lambda: Coulomb(tooth_friction=math.inf), "tooth_friction"),
        (lambda: Coulomb(tooth_friction=2.0), "tooth_friction = 2: must be 0 to 0.5"),
    ],
)
def test_impossible_losses_are_refused(make, message):
    with pytest.raises(MachineError, match=message):
        make()
