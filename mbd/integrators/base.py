"""What a time integrator of this package is.

Contract
--------
1. It is made from a `System` and a fixed step h (s): ``METHODS[name](system, h)``. Making it does all work that does
   not depend on the state; it raises StepError if h is outside its range.
2. ``start(state)`` sets the state at t = 0 and returns a `Block` of that one instant.
3. ``advance(angles, speeds, accelerations)`` takes len(angles) steps. ``angles`` and ``speeds`` are those of the motor
   (rad, rad/s) at the end of each step, ``accelerations`` (rad/s2) are held during it. It returns a `Block` of the new
   instants.
4. A state vector x is whatever the method likes; ``displacement`` and ``velocity`` (n, x) turn it into q and q'.
5. ``inverse_mass`` (n, n) gives the accelerations q'' = inverse_mass (f + B^T lambda - M R phi'' - C q' - K q).
6. Nonlinear forces hold at the end of each step to ``TOLERANCE`` of their scale; a step that does not converge raises
   StepError with its time.
7. ``counters`` has "steps" and "iterations" (of all Newton solves).
8. ``flow`` is the `Flow` that the states follow exactly under the held forces of the blocks (the energy books are then
   exact integrals of it), or None (they are sums over the instants).
9. The same input gives the same bits; nothing depends on how steps are cut into blocks.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from mbd.statics import State

TOLERANCE = 1e-7  # states move by 1e-6 of their size against 1e-9


class Block(NamedTuple):
    """Successive instants; the first axis is time."""

    states: np.ndarray  # (instant, x)
    starts: np.ndarray  # (instant, x) at the start of the step that ends here; the state itself at t = 0
    forces: np.ndarray  # (instant, m) residual forces lambda
    rows: np.ndarray  # (instant, m + mesh) row displacements, then observed rows
    log: np.ndarray  # (instant, element, column), see `mbd.forces.LOG_COLUMNS`
    holds: np.ndarray  # (instant, k, m) c_k of lambda = sum_k theta^k c_k, theta 0..1 over the step that ends here


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

    def advance(self, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray) -> Block:
        """Take len(angles) steps."""
