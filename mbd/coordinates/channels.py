"""Channels: named linear readings of the machine, value = D q + V q' + A q'' + L lambda + constant + rigid part.

Names are ``"<thing>:<quantity>"``. The functions below spell them; `channel_names` lists what a machine offers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mbd.coordinates.layout import Layout
from mbd.parts.bearings import BEARING_AXES, BearingSpec
from mbd.parts.checks import MachineError
from mbd.parts.machine import Machine

if TYPE_CHECKING:
    from mbd.forces.element import Element

DIRECTIONS = ("x", "y", "z")


def acceleration(sensor: str, axis: str) -> str:
    """Acceleration (m/s2) of a casing point along x, y or z."""
    return f"{sensor}:a{axis}"


def bearing_force(bearing: str, axis: str) -> str:
    """Force (N) of a bearing on the casing along x, y or z."""
    return f"{bearing}:f{axis}"


def journal_acceleration(bearing: str, axis: str) -> str:
    """Acceleration (m/s2) of the shaft in a bearing."""
    return f"{bearing}:journal_a{axis}"


def motor_channels(motor: str) -> tuple[str, str, str]:
    """Angle (rad), speed (rad/s) and torque on the shaft (N m, lifting positive)."""
    return f"{motor}:angle", f"{motor}:speed", f"{motor}:torque"


def shaft_channels(shaft: str) -> tuple[str, str]:
    """Angle (rad) and speed (rad/s) in the lifting sense, at the shaft's first gear (else its first node)."""
    return f"{shaft}:angle", f"{shaft}:speed"


def mesh_channels(mesh: str) -> tuple[str, str, str, str]:
    """delta (m) and psi (rad) of the drive flank, force (N) of drive and coast flank, damping included."""
    return f"{mesh}:delta", f"{mesh}:psi", f"{mesh}:drive_force", f"{mesh}:coast_force"


ROPE_FORCE = "rope:force"  # N, all falls together; of a swinging container its vertical part
CONTAINER = ("container:lift", "container:acceleration")  # m from the start, m/s2
SWAY = ("container:sway_x", "container:sway_y")  # m


def channel_names(machine: Machine, sensors: tuple[str, ...] = ()) -> tuple[str, ...]:
    """All channels of ``machine`` with the accelerations of the casing points ``sensors``."""
    names = [acceleration(s, a) for s in sensors for a in DIRECTIONS]
    names += [n for c in machine.couplings for n in motor_channels(c.name)]
    names += [n for s in machine.shafts for n in shaft_channels(s.name)]
    names += [n for m in machine.meshes for n in mesh_channels(m.name)]
    names += [bearing_force(b.name, a) for b in machine.bearings for a in DIRECTIONS]
    return (*names, *machine.load.channel_names)


def sensor_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """The casing points whose accelerations are among the channels `names`."""
    things = dict.fromkeys(name.partition(":")[0] for name in names)
    return tuple(thing for thing in things if acceleration(thing, DIRECTIONS[0]) in names)


@dataclass(eq=False)
class Reading:
    """Coefficients of one channel; rows are (coordinate,) or (force,), ``rigid`` is on (phi_m, phi_m', phi_m'')."""

    units: str
    displacement: np.ndarray | float = 0.0
    velocity: np.ndarray | float = 0.0
    acceleration: np.ndarray | float = 0.0
    forces: np.ndarray | float = 0.0
    rigid: tuple[float, float, float] = (0.0, 0.0, 0.0)


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


