"""The further nonlinear elements of a machine as flat tables and one compiled entry, beside flanks and ropes.

Kinds: ball and roller bearings (5 rows each), mesh efficiency (1), sliding of one flank (2), drag and brake (1),
pendulum rope of one drum (3), ground (1), gyroscopic plane (2). A row r has the linear reference (k0, c0) in the
system's matrices; what is left is lambda = k0 u + c0 u' - F(u, u', angle, speed), as in `mbd.forces`. Its slopes by the
rows ``pattern[r]`` (absolute numbers, -1 unused) are dense, so that the row Newton knows all couplings.

Log columns of an element: elastic force, 0, potential U, dissipated power (W), dU/d angle at fixed rows, then the
parametric work of the step (mean of dU/d angle times the turned angle) and, in the column "push_force", the sum of F
times the rolling rate of its rows per motor angle: the rows of losses, brake and ground move while the machine rolls.
"""

# ruff: noqa: SIM109 - compiled code compares numbers, it does not build tuples
from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import types

from fem.compiled import CUBE, FLOAT, INTEGER, INTEGER_MATRIX, INTEGERS, MATRIX, VECTOR, apart, inner, stored
from fem.contact.kernel import SOURCES as CONTACT
from mbd import hertz
from mbd.hanging import ground_push, rope_pull
from mbd.losses import drag, efficiency_loss, tooth_friction

WIDTH = 6  # columns of a row's slopes
VALUES = 10
BALL, ROLLER, EFFICIENCY, SLIDING, DRAG, PENDULUM, GROUND, GYROSCOPIC = range(8)
ROWS = {BALL: 5, ROLLER: 5, EFFICIENCY: 1, SLIDING: 2, DRAG: 1, PENDULUM: 3, GROUND: 1, GYROSCOPIC: 2}


class Extra(NamedTuple):
    """Constants of the further elements (a tuple that numba reads); empty arrays where there is none."""

    kind: np.ndarray  # (element,)
    at: np.ndarray  # (element,) first row, counted from the first row of all further elements
    flank: np.ndarray  # (element,) flank it reads, -1: none
    values: np.ndarray  # (element, VALUES)
    shares: np.ndarray  # (element with shares, 2, position) of sliding flanks; values[3] is the place
    pattern: np.ndarray  # (row, WIDTH)
    stiffness: np.ndarray  # (row,) reference k0
    damping: np.ndarray  # (row,) reference c0
    scale: np.ndarray  # (row,) force that counts as 1 for convergence
    roll: np.ndarray  # (row,) motion of the row per motor angle when the train rolls


EXTRA = types.NamedTuple(
    (INTEGERS, INTEGERS, INTEGERS, MATRIX, CUBE, INTEGER_MATRIX, VECTOR, VECTOR, VECTOR, VECTOR), Extra
)
_FILES = ("elements", "forces", "hanging", "hertz", "losses", "rows_solver", "integrators/modal_loop")
SOURCES = CONTACT + tuple(Path(__file__).parent / f"{name}.py" for name in _FILES)  # of all that is stored on disk
_bearing = apart(types.UniTuple(FLOAT, 3), VECTOR, FLOAT, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX)
ball_forces, roller_forces = _bearing(hertz.ball_forces), _bearing(hertz.roller_forces)


