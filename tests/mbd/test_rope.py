"""Rope load on a single shaft whose motor prescribes the drum: bounce after a ramp, slack, stiffness with length."""

import numpy as np
import pytest
from mbd_rigs import no_casing

from benchmarks.hoist import EA, FALLS, LENGTH, OMEGA, RADIUS, WEIGHT, hoist
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.machine import STANDARD_GRAVITY
from mbd.system.statics import equilibrium
from mbd.system.system import assemble, natural_frequencies


def run(machine, end=0.6, step=5e-5):
    system = assemble(machine, no_casing())
    return simulate(system, MotionSettings(end=end, output_rate=2000.0, step=step))


def test_the_rope_mode_is_in_the_modes():
    found = natural_frequencies(assemble(hoist(), no_casing()))
    assert found[0] == pytest.approx(OMEGA / (2 * np.pi), rel=2e-3)


@pytest.mark.parametrize("tau", [0.03, 0.1])
def test_bounce_during_and_after_a_ramp(tau):
    """F/F_stat = 1 + (dv/(g tau)) (1 - cos wt) in the ramp; then 1 +- (dv w/g) |sinc(w tau/2)|: exact without damping,
    with the rope's length kept and the drum driven by a coupling that does not give way."""
    speed, start = 0.1, 0.05
    result = run(hoist(speed=speed, tau=tau, coupling=1e10))
    force, t = result.channel("rope:force") / WEIGHT, result.time
    inside = (t >= start) & (t <= start + tau)
    ramp = 1 + speed / (STANDARD_GRAVITY * tau) * (1 - np.cos(OMEGA * (t - start)))
    np.testing.assert_allclose(force[inside], ramp[inside], rtol=1e-3)
    half, after = OMEGA * tau / 2, t > start + tau + 0.005  # the output filter smooths the end of the ramp
    swing = speed * OMEGA / STANDARD_GRAVITY * abs(np.sin(half) / half)
    assert force[after].max() == pytest.approx(1 + swing, rel=1e-3)
    assert force[after].min() == pytest.approx(1 - swing, rel=1e-3)


def test_two_per_cent_of_damping_lowers_the_bounce():
    free, damped = (run(hoist(damping=z)).channel("rope:force").max() for z in (0.0, 0.02))
    assert 0.005 < (free - damped) / free < 0.05


@pytest.mark.parametrize(("share", "slack"), [(0.998, False), (1.002, True)])
@pytest.mark.parametrize(("phase", "tau"), [("step", 1e-3), ("after the ramp", 0.03), ("in the ramp", 0.1)])
def test_the_rope_is_slack_when_and_only_when_a_history_of_the_force_reaches_zero(phase, tau, share, slack):
    """Lowered by dv: the least force over the weight is 1 - 2 dv/(g tau) in a ramp longer than half a period, and
    1 - (dv w/g) |sinc(w tau/2)| after it; the first that falls below 0 makes the rope slack."""
    half = OMEGA * tau / 2
    after, within = OMEGA / STANDARD_GRAVITY * abs(np.sin(half) / half), 2 / (STANDARD_GRAVITY * tau)
    assert (phase == "in the ramp") == (half > np.pi / 2 and within > after)
    speed = -share / (within if phase == "in the ramp" else after)
    result = run(hoist(speed=speed, tau=tau, coupling=1e10))
    assert (result.counter("rope:slack_events") > 0) is slack
    assert result.channel("rope:force").min() == pytest.approx(0.0, abs=3e-3 * WEIGHT)


def test_a_slack_container_falls_freely():
    result = run(hoist(speed=-2.0, tau=2e-3), end=0.2, step=1e-5)
    fall = result.channel("container:acceleration")
    assert fall.min() == pytest.approx(-STANDARD_GRAVITY, rel=0.01)  # the filter rings by 0.3 %
    assert abs(result.energy("total", "residual")) < 1e-6 * result.energy("total", "scale")


def test_a_shorter_rope_is_stiffer():
    """Lifting by 2.5 m of 5 m: the container rises relative to the drum's travel by half the static stretch."""
    machine = hoist(speed=5.0, tau=0.4, damping=0.2, follow=True)
    result = run(machine, end=0.75)
    travel = machine.profile.angle(result.time) * RADIUS / 2
    stretch = travel - result.channel("container:lift")
    mean_late = stretch[-400:].mean()
    left = LENGTH - travel[-400:].mean()
    assert stretch[0] == pytest.approx(WEIGHT * LENGTH / (FALLS * EA), rel=2e-2)
    assert mean_late == pytest.approx(WEIGHT * left / (FALLS * EA), rel=0.05)


def test_the_motor_holds_the_weight():
    state = equilibrium(assemble(hoist(), no_casing()))
    assert state.motor_torque == pytest.approx(WEIGHT * RADIUS / 2, rel=1e-9)
