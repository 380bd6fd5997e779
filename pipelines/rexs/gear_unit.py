"""Gear unit of a REXS file: plain data in the units of the format (mm, deg, 1/min, N m, N/mm2, kg/dm3).

Places are in the frame of the scene: y along the shafts, z up, x across; the input shaft turns about +y.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True, kw_only=True)
class RexsSection:
    """A stretch of a shaft, from -y to +y, whose diameters may change along it."""

    start: float
    end: float
    outer: tuple[float, float]
    inner: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class RexsBearing:
    """A bearing on a shaft."""

    label: str
    y: float
    kind: str  # type in the format, e.g. radial_grooved_ball_bearing
    designation: str
    axial: str  # both_directions, positive, negative, no_direction, or "" if it is not in the file
    radial: bool
    inner_diameter: float | None
    outer_diameter: float | None
    static_rating: float | None  # N
    radial_stiffness: float | None  # N/m
    elements: dict[str, Any]  # its rolling elements as keys of a scene; empty if they are not in the file


@dataclass(frozen=True, kw_only=True)
class RexsGear:
    """A cylindrical gear; None for a value that is not in the file."""

    label: str
    teeth: int
    module: float
    helix: float  # positive: right hand
    pressure_angle: float
    profile_shift: float
    start: float  # of the face
    end: float
    tip_diameter: float | None
    root_diameter: float | None
    addendum: float | None  # h_aP*
    tip_radius: float | None  # of the tool, in modules
    grade: int | None  # tolerance class of ISO 1328


@dataclass(frozen=True, kw_only=True)
class RexsShaft:
    """A shaft with its axis at (x, z)."""

    label: str
    x: float
    z: float
    sections: tuple[RexsSection, ...]
    bearings: tuple[RexsBearing, ...]
    material: dict[str, float]  # as keys of a scene; empty if it is not in the file


@dataclass(frozen=True, kw_only=True)
class RexsStage:
    """A gear pair; `shafts` are the positions of the driving and the driven shaft in the unit's tuple of shafts."""

    label: str
    shafts: tuple[int, int]
    pinion: RexsGear
    wheel: RexsGear
    centre_distance: float


@dataclass(frozen=True, kw_only=True)
class LoadCase:
    """Operating condition: speed of the input shaft and torque into it, None if not in the file."""

    name: str
    speed: float | None
    torque: float | None


@dataclass(frozen=True, kw_only=True)
class GearUnit:
    """The whole unit: shafts in the order of the power flow, the input first."""

    source: str
    written_by: str
    version: str
    shafts: tuple[RexsShaft, ...]
    stages: tuple[RexsStage, ...]
    between: tuple[tuple[tuple[int, int], RexsBearing], ...]  # bearings between two shafts, with their positions
    output: int
    output_y: float | None  # where the load is coupled
    load_case: LoadCase
    other_cases: tuple[LoadCase, ...]
    notes: tuple[Note, ...]

    @property
    def speeds(self) -> dict[int, float]:
        """Turns of each shaft, by its position in the tuple, for one turn of the input."""
        found = {0: 1.0}
        for stage in self.stages:
            driving, driven = stage.shafts
            found[driven] = found[driving] * stage.pinion.teeth / stage.wheel.teeth
        return found

    @property
    def ratio(self) -> float:
        """Turns of the input for one turn of the output."""
        return 1 / self.speeds[self.output]


@dataclass(frozen=True)
class Note:
    """Difference between file and scene: `assumed` a value missing in the file, `changed` what a scene cannot
    express, `left out` what it does not contain."""

    kind: Literal["assumed", "changed", "left out"]
    where: str  # in the scene or in the file
    value: str  # in the scene; "" without one
    reason: str

    def __str__(self) -> str:
        """``kind: where = value: reason``."""
        return f"{self.kind}: {self.where}{f' = {self.value}' if self.value else ''}: {self.reason}"
