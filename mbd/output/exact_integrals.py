"""Integrals for the energy balance of the linear parts, exact for an integrator that follows a `Flow`.

eta' = values eta + sum_i r_i s_i(t) with the signals s = lambda (polynomials of degree p within a step, see `Block`),
the motor acceleration (held), 1, and the motor speed (linear, enters nothing). With theta = 0..1 over a step of length
h, s_i = sum_k c_ik theta^k and z = values h,

    int s_i eta dt = h sum_k psi_k(z) c_ik eta_start + h^2 sum_kl chi_kl(z) c_ik sum_j r_j c_jl,
    psi_k = int_0^1 theta^k e^(z theta) d theta,   chi_kl = int_0^1 theta^k l! theta^(l+1) phi_(l+1)(z theta) d theta,

so per step only the products c eta_start and c c^T are summed. The integral of eta_a eta_b, which all dissipation and
all works of springs follow from, needs no sum: eta_a eta_b changes by (values_a + values_b) eta_a eta_b + the works of
the signals, so it is (change - works)/(values_a + values_b). Nothing is sampled and no mode is too fast for the step.
"""

from __future__ import annotations

import math

import numpy as np

from mbd.integrators.base import ACCELERATION, LENGTH, SPEED, Block, Flow
from mbd.integrators.phi_functions import phi_functions

NODES = 64  # of the Gauss quadrature of chi, exact to rounding for |z| < 40
UNDAMPED = 1e-13  # |values_a + values_b| below this share of |values|: the pair dissipates nothing


class FlowWork:
    """Accumulates the blocks of a run of an integrator with a `Flow`."""

    def __init__(self, flow: Flow, steps: int) -> None:
        self._flow, self.steps = flow, steps
        self._n_signals = flow.rows.shape[1] + 3  # lambda, acceleration, 1, speed
        self._sums: dict[float, tuple[np.ndarray, np.ndarray]] = {}  # by length of step: c eta_start, c c^T
        self._first, self._last = np.zeros(0), np.zeros(0)

    def take(self, block: Block, first: int) -> None:
        """Add the steps that end at the instants of ``block``, of which ``first`` is 0 for the start alone."""
        self._last = block.states[-1].copy()
        if first == 0:
            self._first = block.states[0].copy()
            return
        lengths = block.clock[:, LENGTH]
        for length in np.unique(lengths):
            some = lengths == length
            self._add(float(length), self._pieces(block.holds[some], block.clock[some]), block.starts[some])

    def _pieces(self, holds: np.ndarray, clock: np.ndarray) -> np.ndarray:
        """c (step, k, signal)."""
        n, past, m = holds.shape
        pieces = np.zeros((n, past, self._n_signals))
        pieces[:, :, :m] = holds
        turned = clock[:, LENGTH] * clock[:, ACCELERATION]
        pieces[:, 0, m], pieces[:, 0, m + 1] = clock[:, ACCELERATION], 1.0
        pieces[:, 0, m + 2], pieces[:, 1, m + 2] = clock[:, SPEED] - turned, turned
        return pieces

    def _add(self, length: float, pieces: np.ndarray, starts: np.ndarray) -> None:
        flat = pieces.reshape(len(pieces), -1)
        size = flat.shape[1]
        if length not in self._sums:
            self._sums[length] = np.zeros((size, starts.shape[1])), np.zeros((size, size))
        products, gram = self._sums[length]
        used = np.flatnonzero(flat.any(axis=0))
        flat = np.ascontiguousarray(flat[:, used])
        products[used] += flat.T @ starts
        gram[np.ix_(used, used)] += flat.T @ flat

    def integrals(self) -> tuple[np.ndarray, np.ndarray]:
        """int s x^T dt (signal, state) and int x x^T dt (state, state), x = (Re eta, Im eta)."""
        pushed = self._pushed()
        return np.hstack([pushed.real, pushed.imag]), self._second(pushed)

    def _pushed(self) -> np.ndarray:
        """int s eta dt (signal, mode)."""
        values, signals, modes = self._flow.values, self._n_signals, len(self._flow.values)
        inputs, total = self._inputs(), np.zeros((signals, modes), dtype=complex)
        for h, (products, gram) in self._sums.items():
            past = len(gram) // signals
            started = (products[:, :modes] + 1j * products[:, modes:]).reshape(past, signals, modes)
            psi, chi = _moments(values * h, past)
            total += h * np.einsum("kj,kij->ij", psi, started)
            blocks = gram.reshape(past, signals, past, signals)
            for k in range(past):
                for j in range(past):
                    total += h * h * chi[k, j] * (blocks[k, :, j] @ inputs.T)
        return total

    def _inputs(self) -> np.ndarray:
        """r (mode, signal)."""
        flow = self._flow
        return np.column_stack([flow.rows, flow.ramp, flow.load, np.zeros(len(flow.values))])

    def _second(self, pushed: np.ndarray) -> np.ndarray:
        values, inputs, modes = self._flow.values, self._inputs(), len(self._flow.values)
        ends = [x[:modes] + 1j * x[modes:] for x in (self._first, self._last)]
        plain, mixed = inputs @ pushed, inputs @ pushed.conj()
        change = [np.outer(ends[1], e) - np.outer(ends[0], s) for s, e in (ends, [x.conj() for x in ends])]
        both = _divide(change[0] - plain - plain.T, values[:, None] + values, values)
        twisted = _divide(change[1] - mixed - mixed.conj().T, values[:, None] + values.conj(), values)
        off = 0.5 * (both - twisted).imag
        return np.block([[0.5 * (both + twisted).real, off], [off.T, 0.5 * (twisted - both).real]])


def _divide(work: np.ndarray, rate: np.ndarray, values: np.ndarray) -> np.ndarray:
    still = abs(rate) < UNDAMPED * abs(values)
    return np.where(still, 0.0, work / np.where(still, 1.0, rate))


def _moments(z: np.ndarray, past: int) -> tuple[np.ndarray, np.ndarray]:
    """psi (k, z) and chi (k, l, z)."""
    phi = phi_functions(z, past)
    psi = np.zeros((past, len(z)), dtype=complex)
    for k in range(past):
        for j in range(k + 1):  # theta = 1 - s
            psi[k] += math.comb(k, j) * (-1) ** j * math.factorial(j) * phi[j + 1]
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    theta, weights = 0.5 * (nodes + 1), 0.5 * weights
    inner = phi_functions(np.outer(theta, z), past)
    chi = np.zeros((past, past, len(z)), dtype=complex)
    for k in range(past):
        for j in range(past):
            chi[k, j] = math.factorial(j) * (weights * theta ** (k + j + 1)) @ inner[j + 1]
    return psi, chi
