"""Machines that torques drive: their rolling is part of the answer. Starts, load sharing, work, control, statics."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mbd_rigs import no_casing, train
from scipy.integrate import solve_ivp

from benchmarks.reference_integrator import ReferenceSettings
from mbd.forces.induction_motor import InductionMotor
from mbd.forces.speed_controller import SpeedController, controller_rule
from mbd.forces.torque import SpeedTorque, Torque
from mbd.forces.torque_source import Rotor
from mbd.output.simulate import simulate
from mbd.parts.checks import MachineError
from mbd.parts.mesh_reference import nominal_forces
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

RATIO = 20 / 55
ROTOR = Rotor(inertia=2e-3, stiffness=2e4, damping=0.5)
CHANNELS = ("stage_1:drive_force", "stage_1:coast_force")


def constant(name, shaft, torque, y=0.2, **options):
    return Torque(name=name, shaft=shaft, y=y, times=np.zeros(1), torques=np.array([torque]), **options)


def motor(name="motor_1", y=-0.2, **options):
    values = {"synchronous_speed": 157.08, "rated_speed": 152.16, "rated_torque": 24.0, "rotor": ROTOR}
    return InductionMotor(name=name, shaft="shaft_1", y=y, drives=True, **(values | options))


BRAKE = SpeedTorque(
    name="brake", shaft="shaft_2", y=0.2, speeds=np.array([-10.0, 0.0, 100.0]), torques=np.array([0.0, 0.0, -60.0])
)


def free(*forces, start=100.0, **options):
    """One stage, nothing but torques on it, both shafts rigid but in torsion."""
    machine = train(1, model="torsion", speed=start, **options)
    return replace(machine, couplings=(), input_shaft="shaft_1", load=None, forces=forces)


def assembled(machine, *names, **options):
    sources = [f"{force.name}:{what}" for force in machine.forces for what in ("angle", "speed", "torque")]
    return assemble(machine, no_casing(), (*CHANNELS, *sources, *names), **options)


def run(system, end, step=2e-5, method="exponential", rate=10e3):
    return simulate(system, ReferenceSettings(end=end, output_rate=rate, step=step, integrator=method))


def inertia(system):
    return float(system.rolling @ system.mass @ system.rolling)


def test_a_train_without_torque_keeps_its_speed_for_ever():
    system = assembled(free(constant("load", "shaft_2", 0.0)))
    speed = run(system, 0.1).channel("load:speed")
    np.testing.assert_allclose(speed, 100.0 * RATIO, rtol=1e-9)


def test_a_constant_torque_speeds_up_the_train_as_one_body():
    """With a mesh of constant stiffness nothing vibrates: speed and angle are those of a rigid body from the start."""
    forces = constant("motor_1", "shaft_1", 9.0, y=-0.2, drives=True), constant("load", "shaft_2", -11.0)
    system = assembled(free(*forces, stage={"ripple": 0.0}))
    found = run(system, 0.2)
    rate, time = (9.0 - RATIO * 11.0) / inertia(system), found.time
    np.testing.assert_allclose(found.channel("motor_1:speed"), 100.0 + rate * time, rtol=1e-6)
    angle = time * (100.0 + 0.5 * rate * time)
    np.testing.assert_allclose(np.diff(found.channel("motor_1:angle")), np.diff(angle), rtol=1e-5)


def test_running_equilibrium_at_the_start_shakes_nothing():
    """Motor and load in balance: the mesh force hangs at its static value, by hand T1/r_b1."""
    machine = free(
        constant("motor_1", "shaft_1", 10.0, y=-0.2, drives=True), constant("load", "shaft_2", -10.0 / RATIO)
    )
    system = assembled(machine, "motor_1:torque")
    state = equilibrium(system, 100.0)
    by_hand = 10.0 / machine.meshes[0].base_radius_driving
    assert state.mesh_force[0] == pytest.approx(by_hand, rel=1e-6)
    assert nominal_forces(machine)["stage_1"] == pytest.approx(by_hand, rel=1e-12)


def test_what_is_left_over_is_taken_by_the_inertia_on_the_way():
    """T1 drives alone: the mesh carries what the second shaft's inertia asks for."""
    machine = free(constant("motor_1", "shaft_1", 10.0, y=-0.2, drives=True))
    system = assembled(machine)
    far = system.layout.index("shaft_2")
    share = float(system.rolling[far] @ system.mass[np.ix_(far, far)] @ system.rolling[far]) / inertia(system)
    state = equilibrium(system, 100.0)
    assert state.mesh_force[0] == pytest.approx(10.0 * share / machine.meshes[0].base_radius_driving, rel=1e-6)


