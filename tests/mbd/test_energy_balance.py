"""Energy balance: every part within 1 % of what it dissipates, the total within 1e-6 of all work."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing, rigid_casing, train

from mbd.elements.element import ENERGY, FROZEN_ENERGY, PARAMETRIC
from mbd.elements.element_table import instant, parametric_work
from mbd.elements.newton import work_between
from mbd.integrators.base import ACCELERATION, LENGTH, SPEED
from mbd.integrators.exponential import exponential
from mbd.integrators.phi_functions import phi_functions
from mbd.integrators.settings import MotionSettings
from mbd.output.element_energy import ElementWork
from mbd.output.exact_integrals import FlowWork
from mbd.output.simulate import simulate
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

RAMP = SpeedProfile(times=np.array([0.01, 0.04]), speeds=np.array([0.0, 94.25]))
JERK = SpeedProfile(times=np.array([0.01, 0.0105]), speeds=np.array([0.0, -94.25]))


def balanced(machine, casing=None, channels=(), end=0.1, **settings):
    casing = rigid_casing(machine, extra=10) if casing is None else casing
    return simulate(assemble(machine, casing, channels), MotionSettings(end=end, **settings))


def assert_closed(result, part_limit=0.01):
    assert abs(result.energy("total", "residual")) <= 1e-6 * result.energy("total", "scale")
    for part in result.energy_parts:
        share = abs(result.energy(part, "residual")) / result.energy(part, "scale")
        assert share <= part_limit, f"{part}: {share:.2%}"


@pytest.mark.parametrize("integrator", ["exponential", "trapezoidal"])
@pytest.mark.parametrize("load", ["torque", "rope"])
def test_energy_balances_close(integrator, load):
    machine = train(1, load=load, profile=RAMP, rope={"container_mass": 300.0})
    result = balanced(machine, integrator=integrator, step=5e-6)
    assert_closed(result)
    assert (result.energies[:-1, result.energy_entries.index("dissipated")] >= 0).all()


def test_energy_balances_close_through_contact_loss_and_impacts():
    result = balanced(train(1, profile=JERK), end=0.06, step=2.5e-6)
    assert result.counter("stage_1:contact_losses") > 0
    assert result.counter("stage_1:coast_contacts") > 0
    assert_closed(result)


def test_a_residual_that_counts_is_said_in_one_sentence():
    """Of all parts together, the worst named with what it is held against."""
    whole = balanced(train(1, profile=RAMP), end=0.03, step=5e-6)
    assert whole.unbalanced() == ()
    changed = whole.energies.copy()
    changed[:3, whole.energy_entries.index("residual")] = 2 * changed[-1, whole.energy_entries.index("scale")]
    (sentence,) = dataclasses.replace(whole, energies=changed).unbalanced()
    assert sentence.startswith("energy balance: ")
    assert f"of {whole.energy_parts[0]} are unaccounted for" in sentence
    assert "2 more" in sentence


@pytest.mark.parametrize("what", ["elastic force", "force"])
def test_a_wrong_force_law_opens_the_balance(monkeypatch, what):
    """A mesh whose logged force (with or without damping) is 10 % off its motion."""
    take = ElementWork.take

    def wrong(self, block):
        elastic, lost = block.elastic.copy(), block.lost.copy()
        elastic[:, :2] *= 0.9
        if what == "force":
            lost[:, :2] *= 0.9
        take(self, block._replace(elastic=elastic, lost=lost))

    monkeypatch.setattr(ElementWork, "take", wrong)
    result = balanced(train(1, profile=RAMP), end=0.1, step=5e-6)
    assert "stage_1" in result.open_parts() or "total" in result.open_parts()


def test_the_audit_finds_an_energy_whose_slope_is_not_the_force():
    """Between two states of a loaded flank: a tenth of the work of its force if the energy is a tenth too small."""
    system = assemble(train(1, profile=RAMP), no_casing())
    state, m = equilibrium(system), len(system.rows)
    before = system.all_rows @ state.displacement
    moved, rates, last, now = before.copy(), np.zeros(m), instant(system.table), instant(system.table)
    moved[0] += 1e-7
    work_between(system.table, 0.0, (0.01, 0.0, 0.0), before, moved, rates, last, now)
    work = 0.5 * (now.frozen[0] + now.elastic[0]) * 1e-7
    assert work > 0.0
    assert abs(now.log[0, PARAMETRIC]) < 1e-5 * work
    now.log[0, [ENERGY, FROZEN_ENERGY]] *= 0.9
    parametric_work(system.table, (0.0, 0.01), before, moved, last, now, 1)
    assert now.log[0, PARAMETRIC] == pytest.approx(-0.1 * work, rel=1e-3)


def test_a_defect_of_the_audit_is_the_residual_of_its_part(monkeypatch):
    take = ElementWork.take

    def wrong(self, block):
        log = block.log.copy()
        log[:, 0, PARAMETRIC] += 1.0  # J in every step
        take(self, block._replace(log=log))

    monkeypatch.setattr(ElementWork, "take", wrong)
    assert "stage_1" in balanced(train(1, profile=RAMP), end=0.02, step=5e-6).open_parts()


@pytest.mark.parametrize("band", [3e3, 6e3, 10e3])
def test_what_a_small_part_leaves_over_is_not_worth_a_word(band):
    """Modes beyond the band are missing from the balance of shaft and casing, which dissipate next to nothing."""
    machine = train(1, profile=RAMP)
    result = simulate(
        assemble(machine, rigid_casing(machine, extra=10), (), band=band), MotionSettings(end=0.03, step=5e-6)
    )
    assert abs(result.energy("shaft_1", "residual")) > 0.01 * result.energy("shaft_1", "scale")
    assert result.unbalanced() == ()


def test_energy_balances_close_without_damping():
    machine = train(1, profile=RAMP, shaft_tau=0.0, bearing_tau=0.0, coupling_damping=0.0)
    machine = dataclasses.replace(machine, meshes=(dataclasses.replace(machine.meshes[0], damping_time=0.0),))
    result = balanced(machine, no_casing(), end=0.05, step=5e-6)
    assert result.energy("total", "dissipated") == pytest.approx(0.0, abs=1e-12)
    assert_closed(result)


def test_the_motor_lifts_the_load():
    """Work of motors and gravity over a lift: their difference is small, each is torque x angle."""
    machine = train(1, profile=RAMP)
    result = balanced(machine, channels=("motor_1:torque", "motor_2:torque"), end=0.1)
    torque = result.channel("motor_1:torque") + result.channel("motor_2:torque")
    angle = machine.profile.angle(result.time)
    motors = np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(angle))
    lifted = 60.0 * machine.ratios()["shaft_2"] * angle[-1]
    assert motors - lifted == pytest.approx(result.energy("total", "received"), rel=0.05, abs=0.02 * lifted)


def test_a_book_sampled_every_few_steps_is_the_same(monkeypatch):
    machine = train(1, profile=RAMP)
    every = balanced(machine, end=0.1, step=5e-6, integrator="trapezoidal")
    monkeypatch.setattr("mbd.output.sampled_integrals.MAX_SAMPLES", 5000)
    some = balanced(machine, end=0.1, step=5e-6, integrator="trapezoidal")
    column = every.energy_entries.index("dissipated")
    np.testing.assert_allclose(some.energies[:, column], every.energies[:, column], rtol=0.02)


def test_a_missing_tooth_runs_and_its_energy_balances():
    machine = train(1, speed=60.0)
    wheel = np.zeros(55)
    wheel[3] = np.inf
    gap = dataclasses.replace(machine.meshes[0], drive_clearance_wheel=wheel, coast_clearance_wheel=wheel)
    result = balanced(dataclasses.replace(machine, meshes=(gap,)), channels=("stage_1:delta",), end=0.05, step=5e-6)
    healthy = balanced(machine, channels=("stage_1:delta",), end=0.05, step=5e-6)
    assert result.channel("stage_1:delta").max() > 1.1 * healthy.channel("stage_1:delta").max()
    assert_closed(result)


def test_integrals_of_the_flow_are_those_of_its_states_within_the_steps():
    """Gauss quadrature of states propagated inside every step, through contact loss, with 3 to 60 rad per step."""
    machine = train(1, profile=JERK)
    system = assemble(machine, rigid_casing(machine, extra=10), ())
    step, n = 5e-5, 200
    integrator = exponential(system, step)
    start = integrator.start(equilibrium(system))
    times = 0.005 + step * np.arange(n + 1)
    speeds, angles = JERK.speed(times), JERK.angle(times)
    rates = np.diff(speeds) / step
    block = integrator.advance(angles[1:], speeds[1:], rates)
    flow = integrator.flow
    work = FlowWork(flow, n)
    work.take(start, 0)
    work.take(block, 1)
    step, rates, ends = block.clock[:, [LENGTH]], block.clock[:, ACCELERATION], block.clock[:, [SPEED]]
    assert len(np.unique(step)) > 2  # cut at the impacts
    assert ((block.elastic[1:, 0] > 0) != (block.elastic[:-1, 0] > 0)).any()
    modes = len(flow.values)
    eta = block.starts
    eta = eta[:, :modes] + 1j * eta[:, modes:]
    pushes = np.einsum("nki,ji->nkj", block.holds, flow.rows)
    pushes[:, 0] += flow.load + np.outer(rates, flow.ramp)
    signal_states, states_states = 0.0, 0.0
    for theta, weight in zip(*np.polynomial.legendre.leggauss(24), strict=True):
        theta, weight = 0.5 * (theta + 1), 0.5 * weight * step
        phi = phi_functions(flow.values * step * theta, 3)
        inside = phi[0] * eta
        for k in range(3):
            inside = inside + step * theta ** (k + 1) * math.factorial(k) * phi[k + 1] * pushes[:, k]
        x = np.hstack([inside.real, inside.imag])
        held = sum(theta**k * block.holds[:, k] for k in range(3))
        signals = np.hstack([held, rates[:, None], np.ones_like(step), ends - (1 - theta) * step * rates[:, None]])
        signal_states, states_states = signal_states + (weight * signals).T @ x, states_states + (weight * x).T @ x
    pushed, second = work.integrals()
    size = np.sqrt(np.diag(states_states))
    assert abs((second - states_states) / np.outer(size, size)).max() < 1e-9
    scale = np.maximum(abs(signal_states).max(axis=1, keepdims=True), 1e-30) * np.ones_like(size)
    np.testing.assert_allclose(pushed / scale, signal_states / scale, atol=1e-10)


def test_an_element_observes_its_own_displacements():
    system = assemble(train(2, profile=RAMP), no_casing())
    displacement = np.random.default_rng(1).standard_normal(system.rows.shape[1])
    observing = [element for element in system.elements if len(element.seen)]
    assert len(observing) > 1
    for element in observing:
        observed = system.observed_by(element.name, system.all_rows @ displacement)
        np.testing.assert_allclose(observed, element.seen @ displacement, rtol=1e-12)
