"""Integrals for the energy balance of the linear parts as sums over the instants, for an integrator without a `Flow`.

Sums are those of the trapezoidal rule, which converges faster than any power of the sampling interval for smooth
oscillations that the instants resolve. A jump D phi'' of the motor acceleration changes v by J D phi'',
J = -M^-1 M R, so that by the Euler-Maclaurin formula a power v . g gains H^2 B_2(theta)/2 J D phi'' . g at the place
theta between samples at the distance H (B_2 = theta^2 - theta + 1/6).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import blas

from mbd.integrators.base import ACCELERATION, LENGTH, SPEED, Block

MAX_SAMPLES = 100_000  # for int x x^T; longer runs are sampled every few steps


class SampledWork:
    """Accumulates the integrals of a run of at least ``n_steps`` steps; ``steps`` is the number rounded up to the
    stride. ``torque`` (state,) is the row of the motors' torque."""

    def __init__(self, step: float, n_steps: int, to_force: np.ndarray, n_rows: int, torque: np.ndarray) -> None:
        self._step, self._to_force, self._m, self._torque = step, to_force, n_rows, torque
        self.motor_work, self._power = 0.0, 0.0
        self.stride = max(1, -(-n_steps // MAX_SAMPLES))
        self.steps = -(-n_steps // self.stride) * self.stride
        ports, size = to_force.shape
        self._second, self._first = np.zeros((size, size), order="F"), np.zeros(size)
        self._cross, self._pushed = np.zeros((ports, size)), np.zeros(ports)
        self._jump_states, self._jump_forces, self._held = np.zeros(size), np.zeros(ports), 0.0
        self._origin, self._origin_force = np.zeros(size), np.zeros(n_rows)

    def take(self, block: Block, first: int) -> None:
        """Add a block of whole steps; ``first`` is its first instant, counted in steps since the start."""
        if first == 0:
            self._origin, self._origin_force = block.states[0].copy(), block.forces[0].copy()
        power = (block.states @ self._torque) * block.clock[:, SPEED]
        self.motor_work += 0.5 * float(block.clock[:, LENGTH] @ (power + np.concatenate([[self._power], power[:-1]])))
        self._power = float(power[-1])
        states = block.states - self._origin
        at = np.arange(first, first + len(states))
        weight = self._step * np.where((at == 0) | (at == self.steps), 0.5, 1.0)
        forces = states @ self._to_force.T
        forces[:, : self._m] -= block.forces - self._origin_force
        self._cross += (weight[:, None] * forces).T @ states
        self._pushed += weight @ forces
        self._jumps(at, states, forces, block.clock[:, ACCELERATION])
        use = at % self.stride == 0
        root = np.sqrt(weight[use] * self.stride)
        chosen = states[use] * root[:, None]
        self._second = blas.dsyrk(1.0, chosen.T, beta=1.0, c=self._second, overwrite_c=True)
        self._first += root @ chosen

    def _jumps(self, at: np.ndarray, states: np.ndarray, forces: np.ndarray, accelerations: np.ndarray) -> None:
        """Acceleration jumps, each assigned to the first instant after it, within one step of its place."""
        jumps = np.diff(accelerations, prepend=self._held)
        self._held = float(accelerations[-1])
        some = np.flatnonzero(jumps)
        if len(some) == 0:
            return
        theta = ((at[some] - 1) % self.stride) / self.stride
        weight = 0.5 * (self.stride * self._step) ** 2 * (theta**2 - theta + 1 / 6)
        self._jump_states += (weight * jumps[some]) @ states[some]
        self._jump_forces += self._step**2 / 12 * jumps[some] @ forces[some]

    def integrals(
        self, latest: np.ndarray, to_q: np.ndarray, to_v: np.ndarray, turn: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """int f v^T dt (port, coordinate) and int v v^T dt (coordinate, coordinate) over the run.

        Parameters
        ----------
        latest : (x,) state at the last instant
        to_q, to_v : (coordinate, x) displacements and velocities of a state
        turn : (coordinate,) J, see above
        """
        start = self._to_force @ self._origin
        start[: self._m] -= self._origin_force
        v_0, v_1 = to_v @ self._origin, to_v @ self._first
        work = np.outer(start, to_q @ (latest - self._origin)) + np.outer(self._pushed, v_0)
        work += self._cross @ to_v.T + np.outer(self._jump_forces, turn)
        second = np.triu(self._second) + np.triu(self._second, 1).T
        half = np.outer(to_v @ self._jump_states, turn) + np.outer(v_0, 0.5 * self._step * self.steps * v_0 + v_1)
        return work, to_v @ second @ to_v.T + half + half.T
