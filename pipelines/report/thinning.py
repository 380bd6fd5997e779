"""Fewer points of a curve that look the same: the smallest and largest value of every stretch, or the largest alone."""

from __future__ import annotations

import numpy as np


def extremes(values: np.ndarray, most: int) -> tuple[np.ndarray, int]:
    """Smallest and largest value of stretches, in the order in which they come, and the samples of a stretch.

    Parameters
    ----------
    values : float (n,)
    most : points that are wanted, an even number

    Returns
    -------
    float (at most `most`,), two per stretch, and the length of a stretch; the values themselves and 1 if they are few
    """
    if len(values) <= most:
        return values, 1
    stretch = -(-2 * len(values) // most)
    laid = _laid(values, stretch)
    low, high = laid.argmin(axis=1), laid.argmax(axis=1)
    places = np.stack([np.minimum(low, high), np.maximum(low, high)], axis=1)
    return np.take_along_axis(laid, places, axis=1).ravel(), stretch


def largest(values: np.ndarray, most: int) -> tuple[np.ndarray, int]:
    """The largest value of every stretch and the samples of a stretch, of float (n,), at most `most` of them."""
    if len(values) <= most:
        return values, 1
    stretch = -(-len(values) // most)
    return _laid(values, stretch).max(axis=1), stretch


def _laid(values: np.ndarray, stretch: int) -> np.ndarray:
    """Rows of a stretch each; the last one is filled up with the last value."""
    missing = -len(values) % stretch
    return np.concatenate([values, np.full(missing, values[-1])]).reshape(-1, stretch)
