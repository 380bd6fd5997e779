"""A recording resampled over whole revolutions of a shaft: values by turn and place in the turn.

The signal is resampled to equidistant angles of the shaft by band-limited interpolation
(`fem.numerics.sinc_interpolation`). The error is below 1e-5 of the signal up to 0.45 of the sampling rate. If the angle
steps are wider than the samples, orders above 0.55 of the steps per turn are filtered out to prevent aliasing. The
filter assumes a constant speed over its 96 steps.

References
----------
Fyfe & Munck (1997), Mech. Syst. Signal Process. 11(2), 187-205 (computed order tracking); McFadden (1989), Mech. Syst.
Signal Process. 3(1), 87-97 (interpolation for the average over revolutions).
"""

from __future__ import annotations

import math

import numpy as np

from fem.numerics.sinc_interpolation import HALF_WIDTH, interpolated
from pipelines.signals.orders.rotation import Rotation

HIGHEST = 0.45  # of the sampling rate, highest frequency in use; filters of recorders attenuate above
LEAST_SPEED = 0.05  # of the highest speed; a slower shaft is considered at rest or reversing
_TURN_TOLERANCE = 1e-9  # turns, for rounding at the ends of a window
_STEP_TOLERANCE = 1e-5  # of a sampling step, for the same


def revolutions(
    values: np.ndarray,
    time: np.ndarray,
    rotation: Rotation,
    ratio: float,
    per_turn: int,
    window: tuple[float, float] | None = None,
) -> np.ndarray:
    """Signals (..., turn, angle) over whole turns of a shaft, from all parts of the window in which it turns.

    A turn begins where the angle of the shaft, `ratio` times that of the rotation, is a multiple of 2 pi. Column j is
    at the angle 2 pi j / per_turn after it, for both senses of rotation. The parts are in the order of time, the turns
    of one part in the order of the angle. There may be no turn. A turn is omitted if it crosses the end of the window,
    or if it is closer to an end of the recording than the interpolation needs: HALF_WIDTH samples, or angle steps if
    these are wider.

    Parameters
    ----------
    values : float (..., time)
    time : float (time,), s, equidistant
    rotation : of the recording
    ratio : turns of the shaft per turn of the first one
    per_turn : number of columns
    window : start and end in s, the whole recording if None
    """
    angle = ratio * rotation.angle
    part = within(time, window or (float(time[0]), float(time[-1])))
    found = [np.empty((*values.shape[:-1], 0, per_turn))]
    for stretch in moving_stretches(angle[part]):
        whole = slice(part.start + stretch.start, part.start + stretch.stop)
        position, cutoff = _positions(angle, whole, per_turn)
        cut = interpolated(values, position.ravel(), cutoff.ravel())
        found.append(cut.reshape(*values.shape[:-1], *position.shape))
    return np.concatenate(found, axis=-2)


def within(time: np.ndarray, window: tuple[float, float]) -> slice:
    """Samples of a window (s) with its ends; `time` (time,) may be rounded, as in a text file."""
    rounding = _STEP_TOLERANCE * float(time[-1] - time[0]) / max(len(time) - 1, 1)
    first, last = np.searchsorted(time, window[0] - rounding), np.searchsorted(time, window[1] + rounding, side="right")
    return slice(int(first), int(last))


def moving_stretches(angle: np.ndarray) -> list[slice]:
    """Parts of two samples or more in which a shaft turns in one sense, at LEAST_SPEED of its highest speed or more."""
    if len(angle) < 2:
        return []
    speed = np.gradient(angle)
    least = LEAST_SPEED * np.abs(speed).max()
    sense = np.where(np.abs(speed) > least, np.sign(speed), 0.0)
    edges = np.flatnonzero(np.diff(sense)) + 1
    ends = zip([0, *edges], [*edges, len(angle)], strict=True)
    return [slice(int(first), int(last)) for first, last in ends if sense[first] and last - first > 1]


def _positions(angle: np.ndarray, stretch: slice, per_turn: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions of the columns of whole turns (turn, angle) in samples, and the cut-off of the filter there."""
    from scipy.interpolate import CubicSpline

    sense = 1.0 if angle[stretch.stop - 1] > angle[stretch.start] else -1.0
    turns = sense * angle[stretch] / (2.0 * np.pi)
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(turns)) > 0.0])
    sample = CubicSpline(turns[rising], np.arange(stretch.start, stretch.stop)[rising])
    first, last = math.ceil(turns[0] - _TURN_TOLERANCE), math.floor(turns[rising][-1] + _TURN_TOLERANCE)
    column = np.arange(per_turn) / per_turn
    place = np.arange(first, last)[:, None] + (column if sense > 0.0 else 1.0 - column)
    position = sample(place)
    cutoff = per_turn / np.maximum(sample(place, 1), per_turn)
    reach = HALF_WIDTH / cutoff
    inside = np.all((position - reach >= 0.0) & (position + reach <= len(angle) - 1), axis=1)
    order = slice(None, None, 1 if sense > 0.0 else -1)
    return position[inside][order], cutoff[inside][order]
