"""Tables of faults, one each with its severity: damaged teeth, and spalls of rolling bearings."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.scene.tables.base import Flag, Number, Positive, Table, Whole

End = Annotated[Literal["-y", "+y"], Field(description="end of the face where the damage starts")]


class FaultBase(Table):
    """Which tooth is damaged."""

    stage: Annotated[Whole, Field(ge=1, description="number of the stage")]
    gear: Annotated[Literal["pinion", "wheel"], Field(description="gear of that stage")]
    tooth: Annotated[Whole, Field(ge=0, description="number of the tooth; 0 is in contact at the pitch point at c = 0")]


class MissingToothTable(FaultBase):
    """A tooth broken off at the root."""

    kind: Annotated[Literal["missing-tooth"], Field(description="what is wrong with the tooth")]


class ChippedToothTable(FaultBase):
    """A piece broken off a tooth, from one end of the face and from the tip."""

    kind: Annotated[Literal["chipped-tooth"], Field(description="what is wrong with the tooth")]
    extent_mm: Annotated[Positive, Field(description="part of the face that is chipped")]
    depth_mm: Annotated[Positive, Field(description="height of the piece below the tip circle")]
    corner: Annotated[Flag, Field(description="true: the depth falls to nothing over the extent (tip corner)")] = False
    end: End = "+y"


class CrackedToothTable(FaultBase):
    """A crack in the root fillet, open under load on its own side."""

    kind: Annotated[Literal["cracked-tooth"], Field(description="what is wrong with the tooth")]
    depth_mm: Annotated[Positive, Field(description="length of the crack in the section")]
    angle_deg: Annotated[
        Number, Field(ge=40, le=90, description="to the tooth centre line; 90 straight across, less into the rim")
    ] = 70.0
    extent_mm: Annotated[Positive | None, Field(description="part of the face that is cracked; left out: all")] = None
    end: End = "+y"
    flank: Annotated[Literal["drive", "coast"], Field(description="side of the tooth where the crack starts")] = "drive"


class WornToothTable(FaultBase):
    """Material worn off both flanks of one tooth, or of all."""

    kind: Annotated[Literal["worn-tooth"], Field(description="what is wrong with the tooth")]
    tooth: Annotated[Whole | None, Field(ge=0, description="number of the tooth; left out: all teeth")] = None  # type: ignore[assignment]
    depth_um: Annotated[Positive, Field(description="largest depth, normal to the flank")]
    place: Annotated[Literal["flank", "pitch", "root"], Field(description="even, or local at pitch point or root")] = (
        "flank"
    )
    width_mm: Annotated[Positive | None, Field(description="roll length of local wear; left out with place flank")] = (
        None
    )


FaultTable = Annotated[
    MissingToothTable | ChippedToothTable | CrackedToothTable | WornToothTable, Field(discriminator="kind")
]


class BearingSpallTable(Table):
    """A pit in a race or a rolling element of a bearing with the model hertz, as wide across as the contact."""

    kind: Annotated[Literal["bearing-spall"], Field(description="what is wrong with the bearing")]
    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    bearing: Annotated[Whole, Field(ge=1, description="of the bearings on that shaft, 1 nearest to -y")]
    on: Annotated[
        Literal["outer-ring", "inner-ring", "element"], Field(description="what is pitted; of the elements the first")
    ]
    width_mm: Annotated[Positive, Field(description="along the surface, in the rolling direction")]
    depth_um: Annotated[Positive, Field(description="of its bottom below the surface")]
    angle_deg: Annotated[
        Number,
        Field(
            ge=-360,
            le=360,
            description="of its middle at t = 0: on a ring from x towards z; on the element from the outer race, in "
            "the sense in which it rolls",
        ),
    ] = 0.0


AnyFaultTable = Annotated[FaultTable | BearingSpallTable, Field(discriminator="kind")]
