"""TDMS files of LabVIEW, read by the package nptdms into memory."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.recordings.recording_channels import RecordedChannel, RecordedContents, of_array

_INCREMENT = "wf_increment"  # s, of a waveform
_UNITS = ("unit_string", "NI_UnitDescription")


def memory(path: Path) -> int:
    """Bytes that its values take, scaled."""
    library = _library()
    with path.open("rb") as raw, _complaints(), library.open(raw) as file:
        channels = [channel for group in file.groups() for channel in group.channels()]
        return sum(max(8, channel.dtype.itemsize) * len(channel) for channel in channels)


def open_channels(path: Path) -> RecordedContents:
    """The channels of all groups, named "group/channel" where there are several groups.

    Raises
    ------
    InputError : nptdms is not installed, or had to guess: the file is damaged or was not closed
    """
    library = _library()
    with path.open("rb") as raw, _complaints() as said:  # nptdms does not close a file that it cannot read
        file = library.read(raw)
    if said or file.file_status.incomplete_final_segment:
        reason = shown(said[0] if said else "its last segment is not whole", 100)
        raise InputError(
            f"{shown(path)}: is damaged or cut off ({reason}). Copy it again, or close the recorder first."
        )
    several = len(file.groups()) > 1
    channels = [channel for group in file.groups() for channel in group.channels()]
    texts = " ".join(str(channel.properties.get("wf_start_time", "")) for channel in channels)
    return RecordedContents(channels=tuple(_channel(channel, several) for channel in channels), texts=texts)


@contextlib.contextmanager
def _complaints() -> Iterator[list[str]]:
    """What nptdms would print on the terminal while the block runs."""
    said: list[str] = []

    def keep(record: logging.LogRecord) -> bool:
        said.append(record.getMessage())
        return False

    loggers = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.startswith("nptdms.")]
    for logger in loggers:
        logger.addFilter(keep)
    try:
        yield said
    finally:
        for logger in loggers:
            logger.removeFilter(keep)


def _channel(channel: Any, several: bool) -> RecordedChannel:
    name = f"{channel.group_name}/{channel.name}" if several else channel.name
    step = channel.properties.get(_INCREMENT)
    units = next((str(channel.properties[key]) for key in _UNITS if channel.properties.get(key)), "")
    return of_array(name, np.asarray(channel[:]), units=units, rate=1.0 / float(step) if step else None)


def _library() -> Any:
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise InputError(
            "a TDMS file needs the package nptdms. Install it with: pip install 'gearcase[tdms]'"
        ) from error
    return TdmsFile
