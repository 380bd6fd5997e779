"""Tables of the housing: parametric, from a STEP file, or from a mesh file."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag, model_validator

from fem.casing.geometry.housing import Housing
from fem.casing.geometry.housing_features import LARGEST
from fem.casing.geometry.locators import ByBox, ByCylinder, ByGroup, ByPlane, ByPoint
from fem.casing.parts.bolts import Size
from pipelines.scene.tables.derived import DerivedTable, EitherTable, either, table
from pipelines.scene.tables.scene_table import Flag, Number, Positive, Table, Whole, repeated_names

Vector = tuple[Number, Number, Number]
Axes = tuple[Vector, Vector, Vector]
Unit = Literal["m", "cm", "mm", "um", "inch"]
Length = Annotated[Number, Field(gt=0, le=LARGEST)]
Place = Annotated[Number, Field(ge=-LARGEST, le=LARGEST)]
Stiffness = Annotated[Number, Field(gt=0, le=1e9)]


class JointTable(Table):
    """Bolts that hold two parts of a housing together; without them the parts are bonded."""

    bolt: Annotated[Size, Field(description="size of all bolts: hexagon heads, holes of ISO 273 medium")]
    outer_diameter_mm: Annotated[
        Length | None,
        Field(
            description="outer diameter D_A of the clamped parts (VDI 2230); without it: the diameter up to which "
            "the joint stays closed"
        ),
    ] = None
    stiffness_N_per_um: Annotated[
        tuple[Stiffness, Stiffness] | None,
        Field(
            description="stiffness of each bolt along and across its axis; without it: by the deformation cone of "
            "VDI 2230"
        ),
    ] = None


class CoverJointTable(JointTable):
    """Bolts of the cover: in the flange if there is one, else through the cover into the walls."""

    pitch_mm: Annotated[
        Length | None,
        Field(description="largest distance of neighbouring bolts; bolts are set at corners and next to bosses"),
    ] = None
    positions_mm: Annotated[
        tuple[tuple[Place, Place], ...],
        Field(description="x and y of bolts; together with pitch_mm: of additional bolts"),
    ] = ()

    @model_validator(mode="after")
    def _some(self) -> CoverJointTable:
        if self.pitch_mm is None and not self.positions_mm:
            raise ValueError("has no bolts. Set pitch_mm, positions_mm or both")
        return self


class PlaneJointTable(JointTable):
    """Bolts across a plane where two solids of a file touch, or elements of a mesh meet."""

    through_mm: Annotated[Vector, Field(description="a point of the plane")]
    normal: Annotated[Vector, Field(description="normal of the plane, towards the heads of the bolts")] = (
        0.0,
        0.0,
        1.0,
    )
    clamped_mm: Annotated[
        tuple[Length, Length],
        Field(description="clamped thickness on the two sides of the plane, that under the heads first"),
    ]
    tapped: Annotated[Flag, Field(description="true: the threads are in the part beyond the plane, without nuts")] = (
        False
    )
    positions_mm: Annotated[tuple[Vector, ...], Field(min_length=1, description="a point on the axis of every bolt")]

    @model_validator(mode="after")
    def _direction(self) -> PlaneJointTable:
        if not any(self.normal):
            raise ValueError("normal = [0, 0, 0] is no direction. Correct it")
        return self


class HousingBase(DerivedTable):
    """What a scene gives of a parametric housing besides its dimensions."""

    model: Literal["parametric"] = "parametric"
    bore_diameters_mm: Annotated[
        tuple[Length, ...], Field(description="diameters of the bearing bores, one per shaft, for both of its bearings")
    ]
    boss_diameters_mm: Annotated[tuple[Length, ...], Field(description="outer diameters of the bosses, one per shaft")]
    boss_length_mm: Annotated[
        Length, Field(description="length of the bosses along y, inwards from the outer wall face")
    ]
    foot_pitch_mm: Annotated[
        Length | None,
        Field(
            description="largest distance of neighbouring feet, which sets their number; without it: three on each "
            "side; the outer feet end 5 % of length_mm before the end walls"
        ),
    ] = None
    joint: Annotated[
        CoverJointTable | None, Field(description="bolts of the cover; without it: cover and lower part are bonded")
    ] = None

    @property
    def plain(self) -> bool:
        """Whether the body is made of boxes and of cylinders along y alone."""
        return not any((self.flange, self.ribs, self.foot_fillet_mm, self.inner_fillet_mm, self.pad_diameter_mm))


SeatName = Annotated[
    str,
    Field(
        pattern=r"^bearing_[1-9][0-9]*$",
        description="bearing_1, bearing_2, ...: two per shaft, odd numbers at its -y end",
    ),
]


class SeatBase(EitherTable):
    """A bearing seat, given by axis and diameter of its bore or by a group of the mesh file."""

    name: SeatName


class GroundBase(EitherTable):
    """Ground faces: a flat face, everything in a box, all faces in a plane, or a group of the file."""


SeatTable: TypeAlias = either(SeatBase, ByCylinder, ByGroup)
GroundTable: TypeAlias = either(GroundBase, ByPoint, ByBox, ByPlane, ByGroup)


class ImportedTable(Table):
    """What every housing from a file has. Places are in the frame of the scene: shaft 1 is x = z = 0."""

    file: Annotated[
        str, Field(min_length=1, description="name in the folder of the scene, a path, or the name of a shipped file")
    ]
    unit: Annotated[Unit, Field(description="unit of length of the file")]
    origin_mm: Annotated[Vector, Field(description="x, y, z of the origin of the file in the scene")] = (0.0, 0.0, 0.0)
    axes: Annotated[Axes, Field(description="directions of the axes x, y and z of the file in the scene")] = (
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
    )
    bearings: Annotated[tuple[SeatTable, ...], Field(min_length=1, description="bearing seats")]
    grounds: Annotated[tuple[GroundTable, ...], Field(min_length=1, description="faces that are held by the ground")]
    wall_thickness_mm: Annotated[
        Positive | None, Field(description="thickness of the thinnest wall, for casing.elements_per_wavelength")
    ] = None
    joint: Annotated[
        PlaneJointTable | None, Field(description="bolts between two parts; without it: the parts are bonded")
    ] = None

    @model_validator(mode="after")
    def _each_seat_once(self) -> Any:
        if repeated := repeated_names("bearings", self.bearings, "Delete all but one"):
            raise ValueError("\n".join(repeated))
        return self


class StepHousingTable(ImportedTable):
    """Solids of a STEP, BREP, IGES or closed STL file, which are meshed."""

    model: Literal["step"] = "step"
    solids: Annotated[
        tuple[Annotated[Whole, Field(ge=1)], ...],
        Field(description="numbers of the solids of the housing, as in `gearcase housing FILE`; empty: all"),
    ] = ()
    glue: Annotated[Flag, Field(description="true: several solids are bonded where they touch")] = False


class MeshHousingTable(ImportedTable):
    """A mesh of tetrahedra or hexahedra, best with mid-side nodes: .msh .inp .bdf .unv .med .vtu ..."""

    model: Literal["mesh"] = "mesh"
    upgrade: Annotated[Flag, Field(description="true: linear elements get mid-side nodes on straight edges")] = False


Nodes = Annotated[
    tuple[Whole, ...],
    Field(
        min_length=1,
        description="numbers of its nodes; casing.attachment sets whether it follows their mean motion (RBE3) "
        "or they are rigid (RBE2)",
    ),
]


class NodeSeatTable(Table):
    """A bearing of a housing of matrices: the nodes of its seat, or one node at the bearing."""

    name: SeatName
    nodes: Nodes


class NodeGroundTable(Table):
    """A foot of a housing that is given as matrices."""

    nodes: Nodes


class MatricesHousingTable(Table):
    """Stiffness and mass matrix of the unconstrained body from another program, in the axes of the scene."""

    model: Literal["matrices"] = "matrices"
    file: Annotated[
        str,
        Field(
            min_length=1, description="file of both matrices, or of the stiffness matrix: .op4 .pch .mtx .sti .npz .h5"
        ),
    ]
    mass_file: Annotated[
        str | None, Field(description="file of the mass matrix, if file holds the stiffness matrix only")
    ] = None
    nodes_file: Annotated[
        str | None,
        Field(description="file of the nodes: rows of number, x, y, z; GRID cards of Nastran; *NODE of Abaqus"),
    ] = None
    equations_file: Annotated[
        str | None,
        Field(
            description="file of the equations: rows of node and axis (1 to 6; 0: modal); .mapping of Ansys; "
            "EXTRN cards; without it: 3 or 6 equations per node"
        ),
    ] = None
    rows_file: Annotated[
        str | None,
        Field(
            description="file of the displacements of nodes without equations, such as sensors: three rows, x, y, z, "
            "for each, times the coordinates; .npz, .op4 and .pch of gearcase hold them"
        ),
    ] = None
    units: Annotated[
        Literal["kg-m-s", "t-mm-s", "kg-mm-ms", "kg-mm-s", "lbf-in-s"],
        Field(description="units of mass, length and time of the file; lbf-in-s: units of force, length and time"),
    ]
    origin_mm: Annotated[Vector, Field(description="x, y, z of the origin of the file in the scene")] = (0.0, 0.0, 0.0)
    bearings: Annotated[tuple[NodeSeatTable, ...], Field(min_length=1, description="bearing seats")]
    grounds: Annotated[tuple[NodeGroundTable, ...], Field(min_length=1, description="feet")]


def _model_of(value: Any) -> str:
    """The model that a table names; the parametric housing where it names none."""
    return value.get("model", "parametric") if isinstance(value, dict) else getattr(value, "model", "parametric")


HousingModel: TypeAlias = Annotated[
    Annotated[table(Housing, HousingBase), Tag("parametric")]
    | Annotated[StepHousingTable, Tag("step")]
    | Annotated[MeshHousingTable, Tag("mesh")]
    | Annotated[MatricesHousingTable, Tag("matrices")],
    Discriminator(_model_of),
]
