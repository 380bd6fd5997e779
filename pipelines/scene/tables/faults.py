"""Tables of faults, one each with its severity: damaged teeth, and spalls of rolling bearings."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

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
    depth_mm: Annotated[Positive, Field(description="length of the crack in the section, at that end of the face")]
    far_depth_mm: Annotated[
        Number | None,
        Field(ge=0, description="its length at the far end of the extent; 0: across a corner; left out: the same"),
    ] = None
    angle_deg: Annotated[
        Number, Field(ge=40, le=90, description="to the tooth centre line; 90 straight across, less into the rim")
    ] = 70.0
    extent_mm: Annotated[Positive | None, Field(description="part of the face that is cracked; left out: all")] = None
    end: End = "+y"
    flank: Annotated[Literal["drive", "coast"], Field(description="side of the tooth where the crack starts")] = "drive"


class FlankDamageBase(FaultBase):
    """Where damage lies on a flank."""

    height_mm: Annotated[Positive, Field(description="of the damage, along the flank from root to tip")]
    diameter_mm: Annotated[
        Positive | None, Field(description="where its middle lies; left out: the reference circle")
    ] = None
    position_mm: Annotated[Number, Field(description="of its middle from mid face, towards +y")] = 0.0
    flank: Annotated[Literal["drive", "coast"], Field(description="damaged flank of the tooth")] = "drive"


class SpalledToothTable(FlankDamageBase):
    """A patch broken out of a flank; the mate bridges it over its rim."""

    kind: Annotated[Literal["spalled-tooth"], Field(description="what is wrong with the tooth")]
    length_mm: Annotated[Positive, Field(description="of the spall along the face; cut off at the ends of the face")]
    depth_um: Annotated[Positive, Field(description="of its floor below the flank")]
    shape: Annotated[Literal["ellipse", "rectangle"], Field(description="outline of the spall")] = "ellipse"


class PittedToothTable(FlankDamageBase):
    """Many round pits on an area of a flank, drawn with a seed."""

    kind: Annotated[Literal["pitted-tooth"], Field(description="what is wrong with the tooth")]
    length_mm: Annotated[
        Positive | None, Field(description="of the pitted area along the face; left out: the whole face")
    ] = None
    density: Annotated[Number, Field(gt=0, le=0.3, description="part of the area that the pits cover")]
    pit_mm: Annotated[Positive, Field(description="median diameter of the pits")]
    spread: Annotated[
        Number, Field(ge=1, le=3, description="of the log-normal diameters: factor of one standard deviation")
    ] = 1.4
    depth_part: Annotated[Number, Field(gt=0, le=1, description="depth of a pit in parts of its diameter")] = 0.25
    seed: Annotated[Whole, Field(ge=0, le=2**31, description="same seed, same pits")] = 1


class WornToothTable(FaultBase):
    """Material worn off both flanks of one tooth, or of all."""

    kind: Annotated[Literal["worn-tooth"], Field(description="what is wrong with the tooth")]
    tooth: Annotated[Whole | None, Field(ge=0, description="number of the tooth; left out: all teeth")] = None  # type: ignore[assignment]
    depth_um: Annotated[Positive, Field(description="largest depth, normal to the flank")]
    place: Annotated[
        Literal["flank", "pitch", "root", "profile"],
        Field(description="even, local at pitch point or root, or a profile by diameters_mm and parts"),
    ] = "flank"
    width_mm: Annotated[Positive | None, Field(description="roll length of local wear; left out with other wear")] = (
        None
    )
    diameters_mm: Annotated[tuple[Positive, ...], Field(max_length=1000, description="of a profile, rising")] = ()
    parts: Annotated[
        tuple[Annotated[Number, Field(ge=0, le=1)], ...],
        Field(max_length=1000, description="of a profile: wear at the diameters in parts of depth_um"),
    ] = ()
    extent_mm: Annotated[
        Positive | None, Field(description="part of the face that is worn, of one tooth; left out: all")
    ] = None
    end: End = "+y"
    fading: Annotated[Flag, Field(description="true: the wear falls to nothing over the extent")] = False

    @model_validator(mode="after")
    def _part_of_one_tooth(self) -> WornToothTable:
        if self.tooth is None and self.extent_mm is not None:
            raise ValueError(
                "extent_mm: wear on a part of the face is that of one tooth; give tooth, or give the flanks of all "
                "teeth by stages.N.pinion.deviations.flanks.file"
            )
        return self


FaultTable = Annotated[
    MissingToothTable | ChippedToothTable | CrackedToothTable | SpalledToothTable | PittedToothTable | WornToothTable,
    Field(discriminator="kind"),
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
