"""BEARINGS: the models of bearings by name, each a frozen class of options that makes a bearing of the machine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Literal

from fem.named_classes import named_class
from fem.options import check_options, inline, option
from mbd.parts.bearings import BearingSpec, rigid_bearing
from mbd.parts.part_checks import MachineError, Options
from mbd.parts.rolling_elements import RollingElements

BEARINGS = {
    "rigid": ("mbd.forces.bearing_models", "RigidBearings"),
    "linear": ("mbd.forces.bearing_models", "LinearBearings"),
    "hertz": ("mbd.forces.bearing_models", "HertzBearings"),
}
Support = Literal["casing", "ground"]
Station = tuple[str, float]  # name of a shaft, and y on it (m)


def bearing_model(name: str) -> type[BearingModel]:
    """The class of that name. MachineError if there is none."""
    return named_class(BEARINGS, name, "bearing model", MachineError)


@dataclass(frozen=True, kw_only=True)
class BearingModel(Options, ABC):
    """Options of a bearing; `elements` of those whose rolling elements are known."""

    elements: RollingElements | None = field(default=None, init=False)

    @abstractmethod
    def spec(self, name: str, at: Station, support: Support) -> BearingSpec:
        """The bearing of a name, at a shaft and y (m) on it; `support` carries it.

        Raises
        ------
        MachineError : its values do not fit together
        """


@dataclass(frozen=True, kw_only=True)
class RigidBearings(BearingModel):
    """Bearings that hold all displacements and leave tilting free."""

    model: Literal["rigid"] = "rigid"

    def spec(self, name: str, at: Station, support: Support) -> BearingSpec:
        """Stiff springs."""
        return rigid_bearing(name, *at, support)


@dataclass(frozen=True, kw_only=True)
class LinearBearings(BearingModel):
    """Linear springs and dampers between a shaft and its support."""

    model: Literal["linear"] = "linear"
    radial_stiffness: float = option(1e8, unit="N/um", ge=0.01, le=1e6, text="radial stiffness along x and z")
    vertical_stiffness: float | None = option(
        None, unit="N/um", ge=0.01, le=1e6, text="radial stiffness along z, where it differs from that along x"
    )
    cross_stiffness: float = option(
        0.0, unit="N/um", ge=-1e6, le=1e6, text="symmetric coupling stiffness between x and z"
    )
    axial_stiffness: float = option(5e7, unit="N/um", ge=0.01, le=1e6, text="stiffness along the shaft")
    tilt_stiffness: float = option(1e4, unit="N m/rad", ge=0, le=1e9, text="tilting stiffness about x and z")
    damping_time: float = option(5e-6, unit="us", ge=0, le=1e4, text="damping matrix divided by stiffness matrix")

    def spec(self, name: str, at: Station, support: Support) -> BearingSpec:
        """Springs and dampers."""
        vertical = self.radial_stiffness if self.vertical_stiffness is None else self.vertical_stiffness
        tilt = self.tilt_stiffness
        return BearingSpec(
            name=name,
            shaft=at[0],
            y=at[1],
            stiffness=(self.radial_stiffness, self.axial_stiffness, vertical, tilt, tilt),
            cross=(("ux", "uz", self.cross_stiffness),) if self.cross_stiffness else (),
            damping_time=self.damping_time,
            support=support,
        )


@dataclass(frozen=True, kw_only=True)
class HertzBearings(BearingModel):
    """Rolling bearings: Hertz contact of every rolling element, clearance or preload, rotating cage."""

    model: Literal["hertz"] = "hertz"
    elements: RollingElements = inline()
    damping_time: float = option(5e-6, unit="us", ge=0, le=1e4, text="damping divided by tangent stiffness")
    cage_slip: float = option(
        0.0,
        ge=0,
        le=0.05,
        text="standard deviation of the cage slip as a share of the cage speed; a new random value from "
        "deviations.seed at every passage of an element; 0: no slip",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_options(self.elements, MachineError)

    def spec(self, name: str, at: Station, support: Support) -> BearingSpec:
        """Contacts of the rolling elements."""
        from mbd.forces.rolling_bearing import hertz_bearing

        if not self.elements.stiffness > 0.0:
            raise MachineError("the rolling elements have no stiffness. Raise element_diameter_mm")
        return hertz_bearing(name, *at, self.elements, self.damping_time, support)
