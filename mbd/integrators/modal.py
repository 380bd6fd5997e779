"""Integrator that steps complex modes: what its compiled loop (`mbd.integrators.modal_loop`) needs, made once.

In modal coordinates p the linear reference is x' = A x + (0, g) with x = (omega p, p'), A = [[0, omega], [-omega, -C]].
A = V diag(lambda) V^-1, so eta = V^-1 x obeys eta_j' = lambda_j eta_j + (V^-1)_j (0, g): of every conjugate pair one is
kept. A method supplies its `Hold`,

    eta_new = E eta + sum_s w_s g_(n+1-s) + w (constant load and ramp inertia).

Where the forces do not fit a step, it is cut (`mbd.integrators.modal_loop`).

The rows depend on the new forces by constant matrices, u = u_p + G_u lambda; a Newton iteration over the rows alone
finds lambda. Since a modal velocity is lambda_j times its displacement, one matrix gives the rows and their rates.
Cost per step: O(modes x rows).
"""

from __future__ import annotations

import copy
import logging
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import linalg

from mbd.elements.element import LOG_COLUMNS
from mbd.elements.newton import solve_rows
from mbd.elements.table import Instant, instant
from mbd.integrators.base import LENGTH, TOLERANCE, Block, Flow, join
from mbd.integrators.modal_loop import QUARTERS, Constants, Memory, advance_modes, room
from mbd.parts.checks import StepError
from mbd.system.rolling_frame import RollingFrame
from mbd.system.statics import State
from mbd.system.system import System

logger = logging.getLogger(__name__)

PERTURBATIONS = (0.0, 1e-9, 1e-7, 1e-5)  # shares of the damping
LARGEST_CONDITION = 1e8
LARGEST_RESIDUAL = 1e-9


class Hold(NamedTuple):
    """How a method takes the forces within a step; complex, per mode."""

    growth: np.ndarray  # E (mode,)
    weights: np.ndarray  # w_s (s, mode) of the modal forces at the new instant, the one before, ...
    constant: np.ndarray  # w (mode,) of forces that do not change within the step
    powers: np.ndarray  # (k, s): the held force is sum_k theta^k sum_s powers[k, s] g_(n+1-s)


Holds = Callable[[np.ndarray, float], list[Hold]]  # of eigenvalues and step, see `mbd.integrators.modal_loop.Constants`


