"""TDMS files of LabVIEW, read by the package nptdms into memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pipelines.border.errors import InputError
from pipelines.border.shown import shown
from pipelines.recordings.channels import Channel, Contents

_INCREMENT = "wf_increment"  # s, of a waveform
_UNITS = ("unit_string", "NI_UnitDescription")


def memory(path: Path) -> int:
    """Bytes that its values take, scaled."""
    with path.open("rb") as raw, _library().open(raw) as file:
        return sum(
            max(8, channel.dtype.itemsize) * len(channel) for group in file.groups() for channel in group.channels()
        )


def open_tdms(path: Path) -> Contents:
    """The channels of all groups, named "group/channel" where there are several groups."""
    with path.open("rb") as raw:  # which nptdms leaves open when it stumbles
        file = _library().read(raw)
    if file.file_status.incomplete_final_segment:
        raise InputError(
            f"{shown(path)}: ends within its last segment. Copy the file again, or close the recorder first."
        )
    several = len(file.groups()) > 1
    found = []
    for group in file.groups():
        for channel in group.channels():
            name = f"{group.name}/{channel.name}" if several else channel.name
            found.append(_channel(name, channel))
    return Contents(channels=tuple(found))


def _channel(name: str, channel: Any) -> Channel:
    values = np.asarray(channel[:])
    step = channel.properties.get(_INCREMENT)
    units = next((str(channel.properties[key]) for key in _UNITS if channel.properties.get(key)), "")
    return Channel(
        name=name,
        size=len(values),
        dtype=values.dtype,
        read=lambda part: values[part],
        units=units,
        rate=1.0 / float(step) if step else None,
    )


def _library() -> Any:
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise InputError("a TDMS file needs the package nptdms: pip install 'gearcase[tdms]'") from error
    return TdmsFile
