"""Generalised-alpha in physical coordinates: dense matrices, own loop, chosen damping of high frequencies.

M [(1 - a_m) A_new + a_m A_old] + (1 - a_f) (C v + K q - g)_new + a_f (C v + K q - g)_old = 0,
q_new = q + h v + h^2 [(1/2 - b) A_old + b A_new],  v_new = v + h [(1 - c) A_old + c A_new],

a_m = (2 rho - 1)/(rho + 1), a_f = rho/(rho + 1), c = 1/2 - a_m + a_f, b = (1 + a_f - a_m)^2/4. A is the method's own
acceleration, which jumps with the motor's; second order, unconditionally stable; rho is the spectral radius at
infinite frequency. It shares with
the modal methods only the assembled matrices and the force law, and uses the full coordinates, not the modal basis.

References
----------
Chung & Hulbert (1993), J. Appl. Mech. 60(2), 371-375.
"""

from __future__ import annotations

import copy

import numpy as np
from scipy import linalg

from mbd.elements.element_table import instant
from mbd.elements.newton import solve_rows, work_between
from mbd.integrators.base import TOLERANCE, Block, Flow, uniform_clock
from mbd.parts.part_checks import StepError
from mbd.system.statics import State
from mbd.system.system import System

DEFAULT_RADIUS = 0.9


