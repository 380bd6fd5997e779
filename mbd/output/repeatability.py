"""Repeatability: whether a second computation would give the same waveform, from neighbouring motions.

The neighbour starts from a state changed by a millionth and takes the same cuts of the steps, because different cuts
would separate the two by the error of a step. In a damped machine whose contacts stay closed, or open and close with
the tooth pairs, the two motions converge. In rattle they diverge exponentially (at the largest Lyapunov exponent of
the motion). Once their distance is as large as the signal, no second computation gives the same waveform, be it
with another step, on another computer, or of a gearbox a micrometre different. Only statistics are then meaningful.

Motions diverge only where a contact opens or closes, so no neighbour starts before that, except with rolling elements
or a container that touches the ground. A neighbour is followed while the mean growth of its distance can reach the size
of the signal before the run ends, else dropped; the next one starts when the share of steps followed is below SHARE
again. The motion is unrepeatable if the distance, RMS over a window, has grown 100-fold and to half the RMS of the
signal since the start of the neighbour: this is observed, never extrapolated. Example, one stage in bearings 6205 with
20 um clearance and 2 kg at 3000 rpm: the distance grows by e in 7 ms. With plain bearings and 5 kg contacts also open
and close, but the distance grows by 10 only and then falls by 1000.

References
----------
Benettin, Galgani, Giorgilli & Strelcyn (1980), Meccanica 15, 9-30 (Lyapunov exponents from neighbouring motions).
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbd.integrators.base import Block, Integrator
from mbd.output.recorder import Recorder
from mbd.parts.part_checks import StepError
from mbd.system.statics import State
from mbd.system.system import System

logger = logging.getLogger(__name__)

CHANGE = 1e-6  # of every number of the state
GROWTH = 100.0
PARTED = 0.5  # of the signal
WATCHED = 6  # windows before the growth of a distance is judged
SHARE = 0.1  # of the steps, followed with a neighbour that was dropped
WINDOWS = 200  # windows of a run, over which the distance is averaged
LEAST_WINDOW = 100  # steps
START_CHANGE = 1e-4  # of the displacement at rest, for another start


class Repeatability:
    """Observer of neighbouring motions in a run of ``n_steps`` steps.

    Around every advance, of at most `reach` steps, call `before` and `after` with the number of steps done before it.
    """

    def __init__(self, system: System, recorder: Recorder, step: float, n_steps: int) -> None:
        self._recorder, self._profile, self._step, self._n_steps = recorder, system.machine.profile, step, n_steps
        self._random = np.random.default_rng(0)
        self._window = max(LEAST_WINDOW, n_steps // WINDOWS)
        self._contacts = system.table.row[:-1][system.table.opens == 1]  # rows with a force while in contact
        self._always = any(element.inner_contacts for element in system.elements)
        self._crossed = False  # whether a contact opened or closed in the last block
        self._touching = np.zeros((0, len(self._contacts)), dtype=bool)
        self._state = np.zeros(0)
        self._neighbour: Integrator | None = None
        self._first = 0  # step at which the neighbour started
        self._next = 0 if recorder.signals.size else n_steps  # first step at which the next one may start
        self._own: list[np.ndarray] = []
        self._apart: list[np.ndarray] = []
        self._distances: list[float] = []  # RMS of a window
        self._power = 0.0  # of the signal, sum over the windows
        self.diverged_at, self.rate = 0.0, 0.0  # s and 1/s; 0 if no neighbour diverged

    def reach(self, done: int) -> int:
        """Steps from ``done`` to the end of a window."""
        if self._neighbour is None:
            return self._window
        return self._window - (done - self._first) % self._window

    def before(self, integrator: Integrator, done: int) -> None:
        """Start a neighbour if one is due."""
        if self._neighbour is None and self._crossed and done >= self._next:
            change = CHANGE * self._state * self._random.standard_normal(len(self._state))
            self._neighbour, self._first = integrator.branch(change), done
            self._own, self._apart, self._distances, self._power = [], [], [], 0.0

    def after(self, done: int, steps: int, block: Block) -> None:
        """Advance the neighbour by the ``steps`` after ``done``; ``block`` is the result of the run."""
        touching = np.vstack([self._touching, block.elastic[:, self._contacts] > 0.0])
        self._crossed = self._always or bool((touching[1:] != touching[:-1]).any())
        self._touching, self._state = touching[-1:], block.states[-1]
        if self._neighbour is None:
            return
        try:
            other = self._neighbour.advance(*self._profile.motion(done, steps, self._step), like=block)
        except StepError as error:  # the cuts of one motion may be too coarse for another
            logger.debug("neighbour given up: %s", error)
            self._drop(done + steps)
            return
        own, moved = (self._recorder.unfiltered(one)[self._recorder.signals] for one in (block, other))
        self._own.append(own)
        self._apart.append(moved - own)
        if (done + steps - self._first) % self._window == 0:
            self._judge(done + steps)

    def _judge(self, done: int) -> None:
        """At the end of a window, decide whether the neighbour has diverged, can still do so, or is dropped."""
        own, apart = np.hstack(self._own), np.hstack(self._apart)
        self._own, self._apart = [], []
        self._distances.append(float(np.sqrt(np.mean(apart**2))))
        self._power += float(np.mean(np.var(own, axis=1)))
        first, now, count = self._distances[0], self._distances[-1], len(self._distances)
        goal = max(PARTED * math.sqrt(self._power / count), GROWTH * first)
        if first == 0.0 or done + self._window > self._n_steps:
            self._drop(done)
        elif now >= goal:
            self.diverged_at = done * self._step
            self.rate = math.log(now / first) / ((count - 1) * self._window * self._step)
            self._neighbour, self._next = None, self._n_steps
        elif not may_reach(goal, self._distances, (self._n_steps - done) / self._window):
            self._drop(done)

    def _drop(self, done: int) -> None:
        self._neighbour = None
        self._next = done + round((done - self._first) / SHARE)


def may_reach(goal: float, distances: Sequence[float], left: float) -> bool:
    """Whether a distance may become as large as a goal in the windows that are left, by its mean growth so far.

    The first window, in which the high modes of the change decay, has no weight. Distances scatter from one window to
    the next by a factor, so the first WATCHED decide nothing.
    """
    if len(distances) <= WATCHED:
        return True
    growth = np.polyfit(np.arange(1, len(distances)), np.log(distances[1:]), 1)[0]
    return bool(math.log(distances[-1]) + growth * left >= math.log(goal))


def other_start(system: System, rest: State, number: int) -> State:
    """Start ``number`` near ``rest``: every modal displacement changed by a normal deviate times START_CHANGE."""
    modal = system.basis.T @ (system.mass @ rest.displacement)
    share = START_CHANGE * np.random.default_rng(number).standard_normal(len(modal))
    return replace(rest, displacement=rest.displacement + system.basis @ (share * modal))
