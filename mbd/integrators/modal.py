"""Integrator that steps complex modes: what its compiled loop (`mbd.integrators.modal_loop`) needs, made once.

In modal coordinates p the linear reference is x' = A x + (0, g) with x = (omega p, p'), A = [[0, omega], [-omega, -C]].
A = V diag(lambda) V^-1, so eta = V^-1 x obeys eta_j' = lambda_j eta_j + (V^-1)_j (0, g): of every conjugate pair one is
kept. A method supplies its `Hold`,

    eta_new = E eta + sum_s w_s g_(n+1-s) + w (constant load and ramp inertia).

The rows depend on the new forces by constant matrices, u = u_p + G_u lambda; a Newton iteration over the rows alone
finds lambda. Since a modal velocity is lambda_j times its displacement, one matrix gives the rows and their rates.
Cost per step: O(modes x rows).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import linalg

from mbd.checks import StepError
from mbd.forces import LOG_COLUMNS, element_count
from mbd.integrators.base import TOLERANCE, Block, Flow
from mbd.integrators.modal_loop import Constants, Memory, advance_modes
from mbd.rows_solver import solve_rows
from mbd.statics import State
from mbd.system import System

LARGEST_CONDITION = 1e8
LARGEST_RESIDUAL = 1e-9


class Hold(NamedTuple):
    """How a method takes the forces within a step; complex, per mode."""

    growth: np.ndarray  # E (mode,)
    weights: np.ndarray  # w_s (s, mode) of the modal forces at the new instant, the one before, ...
    constant: np.ndarray  # w (mode,) of forces that do not change within the step
    powers: np.ndarray  # (k, s): the held force is sum_k theta^k sum_s powers[k, s] g_(n+1-s)


Holds = Callable[[np.ndarray, float], tuple[Hold, Hold]]  # after a kink, else


class ModalIntegrator:
    """Integrator (see `mbd.integrators.base`) over complex modes; ``exact`` if the held forces are integrated exactly."""

    def __init__(self, system: System, step: float, holds: Holds, exact: bool) -> None:
        basis, omega = system.basis, system.frequencies
        values, vectors, inverse = complex_modes(omega, basis.T @ system.damping @ basis)
        n = len(omega)
        rotation = np.where(values.imag == 0.0, 1.0, 2.0)  # a pair counts twice its kept member
        moved = vectors[:n] / omega[:, None] * rotation
        self.displacement, self.velocity = basis @ _real_rows(moved), basis @ _real_rows(vectors[n:] * rotation)
        self.inverse_mass = basis @ basis.T
        self.counters = {"steps": 0, "iterations": 0}
        self._system, self._step, self._time = system, step, 0.0
        to_modal = basis.T @ system.mass
        self._from_displacement = inverse[:, :n] @ (omega[:, None] * to_modal)
        self._from_velocity = inverse[:, n:] @ to_modal
        enter = inverse[:, n:] @ basis.T  # forces on coordinates -> modes
        rows, constant = enter @ system.rows.T, enter @ system.constant_force
        ramp = -enter @ (system.mass @ system.rolling)
        self.flow = Flow(values, rows, constant, ramp) if exact else None
        self._constants = _constants(holds(values, step), values, rows, constant, ramp, system.all_rows @ basis @ moved)
        self._memory: Memory | None = None

    def start(self, state: State) -> Block:
        """Set the state at t = 0."""
        table, constants = self._system.table, self._constants
        eta = _stack(self._from_displacement @ state.displacement + self._from_velocity @ state.velocity)
        log = np.zeros((1, element_count(table), len(LOG_COLUMNS)))
        m, past = len(state.forces), constants.weights.shape[1]
        u = constants.rows @ eta
        v = self._system.rows @ (self.velocity @ eta)
        still = np.zeros((len(u), m))
        forces = state.forces.copy()
        used = solve_rows(
            table,
            state.motor_angle,
            state.motor_speed,
            u,
            v,
            still,
            still[:m].copy(),
            forces,
            u.copy(),
            v.copy(),
            log[0],
            TOLERANCE,
        )
        if used < 0:
            raise StepError("the forces at t = 0 could not be evaluated; the state is not finite.")
        self._time = 0.0
        self._memory = Memory(
            state=eta,
            forces=np.tile(state.forces, (3, 1)),
            pushes=np.tile(state.forces @ constants.enter, (past, 1)),
            smooth=np.zeros(1, dtype=np.int64),
            angle=np.array([state.motor_angle]),
            rows=u.copy(),
            log=log[0].copy(),
        )
        states = eta[None].copy()
        return Block(states, states, forces[None], u[None], log, np.zeros((1, past, m)))

    def advance(self, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray) -> Block:
        """Take len(angles) steps."""
        constants, table = self._constants, self._system.table
        assert self._memory is not None, "call start first"
        n, m, past = len(angles), constants.enter.shape[0], constants.weights.shape[1]
        instants = np.empty((n + 1, len(self._memory.state)))
        instants[0] = self._memory.state
        block = Block(
            instants[1:],
            instants[:-1],
            np.empty((n, m)),
            np.empty((n, len(constants.rows))),
            np.zeros((n, element_count(table), len(LOG_COLUMNS))),
            np.empty((n, past, m)),
        )
        iterations, failed = advance_modes(
            table, angles, speeds, accelerations, constants, self._memory, block, TOLERANCE
        )
        if failed >= 0:
            raise StepError(
                f"time step {self.counters['steps'] + failed} (t = {self._time + (failed + 1) * self._step:.6g} s, "
                f"h = {self._step:.3g} s): the contact forces did not converge. Use a smaller step."
            )
        self.counters["steps"] += n
        self.counters["iterations"] += iterations
        self._time += n * self._step
        return block


def _constants(
    holds: tuple[Hold, Hold], values: np.ndarray, enter: np.ndarray, load: np.ndarray, ramp: np.ndarray,
    rows: np.ndarray,
) -> Constants:  # fmt: skip
    """``enter`` (mode, m) and ``rows`` (m + mesh, mode) complex."""
    past = max(len(hold.weights) for hold in holds)
    m = enter.shape[1]
    weights = np.zeros((2, past, len(values)), dtype=complex)
    powers = np.zeros((2, past, past))
    for k, hold in enumerate(holds):
        weights[k, : len(hold.weights)] = hold.weights
        powers[k, : len(hold.weights), : len(hold.weights)] = hold.powers
    new = enter[None] * weights[:, 0, :, None]  # modal displacement per new force
    last = holds[-1]
    return Constants(
        growth=_stack(last.growth),
        rate=_stack(values),
        weights=_stack(weights),
        powers=powers,
        load=_stack(last.constant * load),
        ramp=_stack(last.constant * ramp),
        enter=_stack(enter.T),
        rows=_real_rows(rows),
        g_u=np.ascontiguousarray((rows @ new).real),
        g_v=np.ascontiguousarray(((rows[:m] * values) @ new).real),
    )


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
    return np.ascontiguousarray(np.hstack([rows.real, -rows.imag]))


def _stack(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(np.concatenate([values.real, values.imag], axis=-1))
