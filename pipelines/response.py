"""Response: the signals of a run as a labelled dataset - what response.nc holds and what `run` returns."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import xarray

from mbd import channels
from mbd.machine import Machine
from mbd.trajectory import Trajectory
from pipelines.scene import Scene

AXES = list(channels.DIRECTIONS)


def fault_state(scene: Scene) -> str:
    """ "healthy", or the kinds of the faults."""
    return "+".join(sorted({fault.kind for fault in scene.faults})) or "healthy"


def make_response(scene: Scene, machine: Machine, trajectory: Trajectory) -> xarray.Dataset:
    """The dataset: named dimensions, units on every variable, labels as attributes."""

    def by(*parts: str) -> np.ndarray:
        return np.array([trajectory.channel(name) for name in parts]).T

    def variable(dims: tuple[str, ...], values: np.ndarray, units: str, text: str) -> tuple:
        return ("time", *dims), values, {"units": units, "long_name": text}

    def points(named: list[str], spell: Callable[[str, str], str]) -> np.ndarray:
        return np.stack([by(*(spell(name, axis) for axis in AXES)) for name in named], axis=1)

    motors = [coupling.name for coupling in machine.couplings]
    shafts = [shaft.name for shaft in machine.shafts]
    meshes = [mesh.name for mesh in machine.meshes]
    bearings = [bearing.name for bearing in machine.bearings]
    sensors = [sensor.name for sensor in scene.sensors]
    motor = [channels.motor_channels(name) for name in motors]
    shaft = [channels.shaft_channels(name) for name in shafts]
    mesh = [channels.mesh_channels(name) for name in meshes]
    data = {
        "motor_angle": variable(("motor",), by(*(m[0] for m in motor)), "rad", "angle of the motor, lifting positive"),
        "motor_speed": variable(("motor",), by(*(m[1] for m in motor)), "rad/s", "speed of the motor"),
        "motor_torque": variable(("motor",), by(*(m[2] for m in motor)), "N m", "torque of the motor on the shaft"),
        "shaft_angle": variable(("shaft",), by(*(s[0] for s in shaft)), "rad", "angle of the shaft"),
        "shaft_speed": variable(("shaft",), by(*(s[1] for s in shaft)), "rad/s", "speed of the shaft"),
        "mesh_approach": variable(("stage",), by(*(m[0] for m in mesh)), "m", "approach on the drive flank"),
        "mesh_tilt": variable(("stage",), by(*(m[1] for m in mesh)), "rad", "tilt in the plane of action"),
        "mesh_force": variable(("stage",), by(*(m[2] for m in mesh)), "N", "force on the drive flank"),
        "coast_force": variable(("stage",), by(*(m[3] for m in mesh)), "N", "force on the coast flank"),
        "bearing_force": variable(
            ("bearing", "axis"), points(bearings, channels.bearing_force), "N", "force of the bearing on the casing"
        ),
    }
    if sensors:
        data["acceleration"] = variable(
            ("sensor", "axis"), points(sensors, channels.acceleration), "m/s2", "acceleration of the casing"
        )
    if scene.casing.model == "none":
        data["journal_acceleration"] = variable(
            ("bearing", "axis"), points(bearings, channels.journal_acceleration), "m/s2", "acceleration of the journal"
        )
    if channels.ROPE_FORCE in trajectory.channel_names:
        data["rope_force"] = variable((), trajectory.channel(channels.ROPE_FORCE), "N", "force of all falls together")
        data["container_lift"] = variable((), trajectory.channel(channels.CONTAINER[0]), "m", "rise of the container")
        data["container_acceleration"] = variable(
            (), trajectory.channel(channels.CONTAINER[1]), "m/s2", "acceleration of the container"
        )
    coords: dict = {"time": ("time", trajectory.time, {"units": "s"})}
    coords |= {"motor": motors, "shaft": shafts, "stage": list(range(1, len(meshes) + 1)), "bearing": bearings}
    coords |= {"axis": AXES} | ({"sensor": sensors} if sensors else {})
    deviations = scene.deviations
    books = {
        part: dict(zip(trajectory.book_columns, map(float, row), strict=True))
        for part, row in zip(trajectory.book_parts, trajectory.books, strict=True)
    }
    return xarray.Dataset(
        data,
        coords=coords,
        attrs={
            "title": scene.title,
            "state": fault_state(scene),
            "load": scene.load.model,
            "faults": json.dumps([fault.model_dump() for fault in scene.faults]),
            "seed": deviations.seed if deviations.enabled else "none",
            "iso_grade": deviations.iso_grade if deviations.enabled else "none",
            "sensor_noise_m_s2": scene.diagnosis.noise_m_s2,
            "teeth": json.dumps([[stage.pinion_teeth, stage.wheel_teeth] for stage in scene.stages]),
            "integrator": trajectory.integrator,
            "step_s": trajectory.step,
            "step_error": trajectory.step_error,
            "pass_band_Hz": trajectory.pass_band,
            "counters": json.dumps(dict(zip(trajectory.counter_names, map(int, trajectory.counters), strict=True))),
            "energy_books_J": json.dumps(books),
            "open_energy_books": json.dumps(trajectory.open_books()),
        },
    )
