"""One gear stage between two rotors in linear bearings to ground, as equations that any integrator can take.

Stage 1 of the rig (z 20/55, m_n 2 mm, beta 12 deg, b 12 mm, mesh model `plane`, 80 um backlash), a motor at 900 rpm
through a torsional coupling, a constant load torque. All integrators get the same modal equations

    p'' + C p' + omega^2 p = f0 + B^T lambda(t, B p, B p')

and the same compiled mesh force; only what advances them in time differs.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.gear_pairs import gear_pair
from fem.casing.reduced.reduced_body import ReducedBody
from fem.contact.models.plane import Plane
from mbd.parts.bearings import BearingSpec
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.load import StaticTorque
from mbd.parts.machine import Machine
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import System, assemble

SPEED = 30.0 * math.pi  # rad/s, 900 rpm
TORQUE = 56.0  # N m on the wheel, about 1000 N of mesh force
SPAN = 0.05  # s of motion, 15 mesh cycles
RATE = 10e3  # Hz, instants at which solutions are compared
CLOSE = 1e-3  # error at which times are compared


def machine() -> Machine:
    """The two shafts, rigid but for torsion, with one gear each."""
    pair = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))  # stage 1 of the rig
    drive, coast = Plane().laws(pair)
    shafts, bearings = [], []
    for number, (gear, x, radius) in enumerate(
        ((pair.pinion, 0.0, 0.0125), (pair.wheel, pair.axis_distance, 0.0175)), start=1
    ):
        mass = 7850.0 * math.pi * gear.reference_radius**2 * gear.face_width
        inertia = mass * gear.reference_radius**2
        disk = Disk(name=f"gear_{number}", y=0.0, mass=mass, polar_inertia=inertia / 2, diametral_inertia=inertia / 4)
        section = Section(y_start=-0.1, y_end=0.1, outer_diameter=2 * radius)
        name, sense = f"shaft_{number}", 3 - 2 * number
        shafts.append(
            ShaftSpec(name=name, x=x, z=0.0, sense=sense, sections=(section,), disks=(disk,), model="torsion")
        )
        for side, y in enumerate((-0.08, 0.08), start=1):
            bearings.append(
                BearingSpec(
                    name=f"bearing_{2 * number - 2 + side}", shaft=name, y=y,
                    stiffness=(1e8, 5e7, 1e8, 1e4, 1e4), damping_time=5e-6,
                )
            )  # fmt: skip
    mesh = MeshSpec(
        name="stage_1", driving="shaft_1", driven="shaft_2", y=0.0, base_radius_driving=pair.pinion.base_radius,
        base_radius_driven=pair.wheel.base_radius, pressure_angle=pair.working_pressure_angle,
        base_helix_angle=pair.base_helix_angle, backlash=80e-6, damping_time=1.8e-6, drive=drive, coast=coast,
    )  # fmt: skip
    coupling = MotorCoupling(name="motor_1", shaft="shaft_1", y=-0.1, stiffness=2000.0, damping=0.5)
    return Machine(
        shafts=tuple(shafts), bearings=tuple(bearings), meshes=(mesh,), couplings=(coupling,),
        profile=SpeedProfile(times=np.array([0.0]), speeds=np.array([SPEED])),
        load=StaticTorque(shaft="shaft_2", drums=(0.1,), torque=TORQUE),
    )  # fmt: skip


def system() -> System:
    """The assembled machine, bearings to ground."""
    nothing = np.zeros((0, 0))
    ground = ReducedBody(
        model="none", mass=nothing, stiffness=nothing, damping=nothing, coordinate_names=(), row_names=(),
        rows=nothing, point_names=(), point_positions=np.zeros((0, 3)),
        ground_inertia=np.zeros((0, 3)), row_shifts=np.zeros((0, 3)), foot_stiffness=nothing,
        foot_inertia=np.zeros((0, 3)),
    )  # fmt: skip
    return assemble(machine(), ground)


@dataclass(frozen=True, eq=False)
class Equations:
    """The modal equations of a system at constant motor speed, and where they start."""

    omega2: np.ndarray  # (r,)
    damping: np.ndarray  # (r, r)
    start: np.ndarray  # (2 r,) p, p'
    push: Callable[[float, np.ndarray, np.ndarray], np.ndarray]  # (t, p, p') -> f0 + B^T lambda, compiled
    delta: np.ndarray  # (r,) row of the approach of the drive flank

    @staticmethod
    def of(machine: System) -> Equations:
        """Take them from the assembled system."""
        from numba import njit

        from mbd.elements.element import WIDTH
        from mbd.elements.element_table import Instant, instant
        from mbd.elements.newton import forces_at

        basis, table = machine.basis, machine.table
        u_rows, v_rows = np.ascontiguousarray(machine.all_rows @ basis), np.ascontiguousarray(machine.rows @ basis)
        constant, m, columns = basis.T @ machine.constant_force, len(v_rows), instant(table).log.shape

        @njit
        def push(t, p, rate):
            force, slope_u, slope_v, none = np.empty(m), np.empty((m, WIDTH)), np.empty((m, WIDTH)), np.empty(0)
            now = Instant(
                np.empty(m), np.empty(m), np.empty((m, WIDTH)), np.empty(columns), np.empty(m), np.empty((m, WIDTH))
            )
            u, v = u_rows @ np.ascontiguousarray(p), v_rows @ np.ascontiguousarray(rate)
            forces_at(table, (SPEED * t, SPEED, t), u, v, none, slope_u[:0], force, slope_u, slope_v, now)
            return constant + v_rows.T @ force

        state = equilibrium(machine)
        to_modal = basis.T @ machine.mass
        start = np.concatenate([to_modal @ state.displacement, to_modal @ state.velocity])
        damping = np.ascontiguousarray(basis.T @ machine.damping @ basis)
        push(0.0, start[: len(damping)], start[len(damping) :])
        return Equations(machine.frequencies**2, damping, start, push, u_rows[0])

    def rate(self) -> Callable[[float, np.ndarray], np.ndarray]:
        """(t, x) -> x' of the state x = (p, p'), compiled."""
        from numba import njit

        n, omega2, damping, push = len(self.omega2), self.omega2, self.damping, self.push

        @njit
        def rate(t, x):
            out = np.empty(2 * n)
            out[:n] = x[n:]
            out[n:] = push(t, x[:n], x[n:]) - damping @ np.ascontiguousarray(x[n:]) - omega2 * x[:n]
            return out

        rate(0.0, self.start)
        return rate


def instants() -> np.ndarray:
    """Times (s) at which solutions are compared."""
    return np.arange(1, round(SPAN * RATE) + 1) / RATE


def error(found: np.ndarray, exact: np.ndarray) -> float:
    """RMS of the difference over the standard deviation of the exact dynamic approach."""
    return float(np.sqrt(np.mean((found - exact) ** 2)) / exact.std())


def seconds_at(rows: list[dict[str, float]], wanted: float = CLOSE) -> float | None:
    """Seconds of a method at the error `wanted`, log-linear between its runs; None if it does not reach it."""
    points = sorted((row["error"], row["cpu_seconds"]) for row in rows)
    if not points or points[0][0] > wanted:
        return None
    if points[-1][0] <= wanted:
        return min(second for _, second in points)
    e, s = np.log(np.array(points)).T
    return float(np.exp(np.interp(math.log(wanted), e, s)))
