"""Energy books: what every part stored, dissipated and received, and what is left over.

Parts with mass (shafts, casing, container), bearings and couplings are linear: their powers are quadratic forms of
z = (state, lambda). One weighted Gram matrix S = integral of dz dz^T (dz = z - z at the start), sampled every
``stride`` steps, therefore gives all of them after the run: with v = V z and the forces g = G z of its neighbours a
part receives

    integral v . g dt = g(z_0) . dq + v(z_0) . integral dg dt + sum (V S G^T).

These books are kept in the frame that rolls with the train; the inertia force of a speed ramp counts as received.
Elements (meshes, rope) are logged at every step: U, the parametric work (see `mbd.forces`), and the work of the forces
with and without damping, integral F d delta + M d psi, of cubics through four instants: per step mean(F) D delta +
(D F mean(D2 delta) - mean(D2 F) D delta)/12 with first and second differences D, D2.

The total book is that of the real motion R phi_m + q: sources are the motors, gravity, drum torque and the parametric
works.

residual = received + parametric - change of stored energy - dissipated.
"""

from __future__ import annotations

import numpy as np

from mbd.forces import LOG_COLUMNS
from mbd.integrators.base import Block, Integrator
from mbd.system import Part, System

BOOK_COLUMNS = ("stored", "dissipated", "received", "parametric", "residual", "scale")
MAX_SAMPLES = 125_000  # of the Gram matrix; longer runs are sampled every few steps
_FORCE, _MOMENT, _ENERGY, _TOTAL, _, _, _, _PARAMETRIC, _PUSH, _TURN = range(len(LOG_COLUMNS))


