"""Channels: what a file of signals holds, column by column, in every format. Samples are read when they are used."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipelines.io.shown import shown

LEAST_VALUES = 2  # fewer are a setting, not a signal
_NAME = re.compile(r"(?P<name>.*?)\s*[\[(](?P<units>[^\[\]()]*)[\])]\s*")
_EXPORTED = re.compile(r"acceleration (?P<sensor>\S+) (?P<axis>[xyz])")
_RATES = (  # a "rate" alone may be the speed of a shaft
    "fs", "fshz", "sr", "ratehz", "samplerate", "samplingrate", "samplefreq", "samplingfreq", "samplefrequency",
    "samplingfrequency",
)  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Channel:
    """One signal of a file.

    `read` gives the samples of a slice; `units` and `rate` (Hz) are as the file says them, "" and None where it does
    not; `place` is the sensor and axis that the file names; `stamps` says that it holds time stamps, as seconds;
    `problem` is why its samples cannot be used, "" if they can.
    """

    name: str
    size: int
    dtype: np.dtype
    read: Callable[[slice], np.ndarray]
    units: str = ""
    rate: float | None = None
    place: tuple[str, str] | None = None
    stamps: bool = False
    problem: str = ""

    @property
    def is_numeric(self) -> bool:
        """Whether the samples are real numbers."""
        return self.dtype.kind in "iuf"

    def blocks(self, length: int = 1 << 18) -> Iterator[tuple[int, np.ndarray]]:
        """The number of the first sample and the samples, part by part."""
        for first in range(0, self.size, length):
            yield first, self.read(slice(first, min(first + length, self.size)))


@dataclass(frozen=True, eq=False, kw_only=True)
class Contents:
    """The channels of a file, in its order, and how it is closed."""

    channels: tuple[Channel, ...]
    close: Callable[[], None] = lambda: None

    def names(self) -> str:
        """The names of all channels, for messages."""
        return ", ".join(shown(channel.name, 60) for channel in self.channels[:20]) or "none"


def of_array(name: str, values: np.ndarray, **facts: Any) -> Channel:
    """The channel of an array of one dimension, which may lie in a file; `facts` are other fields of `Channel`."""
    return Channel(name=name, size=len(values), dtype=values.dtype, read=lambda part: values[part], **facts)


def array_channels(
    name: str, values: Any, *, units: str = "", rate: float | None = None, problem: str = ""
) -> Iterator[Channel]:
    """The signals of an array of one or two dimensions, of which the longer one is time; none of any other.

    Parameters
    ----------
    name : of the array; its signals are numbered from 1 where there are several
    values : array, or anything that is sliced like one, as a dataset of an HDF5 file
    units, rate, problem : of all its signals
    """
    shape = values.shape
    facts: dict[str, Any] = {"dtype": np.dtype(values.dtype), "units": units, "rate": rate, "problem": problem}
    if len(shape) == 1 and shape[0] >= LEAST_VALUES:
        yield Channel(name=name, size=shape[0], read=lambda part: values[part], **facts)
    if len(shape) != 2 or max(shape) < LEAST_VALUES or not min(shape):
        return
    along = 0 if shape[0] >= shape[1] else 1
    for column in range(shape[1 - along]):

        def read(part: slice, column: int = column) -> np.ndarray:
            return values[part, column] if along == 0 else values[column, part]

        label = name if shape[1 - along] == 1 else f"{name} {column + 1}".strip()
        yield Channel(name=label, size=shape[along], read=read, **facts)


def name_and_units(text: str) -> tuple[str, str]:
    """A title such as "drive end [g]" or "time (ms)" as name and units; "" where there are none."""
    found = _NAME.fullmatch(text.strip())
    return (found["name"], found["units"].strip()) if found and found["name"] else (text.strip(), "")


def exported_place(name: str) -> tuple[str, str] | None:
    """Sensor and axis of a channel that `gearcase export` wrote, as "acceleration sensor_3 x"; else None."""
    found = _EXPORTED.fullmatch(name)
    return (found["sensor"], found["axis"]) if found else None


def says_rate(name: str) -> bool:
    """Whether a setting of this name is the sampling rate; the last part of a path counts."""
    return re.sub(r"[^a-z]", "", name.lower().rpartition(".")[2]) in _RATES


def distinct(names: list[str]) -> list[str]:
    """The names, with " (2)" and so on behind those that come again."""
    seen: dict[str, int] = {}
    out = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        out.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return out
