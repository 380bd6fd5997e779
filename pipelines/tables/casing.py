"""Tables of the casing: its housing, its rungs, its sensors."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.tables.base import MaterialTable, Number, Positive, Table


class HousingTable(Table):
    """The parametric housing: a closed box with bearing bosses in its two side walls and six feet."""

    length_mm: Annotated[Number, Field(gt=0, description="outer length along x")]
    width_mm: Annotated[Number, Field(gt=0, description="outer width along y; mid face is y = 0")]
    height_mm: Annotated[Number, Field(gt=0, description="outer height along z without feet")]
    wall_thickness_mm: Annotated[Number, Field(gt=0, description="of all walls, floor and cover")]
    left_end_mm: Annotated[Number, Field(description="x of the outer face of the left end wall; shaft 1 is x = 0")]
    shaft_height_mm: Annotated[Number, Field(gt=0, description="shaft 1 above the underside of the floor")]
    bore_diameters_mm: Annotated[tuple[Positive, ...], Field(description="one per shaft, for both of its bearings")]
    boss_diameters_mm: Annotated[tuple[Positive, ...], Field(description="one per shaft")]
    boss_length_mm: Annotated[Number, Field(gt=0, description="along y, from the outer wall face inwards")]
    foot_length_mm: Annotated[Number, Field(gt=0, description="side of the square foot pads")] = 60.0
    foot_height_mm: Annotated[Number, Field(gt=0, description="foot pads below the floor")] = 15.0


class NoCasingTable(Table):
    """Bearings to ground. Casing sensors are refused; channels are bearing forces and shaft motion."""

    model: Literal["none"] = "none"


class FlexibleBase(Table):
    """What every casing with a housing has."""

    housing: HousingTable
    material: MaterialTable
    damping_ratio: Annotated[Number, Field(ge=0, lt=1, description="modal damping")] = 0.01


class RigidCasingTable(FlexibleBase):
    """A rigid body on six mount springs, one per foot: 6 coordinates, no finite elements."""

    model: Literal["rigid"] = "rigid"
    mount_stiffness_N_per_um: Annotated[Number, Field(gt=0, le=1e7, description="of each foot, in x, y and z")] = 200.0


class StaticCasingTable(FlexibleBase):
    """Finite elements condensed statically (Guyan) to the bearing points."""

    model: Literal["static"] = "static"
    element_size_mm: Annotated[Number, Field(gt=0, description="of the tetrahedra")] = 22.0


class CraigBamptonCasingTable(FlexibleBase):
    """Finite elements reduced to the bearing points and the fixed-interface modes."""

    model: Literal["craig-bampton"] = "craig-bampton"
    element_size_mm: Annotated[Number, Field(gt=0, description="of the tetrahedra")] = 22.0
    band_Hz: Annotated[Number, Field(gt=0, le=20000, description="wanted band; modes are kept to 1.5 times it")] = (
        5000.0
    )


CasingModel = Annotated[
    NoCasingTable | RigidCasingTable | StaticCasingTable | CraigBamptonCasingTable, Field(discriminator="model")
]


class SensorTable(Table):
    """A tri-axial accelerometer on the casing."""

    name: Annotated[str, Field(pattern=r"^sensor_[1-9][0-9]*$", description="sensor_1, sensor_2, ...")]
    position_mm: Annotated[
        tuple[Number, Number, Number], Field(description="x, y, z; moved to the nearest surface point")
    ]
