"""Tables of torques from outside: drives that give a torque, brakes and fans that take one.

A kind is a table here with its `spec`, and a class in `mbd.forces`; it may stand under `[drive]`, `[load]` or
`[[forces]]` as those list it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from pipelines.scene.tables.base import Flag, Number, Table, Whole
from pipelines.scene.tables.samples import Samples, check_pairs

if TYPE_CHECKING:
    from mbd.forces.torque_source import TorqueSource

RPM = 2 * math.pi / 60


class SourceTable(Table):
    """The rotor that a torque acts on."""

    inertia_kg_m2: Annotated[Number, Field(ge=0, description="moment of inertia of the rotor; 0: none")] = 0.0
    coupling_stiffness_N_m_per_rad: Annotated[
        Number | None,
        Field(
            gt=0,
            description="torsional stiffness of the coupling between rotor and shaft; without it: the rotor is "
            "fixed to the shaft. Without inertia a coupling has no effect",
        ),
    ] = None
    coupling_damping_N_m_s_per_rad: Annotated[Number, Field(ge=0, description="torsional damping of that coupling")] = (
        0.0
    )

    def at(self, name: str, shaft: int, y: float) -> dict[str, Any]:
        """Arguments of a `TorqueSource`: its name, its shaft (from 0), its place y (m), and the rotor."""
        from mbd.forces.torque_source import Rotor

        rotor = None
        if self.inertia_kg_m2 > 0.0:
            rotor = Rotor(
                inertia=self.inertia_kg_m2,
                stiffness=self.coupling_stiffness_N_m_per_rad,
                damping=self.coupling_damping_N_m_s_per_rad,
            )
        return {"name": name, "shaft": f"shaft_{shaft + 1}", "y": y, "rotor": rotor}


class SomewhereTable(Table):
    """A shaft and a place on it that need not be given."""

    shaft: Annotated[
        Whole | None, Field(ge=1, description="number of the shaft; without it: 1 for a drive, the last for a load")
    ] = None
    position_mm: Annotated[
        Number | None, Field(description="y on the shaft; without it: the -y end for a drive, the +y end for a load")
    ] = None


class TorqueCurve(SourceTable):
    """A torque: constant, over time, or over speed."""

    torque_N_m: Annotated[Number | None, Field(description="constant torque at every speed")] = None
    times_s: Annotated[
        Samples | None, Field(description="times of torques_N_m, rising; linear in between, constant outside")
    ] = None
    speeds_rpm: Annotated[
        Samples | None, Field(description="speeds of the shaft for torques_N_m, rising; instead of times_s")
    ] = None
    torques_N_m: Annotated[Samples | None, Field(description="torque at these times or speeds")] = None

    @model_validator(mode="after")
    def _one_curve(self) -> TorqueCurve:
        places = [name for name in ("times_s", "speeds_rpm") if getattr(self, name) is not None]
        if self.torque_N_m is not None and (places or self.torques_N_m is not None):
            raise ValueError(
                "torque_N_m is constant, and torques_N_m varies over times_s or speeds_rpm. Delete one or the other"
            )
        if self.torque_N_m is None and (len(places) != 1 or self.torques_N_m is None):
            raise ValueError("has no torque. Set torque_N_m, or torques_N_m with either times_s or speeds_rpm")
        if places:
            check_pairs(self, places[0], "torques_N_m")
        return self

    def curve(self, where: dict[str, Any], sign: float, path: str) -> TorqueSource:
        """The torque in SI.

        Parameters
        ----------
        where : from `at`
        sign : +1 if positive values drive, -1 if they resist
        path : of this table in the scene, for messages
        """
        import numpy as np

        from mbd.forces.torque import SpeedTorque, Torque
        from pipelines.scene.tables.samples import pairs

        if self.torque_N_m is not None:
            return Torque(**where, times=np.zeros(1), torques=np.array([sign * self.torque_N_m]))
        key = "times_s" if self.times_s is not None else "speeds_rpm"
        places, torques = pairs(self, key, "torques_N_m", path)
        if key == "times_s":
            return Torque(**where, times=places, torques=sign * torques)
        return SpeedTorque(**where, speeds=places * RPM, torques=sign * torques)


class InductionTable(SourceTable):
    """An induction motor on the mains, by its rating and the formula of Kloss."""

    model: Literal["induction-motor"] = "induction-motor"
    synchronous_rpm: Annotated[
        Number, Field(gt=0, description="synchronous speed: 60 times mains frequency over pole pairs")
    ]
    rated_rpm: Annotated[Number, Field(gt=0, description="speed at the rated torque")]
    rated_torque_N_m: Annotated[Number, Field(gt=0, description="torque at the rated speed")]
    breakdown_ratio: Annotated[Number, Field(gt=1, le=10, description="breakdown torque over rated torque")] = 2.5

    @model_validator(mode="after")
    def _slips(self) -> InductionTable:
        if self.rated_rpm >= self.synchronous_rpm:
            raise ValueError(
                f"rated_rpm = {self.rated_rpm:g} must be below synchronous_rpm = {self.synchronous_rpm:g}, because the "
                "torque grows with the slip. Correct them"
            )
        return self

    def motor(self, where: dict[str, Any]) -> TorqueSource:
        """The motor in SI; `where` is from `at`."""
        from mbd.forces.induction_motor import InductionMotor, breakdown_slip

        slip = breakdown_slip(1.0 - self.rated_rpm / self.synchronous_rpm, self.breakdown_ratio)
        return InductionMotor(
            **where,
            synchronous_speed=self.si.synchronous,
            breakdown_torque=self.breakdown_ratio * self.rated_torque_N_m,
            breakdown_slip=slip,
        )


class ControlledTable(SourceTable):
    """A motor under PI speed control."""

    model: Literal["controlled-motor"] = "controlled-motor"
    times_s: Annotated[Samples, Field(description="times, rising, starting at 0")]
    speeds_rpm: Annotated[Samples, Field(description="target speed at these times")]
    proportional_N_m_s_per_rad: Annotated[Number, Field(gt=0, description="proportional gain: torque per speed error")]
    integral_N_m_per_rad: Annotated[Number, Field(ge=0, description="integral gain: torque per angle error")] = 0.0
    limit_N_m: Annotated[Number, Field(gt=0, description="largest torque in both directions")]
    starting_torque_N_m: Annotated[Number, Field(description="torque of the integral part at t = 0")] = 0.0
    anti_windup: Annotated[
        Flag, Field(description="true: back-calculation reduces the integral part while the torque is limited")
    ] = True

    @model_validator(mode="after")
    def _pairs(self) -> ControlledTable:
        check_pairs(self, "times_s", "speeds_rpm")
        return self

    def motor(self, where: dict[str, Any], path: str) -> TorqueSource:
        """The motor in SI; `where` is from `at`, `path` that of this table in the scene."""
        from mbd.forces.speed_controller import SpeedController
        from mbd.parts.drive import SpeedProfile
        from pipelines.scene.tables.samples import pairs

        times, speeds = pairs(self, "times_s", "speeds_rpm", path)
        return SpeedController(
            **where,
            reference=SpeedProfile(times=times, speeds=speeds * RPM),
            proportional=self.proportional_N_m_s_per_rad,
            integral=self.integral_N_m_per_rad,
            limit=self.limit_N_m,
            starting_torque=self.starting_torque_N_m,
            anti_windup=self.anti_windup,
        )
