"""Works of the nonlinear elements, logged at every step.

An element stores U, receives the integral of F . d(motion of its rows), loses that of the part of F that follows from
no potential, and takes up the parametric work. That of an audited element is the change of U less the work of the
elastic part of F, less the defects of the audit (see `mbd.elements.element`). The rows of elements that roll move with
the train besides. Integrals over the rows are those of cubics through four instants: per step
mean(F) D u + (D F mean(D2 u) - mean(D2 F) D u)/12 with the first and second differences D, D2; next to a step of
another length only the first term.
"""

from __future__ import annotations

import numpy as np

from mbd.elements.element import ENERGY, LOG_COLUMNS, PARAMETRIC
from mbd.integrators.base import ANGLE, LENGTH, Block
from mbd.system.system import System

LOST = 1e-9  # of the stored energy: if a part dissipates less, its residual is compared with its stored energy


class ElementWork:
    """Accumulates the blocks of a run; ``throughput`` is the integral of |power| that parameters and torques on the
    rolling train bring or take."""

    def __init__(self, system: System) -> None:
        self._elements, self._rolls = system.elements, system.rolls
        n, m = len(system.elements), len(system.rows)
        counts = np.diff(system.table.row)
        self._owner = np.repeat(np.arange(n), counts)
        self._opening = np.flatnonzero(system.table.opens)
        self._audited, self._first_rows = system.table.audited == 1, system.table.row[:-1]
        self._contact_rows = system.table.row[self._opening]
        # rows, elastic forces, lost forces of the last three instants
        self._known = [np.zeros((0, m)) for _ in range(3)]
        self._log, self._clock = np.zeros((0, n, len(LOG_COLUMNS))), np.zeros((0, 4))
        self._start, self._peak, self._parametric = np.zeros(n), np.zeros(n), np.zeros(n)
        self._received, self._loss = np.zeros(m), np.zeros(m)
        self._let_go = np.zeros(len(self._opening), dtype=int)
        self._touched = np.zeros(len(self._opening), dtype=int)
        self._open = np.zeros(len(self._opening))  # s
        self.throughput = 0.0

    def take(self, block: Block) -> None:
        """Add the instants of a block; the three before it are kept."""
        known = len(self._log)
        if known == 0:
            self._start = block.log[0, :, ENERGY].copy()
        fresh = block.rows[:, : len(self._received)], block.elastic, block.lost
        rows, elastic, lost = (np.vstack(pair) for pair in zip(self._known, fresh, strict=True))
        log, clock = np.concatenate([self._log, block.log]), np.vstack([self._clock, block.clock])
        new, even = slice(max(known - 1, 0), None), even_steps(clock[:, LENGTH])
        loaded = elastic[new][:, self._contact_rows] > 0.0
        self._let_go += (loaded[:-1] & ~loaded[1:]).sum(axis=0)
        self._touched += (~loaded[:-1] & loaded[1:]).sum(axis=0)
        self._open += (~loaded[1:] * clock[new][1:, LENGTH, None]).sum(axis=0)
        turned = np.diff(clock[new, ANGLE])
        for force, sums in ((elastic + lost, self._received), (lost, self._loss)):
            sums += _path_work(force, rows, known, even) + self._rolling_work(force[new], turned)
        self.throughput += float(abs(self._rolling_work(lost[new], turned)).sum())
        parametric = log[known:, :, PARAMETRIC]
        self._parametric += parametric.sum(axis=0)
        work = 0.5 * (elastic[new][1:] + elastic[new][:-1]) * np.diff(rows[new], axis=0)
        left = np.diff(log[new, :, ENERGY], axis=0) - np.add.reduceat(work, self._first_rows, axis=1)
        audited = self._audited[None, :]
        self.throughput += float(np.where(audited, abs(left), abs(parametric[-len(left) :])).sum())
        self._peak = np.maximum(self._peak, log[new, :, ENERGY].max(axis=0))
        self._known = [values[-3:].copy() for values in (rows, elastic, lost)]
        self._log, self._clock = log[-3:].copy(), clock[-3:].copy()

    def _rolling_work(self, force: np.ndarray, turned: np.ndarray) -> np.ndarray:
        """Work (row,) of forces (instant, row) on the rolling train; ``turned`` (step,) rad between the instants."""
        return self._rolls * (0.5 * turned @ (force[1:] + force[:-1]))

    def entries(self) -> dict[str, list[float]]:
        """Stored, dissipated, received, parametric, residual, scale of every part, J."""
        n = len(self._elements)
        received, loss = (np.bincount(self._owner, values, minlength=n) for values in (self._received, self._loss))
        change = self._log[-1, :, ENERGY] - self._start
        parametric = np.where(self._audited, change - (received - loss) - self._parametric, self._parametric)
        rows = {}
        for part in dict.fromkeys(element.part for element in self._elements if element.part):
            own = np.array([element.part == part for element in self._elements])
            sums = [float(values[own].sum()) for values in (change, loss, received, parametric)]
            stored, dissipated, taken, by_parameter = sums
            peak = float(self._peak[own].max())
            scale = dissipated if dissipated > LOST * peak else peak
            rows[part] = [*sums, taken + by_parameter - stored - dissipated, scale]
        return rows

    def events(self) -> dict[str, int]:
        """Contacts lost and made, by the counters that the elements name, and us without contact of those that hold the
        train."""
        found: dict[str, int] = {}
        for k, i in enumerate(self._opening):
            element = self._elements[i]
            for name, count in ((element.contact_lost, self._let_go[k]), (element.contact_made, self._touched[k])):
                if name:
                    found[name] = found.get(name, 0) + int(count)
            if element.contact is not None and element.contact.side == 0:
                found[f"{element.contact.name}:microseconds_open"] = round(1e6 * float(self._open[k]))
        return found


def even_steps(lengths: np.ndarray) -> np.ndarray:
    """1/12 (step, 1) for every step with two neighbours of its length, else 0, from the lengths of the steps (s)."""
    return ((lengths[1:-2] == lengths[2:-1]) & (lengths[2:-1] == lengths[3:]))[:, None] / 12


def _path_work(force: np.ndarray, motion: np.ndarray, known: int, even: np.ndarray) -> np.ndarray:
    """Integral of force d(motion) after the first ``known`` instants; its cubic part lags by one step and is taken
    with the factor ``even``, see `even_steps`."""
    new = slice(max(known - 1, 0), None)
    total = (0.5 * (force[new][1:] + force[new][:-1]) * np.diff(motion[new], axis=0)).sum(axis=0)
    slope = [x[2:-1] - x[1:-2] for x in (force, motion)]
    return total + (even * (slope[0] * _bend(motion) - _bend(force) * slope[1])).sum(axis=0)


def _bend(values: np.ndarray) -> np.ndarray:
    """Mean of the second differences at both ends of every step that has neighbours."""
    return 0.5 * (values[3:] - values[2:-1] - values[1:-2] + values[:-3])
