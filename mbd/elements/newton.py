"""Newton iteration for the forces on the rows, in a time step or at equilibrium, compiled.

With the predictions u_p, v_p without the new forces and the constant matrices G_u, G_v of the linear system, find

    lambda = Lambda(u, v),   u = u_p + G_u lambda,   v = v_p + G_v lambda.

The flank potentials are convex and G_u is positive, so without damping the solution is unique. A change of lambda that
raises the residual is halved, because the force has kinks where a contact opens. The damping tau k_t u' jumps where a
pair of teeth touches, because k_t does, and the force of a flank jumps with the rotation of its gear where the mesh law
drops a pair that is still loaded, far beyond its path of contact. A time step may then have no solution, with the flank
neither in nor out of contact. Such a step is solved with k_t and the observed rows held at their values for the guess,
which makes the force continuous and monotone again.

An iteration reduces the residual r to 0.05 r^2 to r^2 (measured on the rig). With forces extrapolated in time, r falls
with a power of the time step, so that one iteration leaves a residual far below the error of the step. At a residual
below ``near`` the iteration is therefore the last: the forces are not evaluated again, and the answers of the elements
are updated by their tangents. A time step then costs one evaluation.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import types

from fem.numerics.compiled import CUBE, FLOAT, INTEGER, INTEGER_MATRIX, MATRIX, VECTOR, by_address, stored
from fem.numerics.inner_functions import UNCOUNTED, inner
from mbd.elements.element import WIDTH
from mbd.elements.element_table import (
    CLOCK,
    INSTANT,
    TABLE,
    ElementTable,
    Instant,
    follow_tangent,
    parametric_work,
    row_forces,
)

MAX_ITERATIONS = 60
MAX_HALVINGS = 8
NEAR = 0.01  # of the scale: the remaining residual is below 1e-5 in 99 of 100 steps of 33 us


class Workspace(NamedTuple):
    """Arrays for intermediate results of `iterate`."""

    quality: np.ndarray  # (1,) out: residual of the guess
    forces: np.ndarray  # (5, m) guess, forces at the present motion, step, trial, right-hand side of the reduced system
    slopes: np.ndarray  # (3, m, WIDTH) stiffnesses held for damping, slopes by displacement and rate
    matrix: np.ndarray  # (m, m)
    rows: np.ndarray  # (2, m) int: rows of unknown force, and rows whose change of force is known


WORKSPACE = types.NamedTuple((VECTOR, MATRIX, CUBE, MATRIX, INTEGER_MATRIX), Workspace)


def workspace(m: int) -> Workspace:
    """Arrays for m forces."""
    return Workspace(
        np.empty(1), np.empty((5, m)), np.empty((3, m, WIDTH)), np.empty((m, m)), np.empty((2, m), dtype=np.int64)
    )


@inner()
def _move_rows(predicted, flexibility, force, result):
    """result = predicted + flexibility @ force; rows after the first m are observed and have no force.

    ``predicted`` and ``result`` (k,), ``flexibility`` (k, m), ``force`` (m,).
    """
    for r in range(len(predicted)):
        result[r] = predicted[r]
    for j in range(len(force)):
        if force[j] != 0.0:
            for r in range(len(predicted)):
                result[r] += flexibility[r, j] * force[j]


@inner()
def copy_to(target, source):
    """Copy element by element: an array assignment also compiles its error message, which takes seconds."""
    for r in range(len(target)):
        target[r] = source[r]


@inner()
def residual_size(force, target, scale):
    """Largest |target - force| in units of ``scale``."""
    worst = 0.0
    for r in range(len(force)):
        worst = max(worst, abs(target[r] - force[r]) / scale[r])
    return worst


@by_address(
    INTEGER,
    *(TABLE, CLOCK, VECTOR, VECTOR, MATRIX, MATRIX, VECTOR, VECTOR, VECTOR, INSTANT, FLOAT, FLOAT, FLOAT),
    *(VECTOR, WORKSPACE),
)
@stored(__file__, entry=False, **UNCOUNTED)
def iterate(table, clock, u_p, v_p, g_u, g_v, force, u, v, now, tolerance, near, limit, before, work):
    """Solve for ``force``; the number of iterations, or -1 without convergence.

    k rows, of which the first m have forces. Residuals are measured in units of the scale of the forces.

    Parameters
    ----------
    table, clock : elements of the machine; motor angle, its speed and time, rad, rad/s and s
    u_p, v_p : (k,) and (m,) displacements and rates without the new forces, m or rad, m/s or rad/s
    g_u, g_v : (k, m) and (m, m) displacements and rates per unit force
    force : (m,) N or N m, in: the guess, out: the solution
    u, v : (k,) and (m,) out: displacements and rates with the forces
    now : out: answers of the elements
    tolerance : residual below which the forces are accepted
    near : residual below which the last iteration is done without evaluating the forces again
    limit : residual of the guess above which no iteration is done
    before : (m,) or more displacements of the last instant in a step that is audited, or (0,)
    work : `Workspace`
    """
    guess, held = work.forces[0], work.slopes[0]
    copy_to(guess, force)
    used = _newton(table, clock, u_p, v_p, g_u, g_v, held[:0], force, u, v, now, tolerance, near, limit, before, work)
    if used >= 0:
        return used
    if work.quality[0] > limit:
        return -1
    copy_to(force, guess)
    _move_rows(u_p, g_u, force, u)
    _move_rows(v_p, g_v, force, v)
    row_forces(table, clock, u, v, before[:0], held[:0], guess, work.slopes[1], work.slopes[2], now)
    for r in range(len(force)):
        for j in range(WIDTH):
            held[r, j] = now.stiffness[r, j]
    m = len(force)
    used = _newton(
        table, clock, u_p[:m], v_p, g_u[:m], g_v, held, force, u, v, now, tolerance, near, limit, before, work
    )
    _move_rows(u_p, g_u, force, u)
    return MAX_ITERATIONS + used if used >= 0 else -1


@inner()
def _newton(table, clock, u_p, v_p, g_u, g_v, held, force, u, v, now, tolerance, near, limit, before, work):
    """`iterate` with the stiffnesses ``held`` (m, WIDTH) for the damping, or the present ones if that is empty."""
    m = len(force)
    target, step, trial = work.forces[1], work.forces[2], work.forces[3]
    slope_u, slope_v = work.slopes[1], work.slopes[2]
    size = np.inf
    for r in range(m):
        step[r] = 0.0
    for iteration in range(MAX_ITERATIONS + 1):
        last, part = size, 1.0
        for _ in range(MAX_HALVINGS):
            for r in range(m):
                trial[r] = force[r] + part * step[r]
            _move_rows(u_p, g_u, trial, u)
            _move_rows(v_p, g_v, trial, v)
            row_forces(table, clock, u, v, before, held, target, slope_u, slope_v, now)
            size = residual_size(trial, target, table.scale)
            if size < last:
                break
            part *= 0.5
        copy_to(force, trial)
        if iteration == 0:
            work.quality[0] = size
            if not size <= limit:
                return -1
        if size <= tolerance:
            return iteration
        for r in range(m):
            step[r] = target[r] - force[r]
        if not _newton_step(table, g_u, g_v, work):
            return -1
        if size <= near:
            for r in range(m):
                force[r] += step[r]
            copy_to(trial, u[:m])
            _move_rows(u_p, g_u, force, u)
            _move_rows(v_p, g_v, force, v)
            follow_tangent(table, trial, u, v, force, now)
            return iteration + 1
    return -1


@inner()
def _newton_step(table, g_u, g_v, work):
    """Solve (1 - S_u G_u - S_v G_v) step = residual in place; only rows whose force depends on the motion are unknown.

    ``g_u`` and ``g_v`` as in `iterate`, S_u and S_v as in `mbd.elements.element_table.row_forces`, the step of ``work``
    in: the residual, out: the change of the forces. False if the matrix is singular.
    """
    step, right, matrix, n, n_pushed = work.forces[2], work.forces[4], work.matrix, 0, 0
    slope_u, slope_v, active, pushed = work.slopes[1], work.slopes[2], work.rows[0], work.rows[1]
    for r in range(len(step)):
        moves = False
        for k in range(table.width[r]):
            moves = moves or slope_u[r, k] != 0.0 or slope_v[r, k] != 0.0
        if moves:
            active[n] = r
            n += 1
        elif step[r] != 0.0:
            pushed[n_pushed] = r
            n_pushed += 1
    for i in range(n):
        r = active[i]
        right[i] = step[r]
        for j in range(n):
            matrix[i, j] = 0.0
        for k in range(table.width[r]):
            su, sv = slope_u[r, k], slope_v[r, k]
            if su != 0.0 or sv != 0.0:
                a = table.pattern[r, k]
                for j in range(n):
                    matrix[i, j] -= su * g_u[a, active[j]] + sv * g_v[a, active[j]]
                for j in range(n_pushed):
                    right[i] += (su * g_u[a, pushed[j]] + sv * g_v[a, pushed[j]]) * step[pushed[j]]
        matrix[i, i] += 1.0
    if not solve_dense(matrix, right[:n]):
        return False
    for i in range(n):
        step[active[i]] = right[i]
    return True


@inner()
def solve_dense(matrix, right):
    """Gaussian elimination with partial pivoting in place; the solution is in ``right``; False if singular."""
    n = len(right)
    for i in range(n):
        p = i
        for j in range(i + 1, n):
            if abs(matrix[j, i]) > abs(matrix[p, i]):
                p = j
        if matrix[p, i] == 0.0 or not math.isfinite(matrix[p, i]):
            return False
        if p != i:
            for j in range(i, n):
                matrix[i, j], matrix[p, j] = matrix[p, j], matrix[i, j]
            right[i], right[p] = right[p], right[i]
        for j in range(i + 1, n):
            q = matrix[j, i] / matrix[i, i]
            if q != 0.0:
                for c in range(i + 1, n):
                    matrix[j, c] -= q * matrix[i, c]
                right[j] -= q * right[i]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]
    return True


def solve_rows(
    table: ElementTable, clock: tuple[float, float, float], *, u_p: np.ndarray, v_p: np.ndarray, g_u: np.ndarray,
    g_v: np.ndarray, force: np.ndarray, u: np.ndarray, v: np.ndarray, now: Instant, tolerance: float,
) -> int:  # fmt: skip
    """`iterate` for one instant, to the tolerance.

    Parameters
    ----------
    table, clock, u_p, v_p, g_u, g_v, force, u, v, now, tolerance : those of `iterate`
    """
    return _solve_rows(table, clock, u_p, v_p, g_u, g_v, force, u, v, now, tolerance, workspace(len(force)))


@stored(__file__, **UNCOUNTED)
def _solve_rows(table, clock, u_p, v_p, g_u, g_v, force, u, v, now, tolerance, work):
    return iterate(table, clock, u_p, v_p, g_u, g_v, force, u, v, now, tolerance, 0.0, np.inf, force[:0], work)


@stored(__file__, **UNCOUNTED)
def forces_at(table, clock, u, v, before, held, force, slope_u, slope_v, now):
    """`mbd.elements.element_table.row_forces` at one instant.

    Parameters
    ----------
    table, clock, u, v, before, held, force, slope_u, slope_v, now : those of `mbd.elements.element_table.row_forces`
    """
    row_forces(table, clock, u, v, before, held, force, slope_u, slope_v, now)


@stored(__file__)
def work_between(table, angle_before, clock, u_before, u, v, last, now):
    """`mbd.elements.element_table.parametric_work` of an audited step.

    Parameters
    ----------
    table, u_before, last : those of `mbd.elements.element_table.parametric_work`
    angle_before : of the motor at the start of the step, rad
    clock, u, v, now : end of the step, those of `mbd.elements.element_table.row_forces`
    """
    m = len(v)
    force, slope_u, slope_v = np.empty(m), np.empty((m, WIDTH)), np.empty((m, WIDTH))
    row_forces(table, clock, u, v, u_before, slope_u[:0], force, slope_u, slope_v, now)
    parametric_work(table, (angle_before, clock[0]), u_before, u, last, now, 1)
