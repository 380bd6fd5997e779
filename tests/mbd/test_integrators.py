"""Time integrators: exactness, order, period error, no drift, agreement, and their contract."""

import dataclasses

import numpy as np
import pytest
from mbd_rigs import no_casing, rigid_casing, train
from scipy.linalg import expm

import benchmarks.reference_integrator  # noqa: F401 - registers it
from benchmarks.checks.motion import spectral_radius
from benchmarks.motion import mesh_mode_frequency
from mbd.integrators import exponential, trapezoidal
from mbd.integrators.base import join
from mbd.integrators.methods import make_integrator
from mbd.integrators.modal import complex_modes
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.checks import StepError
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

FIXED_STEP = ("exponential", "trapezoidal", "generalised-alpha")
RAMP = SpeedProfile(times=np.array([0.0, 1.0]), speeds=np.array([0.0, 600.0]))
LINEAR = {"stage": {"ripple": 0.0, "backlash": 1e-3, "tau": 0.0}}  # the linear reference is exact


def run(system, method, step, end, profile=None):
    """Blocks of a fixed-step run from equilibrium: rows, states."""
    profile = system.machine.profile if profile is None else profile
    integrator = make_integrator(method, system, step)
    integrator.start(equilibrium(system))
    return integrator, integrator.advance(*motor(profile, step, round(end / step)))


def motor(profile, step, n):
    """Angles, speeds and accelerations of n steps."""
    times = step * np.arange(n + 1)
    return profile.angle(times[1:]), profile.speed(times[1:]), np.diff(profile.speed(times)) / step


@pytest.mark.parametrize(("steps", "error"), [(20, 0.817e-2), (40, 0.205e-2), (80, 0.051e-2)])
def test_period_error_of_the_trapezoidal_rule(steps, error):
    z = 2j * np.pi / steps
    growth = trapezoidal.hold(np.array([z]), 1.0).growth
    assert abs(growth[0]) == pytest.approx(1.0, abs=1e-15)
    assert 2 * np.pi / steps / np.angle(growth[0]) - 1 == pytest.approx(error, abs=1e-5)


@pytest.mark.parametrize(("radius", "loss"), [(0.9, 1.135e-9), (0.6, 1.215e-7)])
def test_spectral_radius_of_generalised_alpha(radius, loss):
    assert 1 - spectral_radius(0.01, radius) == pytest.approx(loss, rel=2e-3)


def test_generalised_alpha_reaches_its_radius_at_infinite_frequency():
    assert spectral_radius(1e6, 0.7) == pytest.approx(0.7, abs=1e-4)


@pytest.mark.parametrize("z", [1e-8, -0.3 + 0.1j, 0.499j, 0.501j, -4 + 30j])
def test_exponential_step_under_a_polynomial_force_is_exact(z):
    """eta' = z eta + g over a unit step, g the parabola through 3, 1, -2 at -1, 0, 1 or the line through its ends."""
    z = complex(z)
    for instants, bend in ((exponential.LINEAR, 0.0), (exponential.QUADRATIC, -1.0)):
        hold = exponential.hold(np.array([z]), 1.0, instants)
        slope = -3.0 - 0.5 * bend  # g, g', g'' at the start
        augmented = np.diag([1.0, 1.0, 1.0], 1).astype(complex)
        augmented[0, 0] = z
        exact = (expm(augmented) @ [0.7, 1.0, slope, bend])[0]
        values = np.array([-2.0, 1.0, 3.0])[: len(instants)]
        assert hold.growth[0] * 0.7 + hold.weights[:, 0] @ values == pytest.approx(exact, rel=1e-12)