@pytest.fixture(scope="module")
def started():
    """An induction motor starts from standstill under the brake."""
    system = assembled(free(motor(), BRAKE, start=0.0), "motor_1:coupling_torque")
    return system, run(system, 0.5)


def test_the_start_of_an_induction_motor_follows_the_rigid_train(started):
    """Kloss' formula and the brake on one inertia, integrated by SciPy; the flexible train swings about it."""
    system, found = started
    total = inertia(system)

    def rate(_, y):
        slip = (157.08 - y[1]) / 157.08 / 0.15
        return [y[1], (2 * 60.0 * slip / (1 + slip**2) - RATIO * 60.0 * RATIO * y[1] / 100.0) / total]

    exact = solve_ivp(rate, (0.0, 0.5), [0.0, 0.0], t_eval=found.time, rtol=1e-10, atol=1e-12)
    angle, speed = found.channel("motor_1:angle"), found.channel("motor_1:speed")
    assert np.max(abs(angle - exact.y[0])) < 1e-3 * exact.y[0, -1]
    settled = found.time > 0.3
    np.testing.assert_allclose(speed[settled], exact.y[1][settled], rtol=1e-3)


def test_work_in_is_work_out_and_what_turns(started):
    """Work of motor and brake from their channels against the balance, and the total to 1e-6 of what is turned over."""
    system, found = started
    for name in ("motor_1", "brake"):
        torque, angle = found.channel(f"{name}:torque"), found.channel(f"{name}:angle")
        beyond = found.counter("steps") * found.step - found.time[-1]  # the run goes on for half the filter
        work = float(np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(angle)))
        work += torque[-1] * found.channel(f"{name}:speed")[-1] * beyond
        assert -found.energy(name, "dissipated") == pytest.approx(work, rel=5e-4)
    speed = found.channel("motor_1:speed")[-1]
    stored = found.energy("total", "stored")
    assert stored == pytest.approx(0.5 * inertia(system) * speed**2, rel=1e-3)
    assert abs(found.energy("total", "residual")) < 1e-6 * found.energy("total", "scale")
    assert found.open_parts() == ()


@pytest.mark.parametrize(("method", "step"), [("trapezoidal", 5e-6), ("generalised-alpha", 5e-6)])
def test_other_methods_find_the_same_start(method, step):
    """Generalised-alpha keeps the rolling as a remainder in a frame of constant speed: another derivation."""
    system = assembled(free(motor(), BRAKE, start=100.0))
    one, other = run(system, 0.03), run(system, 0.03, step, method)
    filtered = one.time > 2e-3  # before, the filter of the remainder takes the rest before t = 0 for a constant speed
    for what, limit in (("angle", 1e-6), ("speed", 2e-6), ("torque", 1e-3)):
        np.testing.assert_allclose(
            one.channel(f"motor_1:{what}")[filtered], other.channel(f"motor_1:{what}")[filtered], rtol=limit, atol=1e-6
        )


@pytest.mark.slow
def test_the_adaptive_reference_agrees_on_force_and_speed():
    system = assembled(free(motor(), BRAKE, start=100.0))
    one, exact = run(system, 0.006, 5e-6, rate=100e3), run(system, 0.006, 1e-5, "reference", rate=100e3)
    force = exact.channel("stage_1:drive_force")
    assert np.sqrt(np.mean((one.channel("stage_1:drive_force") - force) ** 2)) < 5e-3 * np.std(force)
    np.testing.assert_allclose(one.channel("motor_1:speed"), exact.channel("motor_1:speed"), rtol=1e-6)


