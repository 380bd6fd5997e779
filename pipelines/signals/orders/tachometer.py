"""The angle of a shaft from the pulses of a tachometer or an encoder.

A pulse begins where the signal rises through a level, after it was lower by HYSTERESIS of its range. The time is
interpolated between samples. The interval between two pulses is compared with its neighbours. An integer multiple of
them indicates missing pulses, a much shorter interval a double pulse; both are corrected and counted. With many pulses
per turn, the times of neighbouring pulses are averaged, to PER_TURN times per turn or fewer. A smooth curve through the
times (`pipelines.signals.orders.smoothing`) removes their jitter.

References
----------
Fyfe & Munck (1997), Mech. Syst. Signal Process. 11(2), 187-205 (angle from pulses); Andre, Girardin, Bourdon, Antoni &
Remond (2014), Mech. Syst. Signal Process. 44(1-2), 99-111 (precision of elapsed times).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipelines.signals.orders.rotation import RotationError
from pipelines.signals.orders.smoothing import smooth

HYSTERESIS = 0.2  # of the range of the signal
PER_TURN = 8  # averaged times of pulses
FEWEST_PULSES = 8
_AROUND = 9  # intervals whose median is compared with the middle one
_DOUBLE = 0.4  # of the usual interval: a shorter one is due to a double pulse
_MOST_MISSING = 5  # consecutive pulses; a longer gap is taken for a stop of the machine
_NEAR = 0.2  # of an interval, largest distance from an integer multiple
_SLOW = 1.5  # times the median interval of the recording: the machine starts or stops
MOST_DAMAGED = (
    0.05  # of the pulses; five of nine intervals, which would falsify their median, then have a probability of 4e-5
)


class Pulses(NamedTuple):
    """Pulses at `time` (pulse,) s with their `number` (pulse,), 0 for the first; counts of missing and double ones."""

    time: np.ndarray
    number: np.ndarray
    missing: int
    double: int


def find_pulses(signal: np.ndarray, time: np.ndarray, level: float | None = None) -> Pulses:
    """The pulses of a tachometer.

    Parameters
    ----------
    signal : float (time,), any unit, rising at a pulse
    time : float (time,), s
    level : level that a pulse passes, in the unit of the signal; the middle of the range if None

    Raises
    ------
    RotationError : values that are not numbers, or fewer than FEWEST_PULSES pulses
    """
    if not np.isfinite(signal).all():
        raise RotationError(
            f"tachometer: {np.count_nonzero(~np.isfinite(signal))} of {len(signal)} values are not numbers. Leave it "
            "out, or repair the recording."
        )
    low, high = float(signal.min()), float(signal.max())
    upper = 0.5 * (low + high) if level is None else level
    lower = upper - HYSTERESIS * (high - low)
    state = np.where(signal >= upper, 1, np.where(signal < lower, -1, 0))
    known = np.flatnonzero(state)
    rises = known[1:][(state[known[1:]] == 1) & (state[known[:-1]] == -1)]
    if high == low or len(rises) < FEWEST_PULSES:
        raise RotationError(
            f"tachometer: {len(rises) if high > low else 0} pulses at the trigger level {upper:.3g}, the values "
            f"are from {low:.3g} to {high:.3g}; at least {FEWEST_PULSES} are needed. Use a longer "
            "recording, another level or channel."
        )
    share = (upper - signal[rises - 1]) / (signal[rises] - signal[rises - 1])
    at = time[rises - 1] + share * (time[rises] - time[rises - 1])
    return _numbered(at)


def _numbered(at: np.ndarray) -> Pulses:
    """Numbered pulses without double ones; missing pulses are included in the numbers.

    Raises
    ------
    RotationError : more than MOST_DAMAGED are missing or double, or an interval is no integer multiple of the others
    """
    found = len(at)
    at = _without_extra(at)
    spans = np.diff(at)
    around = _around(spans)
    slow = around > _SLOW * np.median(spans)  # near a stop, where times between pulses follow no rule
    extended = np.concatenate([spans[1:2], spans, spans[-2:-1]])
    usual = np.where(slow, np.maximum(around, 0.5 * (extended[:-2] + extended[2:])), around)
    multiple = spans / usual
    passed = np.rint(multiple).astype(int)
    whole = (passed >= 1) & (passed <= _MOST_MISSING + 1) & (np.abs(multiple - passed) <= _NEAR)
    passed[~whole] = 1
    missing, double, odd = int(np.sum(passed - 1)), found - len(at), np.flatnonzero(~whole & ~slow)
    if len(odd) or missing + double > MOST_DAMAGED * found:
        first = f", the first at {at[odd[0]]:.4g} s" if len(odd) else ""
        raise RotationError(
            f"tachometer: of {found} pulses {missing} are missing and {double} double, and {len(odd)} times between "
            f"pulses are no whole multiple of the others{first}; at most {100 * MOST_DAMAGED:g} % and none are "
            "accepted. Correct level, cut the recording, or delete the tachometer and set speed_rpm."
        )
    return Pulses(at, np.concatenate([[0], np.cumsum(passed)]), missing, double)


def _without_extra(at: np.ndarray) -> np.ndarray:
    """The pulses without double ones: those between two pulses with the usual interval, the clearest removed first."""
    found = len(at)
    while len(at) > max(FEWEST_PULSES, (1.0 - MOST_DAMAGED) * found - 1):
        spans = np.diff(at)
        short = spans < (1.0 - _NEAR) * _around(spans)
        joined = spans[:-1] + spans[1:]
        around = 0.5 * (np.append(joined[:1], spans[:-2]) + np.append(spans[2:], joined[-1:]))
        deviation = np.where(short[:-1] | short[1:], np.abs(joined / around - 1.0), np.inf)
        if deviation.min() > _NEAR:
            break
        at = np.delete(at, 1 + int(deviation.argmin()))
    return at


def _around(spans: np.ndarray) -> np.ndarray:
    """Median of the intervals around each interval."""
    from scipy.ndimage import median_filter

    return median_filter(spans, size=min(_AROUND, len(spans)), mode="mirror")


def angle_from_pulses(pulses: Pulses, pulses_per_turn: float, time: np.ndarray) -> tuple[np.ndarray, float]:
    """Angle (time,) in rad of the shaft with the tachometer, 0 at the first pulse, and the error of its total increase.

    The error is the standard uncertainty of the smooth curve between the first and the last pulse, and at least that of
    the sampling: one sampling interval divided by sqrt(12) for a pulse at each end. Near a stop the smooth curve
    oscillates. The times are then interpolated by a monotone cubic instead.

    Parameters
    ----------
    pulses : the pulses
    pulses_per_turn : of the shaft
    time : float (time,), s, equidistant
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator

    together = max(1, min(math.floor(pulses_per_turn / PER_TURN), len(pulses.time) // FEWEST_PULSES))
    each = np.interp(np.arange(pulses.number[-1] + 1), pulses.number, pulses.time)
    at = each[: len(each) // together * together].reshape(-1, together).mean(axis=1)
    before = math.ceil((at[0] - time[0]) / (at[1] - at[0])) + 1
    after = math.ceil((time[-1] - at[-1]) / (at[-1] - at[-2])) + 1
    places = np.arange(-before, len(at) + after)
    curve = smooth(at, before, after)
    reached = curve.values[0] <= time[0] and curve.values[-1] >= time[-1]
    if reached and np.all(np.diff(curve.values) > 0.0) and curve.noise < _DOUBLE * np.diff(at).min():
        turned, climb = CubicSpline(curve.values, places)(time), curve.climb / np.ptp(curve.values)
    else:
        ends = at[0] - np.arange(before, 0, -1) * (at[1] - at[0]), at[-1] + np.arange(1, after + 1) * (at[-1] - at[-2])
        turned, climb = PchipInterpolator(np.concatenate([ends[0], at, ends[1]]), places)(time), 0.0
    angle = 2.0 * np.pi / pulses_per_turn * (together * turned + 0.5 * (together - 1))
    sampled = float(time[1] - time[0]) / math.sqrt(6.0 * together)
    speed = (angle[-1] - angle[0]) / (time[-1] - time[0])
    return angle, float(speed * max(climb * (time[-1] - time[0]), sampled))
