"""Adaptive reference: SciPy's DOP853 or Radau on the modal equations, for short windows.

(p, p')' = (p', Phi^T (f + B^T lambda - M R phi'') - C p' - omega^2 p) with the error controlled to ``rtol`` = 1e-9; a
free frame (`mbd.system.rolling_frame`) adds its angle and speed to the state.
Made to measure the fixed-step methods, thousands of times slower than they are: use it for milliseconds. It is the
integrator "reference" of `ReferenceSettings`. DOP853 needs a step below 2/omega_max, Radau does not but factorises; the
solver restarts where the motor acceleration jumps.

References
----------
Hairer, Norsett & Wanner (1993), Solving Ordinary Differential Equations I, section II.5 (DOP853).
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from mbd.elements.newton import solve_rows, work_between
from mbd.elements.table import Instant, instant
from mbd.integrators.base import TOLERANCE, Block, Flow, uniform_clock
from mbd.integrators.methods import METHODS
from mbd.integrators.settings import MotionSettings
from mbd.parts.checks import StepError
from mbd.system.statics import State
from mbd.system.system import System

RTOL = 1e-9
ATOL = 1e-13  # mass-normalised coordinates
METHODS["reference"] = (__name__, "Reference")


@dataclass(frozen=True, kw_only=True)
class ReferenceSettings(MotionSettings):
    """Settings with any integrator of METHODS; a scene may not select the reference."""

    integrator: str = "reference"  # type: ignore[assignment]


class Reference:
    """Integrator (see `mbd.integrators.base`) that takes as many inner steps per step as its tolerance needs."""

    flow: Flow | None = None

    def __init__(self, system: System, step: float, method: str = "DOP853") -> None:
        basis, n = system.basis, len(system.frequencies)
        self._system, self._step, self._method = system, step, method
        zero = np.zeros_like(basis)
        self.displacement, self.velocity = np.hstack([basis, zero]), np.hstack([zero, basis])
        self.inverse_mass = basis @ basis.T
        self.counters = {"steps": 0, "cuts": 0, "iterations": 0}
        self._omega2, self._damping = system.frequencies**2, basis.T @ system.damping @ basis
        self._u_rows, self._v_rows = system.all_rows @ basis, system.rows @ basis
        self._constant, self._ramp = basis.T @ system.constant_force, -basis.T @ (system.mass @ system.rolling)
        self._x = np.zeros(2 * n)
        m = len(system.rows)
        self._still = np.zeros((len(self._u_rows), m)), np.zeros((m, m))
        self._now, self._rows = instant(system.table), np.zeros(len(self._u_rows))
        self._angle = self._speed = self._time = 0.0

    def start(self, state: State) -> Block:
        """Set the state at t = 0."""
        to_modal = self._system.basis.T @ self._system.mass
        self._x = np.concatenate([to_modal @ state.displacement, to_modal @ state.velocity])
        self._angle, self._speed, self._time = state.motor_angle, state.motor_speed, 0.0
        forces, self._rows, _, self._now = self._forces(self._x, (self._angle, state.motor_speed, 0.0))
        clock = np.array([[0.0, self._angle, state.motor_speed, 0.0]])
        return Block(
            self._x[None], self._x[None], forces[None], self._rows[None], self._now.elastic[None],
            self._now.lost[None], self._now.log[None], clock, np.zeros(1, dtype=int),
            np.zeros((1, 0, len(forces))),
        )  # fmt: skip

    def branch(self, change: np.ndarray) -> Reference:
        """A second integrator at this instant, its state moved by ``change`` (x,)."""
        other = copy.copy(self)
        other.counters = dict(self.counters)
        other._x = self._x + change
        return other

    def halved(self) -> Reference:
        """A second integrator at this instant with half the step."""
        other = self.branch(np.zeros_like(self._x))
        other._step = 0.5 * self._step
        return other

    def advance(
        self, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray, like: Block | None = None
    ) -> Block:
        """Take len(angles) steps.

        Parameters
        ----------
        angles, speeds, accelerations : (step,) of the motor as in `mbd.integrators.base`, rad, rad/s and rad/s2
        like : not used, whole steps are never cut
        """
        instants = []
        motor = []
        for given in zip(angles, speeds, accelerations, strict=True):
            start, (self._x, *moved) = self._x, self._one_step(*(float(value) for value in given))
            angle, self._speed = moved[:2]
            motor.append(moved)
            clock = angle, self._speed, self._time + self._step
            forces, rows, rates, now = self._forces(self._x, clock)
            work_between(self._system.table, self._angle, clock, self._rows, rows, rates, self._now, now)
            self._rows, self._now, self._angle, self._time = rows, now, clock[0], clock[2]
            self.counters["steps"] += 1
            instants.append((self._x, start, forces, rows, now.elastic, now.lost, now.log))
        columns = dict(zip(Block._fields, (np.array(column) for column in zip(*instants, strict=True)), strict=False))
        clocks = uniform_clock(self._step, *np.array(motor).T)
        none = np.zeros((len(instants), 0, len(self._v_rows)))
        return Block(**columns, clock=clocks, whole=np.arange(len(instants)), holds=none)

    def _one_step(self, angle: float, speed: float, acceleration: float) -> tuple[np.ndarray, float, float, float]:
        """State, angle, speed and mean acceleration of the frame at the end of a step; the arguments are those of a
        frame whose motion is prescribed."""
        h, n, frame = self._step, len(self._omega2), self._system.frame
        prescribed = self._constant + (0.0 if frame.free else acceleration) * self._ramp
        start = self._speed if frame.free else (angle - self._angle) / h - 0.5 * acceleration * h

        def rate(t: float, y: np.ndarray) -> np.ndarray:
            x = y[:-2]
            forces = self._forces(x, (y[-2], y[-1], self._time + t))[0]
            push = prescribed + self._v_rows.T @ forces - self._damping @ x[n:] - self._omega2 * x[:n]
            turning = frame.load + frame.push @ forces if frame.free else acceleration
            return np.concatenate([x[n:], push, [y[-1], turning]])

        begin = np.concatenate([self._x, [self._angle, start]])
        answer = solve_ivp(rate, (0.0, h), begin, method=self._method, rtol=RTOL, atol=ATOL)
        if not answer.success:
            raise StepError(f"reference ({self._method}), step {self.counters['steps']}: {answer.message}")
        self.counters["iterations"] += int(answer.nfev)
        end = answer.y[:, -1]
        if not frame.free:
            return end[:-2], angle, speed, acceleration
        return end[:-2], float(end[-2]), float(end[-1]), (float(end[-1]) - start) / h

    def _forces(
        self, x: np.ndarray, clock: tuple[float, float, float]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, Instant]:
        """Residual forces, rows, their rates and the answers of the elements."""
        n = len(self._omega2)
        u, v = self._u_rows @ x[:n], self._v_rows @ x[n:]
        forces, now = np.zeros(len(v)), instant(self._system.table)
        g_u, g_v = self._still
        used = solve_rows(
            self._system.table, clock, u_p=u, v_p=v, g_u=g_u, g_v=g_v, force=forces, u=u.copy(), v=v.copy(), now=now,
            tolerance=TOLERANCE,
        )  # fmt: skip
        if used < 0:
            raise StepError(f"reference, step {self.counters['steps']}: the state is not finite. Use a smaller step.")
        return forces, u, v, now
