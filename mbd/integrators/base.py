"""Contract that every time integrator of this package fulfils.

Contract
--------
1. It is made from a `System` and a fixed step h (s), see `mbd.integrators.methods`. Making it does all work that does
   not depend on the state; it raises StepError if h is outside its range.
2. ``start(state)`` sets the state at t = 0 and returns a `Block` of that one instant.
3. ``advance(angles, speeds, accelerations)`` takes len(angles) steps. ``angles`` and ``speeds`` are those of the motor
   (rad, rad/s) at the end of each step, ``accelerations`` (rad/s2) are constant during it. It returns a `Block` of the
   new instants; a method may cut steps (`mbd.integrators.modal_loop`), ``whole`` then gives the instants at the ends
   of the given steps.
4. The method chooses the meaning of a state vector x; ``displacement`` and ``velocity`` (n, x) convert it to q and q'.
5. ``inverse_mass`` (n, n) gives the accelerations q'' = inverse_mass (f + B^T lambda - M R phi'' - C q' - K q).
6. Nonlinear forces agree with the motion at the end of each step to ``TOLERANCE`` of their scale, or to less than the
   error of the step (`mbd.elements.newton`); a step that does not converge raises StepError with its time.
7. ``counters`` has "steps" (whole steps), "cuts" (further instants) and "iterations" (Newton solves).
8. ``flow`` is the `Flow` that the states follow exactly under the polynomial forces of the blocks (the energy balance
   then uses exact integrals), or None (it uses sums over the instants).
9. The same input gives the same bits; nothing depends on how steps are divided into blocks.
10. ``branch(change)`` is a second integrator of this kind at the same instant, its state changed by ``change`` (x,);
   the two then continue independently. ``advance(..., like=block)`` cuts the steps as those of ``block`` (the same
   instants of the original motion) were cut: different cuts would separate two neighbours by the error of a step.
11. ``halved()`` is a second integrator of this kind at the same instant with half the step: it takes two steps for one.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from mbd.system.statics import State

TOLERANCE = 1e-7  # changes the states by 1e-6 of their size, compared with 1e-9


LENGTH, ANGLE, SPEED, ACCELERATION = range(4)  # columns of a block's clock: s, rad, rad/s, rad/s2


def uniform_clock(step: float, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray) -> np.ndarray:
    """Clock (step, 4) of steps that are not cut.

    Parameters
    ----------
    step : length of a step, s
    angles, speeds : (step,) of the motor at the end of each step, rad and rad/s
    accelerations : (step,) of the motor during it, rad/s2
    """
    return np.column_stack([np.full(len(angles), step), angles, speeds, accelerations])


class Block(NamedTuple):
    """States, forces and row motions of successive instants; the first axis is time."""

    states: np.ndarray  # (instant, x)
    starts: np.ndarray  # (instant, x) at the start of the step that ends here; the state itself at t = 0
    forces: np.ndarray  # (instant, m) residual forces lambda
    rows: np.ndarray  # (instant, m + observed) row displacements, then observed rows
    elastic: np.ndarray  # (instant, m) part of the real forces that follows from the potentials of the elements
    lost: np.ndarray  # (instant, m) the rest of the real forces
    log: np.ndarray  # (instant, element, column), see `mbd.elements.element.LOG_COLUMNS`
    clock: np.ndarray  # (instant, 4) step that ends here, motor angle, speed, and acceleration during this step
    whole: np.ndarray  # (whole step,) int, its last instant
    holds: np.ndarray  # (instant, k, m) c_k of lambda = sum_k theta^k c_k, theta 0..1 over the step that ends here


def join(blocks: list[Block]) -> Block:
    """Join successive blocks into one."""
    if len(blocks) == 1:
        return blocks[0]
    before = np.cumsum([0] + [len(block.states) for block in blocks])
    columns = {name: np.concatenate([getattr(block, name) for block in blocks]) for name in Block._fields}
    columns["whole"] = np.concatenate([block.whole + n for block, n in zip(blocks, before[:-1], strict=True)])
    return Block(**columns)


class Flow(NamedTuple):
    """Modal equation eta' = values eta + rows lambda + load + ramp phi'', complex; a state is (Re eta, Im eta)."""

    values: np.ndarray  # (mode,)
    rows: np.ndarray  # (mode, m)
    load: np.ndarray  # (mode,)
    ramp: np.ndarray  # (mode,)


class Integrator(Protocol):
    """Type of an integrator that fulfils the contract above."""

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
        like : block of the same steps whose cuts are repeated, or None
        """

    def branch(self, change: np.ndarray) -> Integrator:
        """A second integrator at this instant, its state changed by ``change`` (x,)."""

    def halved(self) -> Integrator:
        """A second integrator at this instant with half the step."""
