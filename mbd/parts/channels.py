"""Channels: named linear readings of the machine, value = D q + V q' + A q'' + L lambda + constant + rigid part.

Names are ``"<part>:<quantity>"``, defined in the file of each kind of part. `channel_names` lists those of a machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import partial

import numpy as np

from mbd.elements.channel_reading import FURTHER, ChannelKind, Reading, further_class
from mbd.elements.component import Component
from mbd.elements.element import Element
from mbd.parts.bearings import DIRECTIONS, bearing_force, journal_acceleration
from mbd.parts.coordinate_layout import Layout
from mbd.parts.gear_mesh import mesh_channels
from mbd.parts.load import CONTAINER, GROUND_ACCELERATION, OUTSIDE_FORCE, ROPE_FORCE, SWAY
from mbd.parts.machine import Train
from mbd.parts.part_checks import MachineError
from mbd.parts.probe import DISPLACEMENT
from mbd.parts.shafts import shaft_channels
from mbd.parts.speed_drive import COUPLING_TORQUE, motor_channels

__all__ = [
    "CHANNELS",
    "CONTAINER",
    "COUPLING_TORQUE",
    "DIRECTIONS",
    "DISPLACEMENT",
    "GROUND_ACCELERATION",
    "OUTSIDE_FORCE",
    "ROPE_FORCE",
    "SWAY",
    "ChannelRows",
    "acceleration",
    "bearing_force",
    "channel_kinds",
    "channel_names",
    "channel_rows",
    "further_channels",
    "journal_acceleration",
    "mesh_channels",
    "motor_channels",
    "sensor_names",
    "shaft_channels",
]


_AT = partial(ChannelKind, labels=DIRECTIONS)
CHANNELS = (  # the variables that a machine records by itself, in the order of the results
    ChannelKind(
        variable="motor_angle",
        dims=("motor",),
        quantity="angle",
        text="angle of the motor, positive as the first one turns it",
    ),
    ChannelKind(variable="motor_speed", dims=("motor",), quantity="speed", text="speed of the motor"),
    ChannelKind(variable="motor_torque", dims=("motor",), quantity="torque", text="torque of the motor on the shaft"),
    ChannelKind(variable="source_angle", dims=("source",), quantity="angle", text="angle of the load or further motor"),
    ChannelKind(variable="source_speed", dims=("source",), quantity="speed", text="speed of the load or further motor"),
    ChannelKind(variable="source_torque", dims=("source",), quantity="torque", text="its torque, driving positive"),
    ChannelKind(
        variable="coupling_torque",
        dims=("coupling",),
        quantity=COUPLING_TORQUE.removeprefix(":"),
        text="torque from the rotor through its coupling",
    ),
    _AT(
        variable="probe_displacement",
        dims=("probe", "axis"),
        quantity=DISPLACEMENT.removeprefix(":"),
        text="displacement of the shaft's axis at the probe",
    ),
    ChannelKind(variable="shaft_angle", dims=("shaft",), quantity="angle", text="angle of the shaft"),
    ChannelKind(variable="shaft_speed", dims=("shaft",), quantity="speed", text="speed of the shaft"),
    ChannelKind(variable="mesh_approach", dims=("stage",), quantity="delta", text="approach on the drive flank"),
    ChannelKind(variable="mesh_tilt", dims=("stage",), quantity="psi", text="tilt in the plane of action"),
    ChannelKind(variable="mesh_force", dims=("stage",), quantity="drive_force", text="force on the drive flank"),
    ChannelKind(variable="coast_force", dims=("stage",), quantity="coast_force", text="force on the coast flank"),
    _AT(
        variable="bearing_force",
        dims=("bearing", "axis"),
        quantity="f",
        text="force of the bearing on the casing",
    ),
    _AT(variable="acceleration", dims=("sensor", "axis"), quantity="a", text="acceleration of the casing"),
    _AT(
        variable="journal_acceleration",
        dims=("bearing", "axis"),
        quantity="journal_a",
        text="acceleration of the journal",
    ),
    ChannelKind(variable=OUTSIDE_FORCE, dims=("force",), quantity=OUTSIDE_FORCE, text="force from outside"),
    ChannelKind(
        variable=GROUND_ACCELERATION, dims=("base",), quantity=GROUND_ACCELERATION, text="acceleration of the ground"
    ),
    ChannelKind(variable="rope_force", dims=(), quantity=ROPE_FORCE, text="force of all falls together"),
    ChannelKind(variable="container_lift", dims=(), quantity=CONTAINER[0], text="rise of the container"),
    ChannelKind(
        variable="container_acceleration", dims=(), quantity=CONTAINER[1], text="acceleration of the container"
    ),
)


def further_channels(names: Sequence[str], **things: tuple[Component, ...]) -> tuple[Component, ...]:
    """The components that record further channels.

    Parameters
    ----------
    names : of `FURTHER`
    **things : all bearings, shafts, ... of a machine; a component receives those that are fields of its class
    """
    kinds = [further_class(name, MachineError) for name in dict.fromkeys(names)]
    return tuple(kind(**{field.name: things[field.name] for field in fields(kind)}) for kind in kinds)


def channel_kinds() -> tuple[ChannelKind, ...]:
    """All variables of the results."""
    return (*CHANNELS, *(further_class(name, MachineError).kind for name in FURTHER))


def acceleration(sensor: str, axis: str) -> str:
    """Acceleration (m/s2) of a casing point along x, y or z."""
    return f"{sensor}:a{axis}"


def channel_names(machine: Train, sensors: tuple[str, ...] = ()) -> tuple[str, ...]:
    """All channels of ``machine`` with the accelerations of the casing points ``sensors``."""
    points = [acceleration(s, a) for s in sensors for a in DIRECTIONS]
    return (*points, *(name for component in machine.components for name in component.channel_names))


def sensor_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """The casing points whose accelerations are among the channels `names`."""
    things = dict.fromkeys(name.partition(":")[0] for name in names)
    return tuple(thing for thing in things if acceleration(thing, DIRECTIONS[0]) in names)


@dataclass(frozen=True, eq=False, kw_only=True)
class ChannelRows:
    """Stacked readings of the requested channels."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    displacement: np.ndarray  # (channel, coordinate)
    velocity: np.ndarray
    acceleration: np.ndarray
    forces: np.ndarray  # (channel, force)
    rigid: np.ndarray
    vibration: np.ndarray  # (channel,) bool, those used for the error estimate of the time step


