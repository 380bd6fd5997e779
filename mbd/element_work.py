"""Works of the nonlinear elements, logged at every step: meshes and ropes.

An element stores U, receives integral F_t d delta + M_t d psi, dissipates integral (F_t - F) d delta + (M_t - M) d psi
and takes up the parametric work (see `mbd.forces`). Integrals are those of cubics through four instants: per step
mean(F) D delta + (D F mean(D2 delta) - mean(D2 F) D delta)/12 with the first and second differences D, D2; next to a
step of another length only the first term.
"""

from __future__ import annotations

import numpy as np

from mbd.forces import LOG_COLUMNS
from mbd.integrators.base import LENGTH, Block
from mbd.system import System

_FORCE, _MOMENT, _ENERGY, _TOTAL, _, _, _, _PARAMETRIC, _PUSH, _TURN = range(len(LOG_COLUMNS))


class ElementWork:
    """Accumulates the logs of a run's blocks."""

    def __init__(self, system: System) -> None:
        self._system = system
        n = len(system.table.tau) + len(system.table.rope_ea)
        self._log, self._rows = np.zeros((0, n, len(LOG_COLUMNS))), np.zeros((0, len(system.all_rows)))
        self._lengths = np.zeros(0)
        self._first, self._peak = np.zeros(n), np.zeros(n)
        self._received, self._loss, self._parametric = np.zeros(n), np.zeros(n), np.zeros(n)
        self._lost, self._touched = np.zeros(n, dtype=int), np.zeros(n, dtype=int)
        self.throughput = 0.0  # integral of |parametric power|

    def take(self, block: Block) -> None:
        """Add the instants of a block; the three before it are kept."""
        known = len(self._log)
        if known == 0:
            self._first = block.log[0, : len(self._first), _ENERGY].copy()
        log, rows = np.concatenate([self._log, block.log[:, : len(self._first)]]), np.vstack([self._rows, block.rows])
        lengths = np.concatenate([self._lengths, block.clock[:, LENGTH]])
        even = even_steps(lengths)
        loaded = log[max(known - 1, 0) :, :, _FORCE] > 0.0
        self._lost += (loaded[:-1] & ~loaded[1:]).sum(axis=0)
        self._touched += (~loaded[:-1] & loaded[1:]).sum(axis=0)
        self._peak = np.maximum(self._peak, log[:, :, _ENERGY].max(axis=0))
        n = len(self._system.table.tau)
        force, total = log[:, :, _FORCE], log[:, :, _TOTAL]
        arm = np.divide(log[:, :, _MOMENT], force, out=np.zeros_like(total), where=force > 0.0)
        along = np.hstack([rows[:, 0 : 2 * n : 2], rows[:, 2 * n : log.shape[1] + n]])
        tilt = np.zeros_like(along)
        tilt[:, :n] = rows[:, 1 : 2 * n : 2]
        for values, sums in ((total, self._received), (total - force, self._loss)):
            sums += path_work(values, along, known, even) + path_work(values * arm, tilt, known, even)
        parametric = log[known:, :, _PARAMETRIC]
        self._parametric += parametric.sum(axis=0)
        self._parametric += _push_work(log[:, :, _PUSH], along, even) + _push_work(log[:, :, _TURN], tilt, even)
        self.throughput += float(abs(parametric).sum())
        self._log, self._rows, self._lengths = log[-3:].copy(), rows[-3:].copy(), lengths[-3:].copy()

    def books(self) -> dict[str, list[float]]:
        """Stored, dissipated, received, parametric, residual, scale of every mesh and of the rope, J."""
        names = [(mesh.name, slice(2 * i, 2 * i + 2)) for i, mesh in enumerate(self._system.machine.meshes)]
        n = len(self._system.table.tau)
        if len(self._loss) > n:  # vertical ropes
            names.append(("rope", slice(n, len(self._loss))))
        rows = {}
        for name, at in names:
            change = float((self._log[-1, at, _ENERGY] - self._first[at]).sum())
            loss, parametric, received = (float(x[at].sum()) for x in (self._loss, self._parametric, self._received))
            scale = loss if self._damped(name) else float(self._peak[at].max())
            rows[name] = [change, loss, received, parametric, received + parametric - change - loss, scale]
        return rows

    def _damped(self, name: str) -> bool:
        return self._system.reference[name][1] > 0.0

    def events(self) -> dict[str, int]:
        """Contact losses and back-flank contacts of every mesh, slack events of the ropes."""
        result = {}
        for i, mesh in enumerate(self._system.machine.meshes):
            result[f"{mesh.name}:contact_losses"] = int(self._lost[2 * i])
            result[f"{mesh.name}:coast_contacts"] = int(self._touched[2 * i + 1])
        n = len(self._system.table.tau)
        if len(self._lost) > n:
            result["rope:slack_events"] = int(self._lost[n:].sum())
        return result


def even_steps(lengths: np.ndarray) -> np.ndarray:
    """1/12 (step, 1) for every step with two neighbours of its length, else 0, from the lengths of the steps (s)."""
    return ((lengths[1:-2] == lengths[2:-1]) & (lengths[2:-1] == lengths[3:]))[:, None] / 12


def path_work(force: np.ndarray, motion: np.ndarray, known: int, even: np.ndarray) -> np.ndarray:
    """Integral of force d(motion) after the first ``known`` instants; its cubic part lags by one step and is taken
    with the factor ``even``, see `even_steps`."""
    new = slice(max(known - 1, 0), None)
    total = (0.5 * (force[new][1:] + force[new][:-1]) * np.diff(motion[new], axis=0)).sum(axis=0)
    slope = [x[2:-1] - x[1:-2] for x in (force, motion)]
    return total + (even * (slope[0] * _bend(motion) - _bend(force) * slope[1])).sum(axis=0)


def _bend(values: np.ndarray) -> np.ndarray:
    """Mean of the second differences at both ends of every step that has neighbours."""
    return 0.5 * (values[3:] - values[2:-1] - values[1:-2] + values[:-3])


def _push_work(push: np.ndarray, motion: np.ndarray, even: np.ndarray) -> np.ndarray:
    """The part of the parametric work that needs the neighbouring steps; ``push`` is that of the step before."""
    slope, change = motion[2:-1] - motion[1:-2], 0.5 * (push[3:] - push[1:-2])
    return (even * (change * slope - push[2:-1] * _bend(motion))).sum(axis=0)
