"""Tables of the casing: its housing, its rungs, its sensors."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.tables.base import MaterialTable, Number, Positive, Table
from pipelines.tables.housing import Axes, HousingModel


class NoCasingTable(Table):
    """Bearings to ground. Casing sensors are refused; channels are bearing forces and shaft motion."""

    model: Literal["none"] = "none"


class FlexibleBase(Table):
    """What every casing with a housing has."""

    housing: HousingModel
    material: MaterialTable
    element_size_mm: Annotated[
        Number, Field(gt=0, description="of the tetrahedra; the rung rigid meshes only a housing that is no plain box")
    ] = 22.0
    bore_element_size_mm: Annotated[Positive | None, Field(description="at the bearing seats, where smaller")] = None
    foot_element_size_mm: Annotated[Positive | None, Field(description="at the ground faces, where smaller")] = None
    damping_ratio: Annotated[Number, Field(ge=0, lt=1, description="modal damping")] = 0.01


class RigidCasingTable(FlexibleBase):
    """A rigid body on six mount springs, one per foot: 6 coordinates, no finite elements."""

    model: Literal["rigid"] = "rigid"
    mount_stiffness_N_per_um: Annotated[Number, Field(gt=0, le=1e7, description="of each foot, in x, y and z")] = 200.0


class StaticCasingTable(FlexibleBase):
    """Finite elements condensed statically (Guyan) to the bearing points."""

    model: Literal["static"] = "static"


class CraigBamptonCasingTable(FlexibleBase):
    """Finite elements reduced to the bearing points and the fixed-interface modes."""

    model: Literal["craig-bampton"] = "craig-bampton"
    band_Hz: Annotated[Number, Field(gt=0, le=20000, description="wanted band; modes are kept to 1.5 times it")] = (
        5000.0
    )
    elements_per_wavelength: Annotated[
        Positive | None,
        Field(description="per bending wavelength of the thinnest wall at band_Hz; elements get no larger than that"),
    ] = None


CasingModel = Annotated[
    NoCasingTable | RigidCasingTable | StaticCasingTable | CraigBamptonCasingTable, Field(discriminator="model")
]


class SensorTable(Table):
    """A tri-axial accelerometer on the casing."""

    name: Annotated[str, Field(pattern=r"^sensor_[1-9][0-9]*$", description="sensor_1, sensor_2, ...")]
    position_mm: Annotated[
        tuple[Number, Number, Number], Field(description="x, y, z; moved to the nearest surface point")
    ]
    axes: Annotated[Axes, Field(description="directions of its channels x, y, z in the frame of the scene")] = (
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
    )
