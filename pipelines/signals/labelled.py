"""Signals: the channels of a motion under the names and dimensions that users see, and how each one is stored."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbd.output.trajectory import Trajectory
from mbd.parts import channels
from pipelines.signals.motion_warnings import ATTRIBUTE, motion_warnings

AXES = list(channels.DIRECTIONS)
EXCITATIONS = (  # dimension, quantity, text
    ("force", channels.OUTSIDE_FORCE, "force from outside"),
    ("base", channels.GROUND_ACCELERATION, "acceleration of the ground"),
)
ROUNDED = ("m/s2", "N", "N m")
ROUNDING = "float32, rounded by at most 2^-24 (6e-8) of each value; the motion in the cache is float64"


@dataclass(frozen=True, eq=False, kw_only=True)
class Signal:
    """One variable of a response: `rows` are numbers of channels, in the shape of `dims` (time comes before them)."""

    name: str
    dims: tuple[str, ...]
    rows: np.ndarray
    units: str
    text: str

    @property
    def dtype(self) -> np.dtype:
        """How it is stored."""
        return stored_type(self.units)

    @property
    def attributes(self) -> dict[str, str]:
        """Units, words, and the rounding where there is one."""
        rounding = {"storage": ROUNDING} if self.units in ROUNDED else {}
        return {"units": self.units, "long_name": self.text, **rounding}


def stored_type(units: str) -> np.dtype:
    """How a signal is stored: accelerations, forces and torques as float32, all else as float64.

    A float32 is rounded by at most 2^-24 (6e-8) of its own value. So the error is less than 1e-7 of the signal's rms,
    and up to peaks of 160 m/s2 a thousand times smaller than a sensor noise of 0.01 m/s2. Angles, speeds and positions
    are differenced and differentiated: there a small vibration rides on a large value.
    """
    return np.dtype("<f4" if units in ROUNDED else "<f8")


def signals(motion: Trajectory) -> Iterator[Signal]:
    """All signals of a motion."""
    number = {name: row for row, name in enumerate(motion.channel_names)}

    def signal(name: str, dims: tuple[str, ...], named: Any, text: str) -> Signal:
        rows = np.vectorize(number.__getitem__, otypes=[int])(np.array(named))
        return Signal(name=name, dims=dims, rows=rows, units=motion.channel_units[rows.flat[0]], text=text)

    def points(named: tuple[str, ...], spell: Callable[[str, str], str]) -> list[list[str]]:
        return [[spell(name, axis) for axis in AXES] for name in named]

    motor, source = (
        list(zip(*map(channels.motor_channels, names), strict=True)) for names in (motion.motors, motion.sources)
    )
    shaft = list(zip(*map(channels.shaft_channels, motion.shafts), strict=True))
    mesh = list(zip(*map(channels.mesh_channels, motion.meshes), strict=True))
    force = points(motion.bearings, channels.bearing_force)
    journal = points(motion.bearings, channels.journal_acceleration)
    yield signal("motor_angle", ("motor",), motor[0], "angle of the motor, positive as the first one turns it")
    yield signal("motor_speed", ("motor",), motor[1], "speed of the motor")
    yield signal("motor_torque", ("motor",), motor[2], "torque of the motor on the shaft")
    if source:
        yield signal("source_angle", ("source",), source[0], "angle of the load or further motor")
        yield signal("source_speed", ("source",), source[1], "speed of the load or further motor")
        yield signal("source_torque", ("source",), source[2], "its torque, driving positive")
    couplings = [name for name in number if name.endswith(channels.COUPLING_TORQUE)]
    if couplings:
        yield signal("coupling_torque", ("coupling",), couplings, "torque from the rotor through its coupling")
    first = channels.DISPLACEMENT + AXES[0]
    probes = [name.removesuffix(first) for name in number if name.endswith(first)]
    if probes:
        rows = points(tuple(probes), channels.probe_channel)
        yield signal("probe_displacement", ("probe", "axis"), rows, "displacement of the shaft's axis at the probe")
    yield signal("shaft_angle", ("shaft",), shaft[0], "angle of the shaft")
    yield signal("shaft_speed", ("shaft",), shaft[1], "speed of the shaft")
    yield signal("mesh_approach", ("stage",), mesh[0], "approach on the drive flank")
    yield signal("mesh_tilt", ("stage",), mesh[1], "tilt in the plane of action")
    yield signal("mesh_force", ("stage",), mesh[2], "force on the drive flank")
    yield signal("coast_force", ("stage",), mesh[3], "force on the coast flank")
    yield signal("bearing_force", ("bearing", "axis"), force, "force of the bearing on the casing")
    if motion.sensors:
        rows = points(motion.sensors, channels.acceleration)
        yield signal("acceleration", ("sensor", "axis"), rows, "acceleration of the casing")
    if journal[0][0] in number:
        yield signal("journal_acceleration", ("bearing", "axis"), journal, "acceleration of the journal")
    for dimension, quantity, text in EXCITATIONS:
        if things := channels.excitations(motion.channel_names, quantity):
            yield signal(quantity, (dimension,), [f"{thing}:{quantity}" for thing in things], text)
    if channels.ROPE_FORCE in number:
        lift, acceleration = channels.CONTAINER
        yield signal("rope_force", (), channels.ROPE_FORCE, "force of all falls together")
        yield signal("container_lift", (), lift, "rise of the container")
        yield signal("container_acceleration", (), acceleration, "acceleration of the container")


def read(motion: Trajectory, signal: Signal, time: int | slice, place: tuple[int | slice, ...] = ()) -> np.ndarray:
    """A part of a signal (time, ...) as it is stored; only its channels and instants are read.

    Parameters
    ----------
    motion, signal : the motion, and one of its signals
    time : instants, from 0
    place : number or slice along each dimension of the signal but time; the last ones may be left out
    """
    rows = signal.rows[place]
    values = np.asarray(motion.values[np.ravel(rows), time]).T.astype(signal.dtype)
    return values.reshape(values.shape[:-1] + np.shape(rows))


def coordinates(motion: Trajectory) -> dict[str, list]:
    """The names along all dimensions but time."""
    couplings = [name.partition(":")[0] for name in motion.channel_names if name.endswith(channels.COUPLING_TORQUE)]
    named: dict[str, Any] = {"motor": motion.motors, "source": motion.sources, "coupling": couplings}
    first = channels.DISPLACEMENT + AXES[0]
    named |= {"probe": [name.removesuffix(first) for name in motion.channel_names if name.endswith(first)]}
    named |= {"shaft": motion.shafts, "stage": range(1, len(motion.meshes) + 1)}
    named |= {"bearing": motion.bearings, "axis": AXES}
    named |= {dimension: channels.excitations(motion.channel_names, quantity) for dimension, quantity, _ in EXCITATIONS}
    return {name: list(values) for name, values in (named | {"sensor": motion.sensors}).items() if len(values)}


def facts(motion: Trajectory) -> dict[str, Any]:
    """What the motion says of itself, as attributes."""
    balance = {
        part: dict(zip(motion.energy_entries, map(float, row), strict=True))
        for part, row in zip(motion.energy_parts, motion.energies, strict=True)
    }
    return {
        "integrator": motion.integrator,
        "step_s": motion.step,
        "step_error": motion.step_error,
        "repeatable_until_s": motion.parted_at or "the end",
        "pass_band_Hz": motion.pass_band,
        "counters": json.dumps(dict(zip(motion.counter_names, map(int, motion.counters), strict=True))),
        "energy_balance_J": json.dumps(balance),
        ATTRIBUTE: json.dumps(motion_warnings(motion)),
    }
