"""The compiled loop shared by the methods that step complex modes.

In modal coordinates p the linear reference is x' = A x + (0, g) with x = (omega p, p'), A = [[0, omega], [-omega, -C]].
A = V diag(lambda) V^-1, so eta = V^-1 x obeys eta_j' = lambda_j eta_j + (V^-1)_j (0, g): of every conjugate pair one is
kept. A method supplies three numbers per mode,

    eta_new = E eta + a g_old + b g_new,

where g_old and g_new are the forces at both ends of the step (constant load and ramp inertia are the same at both).
The rows depend on the new forces by constant matrices, u = u_p + G_u lambda; a Newton iteration over the rows alone
finds lambda. Cost per step: O(modes x rows).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from scipy import linalg

from mbd.checks import StepError
from mbd.forces import LOG_COLUMNS, parametric_work
from mbd.integrators.base import TOLERANCE, Block
from mbd.rows_solver import iterate, solve_rows, source_digest
from mbd.statics import State
from mbd.system import System

Coefficients = Callable[[np.ndarray, float], tuple[np.ndarray, np.ndarray, np.ndarray]]
LARGEST_CONDITION = 1e8
LARGEST_RESIDUAL = 1e-9


class ModalIntegrator:
    """Integrator (see `mbd.integrators.base`) over complex modes with the given ``coefficients(lambda, h)``."""

    def __init__(self, system: System, step: float, coefficients: Coefficients, linear_forces: bool) -> None:
        basis, omega = system.basis, system.frequencies
        eigenvalues, vectors, inverse = complex_modes(omega, basis.T @ system.damping @ basis)
        n = len(omega)
        growth, old, new = coefficients(eigenvalues, step)
        rotation = np.where(eigenvalues.imag == 0.0, 1.0, 2.0)  # a pair counts twice its kept member
        stacked = [_real_rows(part * rotation) for part in (vectors[:n] / omega[:, None], vectors[n:])]
        self.displacement, self.velocity = (basis @ part for part in stacked)
        self.inverse_mass, self.linear_forces = basis @ basis.T, linear_forces
        self.counters = {"steps": 0, "iterations": 0}
        self._system, self._step, self._time = system, step, 0.0
        to_modal = basis.T @ system.mass
        self._from_displacement = inverse[:, :n] @ (omega[:, None] * to_modal)
        self._from_velocity = inverse[:, n:] @ to_modal
        enter = inverse[:, n:] @ basis.T  # forces on coordinates -> modes
        rows = enter @ system.rows.T
        self._growth = np.concatenate([growth.real, growth.imag])
        self._old, self._new = _stack((old[:, None] * rows).T), _stack((new[:, None] * rows).T)
        self._constant = _stack((old + new) * (enter @ system.constant_force))
        self._ramp = _stack(-(old + new) * (enter @ (system.mass @ system.rolling)))
        self._u_rows = np.ascontiguousarray(system.all_rows @ self.displacement)
        self._v_rows = np.ascontiguousarray(system.rows @ self.velocity)
        self._g_u, self._g_v = self._u_rows @ self._new.T, self._v_rows @ self._new.T
        self._state = np.zeros(2 * len(eigenvalues))
        self._forces = np.zeros((2, len(system.rows)))
        self._angle, self._last = 0.0, np.zeros(0)
        self._log = np.zeros((0, 0))

    def start(self, state: State) -> Block:
        """Set the state at t = 0."""
        eta = self._from_displacement @ state.displacement + self._from_velocity @ state.velocity
        self._state = _stack(eta)
        self._forces = np.array([state.forces, state.forces])
        self._time = 0.0
        table = self._system.table
        log = np.zeros((1, len(table.tau) + len(table.rope_ea), len(LOG_COLUMNS)))
        u, v = self._u_rows @ self._state, self._v_rows @ self._state
        zero_u, zero_v = np.zeros_like(self._g_u), np.zeros_like(self._g_v)
        forces = state.forces.copy()
        used = solve_rows(table, state.motor_angle, u, v, zero_u, zero_v, forces, u.copy(), v.copy(), log[0], TOLERANCE)
        if used < 0:
            raise StepError("the forces at t = 0 could not be evaluated; the state is not finite.")
        self._angle, self._last, self._log = state.motor_angle, u, log[0]
        return Block(self._state[None].copy(), forces[None], u[None], log)

    def advance(self, angles: np.ndarray, accelerations: np.ndarray) -> Block:
        """Take len(angles) steps."""
        n, (m, table) = len(angles), (len(self._system.rows), self._system.table)
        block = Block(
            np.empty((n, len(self._state))),
            np.empty((n, m)),
            np.empty((n, len(self._u_rows))),
            np.zeros((n, len(table.tau) + len(table.rope_ea), len(LOG_COLUMNS))),
        )
        iterations, failed = advance_modes(
            table, angles, accelerations, self._growth, self._old, self._new, self._constant, self._ramp,
            self._u_rows, self._v_rows, self._g_u, self._g_v, self._state, self._forces, self._angle, self._last,
            self._log, *block, TOLERANCE,
        )  # fmt: skip
        if failed >= 0:
            raise StepError(
                f"time step {self.counters['steps'] + failed} (t = {self._time + (failed + 1) * self._step:.6g} s, "
                f"h = {self._step:.3g} s): the contact forces did not converge. Use a smaller step."
            )
        self.counters["steps"] += n
        self.counters["iterations"] += iterations
        self._time += n * self._step
        self._state, self._angle = block.states[-1].copy(), float(angles[-1])
        self._last, self._log = block.rows[-1].copy(), block.log[-1].copy()
        return block


def complex_modes(omega: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues (k,), vectors (2 mode, k) and inverse rows (k, 2 mode) of A, one of every conjugate pair.

    Raises
    ------
    StepError : A cannot be diagonalised reliably (nearly equal modes at critical damping)
    """
    n = len(omega)
    matrix = np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -damping]])
    values, vectors = linalg.eig(matrix)
    try:
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        inverse = np.full_like(vectors, np.inf)
    condition = float(np.linalg.norm(vectors) * np.linalg.norm(inverse)) / (2 * n)
    residual = float(abs((vectors * values) @ inverse - matrix).max() / abs(matrix).max())
    if not (condition < LARGEST_CONDITION and residual < LARGEST_RESIDUAL):
        raise StepError(
            f"complex modes: condition {condition:.3g} (limit {LARGEST_CONDITION:.0e}), residual {residual:.3g} (limit "
            f"{LARGEST_RESIDUAL:.0e}): some mode is critically damped. Change a damping value slightly or use the "
            "generalised-alpha integrator."
        )
    keep = values.imag >= 0.0
    return values[keep], vectors[:, keep], inverse[keep]