class GeneralisedAlpha:
    """Integrator (see `mbd.integrators.base`); the state is (q, v)."""

    flow: Flow | None = None

    def __init__(self, system: System, step: float, radius: float = DEFAULT_RADIUS) -> None:
        n = system.layout.size
        self._system, self._step, self._radius = system, step, radius
        self._am, self._af = (2 * radius - 1) / (radius + 1), radius / (radius + 1)
        self._gamma = 0.5 - self._am + self._af
        self._beta = 0.25 * (1 + self._af - self._am) ** 2
        self.displacement, self.velocity = np.eye(n, 2 * n), np.eye(n, 2 * n, n)
        self.inverse_mass = np.linalg.inv(system.mass)
        self.counters = {"steps": 0, "cuts": 0, "iterations": 0}
        matrix = (1 - self._am) * system.mass
        matrix += (1 - self._af) * step * (self._gamma * system.damping + self._beta * step * system.stiffness)
        self._factor = linalg.cho_factor(matrix)
        answer = (1 - self._af) * linalg.cho_solve(self._factor, system.rows.T)  # A_new per new residual force
        self._g_u = self._beta * step**2 * system.all_rows @ answer
        self._g_v = self._gamma * step * system.rows @ answer
        self._answer = answer

    def start(self, state: State) -> Block:
        """Set the state at t = 0."""
        system = self._system
        self._q, self._v, self._forces = state.displacement.copy(), state.velocity.copy(), state.forces.copy()
        self._angle, self._time, self._motor = state.motor_angle, 0.0, 0.0
        self._rows, self._now = system.all_rows @ self._q, instant(system.table)
        still = np.zeros((len(self._rows), len(self._forces)))
        v = system.rows @ self._v
        used = solve_rows(
            system.table, (self._angle, state.motor_speed, 0.0), u_p=self._rows.copy(), v_p=v.copy(), g_u=still,
            g_v=still[: len(v)].copy(), force=self._forces, u=self._rows, v=v, now=self._now, tolerance=TOLERANCE,
        )  # fmt: skip
        if used < 0:
            raise StepError("the forces at t = 0 could not be evaluated; the state is not finite.")
        self._push = system.constant_force + system.rows.T @ self._forces
        self._acceleration = self.inverse_mass @ (self._push - system.damping @ self._v - system.stiffness @ self._q)
        first = self._instant()
        return self._block([(first[0], *first)], np.array([[0.0, self._angle, state.motor_speed, 0.0]]))

    def branch(self, change: np.ndarray) -> GeneralisedAlpha:
        """A second integrator at this instant, its state moved by ``change`` (x,)."""
        other, n = copy.copy(self), len(self._q)
        other.counters = dict(self.counters)
        other._q, other._v, other._forces = self._q + change[:n], self._v + change[n:], self._forces.copy()
        return other

    def halved(self) -> GeneralisedAlpha:
        """A second integrator at this instant with half the step."""
        other = GeneralisedAlpha(self._system, 0.5 * self._step, self._radius)
        other._q, other._v, other._forces = self._q.copy(), self._v.copy(), self._forces.copy()
        other._angle, other._motor, other._acceleration = self._angle, self._motor, self._acceleration.copy()
        other._rows, other._now, other._time = self._rows.copy(), self._now, self._time
        return other

    def advance(
        self, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray, like: Block | None = None
    ) -> Block:
        """Take len(angles) steps.

        Parameters
        ----------
        angles, speeds, accelerations : (step,) of the motor as in `mbd.integrators.base`, rad, rad/s and rad/s2
        like : not used, no step is ever cut
        """
        instants = []
        for angle, speed, acceleration in zip(angles, speeds, accelerations, strict=True):
            start = np.concatenate([self._q, self._v])
            self._one_step(float(angle), float(speed), float(acceleration))
            state, *others = self._instant()
            instants.append((state, start, *others))
        return self._block(instants, uniform_clock(self._step, angles, speeds, accelerations))

    def _one_step(self, angle: float, speed: float, acceleration: float) -> None:
        system, h, af = self._system, self._step, self._af
        prescribed = system.constant_force - acceleration * (system.mass @ system.rolling)
        self._acceleration = self._acceleration - (acceleration - self._motor) * system.rolling
        self._motor = acceleration
        q_p = self._q + h * self._v + h * h * (0.5 - self._beta) * self._acceleration
        v_p = self._v + h * (1 - self._gamma) * self._acceleration
        old = system.rows.T @ self._forces - system.damping @ self._v - system.stiffness @ self._q
        free = prescribed - self._am * system.mass @ self._acceleration + af * old
        free -= (1 - af) * (system.damping @ v_p + system.stiffness @ q_p)
        a_p = linalg.cho_solve(self._factor, free)
        u_p = system.all_rows @ (q_p + self._beta * h * h * a_p)
        w_p = system.rows @ (v_p + self._gamma * h * a_p)
        rows, rates, now = u_p.copy(), w_p.copy(), instant(system.table)
        clock = angle, speed, self._time + h
        used = solve_rows(
            system.table, clock, u_p=u_p, v_p=w_p, g_u=self._g_u, g_v=self._g_v, force=self._forces, u=rows, v=rates,
            now=now, tolerance=TOLERANCE,
        )  # fmt: skip
        step = self.counters["steps"]
        if used < 0:
            raise StepError(
                f"time step {step} (t = {(step + 1) * h:.6g} s, h = {h:.3g} s): the contact forces did not converge. "
                "Use a smaller step."
            )
        work_between(system.table, self._angle, clock, self._rows, rows, rates, self._now, now)
        self._acceleration = a_p + self._answer @ self._forces
        self._q = q_p + self._beta * h * h * self._acceleration
        self._v = v_p + self._gamma * h * self._acceleration
        self._rows, self._now, self._angle, self._time = rows, now, angle, clock[2]
        self.counters["steps"] += 1
        self.counters["iterations"] += used

    def _instant(self) -> tuple[np.ndarray, ...]:
        found = self._forces, self._rows, self._now.elastic, self._now.lost, self._now.log
        return np.concatenate([self._q, self._v]), *(values.copy() for values in found)

    def _block(self, instants: list[tuple[np.ndarray, ...]], clock: np.ndarray) -> Block:
        columns = dict(zip(Block._fields, (np.array(column) for column in zip(*instants, strict=True)), strict=False))
        none = np.zeros((len(instants), 0, len(self._forces)))
        return Block(**columns, clock=clock, whole=np.arange(len(instants)), holds=none)
