"""Collisions of gears, shafts, bearing bosses and walls, and sensors far outside the housing.

All parts are cylinders along y or flat walls. Tip circles are checked against other shafts, gears, bosses and walls,
shafts against walls.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fem.casing.geometry.dimensions import Dimensions
from pipelines.io.errors import Problem
from pipelines.machine.layout import TrainLayout
from pipelines.machine.machine_model import Drivetrain
from pipelines.machine.scene_casing import dimensions
from pipelines.scene.scene import Scene

FARTHEST_SENSOR = 50.0  # mm; a sensor farther from the housing is an error of the scene
_WAYS_OUT = {  # what makes room at a wall
    "left end wall": "Reduce casing.housing.left_end_mm",
    "right end wall": "Raise casing.housing.length_mm",
    "floor": "Raise casing.housing.shaft_height_mm and height_mm",
    "cover": "Raise casing.housing.height_mm",
    "-y side wall": "Raise casing.housing.width_mm",
    "+y side wall": "Raise casing.housing.width_mm",
}


@dataclass(frozen=True)
class RevolvedBody:
    """A body of revolution about the axis of `shaft`, between two y (m); hollow below the radius `inner`."""

    name: str
    path: str
    shaft: int
    radius: float
    start: float
    end: float
    inner: float = 0.0

    def overlaps(self, other: RevolvedBody) -> bool:
        """Whether the ranges of y of both overlap."""
        return self.start < other.end and other.start < self.end

    def encloses(self, other: RevolvedBody, distance: float) -> bool:
        """Whether another cylinder, whose axis has a distance (m), is inside the bore of this one."""
        return distance + other.radius < self.inner


def gears(scene: Scene, layout: TrainLayout) -> list[RevolvedBody]:
    """Tip cylinders of all gears, pinion and wheel of stage 1 first."""
    return [
        RevolvedBody(
            f"tip circle of the stage {number} {name}",
            f"stages.{number}",
            shaft,
            gear.tip_radius,
            stage.si.position - stage.si.face_width / 2,
            stage.si.position + stage.si.face_width / 2,
            gear.bore_radius,
        )
        for number, (stage, pair, on) in enumerate(zip(scene.stages, layout.pairs, layout.pair_shafts, strict=True), 1)
        for shaft, gear, name in ((on[0], pair.pinion, "pinion"), (on[1], pair.wheel, "wheel"))
    ]


def shafts(scene: Scene) -> list[RevolvedBody]:
    """All shaft sections."""
    return [
        RevolvedBody(
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


def bosses(housing: Dimensions) -> list[RevolvedBody]:
    """Bearing bosses inside both side walls."""
    key = "casing.housing.boss_diameters_mm"
    return [
        RevolvedBody(
            f"boss of bearing {number}", key, (number - 1) // 2, bore.boss_diameter / 2, *housing.bore_span(bore)
        )
        for number, bore in enumerate(housing.bores, 1)
    ]


def _clashes(first: list[RevolvedBody], second: list[RevolvedBody], layout: TrainLayout) -> Iterator[Problem]:
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
                    f"{two.radius * 1000:.2f} mm): the distance of their axes is {distance * 1000:.2f} mm and must be "
                    f"more than {needed * 1000:.2f} mm",
                    "Move one of them along the shafts (position_mm), or reduce one of the diameters. "
                    "If they are in different stages, direction_deg of a stage also changes the distance",
                )


def _mates(bodies: list[RevolvedBody], layout: TrainLayout) -> Iterator[Problem]:
    """Pairs of gears that overlap in y and do not mesh, on two shafts or on one; a gear may be in several stages."""
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


def _body(gear: RevolvedBody) -> tuple[int, float, float, float]:
    """Shaft, tip circle and place, by which a gear in two stages is recognised."""
    return gear.shaft, round(gear.radius, 9), round(gear.start, 9), round(gear.end, 9)


def _wall_clashes(scene: Scene, layout: TrainLayout, housing: Dimensions) -> Iterator[Problem]:
    (left, front, floor), (right, back, cover) = (corner.tolist() for corner in housing.cavity)
    if left >= right or front >= back or floor >= cover:
        return  # the walls fill the box, which the checks of the housing report
    for body in gears(scene, layout):
        x, z = layout.axes[body.shaft]
        rooms = {
            "left end wall": x - body.radius - left,
            "right end wall": right - x - body.radius,
            "floor": z - body.radius - floor,
            "cover": cover - z - body.radius,
            "-y side wall": body.start - front,
            "+y side wall": back - body.end,
        }
        for name, room in rooms.items():
            if room <= 0:
                reach = f"reaches {-room * 1000:.2f} mm beyond" if room < 0 else "touches"
                yield Problem(
                    body.path,
                    f"the {body.name} {reach} the inner face of the {name} of the housing",
                    f"{_WAYS_OUT[name]}, or move the gear",
                )


def find_collisions(scene: Scene, train: Drivetrain) -> list[Problem]:
    """All collisions, and sensors far outside the housing."""
    layout, bodies = train.layout, gears(scene, train.layout)
    problems = [*_mates(bodies, layout), *_clashes(bodies, shafts(scene), layout)]
    if scene.parametric is not None:
        housing = dimensions(scene.parametric, layout)
        problems += [*_clashes(bodies, bosses(housing), layout), *_wall_clashes(scene, layout, housing)]
        problems += _far_sensors(scene, housing)
    return problems


def _far_sensors(scene: Scene, housing: Dimensions) -> Iterator[Problem]:
    """Sensors outside the box around the housing and its feet by more than the limit."""
    low, high = (1000 * corner for corner in housing.box)
    low[2] -= 1000 * (housing.feet.height + housing.feet.pad_height)
    for number, sensor in enumerate(scene.sensors, 1):
        distance = math.dist(sensor.position_mm, np.clip(sensor.position_mm, low, high))
        if distance > FARTHEST_SENSOR:
            x, y, z = (f"{start:g} to {end:g}" for start, end in zip(low, high, strict=True))
            yield Problem(
                f"sensors.{number}.position_mm",
                f"{sensor.name} is {distance:.0f} mm outside the housing; the limit is {FARTHEST_SENSOR:.0f} mm",
                f"Set a place near the housing, x {x}, y {y}, z {z} mm.",
            )
