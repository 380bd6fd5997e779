"""Channels: signals of a file in any format. Samples are read when they are used."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

import numpy as np

from pipelines.io.shown_text import shown

LEAST_VALUES = 2  # fewer values are a setting, not a signal
_NAME = re.compile(r"(?P<name>.*?)\s*[\[(](?P<units>[^\[\]()]*)[\])]\s*")
_EXPORTED = re.compile(r"(?:journal_)?acceleration (?P<sensor>\S+) (?P<axis>[xyz])")
SHAFT_ANGLE = "shaft_angle "  # start of the name of an exported angle, before the name of the shaft
DATE = r"\d{4}[-/]\d\d[-/]\d\d|\d\d?[-/][A-Za-z]{3}[-/]\d\d(?:\d\d)?"  # 2017-06-25, 2017/06/25, 25-Jun-17, 25-Jun-2017
_MOMENT = re.compile(rf"(?<!\d)({DATE})\D{{1,12}}(\d\d?:\d\d:\d\d)")
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_RATES = (  # without "rate", which can be the speed of a shaft
    "fs", "fshz", "sr", "ratehz", "samplerate", "samplingrate", "samplefreq", "samplingfreq", "samplefrequency",
    "samplingfrequency",
)  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordedChannel:
    """One signal of a file.

    `read` returns the samples of a slice; `units` and `rate` (Hz) are those in the file, "" and None without; `place`
    is the sensor and axis named by the file; `stamps` is true for time stamps, as seconds; `problem` is the reason why
    the samples cannot be used, "" if they can.
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
        """Number of the first sample, and samples, block by block."""
        for first in range(0, self.size, length):
            yield first, self.read(slice(first, min(first + length, self.size)))


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordedContents:
    """The channels of a file, in its order, the function that closes it, and texts that may state when it begins."""

    channels: tuple[RecordedChannel, ...]
    close: Callable[[], None] = lambda: None
    texts: str = ""

    @property
    def begin(self) -> str:
        """The first date (`DATE`) with a time of day in the texts, in the form of ISO 8601; "" if there is none.

        Other texts than 2026-11-27T12:00:00 can be between the two, as in the head of a LabVIEW measurement file.
        """
        if found := _MOMENT.search(self.texts):
            with contextlib.suppress(ValueError):  # a month 13
                return datetime.fromisoformat(f"{date_of(found[1])}T{found[2]:0>8}").isoformat()
        return ""

    def names(self) -> str:
        """Names of the channels, for messages."""
        names = [shown(channel.name, 60) for channel in self.channels[:20]]
        return ", ".join(names + ["..."] * (len(self.channels) > 20)) or "none"


def date_of(text: str) -> date:
    """The date of a text of the form `DATE`; a year of two digits is between 1970 and 2069.

    Raises
    ------
    ValueError : no such day or month
    """
    first, month, last = re.split("[-/]", text)
    if month.isdigit():
        return date(int(first), int(month), int(last))
    year = int(last) if len(last) > 2 else 1970 + (int(last) - 70) % 100
    return date(year, _MONTHS.index(month.lower()) + 1, int(first))


def of_array(name: str, values: np.ndarray, **facts: Any) -> RecordedChannel:
    """Channel of an array of one dimension, in memory or in a file; `facts` are other fields of `RecordedChannel`."""
    return RecordedChannel(name=name, size=len(values), dtype=values.dtype, read=lambda part: values[part], **facts)


def array_channels(
    name: str, values: Any, *, units: str = "", rate: float | None = None, problem: str = ""
) -> Iterator[RecordedChannel]:
    """Channels of an array of one or two dimensions, of which the longer one is time; none for other arrays.

    Parameters
    ----------
    name : of the array; several signals are numbered from 1
    values : array, or anything that can be sliced as one, such as a dataset of an HDF5 file
    units, rate, problem : of all its signals
    """
    shape = values.shape
    facts: dict[str, Any] = {"dtype": np.dtype(values.dtype), "units": units, "rate": rate, "problem": problem}
    if len(shape) == 1 and shape[0] >= LEAST_VALUES:
        yield RecordedChannel(name=name, size=shape[0], read=lambda part: values[part], **facts)
    if len(shape) != 2 or max(shape) < LEAST_VALUES or not min(shape):
        return
    along = 0 if shape[0] >= shape[1] else 1
    for column in range(shape[1 - along]):

        def read(part: slice, column: int = column) -> np.ndarray:
            return values[part, column] if along == 0 else values[column, part]

        label = name if shape[1 - along] == 1 else f"{name} {column + 1}".strip()
        yield RecordedChannel(name=label, size=shape[along], read=read, **facts)


def name_and_units(text: str) -> tuple[str, str]:
    """Name and units of a title such as "drive end [g]" or "time (ms)"; "" without units."""
    found = _NAME.fullmatch(text.strip())
    return (found["name"], found["units"].strip()) if found and found["name"] else (text.strip(), "")


def exported_place(name: str) -> tuple[str, str] | None:
    """Sensor and axis of a channel written by `gearcase export`, such as "acceleration sensor_3 x"; else None."""
    found = _EXPORTED.fullmatch(name)
    return (found["sensor"], found["axis"]) if found else None


def says_rate(name: str) -> bool:
    """Whether a setting of this name is the sampling rate; only the last part of a path matters."""
    return re.sub(r"[^a-z]", "", name.lower().rpartition(".")[2]) in _RATES


def distinct(names: list[str]) -> list[str]:
    """The names made unique: repeated ones get " (2)" and so on."""
    before = [names[:place].count(name) for place, name in enumerate(names)]
    return [f"{name} ({count + 1})" if count else name for name, count in zip(names, before, strict=True)]
