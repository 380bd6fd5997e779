"""Shafts, time integrators, rope and equilibrium against exact solutions and published figures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache

import numpy as np
from scipy.linalg import eigh, expm

from benchmarks.checks.record import Check, Values
from fem.casing.reduced.body import ReducedBody
from mbd.forces.rope import Rope
from mbd.integrators import exponential, trapezoidal
from mbd.integrators.generalised_alpha import spectral_radius
from mbd.parts.beam import shear_coefficient
from mbd.parts.bearings import BearingSpec
from mbd.parts.drive import CouplingSpec, SpeedProfile
from mbd.parts.machine import STANDARD_GRAVITY, Machine
from mbd.parts.shafts import Disk, Section, ShaftSpec, free_shaft, shaft_nodes
from mbd.simulate import Settings, simulate
from mbd.system.statics import State, equilibrium
from mbd.system.system import assemble

SHAFTS, TIME, LOAD = "Shafts", "Time integration", "Load and equilibrium"
EXUDYN = "Exudyn documentation, recomputed"
LENGTH, DIAMETER = 0.5, 0.05  # m
MASS, RADIUS, ROPE, EA, FALLS = 1000.0, 0.1, 5.0, 3.57e6, 8
OMEGA = math.sqrt(FALLS * EA / ROPE / MASS)  # rad/s
RISE, RAMP, START = 0.1, 0.1, 0.05  # rope speed at the container (m/s), ramp and start (s)


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
def _hoist() -> tuple[np.ndarray, np.ndarray]:
    """Time and rope force over weight of a drum that a motor ramps up; no damping, fixed length, drum prescribed."""
    shaft = ShaftSpec(
        name="shaft_1",
        x=0.0,
        z=0.0,
        sense=1,
        sections=(Section(y_start=-0.2, y_end=0.2, outer_diameter=0.1),),
        disks=(Disk(name="drum", y=0.0, mass=20.0, polar_inertia=0.1, diametral_inertia=0.1),),
    )
    bearings = tuple(
        BearingSpec(name=f"bearing_{i}", shaft="shaft_1", y=y, stiffness_x=1e9, stiffness_z=1e9, stiffness_axial=1e8)
        for i, y in ((1, -0.15), (2, 0.15))
    )
    load = Rope(
        shaft="shaft_1",
        drums=(-0.02, 0.02),
        container_mass=MASS,
        drum_radius=RADIUS,
        falls=FALLS,
        axial_stiffness=EA,
        length=ROPE,
        damping_ratio=0.0,
        follow_length=False,
    )
    machine = Machine(
        shafts=(shaft,),
        bearings=bearings,
        meshes=(),
        couplings=(CouplingSpec(name="motor_1", shaft="shaft_1", y=0.0, stiffness=5e7),),
        profile=SpeedProfile(times=np.array([START, START + RAMP]), speeds=np.array([0.0, RISE * 2 / RADIUS])),
        load=load,
    )
    system = assemble(machine, _no_casing(machine), ("rope:force",))
    result = simulate(system, Settings(end=0.5, output_rate=2000.0, step=5e-5))
    return result.time, result.channel("rope:force") / (MASS * STANDARD_GRAVITY)


def _no_casing(machine: Machine) -> ReducedBody:
    from fem.casing.models.no_casing import NoCasing

    return NoCasing().reduce({b.name: (0.0, b.y, 0.0) for b in machine.bearings})


def _ramp_history() -> Values:
    """Largest deviation from 1 + (dv/(g tau)) (1 - cos omega t) within the ramp."""
    time, force = _hoist()
    inside = (time > START) & (time < START + RAMP)
    exact = 1 + RISE / (STANDARD_GRAVITY * RAMP) * (1 - np.cos(OMEGA * (time[inside] - START)))
    return [float(np.abs(force[inside] / exact - 1).max())]


@cache
def _rig_at_rest() -> tuple[State, float, float]:
    """Equilibrium of the rig with iso laws and without casing; exact motor torque (N m) and mesh force (N)."""
    from benchmarks.rig import casing_body, read, stage_law, system

    iso = {f"stages__{n}__mesh__model": "iso" for n in (1, 2, 3)}
    plant = read(casing__model="none", sensors=[], **iso)
    laws = [stage_law(plant, n) for n in range(3)]
    state = equilibrium(system(plant, laws, casing_body(plant)))
    torque = 1000 * STANDARD_GRAVITY * 0.1 / 2 / (55 / 20 * 62 / 21 * 65 / 22)
    return state, torque, torque / plant.layout.pairs[0].pinion.base_radius


def _at_rest() -> Values:
    state, torque, force = _rig_at_rest()
    return [float(state.motor_torque / torque), float(state.mesh_force[0] / force)]


def checks() -> Iterator[Check]:
    """All rows of this subject."""
    yield Check(
        subject=SHAFTS,
        quantity="shear coefficient κ of the full circle and of a thin tube (m = 0.9999), ν 0.3",
        source="Cowper (1966), J. Appl. Mech. 33(2), 335-340",
        unit="",
        reference=(6 * 1.3 / (7 + 6 * 0.3), 2 * 1.3 / (4 + 3 * 0.3)),
        gate=1e-4,
        compute=lambda: [shear_coefficient(0.3, 0.0), shear_coefficient(0.3, 0.9999)],
        test="test_shafts.py::test_cantilever_is_exact_under_end_loads",
    )
    yield Check(
        subject=SHAFTS,
        quantity="tip deflection of a cantilever over P L³/(3 E I) + P L/(κ G A), 3 elements",
        source="exact",
        unit="",
        reference=(1.0,),
        gate=1e-9,
        compute=_deflection,
        test="test_shafts.py::test_cantilever_is_exact_under_end_loads",
    )
    yield Check(
        subject=SHAFTS,
        quantity="pinned beam d/L 0.1, modes 1 to 3 over Timoshenko's frequency equation, 40 elements",
        source="exact",
        unit="",
        reference=(1.0, 1.0, 1.0),
        gate=5e-4,
        compute=_pinned,
        test="test_shafts.py::test_pinned_beam_has_the_frequencies_of_timoshenko_theory",
    )
    yield Check(
        subject=TIME,
        quantity="period error of the trapezoidal rule at T/20, T/40, T/80",
        source=EXUDYN,
        unit="%",
        reference=(0.817, 0.205, 0.051),
        gate=1e-3,
        kind="absolute",
        compute=_period_error,
        test="test_integrators.py::test_period_error_of_the_trapezoidal_rule",
    )
    yield Check(
        subject=TIME,
        quantity="1 - spectral radius of generalised-alpha at h/T = 0.01, ρ∞ 0.9 and 0.6",
        source=EXUDYN,
        unit="",
        reference=(1.135e-9, 1.215e-7),
        gate=2e-3,
        compute=lambda: [1 - spectral_radius(0.01, 0.9), 1 - spectral_radius(0.01, 0.6)],
        test="test_integrators.py::test_spectral_radius_of_generalised_alpha",
    )
    yield Check(
        subject=TIME,
        quantity="exponential step under a linear force, relative error",
        source="exact",
        unit="",
        reference=(0.0,),
        gate=1e-12,
        kind="absolute",
        compute=_exponential_step,
        test="test_integrators.py::test_exponential_step_under_a_polynomial_force_is_exact",
    )
    yield Check(
        subject=LOAD,
        quantity="rope force during a speed ramp, F/F_stat = 1 + (Δv/(g τ)) (1 - cos ωt), largest relative error",
        source="exact for no damping, fixed length and a prescribed drum",
        unit="",
        reference=(0.0,),
        gate=1e-2,
        kind="absolute",
        compute=_ramp_history,
        test="test_rope.py::test_bounce_during_and_after_a_ramp",
    )
    half = OMEGA * RAMP / 2
    yield Check(
        subject=LOAD,
        quantity="largest rope force after the ramp, F/F_stat = 1 + (Δv ω/g) |sin(ωτ/2)/(ωτ/2)|",
        source="exact under the same conditions",
        unit="",
        reference=(1 + RISE * OMEGA / STANDARD_GRAVITY * abs(math.sin(half) / half),),
        gate=1e-2,
        compute=lambda: [float(_hoist()[1][_hoist()[0] > START + RAMP + 0.01].max())],
        test="test_rope.py::test_bounce_during_and_after_a_ramp",
    )
    yield Check(
        subject=LOAD,
        quantity="rig at rest: motor torque over m g R/(reeving · ratio), force of stage 1 over T₁/r_b1",
        source="exact",
        unit="",
        reference=(1.0, 1.0),
        gate=1e-6,
        compute=_at_rest,
        test="test_statics.py::test_motor_torque_is_weight_times_drum_radius_over_the_ratios",
    )
