"""Features of rolling bearings: how far the pass orders stand out of the spectrum of the squared envelope.

References
----------
Randall & Antoni (2011), Mech. Syst. Signal Process. 25(2), 485-520 (squared envelope spectrum, slip of 1 to 2 %).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

PASS_HARMONICS = 3
SLIP = 0.02  # of a pass order, to either side
FLOOR = 0.1  # of a pass order, to either side: where the floor is read
FEWEST_LINES = 8  # of the spectrum, in the floor


def pass_levels(envelope: np.ndarray, orders: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Level (channel,) of each pass order: its lines over their floors, root mean square over three harmonics.

    A line is the largest within the slip of its order, the floor the median around it. Orders too low for the number of
    turns, or beyond the spectrum, are left out.

    Parameters
    ----------
    envelope : squared envelope (channel, turn, place)
    orders : name -> cycles per turn
    """
    channels, turns, places = envelope.shape
    laid = envelope.reshape(channels, turns * places)
    window = np.hanning(turns * places + 1)[:-1]
    lines = np.abs(np.fft.rfft((laid - laid.mean(axis=-1, keepdims=True)) * window, axis=-1))
    found = {}
    for name, order in orders.items():
        levels = [_over_floor(lines, n * order * turns) for n in range(1, PASS_HARMONICS + 1)]
        if all(level is not None for level in levels):
            found[name] = np.sqrt(np.mean([level**2 for level in levels if level is not None], axis=0))
    return found


def _over_floor(lines: np.ndarray, centre: float) -> np.ndarray | None:
    """Peak (channel,) within the slip of a line over the median about it; None where there is no room for either."""
    reach, around = max(1.0, SLIP * centre), FLOOR * centre
    low, high = int(centre - around), int(centre + around) + 1
    if around < FEWEST_LINES / 2 or high > lines.shape[1]:
        return None
    peak = lines[:, int(np.floor(centre - reach)) : int(np.ceil(centre + reach)) + 1].max(axis=-1)
    return peak / np.median(lines[:, low:high], axis=-1)
