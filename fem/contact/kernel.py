"""Compiled core of the mesh law evaluation; the mathematics stands in `fem.contact.evaluate`, the door to it.

`tables` is the tuple of `fem.contact.evaluate.law_tables`. `work` holds one column per candidate pair of a slice, named
by the row numbers below, then MAX_PAIRS rows of coupling compliances and MAX_PAIRS rows for the linear system.

After a change in `fem.contact.single_pair`, or here for callers elsewhere, empty the `__pycache__` folders: numba's
cache on disk notices a change of the file that holds a function, but not of the files of the functions it calls.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from fem.contact.single_pair import (
    CLOSE,
    contact_approach,
    contact_energy,
    moved_log,
    secant_compliance,
    single_load,
)

MAX_PAIRS = 12  # pairs that the position grid may span
_X, _GAP_SLOPE, _PHI, _PHI_SLOPE, _C, _C_SLOPE, _B, _B_SLOPE, _F, _LOG, _CELL, _WEIGHT, _PAIR, _RHS, _BEFORE = range(15)
_COUPLING = 15  # first row of the coupling compliances c_pq
_SYSTEM = _COUPLING + MAX_PAIRS
_ROWS = _SYSTEM + MAX_PAIRS


@njit(cache=True, nogil=True, error_model="numpy")
def gather(
    tables: tuple, here: float, approach: float, pinion_tooth: int, wheel_tooth: int, anchor: int,
    h1: np.ndarray, h2: np.ndarray, work: np.ndarray,
) -> int:  # fmt: skip
    """Fill `work` with the candidate pairs at c' + shift = `here`, in rising order of p; return their number.

    pinion_tooth and wheel_tooth are the tooth indices of the pair `anchor`.
    """
    sign, start, per_step, grid, pulls = tables[3], tables[5], tables[6], tables[7], tables[9]
    last = grid.shape[0] - 1
    z1, z2 = h1.size, h2.size
    first = math.ceil(here - start - last / per_step - 1e-12)
    n = 0
    for p in range(first, math.floor(here - start + 1e-12) + 1):
        place = (here - p - start) * per_step
        cell = min(max(int(place), 0), last - 1)
        u = min(max(place - cell, 0.0), 1.0)
        low, high = grid[cell], grid[cell + 1]
        phi = low[3] + u * (high[3] - low[3])
        x = approach - low[2] - u * (high[2] - low[2])
        if phi <= 0.0 or low[2] == math.inf or high[2] == math.inf:
            continue
        turn = p - anchor if sign > 0.0 else anchor - p
        i, j = pinion_tooth + turn, wheel_tooth + turn
        while i < 0:
            i += z1
        while i >= z1:
            i -= z1
        while j < 0:
            j += z2
        while j >= z2:
            j -= z2
        x -= h1[i] + h2[j]
        if x == -math.inf or (x <= 0.0 and not pulls):
            continue
        work[_X, n] = x
        work[_GAP_SLOPE, n] = (high[2] - low[2]) * per_step
        work[_PHI, n] = phi
        work[_PHI_SLOPE, n] = (high[3] - low[3]) * per_step
        work[_C, n] = low[0] + u * (high[0] - low[0])
        work[_C_SLOPE, n] = (high[0] - low[0]) * per_step
        work[_B, n] = low[1] + u * (high[1] - low[1])
        work[_B_SLOPE, n] = (high[1] - low[1]) * per_step
        work[_CELL, n] = cell
        work[_WEIGHT, n] = u
        work[_PAIR, n] = p
        n += 1
    return n


@njit(cache=True, nogil=True, error_model="numpy")
def _neighbours(grid: np.ndarray, n: int, work: np.ndarray) -> None:
    """Symmetric coupling compliances c_pq between the gathered pairs, read at the pair that is ahead."""
    reach = grid.shape[1] - 4
    for a in range(n):
        cell, u = int(work[_CELL, a]), work[_WEIGHT, a]
        work[_COUPLING + a, a] = 0.0
        for b in range(a + 1, n):
            apart = int(work[_PAIR, b] - work[_PAIR, a])
            value = 0.0
            if apart <= reach:
                value = grid[cell, 3 + apart] + u * (grid[cell + 1, 3 + apart] - grid[cell, 3 + apart])
            work[_COUPLING + a, b] = value
            work[_COUPLING + b, a] = value


@njit(cache=True, nogil=True, error_model="numpy")
def _relieved(n: int, p: int, work: np.ndarray) -> float:
    """Approach left to pair p itself: x_p - sum_q c_pq phi_q f_q."""
    x = work[_X, p]
    for q in range(n):
        x -= work[_COUPLING + p, q] * work[_PHI, q] * work[_F, q]
    return x


@njit(cache=True, nogil=True, error_model="numpy")
def _solve_system(n: int, work: np.ndarray) -> None:
    """(diag(D) + c phi) d = rhs over the loaded pairs (f > 0), in place of rhs; 0 for the others.

    D stands on the diagonal of the system rows already.
    """
    for p in range(n):
        loaded = work[_F, p] > 0.0
        for q in range(n):
            if q != p:
                both = loaded and work[_F, q] > 0.0
                work[_SYSTEM + p, q] = work[_COUPLING + p, q] * work[_PHI, q] if both else 0.0
        if not loaded:
            work[_SYSTEM + p, p] = 1.0
            work[_RHS, p] = 0.0
    for p in range(n):
        for q in range(p + 1, n):
            factor = work[_SYSTEM + q, p] / work[_SYSTEM + p, p]
            if factor != 0.0:
                for r in range(p + 1, n):
                    work[_SYSTEM + q, r] -= factor * work[_SYSTEM + p, r]
                work[_RHS, q] -= factor * work[_RHS, p]
    for p in range(n - 1, -1, -1):
        for q in range(p + 1, n):
            work[_RHS, p] -= work[_SYSTEM + p, q] * work[_RHS, q]
        work[_RHS, p] /= work[_SYSTEM + p, p]


@njit(cache=True, nogil=True, error_model="numpy")
def _solve_coupled(n: int, slope: float, work: np.ndarray) -> None:
    """Line loads of coupled pairs: Newton on the loaded set; pairs leave at f <= 0 and return at positive approach."""
    for p in range(n):
        x = work[_X, p]
        work[_F, p] = work[_LOG, p] = 0.0
        if x > 0.0:
            work[_F, p], work[_LOG, p] = single_load(x, work[_C, p], slope, work[_B, p])
    for _ in range(40):
        for p in range(n):
            f = work[_F, p]
            if f > 0.0:
                approach, rate = contact_approach(f, work[_LOG, p], slope, work[_B, p]) if slope > 0.0 else (0.0, 0.0)
                work[_RHS, p] = _relieved(n, p, work) - work[_C, p] * f - approach
                work[_SYSTEM + p, p] = work[_C, p] + rate
        _solve_system(n, work)
        largest = 0.0
        switched = False
        for p in range(n):
            f = work[_F, p]
            if f > 0.0:
                step = work[_RHS, p] / f
                largest = max(largest, abs(step))
                if step <= -1.0:
                    switched = True
                    step = -0.9 if slope > 0.0 and _relieved(n, p, work) > 0.0 else -1.0
                work[_F, p] = f * (1.0 + step)
                if slope > 0.0 and step > -1.0:
                    work[_LOG, p] = work[_LOG, p] + step if abs(step) <= CLOSE else math.log(work[_F, p])
        if switched or largest > CLOSE:
            continue
        for p in range(n):
            if work[_F, p] == 0.0:
                x = _relieved(n, p, work)
                if x > 1e-15 * abs(work[_X, p]):
                    work[_F, p], work[_LOG, p] = single_load(x, work[_C, p], slope, work[_B, p])
                    switched = True
        if not switched:
            return
    for _ in range(1000):  # coordinate descent of a convex function always converges
        change = 0.0
        largest = 0.0
        for p in range(n):
            x = _relieved(n, p, work)
            f, log = single_load(x, work[_C, p], slope, work[_B, p]) if x > 0.0 else (0.0, 0.0)
            change = max(change, abs(f - work[_F, p]))
            largest = max(largest, f)
            work[_F, p], work[_LOG, p] = f, log
        if change <= 1e-14 * largest:
            return


@njit(cache=True, nogil=True, error_model="numpy")
def _solve_two(slope: float, work: np.ndarray) -> float:
    """The usual case, two loaded pairs: their line loads, and the stiffness of the slice; -1 if it is another case.

    Starts from the loads of the slice before when that held the same pairs.
    """
    x0, x1, c0, c1 = work[_X, 0], work[_X, 1], work[_C, 0], work[_C, 1]
    if x0 <= 0.0 or x1 <= 0.0:
        return -1.0
    phi0, phi1, b0, b1 = work[_PHI, 0], work[_PHI, 1], work[_B, 0], work[_B, 1]
    upper, lower = work[_COUPLING, 1] * phi1, work[_COUPLING, 1] * phi0
    f0, f1, log0, log1 = work[_F, 0], work[_F, 1], work[_LOG, 0], work[_LOG, 1]
    if not (work[_BEFORE, 0] == work[_PAIR, 0] and work[_BEFORE, 1] == work[_PAIR, 1] and f0 > 0.0 and f1 > 0.0):
        d0, d1 = c0, c1
        if slope > 0.0:
            d0, d1 = secant_compliance(x0, c0, slope, b0), secant_compliance(x1, c1, slope, b1)
        scale = 1.0 / (d0 * d1 - upper * lower)
        f0, f1 = (d1 * x0 - upper * x1) * scale, (d0 * x1 - lower * x0) * scale
        if f0 <= 0.0 or f1 <= 0.0:
            return -1.0
        log0, log1 = math.log(f0), math.log(f1)
    own0 = own1 = rate0 = rate1 = 0.0
    for _ in range(20):
        if slope > 0.0:
            own0, rate0 = contact_approach(f0, log0, slope, b0)
            own1, rate1 = contact_approach(f1, log1, slope, b1)
        rest0, rest1 = x0 - upper * f1 - c0 * f0 - own0, x1 - lower * f0 - c1 * f1 - own1
        d0, d1 = c0 + rate0, c1 + rate1
        scale = 1.0 / (d0 * d1 - upper * lower)
        step0, step1 = (d1 * rest0 - upper * rest1) * scale / f0, (d0 * rest1 - lower * rest0) * scale / f1
        if step0 <= -1.0 or step1 <= -1.0:
            return -1.0
        f0, f1 = f0 * (1.0 + step0), f1 * (1.0 + step1)
        log0, log1 = moved_log(log0, f0, step0), moved_log(log1, f1, step1)
        if max(abs(step0), abs(step1)) <= CLOSE:
            work[_F, 0], work[_F, 1], work[_LOG, 0], work[_LOG, 1] = f0, f1, log0, log1
            d0 = c0 + slope * max(b0 - log0 - 1.0, 0.0)
            d1 = c1 + slope * max(b1 - log1 - 1.0, 0.0)
            return (phi0 * (d1 - upper) + phi1 * (d0 - lower)) / (d0 * d1 - upper * lower)
    return -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def solve_slice(n: int, slope: float, grid: np.ndarray, work: np.ndarray) -> float:
    """Line loads of the n gathered pairs into `work`; returns d(sum phi f)/d approach (N/m per m of width)."""
    if n > 1 and grid.shape[1] > 4:
        _neighbours(grid, n, work)
        stiffness = _solve_two(slope, work) if n == 2 else -1.0
        if stiffness >= 0.0:
            return stiffness
        _solve_coupled(n, slope, work)
        for p in range(n):
            work[_RHS, p] = 1.0
            work[_SYSTEM + p, p] = work[_C, p] + slope * max(work[_B, p] - work[_LOG, p] - 1.0, 0.0)
        _solve_system(n, work)
        stiffness = 0.0
        for p in range(n):
            stiffness += work[_PHI, p] * work[_RHS, p]
        return stiffness
    stiffness = 0.0
    for p in range(n):
        x = work[_X, p]
        work[_F, p] = 0.0
        if x > 0.0:
            f, log = single_load(x, work[_C, p], slope, work[_B, p])
            work[_F, p], work[_LOG, p] = f, log
            stiffness += work[_PHI, p] / (work[_C, p] + slope * max(work[_B, p] - log - 1.0, 0.0))
    return stiffness


@njit(cache=True, nogil=True, error_model="numpy")
def slice_energy(
    n: int, slope: float, per_step: float, grid: np.ndarray, work: np.ndarray
) -> tuple[float, float, float]:
    """Load, energy and d(energy)/d xi of a solved slice, per unit width (N/m, N, N per cycle)."""
    load = energy = rate = 0.0
    reach = grid.shape[1] - 4
    for p in range(n):
        f = work[_F, p]
        if f <= 0.0:
            continue
        phi = work[_PHI, p]
        load += phi * f
        stored, by_offset = contact_energy(f, work[_LOG, p], slope, work[_B, p]) if slope > 0.0 else (0.0, 0.0)
        own = work[_X, p] * f - 0.5 * work[_C, p] * f * f - stored
        energy += phi * own
        rate += work[_PHI_SLOPE, p] * own
        rate -= phi * (f * work[_GAP_SLOPE, p] + 0.5 * f * f * work[_C_SLOPE, p] + by_offset * work[_B_SLOPE, p])
        for q in range(p + 1, n):
            apart = int(work[_PAIR, q] - work[_PAIR, p])
            if work[_F, q] <= 0.0 or apart > reach:
                continue
            cell = int(work[_CELL, p])
            both = f * work[_F, q]
            value = work[_COUPLING + p, q]
            energy -= value * phi * work[_PHI, q] * both
            rate -= value * (work[_PHI_SLOPE, p] * work[_PHI, q] + phi * work[_PHI_SLOPE, q]) * both
            steepness = (grid[cell + 1, 3 + apart] - grid[cell, 3 + apart]) * per_step
            rate -= steepness * phi * work[_PHI, q] * both
    return load, energy, rate


@njit(cache=True, nogil=True, error_model="numpy")
def evaluate_flank(
    tables: tuple, cycle: float, delta: float, psi: float, h1: np.ndarray, h2: np.ndarray, pair_force: np.ndarray
) -> tuple[float, float, float, float, float, float, float]:
    """Sum over the slices; adds each pair's force to pair_force[p - floor(c') + size // 2] where that exists."""
    face, width, shift, sign, offset = tables[:5]
    per_step, grid, slope, wheel_offset = tables[6], tables[7], tables[8], tables[12]
    force = moment = energy = k = k_mixed = k_tilt = rate = 0.0
    work = np.empty((_ROWS, MAX_PAIRS))
    work[_BEFORE, 0] = math.inf
    own_cycle = sign * cycle + offset
    anchor = math.floor(own_cycle)
    highest = delta + abs(psi) * np.abs(face).max()
    if highest <= 0.0 and highest <= h1.min() + h2.min() and not tables[9]:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # out of contact everywhere, as the coast flank mostly is
    tooth = int(sign) * anchor
    pinion_tooth, wheel_tooth = tooth % h1.size, (tooth + wheel_offset) % h2.size
    for s in range(face.size):
        y, w = face[s], width[s]
        n = gather(tables, own_cycle + shift[s], delta + psi * y, pinion_tooth, wheel_tooth, anchor, h1, h2, work)
        if n == 0:
            continue
        stiffness = w * solve_slice(n, slope, grid, work)
        work[_BEFORE, 0], work[_BEFORE, 1] = work[_PAIR, 0], work[_PAIR, 1] if n == 2 else math.inf
        load, stored, along = slice_energy(n, slope, per_step, grid, work)
        for p in range(n if pair_force.size > 0 else 0):
            place = int(work[_PAIR, p]) - anchor + pair_force.size // 2
            if 0 <= place < pair_force.size:
                pair_force[place] += w * work[_PHI, p] * work[_F, p]
        force += w * load
        moment += w * load * y
        energy += w * stored
        rate += w * along
        k += stiffness
        k_mixed += stiffness * y
        k_tilt += stiffness * y * y
    return force, moment, energy, k, k_mixed, k_tilt, sign * rate


