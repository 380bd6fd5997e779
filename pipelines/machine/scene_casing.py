"""The casing of a scene, in SI: its model, and the structure that the model reduces.

The housing is parametric, with bores at the shafts, or imported from a file, whose bores must be at the shafts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.casing.geometry.dimensions import Bore, Dimensions, Sensor, orthonormal
from fem.casing.geometry.housing_features import Feet
from fem.casing.geometry.locators import Point
from fem.casing.mesh.imported_housing import ImportedHousing, Seat, content_hash
from fem.casing.models.casing_model import CasingModel, Structure
from fem.casing.models.casing_registry import casing_class
from mbd.parts.bearings import BEARING_AXES
from pipelines.io.errors import Problem, SceneError
from pipelines.machine.layout import TrainLayout
from pipelines.machine.machine_parts import MachineParts
from pipelines.machine.scene_bearings import bearing_points
from pipelines.scene.scene import Scene
from pipelines.scene.shipped_files import find_file
from pipelines.scene.tables.housing import HousingBase, HousingModel, MatricesHousingTable
from pipelines.scene.tables.series import refused

if TYPE_CHECKING:
    from fem.casing.imported.imported_casing import ImportedMatrices
    from fem.casing.reduced.grounded import ForcedPoint

END_DISTANCE = 0.05  # from the end of the box to the outer feet, in lengths of the box


def casing(scene: Scene, layout: TrainLayout, machine: MachineParts) -> tuple[CasingModel, Structure]:
    """The casing model with its options, and the structure that it reduces, with the sensors on it.

    Parameters
    ----------
    scene, layout, machine : the scene, its layout, and the machine in the casing

    Raises
    ------
    HousingError, InputError : a housing that does not fit
    SceneError : the same, with the keys that must be corrected
    """
    table, points = scene.casing, bearing_points(scene, layout)
    model: CasingModel = table.made()
    if scene.housing is None:
        return model, Structure(bearings={f"bearing_{number}": point for number, point in enumerate(points, 1)})
    made = housing(scene.housing, tuple(sensor.made() for sensor in scene.sensors), layout, points)
    matrices = scene.housing.model == "matrices"
    if matrices:
        model, found = casing_class("matrices")(of=model), Structure(housing=made)
    else:
        found = _shaped(scene, made)
    loads = {  # an axis without stiffness needs no interface
        spec.name: tuple(axis for axis, k in zip(BEARING_AXES, spec.stiffness, strict=True) if k > 0.0)
        for spec in machine.bearings
    }
    forced = forced_points(machine, found.sensors)
    if forced and matrices:
        raise refused(
            "forces",
            "a casing-force acts on a mesh, and the housing is given by matrices",
            "Delete the force, or set casing.housing to a shape, a CAD file or a mesh",
        )
    return model, replace(found, interfaces=loads, forced=forced)


def _shaped(scene: Scene, made: Any) -> Structure:
    """A housing with its material and its bolts, without loads.

    Raises
    ------
    SceneError : no material, bolts that do not fit, or element sizes by wavelength for a wall of unknown thickness
    """
    table, parametric = scene.casing, None if scene.parametric is None else made
    if table.material is None:
        raise refused("casing.material", "is missing", "Set this table: material of the housing")
    thinnest = table.housing.si.wall_thickness if parametric is None else made.thinnest_wall
    if thinnest is None and getattr(table, "elements_per_wavelength", None) is not None:
        raise refused(
            "casing.housing.wall_thickness_mm",
            "is needed for casing.elements_per_wavelength of a housing from a file",
            "Set the thickness of its thinnest wall.",
        )
    joint, bolts = None, getattr(table.housing, "joint", None)
    if table.elastic and bolts is not None:
        from pipelines.machine.joint import bolted_joint  # late, like all that only elastic ones need

        joint = bolted_joint(bolts, parametric)
    return Structure(housing=made, material=table.material.made(name="casing"), joint=joint, wall=thinnest)


def forced_points(machine: MachineParts, sensors: Sequence[Sensor]) -> tuple[ForcedPoint, ...]:
    """Sensors at which external forces act, with the axes of these forces."""
    pulled = {row for force in machine.forces for row in force.casing_rows}
    if not pulled:
        return ()
    from fem.casing.reduced.grounded import GROUND_AXES, ForcedPoint

    points = ((s, tuple(axis for axis in GROUND_AXES if f"{s.name}:{axis}" in pulled)) for s in sensors)
    return tuple(ForcedPoint(sensor=sensor, axes=axes) for sensor, axes in points if axes)


def bores(table: HousingBase, layout: TrainLayout) -> tuple[Bore, ...]:
    """Two bores per shaft, odd numbers in the wall at -y."""
    return tuple(
        Bore(
            name=f"bearing_{2 * number + (1 if side < 0 else 2)}",
            x=x,
            z=z,
            side=side,
            diameter=bore,
            boss_diameter=boss,
            boss_length=table.si.boss_length,
        )
        for number, ((x, z), bore, boss) in enumerate(
            zip(layout.axes, table.si.bore_diameters, table.si.boss_diameters, strict=True)
        )
        for side in (-1, 1)
    )


def dimensions(table: HousingBase, layout: TrainLayout) -> Dimensions:
    """The dimensions of the housing, valid or not."""
    return table.made_part(Dimensions, bores=bores(table, layout), feet=feet(table))


def feet(table: HousingBase) -> Feet:
    """Feet at equal distances along the box: three on each side, or more if their largest distance requires it."""
    box = table.si
    length, left, side, pitch = box.length, box.left_end, box.foot_length, box.foot_pitch
    first, last = left + END_DISTANCE * length + side / 2, left + (1 - END_DISTANCE) * length - side / 2
    places = (first, (first + last) / 2, last)
    if pitch is not None:
        count = max(2, math.ceil((last - first) / pitch - 1e-9) + 1)
        places = tuple(np.linspace(first, last, count).tolist())
    return table.made_part(Feet, x=places)


def housing(
    table: HousingModel,
    sensors: tuple[Sensor, ...],
    layout: TrainLayout,
    points: Sequence[Point],
) -> Any:
    """The housing with the sensors on it: a `Geometry`, or a `ImportedMatrices` of matrices.

    Parameters
    ----------
    table : of the housing
    sensors : on it
    layout : layout of the shafts
    points : (x, y, z) of its bearings, m

    Raises
    ------
    HousingError, InputError : its parts do not fit together, or there is no such file
    SceneError : bearings that are not located or belong to no shaft
    """
    if table.model == "parametric":
        return table.made(bores=bores(table, layout), feet=feet(table), sensors=sensors, bolted=table.joint is not None)
    if problems := list(_seat_problems([seat.name for seat in table.bearings], len(points))):
        raise SceneError("scene", problems)
    if table.model == "matrices":
        return imported_matrices(table, sensors, points)
    path = find_file(table.file)
    return ImportedHousing(
        path=str(path),
        sha256=content_hash(path),
        unit=table.unit,
        upgrade=getattr(table, "upgrade", False),
        solids=getattr(table, "solids", ()),
        glue=getattr(table, "glue", False),
        origin=table.si.origin,
        axes=orthonormal(table.axes),
        seats=tuple(
            Seat(name=f"bearing_{number}", locator=seat.made(), shaft_point=point)
            for number, point in enumerate(points, 1)
            for seat in table.bearings
            if seat.name == f"bearing_{number}"
        ),
        grounds=tuple(ground.made() for ground in table.grounds),
        sensors=sensors,
    )


def imported_matrices(
    table: MatricesHousingTable, sensors: tuple[Sensor, ...], points: Sequence[Point]
) -> ImportedMatrices:
    """The housing given by imported matrices, with the sensors on it; arguments as for `housing`."""
    from fem.casing.imported.imported_casing import ImportedMatrices, file_digests
    from fem.casing.imported.matrix_files import MatrixFiles

    nodes = {seat.name: seat.nodes for seat in table.bearings}
    names = {
        "stiffness": table.file,
        "mass": table.mass_file,
        "nodes": table.nodes_file,
        "equations": table.equations_file,
        "rows": table.rows_file,
    }
    found: dict[str, Any] = {what: None if name is None else str(find_file(name)) for what, name in names.items()}
    files = MatrixFiles(**found, system=table.units)
    return ImportedMatrices(
        files=replace(files, digests=file_digests(files)),
        seats=tuple((f"bearing_{n}", nodes[f"bearing_{n}"], point) for n, point in enumerate(points, 1)),
        grounds=tuple(ground.nodes for ground in table.grounds),
        origin=table.si.origin,
        sensors=sensors,
    )


def _seat_problems(given: Sequence[str], bearings: int) -> Iterator[Problem]:
    """Problems with the names of the bearing seats."""
    expected = [f"bearing_{number}" for number in range(1, bearings + 1)]
    if missing := [name for name in expected if name not in given]:
        yield Problem(
            "casing.housing.bearings", f"there is no seat for {', '.join(missing)}", "Add a table for every bearing"
        )
    if unknown := [name for name in given if name not in expected]:
        yield Problem(
            "casing.housing.bearings",
            f"there is no bearing {', '.join(unknown)}; the shafts have {expected[0]} to {expected[-1]}",
            "Correct the name, or delete the table",
        )
