"""Turns of one shaft in a window of a recording, and their orders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.signals.orders.revolutions import HIGHEST, revolutions, within
from pipelines.signals.orders.rotation import Rotation

COLUMNS = 1.25  # places per recorded sample; with fewer, the filter affects orders below HIGHEST of the rate
_ROUNDING = 1e-7  # of the samples per turn


@dataclass(frozen=True, eq=False, kw_only=True)
class Turns:
    """Turns of a shaft: `values` (channel, turn, place) and its rotation `frequency` (Hz).

    `orders` is the number of orders below HIGHEST of the sampling rate. The angle increases with the place, also if the
    shaft runs `backwards`.
    """

    values: np.ndarray
    frequency: float
    orders: int
    backwards: bool

    @property
    def count(self) -> int:
        """Number of whole turns."""
        return self.values.shape[1]

    def order(self, number: int) -> np.ndarray:
        """Peak amplitude (channel,) of an order of the shaft.

        The turns are averaged with a Hann window, which suppresses strong orders of other shafts. A plain average would
        retain 1/turns of them.
        """
        weights = np.hanning(self.count + 2)[1:-1]
        averaged = np.einsum("ctp,t->cp", self.values, weights / weights.sum())
        return 2.0 * np.abs(np.fft.rfft(averaged, axis=-1)[:, number]) / averaged.shape[-1]


def cut_turns(
    signal: np.ndarray, time: np.ndarray, rotation: Rotation, ratio: float, window: tuple[float, float]
) -> Turns | None:
    """Cut the whole turns of a shaft from a window; None if the shaft is at rest there.

    Parameters
    ----------
    signal, time : (channel, time), at equidistant times (time,) in s
    rotation : of the recording
    ratio : turns of the shaft per turn of the first one
    window : start and end, s
    """
    from scipy.fft import next_fast_len

    part = within(time, window)
    if part.stop - part.start < 2:
        return None
    angle = float(rotation.angle[part.stop - 1] - rotation.angle[part.start])
    turned = abs(angle) * ratio / (2.0 * math.pi)
    frequency = turned / float(time[part.stop - 1] - time[part.start])
    if turned < 1.0:
        return None
    rate = (len(time) - 1) / float(time[-1] - time[0])
    per_turn = rate / frequency * (1.0 - _ROUNDING)  # a rounded time or angle must not give another whole number
    places = next_fast_len(math.ceil(COLUMNS * per_turn), real=True)
    values = revolutions(signal, time, rotation, ratio, places, window)
    return Turns(values=values, frequency=frequency, orders=int(HIGHEST * per_turn), backwards=angle < 0.0)
