"""Universal files (UFF): time responses of dataset 58 as text."""

from __future__ import annotations

from pathlib import Path

from pipelines.io.universal_file import QUANTITIES, Function, UniversalFunction, read_functions
from pipelines.recordings.channels import (
    RecordedChannel,
    RecordedContents,
    array_channels,
    distinct,
    exported_place,
    of_array,
)

_AXES = {1: "x", 2: "y", 3: "z"}
_UNSAID = (0, 1, 12)  # types of the ordinate that may be an acceleration: unknown, general, acceleration


def memory(path: Path) -> int:
    """Bytes that its text takes while its last record becomes numbers."""
    return 2 * path.stat().st_size


def open_channels(path: Path) -> RecordedContents:
    """A channel for each time response, with the sensor and axis of its point; uneven ones bring their time along."""
    with path.open(encoding="latin-1") as file:
        records = list(read_functions(file))
    names = distinct([_name(record.head) for record in records])
    channels = [_channel(name, record) for name, record in zip(names, records, strict=True)]
    times = [record.x for record in records if record.x is not None]
    found = [*array_channels("time", times[0], units="s"), *channels] if times else channels
    texts = " ".join(line for record in records for line in record.head.lines)
    return RecordedContents(channels=tuple(found), texts=texts)


def _channel(name: str, record: UniversalFunction) -> RecordedChannel:
    head = record.head
    values = -record.values if head.direction < 0 else record.values

    units = head.units or ("" if head.quantity in _UNSAID else QUANTITIES.get(head.quantity, "another quantity"))
    return of_array(
        name,
        values,
        units=units,
        rate=1.0 / head.step if record.x is None and head.step > 0.0 else None,
        place=exported_place(name) or _place(head),
    )


def _place(head: Function) -> tuple[str, str] | None:
    """Sensor and axis of a point; None for a scalar or a rotation."""
    axis = _AXES.get(abs(head.direction))
    return None if axis is None else (head.entity or f"node_{head.node}", axis)


def _name(head: Function) -> str:
    """The first line, which describes the function; without it the point."""
    point = " ".join(_place(head) or (head.entity or f"node_{head.node}",))
    return head.lines[0] or point