class ModalIntegrator:
    """Integrator (see `mbd.integrators.base`) over complex modes.

    ``levels`` lengths of step, each a quarter of the one before; ``exact`` if the held forces are integrated exactly.
    """

    def __init__(self, system: System, step: float, holds: Holds, levels: int, exact: bool) -> None:
        basis, omega = system.basis, system.frequencies
        values, vectors, inverse = complex_modes(omega, basis.T @ system.damping @ basis)
        n = len(omega)
        rotation = np.where(values.imag == 0.0, 1.0, 2.0)  # a pair counts twice its kept member
        moved = vectors[:n] / omega[:, None] * rotation
        self.displacement, self.velocity = basis @ _real_rows(moved), basis @ _real_rows(vectors[n:] * rotation)
        self.inverse_mass = basis @ basis.T
        self.counters = {"steps": 0, "cuts": 0, "iterations": 0}
        self._system, self._step, self._time = system, step, 0.0
        to_modal = basis.T @ system.mass
        self._from_displacement = inverse[:, :n] @ (omega[:, None] * to_modal)
        self._from_velocity = inverse[:, n:] @ to_modal
        enter = inverse[:, n:] @ basis.T  # forces on coordinates -> modes
        flow = Flow(
            values, enter @ system.rows.T, enter @ system.constant_force, -enter @ (system.mass @ system.rolling)
        )
        self.flow = flow if exact else None
        rows = system.all_rows @ basis @ moved

        def constants(length: float) -> Constants:
            return _constants(holds, length / float(QUARTERS) ** np.arange(levels), flow, rows, system.frame)

        self._constants_of = constants
        self._constants = constants(step)
        self._memory: Memory | None = None

    def start(self, state: State) -> Block:
        """Set the state at t = 0."""
        table, constants = self._system.table, self._constants
        eta = _stack(self._from_displacement @ state.displacement + self._from_velocity @ state.velocity)
        now = instant(table)
        m, past = len(state.forces), constants.powers.shape[1]
        u = constants.rows @ eta
        v = self._system.rows @ (self.velocity @ eta)
        still = np.zeros((len(u), m))
        forces = state.forces.copy()
        used = solve_rows(
            table, (state.motor_angle, state.motor_speed, 0.0), u_p=u, v_p=v, g_u=still, g_v=still[:m].copy(),
            force=forces, u=u.copy(), v=v.copy(), now=now, tolerance=TOLERANCE,
        )  # fmt: skip
        if used < 0:
            raise StepError("the forces at t = 0 could not be evaluated; the state is not finite.")
        self._time = 0.0
        self._memory = Memory(
            state=eta,
            forces=np.tile(state.forces, (3, 1)),
            pushes=np.tile(state.forces @ constants.enter, (past, 1)),
            past=np.full(2, self._step),
            counts=np.zeros(4, dtype=np.int64),
            motor=np.array([state.motor_angle, state.motor_speed, 0.0]),
            rows=u.copy(),
            elements=now,
        )
        states, clock = eta[None].copy(), np.array([[0.0, state.motor_angle, state.motor_speed, 0.0]])
        holds = np.zeros((1, past, m))
        return Block(
            states=states,
            starts=states,
            forces=forces[None],
            rows=u[None],
            elastic=now.elastic[None].copy(),
            lost=now.lost[None].copy(),
            log=now.log[None].copy(),
            clock=clock,
            whole=np.zeros(1, dtype=np.int64),
            holds=holds,
        )

    def advance(
        self, angles: np.ndarray, speeds: np.ndarray, accelerations: np.ndarray, like: Block | None = None
    ) -> Block:
        """Take len(angles) steps.

        Parameters
        ----------
        angles, speeds, accelerations : (step,) of the motor as in `mbd.integrators.base`, rad, rad/s and rad/s2
        like : block whose cuts of the same steps are taken, or None
        """
        plan = np.zeros(0, dtype=np.int64) if like is None else self._levels(like)
        parts, done = [], 0
        while done < len(angles):
            part, done = self._fill(done, angles, accelerations, plan)
            plan = plan[len(part.states) :]
            parts.append(part)
        return join(parts)

    def branch(self, change: np.ndarray) -> ModalIntegrator:
        """A second integrator at this instant, its state moved by ``change`` (x,)."""
        assert self._memory is not None, "call start first"
        other = copy.copy(self)
        other.counters = dict(self.counters)
        other._memory = _copied(self._memory)
        other._memory.state[:] += change
        return other

    def halved(self) -> ModalIntegrator:
        """A second integrator at this instant with half the step."""
        other = self.branch(np.zeros(self.displacement.shape[1]))
        other._step = 0.5 * self._step
        other._constants = self._constants_of(other._step)
        assert other._memory is not None
        other._memory.counts[0] = 0  # the earlier instants are spaced wider than the holds of its steps assume
        return other

    def _levels(self, block: Block) -> np.ndarray:
        """Levels (instant,) of the steps of a block."""
        quarters = np.log(self._step / block.clock[:, LENGTH]) / np.log(QUARTERS)
        return np.round(quarters).astype(np.int64)

    def _fill(self, done: int, angles: np.ndarray, accelerations: np.ndarray, plan: np.ndarray) -> tuple[Block, int]:
        """One block from step ``done`` on, as far as its arrays reach, and the steps done then."""
        constants, table, memory = self._constants, self._system.table, self._memory
        assert memory is not None, "call start first"
        units = QUARTERS ** (len(constants.length) - 1)
        n, m, past = max(len(angles) - done, len(plan)) + units, constants.enter.shape[0], constants.powers.shape[1]
        instants = np.empty((n + 1, len(memory.state)))
        instants[0] = memory.state
        block = Block(
            states=instants[1:],
            starts=instants[:-1],
            forces=np.empty((n, m)),
            rows=np.empty((n, len(constants.rows))),
            elastic=np.empty((n, m)),
            lost=np.empty((n, m)),
            log=np.empty((n, len(table.rule), len(LOG_COLUMNS))),
            clock=np.empty((n, 4)),
            whole=np.zeros(len(angles), dtype=np.int64),
            holds=np.empty((n, past, m)),
        )
        now, used, iterations, failed = advance_modes(
            table,
            done,
            angles,
            accelerations,
            constants,
            memory,
            block,
            TOLERANCE,
            plan,
            room(m, len(constants.rows), len(memory.state)),
        )
        if failed:
            at = self.counters["steps"] + now - done
            raise StepError(
                f"time step {at} (t = {(at + 1) * self._step:.6g} s, h = {constants.length[-1]:.3g} s): the contact "
                "forces did not converge. Use a smaller step."
            )
        self.counters["steps"] += now - done
        self.counters["cuts"] += used - (now - done)
        self.counters["iterations"] += iterations
        whole = block.whole[done:now]
        return Block(*(x[:used] for x in block))._replace(whole=whole), now


