"""Parametric gearbox housing: a closed box with bearing bosses in its side walls, six feet and sensor places.

Axes: x across the shafts, y along them (0 at mid width of the box), z up; the origin lies on the axis of shaft 1.
The box is one body: four walls, floor and cover of one thickness. Each boss is a cylinder along y, flush with the
outer face of its side wall and standing into the box; the bore goes through it. Each foot is a square pad under the
floor, flush with a side wall; its underside is a ground face.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np

THINNEST_LIGAMENT = 0.3  # least material between two holes or bosses, or around a bore, in wall thicknesses


class HousingError(ValueError):
    """The dimensions of a housing do not make a sound body."""


@dataclass(frozen=True, kw_only=True)
class Bore:
    """A bearing seat in a side wall (m): axis at (x, z); `side` -1 is the wall at -y, +1 the wall at +y."""

    name: str
    x: float
    z: float = 0.0
    side: int
    diameter: float
    boss_diameter: float
    boss_length: float  # along y, from the outer face of the wall inwards


@dataclass(frozen=True, kw_only=True)
class Feet:
    """Six equal square pads (m) under the floor, three along each side wall; `x` are the middles of the three."""

    x: tuple[float, float, float]
    length: float = 0.060  # side of the square
    height: float = 0.015  # below the underside of the floor


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A sensor at the point of the surface nearest to `position` (m); its axes are the global ones."""

    name: str
    position: tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Housing:
    """The dimensions of a housing (m); `HousingError` lists everything that is wrong with them at once."""

    length: float  # outside, x
    width: float  # outside, y
    height: float  # outside, z, without the feet
    wall_thickness: float
    left: float  # x of the outer face of the wall at -x; negative when shaft 1 lies inside
    axis_height: float  # height of z = 0 above the underside of the floor
    bores: tuple[Bore, ...]
    feet: Feet
    sensors: tuple[Sensor, ...] = ()

    def __post_init__(self) -> None:
        if problems := [*_box_problems(self), *_bore_problems(self), *_foot_problems(self), *_name_problems(self)]:
            raise HousingError("housing: " + "; ".join(problems))

    @property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner (3,) of the outer box."""
        low = np.array([self.left, -self.width / 2, -self.axis_height])
        return low, low + np.array([self.length, self.width, self.height])

    def bore(self, name: str) -> Bore:
        """The bore called `name`; `HousingError` with the known names if absent."""
        for bore in self.bores:
            if bore.name == name:
                return bore
        raise HousingError(f"housing: no bore {name!r}; known: {', '.join(b.name for b in self.bores)}")

    def bore_span(self, bore: Bore) -> tuple[float, float]:
        """y of the two ends of a bore, the lower first."""
        outer = bore.side * self.width / 2
        inner = outer - bore.side * bore.boss_length
        return min(outer, inner), max(outer, inner)

    def bore_centre(self, bore: Bore) -> np.ndarray:
        """Middle of a bore (3,): the bearing point."""
        return np.array([bore.x, sum(self.bore_span(bore)) / 2, bore.z])

    def foot_boxes(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Corners of the six pads; ground_1, 3, 5 at -y and ground_2, 4, 6 at +y, both along x."""
        side, boxes = self.feet.length, {}
        bottom = -self.axis_height - self.feet.height
        for place, x in enumerate(self.feet.x):
            for number, y in ((2 * place + 1, -self.width / 2), (2 * place + 2, self.width / 2 - side)):
                low = np.array([x - side / 2, y, bottom])
                boxes[f"ground_{number}"] = (low, low + np.array([side, side, self.feet.height]))
        return boxes

    def ground_points(self) -> dict[str, np.ndarray]:
        """Middle of the underside of each foot (3,)."""
        return {name: np.array([*(0.5 * (low + high))[:2], low[2]]) for name, (low, high) in self.foot_boxes().items()}

    def with_sensors(self, *names: str) -> Self:
        """The same housing with only the named sensors, in the order asked."""
        known = {sensor.name: sensor for sensor in self.sensors}
        if missing := [name for name in names if name not in known]:
            raise HousingError(f"housing: no sensor {', '.join(missing)}; known: {', '.join(known) or 'none'}")
        return replace(self, sensors=tuple(known[name] for name in names))


