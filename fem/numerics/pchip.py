"""Monotone cubic interpolation."""

from __future__ import annotations

import numpy as np


def pchip(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values of the piecewise cubic that rises and falls only where its points do; the end pieces go on beyond them.

    It computes as `scipy.interpolate.PchipInterpolator`, to the last bit; importing that package takes longer than a
    short simulation.

    Parameters
    ----------
    x, y : float (n,), n > 2, x increasing
    at : float, any shape

    References
    ----------
    Fritsch & Butland (1984), SIAM J. Sci. Stat. Comput. 5(2), 300-304.
    """
    width = np.diff(x)
    slope = np.diff(y) / width
    before, after = 2 * width[1:] + width[:-1], width[1:] + 2 * width[:-1]
    turns = (np.sign(slope[1:]) != np.sign(slope[:-1])) | (slope[1:] == 0.0) | (slope[:-1] == 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = 1.0 / ((before / slope[:-1] + after / slope[1:]) / (before + after))
    start = _end_slope(width[0], width[1], slope[0], slope[1])
    end = _end_slope(width[-1], width[-2], slope[-1], slope[-2])
    tangent = np.array([start, *np.where(turns, 0.0, inside), end])
    bend = (tangent[:-1] + tangent[1:] - 2 * slope) / width
    piece = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(width) - 1)
    s = at - x[piece]
    square = ((slope - tangent[:-1]) / width - bend)[piece]
    return np.asarray(y[piece] + tangent[piece] * s + square * (s * s) + (bend / width)[piece] * (s * s * s))


def _end_slope(width: float, next_width: float, slope: float, next_slope: float) -> float:
    """Slope at an end: of the parabola through three points, limited so that the curve keeps its shape."""
    tangent = ((2 * width + next_width) * slope - width * next_slope) / (width + next_width)
    if np.sign(tangent) != np.sign(slope):
        return 0.0
    if np.sign(slope) != np.sign(next_slope) and abs(tangent) > 3.0 * abs(slope):
        return float(3.0 * slope)
    return float(tangent)
