"""Places of the shafts of a scene: where the axes are, how fast and in which sense the shafts turn.

Shaft 1 is the origin. Every stage places its wheel's axis from its pinion's (or the other way), every coupling puts two
shafts on one axis. Where a loop closes, both ways to a shaft must meet.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fem.gears.geometry import GearPair
from pipelines.io.errors import Problem
from pipelines.scene.tables.shafts import CouplingTable
from pipelines.scene.tables.stages import StageTable

MEETING = 1e-5  # m: how close two ways to one axis must come


@dataclass(frozen=True)
class ShaftAxis:
    """Axis (m), lifting sense and speed (over that of shaft 1) of a shaft."""

    x: float
    z: float
    sense: int
    speed: float


@dataclass(frozen=True)
class _Step:
    path: str
    first: int
    second: int
    change: ShaftAxis  # of the second shaft relative to the first

    def back(self) -> _Step:
        one = self.change
        return _Step(self.path, self.second, self.first, ShaftAxis(-one.x, -one.z, one.sense, 1 / one.speed))

    def to(self, place: ShaftAxis) -> ShaftAxis:
        one = self.change
        return ShaftAxis(place.x + one.x, place.z + one.z, place.sense * one.sense, place.speed * one.speed)


def stage_shafts(stages: Sequence[StageTable]) -> list[tuple[int, int]]:
    """Shafts (0-based) of pinion and wheel of every stage; by default stage i couples shafts i and i + 1."""
    return [
        ((stage.pinion_shaft or number) - 1, (stage.wheel_shaft or number + 1) - 1)
        for number, stage in enumerate(stages, 1)
    ]


def shaft_senses(count: int, stages: Sequence[StageTable], couplings: Sequence[CouplingTable]) -> list[int]:
    """Lifting sense of every shaft, +1 about +y as the first: meshes reverse it, couplings keep it; +1 out of reach."""
    found, _ = _walked([*_stage_steps(stages, [0.0] * len(stages)), *_coupling_steps(couplings)])
    return [found[shaft].sense if shaft in found else 1 for shaft in range(count)]


def place_shafts(
    count: int, stages: Sequence[StageTable], pairs: Sequence[GearPair], couplings: Sequence[CouplingTable]
) -> tuple[list[ShaftAxis], list[Problem]]:
    """Places of the shafts, and what contradicts itself: shafts out of reach, loops that do not close.

    Parameters
    ----------
    count : number of shafts
    stages, pairs : tables of the stages, and the gears of each
    couplings : tables of the couplings
    """
    distances = [pair.axis_distance for pair in pairs]
    found, problems = _walked([*_stage_steps(stages, distances), *_coupling_steps(couplings)])
    lost = [str(shaft + 1) for shaft in range(count) if shaft not in found]
    if lost:
        problems.append(
            Problem(
                "shafts",
                f"no stage or coupling connects shaft {', '.join(lost)} to shaft 1",
                "Connect it, or delete it",
            )
        )
    places = [found.get(shaft, ShaftAxis(0.0, 0.0, 1, 1.0)) for shaft in range(count)]
    return places, problems + list(_beside_one_another(places, couplings))


def _beside_one_another(places: Sequence[ShaftAxis], couplings: Sequence[CouplingTable]) -> Iterator[Problem]:
    """Bearings between two shafts that are not on one axis."""
    for number, table in enumerate(couplings, 1):
        one, other = (places[shaft - 1] for shaft in table.shafts)
        off = math.hypot(one.x - other.x, one.z - other.z)
        if not table.turns_both and off > MEETING:
            yield Problem(
                f"couplings.{number}.shafts",
                f"the distance between the axes of shafts {table.shafts[0]} and {table.shafts[1]} is {off * 1000:.3f} "
                "mm; "
                "a coupling or bearing between two shafts needs one common axis",
                "Set other shafts, or correct direction_deg or the profile shifts",
            )


def _walked(waiting: list[_Step]) -> tuple[dict[int, ShaftAxis], list[Problem]]:
    """Places of the shafts in reach of the first, and loops that do not close."""
    found, problems = {0: ShaftAxis(0.0, 0.0, 1, 1.0)}, list[Problem]()
    while ready := next((step for step in waiting if step.first in found or step.second in found), None):
        waiting.remove(ready)
        step = ready if ready.first in found else ready.back()
        place = step.to(found[step.first])
        if step.second in found:
            problems += _loop(ready, place, found[step.second], step.second)
        else:
            found[step.second] = place
    return found, problems


def _stage_steps(stages: Sequence[StageTable], distances: Sequence[float]) -> Iterator[_Step]:
    """From pinion to wheel of every stage, their axes at a distance (m)."""
    for number, (stage, shafts, distance) in enumerate(zip(stages, stage_shafts(stages), distances, strict=True), 1):
        angle, ratio = stage.si.direction, stage.wheel_teeth / stage.pinion_teeth
        x, z = distance * math.cos(angle), distance * math.sin(angle)
        yield _Step(f"stages.{number}", *shafts, ShaftAxis(x, z, -1, 1 / ratio))


def _coupling_steps(couplings: Sequence[CouplingTable]) -> Iterator[_Step]:
    for number, table in enumerate(couplings, 1):
        if table.turns_both:
            one, other = table.shafts
            yield _Step(f"couplings.{number}", one - 1, other - 1, ShaftAxis(0.0, 0.0, 1, 1.0))


def _loop(step: _Step, place: ShaftAxis, known: ShaftAxis, shaft: int) -> Iterator[Problem]:
    """Why a loop of stages and couplings that ends with ``step`` does not close."""
    off = math.hypot(place.x - known.x, place.z - known.z)
    if place.sense != known.sense or abs(place.speed / known.speed - 1) > 1e-9:
        turn = (
            "in the opposite sense" if place.sense != known.sense else f"{place.speed / known.speed:.9g} times as fast"
        )
        yield Problem(
            step.path,
            f"closes a loop that locks: it would turn shaft {shaft + 1} {turn} compared with the rest of the loop",
            "Correct the numbers of teeth so that both paths agree, or delete one part of the loop",
        )
    if off > MEETING:
        yield Problem(
            step.path,
            f"closes a loop whose ends do not meet: the axis of shaft {shaft + 1} is {off * 1000:.3f} mm away from "
            f"its place by the rest of the loop (x {known.x * 1000:.3f}, z {known.z * 1000:.3f} mm)",
            "Correct direction_deg or the profile shifts",
        )
