"""Works of the further elements (`mbd.elements`): bearings with rolling elements, losses, brake, pendulum rope, ground.

An element stores U, receives the integral of F . d(motion of its rows, rolling included), loses its logged power and
takes up the parametric work of the turning cage or of the winding rope. Gyroscopic planes do no work.
"""

from __future__ import annotations

import numpy as np

from mbd.element_work import even_steps, path_work
from mbd.integrators.base import ANGLE, LENGTH, Block, Integrator
from mbd.system import System

_ENERGY, _POWER, _PARAMETRIC, _PUSH = 2, 3, 7, 8


class FurtherWork:
    """Accumulates the logs of a run's blocks; ``throughput`` is the integral of |parametric power|."""

    def __init__(self, system: System, integrator: Integrator) -> None:
        extra, self._names = system.table.extra, system.element_names
        n, rows = len(extra.kind), len(extra.pattern)
        self._first_row, self._first = len(system.rows) - rows, len(system.table.tau) + len(system.table.rope_ea)
        self._velocity = system.rows[self._first_row :] @ integrator.velocity
        self._stiffness, self._damping = extra.stiffness, extra.damping
        self._owner = np.repeat(np.arange(n), np.diff(np.append(extra.at, rows))) if n else np.zeros(0, dtype=int)
        self._log, self._rows, self._force = np.zeros((0, n, 4)), np.zeros((0, rows)), np.zeros((0, rows))
        self._clock = np.zeros((0, 4))
        self._start, self._peak, self._loss, self._parametric, self._rolled = (np.zeros(n) for _ in range(5))
        self._received = np.zeros(rows)
        self.throughput = 0.0

    def take(self, block: Block) -> None:
        """Add the instants of a block; the three before it are kept."""
        if not self._names:
            return
        known = len(self._log)
        at = slice(self._first_row, self._first_row + self._velocity.shape[0])
        rows = block.rows[:, at]
        force = self._stiffness * rows + self._damping * (block.states @ self._velocity.T) - block.forces[:, at]
        fresh = block.log[:, self._first :, [_ENERGY, _POWER, _PARAMETRIC, _PUSH]]
        if known == 0:
            self._start = fresh[0, :, 0].copy()
        log = np.concatenate([self._log, fresh])
        rows, force = np.vstack([self._rows, rows]), np.vstack([self._force, force])
        clock = np.vstack([self._clock, block.clock])
        new = slice(max(known - 1, 0), None)
        self._received += path_work(force, rows, known, even_steps(clock[:, LENGTH]))
        power, push = log[new, :, 1], log[new, :, 3]
        self._loss += 0.5 * clock[new, LENGTH][1:] @ (power[1:] + power[:-1])
        self._rolled += (0.5 * (push[1:] + push[:-1]) * np.diff(clock[new, ANGLE])[:, None]).sum(axis=0)
        self._parametric += log[known:, :, 2].sum(axis=0)
        self.throughput += float(abs(log[known:, :, 2]).sum())
        self._peak = np.maximum(self._peak, log[:, :, 0].max(axis=0))
        self._log, self._rows, self._force, self._clock = (x[-3:].copy() for x in (log, rows, force, clock))

    def books(self) -> dict[str, list[float]]:
        """Stored, dissipated, received, parametric, residual, scale of every part, J."""
        received = self._rolled + np.bincount(self._owner, self._received, minlength=len(self._rolled))
        rows: dict[str, list[float]] = {}
        for name in dict.fromkeys(self._names):
            if name == "gyroscopic":
                continue
            at = np.array([other == name for other in self._names])
            change = float((self._log[-1, at, 0] - self._start[at]).sum()) if len(self._log) else 0.0
            loss, parametric, taken = (float(x[at].sum()) for x in (self._loss, self._parametric, received))
            scale = loss if loss > 0.0 else float(self._peak[at].sum())
            rows[name] = [change, loss, taken, parametric, taken + parametric - change - loss, scale]
        return rows
