"""Works of the linear parts: shafts, bearings, casing, couplings, container.

With the state x and the residual forces lambda the powers of these parts are quadratic forms. S = integral of dx dx^T,
sampled every ``stride`` steps, and L = integral of dlambda dx^T at every step (d: minus the value at the start) give
all of them after the run: with v = V x, a part that feels the forces g = G x + B^T lambda receives

    integral v . g dt = g_0 . Dq + v_0 . integral dg dt + sum (V S) G + sum (V L^T) B^T.

The integrals are sums by the trapezoidal rule, accurate beyond all orders for smooth oscillations. Kinks are added by
Euler and Maclaurin's formula: a method that holds the forces linear within a step gives
h/12 sum (second difference of lambda) x^T to L; a jump Dphi'' of the motor acceleration turns v by J Dphi'',
J = -M^-1 M R, so a power v . g gains H^2 B_2(theta)/2 J Dphi'' . g, at the place theta between samples H apart
(B_2 = theta^2 - theta + 1/6, 1/6 at a sample).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import blas

from mbd.integrators.base import Block, Integrator
from mbd.system import Part, System

MAX_SAMPLES = 200_000  # of S; longer runs are sampled every few steps


class LinearWork:
    """Accumulates blocks of a run of at least ``n_steps`` steps; ``steps`` is that number rounded up to the stride."""

    def __init__(self, system: System, integrator: Integrator, step: float, n_steps: int) -> None:
        self._system, self._step, self._kinks = system, step, integrator.linear_forces
        self.stride = max(1, -(-n_steps // MAX_SAMPLES))
        self.steps = -(-n_steps // self.stride) * self.stride
        self.to_q, self.to_v = integrator.displacement, integrator.velocity
        size, m = self.to_q.shape[1], len(system.rows)
        self._second, self._first = np.zeros((size, size), order="F"), np.zeros(size)
        self._cross, self._pushed = np.zeros((m, size)), np.zeros(m)
        self._turn = -integrator.inverse_mass @ (system.mass @ system.rolling)  # J
        self._jump_states, self._jump_forces = np.zeros(size), np.zeros(m)
        self._held = 0.0
        self._tail_states, self._tail_forces = np.zeros((0, size)), np.zeros((0, m))
        self.origin, self.latest, self._origin_force = np.zeros(size), np.zeros(size), np.zeros(m)
        self._stored_first: dict[str, float] = {}
        self._peak: dict[str, float] = {}

    def take(self, block: Block, first: int, accelerations: np.ndarray) -> None:
        """Add instants ``first``, ``first`` + 1, ... (steps since the start); accelerations held before each."""
        if first == 0:
            self.origin, self._origin_force, self.latest = block.states[0], block.forces[0], block.states[0]
            self._stored_first = self._stored()
            self._peak = dict(self._stored_first)
        states, forces = block.states - self.origin, block.forces - self._origin_force
        at = np.arange(first, first + len(states))
        weight = self._step * np.where((at == 0) | (at == self.steps), 0.5, 1.0)
        self._cross += (weight[:, None] * forces).T @ states
        self._pushed += weight @ forces
        if self._kinks:
            near, x = np.vstack([self._tail_forces, forces]), np.vstack([self._tail_states, states])
            self._cross += self._step / 12 * np.diff(near, 2, axis=0).T @ x[1:-1]
            self._tail_forces, self._tail_states = near[-2:].copy(), x[-2:].copy()
        self._jumps(at, states, forces, accelerations)
        use = at % self.stride == 0
        root = np.sqrt(weight[use] * self.stride)
        chosen = states[use] * root[:, None]
        self._second = blas.dsyrk(1.0, chosen.T, beta=1.0, c=self._second, overwrite_c=True)
        self._first += root @ chosen
        self.latest = block.states[-1]
        for name, value in self._stored().items():
            self._peak[name] = max(self._peak[name], value)

    def _jumps(self, at: np.ndarray, states: np.ndarray, forces: np.ndarray, accelerations: np.ndarray) -> None:
        """Acceleration jumps, each counted at the first instant after it: within one step of its place."""
        jumps = np.diff(accelerations, prepend=self._held)
        self._held = float(accelerations[-1])
        some = np.flatnonzero(jumps)
        if len(some) == 0:
            return
        theta = ((at[some] - 1) % self.stride) / self.stride
        weight = 0.5 * (self.stride * self._step) ** 2 * (theta**2 - theta + 1 / 6)
        self._jump_states += (weight * jumps[some]) @ states[some]
        self._jump_forces += self._step**2 / 12 * jumps[some] @ forces[some]

    def books(self, ramp_work: dict[str, float]) -> dict[str, list[float]]:
        """Stored, dissipated, received, parametric (0), residual, scale of every part, J."""
        system = self._system
        second = np.triu(self._second) + np.triu(self._second, 1).T
        stored, moved = self._stored(), self.to_q @ (self.latest - self.origin)
        v_0, v_1 = self.to_v @ self.origin, self.to_v @ self._first
        half = second @ self.to_v.T + np.outer(self._jump_states, self._turn)
        cross = self._cross @ self.to_v.T + np.outer(self._jump_forces, self._turn)
        v_2 = self.to_v @ half + np.outer(self._turn, self.to_v @ self._jump_states)
        rows: dict[str, list[float]] = {}
        for part in system.parts:
            i = part.index
            own = part.stiffness @ self.to_q[i] + part.damping @ self.to_v[i]
            if part.mass.any():
                around = own - system.stiffness[i] @ self.to_q - system.damping[i] @ self.to_v
                rest = system.constant_force[i] + system.rows[:, i].T @ self._origin_force
                received = ramp_work[part.name] + float(moved[i] @ rest)
                received += float(
                    v_0[i] @ (system.rows[:, i].T @ self._pushed) + np.sum(system.rows[:, i] * cross[:, i])
                )
            else:
                around, received = own, 0.0
            received += float(moved[i] @ (around @ self.origin) + v_0[i] @ (around @ self._first))
            received += float(np.sum(around * half[:, i].T))
            span = self._step * self.steps
            dissipated = float(v_0[i] @ part.damping @ (span * v_0[i] + 2 * v_1[i]))
            dissipated += float(np.sum(part.damping * v_2[np.ix_(i, i)]))
            change = stored[part.name] - self._stored_first[part.name]
            scale = dissipated if part.damping.any() else self._peak[part.name]
            rows[part.name] = [change, dissipated, received, 0.0, received - change - dissipated, scale]
        return rows

    def _stored(self) -> dict[str, float]:
        q, v = self.to_q @ self.latest, self.to_v @ self.latest
        return {part.name: _energy(part, q, v) for part in self._system.parts}


def _energy(part: Part, q: np.ndarray, v: np.ndarray) -> float:
    """Kinetic and strain energy of a linear part."""
    q, v = q[part.index], v[part.index]
    return float(0.5 * v @ part.mass @ v + 0.5 * q @ part.stiffness @ q)
