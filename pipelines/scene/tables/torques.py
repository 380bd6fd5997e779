"""Tables of torques, constant or over time or speed, as they may stand under `[drive]`, `[load]` or `[[forces]]`."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from mbd.forces.torque_source import Rotor, TorqueSource
from pipelines.scene.tables.derived import table
from pipelines.scene.tables.scene_table import Number, Table, Whole
from pipelines.scene.tables.series import Samples, check_pairs, pairs

RPM = 2 * math.pi / 60


_Rotor: Any = table(Rotor)


class SomewhereTable(Table):
    """A shaft and a place on it that need not be given."""

    shaft: Annotated[
        Whole | None, Field(ge=1, description="number of the shaft; without it: 1 for a drive, the last for a load")
    ] = None
    position_mm: Annotated[
        Number | None, Field(description="y on the shaft; without it: the -y end for a drive, the +y end for a load")
    ] = None


class TorqueCurve(_Rotor):
    """A torque: constant, over time, or over speed."""

    torque_N_m: Annotated[Number | None, Field(description="constant torque at every speed")] = None
    times_s: Annotated[
        Samples | None, Field(description="times of torques_N_m, ascending; linear in between, constant outside")
    ] = None
    speeds_rpm: Annotated[
        Samples | None, Field(description="speeds of the shaft for torques_N_m, ascending; instead of times_s")
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
        where : name, shaft and y (m) of the source
        sign : +1 if positive values drive, -1 if they resist
        path : of this table in the scene, for messages
        """
        from mbd.forces.torque import SpeedTorque, Torque

        where = where | {"rotor": self.made()}
        if self.torque_N_m is not None:
            return Torque(**where, times=np.zeros(1), torques=np.array([sign * self.torque_N_m]))
        key = "times_s" if self.times_s is not None else "speeds_rpm"
        places, torques = pairs(self, key, "torques_N_m", path)
        if key == "times_s":
            return Torque(**where, times=places, torques=sign * torques)
        return SpeedTorque(**where, speeds=places * RPM, torques=sign * torques)
