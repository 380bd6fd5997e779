"""Shafts, time integrators, rope and equilibrium against exact solutions and published figures."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.linalg import eigh, expm

from benchmarks.checks.record import Check, Subject, Values
from benchmarks.hoist import OMEGA, WEIGHT, hoist
from fem.casing.models.no_casing import NoCasing
from mbd.integrators import exponential, trapezoidal
from mbd.integrators.generalised_alpha import DEFAULT_RADIUS
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.beam import shear_coefficient
from mbd.parts.machine import STANDARD_GRAVITY
from mbd.parts.shafts import Section, ShaftSpec, free_shaft, shaft_nodes
from mbd.system.statics import State, equilibrium
from mbd.system.system import assemble

COWPER = "Cowper (1966), J. Appl. Mech. 33(2), 335-340"
EXUDYN = "Exudyn documentation, recomputed"
LENGTH, DIAMETER = 0.5, 0.05  # m
RISE, RAMP, START = 0.1, 0.1, 0.05  # rope speed at the container (m/s), ramp and start (s)
HALF = OMEGA * RAMP / 2


def _beam(element_length: float) -> tuple[ShaftSpec, np.ndarray, np.ndarray]:
    spec = ShaftSpec(
        name="shaft_1",
        x=0.0,
        z=0.0,
        sense=1,
        sections=(Section(y_start=0.0, y_end=LENGTH, outer_diameter=DIAMETER),),
        element_length=element_length,
    )
    part = free_shaft(spec, shaft_nodes(spec))
    return spec, part.mass, part.stiffness


def _shear(spec: ShaftSpec) -> float:
    """kappa G (Pa)."""
    return shear_coefficient(spec.poisson_ratio, 0.0) * spec.elastic_modulus / (2 * (1 + spec.poisson_ratio))


AREA, SECOND = math.pi * DIAMETER**2 / 4, math.pi * DIAMETER**4 / 64


def _deflection() -> Values:
    """Tip deflection over P L^3/(3 E I) + P L/(kappa G A)."""
    spec, _, stiffness = _beam(LENGTH / 3)
    load = np.zeros(len(stiffness) - 6)
    load[-4] = 1.0
    exact = LENGTH**3 / (3 * spec.elastic_modulus * SECOND) + LENGTH / (_shear(spec) * AREA)
    return [float(np.linalg.solve(stiffness[6:, 6:], load)[-4] / exact)]


def _pinned() -> Values:
    """First three bending frequencies over those of Timoshenko's equation."""
    spec, mass, stiffness = _beam(LENGTH / 40)
    count = len(mass) // 6
    bending = sorted({6 * i + a for i in range(count) for a in (2, 3)} - {2, 6 * (count - 1) + 2})
    at = np.ix_(bending, bending)
    found = np.sqrt(eigh(stiffness[at], mass[at], eigvals_only=True))[:3]
    rho, e, shear = spec.density, spec.elastic_modulus, _shear(spec)
    ratios = []
    for n, omega in enumerate(found, 1):
        k = n * math.pi / LENGTH
        a, b = rho**2 * SECOND / shear, rho * AREA + rho * SECOND * k**2 * (1 + e / shear)
        ratios.append(float(omega / math.sqrt((b - math.sqrt(b * b - 4 * a * e * SECOND * k**4)) / (2 * a))))
    return ratios


def _period_error() -> Values:
    """Percent at 20, 40 and 80 steps per period."""
    growth = [trapezoidal.hold(np.array([2j * np.pi / n]), 1.0).growth[0] for n in (20, 40, 80)]
    return [100 * (2 * math.pi / n / float(np.angle(g)) - 1) for n, g in zip((20, 40, 80), growth, strict=True)]


def _exponential_step() -> Values:
    """Largest relative error of one step under a linear force, over several eigenvalues."""
    worst = 0.0
    for z in (-0.3 + 0.1j, 0.499j, 0.501j, -4 + 30j):
        hold = exponential.hold(np.array([z]), 1.0, exponential.LINEAR)
        exact = (expm(np.array([[z, 1, 0], [0, 0, 1], [0, 0, 0]])) @ [0.7, 1.0, -3.0])[0]
        worst = max(worst, abs((hold.growth[0] * 0.7 + hold.weights[:, 0] @ [-2.0, 1.0]) / exact - 1))
    return [worst]


@cache
def _ramp() -> tuple[np.ndarray, np.ndarray]:
    """Time and rope force over weight of a hoist that its motor ramps up."""
    machine = hoist(speed=RISE, tau=RAMP, start=START)
    system = assemble(
        machine, NoCasing().reduce(bearings={b.name: (0.0, b.y, 0.0) for b in machine.bearings}), ("rope:force",)
    )
    result = simulate(system, MotionSettings(end=0.5, output_rate=2000.0, step=5e-5))
    return result.time, result.channel("rope:force") / WEIGHT


