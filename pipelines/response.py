"""Response: the signals of a run as a labelled dataset - what response.nc holds and what `run` returns.

The dataset is a view: a signal is read from the motion, and rounded as response.nc stores it, when it is looked at. So
what is found in the motion is found in the file, to the last digit.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from fem.stored_array import StoredArray
from mbd import channels
from mbd.trajectory import Trajectory
from pipelines.scene import Scene

AXES = list(channels.DIRECTIONS)
ROUNDED = ("m/s2", "N", "N m")
ROUNDING = "float32, rounded by at most 2^-24 (6e-8) of each value; the motion in the cache is float64"


def stored_type(units: str) -> np.dtype:
    """How a signal is stored: accelerations, forces and torques as float32, all else as float64.

    A float32 is rounded by at most 2^-24 (6e-8) of its own value. So the error is less than 1e-7 of the signal's rms,
    and up to peaks of 160 m/s2 a thousand times smaller than a sensor noise of 0.01 m/s2. Angles, speeds and positions
    are differenced and differentiated: there a small vibration rides on a large value.
    """
    return np.dtype(np.float32 if units in ROUNDED else np.float64)


def labels(scene: Scene) -> dict[str, Any]:
    """What is known of a run without its motion: the attributes that say what was run."""
    deviations = scene.deviations
    return {
        "title": scene.title,
        "state": "+".join(sorted({fault.kind for fault in scene.faults})) or "healthy",
        "load": scene.load.model,
        "faults": json.dumps([fault.model_dump() for fault in scene.faults]),
        "seed": deviations.seed if deviations.enabled else "none",
        "iso_grade": deviations.iso_grade if deviations.enabled else "none",
        "sensor_noise_m_s2": scene.diagnosis.noise_m_s2,
        "teeth": json.dumps([[stage.pinion_teeth, stage.wheel_teeth] for stage in scene.stages]),
    }


def make_response(trajectory: Trajectory, labelled: Mapping[str, Any]) -> xarray.Dataset:
    """The dataset: named dimensions, units on every variable, `labels` and facts of the motion as attributes."""
    motors, shafts, meshes = trajectory.motors, trajectory.shafts, trajectory.meshes
    bearings, sensors = trajectory.bearings, trajectory.sensors
    number = {name: row for row, name in enumerate(trajectory.channel_names)}

    def variable(dims: tuple[str, ...], named: Any, text: str) -> xarray.Variable:
        rows = np.vectorize(number.__getitem__, otypes=[int])(np.array(named))
        units = trajectory.channel_units[rows.flat[0]]
        dtype = stored_type(units)
        signals = indexing.LazilyIndexedArray(_Signals(trajectory.values, rows, dtype))
        facts = {"units": units, "long_name": text} | ({"storage": ROUNDING} if dtype == np.float32 else {})
        return xarray.Variable(("time", *dims), signals, facts)

    def points(named: tuple[str, ...], spell: Callable[[str, str], str]) -> list[list[str]]:
        return [[spell(name, axis) for axis in AXES] for name in named]

    motor = list(zip(*map(channels.motor_channels, motors), strict=True))
    shaft = list(zip(*map(channels.shaft_channels, shafts), strict=True))
    mesh = list(zip(*map(channels.mesh_channels, meshes), strict=True))
    force = points(bearings, channels.bearing_force)
    journal = points(bearings, channels.journal_acceleration)
    data = {
        "motor_angle": variable(("motor",), motor[0], "angle of the motor, lifting positive"),
        "motor_speed": variable(("motor",), motor[1], "speed of the motor"),
        "motor_torque": variable(("motor",), motor[2], "torque of the motor on the shaft"),
        "shaft_angle": variable(("shaft",), shaft[0], "angle of the shaft"),
        "shaft_speed": variable(("shaft",), shaft[1], "speed of the shaft"),
        "mesh_approach": variable(("stage",), mesh[0], "approach on the drive flank"),
        "mesh_tilt": variable(("stage",), mesh[1], "tilt in the plane of action"),
        "mesh_force": variable(("stage",), mesh[2], "force on the drive flank"),
        "coast_force": variable(("stage",), mesh[3], "force on the coast flank"),
        "bearing_force": variable(("bearing", "axis"), force, "force of the bearing on the casing"),
    }
    if sensors:
        rows = points(sensors, channels.acceleration)
        data["acceleration"] = variable(("sensor", "axis"), rows, "acceleration of the casing")
    if journal[0][0] in number:
        data["journal_acceleration"] = variable(("bearing", "axis"), journal, "acceleration of the journal")
    if channels.ROPE_FORCE in number:
        lift, acceleration = channels.CONTAINER
        data["rope_force"] = variable((), channels.ROPE_FORCE, "force of all falls together")
        data["container_lift"] = variable((), lift, "rise of the container")
        data["container_acceleration"] = variable((), acceleration, "acceleration of the container")
    coords: dict = {"time": ("time", trajectory.time, {"units": "s"})}
    coords |= {"motor": list(motors), "shaft": list(shafts), "stage": list(range(1, len(meshes) + 1))}
    coords |= {"bearing": list(bearings), "axis": AXES} | ({"sensor": list(sensors)} if sensors else {})
    return xarray.Dataset(data, coords=coords, attrs={**labelled, **_facts(trajectory)})


def _facts(trajectory: Trajectory) -> dict[str, Any]:
    books = {
        part: dict(zip(trajectory.book_columns, map(float, row), strict=True))
        for part, row in zip(trajectory.book_parts, trajectory.books, strict=True)
    }
    return {
        "integrator": trajectory.integrator,
        "step_s": trajectory.step,
        "step_error": trajectory.step_error,
        "pass_band_Hz": trajectory.pass_band,
        "counters": json.dumps(dict(zip(trajectory.counter_names, map(int, trajectory.counters), strict=True))),
        "energy_books_J": json.dumps(books),
        "open_energy_books": json.dumps(trajectory.open_books()),
    }


class _Signals(BackendArray):
    """Rows of a table (channel, time) as an array (time, ...), read when it is looked at."""

    def __init__(self, values: np.ndarray | StoredArray, rows: np.ndarray, dtype: np.dtype) -> None:
        self._values, self._rows = values, rows
        self.shape, self.dtype = (values.shape[1], *rows.shape), dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[int | slice, ...]) -> np.ndarray:
        time, *place = key
        rows = self._rows[tuple(place)]
        instants = (len(range(self.shape[0])[time]),) if isinstance(time, slice) else ()
        out = np.empty((*instants, rows.size), self.dtype)
        for column, row in enumerate(np.ravel(rows)):
            out[..., column] = self._values[row, time]
        return out.reshape(*instants, *np.shape(rows))
