"""Recorder: computes channels from blocks of states, low-pass filters them and stores a sample per output interval.

Samples go to ``values[:, first:last]`` as soon as they are complete: an array, or a `StoredArray` of any length.
The filter is a linear-phase FIR (Kaiser window): flat to ``PASS_SHARE`` of the output rate, at least
``ATTENUATION`` dB down at and above 1 - ``PASS_SHARE`` of it, so that the pass band is free of aliasing. The delay is
compensated: a sample at time t uses the steps around t. Before t = 0 the machine rests, so the first value is repeated.

References
----------
Oppenheim & Schafer (2010), Discrete-Time Signal Processing, section 7.6 (Kaiser window). It is implemented here because
importing SciPy's functions for it takes 1.5 s.
"""

from __future__ import annotations

import math

import numpy as np

from fem.storage.large_array_file import StoredArray
from mbd.integrators.base import ACCELERATION, ANGLE, SPEED, Block, Integrator
from mbd.parts.part_checks import StepError
from mbd.system.system import System

PASS_SHARE = 0.4
ATTENUATION = 80.0  # dB
CHUNK = 32  # samples filtered at once, as a matrix product


def low_pass(steps_per_sample: int) -> np.ndarray:
    """Filter taps (odd number, sum 1); the single tap 1 if every step is a sample."""
    if steps_per_sample == 1:
        return np.ones(1)
    width = 2 * (1 - 2 * PASS_SHARE) / steps_per_sample  # in units of the Nyquist frequency of the steps
    taps = math.ceil((ATTENUATION - 7.95) / (2.285 * math.pi * width) + 1)
    pairs = math.ceil((taps - 1) / (2 * steps_per_sample))  # the delay is a whole number of samples
    at = np.arange(-steps_per_sample * pairs, steps_per_sample * pairs + 1)
    result = np.sinc(at / steps_per_sample) * np.kaiser(len(at), 0.1102 * (ATTENUATION - 8.7))
    return result / result.sum()


def _filter_matrix(taps: np.ndarray, every: int) -> np.ndarray:
    """Matrix (step, sample) of CHUNK samples: the taps, shifted by ``every`` steps per sample."""
    matrix = np.zeros(((CHUNK - 1) * every + len(taps), CHUNK))
    for k in range(CHUNK):
        matrix[k * every : k * every + len(taps), k] = taps
    return matrix


class Recorder:
    """Stores the system's channels in `values` (channel, sample), a sample per ``steps_per_sample`` steps, at `rate`
    (Hz)."""

    def __init__(
        self,
        system: System,
        integrator: Integrator,
        steps_per_sample: int,
        rate: float,
        values: np.ndarray | StoredArray,
    ) -> None:
        rows, h = system.channels, integrator.inverse_mass
        self._states = (
            rows.displacement @ integrator.displacement
            + rows.velocity @ integrator.velocity
            - rows.acceleration
            @ h
            @ (system.damping @ integrator.velocity + system.stiffness @ integrator.displacement)
        )
        self._forces = rows.forces + rows.acceleration @ h @ system.rows.T
        self._constant = rows.acceleration @ h @ system.constant_force
        self._ramp = rows.rigid[:, 2] - rows.acceleration @ h @ (system.mass @ system.rolling)
        self._taps, self._every = low_pass(steps_per_sample), steps_per_sample
        self._filter = _filter_matrix(self._taps, steps_per_sample)
        self._pending = np.zeros((len(rows.names), 0))  # instants that later samples need
        self._next = 0  # next sample
        judged = rows.vibration if rows.vibration.any() else np.array(rows.units, dtype=object) == "N"
        self.signals = np.flatnonzero(judged)  # channels by which a run is judged: vibration, else the forces
        self._rigid, self._rate = rows.rigid, rate
        self._turned = np.zeros((0, 2))  # angle and speed of the frame at whole steps, from the next sample on
        self.values = values
        self.steps_needed = (values.shape[1] - 1) * steps_per_sample + len(self._taps) // 2

    def unfiltered(self, block: Block) -> np.ndarray:
        """Channels (channel, whole step) at the whole steps of a block."""
        cut = len(block.whole) < len(block.states)
        states, forces, clock = (x[block.whole] if cut else x for x in (block.states, block.forces, block.clock))
        values = self._states @ states.T + self._forces @ forces.T
        return values + self._constant[:, None] + np.outer(self._ramp, clock[:, ACCELERATION])

    def take(self, block: Block) -> None:
        """Add the whole steps of a block."""
        fresh = self.unfiltered(block)
        self._turned = np.vstack([self._turned, block.clock[block.whole][:, [ANGLE, SPEED]]])
        if self._pending.shape[1] == 0 and self._next == 0:
            fresh = np.hstack([np.repeat(fresh[:, :1], len(self._taps) // 2, axis=1), fresh])
        pending = np.hstack([self._pending, fresh])
        left = self.values.shape[1] - self._next
        ready = min(left, max(0, (pending.shape[1] - len(self._taps)) // self._every + 1))
        if ready:
            samples = np.empty((len(pending), ready))
            for first in range(0, ready, CHUNK):
                n = min(CHUNK, ready - first)
                span = slice(first * self._every, (first + n - 1) * self._every + len(self._taps))
                samples[:, first : first + n] = pending[:, span] @ self._filter[: span.stop - span.start, :n]
            self._keep(samples)
        self._pending = pending[:, ready * self._every :]

    def _keep(self, samples: np.ndarray) -> None:
        """Add the rigid motion, which needs no filter, to the next samples and store them."""
        last = self._next + samples.shape[1]
        count = samples.shape[1] * self._every
        samples += self._rigid[:, :2] @ self._turned[: count : self._every].T
        self._turned = self._turned[count:]
        if not np.isfinite(samples).all():
            time = np.arange(self._next, last) / self._rate
            at = time[int(np.argmin(np.isfinite(samples).all(axis=0)))]
            raise StepError(f"t = {at:.6g} s: a channel is not finite. Use a smaller step.")
        self.values[:, self._next : last] = samples
        self._next = last
