"""What a time integrator of this package is.

Contract
--------
1. It is made from a `System` and a fixed step h (s), see `mbd.integrators.methods`. Making it does all work that does
   not depend on the state; it raises StepError if h is outside its range.
2. ``start(state)`` sets the state at t = 0 and returns a `Block` of that one instant.
3. ``advance(angles, speeds, accelerations)`` takes len(angles) steps. ``angles`` and ``speeds`` are those of the motor
   (rad, rad/s) at the end of each step, ``accelerations`` (rad/s2) are held during it. It returns a `Block` of the new
   instants; a method may cut steps, ``whole`` then names the instants that end the steps asked for.
4. A state vector x is whatever the method likes; ``displacement`` and ``velocity`` (n, x) turn it into q and q'.
5. ``inverse_mass`` (n, n) gives the accelerations q'' = inverse_mass (f + B^T lambda - M R phi'' - C q' - K q).
6. Nonlinear forces hold at the end of each step to ``TOLERANCE`` of their scale, or to less than the error of the step
   (`mbd.elements.newton`); a step that does not converge raises StepError with its time.
7. ``counters`` has "steps" (whole ones), "cuts" (instants beyond the whole steps) and "iterations" (Newton solves).
8. ``flow`` is the `Flow` that the states follow exactly under the held forces of the blocks (the energy balance is then
   made of exact integrals), or None (it is made of sums over the instants).
9. The same input gives the same bits; nothing depends on how steps are cut into blocks.
10. ``branch(change)`` is a second integrator of this kind at the same instant, its state moved by ``change`` (x,); the
   two go on independently. ``advance(..., like=block)`` cuts the steps as those of ``block`` (the same instants of the
   motion that it was branched from) were cut: cuts of its own would part two neighbours by the error of a step.
11. ``halved()`` is a second integrator of this kind at the same instant with half the step: it takes two steps for one.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from mbd.system.statics import State

TOLERANCE = 1e-7  # states move by 1e-6 of their size against 1e-9


LENGTH, ANGLE, SPEED, ACCELERATION = range(4)  # columns of a block's clock: s, rad, rad/s, rad/s2


def uniform_clock(step: float, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray) -> np.ndarray:
    """The clock (step, 4) of steps that are all whole.

    Parameters
    ----------
    step : length of a step, s
    angles, speeds : (step,) of the motor at the end of each step, rad and rad/s
    accelerations : (step,) of the motor during it, rad/s2
    """
    return np.column_stack([np.full(len(angles), step), angles, speeds, accelerations])


class Block(NamedTuple):
    """Successive instants; the first axis is time."""

    states: np.ndarray  # (instant, x)
    starts: np.ndarray  # (instant, x) at the start of the step that ends here; the state itself at t = 0
    forces: np.ndarray  # (instant, m) residual forces lambda
    rows: np.ndarray  # (instant, m + observed) row displacements, then observed rows
    elastic: np.ndarray  # (instant, m) part of the real forces that follows from the potentials of the elements
    lost: np.ndarray  # (instant, m) the rest of the real forces
    log: np.ndarray  # (instant, element, column), see `mbd.elements.element.LOG_COLUMNS`
    clock: np.ndarray  # (instant, 4) CLOCK: step that ends here, motor angle, speed, acceleration held before
    whole: np.ndarray  # (whole step,) int, its last instant
    holds: np.ndarray  # (instant, k, m) c_k of lambda = sum_k theta^k c_k, theta 0..1 over the step that ends here


def join(blocks: list[Block]) -> Block:
    """One block of successive ones."""
    if len(blocks) == 1:
        return blocks[0]
    before = np.cumsum([0] + [len(block.states) for block in blocks])
    columns = {name: np.concatenate([getattr(block, name) for block in blocks]) for name in Block._fields}
    columns["whole"] = np.concatenate([block.whole + n for block, n in zip(blocks, before[:-1], strict=True)])
    return Block(**columns)


class Flow(NamedTuple):
    """eta' = values eta + rows lambda + load + ramp phi'', complex; a state is (Re eta, Im eta)."""

    values: np.ndarray  # (mode,)
    rows: np.ndarray  # (mode, m)
    load: np.ndarray  # (mode,)
    ramp: np.ndarray  # (mode,)


class Integrator(Protocol):
    """The contract above as a type."""

    displacement: np.ndarray
    velocity: np.ndarray
    inverse_mass: np.ndarray
    flow: Flow | None
    counters: dict[str, int]

    def start(self, state: State) -> Block:
        """Set the state at t = 0."""

    def advance(
        self, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray, like: Block | None = None
    ) -> Block:
        """Take len(angles) steps.

        Parameters
        ----------
        angles, speeds : (step,) of the motor at the end of each step, rad and rad/s
        accelerations : (step,) of the motor during it, rad/s2
        like : block whose cuts of the same steps are taken, or None
        """

    def branch(self, change: np.ndarray) -> Integrator:
        """A second integrator at this instant, its state moved by ``change`` (x,)."""

    def halved(self) -> Integrator:
        """A second integrator at this instant with half the step."""
