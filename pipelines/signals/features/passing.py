"""Features of rolling bearings: levels of the pass orders over the floor of the squared envelope spectrum.

Damage causes impacts, thus lines at its pass order and multiples of it. Slip shifts all of them by the same relative
amount. The level of a pass order is therefore that of the best comb of lines at 1, 2 and 3 times an order within SLIP
of it. Single lines of another cause do not fit a comb. A damaged rolling element passes the load zone once per turn of
the cage, so that there are also sidebands at this distance, often as high as the lines themselves. A damaged outer race
has none, those of an inner race are at the distance of the shaft speed. The level with the sidebands is a second
feature of rolling elements. It scatters less, because it is the mean of more lines.

Multiples of shaft speeds are omitted, since gears, unbalance and misalignment cause them. If the speed has a large
uncertainty, they are those of the speed at which they are highest (see
`pipelines.signals.orders.speed_from_multiples`). Otherwise all lines within the uncertainty of each would have to be
omitted.

References
----------
Randall & Antoni (2011), Mech. Syst. Signal Process. 25(2), 485-520 (squared envelope spectrum, slip of 1 to 2 %,
sidebands at the speed of the cage).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import fft
from scipy.ndimage import maximum_filter1d

from pipelines.signals.features.unresolved_passes import (
    FEWEST,
    FEWEST_LINES,
    FLOOR,
    PASS_HARMONICS,
    SCATTER,
    crowded,
    free_lines,
    resolved,
)
from pipelines.signals.orders.rotation import Rotation

PASSING, SIDEBANDS = "pass_order", "pass_sidebands"  # features
SIDES = 2  # sidebands on each side
SLIP = 0.02  # of a pass order, to either side
LEAD = 20.0  # dB, upper limit of the strongest line over the second strongest, since a single line is no comb


def pass_levels(
    envelope: np.ndarray,
    orders: Mapping[str, float],
    shafts: Sequence[float] = (1.0,),
    rotation: Rotation | None = None,
    sidebands: Mapping[str, float] | None = None,
    repeats: Sequence[float] = (),
) -> dict[tuple[str, str], np.ndarray]:
    """Level (channel,) of each pass order: lines of its best comb over their floors, geometric mean over harmonics.

    The result has the level of each name as PASSING, and with its sidebands as SIDEBANDS. The floor is the median of
    the spectrum around a line. Orders that are not `resolved` are omitted, those with sidebands only as PASSING.

    Parameters
    ----------
    envelope : squared envelope (channel, turn, place)
    orders : name -> cycles per turn
    shafts : turns of all shafts per turn of this one
    rotation : with the uncertainty of the speed; exact if None
    sidebands : name -> their distance, in cycles per turn
    repeats : orders at which the same teeth meet again, per turn
    """
    channels, turns, places = envelope.shape
    laid = envelope.reshape(channels, turns * places)
    window = np.hanning(turns * places + 1)[:-1]
    lines = np.abs(fft.rfft((laid - laid.mean(axis=-1, keepdims=True)) * window, axis=-1))
    factor, error = (rotation.likely, rotation.error) if rotation else (1.0, 0.0)
    per_order, shafts = turns * factor, [*shafts, *repeats]
    if crowded(repeats, per_order):
        return {}
    free = free_lines(np.arange(lines.shape[1]), [per_order * ratio for ratio in shafts], error)
    found = {
        (name, PASSING): _level(lines, free, order * per_order)
        for name, order in orders.items()
        if resolved(order, per_order, (lines.shape[1] - 1) / per_order, shafts, error)
    }
    found |= {
        (name, SIDEBANDS): _level(lines, free, orders[name] * per_order, distance * per_order)
        for name, distance in (sidebands or {}).items()
    }
    return {name: level for name, level in found.items() if level is not None}


def _level(lines: np.ndarray, free: np.ndarray, centre: float, distance: float = 0.0) -> np.ndarray | None:
    """Level (channel,) of the best comb near the line `centre`, with sidebands at a distance (lines) if it is not 0.

    It is None if too few lines are within the spectrum.
    """
    combs = np.arange((1.0 - SLIP) * centre, (1.0 + SLIP) * centre, 0.5 / PASS_HARMONICS)
    sides = range(-SIDES, SIDES + 1) if distance else (0,)
    places = [(harmonic, side * distance) for harmonic in range(1, PASS_HARMONICS + 1) for side in sides]
    decibels, used = np.zeros((len(places), len(lines), len(combs))), np.zeros(len(combs), dtype=int)
    for row, (harmonic, shift) in enumerate(places):
        around, middle = FLOOR * harmonic * centre, harmonic * centre + shift
        near = slice(max(int(middle - around), 0), int(middle + around) + 1)
        if around < FEWEST_LINES / 2 or near.stop > lines.shape[1] or free[near].sum() < FEWEST_LINES:
            continue
        floor = np.median(lines[:, near][:, free[near]], axis=-1, keepdims=True)
        reach = max(1, round(SCATTER * harmonic * centre)) + int(SLIP * abs(shift))
        peaks = maximum_filter1d(np.where(free[near], lines[:, near], 0.0), 2 * reach + 1, axis=-1, mode="nearest")
        at = np.rint(harmonic * combs + shift).astype(int) - near.start
        over = peaks[:, at] / np.maximum(floor, np.finfo(float).tiny)
        decibels[row] = np.where(free[near][at], 20.0 * np.log10(np.maximum(over, 1.0)), 0.0)
        used += free[near][at]
    enough = used >= FEWEST * len(places)
    if not enough.any():
        return None
    decibels.sort(axis=0)
    decibels[-1] = np.minimum(decibels[-1], decibels[-2] + LEAD)
    best = decibels.mean(axis=0)[:, enough].max(axis=-1)
    return np.asarray(10.0 ** (best / 20.0))
