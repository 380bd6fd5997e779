"""Read a recording: the signals of a measured file in the form of the response of a run.

A dataset with `acceleration` (time, sensor, axis) in m/s2 over even steps of `time` in s, `tachometer` (time) if
there is one, and `known_speed` (time) in Hz if the machine file gives it. Missing axes of a sensor are NaN.
Samples are read from the file when they are used.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray
from xarray.core import indexing

from pipelines.io.errors import InputError
from pipelines.io.shown_text import nearest_name, shown
from pipelines.recordings.formats import damage_refused, format_of, memory_needed, open_channels
from pipelines.recordings.hdf5 import holds_recording
from pipelines.recordings.machine_file import MeasuredMachine, shaft_name
from pipelines.recordings.machine_table import AXES, DEFAULT_AXIS, ChannelName
from pipelines.recordings.recording_channels import SHAFT_ANGLE, RecordedChannel, RecordedContents
from pipelines.recordings.sample_checks import checked_extremes, clipped_share, is_silent, whole_numbers
from pipelines.recordings.time_axis import is_time, sampling
from pipelines.recordings.units import ACCELERATIONS, GRAVITY, VOLTAGES, may_be_acceleration, plain_units
from pipelines.signals.lazy_array import LazyArray, Place
from pipelines.signals.motion_warnings import ATTRIBUTE
from pipelines.signals.response_file import has_checksum, open_response

_LOG = logging.getLogger(__name__)
_COUNTERS = ("sample", "index", "piece")
_WORTH_A_LINE = 1e6  # bytes: reading a smaller file is not logged
Places = dict[tuple[str, str], RecordedChannel]  # by sensor and axis


def read_recording(source: str | Path, machine: MeasuredMachine) -> xarray.Dataset:
    """Read the recording in a file; close it, or use it in a `with` block, to close the file.

    A response of a run is returned as it is. Attributes of others: `source` (name of the file), `format`, `begin`
    (ISO 8601, "" if the file does not state it), and `warnings`, sentences by kind as JSON (clipped sensors, units that
    contradict the machine).

    Raises
    ------
    InputError : the file cannot be read, or contradicts the machine: what, where, value, limit and remedy
    """
    path = Path(source)
    form = format_of(path)
    if form.name == "HDF5" and (has_checksum(path) or holds_recording(path)):
        return _response(path)
    if (needed := memory_needed(path)) > _WORTH_A_LINE:
        _LOG.info("%s: %s takes about %.0f MB of memory", shown(path), form.name, needed / 1e6)
    contents = open_channels(path)
    try:
        with damage_refused(path, form):
            return _recording(contents, machine, path, form.name)
    except BaseException:
        contents.close()
        raise


def _response(path: Path) -> xarray.Dataset:
    """A file that is already in this form."""
    found = open_response(path)
    if "acceleration" not in found and "journal_acceleration" not in found:
        found.close()
        raise InputError(f"{shown(path)}: holds no acceleration. Add sensors to the scene and run it again.")
    found.attrs["source"] = path.name
    return found


def _recording(contents: RecordedContents, machine: MeasuredMachine, path: Path, form: str) -> xarray.Dataset:
    source, table, tachometer, speed = shown(path), machine.table, machine.table.tachometer, machine.table.speed
    clock = _clock(contents, machine, source)
    named = tachometer.channel if tachometer is not None else None if speed is None else speed.channel
    pulses = None if named is None else channel_of(contents, named, source)
    places = _places(contents, machine, [one for one in (clock, pulses) if one is not None], source)
    angles = {
        one.name.removeprefix(SHAFT_ANGLE): one
        for one in contents.channels
        if one.name.startswith(SHAFT_ANGLE) and named is None and speed is None
    }
    used = [*places.values(), *([] if pulses is None else [pulses]), *angles.values()]
    _check_lengths([*used, *([] if clock is None else [clock])], source)
    extremes = {channel.name: checked_extremes(channel, source) for channel in used}
    needed = [pulses] if pulses is not None and (tachometer is not None or np.isnan(extremes[pulses.name][0])) else []
    places, silent = _without_silent(places, extremes, needed, machine, source)
    rate, start = sampling(used, clock, table.rate_Hz, source)
    scales = {place: _to_si(channel, place[0], machine, source) for place, channel in places.items()}
    sensors = list(dict.fromkeys(sensor for sensor, _ in places))
    axes = [axis for axis in AXES if any(axis == other for _, other in places)]
    placed = [[places.get((sensor, axis)) for axis in axes] for sensor in sensors]
    factors = [[scales.get((sensor, axis), 1.0) for axis in axes] for sensor in sensors]
    variables = {"acceleration": _variable(("sensor", "axis"), placed, factors, {"units": "m/s2"})}
    if pulses is not None and tachometer is not None:
        marks = {"pulses_per_turn": tachometer.pulses_per_turn, "shaft": shaft_name(tachometer.shaft)}
        marks |= {} if tachometer.level is None else {"level": tachometer.level}
        variables["tachometer"] = _variable((), pulses, 1.0, marks | {"units": pulses.units})
    if speed is not None:
        known = {"shaft": shaft_name(speed.shaft), "uncertainty": speed.uncertainty_percent / 100, "units": "Hz"}
        variables["known_speed"] = (
            xarray.Variable("time", np.broadcast_to(speed.rpm / 60, used[0].size), known)
            if speed.rpm is not None
            else _variable((), pulses, 1.0 if speed.units == "Hz" else 1 / 60, known)
        )
    if angles:
        variables["shaft_angle"] = _variable(("shaft",), [*angles.values()], [1.0] * len(angles), {"units": "rad"})
    found = xarray.Dataset(
        variables,
        coords={
            "time": ("time", start + np.arange(used[0].size) / rate, {"units": "s"}),
            "sensor": sensors,
            "axis": axes,
            **({"shaft": list(angles)} if angles else {}),
        },
        attrs={
            "source": path.name,
            "format": form,
            "begin": contents.begin,
            ATTRIBUTE: json.dumps(silent | dict(_warnings(places, extremes, machine, scales))),
        },
    )
    found.set_close(contents.close)
    return found


def _variable(
    dims: tuple[str, ...], table: object, factors: object, attributes: Mapping[str, object]
) -> xarray.Variable:
    """Variable over time and `dims` from a nested list of channels times their factors; NaN without a channel."""
    channels = np.empty(np.shape(np.array(table, dtype=object)), dtype=object)
    channels[...] = table
    by = np.array(factors, float)
    given = [channel for channel in channels.flat if channel is not None]
    single = all(channel.dtype == np.float32 for channel in given) and bool((by == 1.0).all())
    dtype = np.dtype(np.float32 if single else np.float64)

    def read(key: Place) -> np.ndarray:
        instants, places = key[0], key[1:]
        part = slice(instants, instants + 1) if isinstance(instants, int | np.integer) else instants
        chosen, of_chosen = np.asarray(channels[places], dtype=object), np.asarray(by[places])
        values = np.full((len(range(*part.indices(given[0].size))), *chosen.shape), np.nan, dtype)
        for place, channel in np.ndenumerate(chosen):
            if channel is not None:
                values[(slice(None), *place)] = channel.read(part) * dtype.type(of_chosen[place])
        return values[0] if part is not instants else values

    lazy = LazyArray((given[0].size, *channels.shape), dtype, read)
    return xarray.Variable(("time", *dims), indexing.LazilyIndexedArray(lazy), dict(attributes))


def channel_of(contents: RecordedContents, wanted: ChannelName, source: str) -> RecordedChannel:
    """Channel of a name or number.

    Raises
    ------
    InputError : there is none; lists the existing ones
    """
    if isinstance(wanted, int):
        if wanted <= len(contents.channels):
            return contents.channels[wanted - 1]
        raise InputError(
            f"{source}: there is no channel {wanted}, the file has {len(contents.channels)}: {contents.names()}. "
            "Correct the number in the machine file."
        )
    named = {channel.name: channel for channel in contents.channels}
    if wanted in named:
        return named[wanted]
    near = nearest_name(wanted, named)
    hint = f'Did you mean "{shown(near)}"?' if near else "Correct the name in the machine file."
    raise InputError(f'{source}: there is no channel "{shown(wanted)}", the file has {contents.names()}. {hint}')


def _clock(contents: RecordedContents, machine: MeasuredMachine, source: str) -> RecordedChannel | None:
    """Channel of the time: that of the machine file, or the first with such a name."""
    wanted = machine.table.time
    if wanted is None:
        return next((channel for channel in contents.channels if is_time(channel)), None)
    return None if wanted is False else channel_of(contents, wanted, source)


def _places(
    contents: RecordedContents, machine: MeasuredMachine, others: Sequence[RecordedChannel], source: str
) -> Places:
    """Channels by sensor and axis: those of the machine file, else all that can be accelerations."""
    if machine.table.sensors:
        return {
            (name, axis): channel_of(contents, channel, source)
            for name, axes in machine.table.sensors.items()
            for axis, channel in axes.items()
        }
    found = [
        channel
        for channel in contents.channels
        if channel not in others
        and channel.dtype.kind not in "OSUbMm"
        and channel.name not in _COUNTERS
        and not is_time(channel)
        and may_be_acceleration(channel.units)
    ]
    if not found:
        raise InputError(
            f"{source}: no channel has the unit of an acceleration; the channels are {contents.names()}. Set sensors "
            "and units in the machine file."
        )
    places: Places = {}
    for channel in [channel for channel in found if channel.place] or found:
        place = channel.place or (channel.name, DEFAULT_AXIS)
        if place in places:
            raise InputError(
                f"{source}: {shown(place[0])} {place[1]} exists twice, as {shown(places[place].name)} and "
                f"{shown(channel.name)}. Set sensors in the machine file."
            )
        places[place] = channel
    return places


def _without_silent(
    places: Places,
    extremes: Mapping[str, tuple[float, float]],
    needed: Sequence[RecordedChannel],
    machine: MeasuredMachine,
    source: str,
) -> tuple[Places, dict[str, str]]:
    """The places without constant channels, and a warning of each by its kind.

    Raises
    ------
    InputError : such a channel is needed, the machine file names it, or there is no other
    """
    silent = {place: channel.name for place, channel in places.items() if is_silent(extremes[channel.name])}
    left = {place: channel for place, channel in places.items() if place not in silent}
    fixed = [channel.name for channel in needed if is_silent(extremes[channel.name])]
    if fixed or (silent and (machine.table.sensors or not left)):
        name = [*fixed, *silent.values()][0]
        raise InputError(
            f'{source}: "{shown(name, 60)}" {_silence(extremes[name])}. Check the sensor, or delete it from sensors of '
            "the machine file."
        )
    warned = {
        f"silent {sensor} {axis}": f"{shown(f'{sensor} {axis}')} {_silence(extremes[name])} and is not used. Check the "
        "sensor, or set sensors in the machine file."
        for (sensor, axis), name in silent.items()
    }
    return left, warned


def _silence(extremes: tuple[float, float]) -> str:
    return "holds no number" if np.isnan(extremes[0]) else f"is {extremes[0]:g} throughout"


def _check_lengths(channels: Sequence[RecordedChannel], source: str) -> None:
    if len({channel.size for channel in channels}) > 1:
        lengths = ", ".join(f"{shown(channel.name, 60)} {channel.size}" for channel in channels[:10])
        raise InputError(
            f"{source}: the channels have different numbers of samples ({lengths}). Set sensors in the machine file "
            "to channels of one length."
        )


def _units(channel: RecordedChannel, machine: MeasuredMachine) -> str:
    """Units of the machine file, else of the recording, else m/s2."""
    return plain_units(machine.table.units or channel.units) or "m/s2"


def _to_si(channel: RecordedChannel, sensor: str, machine: MeasuredMachine, source: str) -> float:
    """Factor from the numbers of a channel to m/s2."""
    units, table = _units(channel, machine), machine.table
    scale = _of_sensor(table.scale, sensor) or 1.0
    if units in ACCELERATIONS:
        return scale * ACCELERATIONS[units]
    where = f'{source}: "{shown(channel.name, 60)}" is in {shown(units, 40)}'
    if units not in VOLTAGES:
        raise InputError(
            f"{where}, allowed are {', '.join((*ACCELERATIONS, *VOLTAGES))}. Set units in the machine file, or another "
            "channel in sensors."
        )
    sensitivity = _of_sensor(table.sensitivity_mV_g, sensor)
    if sensitivity is None:
        raise InputError(f"{where}. Set sensitivity_mV_g of the sensors in the machine file.")
    return scale * VOLTAGES[units] / (sensitivity / 1000) * GRAVITY


def _of_sensor(numbers: Mapping[str, float], sensor: str) -> float | None:
    """The number of a sensor, else the common number; None without one."""
    return numbers.get(sensor, numbers.get(""))


def _warnings(
    places: Places,
    extremes: Mapping[str, tuple[float, float]],
    machine: MeasuredMachine,
    scales: Mapping[tuple[str, str], float],
) -> Iterator[tuple[str, str]]:
    """Warnings by kind, as sentences."""
    table = machine.table
    for (sensor, axis), channel in places.items():
        place, (low, high), factor = f"{shown(sensor)} {axis}", extremes[channel.name], scales[sensor, axis]
        if share := clipped_share(channel, low, high):
            yield (
                f"clipped {sensor} {axis}",
                f"{place} is clipped: {share:.2%} of its samples lie at its extreme values, {low * factor:.4g} and "
                f"{high * factor:.4g} m/s2. Reduce the gain and record it again.",
            )
        in_file = plain_units(channel.units)
        if in_file and in_file != _units(channel, machine):
            yield (
                f"units {sensor} {axis}",
                f"{place} is read in {_units(channel, machine)} as the machine file gives it; the recording gives "
                f"{shown(in_file, 40)}. Correct units if this is wrong.",
            )
        if not (in_file or table.units or table.scale) and whole_numbers(channel):
            yield (
                f"counts {sensor} {axis}",
                f"{place} holds whole numbers without units, which are read as m/s2. If they are counts of a "
                "converter, set units, and scale to the units per count, in the machine file.",
            )
