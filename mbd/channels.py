"""Channels: named linear readings of the machine, value = D q + V q' + A q'' + L lambda + constant + rigid part.

Names are ``"<thing>:<quantity>"``. The functions below spell them; `channel_names` lists what a machine offers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.bearings import BEARING_AXES, BearingSpec
from mbd.checks import MachineError
from mbd.layout import Layout
from mbd.load import Rope, RopePendulum
from mbd.machine import Machine

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


def channel_names(machine: Machine, sensors: tuple[str, ...] = ()) -> tuple[str, ...]:
    """All channels of ``machine`` with the accelerations of the casing points ``sensors``."""
    names = [acceleration(s, a) for s in sensors for a in DIRECTIONS]
    names += [n for c in machine.couplings for n in motor_channels(c.name)]
    names += [n for s in machine.shafts for n in shaft_channels(s.name)]
    names += [n for m in machine.meshes for n in mesh_channels(m.name)]
    names += [bearing_force(b.name, a) for b in machine.bearings for a in DIRECTIONS]
    names += [ROPE_FORCE, *CONTAINER] if isinstance(machine.load, Rope) else []
    names += [*SWAY] if isinstance(machine.load, RopePendulum) else []
    return tuple(names)


def sensor_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """The casing points whose accelerations are among the channels `names`."""
    things = dict.fromkeys(name.partition(":")[0] for name in names)
    return tuple(thing for thing in things if acceleration(thing, DIRECTIONS[0]) in names)


SWAY = ("container:sway_x", "container:sway_y")  # m


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


def channel_rows(
    names: tuple[str, ...],
    lay: Layout,
    rows: np.ndarray,
    row_names: tuple[str, ...],
    reference: dict[str, tuple[float, float]],
) -> ChannelRows:
    """Readings of ``names``; ``rows`` are the force rows of the system, ``reference`` (k0, c0) by element name.

    Raises
    ------
    MachineError : an unknown channel, with the known ones
    """
    readings = []
    offered = _offered(lay, rows, row_names, reference)
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
    n, m = lay.size, len(rows)
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


def _offered(
    lay: Layout, rows: np.ndarray, row_names: tuple[str, ...], reference: dict[str, tuple[float, float]]
) -> dict[str, Reading]:
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
    for i, m in enumerate(machine.meshes):
        delta, psi, drive, coast = mesh_channels(m.name)
        offered[delta] = Reading("m", displacement=rows[4 * i])
        offered[psi] = Reading("rad", displacement=rows[4 * i + 1])
        offered[drive] = _element_force(rows, 4 * i, reference[m.name])
        offered[coast] = _element_force(rows, 4 * i + 2, (0.0, 0.0))
    for b in machine.bearings:
        for axis in DIRECTIONS:
            offered[bearing_force(b.name, axis)] = _bearing(lay, b, axis, rows, row_names)
            row = lay.axis_row(b.shaft, b.y, DIRECTIONS.index(axis))
            offered[journal_acceleration(b.name, axis)] = Reading("m/s2", acceleration=row)
    if isinstance(machine.load, Rope):
        stretched = [r for r, name in enumerate(row_names) if name.startswith("rope:") and name.endswith(":stretch")]
        rise = float(lay.rolling()[-1])
        lift = np.eye(lay.size)[-1]
        offered[ROPE_FORCE] = _rope(rows, stretched, reference["rope"])
        offered[CONTAINER[0]] = Reading("m", displacement=lift, rigid=(rise, 0.0, 0.0))
        offered[CONTAINER[1]] = Reading("m/s2", acceleration=lift, rigid=(0.0, 0.0, rise))
    if isinstance(machine.load, RopePendulum):
        for k, name in enumerate(SWAY):
            offered[name] = Reading("m", displacement=np.eye(lay.size)[k - 3])
    return offered


def _element_force(rows: np.ndarray, r: int, reference: tuple[float, float]) -> Reading:
    """F_t = k0 u + c0 u' - lambda."""
    return Reading(
        "N", displacement=reference[0] * rows[r], velocity=reference[1] * rows[r], forces=-np.eye(len(rows))[r]
    )


def _rope(rows: np.ndarray, stretched: list[int], reference: tuple[float, float]) -> Reading:
    stretch = rows[stretched].sum(axis=0)
    share = np.zeros(len(rows))
    share[stretched] = -1.0
    return Reading("N", displacement=reference[0] * stretch, velocity=reference[1] * stretch, forces=share)


def _bearing(lay: Layout, bearing: BearingSpec, axis: str, rows: np.ndarray, row_names: tuple[str, ...]) -> Reading:
    if bearing.model == "hertz":
        r, k = row_names.index(f"{bearing.name}:u{axis}"), bearing.stiffness[BEARING_AXES.index(f"u{axis}")]
        return _element_force(rows, r, (k, bearing.damping_time * k))
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
