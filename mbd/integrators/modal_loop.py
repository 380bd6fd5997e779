"""Time loop over complex modes with step refinement, compiled; arrays over modes hold (Re, Im) halves.

See `mbd.integrators.modal` for the method.

Refinement: the forces extrapolated to the end of a step are compared with the forces at the motion that they cause.
A step is repeated in quarters if they differ by more than ROUGH of their scale, if a contact opens or closes, or if it
does not converge, and so on down to the shortest length (level), which is not cut further. Lengths increase
again, where a step of the longer length may begin, once the difference is below SMOOTH. Exact coefficients are stored
for every length, so that a cut costs only its evaluations. A motion that is compared with another one takes the lengths
of that one: different cuts would separate them by the error of a step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types

from fem.numerics.compiled import CUBE, FLOAT, HYPERCUBE, INTEGER, INTEGERS, MATRIX, VECTOR, stored
from fem.numerics.inner_functions import UNCOUNTED, inner
from mbd.elements.element import AUDIT_STEPS, WIDTH
from mbd.elements.element_table import INSTANT, TABLE, Instant, contact_changed, parametric_work
from mbd.elements.newton import NEAR, WORKSPACE, Workspace, iterate, workspace
from mbd.integrators.base import Block
from mbd.system.rolling_frame import RollingFrame, frame_acceleration

QUARTERS = 4
ROUGH, SMOOTH = 0.025, 0.005


class Constants(NamedTuple):
    """Constants of the loop; holds: 0 linear, 1 after an equal step, 2 and 3 after a shorter and a longer step."""

    length: np.ndarray  # (level,) s
    growth: np.ndarray  # (level, 2 mode) e^(lambda h)
    rate: np.ndarray  # (2 mode,) lambda
    weights: np.ndarray  # (level, hold, s, 2 mode)
    powers: np.ndarray  # (hold, k, s)
    load: np.ndarray  # (level, 2 mode) change of the state in a step by the constant load
    ramp: np.ndarray  # (level, 2 mode) change of the state in a step per unit of motor acceleration
    enter: np.ndarray  # (m, 2 mode) modal force per row force
    rows: np.ndarray  # (m + observed, 2 mode) row displacements
    g_u: np.ndarray  # (level, hold, m + observed, m)
    g_v: np.ndarray  # (level, hold, m, m)
    frame: RollingFrame


class Memory(NamedTuple):
    """Data of a step that the next one needs; overwritten in place."""

    state: np.ndarray  # (2 mode,)
    forces: np.ndarray  # (3, m) of the last instants, newest first
    pushes: np.ndarray  # (s, 2 mode) modal forces of the last instants, newest first
    past: np.ndarray  # (2,) lengths of the last two steps, s
    counts: np.ndarray  # (4,) int: steps since a contact changed, level to try, level of the last step, all steps
    motor: np.ndarray  # (3,) angle, speed, time
    rows: np.ndarray  # (m + observed,)
    elements: Instant  # their answers


class Room(NamedTuple):
    """Arrays for intermediate results of a step."""

    u: np.ndarray  # (m + observed,) displacements without the new forces
    v_without: np.ndarray  # (m,) their rates
    v: np.ndarray  # (m,) rates with them
    guess: np.ndarray  # (m,) forces
    moving: np.ndarray  # (2 mode,) rates of the modes without the new forces
    stiffness: np.ndarray  # (m, WIDTH); this and the next two are those of an `Instant`
    frozen: np.ndarray
    frozen_stiffness: np.ndarray
    work: Workspace


def room(m: int, n_rows: int, size: int) -> Room:
    """Arrays for m forces, n_rows rows and a state of `size` numbers."""
    slopes = np.empty((2, m, WIDTH))
    return Room(
        np.empty(n_rows), np.empty(m), np.empty(m), np.empty(m), np.empty(size), slopes[0], np.empty(m), slopes[1],
        workspace(m),
    )  # fmt: skip


_FRAME = types.NamedTuple((INTEGER, FLOAT, VECTOR), RollingFrame)
_CONSTANTS = types.NamedTuple(
    (VECTOR, MATRIX, VECTOR, HYPERCUBE, CUBE, MATRIX, MATRIX, MATRIX, MATRIX, HYPERCUBE, HYPERCUBE, _FRAME), Constants
)
_MEMORY = types.NamedTuple((VECTOR, MATRIX, MATRIX, VECTOR, INTEGERS, VECTOR, VECTOR, INSTANT), Memory)
_ROOM = types.NamedTuple((*[VECTOR] * 5, MATRIX, VECTOR, MATRIX, WORKSPACE), Room)
_BLOCK = types.NamedTuple((*[MATRIX] * 6, CUBE, MATRIX, INTEGERS, CUBE), Block)


def compile_loop() -> None:
    """Compile the loop and the iteration in it, or read them from disk: they are the same for every machine."""
    iterate.compile()
    advance_modes.compile((TABLE, INTEGER, VECTOR, VECTOR, _CONSTANTS, _MEMORY, _BLOCK, FLOAT, INTEGERS, _ROOM))


@inner(fastmath={"reassoc", "contract", "nsz"})
def _dots(a, b, c):
    """a . b and a . c; computing both at once reads the long rows of modes only once."""
    first = second = 0.0
    for j in range(len(a)):
        first += a[j] * b[j]
        second += a[j] * c[j]
    return first, second


@inner(fastmath={"contract"})
def _add_rows(target, factors, rows):
    """target += factors @ rows, without the factors that are 0; two rows at once read and write ``target`` half as
    often."""
    waiting = -1
    for r in range(len(factors)):
        if factors[r] != 0.0:
            if waiting < 0:
                waiting = r
            else:
                one, other = factors[waiting], factors[r]
                for j in range(len(target)):
                    target[j] += one * rows[waiting, j] + other * rows[r, j]
                waiting = -1
    if waiting >= 0:
        for j in range(len(target)):
            target[j] += factors[waiting] * rows[waiting, j]


@inner(fastmath={"contract"})
def _free_step(before, growth, load, ramp, acceleration, after):
    """after = E before + the contribution of the prescribed forces."""
    n = len(before) // 2
    for j in range(n):
        r, i, er, ei = before[j], before[n + j], growth[j], growth[n + j]
        after[j] = er * r - ei * i + load[j] + acceleration * ramp[j]
        after[n + j] = er * i + ei * r + load[n + j] + acceleration * ramp[n + j]


@inner(fastmath={"contract"})
def _add_product(target, weight, push):
    """target += weight * push, complex."""
    n = len(target) // 2
    for j in range(n):
        wr, wi, pr, pi = weight[j], weight[n + j], push[j], push[n + j]
        target[j] += wr * pr - wi * pi
        target[n + j] += wr * pi + wi * pr


@inner()
def _extrapolate(forces, past, smooth, h, guess):
    """Forces h after the last instant: the parabola, line or constant through up to three instants without a contact
    change between them."""
    near, far = past[0], past[0] + past[1]
    a, b, c = 1.0, 0.0, 0.0
    if smooth >= 2:
        a = (h + near) * (h + far) / (near * far)
        b = -h * (h + far) / (near * past[1])
        c = h * (h + near) / (far * past[1])
    elif smooth == 1:
        a, b = 1.0 + h / near, -h / near
    for r in range(len(guess)):
        guess[r] = a * forces[0, r] + b * forces[1, r] + c * forces[2, r]


@inner()
def _turn(frame, powers, past_forces, force, motor, h):
    """Angle, speed and mean acceleration of a free frame a step h after the last instant, see `frame_acceleration`."""
    mean, early = frame_acceleration(frame, powers, past_forces, force)
    return motor[0] + h * (motor[1] + h * early), motor[1] + h * mean, mean


@inner()
def _choose_hold(counts, level, n_past):
    """Number of the hold: linear after a contact change or a step more than four times as long or as short."""
    apart = counts[2] - level
    if counts[0] < n_past - 2 or apart > 1 or apart < -1:
        return 0
    return 1 if apart == 0 else (2 if apart == 1 else 3)


@inner()
def _remember(h, weight, powers, enter, memory, level, kink, eta, force, row_values, now, held):
    """Finish a step of length h: contribution of its new forces to the state, polynomials of the forces, memory."""
    state, forces, pushes, past, counts, _, rows, last = memory
    n_past = len(pushes)
    for s in range(n_past - 1, 0, -1):
        for j in range(len(eta)):
            pushes[s, j] = pushes[s - 1, j]
    for j in range(len(eta)):
        pushes[0, j] = 0.0
    _add_rows(pushes[0], force, enter)
    _add_product(eta, weight, pushes[0])
    for r in range(len(force)):
        for k in range(n_past):
            held[k, r] = powers[k, 0] * force[r]
            for s in range(1, n_past):
                held[k, r] += powers[k, s] * forces[s - 1, r]
        forces[2, r], forces[1, r], forces[0, r] = forces[1, r], forces[0, r], force[r]
    counts[0] = 0 if kink else counts[0] + 1
    counts[2], counts[3] = level, counts[3] + 1
    past[1], past[0] = past[0], h
    for r in range(len(rows)):
        rows[r] = row_values[r]
    for r in range(len(force)):
        last.elastic[r] = now.elastic[r]
        for j in range(WIDTH):
            last.stiffness[r, j] = now.stiffness[r, j]
    for k in range(len(last.log)):
        for j in range(last.log.shape[1]):
            last.log[k, j] = now.log[k, j]
    for j in range(len(eta)):
        state[j] = eta[j]


@stored(__file__, **UNCOUNTED)
def advance_modes(table, first, angles, accelerations, constants, memory, block, tolerance, plan, arrays):
    """Take steps while the block has room: next step, instants and iterations taken, True if a step failed.

    Parameters
    ----------
    table : elements of the machine
    first : number of the first step to take
    angles : (step,) of the motor at the end of each step, rad
    accelerations : (step,) of the motor during it, rad/s2; a free frame uses neither
    constants, memory : `Constants`, and the `Memory` of the last step (changed in place)
    block : `mbd.integrators.base.Block` with room for the instants of one step or more, filled in
    tolerance : of the forces, in units of their scale
    plan : (instant,) int, levels to take, or (0,): chosen by the difference of the forces
    arrays : `Room` for intermediate results
    """
    length, growth, rate, weights, powers, load, ramp, enter, rows, g_u, g_v, frame = constants
    state, past_forces, pushes, past, counts, motor, last_rows, last = memory
    states, _, forces, row_values, elastic, lost, log, clock, whole, holds = block
    m, n_rows, n_past, finest = len(enter), len(rows), len(pushes), len(length) - 1
    units = QUARTERS**finest
    u_p, v_p, v, guess, moving, stiffness, frozen, frozen_stiffness, work = arrays
    iterations, n = 0, 0
    planned = len(plan) > 0
    for i in range(first, len(angles)):
        if n + units > len(states):
            return i, n, iterations, False
        angle_0, speed_0, a, position = motor[0], motor[1], 0.0 if frame.free == 1 else accelerations[i], 0
        mismatch = angles[i] - angle_0 - length[0] * (speed_0 + 0.5 * a * length[0])  # a kink of the speed table
        while position < units:
            level = plan[n] if planned else counts[1]
            may_cut = level < finest and not planned
            own = QUARTERS ** (finest - level)
            share = (position + own) / units
            t = share * length[0]
            angle, speed, turning = angle_0 + t * (speed_0 + 0.5 * a * t) + share * mismatch, speed_0 + a * t, a
            hold = _choose_hold(counts, level, n_past)
            eta = states[n]
            _free_step(state, growth[level], load[level], ramp[level], a, eta)
            for s in range(1, n_past if hold > 0 else 2):
                _add_product(eta, weights[level, hold, s], pushes[s - 1])
            for j in range(len(moving)):
                moving[j] = 0.0
            _add_product(moving, rate, eta)
            for r in range(m):
                u_p[r], v_p[r] = _dots(rows[r], eta, moving)
            for r in range(m, n_rows):
                u_p[r], _ = _dots(rows[r], eta, eta)
            _extrapolate(past_forces, past, counts[0], length[level], guess)
            if frame.free == 1:
                angle, speed, turning = _turn(frame, powers[hold], past_forces, guess, motor, length[level])
            now = Instant(elastic[n], lost[n], stiffness, log[n], frozen, frozen_stiffness)
            time, audited = motor[2] + length[level], AUDIT_STEPS if counts[3] % AUDIT_STEPS == 0 else 0
            used = iterate(
                table, (angle, speed, time), u_p, v_p, g_u[level, hold], g_v[level, hold], guess, row_values[n], v, now,
                tolerance, NEAR, ROUGH if may_cut else np.inf, last_rows if audited > 0 else last_rows[:0], work,
            )  # fmt: skip
            kink = contact_changed(table, last.elastic, now.elastic)
            if may_cut and (used < 0 or kink):
                counts[1] += 1
                continue
            if used < 0:
                return i, n, iterations, True
            iterations += used
            if frame.free == 1:
                angle, speed, turning = _turn(frame, powers[hold], past_forces, guess, motor, length[level])
            parametric_work(table, (motor[0], angle), last_rows, row_values[n], last, now, audited)
            for r in range(m):
                forces[n, r] = guess[r]
            clock[n, 0], clock[n, 1], clock[n, 2], clock[n, 3] = length[level], angle, speed, turning
            _remember(
                length[level], weights[level, hold, 0], powers[hold], enter, memory, level, kink, eta, guess,
                row_values[n], now, holds[n],
            )  # fmt: skip
            motor[0], motor[1], motor[2] = angle, speed, time
            position += own
            n += 1
            if level > 0 and position % (QUARTERS * own) == 0 and work.quality[0] < SMOOTH:
                counts[1] -= 1
        whole[i] = n - 1
    return len(angles), n, iterations, False
