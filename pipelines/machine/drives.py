"""The drive of a scene, in SI: motors of prescribed speed, or motors that give a torque."""

from __future__ import annotations

import numpy as np

from mbd.forces.torque_source import TorqueSource
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from pipelines.io.errors import Problem, SceneError
from pipelines.scene.tables.drive_and_load import DriveModel, SpeedDrive, TorqueDrive
from pipelines.scene.tables.series import ColumnTable, pairs
from pipelines.scene.tables.shafts import ShaftTable
from pipelines.scene.tables.torques import RPM


def motor_places(drive: DriveModel, shaft: ShaftTable) -> tuple[float, ...]:
    """y of the motors (m) on their shaft."""
    if not isinstance(drive, SpeedDrive) and drive.position_mm is not None:
        return (drive.si.position,)
    return shaft.ends[: drive.motors]


def speed_profile(drive: DriveModel) -> SpeedProfile:
    """Speed of the motors over time; for motors that give a torque, only the speed at t = 0.

    Raises
    ------
    SceneError : a file that cannot be used
    """
    if isinstance(drive, SpeedDrive):
        times, speeds = pairs(drive, "times_s", "speeds_rpm", "drive")
        if times[0] > 0.0:
            raise SceneError(
                "scene",
                [Problem("drive.times_s", f"starts at {times[0]:g} s, and must start at 0", "Correct the file")],
            )
        return SpeedProfile(times=times, speeds=speeds * RPM, smooth=isinstance(drive.speeds_rpm, ColumnTable))
    return SpeedProfile(times=np.zeros(1), speeds=np.array([starting_rpm(drive) * RPM]))


def starting_rpm(drive: DriveModel) -> float:
    """Speed of the driven shaft at t = 0 in rpm."""
    if drive.model == "controlled-motor":
        times, speeds = pairs(drive, "times_s", "speeds_rpm", "drive")
        return float(np.interp(0.0, times, speeds))
    if drive.model == "induction-motor" and drive.start_rpm is None:
        return float(drive.rated_rpm)
    return float(drive.start_rpm or 0.0)


def highest_rpm(drive: DriveModel) -> float:
    """Highest speed (rpm) for which frequencies and strength are stated."""
    if isinstance(drive, TorqueDrive):
        return drive.highest_rpm or abs(drive.start_rpm)
    if drive.model == "induction-motor":
        return float(drive.rated_rpm)
    return float(abs(pairs(drive, "times_s", "speeds_rpm", "drive")[1]).max())


def motor_couplings(drive: DriveModel, shaft: int, places: tuple[float, ...]) -> tuple[MotorCoupling, ...]:
    """Couplings to motors of prescribed speed; none for motors that give a torque.

    Parameters
    ----------
    drive : the drive
    shaft : number of the driven shaft, from 0
    places : y of the motors (m)
    """
    if not isinstance(drive, SpeedDrive):
        return ()
    return tuple(
        MotorCoupling(
            name=f"motor_{number}",
            shaft=f"shaft_{shaft + 1}",
            y=y,
            stiffness=drive.coupling_stiffness_N_m_per_rad,
            damping=drive.coupling_damping_N_m_s_per_rad,
        )
        for number, y in enumerate(places, 1)
    )


def motor_torques(drive: DriveModel, shaft: int, places: tuple[float, ...]) -> tuple[TorqueSource, ...]:
    """Motors that give a torque; none where the speed is prescribed. Arguments as for `motor_couplings`."""
    found = []
    for number, y in enumerate(places, 1):
        if isinstance(drive, SpeedDrive):
            continue
        where = {"name": f"motor_{number}", "shaft": f"shaft_{shaft + 1}", "y": y, "drives": True}
        if isinstance(drive, TorqueDrive):
            found.append(drive.curve(where, 1.0, "drive"))
        else:
            found.append(drive.made("drive", **where))
    return tuple(found)