def test_two_motors_share_the_load_by_their_slip():
    """Steady: T1/T2 = slope1/slope2 where both run near their synchronous speed; together they balance the load."""
    weak = motor("motor_2", y=0.2, rated_torque=12.0)
    load = constant("load", "shaft_2", -12.0 / RATIO, y=0.0)
    found = run(assembled(free(motor(), weak, load, start=155.0)), 0.8)
    late = found.time > 0.7
    strong, little = (found.channel(f"motor_{k}:torque")[late].mean() for k in (1, 2))
    assert strong / little == pytest.approx(2.0, rel=1e-3)
    assert strong + little == pytest.approx(12.0, rel=1e-3)


def test_a_speed_controller_reaches_its_speed_and_holds_it_against_the_load():
    profile = {"times": np.array([0.0, 0.1, 0.2]), "speeds": np.array([80.0, 80.0, 100.0])}
    control = SpeedController(
        name="motor_1", shaft="shaft_1", y=-0.2, drives=True, rotor=ROTOR, **profile, proportional=2.0,
        integral=40.0, limit=60.0, starting_torque=8.0,
    )  # fmt: skip
    found = run(assembled(free(control, constant("load", "shaft_2", -8.0 / RATIO), start=80.0)), 0.8)
    late = found.time > 0.7
    np.testing.assert_allclose(found.channel("motor_1:speed")[late], 100.0, rtol=1e-3)
    assert found.channel("motor_1:torque")[late].mean() == pytest.approx(8.0, rel=1e-2)
    early = found.time < 0.05
    np.testing.assert_allclose(found.channel("motor_1:speed")[early], 80.0, rtol=2e-3)


STEP = {"proportional": 6.0, "integral": 40.0, "limit": 20.0, "starting_torque": 8.0}


def stepped(end=1.5, **options):
    """A controller asks for 110 rad/s from 100 on against 8 N m, with 20 N m at most: speed over time, and inertia."""
    profile = {"times": np.array([0.0, 1.0]), "speeds": np.array([110.0, 110.0])}
    control = SpeedController(
        name="motor_1", shaft="shaft_1", y=-0.2, drives=True, rotor=Rotor(inertia=0.3), **profile,
        **(STEP | options),
    )  # fmt: skip
    machine = free(control, constant("load", "shaft_2", -8.0 / RATIO), start=100.0, stage={"ripple": 0.0})
    system = assembled(machine)
    found = run(system, end)
    return found.time, found.channel("motor_1:speed"), inertia(system)


def integrated(time, total, anti_windup):
    """The same controller on one inertia by SciPy: angle, speed, and the integral of its equations in textbook form."""
    kp, ki, limit, start = STEP.values()

    def rate(_, y):
        asked = kp * (110.0 - y[0]) + y[1]
        torque = np.clip(asked, -limit, limit)
        back = (torque - asked) / (kp / ki) if anti_windup else 0.0
        return [(torque - 8.0) / total, ki * (110.0 - y[0]) + back]

    exact = solve_ivp(rate, (0.0, time[-1]), [100.0, start], t_eval=time, rtol=1e-10, atol=1e-12, max_step=1e-3)
    return exact.y[0]


def overshoot(speed):
    return float((speed.max() - 110.0) / 10.0)


@pytest.mark.parametrize("anti_windup", [True, False])
def test_a_limited_controller_follows_the_integration_of_its_equations(anti_windup):
    """Largest and settled speed within 0.1 %, and 0.1 % of the step all along; SciPy integrates the textbook's form.

    The torque is at its limit for the first 0.2 s. Overshoot of the step: 11 % with back-calculation, 53 % without.
    """
    time, speed, total = stepped(anti_windup=anti_windup)
    exact = integrated(time, total, anti_windup)
    assert speed.max() == pytest.approx(exact.max(), rel=1e-3)
    assert speed[-1] == pytest.approx(exact[-1], rel=1e-3)
    assert overshoot(speed) == pytest.approx(0.113 if anti_windup else 0.534, abs=1e-3)
    settled = time > 2e-3  # the filter of the recording
    assert abs(speed - exact)[settled].max() < 1e-3 * 10.0


