"""Dimensions of a parametric gearbox housing: a closed box with bearing bosses in its walls, feet and sensors.

Axes: x across the shafts, y along them (0 at mid width of the box), z up; the origin lies on the axis of shaft 1.
Four walls, floor and cover, each with its thickness. Each boss is a cylinder along y, flush with the outer face of its
side wall and protruding into the box; the bore passes through it. Feet are under the floor, flush with a side wall or
beyond it; their undersides, or those of their bolt pads, are the ground faces. Ribs, a flange on the split plane of the
cover and fillets are added on request (`fem.casing.geometry.housing_features`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.casing.geometry.housing_features import LARGEST, Feet, Fillets, Flange, Ribs, Walls
from fem.options import inline, option

Box = tuple[np.ndarray, np.ndarray]  # lower and upper corner (3,), m
Vector = tuple[float, float, float]
Axes = tuple[Vector, Vector, Vector]
SKEW = 1e-3  # largest cosine between two axes of a sensor or a file, which are then made orthogonal
GLOBAL_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class HousingError(ValueError):
    """The dimensions of a housing do not form a valid body."""


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
    """A triaxial accelerometer on the casing.

    The axes are scaled to unit length. HousingError for axes that are not orthogonal.
    """

    name: str = option(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,39}$", text="up to 40 letters, digits, _ and -")
    position: Vector = option(
        unit="mm", text="x, y, z of the sensor, which is moved to the nearest point of the surface"
    )
    axes: Axes = option(GLOBAL_AXES, text="directions of its channels x, y, z in the coordinate system of the scene")

    def __post_init__(self) -> None:
        object.__setattr__(self, "axes", orthonormal(self.axes))


def orthonormal(axes: Axes) -> Axes:
    """Three directions with unit length. HousingError unless they are orthogonal."""
    rows = np.array(axes, float)
    given = f"axes = {rows.tolist()}"
    sizes = np.linalg.norm(rows, axis=-1)
    if rows.shape != (3, 3) or not sizes.all():
        raise HousingError(f"{given}: not three directions. Set three orthogonal directions")
    rows = rows / sizes[:, None]
    skew = np.abs(rows @ rows.T - np.eye(3)).max()
    if skew > SKEW:
        raise HousingError(f"{given}: they are not orthogonal (cosine {skew:.3g}, limit {SKEW:g}). Correct one of them")
    u, _, v = np.linalg.svd(rows)
    first, second, third = np.where(np.abs(rows - u @ v) < 1e-12, rows, u @ v).tolist()
    return tuple(first), tuple(second), tuple(third)


@dataclass(frozen=True, kw_only=True)
class Dimensions:
    """The dimensions of a parametric housing (m) and the positions that follow from them."""

    length: float = option(unit="mm", gt=0, le=LARGEST, text="outer length along x")
    width: float = option(unit="mm", gt=0, le=LARGEST, text="outer width along y; the middle is y = 0")
    height: float = option(unit="mm", gt=0, le=LARGEST, text="outer height along z without feet")
    wall_thickness: float = option(unit="mm", gt=0, le=LARGEST, text="thickness of all walls, floor and cover")
    walls: Walls = inline(Walls())
    left: float = option(
        unit="mm",
        key="left_end_mm",
        ge=-LARGEST,
        le=LARGEST,
        text="x of the outer face of the left end wall; shaft 1 is at x = 0",
    )
    axis_height: float = option(
        unit="mm",
        key="shaft_height_mm",
        gt=0,
        le=LARGEST,
        text="height of shaft 1 over the underside of the floor",
    )
    bores: tuple[Bore, ...]
    feet: Feet = inline()
    sensors: tuple[Sensor, ...] = ()
    flange: Flange | None = option(None, text="flange at the split plane; without it: none")
    ribs: Ribs | None = option(None, text="ribs; without it: none")
    fillets: Fillets = inline(Fillets())
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
        """Whether the body consists of boxes and cylinders that do not intersect (`rigid.housing_mass`)."""
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
        """z where the cover begins: split plane of the flange or, without a flange, underside of the top wall."""
        return float(self.cavity[1][2]) if self.flange is None else self.flange.split

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
        """Corners of the protruding parts of all ribs, by the part that carries them."""
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