def _copied(memory: Memory) -> Memory:
    arrays = {name: value.copy() for name, value in memory._asdict().items() if name != "elements"}
    return Memory(elements=Instant(*(array.copy() for array in memory.elements)), **arrays)


def _constants(holds: Holds, lengths: np.ndarray, flow: Flow, rows: np.ndarray, frame: RollingFrame) -> Constants:
    """``rows`` (m + observed, mode) complex."""
    m, values = flow.rows.shape[1], flow.values
    table = [holds(values, float(h)) for h in lengths]  # level, hold
    past, size = max(len(hold.weights) for hold in table[0]), (len(lengths), len(table[0]))
    weights, powers = np.zeros((*size, past, len(values)), dtype=complex), np.zeros((size[1], past, past))
    for level, level_holds in enumerate(table):
        for k, hold in enumerate(level_holds):
            weights[level, k, : len(hold.weights)] = hold.weights
            powers[k, : len(hold.weights), : len(hold.weights)] = hold.powers
    new = weights[:, :, 0, :, None] * flow.rows  # modal displacement per new force
    constant = np.array([level_holds[0].constant for level_holds in table])
    return Constants(
        length=lengths,
        growth=_stack(np.array([level_holds[0].growth for level_holds in table])),
        rate=_stack(values),
        weights=_stack(weights),
        powers=powers,
        load=_stack(constant * flow.load),
        ramp=_stack(constant * flow.ramp),
        enter=_stack(flow.rows.T),
        rows=_real_rows(rows),
        g_u=np.ascontiguousarray((rows @ new).real),
        g_v=np.ascontiguousarray(((rows[:m] * values) @ new).real),
        frame=frame,
    )


def complex_modes(omega: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues (k,), vectors (2 mode, k) and inverse rows (k, 2 mode) of A, one of every conjugate pair.

    At critical damping two eigenvectors fall together and A has too few of them. The damping is then changed by the
    least of PERTURBATIONS that parts them, with a warning: the modes move by about its square root at most.

    Raises
    ------
    StepError : A cannot be diagonalised reliably even so
    """
    found = condition, residual = np.inf, np.inf
    for share in PERTURBATIONS:
        uneven = 1.0 + share * np.linspace(1.0, 2.0, len(omega))
        changed = damping * np.sqrt(np.outer(uneven, uneven))  # stays positive semidefinite
        modes, condition, residual = _diagonalise(omega, changed)
        if condition < LARGEST_CONDITION and residual < LARGEST_RESIDUAL:
            if share:
                logger.warning(
                    "complex modes: a mode is critically damped (condition %.3g); damping changed by %.0e of itself.",
                    found[0], share,
                )  # fmt: skip
            return modes
        found = min(found, (condition, residual))
    raise StepError(
        f"complex modes: condition {condition:.3g} (limit {LARGEST_CONDITION:.0e}), residual {residual:.3g} (limit "
        f"{LARGEST_RESIDUAL:.0e}): some mode is critically damped. Change a damping value slightly or use the "
        "generalised-alpha integrator."
    )


def _diagonalise(
    omega: np.ndarray, damping: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], float, float]:
    """What `complex_modes` returns, condition of the vectors and residual of the decomposition.

    With one of every pair, x = sum c_k Re v_k + sum c'_k Im v_k. Its real matrix takes a quarter of the time to invert.
    """
    n = len(omega)
    matrix = np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -damping]])
    values, vectors = linalg.eig(matrix)
    kept = values.imag >= 0.0
    values, vectors = values[kept], vectors[:, kept]
    pairs = values.imag > 0.0
    times = np.where(pairs, 2.0, 1.0)
    inverse = np.full(vectors.T.shape, np.inf, dtype=complex)
    try:
        rows = np.linalg.inv(np.hstack([vectors.real, vectors.imag[:, pairs]]))
    except np.linalg.LinAlgError:
        return (values, vectors, inverse), np.inf, np.inf
    inverse[:] = rows[: len(values)]
    inverse[pairs] = 0.5 * (inverse[pairs] - 1j * rows[len(values) :])
    sizes = np.linalg.norm(vectors * np.sqrt(times)), np.linalg.norm(inverse * np.sqrt(times)[:, None])
    moved = vectors * (values * times)
    residual = float(abs(moved.real @ inverse.real - moved.imag @ inverse.imag - matrix).max() / abs(matrix).max())
    return (values, vectors, inverse), float(sizes[0] * sizes[1]) / (2 * n), residual


def _real_rows(rows: np.ndarray) -> np.ndarray:
    """Rows on (Re eta, Im eta) that give Re(rows @ eta)."""
    return np.ascontiguousarray(np.hstack([rows.real, -rows.imag]))


def _stack(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(np.concatenate([values.real, values.imag], axis=-1))