def channel_rows(names: tuple[str, ...], lay: Layout, elements: Sequence[Element]) -> ChannelRows:
    """Readings of ``names`` of a machine with the given elements, whose rows make the forces.

    Raises
    ------
    MachineError : an unknown channel, with the known ones
    """
    readings = []
    offered = _offered(lay, elements)
    for name in names:
        thing, _, quantity = name.partition(":")
        if name in offered:
            readings.append(offered[name])
        elif len(quantity) == 2 and quantity[0] == "a" and quantity[1] in DIRECTIONS:
            if not len(lay.casing.coordinate_names):
                raise MachineError(
                    f"channel {name!r}: a casing of model {lay.casing.model!r} does not move. Ask for bearing forces "
                    "or journal accelerations, or use another casing model."
                )
            readings.append(Reading("m/s2", acceleration=lay.casing_row(f"{thing}:u{quantity[1]}")))
        else:
            raise MachineError(f"channel {name!r} is unknown; known: {', '.join(offered)} and '<sensor>:ax|ay|az'.")
    n, m = lay.size, sum(len(element.rows) for element in elements)
    return ChannelRows(
        names=tuple(names),
        units=tuple(r.units for r in readings),
        displacement=_stack([r.displacement for r in readings], n),
        velocity=_stack([r.velocity for r in readings], n),
        acceleration=_stack([r.acceleration for r in readings], n),
        forces=_stack([r.forces for r in readings], m),
        rigid=np.array([r.rigid for r in readings]).reshape(-1, 3),
    )


def _stack(rows: list, length: int) -> np.ndarray:
    return np.array([np.broadcast_to(row, length) for row in rows]).reshape(len(rows), length)


def _offered(lay: Layout, elements: Sequence[Element]) -> dict[str, Reading]:
    machine, ratios = lay.machine, lay.machine.ratios()
    offered: dict[str, Reading] = {}
    for c in machine.couplings:
        angle, speed, torque = motor_channels(c.name)
        row = lay.angle_row(c.shaft, c.y)
        offered[angle] = Reading("rad", rigid=(ratios[c.shaft], 0.0, 0.0))
        offered[speed] = Reading("rad/s", rigid=(0.0, ratios[c.shaft], 0.0))
        offered[torque] = Reading("N m", displacement=-c.stiffness * row, velocity=-c.damping * row)
    for s in machine.shafts:
        gears = [m.y for m in machine.meshes if s.name in (m.driving, m.driven)]
        row, r = lay.angle_row(s.name, gears[0] if gears else s.y_start), ratios[s.name]
        angle, speed = shaft_channels(s.name)
        offered[angle] = Reading("rad", displacement=row, rigid=(r, 0.0, 0.0))
        offered[speed] = Reading("rad/s", velocity=row, rigid=(0.0, r, 0.0))
    for b in machine.bearings:
        for axis in DIRECTIONS:
            if b.inside is None:
                offered[bearing_force(b.name, axis)] = _linear_bearing(lay, b, axis)
            row = lay.axis_row(b.shaft, b.y, DIRECTIONS.index(axis))
            offered[journal_acceleration(b.name, axis)] = Reading("m/s2", acceleration=row)
    return offered | _signals(lay, elements) | machine.load.readings(lay)


def _signals(lay: Layout, elements: Sequence[Element]) -> dict[str, Reading]:
    """Channels that the elements offer, those of one name added up; F = k0 u + c0 u' - lambda on every row."""
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


def _linear_bearing(lay: Layout, bearing: BearingSpec, axis: str) -> Reading:
    at = BEARING_AXES.index(f"u{axis}")
    motion = np.array([bearing_row(lay, bearing, a) for a in BEARING_AXES])
    stiffness, damping = bearing.stiffness_matrix[at], bearing.damping_matrix[at]
    return Reading("N", displacement=stiffness @ motion, velocity=damping @ motion)


def bearing_row(lay: Layout, bearing: BearingSpec, axis: str) -> np.ndarray:
    """Displacement of the shaft relative to the support in a bearing, axis ux uy uz rx rz.

    A casing may leave out the motion that no bearing holds: there the shaft moves against the ground.
    """
    shaft = lay.axis_row(bearing.shaft, bearing.y, ("ux", "uy", "uz", "rx", "ry", "rz").index(axis))
    name = f"{bearing.name}:{axis}"
    free = bearing.stiffness[BEARING_AXES.index(axis)] == 0.0 and name not in lay.casing.row_names
    return shaft if bearing.support == "ground" or free else shaft - lay.casing_row(name)