def test_exponential_run_of_a_linear_machine_is_exact():
    """Constant mesh stiffness, ramp from rest: 1e-10 against one matrix exponential, with 12 steps per mesh period."""
    system = assemble(train(1, profile=RAMP, **LINEAR), no_casing(), band=8e3)
    step = 1 / (12 * mesh_mode_frequency(system))
    integrator, block = run(system, "exponential", step, 300 * step)
    basis, n = system.basis, len(system.frequencies)
    matrix = np.zeros((2 * n + 1, 2 * n + 1))  # (p, p', 1)' with p from equilibrium
    matrix[:n, n : 2 * n] = np.eye(n)
    matrix[n : 2 * n, : 2 * n] = -np.hstack([np.diag(system.frequencies**2), basis.T @ system.damping @ basis])
    matrix[n : 2 * n, -1] = -600.0 * basis.T @ system.mass @ system.rolling
    deviation = basis @ expm(matrix * 300 * step)[:n, -1]
    moved = integrator.displacement @ block.states[-1] - equilibrium(system).displacement
    assert abs(block.forces).max() < 1e-6  # N: the reference is the machine
    np.testing.assert_allclose(moved, deviation, atol=1e-10 * abs(deviation).max())


@pytest.mark.parametrize(
    ("method", "steps", "order"), [("exponential", 50, 3), ("trapezoidal", 400, 2), ("generalised-alpha", 400, 2)]
)
def test_order(method, steps, order):
    """A rope that shortens changes the stiffness smoothly in time: error of the mesh approach against the step."""
    rope = {"rope_length": 0.5, "container_mass": 300.0, "rope_modulus": 5.6e10}
    profile = SpeedProfile(times=np.array([0.0, 1.0]), speeds=np.array([300.0, 900.0]))
    machine = train(1, load="rope", rope=rope, profile=profile, coupling=2e3, **LINEAR)
    system = assemble(machine, no_casing(), band=np.inf)
    end, row = 0.02, 4
    exact = run(system, "exponential", end / 6400, end)[1].rows[-1, row]
    errors = [abs(run(system, method, end / k, end)[1].rows[-1, row] - exact) for k in (steps, 2 * steps)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("method", ["exponential", "trapezoidal"])
def test_undamped_energy_does_not_drift(method):
    machine = train(1, profile=RAMP, shaft_tau=0.0, bearing_tau=0.0, coupling_damping=0.0, **LINEAR)
    system = assemble(machine, no_casing())
    integrator = make_integrator(method, system, 2e-5)
    state = equilibrium(system)
    rest = state.displacement
    kick = dataclasses.replace(state, velocity=system.basis @ np.full(len(system.frequencies), 1e-3))
    integrator.start(kick)
    block = integrator.advance(*np.zeros((3, 50_000)))
    q = block.states[[0, -1]] @ integrator.displacement.T - rest
    v = block.states[[0, -1]] @ integrator.velocity.T
    energy = [0.5 * a @ system.stiffness @ a + 0.5 * b @ system.mass @ b for a, b in zip(q, v, strict=True)]
    assert energy[1] == pytest.approx(energy[0], rel=1e-8)


@pytest.mark.slow
def test_a_million_undamped_steps_do_not_drift():
    machine = train(1, profile=RAMP, shaft_tau=0.0, bearing_tau=0.0, coupling_damping=0.0, **LINEAR)
    system = assemble(machine, no_casing())
    integrator, state = make_integrator("exponential", system, 2e-5), equilibrium(system)
    kick = dataclasses.replace(state, velocity=system.basis @ np.full(len(system.frequencies), 1e-3))
    ends = [integrator.start(kick).states[-1]]
    for _ in range(100):
        ends.append(integrator.advance(*np.zeros((3, 10_000))).states[-1])
    q, v = np.array(ends) @ integrator.displacement.T - state.displacement, np.array(ends) @ integrator.velocity.T
    energy = 0.5 * np.einsum("ti,ij,tj->t", q, system.stiffness, q)
    energy += 0.5 * np.einsum("ti,ij,tj->t", v, system.mass, v)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def nonlinear_system(**options):
    profile = SpeedProfile(times=np.array([0.002, 0.012]), speeds=np.array([0.0, 94.25]))
    machine = train(1, profile=profile, **options)
    return assemble(machine, rigid_casing(machine), ("sensor_1:az", "stage_1:delta", "stage_1:drive_force"))


@pytest.mark.slow
def test_two_independent_integrators_agree():
    system = nonlinear_system()
    a, b = (
        simulate(system, MotionSettings(end=0.03, step=2e-6, integrator=name)).values
        for name in ("exponential", "generalised-alpha")
    )
    spread = np.sqrt(np.mean((a - b) ** 2, axis=1) / np.var(a, axis=1))
    assert spread.max() < 0.01  # generalised-alpha keeps modes above the band and damps them


def test_the_default_agrees_with_the_adaptive_reference():
    machine = train(1, speed=94.25)
    system = assemble(machine, no_casing(), ("stage_1:delta",), band=15e3)
    exact = run(system, "reference", 5e-5, 2e-3)[1].rows[-1]
    fast = run(system, "exponential", 5e-6, 2e-3)[1].rows[-1]
    assert fast[0] == pytest.approx(exact[0], rel=1e-3)


@pytest.mark.parametrize("method", FIXED_STEP)
def test_cutting_a_run_into_blocks_changes_nothing(method):
    system = nonlinear_system()
    steps = motor(system.machine.profile, 1e-5, 600)
    whole, cut = make_integrator(method, system, 1e-5), make_integrator(method, system, 1e-5)
    whole.start(equilibrium(system))
    cut.start(equilibrium(system))
    one = whole.advance(*steps)
    parts = [cut.advance(*(x[a:b] for x in steps)) for a, b in ((0, 7), (7, 300), (300, 600))]
    for name, values in join(parts)._asdict().items():
        np.testing.assert_array_equal(getattr(one, name), values, err_msg=name)


@pytest.mark.parametrize("step", [1e-6, 5e-5])
def test_reversal_in_one_sample_stays_finite(step):
    profile = SpeedProfile(times=np.array([0.01, 0.0101]), speeds=np.array([94.25, -94.25]))
    machine = train(1, profile=profile)
    system = assemble(machine, rigid_casing(machine), ("sensor_1:az", "stage_1:coast_force", "stage_1:drive_force"))
    result = simulate(system, MotionSettings(end=0.03, step=step))
    assert result.counter("stage_1:contact_losses") > 0
    assert result.channel("stage_1:coast_force").max() > 0
    assert np.isfinite(result.values).all()


def test_critically_damped_modes_are_parted_by_a_change_of_the_damping(caplog):
    """The free motion exp(-omega t)(1 + omega t) of critical damping within 1e-6."""
    values, vectors, inverse = complex_modes(np.array([10.0, 30.0]), np.diag([20.0, 1.0]))
    assert "critically damped" in caplog.text
    t, start = 0.15, np.array([1.0, 0.0, 0.0, 0.0])
    weight = np.where(values.imag == 0.0, 1.0, 2.0)
    moved = (vectors * (weight * np.exp(values * t)) @ inverse @ start).real
    assert moved[0] == pytest.approx((1 + 10 * t) * np.exp(-10 * t), abs=1e-6)
    assert abs(moved[1]) < 1e-9


def test_modes_that_no_change_parts_are_refused_with_the_reason(monkeypatch):
    monkeypatch.setattr("mbd.integrators.modal.PERTURBATIONS", (0.0,))
    with pytest.raises(StepError, match="critically damped"):
        complex_modes(np.array([10.0, 30.0]), np.diag([20.0, 1.0]))


def test_wrong_settings_are_refused():
    with pytest.raises(ValueError, match="must be above 0"):
        MotionSettings(end=-1.0)
    with pytest.raises(ValueError, match="shorter than one sample"):
        MotionSettings(end=1e-5)


def test_interruption_leaves_at_a_block():
    class Stop(Exception):
        pass

    def stop(share):
        assert 0 < share < 1
        raise Stop

    with pytest.raises(Stop):
        simulate(nonlinear_system(), MotionSettings(end=0.5), progress=stop)


def test_torsional_shafts_still_shake_the_casing():
    profile = SpeedProfile(times=np.array([0.002, 0.05]), speeds=np.array([0.0, 94.25]))
    machine = train(1, profile=profile, model="torsion")
    system = assemble(machine, rigid_casing(machine), ("sensor_1:az", "stage_1:drive_force"))
    result = simulate(system, MotionSettings(end=0.06))
    assert result.channel("sensor_1:az").std() > 0.1
    assert abs(result.energy("total", "residual")) < 1e-6 * result.energy("total", "scale")
