"""The housing of a scene, in SI: parametric, bores where the shafts are, or from a file, whose bores must be there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from fem.casing.geometry.dimensions import Bore, HousingError, Sensor
from fem.casing.geometry.features import Feet, Fillets, Walls
from fem.casing.geometry.housing import Housing
from fem.casing.meshing.imported import ImportedHousing, Seat, content_hash
from fem.casing.meshing.locate import ByBox, ByCylinder, ByGroup, ByPlane, ByPoint, Locator, Point
from fem.casing.meshing.source import Geometry
from pipelines.border.errors import InputError, Problem, SceneError
from pipelines.plant.layout import Layout
from pipelines.scene.shipped_files import find_file
from pipelines.scene.tables.casing import SensorTable
from pipelines.scene.tables.housing import GroundTable, HousingTable, ImportedTable, SeatTable

END_DISTANCE = 0.05  # from the end of the box to the outer feet, in lengths of the box
_SKEW = 1e-3  # largest cosine between two axes of a sensor or a file, which are then made orthogonal


def bores(table: HousingTable, layout: Layout) -> tuple[Bore, ...]:
    """Two bores per shaft, odd numbers in the wall at -y."""
    return tuple(
        Bore(
            name=f"bearing_{2 * number + (1 if side < 0 else 2)}",
            x=x,
            z=z,
            side=side,
            diameter=bore / 1000,
            boss_diameter=boss / 1000,
            boss_length=table.si.boss_length,
        )
        for number, ((x, z), bore, boss) in enumerate(
            zip(layout.axes, table.bore_diameters_mm, table.boss_diameters_mm, strict=True)
        )
        for side in (-1, 1)
    )


def feet(table: HousingTable) -> Feet:
    """Feet evenly spread between the ends of the box: three a side, or as many as their largest distance asks for."""
    length, left, side = table.si.length, table.si.left_end, table.si.foot_length
    first, last = left + END_DISTANCE * length + side / 2, left + (1 - END_DISTANCE) * length - side / 2
    if table.foot_pitch_mm is None:
        places = (first, (first + last) / 2, last)
    else:
        count = max(2, math.ceil((last - first) / (table.si.foot_pitch) - 1e-9) + 1)
        places = tuple(np.linspace(first, last, count).tolist())
    return Feet(
        x=places,
        length=side,
        height=table.si.foot_height,
        overhang=table.si.foot_overhang,
        pad_diameter=table.si.pad_diameter,
        pad_height=table.si.pad_height,
        bolt_diameter=table.si.bolt_diameter,
    )


def housing(
    table: HousingTable | ImportedTable,
    on_it: Sequence[SensorTable],
    layout: Layout,
    points: Sequence[Point],
    source: str = "scene",
) -> Geometry:
    """The housing with the sensors on it.

    Parameters
    ----------
    table : of the housing
    on_it : tables of the sensors
    layout : where the shafts are
    points : (x, y, z) of the bearings that it carries, m
    source : of the scene, for messages

    Raises
    ------
    SceneError : its parts do not fit together, with every reason
    """
    try:
        placed = sensors(on_it)
        if isinstance(table, HousingTable):
            return _parametric(table, layout, placed)
        if problems := list(seat_problems([seat.name for seat in table.bearings], len(points))):
            raise SceneError(source, problems)
        return _imported(table, points, placed)
    except (HousingError, InputError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(source, [Problem("casing.housing", line) for line in str(error).splitlines()]) from error


def sensors(tables: Sequence[SensorTable]) -> tuple[Sensor, ...]:
    """Sensors in SI; their axes get unit length."""
    return tuple(
        Sensor(name=table.name, position=_metres(table.position_mm), axes=_frame(table.name, table.axes))
        for table in tables
    )


def _parametric(table: HousingTable, layout: Layout, placed: tuple[Sensor, ...]) -> Housing:
    return Housing(
        length=table.si.length,
        width=table.si.width,
        height=table.si.height,
        wall_thickness=table.si.wall_thickness,
        left=table.si.left_end,
        axis_height=table.si.shaft_height,
        bores=bores(table, layout),
        feet=feet(table),
        sensors=placed,
        walls=Walls(
            side=_optional(table.side_wall_thickness_mm),
            end=_optional(table.end_wall_thickness_mm),
            floor=_optional(table.floor_thickness_mm),
            cover=_optional(table.cover_thickness_mm),
        ),
        flange=table.flange and table.flange.made(),
        ribs=table.ribs and table.ribs.made(),
        fillets=Fillets(foot=table.si.foot_fillet, inner=table.si.inner_fillet),
        bolted=table.joint is not None,
    )


def _imported(table: ImportedTable, points: Sequence[Point], placed: tuple[Sensor, ...]) -> ImportedHousing:
    path = find_file(table.file)
    return ImportedHousing(
        path=str(path),
        sha256=content_hash(path),
        unit=table.unit,
        upgrade=getattr(table, "upgrade", False),
        solids=getattr(table, "solids", ()),
        glue=getattr(table, "glue", False),
        origin=_metres(table.origin_mm),
        axes=_frame("casing.housing.axes", table.axes),
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
    return ByCylinder(through=_metres(table.through_mm), diameter=table.si.diameter, axis=table.axis)


def _ground(table: GroundTable) -> Locator:
    if table.point_mm is not None:
        return ByPoint(point=_metres(table.point_mm))
    if table.box_mm is not None:
        return ByBox(low=_metres(table.box_mm[0]), high=_metres(table.box_mm[1]))
    if table.through_mm is not None and table.normal is not None:
        return ByPlane(through=_metres(table.through_mm), normal=table.normal)
    return ByGroup(group=table.group or "")


def _frame(name: str, axes: tuple[Point, Point, Point]) -> tuple[Point, Point, Point]:
    """Three directions as orthonormal rows; HousingError if they are not near to orthogonal."""
    rows = np.array(axes, float)
    sizes = np.linalg.norm(rows, axis=1)
    if not sizes.all():
        raise HousingError(f"{name}: one of {axes} is no direction. Set three orthogonal directions")
    rows = rows / sizes[:, None]
    skew = np.abs(rows @ rows.T - np.eye(3)).max()
    if skew > _SKEW:
        raise HousingError(
            f"{name}: the axes {axes} are not orthogonal (cosine {skew:.3g}, limit {_SKEW:g}). Correct one of them"
        )
    u, _, v = np.linalg.svd(rows)
    first, second, third = np.where(np.abs(rows - u @ v) < 1e-12, rows, u @ v).tolist()
    return tuple(first), tuple(second), tuple(third)


def _metres(point: tuple[float, float, float]) -> Point:
    return point[0] / 1000, point[1] / 1000, point[2] / 1000


def _optional(value: float | None) -> float | None:
    return None if value is None else value / 1000
