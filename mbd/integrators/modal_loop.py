"""The compiled time loop over complex modes, see `mbd.integrators.modal`; arrays over modes hold (Re, Im) halves."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from mbd.forces import parametric_work
from mbd.rows_solver import NEAR, iterate, source_digest


class Constants(NamedTuple):
    """What does not change: first axis 2 where a hold after a kink and the usual one differ."""

    growth: np.ndarray  # (2 mode,) e^(lambda h)
    rate: np.ndarray  # (2 mode,) lambda
    weights: np.ndarray  # (2, s, 2 mode)
    powers: np.ndarray  # (2, k, s)
    load: np.ndarray  # (2 mode,) what the constant load adds in a step
    ramp: np.ndarray  # (2 mode,) the same per unit of motor acceleration
    enter: np.ndarray  # (m, 2 mode) modal force per row force
    rows: np.ndarray  # (m + mesh, 2 mode) row displacements
    g_u: np.ndarray  # (2, m + mesh, m)
    g_v: np.ndarray  # (2, m, m)


class Memory(NamedTuple):
    """What a step leaves for the next; overwritten in place."""

    state: np.ndarray  # (2 mode,)
    forces: np.ndarray  # (3, m) of the last instants, newest first
    pushes: np.ndarray  # (s, 2 mode) modal forces of the last instants, newest first
    smooth: np.ndarray  # (1,) steps since the start or the last kink
    angle: np.ndarray  # (1,)
    rows: np.ndarray  # (m + mesh,)
    log: np.ndarray  # (element, column)


@njit(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _dot(a, b):
    total = 0.0
    for j in range(len(a)):
        total += a[j] * b[j]
    return total


@njit(nogil=True, error_model="numpy", fastmath={"contract"})
def _add(target, factor, vector):
    for j in range(len(target)):
        target[j] += factor * vector[j]


@njit(nogil=True, error_model="numpy", fastmath={"contract"})
def _free_step(before, growth, load, ramp, acceleration, after):
    """after = E before + the part of the prescribed forces."""
    n = len(before) // 2
    for j in range(n):
        r, i, er, ei = before[j], before[n + j], growth[j], growth[n + j]
        after[j] = er * r - ei * i + load[j] + acceleration * ramp[j]
        after[n + j] = er * i + ei * r + load[n + j] + acceleration * ramp[n + j]


@njit(nogil=True, error_model="numpy", fastmath={"contract"})
def _add_product(target, weight, push):
    """target += weight * push, complex."""
    n = len(target) // 2
    for j in range(n):
        wr, wi, pr, pi = weight[j], weight[n + j], push[j], push[n + j]
        target[j] += wr * pr - wi * pi
        target[n + j] += wr * pi + wi * pr


@njit(nogil=True, error_model="numpy")
def _kink(before, after, n_element):
    """True if an element touched or let go."""
    for k in range(n_element):
        if (before[k, 0] > 0.0) != (after[k, 0] > 0.0):
            return True
    return False


def _compiled(digest: int) -> Callable:
    @njit(cache=True, nogil=True, error_model="numpy")
    def advance(table, angles, speeds, accelerations, constants, memory, block, tolerance):
        if digest < 0:  # part of the key under which the compiled code is stored
            return -1, 0
        growth, rate, weights, powers, load, ramp, enter, rows, g_u, g_v = constants
        state, past_forces, pushes, smooth, last_angle, last_rows, last_log = memory
        states, starts, forces, row_values, log, holds = block
        m, n_rows, n_past, size = len(enter), len(rows), len(pushes), len(state)
        u_p, v_p, v, guess = np.empty(n_rows), np.empty(m), np.empty(m), np.empty(m)
        moving = np.empty(size)
        iterations = 0
        for n in range(len(angles)):
            eta = states[n]
            _free_step(starts[n], growth, load, ramp, accelerations[n], eta)
            usual = 1 if smooth[0] >= n_past - 2 else 0
            for s in range(1, n_past if usual == 1 else 2):
                _add_product(eta, weights[usual, s], pushes[s - 1])
            moving[:] = 0.0
            _add_product(moving, rate, eta)
            for r in range(n_rows):
                u_p[r] = _dot(rows[r], eta)
            for r in range(m):
                v_p[r] = _dot(rows[r], moving)
                guess[r] = past_forces[0, r]
                if smooth[0] >= 2:
                    guess[r] = 3.0 * (past_forces[0, r] - past_forces[1, r]) + past_forces[2, r]
            used = iterate(
                table, angles[n], speeds[n], u_p, v_p, g_u[usual], g_v[usual], guess, row_values[n], v, log[n],
                tolerance, NEAR,
            )  # fmt: skip
            if used < 0:
                return iterations, n
            iterations += used
            parametric_work(table, last_angle[0], angles[n], last_rows, row_values[n], last_log, log[n])
            for s in range(n_past - 1, 0, -1):
                for j in range(size):
                    pushes[s, j] = pushes[s - 1, j]
            pushes[0, :] = 0.0
            for r in range(m):
                if guess[r] != 0.0:
                    _add(pushes[0], guess[r], enter[r])
            _add_product(eta, weights[usual, 0], pushes[0])
            for r in range(m):
                for k in range(n_past):
                    total = powers[usual, k, 0] * guess[r]
                    for s in range(1, n_past):
                        total += powers[usual, k, s] * past_forces[s - 1, r]
                    holds[n, k, r] = total
                past_forces[2, r], past_forces[1, r] = past_forces[1, r], past_forces[0, r]
                past_forces[0, r] = guess[r]
                forces[n, r] = guess[r]
            smooth[0] = 0 if _kink(last_log, log[n], len(last_log)) else smooth[0] + 1
            last_angle[0] = angles[n]
            for r in range(n_rows):
                last_rows[r] = row_values[n, r]
            for k in range(log.shape[1]):
                for j in range(log.shape[2]):
                    last_log[k, j] = log[n, k, j]
        for j in range(size):
            state[j] = states[len(angles) - 1, j]
        return iterations, -1

    return advance


advance_modes = _compiled(source_digest(__file__))
