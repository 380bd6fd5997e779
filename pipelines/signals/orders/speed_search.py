"""First estimate of the speed in a recording, by the levels of all mesh orders and sidebands together.

Each window of the recording has a spectrum in dB over its local median, averaged over the channels. The score of a
speed near the nominal one is the weighted sum over the mesh orders and their sidebands. Dynamic programming finds the
sequence of speeds with the highest sum of scores, among those that change slowly enough. The weights of sidebands are
symmetric, so that the centre of a group of lines has the highest score, not its strongest line.

References
----------
Leclere, Andre & Antoni (2016), Mech. Syst. Signal Process. 81, 375-386 (many orders as one probability); Urbanek,
Barszcz & Antoni (2013), Mech. Syst. Signal Process. 38(1), 96-102 (rough path first, phase then).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

RANGE = 0.3  # about the nominal speed, relative
_PER_LINE = 3  # number of speeds within the width of the highest line


def speed_path(
    signals: Sequence[np.ndarray],
    rate: float,
    weights: Mapping[float, float],
    nominal: float,
    seconds: float,
    change: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Middle of each window (s, from the first sample) and speed of the first shaft in it (Hz).

    Parameters
    ----------
    signals : float (time,) of every channel, any unit, all finite
    rate : sampling rate, Hz
    weights : of the lines, by order of the first shaft
    nominal : nominal speed of the first shaft, Hz
    seconds : length of a window; windows overlap by half
    change : fastest change of the speed, Hz/s
    """
    size = round(seconds * rate)
    orders, share = np.array(list(weights)), np.array(list(weights.values()))
    level = np.mean([_over_floor(signal, size, orders, nominal * size / rate) for signal in signals], axis=0)
    step = rate / size / orders.max() / _PER_LINE
    speeds = nominal + step * np.arange(-int(RANGE * nominal / step), int(RANGE * nominal / step) + 1)
    lines = np.arange(level.shape[1]) * rate / size
    score = np.array([np.interp(np.outer(speeds, orders), lines, window) @ share for window in level])
    middles = (np.arange(len(score)) * (size // 2) + size / 2) / rate
    reach = max(1, int(np.ceil(change * (size // 2) / rate / step)))
    return middles, speeds[_best_path(score, reach)]


def _over_floor(signal: np.ndarray, size: int, orders: np.ndarray, lines_per_order: float) -> np.ndarray:
    """Levels (window, line) of a channel in dB over the median of the lines within two orders, not below 0."""
    from scipy.ndimage import median_filter

    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(size) / size)
    top = min(size // 2 + 1, int((1.0 + RANGE) * orders.max() * lines_per_order) + 2)
    starts = range(0, len(signal) - size + 1, size // 2)
    power = np.array([np.abs(np.fft.rfft(window * signal[s : s + size])[:top]) ** 2 for s in starts])
    level = 10.0 * np.log10(power + np.finfo(float).tiny)
    floor = median_filter(level, size=(1, 2 * int(2 * lines_per_order) + 1))
    return np.maximum(level - floor, 0.0)


def _best_path(score: np.ndarray, reach: int) -> np.ndarray:
    """Column (window,) of the path with the highest sum, which changes by `reach` columns at most between rows."""
    padded = np.full(score.shape[1] + 2 * reach, -np.inf)
    total, came = score[0], []
    for row in score[1:]:
        padded[reach : len(padded) - reach] = total
        around = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
        best = around.argmax(axis=1)
        came.append(np.arange(len(best)) + best - reach)
        total = row + around.max(axis=1)
    path = [int(total.argmax())]
    for back in reversed(came):
        path.append(int(back[path[-1]]))
    return np.array(path[::-1])
