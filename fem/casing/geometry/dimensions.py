"""Dimensions of a parametric gearbox housing: a closed box with bearing bosses in its walls, feet and sensor places.

Axes: x across the shafts, y along them (0 at mid width of the box), z up; the origin lies on the axis of shaft 1.
Four walls, floor and cover, each with its thickness. Each boss is a cylinder along y, flush with the outer face of its
side wall and standing into the box; the bore goes through it. Feet stand under the floor, flush with a side wall or
beyond it; their undersides, or those of their bolt pads, are the ground faces. Ribs, a flange on the split plane of the
cover and fillets are added on request (`fem.casing.geometry.features`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fem.casing.geometry.features import Feet, Fillets, Flange, Ribs, Walls

Box = tuple[np.ndarray, np.ndarray]  # lower and upper corner (3,), m
GLOBAL_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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
class Sensor:
    """A tri-axial sensor at the point of the surface nearest to `position` (m).

    `axes` are the directions of its three channels in global coordinates, one per row: orthogonal unit vectors, the
    global axes by default.
    """

    name: str
    position: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]] = GLOBAL_AXES

    def __post_init__(self) -> None:
        axes = np.array(self.axes, float)
        if axes.shape != (3, 3) or not np.allclose(axes @ axes.T, np.eye(3), atol=1e-6):
            raise HousingError(
                f"{self.name}: its axes {self.axes} are not three orthogonal unit vectors (limit 1e-6); give their "
                "directions in global coordinates"
            )


@dataclass(frozen=True, kw_only=True)
class Dimensions:
    """The dimensions of a parametric housing (m) and the places that follow from them."""

    length: float  # outside, x
    width: float  # outside, y
    height: float  # outside, z, without the feet
    wall_thickness: float  # of every wall that `walls` does not name
    left: float  # x of the outer face of the wall at -x; negative when shaft 1 lies inside
    axis_height: float  # height of z = 0 above the underside of the floor
    bores: tuple[Bore, ...]
    feet: Feet
    sensors: tuple[Sensor, ...] = ()
    walls: Walls = Walls()
    flange: Flange | None = None
    ribs: Ribs | None = None
    fillets: Fillets = Fillets()
    bolted: bool = False  # cover and lower part are two bodies that touch at `cover_start`

    def wall(self, name: str) -> float:
        """Thickness of the wall "side", "end", "floor" or "cover"."""
        own = getattr(self.walls, name)
        return self.wall_thickness if own is None else own

    @property
    def thinnest_wall(self) -> float:
        """The least of the wall thicknesses."""
        return min(self.wall(name) for name in ("side", "end", "floor", "cover"))

    @property
    def plain(self) -> bool:
        """Whether the body is made of boxes and cylinders that do not run into each other (`rigid.housing_mass`)."""
        return self.flange is None and self.ribs is None and self.fillets == Fillets() and not self.feet.pad_diameter

    @property
    def box(self) -> Box:
        """Lower and upper corner (3,) of the outer box."""
        low = np.array([self.left, -self.width / 2, -self.axis_height])
        return low, low + np.array([self.length, self.width, self.height])

    @property
    def cavity(self) -> Box:
        """Lower and upper corner (3,) of the space inside."""
        low, high = self.box
        end, side = self.wall("end"), self.wall("side")
        return low + [end, side, self.wall("floor")], high - [end, side, self.wall("cover")]

    @property
    def cover_start(self) -> float:
        """z where the cover begins: the split plane of the flange, without one the underside of the top wall."""
        return float(self.cavity[1][2]) if self.flange is None else self.flange.split

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

    def foot_boxes(self) -> dict[str, Box]:
        """Corners of the feet; ground_1, 3, 5, ... at -y and ground_2, 4, 6, ... at +y, both along x."""
        side, over, boxes = self.feet.length, self.feet.overhang, {}
        bottom, outer = -self.axis_height - self.feet.height, self.width / 2
        for place, x in enumerate(self.feet.x):
            for number, low_y, high_y in (
                (2 * place + 1, -outer - over, -outer + side),
                (2 * place + 2, outer - side, outer + over),
            ):
                low = np.array([x - side / 2, low_y, bottom])
                boxes[f"ground_{number}"] = (low, low + np.array([side, high_y - low_y, self.feet.height]))
        return boxes

    def ground_points(self) -> dict[str, np.ndarray]:
        """Middle of the ground face of each foot (3,): the underside of its pad, or its own."""
        points = {}
        for name, (low, high) in self.foot_boxes().items():
            x, y, _ = 0.5 * (low + high)
            if self.feet.pad_diameter and self.feet.overhang:
                y = math.copysign((self.width + self.feet.overhang) / 2, y)
            points[name] = np.array([x, y, low[2] - self.feet.pad_height])
        return points

    def rib_boxes(self) -> dict[str, Box]:
        """Corners of the outstanding parts of all ribs, by what they stand on."""
        if (ribs := self.ribs) is None:
            return {}
        (low, high), half, boxes = self.box, ribs.thickness / 2, {}
        for bore in self.bores:
            y = (high[1], high[1] + ribs.height) if bore.side > 0 else (low[1] - ribs.height, low[1])
            middle = (bore.diameter + bore.boss_diameter) / 4  # radius of the middle of the boss ring
            for number in range(ribs.per_boss):
                offset = (number - (ribs.per_boss - 1) / 2) * bore.boss_diameter / ribs.per_boss
                top = bore.z - math.sqrt(max(middle**2 - offset**2, 0.0))
                corner = np.array([bore.x + offset - half, y[0], low[2]])
                boxes[f"rib {number + 1} under {bore.name}"] = (corner, np.array([corner[0] + 2 * half, y[1], top]))
        for number in range(ribs.end_wall):
            y_mid = low[1] + self.width * (number + 1) / (ribs.end_wall + 1)
            for name, start in (("-x", low[0] - ribs.height), ("+x", high[0])):
                corner = np.array([start, y_mid - half, low[2]])
                boxes[f"rib {number + 1} of the {name} wall"] = (
                    corner,
                    corner + [ribs.height, 2 * half, self.height],
                )
        for number in range(ribs.cover):
            x = low[0] + self.length * (number + 1) / (ribs.cover + 1)
            corner = np.array([x - half, low[1], high[2]])
            boxes[f"rib {number + 1} of the cover"] = (corner, corner + [2 * half, self.width, ribs.height])
        return boxes

    def with_sensors(self, *names: str) -> Self:
        """The same housing with only the named sensors, in the order asked."""
        known = {sensor.name: sensor for sensor in self.sensors}
        if missing := [name for name in names if name not in known]:
            raise HousingError(f"housing: no sensor {', '.join(missing)}; known: {', '.join(known) or 'none'}")
        return replace(self, sensors=tuple(known[name] for name in names))