def channel_rows(names: tuple[str, ...], lay: Layout, elements: Sequence[Element]) -> ChannelRows:
    """Readings of the channels ``names`` of a machine; the forces are those on the rows of its elements.

    Raises
    ------
    MachineError : an unknown channel, with the known ones
    """
    readings = []
    offered = {name: reading for component in lay.components for name, reading in component.readings(lay).items()}
    offered |= _signals(lay, elements)
    for name in names:
        thing, _, quantity = name.partition(":")
        if name in offered:
            readings.append(offered[name])
        elif len(quantity) == 2 and quantity[0] == "a" and quantity[1] in DIRECTIONS:
            if not len(lay.casing.coordinate_names):
                raise MachineError(
                    f"channel {name!r}: a casing of model {lay.casing.model!r} does not move. Set bearing forces "
                    "or journal accelerations, or use another casing model."
                )
            row = f"{thing}:u{quantity[1]}"
            acceleration = lay.casing_row(row)  # raises an error for an unknown row
            shift = lay.casing.row_shifts[lay.casing.row_names.index(row)]
            readings.append(Reading("m/s2", acceleration=acceleration, shift=shift, vibration=True))
        else:
            raise MachineError(f"channel {name!r} is unknown; known: {', '.join(offered)} and '<sensor>:ax|ay|az'.")
    n, m = lay.size, sum(len(element.rows) for element in elements)
    forces = _stack([r.forces for r in readings], m) + _shaken(readings, lay, elements)
    return ChannelRows(
        names=tuple(names),
        units=tuple(r.units for r in readings),
        displacement=_stack([r.displacement for r in readings], n),
        velocity=_stack([r.velocity for r in readings], n),
        acceleration=_stack([r.acceleration for r in readings], n),
        forces=forces,
        rigid=np.array([r.rigid for r in readings]).reshape(-1, 3),
        vibration=np.array([r.vibration for r in readings], dtype=bool),
    )


def _shaken(readings: Sequence[Reading], lay: Layout, elements: Sequence[Element]) -> np.ndarray:
    """Part of the readings (channel, force) by the ground acceleration; coordinates are relative to the ground."""
    found = np.zeros((len(readings), sum(len(element.rows) for element in elements)))
    first = 0
    for element in elements:
        if element.ground_acceleration:
            for row, reading in zip(found, readings, strict=True):
                own = np.broadcast_to(reading.acceleration, lay.size) @ lay.translation
                row[first] = (own if reading.shift is None else reading.shift) @ element.ground_acceleration
        first += len(element.rows)
    return found


def _stack(rows: list, length: int) -> np.ndarray:
    return np.array([np.broadcast_to(row, length) for row in rows]).reshape(len(rows), length)


def _signals(lay: Layout, elements: Sequence[Element]) -> dict[str, Reading]:
    """Channels of the elements; channels of the same name are added. The force on a row is k0 u + c0 u' - lambda."""
    found: dict[str, Reading] = {}
    m, first = sum(len(element.rows) for element in elements), 0
    for element in elements:
        at = slice(first, first + len(element.rows))
        first = at.stop
        k0, c0 = element.reference("stiffness"), element.reference("damping")
        for signal in element.signals:
            motion, force = (np.array(part or (0.0,) * len(element.rows)) for part in (signal.motion, signal.force))
            reading = found.setdefault(
                signal.name,
                Reading(signal.units, displacement=np.zeros(lay.size), velocity=np.zeros(lay.size), forces=np.zeros(m)),
            )
            reading.displacement += (motion + force * k0) @ element.rows
            reading.velocity += (force * c0) @ element.rows
            reading.forces[at] -= force  # type: ignore[index]
    return found
