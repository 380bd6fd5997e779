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
    tooth: Annotated[
        Whole, Field(ge=0, description="number of the tooth; tooth 0 touches at the pitch point at mesh cycle c = 0")
    ]


class MissingToothTable(FaultBase):
    """A tooth broken off at the root."""

    kind: Annotated[Literal["missing-tooth"], Field(description="what is wrong with the tooth")]


class ChippedToothTable(FaultBase):
    """A piece is broken off a tooth at the tip, from one end of the face."""

    kind: Annotated[Literal["chipped-tooth"], Field(description="what is wrong with the tooth")]
    extent_mm: Annotated[Positive, Field(description="length of the piece along the face")]
    depth_mm: Annotated[Positive, Field(description="height of the piece below the tip circle")]
    corner: Annotated[Flag, Field(description="true: a tip corner, the depth falls to zero over the extent")] = False
    end: End = "+y"


class CrackedToothTable(FaultBase):
    """A crack in the root fillet. It is open while the tooth is loaded on the cracked side."""

    kind: Annotated[Literal["cracked-tooth"], Field(description="what is wrong with the tooth")]
    depth_mm: Annotated[
        Positive,
        Field(description="length of the crack in the transverse section, at the end of the face where it starts"),
    ]
    far_depth_mm: Annotated[
        Number | None,
        Field(
            ge=0,
            description="length of the crack at the far end of extent_mm; 0: a crack across a corner;"
            " without it: depth_mm",
        ),
    ] = None
    angle_deg: Annotated[
        Number,
        Field(
            ge=40,
            le=90,
            description="angle between crack and tooth centre line; 90: straight across the tooth, smaller: into "
            "the rim",
        ),
    ] = 70.0
    extent_mm: Annotated[
        Positive | None, Field(description="length of the crack along the face; without it: whole face")
    ] = None
    end: End = "+y"
    flank: Annotated[Literal["drive", "coast"], Field(description="side of the tooth where the crack starts")] = "drive"


class FlankDamageBase(FaultBase):
    """Where damage lies on a flank."""

    height_mm: Annotated[Positive, Field(description="size of the damage along the flank, from root to tip")]
    diameter_mm: Annotated[
        Positive | None, Field(description="diameter at its centre; without it: the reference circle")
    ] = None
    position_mm: Annotated[Number, Field(description="y of its centre from the middle of the face")] = 0.0
    flank: Annotated[Literal["drive", "coast"], Field(description="damaged flank of the tooth")] = "drive"


class SpalledToothTable(FlankDamageBase):
    """A spall of a flank; the mating tooth bridges it on its edge."""

    kind: Annotated[Literal["spalled-tooth"], Field(description="what is wrong with the tooth")]
    length_mm: Annotated[
        Positive, Field(description="size of the spall along the face; what is beyond the end of the face is left out")
    ]
    depth_um: Annotated[Positive, Field(description="depth of the spall below the flank")]
    shape: Annotated[Literal["ellipse", "rectangle"], Field(description="outline of the spall")] = "ellipse"


class PittedToothTable(FlankDamageBase):
    """Many round pits on an area of a flank, at random places."""

    kind: Annotated[Literal["pitted-tooth"], Field(description="what is wrong with the tooth")]
    length_mm: Annotated[
        Positive | None, Field(description="size of the pitted area along the face; without it: whole face")
    ] = None
    density: Annotated[Number, Field(gt=0, le=0.3, description="share of the area that pits cover")]
    pit_mm: Annotated[Positive, Field(description="median diameter of the pits")]
    spread: Annotated[
        Number, Field(ge=1, le=3, description="geometric standard deviation of the log-normal diameters")
    ] = 1.4
    depth_part: Annotated[Number, Field(gt=0, le=1, description="depth of a pit divided by its diameter")] = 0.25
    seed: Annotated[Whole, Field(ge=0, le=2**31, description="seed of the random places and diameters")] = 1


class WornToothTable(FaultBase):
    """Wear of both flanks of one tooth, or of all teeth."""

    kind: Annotated[Literal["worn-tooth"], Field(description="what is wrong with the tooth")]
    tooth: Annotated[Whole | None, Field(ge=0, description="number of the tooth; without it: all teeth")] = None  # type: ignore[assignment]
    depth_um: Annotated[Positive, Field(description="largest depth of wear, normal to the flank")]
    place: Annotated[
        Literal["flank", "pitch", "root", "profile"],
        Field(
            description="place of the wear; flank: evenly on the whole flank; pitch or root: locally "
            "at the pitch point or root; profile: by diameters_mm and parts"
        ),
    ] = "flank"
    width_mm: Annotated[
        Positive | None,
        Field(description='length of local wear along the line of action; for place = "pitch" and "root" only'),
    ] = None
    diameters_mm: Annotated[
        tuple[Positive, ...], Field(max_length=1000, description="diameters of a profile, rising")
    ] = ()
    parts: Annotated[
        tuple[Annotated[Number, Field(ge=0, le=1)], ...],
        Field(max_length=1000, description="wear at these diameters as a share of depth_um"),
    ] = ()
    extent_mm: Annotated[
        Positive | None,
        Field(description="length of the wear along the face, for one tooth only; without it: whole face"),
    ] = None
    end: End = "+y"
    fading: Annotated[Flag, Field(description="true: the wear falls to zero over the extent")] = False

    @model_validator(mode="after")
    def _part_of_one_tooth(self) -> WornToothTable:
        if self.tooth is None and self.extent_mm is not None:
            raise ValueError(
                "extent_mm: only a single tooth can be worn on a part of the face. Set tooth, or delete extent_mm and "
                "set the worn flanks of all teeth by stages.N.pinion.deviations.flanks.file"
            )
        return self


FaultTable = Annotated[
    MissingToothTable | ChippedToothTable | CrackedToothTable | SpalledToothTable | PittedToothTable | WornToothTable,
    Field(discriminator="kind"),
]


class BearingSpallTable(Table):
    """A spall of a raceway or rolling element of a bearing of model hertz, across its whole contact width."""

    kind: Annotated[Literal["bearing-spall"], Field(description="what is wrong with the bearing")]
    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    bearing: Annotated[Whole, Field(ge=1, description="number of the bearing on that shaft; 1 is nearest to -y")]
    on: Annotated[
        Literal["outer-ring", "inner-ring", "element"],
        Field(description="damaged part; element: the first rolling element"),
    ]
    width_mm: Annotated[Positive, Field(description="size along the surface in the rolling direction")]
    depth_um: Annotated[Positive, Field(description="largest depth below the surface")]
    angle_deg: Annotated[
        Number,
        Field(
            ge=-360,
            le=360,
            description="angle of its centre at t = 0: on a ring from +x towards +z; on an element from the "
            "contact with the outer race, in the sense in which the element rolls",
        ),
    ] = 0.0


AnyFaultTable = Annotated[FaultTable | BearingSpallTable, Field(discriminator="kind")]
