"""Spectra of a run whose speed changes: over the orders of a shaft, or over frequency, window by window.

An order is the number of cycles per revolution of a shaft. The signal is resampled to equidistant angles of the shaft
by band-limited interpolation (`fem.numerics.sinc_interpolation`). A line that follows the shaft then remains sharp when
the speed changes. Windows of whole revolutions overlap by half. The angle of the shaft is recorded with the response.

References
----------
Fyfe & Munck (1997), Mech. Syst. Signal Process. 11(2), 187-205 (computed order tracking).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.numerics.sinc_interpolation import interpolated
from fem.storage.records import Record, array, scalar, text
from pipelines.signals.orders.revolutions import HIGHEST, moving_stretches
from pipelines.signals.spectrum import amplitudes

STEPS = 1.25  # per recorded sample, so that the filter of the interpolation begins above HIGHEST


class OrderError(ValueError):
    """A run has no order spectra: the shaft does not turn, or the run is shorter than a window."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Waterfall(Record):
    """One-sided peak amplitudes (window, line); lines are orders of the shaft, or frequencies."""

    shaft: str = text()
    over: str = text()  # "order" | "frequency"
    time: np.ndarray = array("window", units="s")  # middle of each window
    speed: np.ndarray = array("window", units="rad/s")  # mean of the shaft
    line: np.ndarray = array("line", units="1 or Hz")
    amplitude: np.ndarray = array("window", "line", units="per signal")
    resolution: float = scalar(units="1 or Hz")

    def cut(self, order: float) -> np.ndarray:
        """Amplitude (window,) along an order: the root of the power in the main lobe, +-2 lines, of the Hann window.

        Raises
        ------
        OrderError : beyond the highest order
        """
        lines = order * (np.ones_like(self.speed) if self.over == "order" else self.speed / (2 * np.pi))
        centres = np.rint(lines / self.resolution).astype(int)
        if centres.max() + 2 >= self.line.size:
            raise OrderError(f"order {order:g}: beyond the highest line, {self.line[-1]:.4g}. Choose a lower order.")
        lobe = np.clip(centres[:, None] + np.arange(-2, 3), 0, self.line.size - 1)
        power = np.sum(np.take_along_axis(self.amplitude, lobe, axis=1) ** 2, axis=1)
        return np.sqrt(power / 1.5)  # the Hann window spreads the power of a tone over 1.5 lines


def order_waterfall(
    signal: np.ndarray, time: np.ndarray, angle: np.ndarray, *, shaft: str, revolutions: int = 16
) -> Waterfall:
    """Spectra over the orders of a shaft, for the longest part of the run in which it turns.

    The highest order is HIGHEST of the median number of samples per revolution.

    Parameters
    ----------
    signal, time, angle : (n,) signal, equidistant time (s) and angle of the shaft (rad)
    shaft : name of the shaft
    revolutions : number of revolutions in a window; the resolution is its inverse

    Raises
    ------
    OrderError : the shaft does not turn, or makes fewer revolutions than a window
    """
    moving = max(moving_stretches(angle), key=lambda stretch: stretch.stop - stretch.start, default=slice(0))
    turned = np.abs(angle[moving] - angle[moving.start or 0]) / (2 * np.pi)
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(turned)) > 0.0])[: len(turned)]
    turned, sample = turned[rising], np.arange(len(angle))[moving][rising]
    if not len(turned):
        raise OrderError("no shaft turns, and a run at rest has no orders. Use a run in which the shafts turn.")
    if turned[-1] < revolutions:
        raise OrderError(
            f"{shaft} makes {turned[-1]:.3g} revolutions, and a window takes {revolutions}. Reduce --revolutions, or "
            "use a longer run."
        )
    samples = 1.0 / np.diff(turned)  # in a revolution
    per_turn = 2 * math.ceil(0.5 * STEPS * float(np.median(samples)))
    steps = np.arange(0.0, turned[-1], 1.0 / per_turn)
    at = np.interp(steps, turned, sample)
    cutoff = np.minimum(per_turn / np.interp(steps, turned[1:], samples), 1.0)
    even = interpolated(signal, at, cutoff)
    size = revolutions * per_turn
    starts = np.arange(0, len(even) - size + 1, size // 2)
    orders = np.arange(int(revolutions * HIGHEST * float(np.median(samples)))) / revolutions
    seconds = np.interp(at, np.arange(len(time)), time)
    return Waterfall(
        shaft=shaft,
        over="order",
        time=seconds[starts + size // 2],
        speed=2 * np.pi * revolutions / (seconds[starts + size - 1] - seconds[starts]),
        line=orders,
        amplitude=_amplitudes(even, starts, size)[:, : len(orders)],
        resolution=1.0 / revolutions,
    )


def frequency_waterfall(
    signal: np.ndarray, time: np.ndarray, angle: np.ndarray, *, shaft: str, seconds: float = 0.2
) -> Waterfall:
    """Spectra over frequency, in which natural frequencies stay constant while orders change with the speed.

    Parameters
    ----------
    signal, time, angle : (n,) signal, equidistant time (s) and angle of the shaft (rad)
    shaft : name of the shaft
    seconds : length of a window; windows overlap by half

    Raises
    ------
    OrderError : the run is shorter than a window
    """
    step = float(time[1] - time[0])
    size = round(seconds / step)
    if size > len(signal):
        raise OrderError(f"the run lasts {time[-1] - time[0]:.3g} s, a window {seconds:g} s. Use shorter windows.")
    starts = np.arange(0, len(signal) - size + 1, max(1, size // 2))
    turned = np.array([angle[s + size - 1] - angle[s] for s in starts]) / (step * (size - 1))
    return Waterfall(
        shaft=shaft,
        over="frequency",
        time=time[starts] + 0.5 * step * size,
        speed=np.abs(turned),
        line=np.arange(size // 2) / (size * step),
        amplitude=_amplitudes(signal, starts, size)[:, : size // 2],
        resolution=1.0 / (size * step),
    )


def _amplitudes(values: np.ndarray, starts: np.ndarray, size: int) -> np.ndarray:
    """One-sided peak amplitudes (window, line) of the windows of a size that begin at `starts`, less their means."""
    windows = values[starts + np.arange(size)[:, None]]
    return amplitudes(windows - windows.mean(axis=0)).T