@njit(cache=True, nogil=True, error_model="numpy")
def evaluate(
    tables: tuple, cycle: float, delta: float, psi: float, clearance_pinion: np.ndarray, clearance_wheel: np.ndarray
) -> tuple:
    """Response of one flank at one state.

    Parameters
    ----------
    tables : from `law_tables`
    cycle : mesh cycle c of the gears (1); the law turns it into its own c'
    delta, psi : approach along the transverse line of action (m) and tilt (rad)
    clearance_pinion (z1,), clearance_wheel (z2,) : m, +inf for a missing tooth

    Returns
    -------
    F (N), M (N m), U (J), dF/d delta (N/m), dF/d psi = dM/d delta (N), dM/d psi (N m), dU/dc (J)
    """
    return evaluate_flank(tables, cycle, delta, psi, clearance_pinion, clearance_wheel, np.empty(0))


@njit(cache=True, nogil=True, error_model="numpy")
def evaluate_shares(
    tables: tuple, cycle: float, delta: float, psi: float, h1: np.ndarray, h2: np.ndarray, pair_force: np.ndarray
) -> tuple:
    """As `evaluate`, and add the force (N) of pair p to pair_force[p - floor(c') + pair_force.size // 2].

    c' = cycle_sign c + cycle_offset. Pairs outside the array are left out; 2 `share_reach` + 1 places hold all.
    """
    return evaluate_flank(tables, cycle, delta, psi, h1, h2, pair_force)


@njit(cache=True, nogil=True, error_model="numpy")
def evaluate_many(
    tables: tuple,
    cycle: np.ndarray,
    delta: np.ndarray,
    psi: np.ndarray,
    h1: np.ndarray,
    h2: np.ndarray,
    out: np.ndarray,
) -> None:
    """Rows of `evaluate` for states given as arrays (n,), into out (n, 7)."""
    none = np.empty(0)
    for i in range(cycle.size):
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4], out[i, 5], out[i, 6] = evaluate_flank(
            tables, cycle[i], delta[i], psi[i], h1, h2, none
        )
