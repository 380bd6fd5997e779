"""Time-synchronous average of a signal over the turns of a shaft, and its residual without regular orders.

The average retains the components that repeat with the shaft. Uncorrelated components are divided by the square root of
the number of turns. Each integer order is one line of the Fourier transform of the average, without leakage.

References
----------
McFadden (1987), Mech. Syst. Signal Process. 1(1), 83-95 (average); Stewart (1977), Report MHM/R/10/77, University of
Southampton, as given by Zakrajsek, Townsend & Decker (1993), NASA TM-105950 (residual and difference signal).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipelines.signals.features.statistics import squared_magnitude

FEWEST_TURNS = 3  # for an average


@dataclass(frozen=True, eq=False, kw_only=True)
class Average:
    """Average of turns, which should be FEWEST_TURNS or more: `values` (channel, place) over one turn.

    `orders` is the number of orders below half of the sampling rate, `teeth` are those of the gears on the shaft.
    """

    values: np.ndarray
    orders: int
    teeth: Collection[int]

    @cached_property
    def _lines(self) -> np.ndarray:
        return np.fft.rfft(self.values, axis=-1)

    @cached_property
    def amplitudes(self) -> np.ndarray:
        """One-sided peak amplitudes (channel, order), NaN from `orders` on."""
        lines = 2.0 * np.abs(self._lines) / self.values.shape[-1]
        lines[:, 0] /= 2.0
        lines[:, self.orders :] = np.nan
        return lines

    def amplitude(self, order: int) -> np.ndarray:
        """Amplitude (channel,) of an order, NaN beyond half of the sampling rate."""
        lines = self.amplitudes
        return lines[:, order] if order < lines.shape[1] else np.full(len(lines), np.nan)

    @property
    def residual(self) -> np.ndarray:
        """The average (channel, place) without its mean, the first order of the shaft and all orders of its meshes."""
        return self._filtered({0, 1} | self._of_meshes(), kept=False)

    @property
    def regular(self) -> np.ndarray:
        """Regular part of the average (channel, place): its mean, the first order and the mesh orders."""
        return self._filtered({0, 1} | self._of_meshes(), kept=True)

    @property
    def difference(self) -> np.ndarray:
        """The residual without the first sidebands of the mesh orders and the second order of the shaft."""
        of_meshes = self._of_meshes()
        sidebands = {order + side for order in of_meshes for side in (-1, 1)}
        return self._filtered({0, 1, 2} | of_meshes | sidebands, kept=False)

    def _of_meshes(self) -> set[int]:
        return {n * teeth for teeth in self.teeth for n in range(1, self.orders // teeth + 1)}

    def _filtered(self, orders: set[int], kept: bool) -> np.ndarray:
        """The part of the average with some orders, or without them and all from `orders` on."""
        every = np.arange(self._lines.shape[1])
        listed = np.isin(every, list(orders))
        lines = np.where(listed if kept else ~listed & (every < self.orders), self._lines, 0.0)
        return np.fft.irfft(lines, self.values.shape[-1], axis=-1)


def average_power(turns: np.ndarray) -> np.ndarray:
    """Power (2, channel) of the average of turns: the part that does not repeat with the shaft, and all of it.

    The Fourier transform over the N turns has the average at frequency 0. Lines of other shafts are at a few of the
    other N - 1 frequencies. Vibration that repeats with no shaft, such as impacts of a bearing with slip, has about the
    same power at all of them. Its power in the average is therefore the median over the other frequencies.

    Parameters
    ----------
    turns : (channel, turn, place), real or complex, two turns or more
    """
    from scipy import fft

    power = squared_magnitude(fft.fft(turns, axis=1)).mean(axis=-1) / turns.shape[1] ** 2
    return np.stack([np.median(power[:, 1:], axis=1), power[:, 0]])