def _real_rows(rows: np.ndarray) -> np.ndarray:
    """Rows on (Re eta, Im eta) that give Re(rows @ eta)."""
    return np.hstack([rows.real, -rows.imag])


def _stack(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(np.concatenate([values.real, values.imag], axis=-1))


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
def _free_step(before, growth, constant, ramp, acceleration, after):
    """after = E before + the part of the prescribed forces."""
    n = len(before) // 2
    for j in range(n):
        r, i, er, ei = before[j], before[n + j], growth[j], growth[n + j]
        after[j] = er * r - ei * i + constant[j] + acceleration * ramp[j]
        after[n + j] = er * i + ei * r + constant[n + j] + acceleration * ramp[n + j]


def _compiled(digest: int) -> Callable:
    @njit(cache=True, nogil=True, error_model="numpy")
    def advance(
        table, angles, accelerations, growth, old, new, constant, ramp, u_rows, v_rows, g_u, g_v,
        state, memory, last_angle, last_rows, last_log, states, forces, rows, log, tolerance,
    ):  # fmt: skip
        if digest < 0:  # part of the key under which the compiled code is stored
            return -1, 0
        m = len(v_rows)
        u_p, v_p, v, guess = np.empty(len(u_rows)), np.empty(m), np.empty(m), np.empty(m)
        iterations = 0
        before = state
        for n in range(len(angles)):
            eta = states[n]
            _free_step(before, growth, constant, ramp, accelerations[n], eta)
            for r in range(m):
                if memory[0, r] != 0.0:
                    _add(eta, memory[0, r], old[r])
                guess[r] = 2.0 * memory[0, r] - memory[1, r]
            for r in range(len(u_rows)):
                u_p[r] = _dot(u_rows[r], eta)
            for r in range(m):
                v_p[r] = _dot(v_rows[r], eta)
            used = iterate(table, angles[n], u_p, v_p, g_u, g_v, guess, rows[n], v, log[n], tolerance)
            if used < 0:
                return iterations, n
            iterations += used
            if n > 0:
                last_angle, last_rows, last_log = angles[n - 1], rows[n - 1], log[n - 1]
            parametric_work(table, last_angle, angles[n], last_rows, rows[n], last_log, log[n])
            for r in range(m):
                if guess[r] != 0.0:
                    _add(eta, guess[r], new[r])
                memory[1, r] = memory[0, r]
                memory[0, r] = guess[r]
                forces[n, r] = guess[r]
            before = eta
        return iterations, -1

    return advance


advance_modes = _compiled(source_digest(__file__))