def _box_problems(housing: Housing) -> list[str]:
    problems = []
    sizes = {name: getattr(housing, name) for name in ("length", "width", "height", "wall_thickness", "axis_height")}
    for name, value in sizes.items():
        if not (math.isfinite(value) and value > 0.0):
            problems.append(f"{name} is {_mm(value)}; it must be positive")
    if problems:
        return problems
    limit = min(housing.length, housing.width, housing.height) / 2
    if housing.wall_thickness >= limit:
        problems.append(
            f"wall thickness {_mm(housing.wall_thickness)} fills the box (limit {_mm(limit)}, half of its smallest "
            "side); make the walls thinner or the box larger"
        )
    return problems


def _bore_problems(housing: Housing) -> list[str]:
    problems = [] if housing.bores else ["no bores; give one for each bearing"]
    low, high = housing.box
    wall, ligament = housing.wall_thickness, THINNEST_LIGAMENT * housing.wall_thickness
    for bore in housing.bores:
        if bore.side not in (-1, 1):
            problems.append(f"{bore.name}: side is {bore.side}; give -1 (wall at -y) or +1 (wall at +y)")
        if not bore.diameter > 0.0:
            problems.append(f"{bore.name}: bore diameter is {_mm(bore.diameter)}; it must be positive")
        if (ring := (bore.boss_diameter - bore.diameter) / 2) < ligament:
            problems.append(
                f"{bore.name}: boss ring is {_mm(ring)} thick (limit {_mm(ligament)}); enlarge the boss diameter "
                f"{_mm(bore.boss_diameter)} or shrink the bore {_mm(bore.diameter)}"
            )
        if bore.boss_length < wall:
            problems.append(
                f"{bore.name}: boss length {_mm(bore.boss_length)} is less than the wall {_mm(wall)} it contains"
            )
        if bore.boss_length > (limit := housing.width / 2 - wall / 2):
            problems.append(
                f"{bore.name}: boss length {_mm(bore.boss_length)} reaches the opposite boss (limit {_mm(limit)})"
            )
        radius = bore.boss_diameter / 2
        room = min(bore.x - low[0], high[0] - bore.x, bore.z - low[2], high[2] - bore.z) - wall - radius
        if room < 0.0:
            problems.append(
                f"{bore.name}: boss at x = {_mm(bore.x)}, z = {_mm(bore.z)} leaves its side wall by {_mm(-room)}; "
                "enlarge or move the box"
            )
    for i, one in enumerate(housing.bores):
        for two in housing.bores[i + 1 :]:
            if one.side != two.side:
                continue
            gap = math.hypot(one.x - two.x, one.z - two.z) - (one.boss_diameter + two.boss_diameter) / 2
            if gap < ligament:
                what = "overlap by" if gap < 0.0 else "leave a ligament of only"
                problems.append(
                    f"bosses of {one.name} and {two.name} {what} {_mm(abs(gap))} (limit: {_mm(ligament)} apart); "
                    "shrink the bosses or move the shafts apart"
                )
    return problems


def _foot_problems(housing: Housing) -> list[str]:
    problems, feet = [], housing.feet
    for name in ("length", "height"):
        if not getattr(feet, name) > 0.0:
            problems.append(f"foot {name} is {_mm(getattr(feet, name))}; it must be positive")
    if 2 * feet.length >= housing.width:
        problems.append(
            f"feet of {_mm(feet.length)} meet in the middle of the box (limit {_mm(housing.width / 2)}); shorten them"
        )
    ends = sorted((x - feet.length / 2, x + feet.length / 2) for x in feet.x)
    for (_, end), (start, _) in pairwise(ends):
        if start <= end:
            problems.append(f"two feet overlap by {_mm(end - start)} in x; shorten or move them")
    low, high = housing.box
    if ends[0][0] < low[0] - 1e-12 or ends[-1][1] > high[0] + 1e-12:
        problems.append(
            f"feet from x = {_mm(ends[0][0])} to {_mm(ends[-1][1])} leave the box "
            f"({_mm(low[0])} to {_mm(high[0])}); move them inwards"
        )
    return problems


def _name_problems(housing: Housing) -> list[str]:
    names = [b.name for b in housing.bores] + [s.name for s in housing.sensors]
    return [f"the name {n!r} is given {names.count(n)} times" for n in dict.fromkeys(names) if names.count(n) > 1]


def _mm(metres: float) -> str:
    return f"{1000 * metres:.6g} mm"
