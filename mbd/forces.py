"""The nonlinear forces of the machine on their rows, compiled: gear flanks and ropes.

A linear reference (k0, c0) of each element is part of the system's matrices. What is left is the residual force
lambda = (k0 u + c0 u') - F_t(u, u', t) on the rows, so that the equation of motion reads
M q'' + C q' + K q = f + B^T lambda. Row order: per mesh delta, psi of the drive flank, delta, psi of the coast flank,
then the stretch of each rope, then rows that are only observed (rotation of each driving gear).

Element order (for the log): drive and coast flank of each mesh, then the ropes. Log columns: elastic force, elastic
moment, potential U, force with damping, the stiffness H (dF/d delta, dF/d psi, dM/d psi), the parametric work of the
step that ends here, and the changes G_F, G_M of force and moment by the parameter alone.

The parametric work is the integral of dU/dp dp, p being the mesh cycle or the rope stiffness. dU/dc jumps wherever a
tooth enters a new cell of the law's tables, so a quadrature of dU/dc would be first order. Instead U is evaluated
again at the new c with the old u = (delta, psi), which gives the work at frozen u across any jump, with
G = F(c_1, u_0) - F(c_0, u_0) and Q = H(c_1, u_0) - H(c_0, u_0) of the stiffness H; to third order in the step

    work = U(c_1, u_0) - U(c_0, u_0) + G . Du/2 + Du . Q Du/12 + [D G . Du - G . D2 u]/12,

where the last bracket, central differences over the neighbouring steps, is added by `mbd.books`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import types

from fem.compiled import FLOAT, INTEGER_MATRIX, MATRIX, VECTOR, apart, inner, stored
from fem.contact.evaluate import evaluate, law_tables
from fem.contact.kernel import evaluate_two
from fem.contact.teeth import least_clearance
from mbd.elements import EXTRA, SOURCES, Extra, extra_forces, extra_work
from mbd.load import vertical_rope
from mbd.machine import Machine

LOG_COLUMNS = (
    "force", "moment", "energy", "total_force", "stiffness", "coupling", "tilt", "parametric", "push_force",
    "push_moment",
)  # fmt: skip


class ForceTable(NamedTuple):
    """All constants of the nonlinear elements as flat arrays (a tuple that numba reads)."""

    laws: np.ndarray  # drive and coast tables of each mesh, one after another
    law_at: np.ndarray  # (flank, 2) start and end in `laws`
    clearances: np.ndarray  # (tooth, 6) tooth terms of all gears, one after another
    clearance_at: np.ndarray  # (flank, 2) start in `clearances`: pinion, wheel
    teeth: np.ndarray  # (flank, 2)
    backlash: np.ndarray  # (flank,), 0 for the drive flank
    floor: np.ndarray  # (flank,) smallest clearance of a pair: no contact at a smaller approach
    reach: np.ndarray  # (flank,) largest face coordinate
    tau: np.ndarray  # (flank,)
    stiffness: np.ndarray  # (flank, 2) k0 on delta, psi
    cycle_rate: np.ndarray  # (mesh,) cycles per radian of the driving shaft
    cycle_start: np.ndarray  # (mesh,)
    ratio: np.ndarray  # (mesh,) driving shaft angle per motor angle
    rope_stiffness: np.ndarray  # (rope,) reference k0
    rope_damping: np.ndarray  # (rope,) reference c0
    rope_ea: np.ndarray  # (rope,) stiffness times length
    rope_length: np.ndarray  # (rope,) at t = 0
    rope_travel: np.ndarray  # (rope,) shortening per motor angle, 0 if the stiffness is kept
    rope_loss: np.ndarray  # (rope,) 2 zeta sqrt(mass per rope)
    scale: np.ndarray  # (row,) force or moment that counts as 1 for convergence
    extra: Extra  # further elements, see `mbd.elements`


TABLE = types.NamedTuple(
    (
        *(VECTOR, INTEGER_MATRIX, MATRIX, INTEGER_MATRIX, INTEGER_MATRIX, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX),
        *(VECTOR,) * 10,
        EXTRA,
    ),
    ForceTable,
)


def element_count(table: ForceTable) -> int:
    """Rows of the log: flanks, ropes, further elements."""
    return len(table.tau) + len(table.rope_ea) + len(table.extra.kind)


def reference_stiffness(table: ForceTable) -> np.ndarray:
    """k0 (row,) of every force row."""
    return np.concatenate([table.stiffness.ravel(), table.rope_stiffness, table.extra.stiffness])


def reference_damping(table: ForceTable) -> np.ndarray:
    """c0 (row,) of every force row."""
    flanks = table.tau[:, None] * table.stiffness * [1.0, 0.0]
    return np.concatenate([flanks.ravel(), table.rope_damping, table.extra.damping])


def force_table(
    machine: Machine, loads: dict[str, float], stiffness: dict[str, tuple[float, float]], extra: Extra
) -> ForceTable:
    """Constants from the machine, the nominal mesh forces (N) and reference stiffnesses (N/m, N m/rad) by mesh name."""
    ratios = machine.ratios()
    laws, clearances, scale, floor = [], [], [], []
    for mesh in machine.meshes:
        laws += [law_tables(mesh.drive), law_tables(mesh.coast)]
        clearances += [mesh.drive_clearance_pinion, mesh.drive_clearance_wheel]
        clearances += [mesh.coast_clearance_pinion, mesh.coast_clearance_wheel]
        floor += [least_clearance(law, *terms) for law, terms in zip((mesh.drive, mesh.coast), mesh.terms, strict=True)]
        width = float(mesh.drive.slice_width.sum())
        scale += [loads[mesh.name], loads[mesh.name] * width] * 2
    sizes = np.array([len(c) for c in clearances], dtype=np.int64)
    starts = np.concatenate([[0], np.cumsum(sizes)])[:-1].astype(np.int64)
    ends = np.cumsum([len(law) for law in laws], dtype=np.int64)
    n_mesh = len(machine.meshes)
    stiff = np.zeros((2 * n_mesh, 2))
    for i, mesh in enumerate(machine.meshes):
        stiff[2 * i] = stiffness[mesh.name]
    ropes = _rope_constants(machine, ratios)
    load = machine.load
    if vertical_rope(load):
        scale += [max(load.container_mass * machine.gravity, 1.0) / len(load.drums)] * len(load.drums)
    return ForceTable(
        laws=np.concatenate([*laws, np.zeros(0)]),
        law_at=np.stack([np.concatenate([[0], ends])[:-1], ends], axis=1),
        clearances=np.concatenate([*clearances, np.zeros((1, 6))]),
        clearance_at=starts.reshape(-1, 2),
        teeth=sizes.reshape(-1, 2),
        backlash=np.array([b for m in machine.meshes for b in (0.0, m.backlash)]),
        floor=np.array(floor),
        reach=np.array([abs(law.face_coordinate).max() for m in machine.meshes for law in (m.drive, m.coast)]),
        tau=np.array([m.damping_time for m in machine.meshes for _ in range(2)]),
        stiffness=stiff,
        cycle_rate=np.array([m.cycles_per_radian for m in machine.meshes]),
        cycle_start=np.array([m.cycle_at_start for m in machine.meshes]),
        ratio=np.array([ratios[m.driving] for m in machine.meshes]),
        scale=np.concatenate([scale, extra.scale]),
        extra=extra,
        **ropes,
    )


def _rope_constants(machine: Machine, ratios: dict[str, float]) -> dict[str, np.ndarray]:
    load = machine.load
    if not vertical_rope(load):
        names = ("stiffness", "damping", "ea", "length", "travel", "loss")
        return {f"rope_{name}": np.zeros(0) for name in names}
    n = len(load.drums)
    stiffness = load.stiffness_times_length / load.length
    loss = 2 * load.damping_ratio * math.sqrt(load.container_mass / n)
    travel = load.travel_per_radian * ratios[load.shaft] if load.follow_length else 0.0
    return {
        "rope_stiffness": np.full(n, stiffness),
        "rope_damping": np.full(n, loss * math.sqrt(stiffness)),
        "rope_ea": np.full(n, load.stiffness_times_length),
        "rope_length": np.full(n, load.length),
        "rope_travel": np.full(n, travel),
        "rope_loss": np.full(n, loss),
    }


@inner(inline="always")
def touches(table, k, delta, psi):
    """False if flank k is clear of contact everywhere."""
    return delta - table.backlash[k] + abs(psi) * table.reach[k] > table.floor[k]


@inner()
def flank(table, k, angle, rotation, delta, psi):
    """What `evaluate` returns for flank k at the motor angle and the elastic rotation of its driving gear (rad)."""
    if not touches(table, k, delta, psi):
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    approach, i = delta - table.backlash[k], k // 2
    cycle = table.cycle_start[i] + table.cycle_rate[i] * (table.ratio[i] * angle + rotation)
    at, teeth = table.clearance_at[k], table.teeth[k]
    pinion = table.clearances[at[0] : at[0] + teeth[0]]
    wheel = table.clearances[at[1] : at[1] + teeth[1]]
    law = table.laws[table.law_at[k, 0] : table.law_at[k, 1]]
    return evaluate(law, cycle, approach, psi, pinion, wheel)


@inner()
def flank_and_before(table, k, angle, rotation, delta, psi, before, frozen):
    """`flank` without dU/dc, and into ``frozen`` (6,) the same at the rows ``before`` and the same mesh cycle."""
    i, b = k // 2, table.backlash[k]
    cycle = table.cycle_start[i] + table.cycle_rate[i] * (table.ratio[i] * angle + rotation)
    at, teeth = table.clearance_at[k], table.teeth[k]
    pinion = table.clearances[at[0] : at[0] + teeth[0]]
    wheel = table.clearances[at[1] : at[1] + teeth[1]]
    law = table.laws[table.law_at[k, 0] : table.law_at[k, 1]]
    f, m, energy, f_d, f_p, m_p, frozen[0], frozen[1], frozen[2], frozen[3], frozen[4], frozen[5] = evaluate_two(
        law, cycle, delta - b, psi, before[2 * k] - b, before[2 * k + 1], pinion, wheel
    )
    return f, m, energy, f_d, f_p, m_p


@inner()
def rope_stiffness(table, j, angle):
    """Stiffness (N/m) of the falls of drum j at the motor angle."""
    return table.rope_ea[j] / (table.rope_length[j] - table.rope_travel[j] * angle)


@apart(types.none, TABLE, FLOAT, FLOAT, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, MATRIX, VECTOR, MATRIX)
@stored(SOURCES, entry=False)
def row_forces(table, angle, speed, u, v, held, force, slope_u, slope_v, log, before, frozen):
    """Residual forces at row displacements u and rates v, motor angle and speed (rad, rad/s); fills force, slopes, log.

    ``slope_u[r]`` and ``slope_v[r]`` hold d force[r] with respect to the first and second row of r's element.
    ``held`` (flank,) is the stiffness that the damping takes, where it is not negative, instead of the current one.
    If the rows ``before`` of the last instant are given (else empty), ``frozen`` (flank, 6) takes F, M, U, dF/d delta,
    dF/d psi, dM/d psi there at the present mesh cycle, for `parametric_work`.
    """
    n_flank = len(table.tau)
    n_rope = len(table.rope_ea)
    n_force = 2 * n_flank + n_rope + len(table.extra.pattern)
    for k in range(n_flank):
        a = 2 * k
        f, m, energy, f_d, f_p, m_p = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if len(before) == 0:
            f, m, energy, f_d, f_p, m_p, _ = flank(table, k, angle, u[n_force + k // 2], u[a], u[a + 1])
        elif touches(table, k, u[a], u[a + 1]) or touches(table, k, before[a], before[a + 1]):
            f, m, energy, f_d, f_p, m_p = flank_and_before(
                table, k, angle, u[n_force + k // 2], u[a], u[a + 1], before, frozen[k]
            )
        else:
            frozen[k, :] = 0.0
        k0, kp0, tau = table.stiffness[k, 0], table.stiffness[k, 1], table.tau[k]
        total, moment = 0.0, 0.0
        slope_u[a, 0], slope_u[a, 1] = k0, 0.0
        slope_u[a + 1, 0], slope_u[a + 1, 1] = 0.0, kp0
        slope_v[a, 0], slope_v[a, 1] = tau * k0, 0.0
        slope_v[a + 1, 0], slope_v[a + 1, 1] = 0.0, 0.0
        if f > 0.0:
            arm = m / f
            rate = v[a] + arm * v[a + 1]
            damper = tau * (f_d if held[k] < 0.0 else held[k])
            total = f + damper * rate
            if total > 0.0:
                moment = arm * total
                share = total / f
                slope_u[a, 0] -= f_d
                slope_u[a, 1] -= f_p
                slope_u[a + 1, 0] -= arm * f_d + share * (f_p - arm * f_d)
                slope_u[a + 1, 1] -= arm * f_p + share * (m_p - arm * f_p)
                slope_v[a, 0] -= damper
                slope_v[a, 1] -= damper * arm
                slope_v[a + 1, 0] -= damper * arm
                slope_v[a + 1, 1] -= damper * arm * arm
            else:
                total = 0.0
        force[a] = k0 * u[a] + tau * k0 * v[a] - total
        force[a + 1] = kp0 * u[a + 1] - moment
        log[k, 0], log[k, 1], log[k, 2], log[k, 3] = f, m, energy, total
        log[k, 4], log[k, 5], log[k, 6] = f_d, f_p, m_p
    for j in range(n_rope):
        r = 2 * n_flank + j
        stiff = rope_stiffness(table, j, angle)
        damp = table.rope_loss[j] * math.sqrt(stiff)
        elastic, total = 0.0, 0.0
        slope_u[r, 0], slope_u[r, 1] = table.rope_stiffness[j], 0.0
        slope_v[r, 0], slope_v[r, 1] = table.rope_damping[j], 0.0
        if u[r] > 0.0:
            elastic = stiff * u[r]
            total = elastic + damp * v[r]
            if total > 0.0:
                slope_u[r, 0] -= stiff
                slope_v[r, 0] -= damp
            else:
                total = 0.0
        force[r] = table.rope_stiffness[j] * u[r] + table.rope_damping[j] * v[r] - total
        k = n_flank + j
        log[k, 0], log[k, 1], log[k, 2], log[k, 3] = elastic, 0.0, 0.5 * elastic * max(u[r], 0.0), total
    if len(table.extra.kind):
        extra_forces(
            table.extra, angle, speed, u, v, 2 * n_flank + n_rope, force, slope_u, slope_v, log, n_flank + n_rope
        )


@inner()
def follow_tangent(table, angle, before, u, v, force, log):
    """Move the log from the rows ``before`` where it was evaluated to u, v nearby, where ``force`` is the solution."""
    n_flank = len(table.tau)
    for k in range(n_flank):
        if log[k, 0] > 0.0:
            a = 2 * k
            d, p = u[a] - before[a], u[a + 1] - before[a + 1]
            df, dm = log[k, 4] * d + log[k, 5] * p, log[k, 5] * d + log[k, 6] * p
            log[k, 2] += (log[k, 0] + 0.5 * df) * d + (log[k, 1] + 0.5 * dm) * p
            log[k, 0], log[k, 1] = max(log[k, 0] + df, 0.0), log[k, 1] + dm
            if log[k, 3] > 0.0:
                k0 = table.stiffness[k, 0]
                log[k, 3] = max(k0 * u[a] + table.tau[k] * k0 * v[a] - force[a], 0.0)
    for j in range(len(table.rope_ea)):
        r, k = 2 * n_flank + j, n_flank + j
        stretch = max(u[r], 0.0)
        log[k, 0] = rope_stiffness(table, j, angle) * stretch
        log[k, 2] = 0.5 * log[k, 0] * stretch
        if log[k, 3] > 0.0:
            log[k, 3] = max(table.rope_stiffness[j] * u[r] + table.rope_damping[j] * v[r] - force[r], 0.0)


@inner()
def parametric_work(table, before, after, u_before, u_after, log_before, log_after, frozen):
    """Fill the last three log columns of the step from motor angle ``before`` to ``after`` (rad); ``frozen`` (flank, 6)
    are the flanks at the new cycle and the old rows."""
    n_flank = len(table.tau)
    n_rope = len(table.rope_ea)
    for k in range(n_flank):
        a = 2 * k
        log_after[k, 7], log_after[k, 8], log_after[k, 9] = 0.0, 0.0, 0.0
        if log_before[k, 2] > 0.0 or log_after[k, 2] > 0.0:
            delta, psi = u_before[a], u_before[a + 1]
            d, p = u_after[a] - delta, u_after[a + 1] - psi
            f_d, f_p, m_p = (
                frozen[k, 3] - log_before[k, 4],
                frozen[k, 4] - log_before[k, 5],
                frozen[k, 5] - log_before[k, 6],
            )
            push, turn = frozen[k, 0] - log_before[k, 0], frozen[k, 1] - log_before[k, 1]
            twice = f_d * d * d + 2.0 * f_p * d * p + m_p * p * p
            log_after[k, 7] = frozen[k, 2] - log_before[k, 2] + 0.5 * (push * d + turn * p) + twice / 12.0
            log_after[k, 8], log_after[k, 9] = push, turn
    for j in range(n_rope):
        r = 2 * n_flank + j
        change = rope_stiffness(table, j, after) - rope_stiffness(table, j, before)
        log_after[n_flank + j, 7] = 0.25 * change * (max(u_before[r], 0.0) ** 2 + max(u_after[r], 0.0) ** 2)
    extra_work(table.extra, before, after, log_before, log_after, n_flank + n_rope)


@inner()
def partner(row, n_flank):
    """First and second row of the element that ``row`` belongs to."""
    if row < 2 * n_flank:
        return row - row % 2, row - row % 2 + 1
    return row, row


@inner()
def solve_dense(matrix, right):
    """Gaussian elimination with partial pivoting in place; the answer is in ``right``; False if singular."""
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


def slope_matrix(slope: np.ndarray, table: ForceTable) -> np.ndarray:
    """Matrix (m, m) of the slopes (m, WIDTH) with respect to the rows that each row's force depends on."""
    matrix = np.zeros((len(slope), len(slope)))
    n_flank, first = len(table.tau), len(slope) - len(table.extra.pattern)
    for r, values in enumerate(slope):
        columns = partner(r, n_flank) if r < first else table.extra.pattern[r - first]
        for column, value in zip(columns, values, strict=False):
            if value != 0.0:
                matrix[r, column] += value
    return matrix