class Books:
    """Accumulates blocks of a run of at least ``n_steps`` steps; `steps` is that number rounded up to the stride."""

    def __init__(self, system: System, integrator: Integrator, step: float, n_steps: int) -> None:
        self._system, self._step = system, step
        self.stride = max(1, -(-n_steps // MAX_SAMPLES))
        self.steps = -(-n_steps // self.stride) * self.stride
        m = len(system.rows)
        self._to_q = np.hstack([integrator.displacement, np.zeros((system.layout.size, m))])
        self._to_v = np.hstack([integrator.velocity, np.zeros((system.layout.size, m))])
        size = self._to_q.shape[1]
        self._gram, self._sum = np.zeros((size, size)), np.zeros(size)
        self._massive = [p for p in system.parts if p.mass.any()]
        self._origin, self._latest = np.zeros(size), np.zeros(size)
        torque = sum(
            -(c.stiffness * system.layout.angle_row(c.shaft, c.y) @ self._to_q)
            - c.damping * system.layout.angle_row(c.shaft, c.y) @ self._to_v
            for c in system.machine.couplings
        )
        inertia = [part.mass @ system.rolling[part.index] @ self._to_q[part.index] for part in self._massive]
        constant = system.constant_force
        self._watch = np.array([*inertia, torque, constant @ self._to_q])
        self._watched = np.zeros(len(self._watch))
        self._motion = np.zeros((3,))  # angle, speed of the motor at the latest instant
        elements = len(system.table.tau) + len(system.table.rope_ea)
        self._log, self._first_energy = np.zeros((0, elements, len(LOG_COLUMNS))), np.zeros(elements)
        self._loss, self._parametric, self._throughput = np.zeros(elements), np.zeros(elements), 0.0
        self._received, self._peak_element = np.zeros(elements), np.zeros(elements)
        self._rows = np.zeros((0, len(system.all_rows)))
        self._ramp_work, self._motor_work, self._constant_work = np.zeros(len(self._massive)), 0.0, 0.0
        self._first: dict[str, float] = {}
        self._peak = {part.name: 0.0 for part in system.parts}
        self._lost, self._touched = np.zeros(elements, dtype=int), np.zeros(elements, dtype=int)

    def take(self, block: Block, first: int, accelerations: np.ndarray) -> None:
        """Add instants ``first``, ``first`` + 1, ... (steps since the start); accelerations held before each."""
        z = np.hstack([block.states, block.forces])
        times = self._step * np.arange(first, first + len(z))
        profile = self._system.machine.profile
        motion = np.column_stack([profile.angle(times), profile.speed(times)])
        watched = z @ self._watch.T
        if first == 0:
            self._origin, self._watched = z[0], watched[0]
            self._motion = motion[0]
            self._first_energy = block.log[0, :, _ENERGY].copy()
            self._latest = z[0]
            self._first = self._stored()
        self._sources(np.vstack([self._watched, watched]), np.vstack([self._motion, motion]), accelerations)
        self._elements(np.concatenate([self._log, block.log]), np.vstack([self._rows, block.rows]), len(self._log))
        self._sample(z - self._origin, first)
        self._latest, self._watched, self._motion = z[-1], watched[-1], motion[-1]
        for name, value in self._stored().items():
            self._peak[name] = max(self._peak[name], value)

    def _sources(self, watched: np.ndarray, motion: np.ndarray, accelerations: np.ndarray) -> None:
        n = len(self._massive)
        change, turned = np.diff(watched, axis=0), np.diff(motion[:, 0])
        self._ramp_work -= accelerations @ change[:, :n]
        motor = 0.5 * (watched[1:, n] + watched[:-1, n]) * turned
        constant = change[:, n + 1] + self._system.constant_force @ self._system.rolling * turned
        self._motor_work += float(motor.sum())
        self._constant_work += float(constant.sum())
        self._throughput += float(abs(motor).sum() + abs(constant).sum())

    def _elements(self, log: np.ndarray, rows: np.ndarray, known: int) -> None:
        """Add the instants after the first ``known`` ones, which are the last three of the block before."""
        new = slice(max(known - 1, 0), None)
        parametric, loaded = log[known:, :, _PARAMETRIC], log[new, :, _FORCE] > 0.0
        self._parametric += parametric.sum(axis=0)
        self._throughput += float(abs(parametric).sum())
        self._peak_element = np.maximum(self._peak_element, log[:, :, _ENERGY].max(axis=0))
        self._lost += (loaded[:-1] & ~loaded[1:]).sum(axis=0)
        self._touched += (~loaded[:-1] & loaded[1:]).sum(axis=0)
        n = len(self._system.table.tau)
        force, total = log[:, :, _FORCE], log[:, :, _TOTAL]
        arm = np.divide(log[:, :, _MOMENT], force, out=np.zeros_like(total), where=force > 0.0)
        along = np.hstack([rows[:, 0 : 2 * n : 2], rows[:, 2 * n : log.shape[1] + n]])
        tilt = np.zeros_like(along)
        tilt[:, :n] = rows[:, 1 : 2 * n : 2]
        for values, sums in ((total, self._received), (total - force, self._loss)):
            sums += _work(values, along, known) + _work(values * arm, tilt, known)
        self._parametric += _push_work(log[:, :, _PUSH], along) + _push_work(log[:, :, _TURN], tilt)
        self._log, self._rows = log[-3:].copy(), rows[-3:].copy()

    def _sample(self, deviation: np.ndarray, first: int) -> None:
        at = np.arange(first, first + len(deviation))
        use = at % self.stride == 0
        weight = self._step * self.stride * np.where((at[use] == 0) | (at[use] == self.steps), 0.5, 1.0)
        chosen = deviation[use] * np.sqrt(weight)[:, None]
        self._gram += chosen.T @ chosen
        self._sum += np.sqrt(weight) @ chosen

    def _stored(self) -> dict[str, float]:
        q, v = self._to_q @ self._latest, self._to_v @ self._latest
        return {part.name: _energy(part, q, v) for part in self._system.parts}

    def events(self) -> dict[str, int]:
        """Contact losses and back-flank contacts of every mesh, slack events of the ropes."""
        result = {}
        for i, mesh in enumerate(self._system.machine.meshes):
            result[f"{mesh.name}:contact_losses"] = int(self._lost[2 * i])
            result[f"{mesh.name}:coast_contacts"] = int(self._touched[2 * i + 1])
        n_flanks = len(self._system.table.tau)
        if len(self._lost) > n_flanks:
            result["rope:slack_events"] = int(self._lost[n_flanks:].sum())
        return result

    def table(self) -> tuple[tuple[str, ...], np.ndarray]:
        """Part names and the entries of BOOK_COLUMNS (part, entry), J; ``scale`` is what the residual is held against:
        the dissipated energy of the part (its peak stored energy if undamped), all work of the sources for the total.
        """
        rows = self._linear_books() | self._element_books()
        parts = np.array(list(rows.values()))
        stored = parts[:, 0].sum() + self._rigid_energy()
        dissipated, parametric = parts[:, 1].sum(), parts[:, 3].sum()
        received = self._motor_work + self._constant_work
        residual = received + parametric - stored - dissipated
        rows["total"] = [stored, dissipated, received, parametric, residual, self._throughput]
        return tuple(rows), np.array(list(rows.values()))

    def _rigid_energy(self) -> float:
        """Change of (phi' R)^T M v + phi'^2 R^T M R/2, the kinetic energy that the rolling frame leaves out."""
        system = self._system
        momentum = system.rolling @ system.mass
        change = 0.0
        for sign, z, time in ((1, self._latest, self._step * self.steps), (-1, self._origin, 0.0)):
            speed = float(system.machine.profile.speed(np.array([time]))[0])
            change += sign * speed * float(momentum @ (self._to_v @ z) + 0.5 * speed * momentum @ system.rolling)
        return change

    def _linear_books(self) -> dict[str, list[float]]:
        system, stored = self._system, self._stored()
        moved, kinetic = self._to_q @ (self._latest - self._origin), self._gram @ self._to_v.T
        rates = _Integrals(self._to_v @ self._origin, self._to_v @ self._sum, self._to_v @ kinetic, self._span())
        push = np.hstack([np.zeros((system.layout.size, self._to_q.shape[1] - len(system.rows))), system.rows.T])
        rows: dict[str, list[float]] = {}
        for part in system.parts:
            i = part.index
            own = part.stiffness @ self._to_q[i] + part.damping @ self._to_v[i]
            if part.mass.any():
                around = push[i] - system.stiffness[i] @ self._to_q - system.damping[i] @ self._to_v + own
                received = float(moved[i] @ system.constant_force[i]) + self._ramp_work[self._massive.index(part)]
            else:
                around, received = own, 0.0
            received += float(moved[i] @ (around @ self._origin) + rates.start[i] @ (around @ self._sum))
            received += float(np.sum(around * kinetic[:, i].T))
            dissipated = rates.quadratic(part.damping, i)
            change = stored[part.name] - self._first[part.name]
            scale = dissipated if part.damping.any() else self._peak[part.name]
            rows[part.name] = [change, dissipated, received, 0.0, received - change - dissipated, scale]
        return rows

    def _element_books(self) -> dict[str, list[float]]:
        names = [(mesh.name, slice(2 * i, 2 * i + 2)) for i, mesh in enumerate(self._system.machine.meshes)]
        n = len(self._system.table.tau)
        if len(self._loss) > n:
            names.append(("rope", slice(n, len(self._loss))))
        rows = {}
        for name, at in names:
            change = float((self._log[-1, at, _ENERGY] - self._first_energy[at]).sum())
            loss, parametric = float(self._loss[at].sum()), float(self._parametric[at].sum())
            received = float(self._received[at].sum())
            scale = loss if loss > 0 else float(self._peak_element[at].max())
            rows[name] = [change, loss, received, parametric, received + parametric - change - loss, scale]
        return rows

    def _span(self) -> float:
        return self._step * self.steps


def _work(force: np.ndarray, motion: np.ndarray, known: int) -> np.ndarray:
    """Integral of force d(motion) after the first ``known`` instants; its cubic part lags by one step."""
    new = slice(max(known - 1, 0), None)
    total = (0.5 * (force[new][1:] + force[new][:-1]) * np.diff(motion[new], axis=0)).sum(axis=0)
    slope = [x[2:-1] - x[1:-2] for x in (force, motion)]
    return total + (slope[0] * _bend(motion) - _bend(force) * slope[1]).sum(axis=0) / 12


def _bend(values: np.ndarray) -> np.ndarray:
    """Mean of the second differences at both ends of every step that has neighbours."""
    return 0.5 * (values[3:] - values[2:-1] - values[1:-2] + values[:-3])


def _push_work(push: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """The part of the parametric work that needs the neighbouring steps; ``push`` is that of the step before."""
    slope, change = motion[2:-1] - motion[1:-2], 0.5 * (push[3:] - push[1:-2])
    return (change * slope - push[2:-1] * _bend(motion)).sum(axis=0) / 12


class _Integrals:
    """Integrals of v = v_0 + dv: start v_0, integral of dv, integral of dv dv^T, length of time."""

    def __init__(self, start: np.ndarray, first: np.ndarray, second: np.ndarray, span: float) -> None:
        self.start, self._first, self._second, self._span = start, first, second, span

    def quadratic(self, matrix: np.ndarray, index: np.ndarray) -> float:
        """Integral of v^T matrix v over the coordinates ``index``."""
        start, first, second = self.start[index], self._first[index], self._second[np.ix_(index, index)]
        return float(self._span * start @ matrix @ start + 2 * start @ matrix @ first + np.sum(matrix * second))


def _energy(part: Part, q: np.ndarray, v: np.ndarray) -> float:
    """Kinetic and strain energy of a linear part."""
    q, v = q[part.index], v[part.index]
    return float(0.5 * v @ part.mass @ v + 0.5 * q @ part.stiffness @ q)
