"""Checks of measured samples: gaps, silence, clipping. Every channel is read block by block."""

from __future__ import annotations

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.recordings.recording_channels import RecordedChannel

LEAST_SAMPLES = 256
_NEAR = 0.02  # of the range: how wide the neighbourhood of an extreme value is
_LEAST_CLIPPED = 5  # samples at an extreme value
_PILED = 1.5  # times as many samples at the extreme value as in its neighbourhood
_LEAST_LEVELS = 100  # in the first block: below, the resolution is too coarse to judge by


def checked_extremes(channel: RecordedChannel, source: str) -> tuple[float, float]:
    """Lowest and highest value of a channel that holds enough real numbers, all finite; NaN if none is a number.

    Raises
    ------
    InputError : with the reason, and for gaps their number and first place
    """
    where = f'{source}: "{shown(channel.name, 60)}"'
    if not channel.is_numeric:
        complex_ = channel.dtype.kind == "c" or channel.dtype.names == ("real", "imag")
        what = "complex numbers" if complex_ else "no numbers"
        raise InputError(f"{where} holds {what} ({shown(str(channel.dtype), 40)}). Give a signal over time.")
    if channel.size < LEAST_SAMPLES:
        raise InputError(
            f"{where} has {channel.size} samples, at least {LEAST_SAMPLES} are needed. Give a longer recording."
        )
    if channel.problem:
        raise InputError(f"{where} {channel.problem}. The file is damaged or cut off; save or copy it again.")
    gaps, first, low, high = 0, 0, np.inf, -np.inf
    for start, values in channel.blocks():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad) and not gaps:
            first = start + int(bad[0]) + 1
        gaps += len(bad)
        low, high = min(low, float(np.min(values))), max(high, float(np.max(values)))
    if gaps == channel.size:
        return np.nan, np.nan
    if gaps:
        raise InputError(
            f"{where} has gaps: {gaps} of {channel.size} samples are NaN or infinite, the first is sample {first}. "
            "Fill the gaps, or cut the recording before them."
        )
    return low, high


def is_silent(extremes: tuple[float, float]) -> bool:
    """Whether all samples between these extremes are equal, or none is a number."""
    return not extremes[0] < extremes[1]


def whole_numbers(channel: RecordedChannel) -> bool:
    """Whether the first block holds whole numbers only, as an analog-to-digital converter counts."""
    _, start = next(channel.blocks())
    return bool(np.all(start == np.round(start)))


def clipped_share(channel: RecordedChannel, low: float, high: float) -> float:
    """Share of the samples that lie at the extreme values because the signal was cut there; 0.0 where it was not.

    A signal that is not clipped spends less time at its highest value than just below it: samples that pile up at the
    very highest, or lowest, value were cut off by an amplifier or converter.
    """
    _, start = next(channel.blocks())
    if len(np.unique(start)) < _LEAST_LEVELS:
        return 0.0
    width = _NEAR * (high - low)
    piles = np.zeros((2, 2), dtype=int)  # samples at each extreme value, and near it
    for _, values in channel.blocks():
        for pile, inside in zip(piles, (values - low, high - values), strict=True):
            pile += np.count_nonzero(inside == 0), np.count_nonzero((inside > 0) & (inside <= width))
    clipped = sum(int(at) for at, near in piles if at >= _LEAST_CLIPPED and at > _PILED * near)
    return clipped / channel.size
