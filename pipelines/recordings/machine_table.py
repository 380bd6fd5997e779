"""The short description of a machine that was measured: its keys, as they are written in a TOML file.

teeth = [[21, 62], [23, 75]]        # pairs in series, the driving gear first
speed_rpm = 1480                    # of the first shaft
rate_Hz = 25600
units = "g"
sensors = { gearbox = "channel 1" }
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, model_validator

from pipelines.recordings.units import ACCELERATIONS, VOLTAGES, plain_units
from pipelines.scene.tables.scene_table import Number, Positive, Table
from pipelines.scene.tables.scene_table import Whole as Integer

AXES = ("x", "y", "z")
DEFAULT_AXIS = "z"
PASS_ORDERS = ("BPFO", "BPFI", "BSF", "FTF")
_GEOMETRY = ("elements", "pitch_diameter_mm", "element_diameter_mm")
ChannelName = str | int  # name of a channel, or its number in the file, from 1


def _channel(value: Any) -> ChannelName:
    named, numbered = isinstance(value, str) and value, type(value) is int and value >= 1  # true is no number
    if not (named or numbered):
        raise ValueError("must be the name of a channel in quotes, or its number in the file, from 1 up")
    return value


def _time(value: Any) -> ChannelName | Literal[False]:
    return value if value is False else _channel(value)


def _sensors(value: Any) -> dict[str, dict[str, ChannelName]]:
    """Sensors as names with a channel by axis; a single channel is that of the default axis."""
    if not isinstance(value, dict) or not value:
        raise ValueError('must be a table of names and channels, for example { gearbox = "channel 1" }')
    found = {}
    for name, given in value.items():
        channels = given if isinstance(given, dict) else {DEFAULT_AXIS: given}
        if unknown := [axis for axis in channels if axis not in AXES]:
            raise ValueError(f"{name} has the axis {unknown[0]}; allowed are {', '.join(AXES)}")
        if not channels:
            raise ValueError(f'{name} has no channel; set one, for example {name} = {{ x = "channel 1" }}')
        try:
            found[name] = {axis: _channel(channel) for axis, channel in channels.items()}
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    return found


def _by_sensor(value: Any) -> dict[str, float]:
    """A positive number for all sensors, under the name "", or one for each."""
    numbers = value if isinstance(value, dict) else {"": value}
    plain = all(type(one) in (int, float) and 0.0 < one < float("inf") for one in numbers.values())
    if not numbers or not plain:
        raise ValueError("must be a positive number, or a table of sensors and positive numbers")
    return {name: float(one) for name, one in numbers.items()}


Channel = Annotated[ChannelName, PlainValidator(_channel)]
Teeth = Annotated[Integer, Field(ge=3, le=10_000)]
ShaftNumber = Annotated[Integer, Field(ge=1, le=100)]


class TachometerTable(Table):
    """A channel with pulses of a shaft: a tachometer, or an encoder."""

    channel: Annotated[Channel, Field(description="name of the channel, or its number in the file")]
    pulses_per_turn: Annotated[Positive, Field(description="pulses per turn of the shaft")] = 1.0
    shaft: Annotated[ShaftNumber, Field(description="number of the shaft that carries the mark")] = 1
    level: Annotated[
        Number | None,
        Field(description="value at which a pulse begins, in the units of the channel; without it: half of the range"),
    ] = None


class SpeedTable(Table):
    """The speed of a shaft, if it is known: a constant, or a channel."""

    rpm: Annotated[Positive | None, Field(description="constant speed")] = None
    channel: Annotated[Channel | None, Field(description="channel of the speed: its name or number in the file")] = None
    units: Annotated[Literal["rpm", "Hz"], Field(description="units of the channel")] = "rpm"
    shaft: Annotated[ShaftNumber, Field(description="number of the shaft with this speed")] = 1
    uncertainty_percent: Annotated[Positive, Field(le=5, description="largest error of the mean speed, in per cent")]

    @model_validator(mode="after")
    def _one_way(self) -> SpeedTable:
        if (self.rpm is None) == (self.channel is None):
            raise ValueError("give either rpm, a constant speed, or channel, which contains the speed")
        return self


class BearingTable(Table):
    """A rolling bearing, by its geometry or by its pass orders."""

    name: Annotated[str, Field(min_length=1, max_length=60, description="name of the bearing in the results")]
    shaft: Annotated[ShaftNumber, Field(description="number of the shaft of the bearing")] = 1
    elements: Annotated[Integer | None, Field(ge=3, le=1000, description="number of balls or rollers")] = None
    pitch_diameter_mm: Annotated[
        Positive | None, Field(description="diameter of the circle through the centres of the elements")
    ] = None
    element_diameter_mm: Annotated[Positive | None, Field(description="diameter of a ball or roller")] = None
    contact_angle_deg: Annotated[Number, Field(ge=0, lt=75, description="contact angle")] = 0.0
    BPFO: Annotated[Positive | None, Field(description="pass order of the outer ring per turn of the shaft")] = None
    BPFI: Annotated[Positive | None, Field(description="pass order of the inner ring")] = None
    BSF: Annotated[Positive | None, Field(description="turns of an element per turn of the shaft")] = None
    FTF: Annotated[Positive | None, Field(description="turns of the cage per turn of the shaft")] = None

    @model_validator(mode="after")
    def _one_way(self) -> BearingTable:
        geometry = [key for key in _GEOMETRY if getattr(self, key) is not None]
        if bool(geometry) == bool(self.orders()):
            raise ValueError(f"give either {', '.join(_GEOMETRY)}, or pass orders ({', '.join(PASS_ORDERS)})")
        if geometry and len(geometry) < len(_GEOMETRY):
            raise ValueError(
                f"{', '.join(key for key in _GEOMETRY if key not in geometry)} is missing; give all of the geometry"
            )
        return self

    def orders(self) -> dict[str, float]:
        """The pass orders that are written."""
        return {name: getattr(self, name) for name in PASS_ORDERS if getattr(self, name) is not None}


class MachineTable(Table):
    """A machine and how its recordings are to be read."""

    teeth: Annotated[
        tuple[tuple[Teeth, Teeth], ...],
        Field(max_length=50, description="numbers of teeth of driving and driven gear, pair by pair"),
    ] = ()
    shafts: Annotated[
        tuple[tuple[ShaftNumber, ShaftNumber], ...] | None,
        Field(description="numbers of the two shafts of each gear pair; without it: pairs in series"),
    ] = None
    ratios: Annotated[
        tuple[Positive, ...],
        Field(max_length=100, description="speeds of the shafts divided by that of the first; instead of teeth"),
    ] = ()
    bearings: Annotated[tuple[BearingTable, ...], Field(max_length=200, description="rolling bearings")] = ()
    speed_rpm: Annotated[
        Positive | None,
        Field(
            description="speed of the first shaft, from which the search begins; not needed with tachometer or speed"
        ),
    ] = None
    speed: Annotated[SpeedTable | None, Field(description="known speed, instead of a search in the vibration")] = None
    rate_Hz: Annotated[Positive | None, Field(description="sampling rate, if the recording does not hold it")] = None
    time: Annotated[
        ChannelName | Literal[False] | None,
        PlainValidator(_time),
        Field(description="channel that holds the time, if it is not called time or t; false: the time is not used"),
    ] = None
    units: Annotated[
        str | None, Field(description="units of the signals; without it: those of the recording, or m/s2")
    ] = None
    sensitivity_mV_g: Annotated[
        dict[str, float],
        PlainValidator(_by_sensor),
        Field(default={}, description="sensitivity of all sensors, or by sensor, for a recording in volts"),
    ]
    scale: Annotated[
        dict[str, float],
        PlainValidator(_by_sensor),
        Field(
            default={},
            description="factor from the numbers in the file to units, of all sensors or by sensor: full scale of a "
            "WAV file, units per count; without it: 1",
        ),
    ]
    sensors: Annotated[
        dict[str, dict[str, ChannelName]],
        PlainValidator(_sensors),
        Field(default={}, description="channels by sensor, or by sensor and axis; without it: all channels, axis z"),
    ]
    tachometer: Annotated[TachometerTable | None, Field(description="channel with pulses of a shaft")] = None

    @model_validator(mode="after")
    def _consistent(self) -> MachineTable:
        if problems := [*self._train(), *self._signals()]:
            raise ValueError("\n".join(problems))
        return self

    def _train(self) -> Iterator[str]:
        if self.teeth and self.ratios:
            yield "teeth and ratios are both given; delete one of them"
        if self.ratios and self.ratios[0] != 1.0:
            yield f"ratios: the first is {self.ratios[0]:g} and must be 1; give the speeds over that of the first shaft"
        if self.shafts is not None and len(self.shafts) != len(self.teeth):
            yield f"shafts has {len(self.shafts)} pairs of numbers, teeth has {len(self.teeth)}; give one for each"
        if self.speed_rpm is None and self.tachometer is None and self.speed is None:
            yield "speed_rpm is missing. Set the speed of the first shaft, a tachometer, or speed"
        if self.tachometer is not None and self.speed is not None:
            yield "tachometer and speed are both given; delete one of them"

    def _signals(self) -> Iterator[str]:
        for key, by_sensor in (("scale", self.scale), ("sensitivity_mV_g", self.sensitivity_mV_g)):
            if self.sensors and (unknown := sorted(by_sensor.keys() - {"", *self.sensors})):
                yield f"{key}: there is no sensor {unknown[0]}. Correct the name, or add it to sensors"
        known = (*ACCELERATIONS, *VOLTAGES)
        if self.units is None:
            return
        if plain_units(self.units) not in known:
            yield f'units = "{self.units}": must be one of {", ".join(known)}. Correct it'
        elif plain_units(self.units) in VOLTAGES and not self.sensitivity_mV_g:
            yield "sensitivity_mV_g is missing. Set it for signals in volts, for example to 100"