@apart(types.none, EXTRA, FLOAT, FLOAT, VECTOR, VECTOR, INTEGER, VECTOR, MATRIX, MATRIX, MATRIX, INTEGER)
@stored(SOURCES, entry=False)
def extra_forces(extra, angle, speed, u, v, first, force, slope_u, slope_v, log, n_log):
    """Fill force and slopes of the rows from ``first`` on, and the log from element ``n_log`` on."""
    f3, f5 = np.empty(3), np.empty(5)
    k3, c3, k5, c5 = np.empty((3, 3)), np.empty((3, 3)), np.empty((5, 5)), np.empty((5, 5))
    two, four, one, by = np.empty(2), np.empty(4), np.empty(1), np.empty((2, 2))
    for r in range(first, first + len(extra.pattern)):
        for j in range(WIDTH):
            slope_u[r, j] = 0.0
            slope_v[r, j] = 0.0
    for e in range(len(extra.kind)):
        kind, r, values, k = extra.kind[e], first + extra.at[e], extra.values[e], n_log + e
        log[k, 0], log[k, 1], log[k, 2], log[k, 3], log[k, 4] = 0.0, 0.0, 0.0, 0.0, 0.0
        if kind == BALL or kind == ROLLER:
            if kind == BALL:
                energy, power, turned = ball_forces(values, angle, u[r : r + 5], v[r : r + 5], f5, k5, c5)
            else:
                energy, power, turned = roller_forces(values, angle, u[r : r + 5], v[r : r + 5], f5, k5, c5)
            _own(extra, u, v, first, r, 5, f5, k5, c5, force, slope_u, slope_v)
            log[k, 0], log[k, 2] = (f5[0] ** 2 + f5[1] ** 2 + f5[2] ** 2) ** 0.5, energy
            log[k, 3], log[k, 4] = power, turned
        elif kind == PENDULUM:
            elastic, energy, power, turned = rope_pull(values, angle, u[r : r + 3], v[r : r + 3], f3, k3, c3)
            _own(extra, u, v, first, r, 3, f3, k3, c3, force, slope_u, slope_v)
            log[k, 0], log[k, 2], log[k, 3], log[k, 4] = elastic, energy, power, turned
        elif kind == GROUND:
            push, stiff, damp, elastic, energy, power = ground_push(values, angle, speed, u[r], v[r])
            force[r] = -push
            slope_u[r, 0], slope_v[r, 0] = -stiff, -damp
            log[k, 0], log[k, 2], log[k, 3] = elastic, energy, power
        elif kind == DRAG:
            torque, slope, power = drag(values, speed, v[r])
            force[r] = -torque
            slope_v[r, 0] = -slope
            log[k, 0], log[k, 3] = abs(torque), power
        elif kind == EFFICIENCY:
            f = extra.flank[e]
            torque, power = efficiency_loss(
                values, speed, v[r], log[f : f + 2, 0], log[f : f + 2, 4], log[f : f + 2, 5], four, one
            )
            force[r] = -torque
            for j in range(4):
                slope_u[r, j] = -four[j]
            slope_v[r, 4] = -one[0]
            log[k, 0], log[k, 3] = abs(torque), power
        elif kind == SLIDING:
            f = extra.flank[e]
            shares = extra.shares[int(values[3])]
            cycle = values[4] + values[5] * angle
            power = tooth_friction(
                values, shares, cycle, speed, v[r], v[r + 1], log[f, 0], log[f, 4], log[f, 5], f3, by, two
            )
            for i in range(2):
                force[r + i] = -f3[i]
                slope_u[r + i, 0], slope_u[r + i, 1] = -by[i, 0], -by[i, 1]
                slope_v[r + i, 2] = -two[i]
            log[k, 0], log[k, 3] = abs(f3[0]), power
        else:  # a gyroscopic plane
            g = values[0] * speed
            force[r], force[r + 1] = -g * v[r + 1], g * v[r]
            slope_v[r, 1], slope_v[r + 1, 0] = -g, g
        push = 0.0
        for i in range(_rows(kind)):
            at = extra.at[e] + i
            push += extra.roll[at] * (extra.stiffness[at] * u[r + i] + extra.damping[at] * v[r + i] - force[r + i])
        log[k, 8] = push


@inner()
def _rows(kind):
    if kind == BALL or kind == ROLLER:
        return 5
    if kind == PENDULUM:
        return 3
    return 2 if kind == SLIDING or kind == GYROSCOPIC else 1


@inner()
def _own(extra, u, v, first, r, n, restoring, stiff, loss, force, slope_u, slope_v):
    """An element that reads nothing but its own rows."""
    for i in range(n):
        at = r + i - first
        k0, c0 = extra.stiffness[at], extra.damping[at]
        force[r + i] = k0 * u[r + i] + c0 * v[r + i] - restoring[i]
        for j in range(n):
            slope_u[r + i, j] = -stiff[i, j]
            slope_v[r + i, j] = -loss[i, j]
        slope_u[r + i, i] += k0
        slope_v[r + i, i] += c0


@apart(types.none, EXTRA, FLOAT, FLOAT, MATRIX, MATRIX, INTEGER)
@stored(SOURCES, entry=False)
def extra_work(extra, before, after, log_before, log_after, n_log):
    """Fill the parametric work of the step from motor angle ``before`` to ``after`` (rad)."""
    for e in range(len(extra.kind)):
        k = n_log + e
        log_after[k, 7] = 0.5 * (log_before[k, 4] + log_after[k, 4]) * (after - before)
        log_after[k, 9] = 0.0


@apart(types.none, EXTRA, FLOAT, VECTOR, VECTOR, INTEGER, VECTOR, MATRIX, INTEGER)
@stored(SOURCES, entry=False)
def extra_follow(extra, speed, u, v, first, force, log, n_log):
    """Lost power and rolling force of losses, brake and ground anew, where the solution ``force`` is known."""
    for e in range(len(extra.kind)):
        kind = extra.kind[e]
        if kind == EFFICIENCY or kind == SLIDING or kind == DRAG or kind == GROUND:
            push, power = 0.0, 0.0
            for i in range(_rows(kind)):
                at = extra.at[e] + i
                r = first + at
                total = extra.stiffness[at] * u[r] + extra.damping[at] * v[r] - force[r]
                push += extra.roll[at] * total
                power += total * (v[r] + extra.roll[at] * speed)
            log[n_log + e, 8] = push
            if kind != GROUND:
                log[n_log + e, 3] = power
