"""What locates a bearing seat or ground face of an imported housing; `fem.casing.mesh.key_points` finds the place."""

from __future__ import annotations

from dataclasses import dataclass

from fem.options import option

Point = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class ByGroup:
    """A physical group, node set or element set of the file."""

    group: str = option(text="physical group, node set or element set of the file")


@dataclass(frozen=True, kw_only=True)
class ByCylinder:
    """The cylinder of `diameter` about the line along `axis` through `through` (m), the part nearest to that point."""

    through: Point = option(unit="mm", text="a point on the axis of the bore, near the seat")
    diameter: float = option(unit="mm", gt=0, text="diameter of the bore")
    axis: Point = option((0.0, 1.0, 0.0), text="direction of the bore")


@dataclass(frozen=True, kw_only=True)
class ByPoint:
    """The flat face on which a point (m) lies."""

    point: Point = option(unit="mm", text="a point on a flat face, which is the ground face")


@dataclass(frozen=True, kw_only=True)
class ByBox:
    """The part of the surface inside a box (m)."""

    box: tuple[Point, Point] = option(unit="mm", text="lower and upper corner of a box")


@dataclass(frozen=True, kw_only=True)
class ByPlane:
    """The part of the surface in the plane through a point (m) with a normal, divided into its unconnected parts."""

    through: Point = option(unit="mm", text="a point of a plane; every face in it is a ground face")
    normal: Point = option(text="normal of that plane")


Locator = ByGroup | ByCylinder | ByPoint | ByBox | ByPlane
