"""Container: pendulum, ground, and the radial pull of the ropes."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing, pendulum, rigid_casing, train
from scipy.integrate import solve_ivp

from benchmarks.hoist import EA, MASS, RADIUS, hoist
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.channels import bearing_force
from mbd.parts.machine import STANDARD_GRAVITY
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.linearised import linear_modes
from mbd.system.statics import equilibrium
from mbd.system.system import assemble


def swinging(length=5.0, sway=(0.02, 0.0), speed=0.0, follow=True):
    machine = hoist(speed=speed, tau=0.1, damping=0.0, follow=follow)
    load = pendulum(machine.load, rope_length=length, sway_x=sway[0], sway_y=sway[1])
    return dataclasses.replace(machine, load=load)


@pytest.mark.parametrize(("length", "hertz"), [(2.0, 0.352), (3.0, 0.288), (5.0, 0.223), (8.0, 0.176)])
def test_a_container_swings_as_a_pendulum(length, hertz):
    exact = math.sqrt(STANDARD_GRAVITY / length) / (2 * math.pi)
    assert exact == pytest.approx(hertz, abs=6e-4)
    system = assemble(swinging(length, sway=(0.0, 0.0)), no_casing())
    modes = linear_modes(system, up_to=1.0)
    stretched = exact / math.sqrt(1 + MASS * STANDARD_GRAVITY / (8 * EA))  # the rope is longer under the weight
    np.testing.assert_allclose(modes.frequencies[:2], stretched, rtol=1e-5)
    assert modes.dominant[0] == "rope bounce"


@pytest.mark.parametrize("degrees", [1.0, 30.0])
def test_a_swing_from_rest_has_the_period_of_its_angle(degrees):
    """T = 4 sqrt(L/g) K(sin(theta/2)), released from rest; the tension at the lowest point is 3 - 2 cos theta."""
    from scipy.special import ellipk

    angle, length = math.radians(degrees), 2.0
    system = assemble(swinging(length, (angle, 0.0)), no_casing(), ("container:sway_x", "rope:force"))
    run = simulate(system, MotionSettings(end=3.9, output_rate=500.0, step=2e-4))
    sway, t = run.channel("container:sway_x"), run.time
    assert sway[0] == pytest.approx(length * math.sin(angle), rel=2e-3)
    falls = np.flatnonzero((sway[:-1] > 0) & (sway[1:] <= 0))
    period = t[falls[1]] - t[falls[0]]
    expected = 4 * math.sqrt(length / STANDARD_GRAVITY) * ellipk(math.sin(angle / 2) ** 2)
    assert period == pytest.approx(expected, rel=3e-3)
    lowest = run.channel("rope:force")[falls[0]] / (MASS * STANDARD_GRAVITY)
    assert lowest == pytest.approx(3 - 2 * math.cos(angle), abs=0.06 * (1 - math.cos(angle)) + 1e-3)


def test_hoisting_raises_the_sway_angle_as_the_adiabatic_invariant_says():
    """Slow winding: E/omega stays, so the angle grows as L^(-3/4); checked against the varying pendulum."""
    length, speed = 3.0, 0.08  # m/s of the container
    system = assemble(swinging(length, (0.02, 0.0), speed=speed), no_casing(), ("container:sway_x",))
    run = simulate(system, MotionSettings(end=12.0, output_rate=200.0, step=5e-4))
    left = length - speed * np.maximum(run.time - 0.1, 0.0)
    angle = run.channel("container:sway_x") / left
    late = run.time > 9.5
    assert abs(angle[late]).max() / 0.02 == pytest.approx((left[late].mean() / length) ** -0.75, rel=0.05)

    def rate(t, y):
        now = length - speed * max(t - 0.1, 0.0)
        shrink = -speed if t > 0.1 else 0.0
        return [y[1], (-STANDARD_GRAVITY * y[0] - 2 * shrink * y[1]) / now]

    exact = solve_ivp(rate, (0, 12), [0.02, 0.0], t_eval=run.time, rtol=1e-9, atol=1e-12, max_step=0.05).y[0]
    assert abs(angle - exact).max() < 0.03 * 0.02 * (3.0 / 2.0) ** 0.75


def grounded(level, **options):
    machine = hoist(damping=0.05, **options)
    ground = {"ground_level": level, "ground_stiffness": 1e7, "ground_damping_ratio": 0.3}
    load = dataclasses.replace(machine.load, hoist=dataclasses.replace(machine.load.hoist, **ground))
    return dataclasses.replace(machine, load=load)


def test_a_container_is_picked_from_the_ground_and_set_down_again():
    """Slack by 20 mm at the start, lifted, set down: the rope takes up the weight when the slack is wound."""
    slack, speed = 0.02, 0.2
    profile = SpeedProfile(
        times=np.array([0.05, 0.1, 0.5, 0.55, 0.65, 0.7, 1.2, 1.25]),
        speeds=np.array([0.0, 1.0, 1.0, 0.0, 0.0, -1.0, -1.0, 0.0]) * speed * 2 / RADIUS,
    )
    machine = dataclasses.replace(grounded(slack), profile=profile)
    system = assemble(machine, no_casing(), ("rope:force", "container:lift", "motor_1:torque"))
    state = equilibrium(system)
    assert state.motor_torque == pytest.approx(0.0, abs=1e-6)
    weight = MASS * STANDARD_GRAVITY
    run = simulate(system, MotionSettings(end=1.6, output_rate=1000.0, step=5e-5))
    force, lift, t = run.channel("rope:force"), run.channel("container:lift"), run.time
    assert force[t < 0.1].max() < 1e-6 * weight
    assert lift[0] == pytest.approx(slack - weight / 1e7, rel=1e-6)
    taut = 0.075 + slack / speed
    first = t[np.argmax(force > 0.01 * weight)]
    assert first == pytest.approx(taut, abs=5e-3)
    hanging = (t > 0.3) & (t < 0.5)
    assert force[hanging].mean() == pytest.approx(weight, rel=0.1)
    assert force[t > 1.5].max() < 1e-3 * weight
    assert lift[-1] == pytest.approx(slack - weight / 1e7, abs=1e-4)
    for part in ("ground", "rope"):
        assert abs(run.energy(part, "residual")) < 0.01 * run.energy(part, "scale")
    assert abs(run.energy("total", "residual")) < 1e-5 * run.energy("total", "scale")


@pytest.mark.parametrize("load", ["rope", "torque"])
@pytest.mark.parametrize("direction", [0.0, math.pi / 2, 2.0])
def test_the_ropes_pull_the_drum_shaft(load, direction):
    """The bearings of the drum shaft carry the rope force T/r besides, along the ropes; the torque is the same."""
    machine = train(1, load=load, gravity=9.80665)
    if load == "rope":
        changes = {"hoist": dataclasses.replace(machine.load.hoist, rope_direction=direction)}
    else:
        changes = {"direction": direction, "drum_radius": 0.1}
    pulled = dataclasses.replace(machine, load=dataclasses.replace(machine.load, **changes))
    found = []
    for m in (machine, pulled):
        system = assemble(m, rigid_casing(m))
        state = equilibrium(system)
        names = [bearing_force(f"bearing_{k}", a) for k in (3, 4) for a in ("x", "z")]
        rows = [system.channels.names.index(n) for n in names]
        found.append(
            (state.motor_torque, (system.channels.displacement[rows] @ state.displacement).reshape(2, 2).sum(axis=0))
        )
    assert found[1][0] == pytest.approx(found[0][0], rel=1e-7)
    if load == "rope":
        pull = machine.load.hoist.container_mass * machine.gravity / machine.load.hoist.reeving_ratio
    else:
        pull = machine.load.torque * 2 / 0.1
    expected = pull * np.array([math.cos(direction), math.sin(direction)])
    np.testing.assert_allclose(found[1][1] - found[0][1], expected, rtol=1e-5, atol=1e-4 * pull)
