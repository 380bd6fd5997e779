"""Collisions: what of the gearbox would run into something else, found before anything is computed.

Everything is a cylinder along y or a flat wall: tip circles against neighbouring shafts, gears, bosses and walls,
shafts against walls.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from pipelines.io.errors import Problem
from pipelines.machine.layout import Layout
from pipelines.scene.scene import Scene
from pipelines.scene.tables.casing import FlexibleBase
from pipelines.scene.tables.housing import HousingBase

_WAYS_OUT = {  # what makes room at a wall
    "left end wall": "Reduce casing.housing.left_end_mm",
    "right end wall": "Raise casing.housing.length_mm",
    "floor": "Raise casing.housing.shaft_height_mm and height_mm",
    "cover": "Raise casing.housing.height_mm",
    "-y side wall": "Raise casing.housing.width_mm",
    "+y side wall": "Raise casing.housing.width_mm",
}


@dataclass(frozen=True)
class Cylinder:
    """A body of revolution about the axis of `shaft`, between two y (m); hollow below the radius `inner`."""

    name: str
    path: str
    shaft: int
    radius: float
    start: float
    end: float
    inner: float = 0.0

    def overlaps(self, other: Cylinder) -> bool:
        """Whether both occupy some of the same y."""
        return self.start < other.end and other.start < self.end

    def encloses(self, other: Cylinder, distance: float) -> bool:
        """Whether another one, its axis at a distance, runs inside the hollow of this one."""
        return distance + other.radius < self.inner


def gears(scene: Scene, layout: Layout) -> list[Cylinder]:
    """Tip cylinders of all gears, pinion and wheel of stage 1 first."""
    found = []
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pairs, strict=True)):
        middle, half = stage.si.position, stage.si.face_width / 2
        places = layout.pair_shafts[number]
        for shaft, gear, name in ((places[0], pair.pinion, "pinion"), (places[1], pair.wheel, "wheel")):
            label = f"tip circle of the stage {number + 1} {name}"
            ends = middle - half, middle + half
            found.append(Cylinder(label, f"stages.{number + 1}", shaft, gear.tip_radius, *ends, gear.bore_radius))
    return found


def shafts(scene: Scene) -> list[Cylinder]:
    """All shaft sections."""
    return [
        Cylinder(
            f"section of shaft {number}",
            f"shafts.{number}",
            number - 1,
            section.si.diameter / 2,
            section.si.start,
            section.si.end,
        )
        for number, shaft in enumerate(scene.shafts, 1)
        for section in shaft.sections
    ]


def bosses(housing: HousingBase) -> list[Cylinder]:
    """Bearing bosses inside both side walls."""
    outer, length = housing.si.width / 2, housing.si.boss_length
    found = []
    for index, diameter in enumerate(housing.si.boss_diameters):
        for number, start in ((2 * index + 1, -outer), (2 * index + 2, outer - length)):
            name = f"boss of bearing {number}"
            found.append(Cylinder(name, "casing.housing.boss_diameters_mm", index, diameter / 2, start, start + length))
    return found


def _clashes(first: list[Cylinder], second: list[Cylinder], layout: Layout) -> Iterator[Problem]:
    for one in first:
        for two in second:
            if one.shaft == two.shaft or not one.overlaps(two):
                continue
            distance = math.dist(layout.axes[one.shaft], layout.axes[two.shaft])
            if distance <= one.radius + two.radius and not one.encloses(two, distance):
                needed = one.radius + two.radius
                yield Problem(
                    one.path,
                    f"the {one.name} (radius {one.radius * 1000:.2f} mm) intersects the {two.name} (radius "
                    f"{two.radius * 1000:.2f} mm): the distance of their axes is {distance * 1000:.2f} mm, more than "
                    f"{needed * 1000:.2f} mm is needed",
                    "Move one of them along the shafts (position_mm), or reduce one of the diameters, "
                    "or turn the stage (direction_deg)",
                )


def _mates(scene: Scene, layout: Layout) -> Iterator[Problem]:
    """Gears that overlap in y and do not mesh, on other shafts or on the same one; a gear may be in several stages."""
    bodies = gears(scene, layout)
    meshing = {frozenset((_body(one), _body(two))) for one, two in zip(bodies[::2], bodies[1::2], strict=True)}
    for i, one in enumerate(bodies):
        for two in bodies[i + 1 :]:
            if _body(one) == _body(two) or frozenset((_body(one), _body(two))) in meshing:
                continue
            if one.shaft == two.shaft and one.overlaps(two):
                yield Problem(
                    two.path,
                    f"the {two.name} and the {one.name} overlap on shaft {one.shaft + 1}",
                    "Correct position_mm of one of the stages",
                )
            yield from _clashes([one], [two], layout)


def _body(gear: Cylinder) -> tuple[int, float, float, float]:
    """What makes a gear the same one in two stages: shaft, tip circle and place."""
    return gear.shaft, round(gear.radius, 9), round(gear.start, 9), round(gear.end, 9)


def _wall_clashes(scene: Scene, layout: Layout, housing: HousingBase) -> Iterator[Problem]:
    box, common = housing.si, housing.si.wall_thickness
    end = box.end_wall_thickness or common
    left = box.left_end + end
    right = box.left_end + box.length - end
    floor = -box.shaft_height + (box.floor_thickness or common)
    cover = box.height - box.shaft_height - (box.cover_thickness or common)
    side = box.width / 2 - (box.side_wall_thickness or common)
    for body in gears(scene, layout):
        x, z = layout.axes[body.shaft]
        rooms = {
            "left end wall": x - body.radius - left,
            "right end wall": right - x - body.radius,
            "floor": z - body.radius - floor,
            "cover": cover - z - body.radius,
            "-y side wall": body.start + side,
            "+y side wall": side - body.end,
        }
        for name, room in rooms.items():
            if room <= 0:
                reach = f"reaches {-room * 1000:.2f} mm into" if room < 0 else "touches"
                yield Problem(
                    body.path,
                    f"the {body.name} {reach} the {name} of the housing",
                    f"{_WAYS_OUT[name]}, or move the gear",
                )
    for number, shaft in enumerate(scene.shafts, 1):
        carried = [
            y
            for place, y in enumerate(shaft.bearing_positions_mm)
            if not (shaft.bearing_supports and shaft.bearing_supports[place] == "ground")
        ]
        for bearing, y in zip((2 * number - 1, 2 * number), carried, strict=True):
            low, high = housing.width_mm / 2 - housing.boss_length_mm, housing.width_mm / 2
            if not low <= abs(y) <= high or (y < 0) != (bearing % 2 == 1):
                sign = "-" if bearing % 2 else "+"
                yield Problem(
                    f"shafts.{number}.bearing_positions_mm",
                    f"bearing {bearing} at y = {y:g} mm is outside its boss, y = {sign}{low:g} to {sign}{high:g} mm",
                    "Move the bearing into the boss, or correct casing.housing.boss_length_mm or width_mm",
                )


def find_collisions(scene: Scene, layout: Layout) -> list[Problem]:
    """Everything that touches what it must not touch."""
    problems = [*_mates(scene, layout), *_clashes(gears(scene, layout), shafts(scene), layout)]
    if isinstance(scene.casing, FlexibleBase) and isinstance(scene.casing.housing, HousingBase):
        housing = scene.casing.housing
        problems += _clashes(gears(scene, layout), bosses(housing), layout)
        problems += _wall_clashes(scene, layout, housing)
    return problems
