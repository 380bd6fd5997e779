"""Integrals for the books of the linear parts, exact for an integrator that follows a `Flow`.

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

from mbd.integrators.base import Block, Flow
from mbd.integrators.exponential import phi_functions

NODES = 64  # of the Gauss quadrature of chi, exact to rounding for |z| < 40
UNDAMPED = 1e-13  # |values_a + values_b| below this share of |values|: the pair dissipates nothing


class FlowWork:
    """Accumulates the blocks of a run of an integrator with a `Flow`, of steps of length ``step``."""

    def __init__(self, flow: Flow, step: float) -> None:
        self._flow, self._step = flow, step
        self._n_signals = flow.rows.shape[1] + 3  # lambda, acceleration, 1, speed
        self._products, self._gram = np.zeros((0, 0)), np.zeros((0, 0))
        self._first, self._last, self._speed = np.zeros(0), np.zeros(0), 0.0

    def take(self, block: Block, accelerations: np.ndarray, speeds: np.ndarray) -> None:
        """Add the steps that end at the instants of ``block``; the first block is the start alone."""
        if self._last.size == 0:
            self._first = self._last = block.states[0].copy()
            self._speed = float(speeds[0])
            width = block.holds.shape[1] * self._n_signals
            self._products, self._gram = np.zeros((width, self._last.size)), np.zeros((width, width))
            return
        n, past, m = block.holds.shape
        pieces = np.zeros((n, past, self._n_signals))
        pieces[:, :, :m] = block.holds
        pieces[:, 0, m], pieces[:, 0, m + 1] = accelerations, 1.0
        pieces[1:, 0, m + 2], pieces[0, 0, m + 2] = speeds[:-1], self._speed
        pieces[:, 1, m + 2] = self._step * accelerations
        flat = pieces.reshape(n, -1)
        used = np.flatnonzero(flat.any(axis=0))
        flat = np.ascontiguousarray(flat[:, used])
        self._products[used] += flat.T @ block.starts
        self._gram[np.ix_(used, used)] += flat.T @ flat
        self._last, self._speed = block.states[-1].copy(), float(speeds[-1])

    def integrals(self) -> tuple[np.ndarray, np.ndarray]:
        """int s x^T dt (signal, state) and int x x^T dt (state, state), x = (Re eta, Im eta)."""
        pushed = self._pushed()
        return np.hstack([pushed.real, pushed.imag]), self._second(pushed)

    def _pushed(self) -> np.ndarray:
        """int s eta dt (signal, mode)."""
        flow, h, modes = self._flow, self._step, len(self._flow.values)
        past = len(self._gram) // self._n_signals
        products = (self._products[:, :modes] + 1j * self._products[:, modes:]).reshape(past, self._n_signals, modes)
        gram = self._gram.reshape(past, self._n_signals, past, self._n_signals)
        inputs = self._inputs()
        psi, chi = _moments(flow.values * h, past)
        total = h * np.einsum("kj,kij->ij", psi, products)
        for k in range(past):
            for j in range(past):
                total += h * h * chi[k, j] * (gram[k, :, j] @ inputs.T)
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
