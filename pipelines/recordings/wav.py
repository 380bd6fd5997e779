"""WAV files. Integers become shares of the full scale, -1 to 1."""

from __future__ import annotations

import warnings
from functools import partial
from pathlib import Path

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.recordings.recording_channels import RecordedChannel, RecordedContents

_UNSAID = 0xFFFFFFFF  # size in the header of a file that was written as a stream
_PADDING = 1  # byte that some programs include in the size but do not write


def memory(path: Path) -> int:
    """Bytes of the samples in memory: 24 bits become 32."""
    return path.stat().st_size * 4 // 3


def open_channels(path: Path) -> RecordedContents:
    """Channels of a WAV file, named by their numbers.

    Raises
    ------
    InputError : the file is shorter than its header states
    """
    from scipy.io import wavfile

    with path.open("rb") as file:
        mark, size = file.read(4), int.from_bytes(file.read(4), "little")
    if mark == b"RIFF" and size != _UNSAID and size + 8 > path.stat().st_size + _PADDING:
        raise InputError(f"{shown(path)}: is cut off, it has {path.stat().st_size} of {size + 8} bytes. Copy it again.")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # about text chunks, which are ignored
        rate, samples = wavfile.read(path)
    samples = samples.reshape(len(samples), -1)
    scale, middle = _scale(samples.dtype)
    kind = samples.dtype if scale == 1.0 else np.dtype(float)
    channels = (
        RecordedChannel(
            name=f"channel {number}",
            size=len(samples),
            dtype=kind,
            read=partial(_shares, column, scale, middle),
            rate=float(rate),
        )
        for number, column in enumerate(samples.T, 1)
    )
    return RecordedContents(channels=tuple(channels))


def _shares(values: np.ndarray, scale: float, middle: float, part: slice) -> np.ndarray:
    """The samples of a part as shares of the full scale."""
    return np.asarray((values[part].astype(float) - middle) / scale)


def _scale(kind: np.dtype) -> tuple[float, float]:
    """Full scale and middle of a type; 24 bits are in the upper bits of 32."""
    if kind.kind == "f":
        return 1.0, 0.0
    return (128.0, 128.0) if kind.kind == "u" else (2.0 ** (8 * kind.itemsize - 1), 0.0)