def test_what_keeps_the_integral_from_winding_up_takes_no_energy():
    profile = {"times": np.array([0.0, 1.0]), "speeds": np.array([110.0, 110.0])}
    control = SpeedController(
        name="motor_1", shaft="shaft_1", y=-0.2, drives=True, rotor=ROTOR, **profile, **STEP
    )  # fmt: skip
    found = run(assembled(free(control, constant("load", "shaft_2", -8.0 / RATIO), start=100.0)), 0.1)
    assert found.energy("motor_1 anti-windup", "dissipated") < 1e-6 * -found.energy("motor_1", "dissipated")
    assert abs(found.energy("total", "residual")) < 1e-6 * found.energy("total", "scale")


def test_below_its_limit_a_controller_answers_both_errors_of_the_shaft_and_its_slopes_are_its_gains():
    """After 0.2 s at 5 rad/s; the shaft turns by the motor's angle over the ratio, and by what bends between."""
    ratio, kp, ki, start = 0.5, 3.0, 40.0, 0.7
    motion = SimpleNamespace(time=0.2, u=[0.1], v=[0.4], angle=1.5, speed=9.0)
    answer = SimpleNamespace(lost=np.zeros(1), lost_by_u=np.zeros((1, 1)), lost_by_v=np.zeros((1, 1)))
    controller_rule.function(np.array([ratio, kp, ki, 1e3, start, 0.0, 5.0, 0.0]), motion, answer)
    by_hand = kp * (5.0 - 0.4 - 0.5 * 9.0) + ki * (5.0 * 0.2 - 0.1 - 0.5 * 1.5) + start
    assert -answer.lost[0] == pytest.approx(by_hand)
    assert (answer.lost_by_u[0, 0], answer.lost_by_v[0, 0]) == (ki, kp)


def test_a_controller_gives_no_more_than_its_limit():
    profile = {"times": np.array([0.0, 1.0]), "speeds": np.array([150.0, 150.0])}
    control = SpeedController(
        name="motor_1",
        shaft="shaft_1",
        y=-0.2,
        drives=True,
        **profile,
        proportional=50.0,
        integral=0.0,
        limit=5.0,
    )
    found = run(assembled(free(control, start=100.0)), 0.05)
    np.testing.assert_allclose(found.channel("motor_1:torque"), 5.0, rtol=1e-9)


def test_a_motor_that_winds_up_the_rope_is_stopped_with_the_time():
    machine = train(1, load="rope", rope={"rope_length": 0.3, "container_mass": 50.0}, model="torsion", speed=100.0)
    machine = replace(machine, couplings=(), input_shaft="shaft_1", forces=(motor(),))
    with pytest.raises(MachineError, match=r"0.3 m are wound up at t = 0\.1"):
        run(assembled(machine), 1.0)


def test_breakdown_slip_gives_the_rated_torque_at_the_rated_slip():
    rated = motor(rated_speed=0.96 * 157.08, rated_torque=20.0)
    assert rated.at_start(0.96 * 157.08) == pytest.approx(20.0, rel=1e-12)


def test_a_smooth_profile_goes_through_its_samples_and_does_not_step_the_acceleration():
    times = np.array([0.0, 0.1, 0.25, 0.4, 0.9])
    speeds = np.array([0.0, 40.0, 60.0, 61.0, 20.0])
    line, smooth = (SpeedProfile(times=times, speeds=speeds, smooth=way) for way in (False, True))
    np.testing.assert_allclose(smooth.speed(times), speeds, atol=1e-12)
    fine = np.linspace(0.0, 0.9, 90_001)
    steps = [np.abs(np.diff(np.gradient(profile.speed(fine), fine))).max() for profile in (line, smooth)]
    assert steps[1] < 1e-3 * steps[0]
    numeric = np.concatenate(
        [[0.0], np.cumsum(0.5 * (smooth.speed(fine)[1:] + smooth.speed(fine)[:-1]) * np.diff(fine))]
    )
    np.testing.assert_allclose(smooth.angle(fine), numeric, atol=1e-7)
    np.testing.assert_allclose(smooth.angle(np.array([1.1])) - smooth.angle(np.array([0.9])), 0.2 * 20.0, rtol=1e-12)
