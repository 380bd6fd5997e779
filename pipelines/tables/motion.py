"""Tables of what moves the machine: drive, load, and the time integration."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipelines.tables.base import Number, Table, Whole


class DriveTable(Table):
    """Speed-driven motors at both ends of shaft 1, each through a coupling that only holds the rotation."""

    times_s: Annotated[tuple[Number, ...], Field(min_length=2, description="strictly rising, starting at 0")]
    speeds_rpm: Annotated[tuple[Number, ...], Field(min_length=2, description="motor speed at these times")]
    motors: Annotated[Literal[1, 2], Field(description="2: one at each end; 1: at the -y end")] = 2
    coupling_stiffness_N_m_per_rad: Annotated[Number, Field(gt=0, description="of each coupling")] = 2000.0
    coupling_damping_N_m_s_per_rad: Annotated[Number, Field(ge=0, description="of each coupling")] = 0.5

    @model_validator(mode="after")
    def _table(self) -> DriveTable:
        if len(self.times_s) != len(self.speeds_rpm):
            raise ValueError(f"times_s has {len(self.times_s)} values, speeds_rpm has {len(self.speeds_rpm)}")
        if self.times_s[0] != 0:
            raise ValueError(f"times_s must start at 0, it starts at {self.times_s[0]}")
        for before, after in zip(self.times_s, self.times_s[1:], strict=False):
            if after <= before:
                raise ValueError(f"times_s must rise strictly: {after} s follows {before} s")
        return self


class LoadBase(Table):
    """What every load has: a weight on two drums."""

    container_kg: Annotated[Number, Field(ge=0, description="hanging mass")]
    drum_radius_mm: Annotated[Number, Field(gt=0, description="to the middle of the rope")]
    drum_mass_kg: Annotated[Number, Field(gt=0, description="of each drum, overhung at the ends of the last shaft")]
    drum_inertia_kg_m2: Annotated[Number, Field(gt=0, description="of each drum about the shaft")]
    reeving_ratio: Annotated[Number, Field(gt=0, description="rope speed at the drum over container speed")] = 2.0


class StaticTorqueTable(LoadBase):
    """The weight as a constant torque on the drums."""

    model: Literal["static-torque"] = "static-torque"


class RopeTable(LoadBase):
    """Container on elastic rope: stiffness of the current length, tension only."""

    model: Literal["rope"] = "rope"
    rope_diameter_mm: Annotated[Number, Field(gt=0, description="nominal diameter")] = 10.0
    rope_modulus_GPa: Annotated[Number, Field(gt=0, description="on the metallic area")] = 100.0
    rope_fill_factor: Annotated[Number, Field(gt=0, le=1, description="metallic area over the circle")] = 0.455
    rope_falls: Annotated[Whole, Field(ge=1, description="falls that carry the container")] = 8
    rope_length_m: Annotated[Number, Field(gt=0, description="free length at t = 0")] = 5.0
    rope_damping_ratio: Annotated[Number, Field(ge=0, lt=1, description="of the bounce at the initial length")] = 0.02


LoadModel = Annotated[StaticTorqueTable | RopeTable, Field(discriminator="model")]


class SimulationTable(Table):
    """Time integration and output."""

    end_s: Annotated[Number, Field(gt=0, le=3600, description="simulated time")]
    output_rate_Hz: Annotated[Number, Field(gt=0, le=200000, description="after the anti-alias filter")] = 10000.0
    step_us: Annotated[Number, Field(gt=0, le=1000, description="rounded down to a whole part of the output step")] = (
        10.0
    )
    integrator: Annotated[
        Literal["exponential", "trapezoidal", "generalised-alpha"], Field(description="see docs/choosing-a-rung.md")
    ] = "exponential"
