"""Newton iteration for the forces on the rows of one time step or of the equilibrium, compiled.

With the predictions u_p, v_p without the new forces and the constant matrices G_u, G_v of the linear system, find

    lambda = Lambda(u, v),   u = u_p + G_u lambda,   v = v_p + G_v lambda.

The flank potentials are convex and G_u is positive, so without damping the solution is unique; a step that raises the
residual is halved (the force law has kinks where a contact opens). The damping tau k_t u' jumps where a pair of teeth
touches, because k_t does: a step may then have no solution, the flank being neither in nor out of contact. Such a step
is taken with k_t held at its value for the guess, which makes the force monotone again.

A Newton step leaves 0.05 r^2 to r^2 of the residual r it starts from (measured on the rig). With forces extrapolated in
time r falls with a power of the time step, so what is left after one step is far below the error of the step itself:
from a residual below ``near`` the step is taken without evaluating the forces again, and forces, moments and energies
in the log are moved along by their tangents. A time step then costs one evaluation.
"""

from __future__ import annotations

import numpy as np

from fem.compiled import FLOAT, INTEGER, MATRIX, VECTOR, apart, inner, stored
from mbd.elements import SOURCES, WIDTH, extra_follow
from mbd.forces import TABLE, flank, follow_tangent, parametric_work, partner, row_forces, solve_dense

MAX_ITERATIONS = 60
MAX_HALVINGS = 8
NEAR = 0.01  # of the scale: what is left is below 1e-5 of it in 99 of 100 steps of 33 us


@inner()
def move_rows(predicted, flexibility, force, result):
    """result = predicted + flexibility @ force; rows beyond the forces are observed only."""
    for r in range(len(predicted)):
        result[r] = predicted[r]
    for j in range(len(force)):
        if force[j] != 0.0:
            for r in range(len(predicted)):
                result[r] += flexibility[r, j] * force[j]


@inner()
def copy_to(target, source):
    """Copy element by element: an array assignment drags its error text into the compilation, which costs seconds."""
    for r in range(len(target)):
        target[r] = source[r]


@inner()
def residual_size(force, target, scale):
    """Largest |target - force| in units of ``scale``."""
    worst = 0.0
    for r in range(len(force)):
        worst = max(worst, abs(target[r] - force[r]) / scale[r])
    return worst


