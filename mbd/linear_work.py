"""Works of the linear parts: shafts, bearings, casing, couplings, container.

Parts with mass touch only through ports: rows B with the forces f = k B q + c B q' - lambda of bearings, couplings,
meshes and ropes (lambda for the last two). With the state x, v = V x, and d for "minus the value at the start", the
integral C of df dx^T, summed at every step, gives the work of every port on every part after the run:

    integral f . B v dt = f_0 . B Dq + B v_0 . integral df dt + sum (C V^T B^T).

The dissipation v^T C v of a part follows from S = integral of dx dx^T, summed every ``stride`` steps. Sums are those of
the trapezoidal rule, accurate beyond all orders for smooth oscillations. Kinks are added by Euler and Maclaurin's
formula: a method that holds lambda linear within a step gives h/12 sum (second difference of -lambda) x^T to C; a jump
Dphi'' of the motor acceleration turns v by J Dphi'', J = -M^-1 M R, so that a power v . g gains
H^2 B_2(theta)/2 J Dphi'' . g at the place theta between samples H apart (B_2 = theta^2 - theta + 1/6).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import blas

from mbd.forces import reference_damping, reference_stiffness
from mbd.integrators.base import Block, Integrator
from mbd.system import Part, System

MAX_SAMPLES = 100_000  # of S; longer runs are sampled every few steps


class LinearWork:
    """Accumulates blocks of a run of at least ``n_steps`` steps; ``steps`` is that number rounded up to the stride."""

    def __init__(self, system: System, integrator: Integrator, step: float, n_steps: int) -> None:
        self._system, self._step, self._kinks = system, step, False
        self.stride = max(1, -(-n_steps // MAX_SAMPLES))
        self.steps = -(-n_steps // self.stride) * self.stride
        self.to_q, self.to_v = integrator.displacement, integrator.velocity
        self._ports, stiffness, damping = _ports(system)
        self._to_force = stiffness[:, None] * (self._ports @ self.to_q) + damping[:, None] * (self._ports @ self.to_v)
        self._turn = -integrator.inverse_mass @ (system.mass @ system.rolling)  # J
        size, m, p = self.to_q.shape[1], len(system.rows), len(self._ports)
        self._second, self._first = np.zeros((size, size), order="F"), np.zeros(size)
        self._cross, self._pushed = np.zeros((p, size)), np.zeros(p)
        self._jump_states, self._jump_forces, self._held = np.zeros(size), np.zeros(p), 0.0
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
        states, residual = block.states - self.origin, block.forces - self._origin_force
        m = residual.shape[1]
        at = np.arange(first, first + len(states))
        weight = self._step * np.where((at == 0) | (at == self.steps), 0.5, 1.0)
        forces = states @ self._to_force.T
        forces[:, :m] -= residual
        self._cross += (weight[:, None] * forces).T @ states
        self._pushed += weight @ forces
        if self._kinks:
            near, x = np.vstack([self._tail_forces, residual]), np.vstack([self._tail_states, states])
            self._cross[:m] -= self._step / 12 * np.diff(near, 2, axis=0).T @ x[1:-1]
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
        system, stored, moved = self._system, self._stored(), self.to_q @ (self.latest - self.origin)
        v_0, v_1, v_2 = self._velocity_integrals()
        start = self._to_force @ self.origin
        start[: len(self._origin_force)] -= self._origin_force
        cross = self._cross @ self.to_v.T + np.outer(self._jump_forces, self._turn)
        # work (port, coordinate) that the motion of each coordinate does against each port
        work = self._ports * (np.outer(start, moved) + np.outer(self._pushed, v_0) + cross)
        rows: dict[str, list[float]] = {}
        port = len(system.rows)
        for part in system.parts:
            i = part.index
            if part.mass.any():
                received = ramp_work[part.name] + float(moved[i] @ system.constant_force[i] - work[:, i].sum())
            else:
                received = float(work[port : port + len(part.rows)].sum())
                port += len(part.rows)
            span = self._step * self.steps
            dissipated = float(v_0[i] @ part.damping @ (span * v_0[i] + 2 * v_1[i]))
            dissipated += float(np.sum(part.damping * v_2[np.ix_(i, i)]))
            change = stored[part.name] - self._stored_first[part.name]
            scale = dissipated if part.damping.any() else self._peak[part.name]
            rows[part.name] = [change, dissipated, received, 0.0, received - change - dissipated, scale]
        return rows

    def _velocity_integrals(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """v_0, integral of dv, integral of dv dv^T."""
        second = np.triu(self._second) + np.triu(self._second, 1).T
        half = np.outer(self.to_v @ self._jump_states, self._turn)
        return self.to_v @ self.origin, self.to_v @ self._first, self.to_v @ second @ self.to_v.T + half + half.T

    def _stored(self) -> dict[str, float]:
        q, v = self.to_q @ self.latest, self.to_v @ self.latest
        return {part.name: _energy(part, q, v) for part in self._system.parts}


def _ports(system: System) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, stiffness and damping of all ports: meshes and ropes (their linear reference), then the massless parts."""
    table, massless = system.table, [part for part in system.parts if not part.mass.any()]
    return (
        np.vstack([system.rows, *(part.rows for part in massless)]),
        np.concatenate([reference_stiffness(table), *(part.row_stiffness for part in massless)]),
        np.concatenate([reference_damping(table), *(part.row_damping for part in massless)]),
    )


def _energy(part: Part, q: np.ndarray, v: np.ndarray) -> float:
    """Kinetic and strain energy of a linear part."""
    q, v = q[part.index], v[part.index]
    return float(0.5 * v @ part.mass @ v + 0.5 * q @ part.stiffness @ q)
