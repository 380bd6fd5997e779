"""The housing of a scene, in SI: parametric, bores where the shafts are, or from a file, whose bores must be there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from fem.casing.geometry.dimensions import Bore, Dimensions, HousingError, Sensor, orthonormal
from fem.casing.geometry.features import Feet
from fem.casing.geometry.housing import Housing
from fem.casing.mesh.imported import ImportedHousing, Seat, content_hash
from fem.casing.mesh.locate import ByBox, ByCylinder, ByGroup, ByPlane, ByPoint, Locator, Point
from fem.casing.mesh.source import Geometry
from pipelines.io.errors import InputError, Problem, SceneError
from pipelines.machine.layout import Layout
from pipelines.scene.shipped_files import find_file
from pipelines.scene.tables.housing import GroundTable, HousingBase, ImportedTable, SeatTable

END_DISTANCE = 0.05  # from the end of the box to the outer feet, in lengths of the box


def bores(table: HousingBase, layout: Layout) -> tuple[Bore, ...]:
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


def dimensions(table: HousingBase, layout: Layout) -> Dimensions:
    """The dimensions of the housing, valid or not."""
    made: Dimensions = table.made_part(Dimensions, bores=bores(table, layout), feet=feet(table))
    return made


def feet(table: HousingBase) -> Feet:
    """Feet evenly spread between the ends of the box: three a side, or as many as their largest distance asks for."""
    box = table.si
    length, left, side, pitch = box.length, box.left_end, box.foot_length, box.foot_pitch
    first, last = left + END_DISTANCE * length + side / 2, left + (1 - END_DISTANCE) * length - side / 2
    places = (first, (first + last) / 2, last)
    if pitch is not None:
        count = max(2, math.ceil((last - first) / pitch - 1e-9) + 1)
        places = tuple(np.linspace(first, last, count).tolist())
    made: Feet = table.made_part(Feet, x=places)
    return made


def housing(
    table: HousingBase | ImportedTable,
    sensors: tuple[Sensor, ...],
    layout: Layout,
    points: Sequence[Point],
    source: str = "scene",
) -> Geometry:
    """The housing with the sensors on it.

    Parameters
    ----------
    table : of the housing
    sensors : on it
    layout : where the shafts are
    points : (x, y, z) of the bearings that it carries, m
    source : of the scene, for messages

    Raises
    ------
    SceneError : its parts do not fit together, with every reason
    """
    try:
        if isinstance(table, HousingBase):
            made: Housing = table.made(
                bores=bores(table, layout), feet=feet(table), sensors=sensors, bolted=table.joint is not None
            )
            return made
        if problems := list(seat_problems([seat.name for seat in table.bearings], len(points))):
            raise SceneError(source, problems)
        return _imported(table, points, sensors)
    except (HousingError, InputError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(source, [Problem("casing.housing", line) for line in str(error).splitlines()]) from error


def _imported(table: ImportedTable, points: Sequence[Point], placed: tuple[Sensor, ...]) -> ImportedHousing:
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
            Seat(name=f"bearing_{number}", locator=_seat(seat), shaft_point=point)
            for number, point in enumerate(points, 1)
            for seat in table.bearings
            if seat.name == f"bearing_{number}"
        ),
        grounds=tuple(_ground(ground) for ground in table.grounds),
        sensors=placed,
    )


def seat_problems(given: Sequence[str], bearings: int) -> Iterator[Problem]:
    """What is wrong with the names of the seats given for so many bearings."""
    wanted = [f"bearing_{number}" for number in range(1, bearings + 1)]
    if missing := [name for name in wanted if name not in given]:
        yield Problem(
            "casing.housing.bearings", f"there is no seat for {', '.join(missing)}", "Add a table for every bearing"
        )
    if unknown := [name for name in given if name not in wanted]:
        yield Problem(
            "casing.housing.bearings",
            f"there is no bearing {', '.join(unknown)}; the shafts have {wanted[0]} to {wanted[-1]}",
            "Correct the name, or delete the table",
        )


def _seat(table: SeatTable) -> Locator:
    if table.through_mm is None or table.diameter_mm is None:
        return ByGroup(group=table.group or "")
    return ByCylinder(through=table.si.through, diameter=table.si.diameter, axis=table.axis)


def _ground(table: GroundTable) -> Locator:
    if table.point_mm is not None:
        return ByPoint(point=table.si.point)
    if table.box_mm is not None:
        return ByBox(low=table.si.box[0], high=table.si.box[1])
    if table.through_mm is not None and table.normal is not None:
        return ByPlane(through=table.si.through, normal=table.normal)
    return ByGroup(group=table.group or "")
