"""Spectra of a run whose speed changes: over the orders of a shaft, or over frequency, window by window.

Orders count cycles per revolution of a shaft. The signal is read at even steps of the shaft's angle (cubic between
samples), so that a line that follows the shaft stays sharp whatever the speed does; windows of whole revolutions
overlap by half. The angle is that of the shaft itself, recorded with the response.

References
----------
Fyfe & Munck (1997), Mech. Syst. Signal Process. 11(2), 187-205 (computed order tracking).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.storage.records import Record, array, scalar, text

LEAST_TURNS = 0.05  # of a window: a shaft that stands has no orders
OVERSAMPLING = 2  # at the lowest speed, so that nothing folds and the cubic loses nothing
MOST_PER_TURN = 100_000


class OrderError(ValueError):
    """A run has no orders to show: the shaft stands, or the windows do not fit."""


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
        found = np.zeros(len(centres))
        for offset in range(-2, 3):
            at = np.clip(centres + offset, 0, self.line.size - 1)
            found += self.amplitude[np.arange(len(at)), at] ** 2
        return np.sqrt(found / 1.5)  # the Hann window spreads the power of a tone over 1.5 lines


@dataclass(frozen=True, eq=False, kw_only=True)
class Turned:
    """A signal over a shaft's angle: `values` (n, ...) at even steps, at `time` (n,) s, `per_turn` in a revolution.

    `samples` is the median number of recorded samples in a revolution.
    """

    values: np.ndarray
    time: np.ndarray
    per_turn: int
    samples: float


def over_angle(signal: np.ndarray, time: np.ndarray, angle: np.ndarray, *, shaft: str, revolutions: float) -> Turned:
    """A signal over the angle of a shaft, from the longest stretch in which it turns.

    Parameters
    ----------
    signal, time, angle : (n, ...) signal, (n,) time (s) and angle of the shaft (rad)
    shaft : its name
    revolutions : the fewest that are needed

    Raises
    ------
    OrderError : the shaft does not turn as often
    """
    turned = np.abs(np.gradient(angle, time))
    moving = _longest_moving(turned)
    t, a, x = time[moving], angle[moving], signal[moving]
    sense = 1.0 if a[-1] >= a[0] else -1.0
    a = sense * (a - a[0])
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(a)) > 0.0])
    t, a, x = t[rising], a[rising], x[rising]
    whole = a[-1] / (2 * np.pi) if len(a) else 0.0
    if whole < revolutions:
        raise OrderError(
            f"{shaft} turns {whole:.3g} times while it moves, a window takes {revolutions} revolutions. Use a longer "
            "run or shorter windows."
        )
    samples = 2 * np.pi / np.diff(a)  # of the signal per revolution; most of them where the shaft turns slowest
    per_turn = min(OVERSAMPLING * math.ceil(float(samples.max())), MOST_PER_TURN)
    steps = np.arange(0.0, a[-1], 2 * np.pi / per_turn)
    from scipy.interpolate import CubicSpline

    at = np.interp(steps, a, t)
    return Turned(values=CubicSpline(t, x)(at), time=at, per_turn=per_turn, samples=float(np.median(samples)))


def order_waterfall(
    signal: np.ndarray, time: np.ndarray, angle: np.ndarray, *, shaft: str, revolutions: int = 16
) -> Waterfall:
    """Spectra over the orders of a shaft.

    Parameters
    ----------
    signal, time, angle : (n,) signal, time (s) and angle of the shaft (rad)
    shaft : its name
    revolutions : of a window; the resolution is its inverse

    Raises
    ------
    OrderError : fewer revolutions in the run than in a window
    """
    turned = over_angle(signal, time, angle, shaft=shaft, revolutions=revolutions)
    even, at, per_turn = turned.values, turned.time, turned.per_turn
    size = revolutions * per_turn
    starts = np.arange(0, len(even) - size + 1, size // 2)
    orders = np.arange(int(revolutions * turned.samples / 2)) / revolutions
    spectra = np.array([_amplitudes(even[s : s + size])[: len(orders)] for s in starts])
    spans = at[starts + size - 1] - at[starts]
    return Waterfall(
        shaft=shaft,
        over="order",
        time=at[starts + size // 2],
        speed=2 * np.pi * revolutions / spans,
        line=orders,
        amplitude=spectra,
        resolution=1.0 / revolutions,
    )


def frequency_waterfall(
    signal: np.ndarray, time: np.ndarray, angle: np.ndarray, *, shaft: str, seconds: float = 0.2
) -> Waterfall:
    """Spectra over frequency, as natural frequencies are seen: they stay where they are while orders climb.

    Parameters
    ----------
    signal, time, angle : (n,) signal, time (s, even) and angle of the shaft (rad)
    shaft : its name
    seconds : of a window; windows overlap by half

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
        amplitude=np.array([_amplitudes(signal[s : s + size])[: size // 2] for s in starts]),
        resolution=1.0 / (size * step),
    )


def _longest_moving(speed: np.ndarray) -> slice:
    """The longest stretch in which a shaft turns at LEAST_TURNS of its highest speed or more."""
    moves = np.concatenate([[False], speed > LEAST_TURNS * speed.max(initial=0.0), [False]])
    edges = np.flatnonzero(moves[1:] != moves[:-1]).reshape(-1, 2)
    if not len(edges):
        raise OrderError("no shaft turns: a run at rest has no orders.")
    first, last = edges[np.argmax(edges[:, 1] - edges[:, 0])]
    return slice(int(first), int(last))


def _amplitudes(values: np.ndarray) -> np.ndarray:
    """One-sided peak amplitudes with a Hann window: a tone on a line reads its amplitude."""
    weights = np.hanning(len(values) + 1)[:-1]
    return 2.0 * np.abs(np.fft.rfft((values - values.mean()) * weights)) / weights.sum()