def _ramp_history() -> Values:
    """Largest deviation from 1 + (dv/(g tau)) (1 - cos omega t) within the ramp."""
    time, force = _ramp()
    inside = (time > START) & (time < START + RAMP)
    exact = 1 + RISE / (STANDARD_GRAVITY * RAMP) * (1 - np.cos(OMEGA * (time[inside] - START)))
    return [float(np.abs(force[inside] / exact - 1).max())]


def _largest_force() -> Values:
    time, force = _ramp()
    return [float(force[time > START + RAMP + 0.01].max())]


@cache
def _rig_at_rest() -> tuple[State, float, float]:
    """Equilibrium of the rig with iso laws and without casing; exact motor torque (N m) and mesh force (N)."""
    from benchmarks.rig import casing_body, read, stage_law, system

    iso = {f"stages__{n}__mesh__model": "iso" for n in (1, 2, 3)}
    model = read(casing__model="none", sensors=[], **iso)
    laws = [stage_law(model, n) for n in range(3)]
    state = equilibrium(system(model, laws, casing_body(model)))
    torque = 1000 * STANDARD_GRAVITY * 0.1 / 2 / (55 / 20 * 62 / 21 * 65 / 22)
    return state, torque, torque / model.layout.pairs[0].pinion.base_radius


def _at_rest() -> Values:
    state, torque, force = _rig_at_rest()
    return [float(state.motor_torque / torque), float(state.mesh_force[0] / force)]


SUBJECTS = (
    Subject("Shafts", (
        Check("shear coefficient κ of a full circle and a thin tube (inner over outer diameter 0.9999), ν 0.3", COWPER,
              "", (6 * 1.3 / (7 + 6 * 0.3), 2 * 1.3 / (4 + 3 * 0.3)), 1e-4,
              lambda: [shear_coefficient(0.3, 0.0), shear_coefficient(0.3, 0.9999)],
              "test_shafts.py::test_cantilever_is_exact_under_end_loads"),
        Check("tip deflection of a cantilever divided by P L³/(3 E I) + P L/(κ G A), 3 elements", "exact", "", (1.0,),
              1e-9, _deflection, "test_shafts.py::test_cantilever_is_exact_under_end_loads"),
        Check("frequencies 1 to 3 of a pinned beam divided by those of Timoshenko's theory, d/L 0.1, 40 elements",
              "exact", "", (1.0, 1.0, 1.0), 5e-4, _pinned,
              "test_shafts.py::test_pinned_beam_has_the_frequencies_of_timoshenko_theory"),
    )),
    Subject("Time integration", (
        Check("period error of the trapezoidal rule at steps of T/20, T/40, T/80", EXUDYN, "%", (0.817, 0.205, 0.051),
              1e-3, _period_error, "test_integrators.py::test_period_error_of_the_trapezoidal_rule", "absolute"),
        Check("1 - spectral radius of generalised-alpha at steps of T/100, ρ∞ 0.9 and 0.6", EXUDYN, "",
              (1.135e-9, 1.215e-7), 2e-3, lambda: [1 - spectral_radius(0.01, 0.9), 1 - spectral_radius(0.01, 0.6)],
              "test_integrators.py::test_spectral_radius_of_generalised_alpha"),
        Check("relative error of an exponential step, force linear in time", "exact", "", (0.0,), 1e-12,
              _exponential_step,
              "test_integrators.py::test_exponential_step_under_a_polynomial_force_is_exact", "absolute"),
    )),
    Subject("Load and equilibrium", (
        Check("rope force during a speed ramp, F/F_stat = 1 + (Δv/(g τ)) (1 - cos ωt), largest relative error",
              "exact for no damping, fixed length and prescribed drum speed", "", (0.0,), 1e-2, _ramp_history,
              "test_rope.py::test_bounce_during_and_after_a_ramp", "absolute"),
        Check("largest rope force after the ramp, F/F_stat = 1 + (Δv ω/g) |sin(ωτ/2)/(ωτ/2)|",
              "exact under the same conditions", "",
              (1 + RISE * OMEGA / STANDARD_GRAVITY * abs(math.sin(HALF) / HALF),), 1e-2, _largest_force,
              "test_rope.py::test_bounce_during_and_after_a_ramp"),
        Check("rig at rest: motor torque / (m g R/(reeving · ratio)), mesh force of stage 1 / (T₁/r_b1)", "exact", "",
              (1.0, 1.0), 1e-6, _at_rest,
              "test_statics.py::test_motor_torque_is_weight_times_drum_radius_over_the_ratios"),
    )),
)  # fmt: skip


def spectral_radius(step_over_period: float, radius: float = DEFAULT_RADIUS) -> float:
    """Largest eigenvalue modulus of one step of the undamped oscillator, h/T = ``step_over_period``."""
    x = (2 * np.pi * step_over_period) ** 2  # (omega h)^2; unknowns (q, h v, h^2 A)
    am, af = (2 * radius - 1) / (radius + 1), radius / (radius + 1)
    gamma, beta = 0.5 - am + af, 0.25 * (1 + af - am) ** 2
    new = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1 - af) * x, 0.0, 1 - am]])
    old = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1 - gamma], [-af * x, 0.0, -am]])
    return float(abs(np.linalg.eigvals(np.linalg.solve(new, old))).max())