@apart(
    INTEGER,
    *(TABLE, FLOAT, FLOAT, VECTOR, VECTOR, MATRIX, MATRIX, VECTOR, VECTOR, VECTOR, MATRIX, FLOAT, FLOAT, FLOAT),
    *(VECTOR, VECTOR, MATRIX),
)
@stored(SOURCES, entry=False)
def iterate(table, angle, speed, u_p, v_p, g_u, g_v, force, u, v, log, tolerance, near, limit, quality, before, frozen):
    """Iterate on ``force`` (in: guess, out: solution); returns the iterations used, or -1 without convergence.

    ``angle`` and ``speed`` of the motor (rad, rad/s); residuals in units of the scale of the forces: below
    ``tolerance`` the guess is taken, from below ``near`` one more step is, above ``limit`` nothing is. ``quality`` (1,)
    takes the residual of the guess. ``before`` and ``frozen`` as in `mbd.forces.row_forces`.
    """
    n_flank = len(table.tau)
    guess, held = force.copy(), np.full(n_flank, -1.0)
    total = 0
    for attempt in range(2):
        if attempt == 1:
            copy_to(force, guess)
            move_rows(u_p, g_u, force, u)
            first = len(force)  # the rows that are observed only
            for k in range(n_flank):
                held[k] = flank(table, k, angle, u[first + k // 2], u[2 * k], u[2 * k + 1])[3]
        used = newton(
            table, angle, speed, u_p, v_p, g_u, g_v, held, force, u, v, log, tolerance, near, limit, quality, before,
            frozen,
        )  # fmt: skip
        if used >= 0:
            return total + used
        if quality[0] > limit:
            return -1
        total += MAX_ITERATIONS
    return -1


@inner()
def newton(
    table, angle, speed, u_p, v_p, g_u, g_v, held, force, u, v, log, tolerance, near, limit, quality, before,
    frozen,
):  # fmt: skip
    """`iterate` with the damping stiffnesses ``held`` (flank,), see `mbd.forces.row_forces`."""
    m = len(force)
    n_flank = len(table.tau)
    target, step, trial = np.empty(m), np.zeros(m), np.empty(m)
    slope_u, slope_v = np.zeros((m, WIDTH)), np.zeros((m, WIDTH))
    size = np.inf
    for iteration in range(MAX_ITERATIONS + 1):
        last, part = size, 1.0
        for _ in range(MAX_HALVINGS):
            for r in range(m):
                trial[r] = force[r] + part * step[r]
            move_rows(u_p, g_u, trial, u)
            move_rows(v_p, g_v, trial, v)
            row_forces(table, angle, speed, u, v, held, target, slope_u, slope_v, log, before, frozen)
            size = residual_size(trial, target, table.scale)
            if size < last:
                break
            part *= 0.5
        copy_to(force, trial)
        if iteration == 0:
            quality[0] = size
            if not size <= limit:
                return -1
        if size <= tolerance:
            return iteration
        for r in range(m):
            step[r] = target[r] - force[r]
        if not newton_step(n_flank, table.extra.pattern, g_u, g_v, slope_u, slope_v, step):
            return -1
        if size <= near:
            for r in range(m):
                force[r] += step[r]
            copy_to(trial, u[:m])
            move_rows(u_p, g_u, force, u)
            move_rows(v_p, g_v, force, v)
            follow_tangent(table, angle, trial, u, v, force, log)
            extra_follow(
                table.extra, speed, u, v, m - len(table.extra.pattern), force, log, len(log) - len(table.extra.kind)
            )
            return iteration + 1
    return -1


@inner()
def newton_step(n_flank, pattern, g_u, g_v, slope_u, slope_v, step):
    """Solve (1 - S_u G_u - S_v G_v) step = residual in place; rows whose force does not depend on the motion stay.

    The columns of row r's slopes are the rows of its element: two at most of flanks and ropes, ``pattern`` of others.
    """
    m = len(step)
    first = m - len(pattern)
    active, n = np.empty(m, dtype=np.int64), 0
    pushed, n_pushed = np.empty(m, dtype=np.int64), 0  # rows that move by a given force
    for r in range(m):
        moves, width = False, 2 if r < first else WIDTH
        for k in range(width):
            moves = moves or slope_u[r, k] != 0.0 or slope_v[r, k] != 0.0
        if moves:
            active[n] = r
            n += 1
        elif step[r] != 0.0:
            pushed[n_pushed] = r
            n_pushed += 1
    matrix, right = np.zeros((n, n)), np.empty(n)
    for i in range(n):
        r = active[i]
        right[i] = step[r]
        for k in range(2 if r < first else WIDTH):
            su, sv = slope_u[r, k], slope_v[r, k]
            if su != 0.0 or sv != 0.0:
                a = pattern[r - first, k] if r >= first else partner(r, n_flank)[k]
                for j in range(n):
                    matrix[i, j] -= su * g_u[a, active[j]] + sv * g_v[a, active[j]]
                for j in range(n_pushed):
                    right[i] += (su * g_u[a, pushed[j]] + sv * g_v[a, pushed[j]]) * step[pushed[j]]
        matrix[i, i] += 1.0
    if not solve_dense(matrix, right):
        return False
    for i in range(n):
        step[active[i]] = right[i]
    return True


@stored(SOURCES)
def solve_rows(table, angle, speed, u_p, v_p, g_u, g_v, force, u, v, log, tolerance):
    """`iterate` for one instant, to the tolerance."""
    quality, none = np.empty(1), np.empty((0, 6))
    return iterate(
        table, angle, speed, u_p, v_p, g_u, g_v, force, u, v, log, tolerance, 0.0, np.inf, quality, quality[:0], none
    )


@stored(SOURCES)
def parametric(table, before, after, u_before, u_after, log_before, log_after):
    """`mbd.forces.parametric_work` with the flanks at the new cycle and the old rows evaluated."""
    frozen, observed = np.zeros((len(table.tau), 6)), len(u_after) - len(table.ratio)
    for k in range(len(table.tau)):
        turned = u_after[observed + k // 2]
        f, m, energy, f_d, f_p, m_p, _ = flank(table, k, after, turned, u_before[2 * k], u_before[2 * k + 1])
        frozen[k, 0], frozen[k, 1], frozen[k, 2] = f, m, energy
        frozen[k, 3], frozen[k, 4], frozen[k, 5] = f_d, f_p, m_p
    parametric_work(table, before, after, u_before, u_after, log_before, log_after, frozen)


@stored(SOURCES)
def forces_at(table, angle, speed, u, v, held, force, slope_u, slope_v, log):
    """`mbd.forces.row_forces` at one instant."""
    row_forces(table, angle, speed, u, v, held, force, slope_u, slope_v, log, np.empty(0), np.empty((0, 6)))
