"""The bolted joint of a housing, in SI: positions of its bolts and the clamped parts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from fem.casing.geometry.dimensions import Bore, HousingError
from fem.casing.geometry.housing import Housing
from fem.casing.parts.bolted_joint import BoltedJoint
from fem.casing.parts.bolts import Bolt, BoltError
from fem.casing.parts.split_mesh import SplitPlane
from fem.elements.materials import Material
from pipelines.io.errors import Problem, SceneError
from pipelines.scene.tables.housing import CoverJointTable, PlaneJointTable

Point = tuple[float, float, float]


def bolted_joint(table: Any, housing: Housing | None) -> BoltedJoint:
    """The joint of the cover of a parametric housing, or across a plane of one from a file (None).

    Raises
    ------
    SceneError : bolts that do not fit the clamped parts
    """
    try:
        return _across_plane(table) if housing is None else _of_cover(table, housing)
    except (BoltError, HousingError) as error:
        raise SceneError("scene", [Problem("casing.housing.joint", str(error))]) from error


def joint_words(joint: BoltedJoint, material: Material) -> str:
    """Text with number, stiffness and contact diameter of the bolts of a joint."""
    bolt, (along, across) = joint.bolt, joint.stiffness_in(material)
    kind = "tapped" if bolt.tapped else "through"
    return (
        f"{len(joint.places)} {kind} bolts M{1000 * bolt.diameter:g}, each {along / 1e6:.4g} N/um along and "
        f"{across / 1e6:.4g} N/um across its axis, closed from diameter {1000 * bolt.hole:.4g} to "
        f"{1000 * bolt.contact_diameter:.4g} mm"
    )


def _across_plane(table: PlaneJointTable) -> BoltedJoint:
    through, normal = np.array(table.si.through), np.array(table.normal) / np.linalg.norm(table.normal)
    above, beyond = table.si.clamped
    places = np.array(table.si.positions)
    on_plane = places - np.outer((places - through) @ normal, normal)
    return BoltedJoint(
        plane=SplitPlane(through=_point(through), normal=_point(normal)),
        bolt=Bolt.of_size(table.bolt, clamped=(above, beyond), tapped=table.tapped, outer=table.si.outer_diameter),
        places=tuple(_point(place) for place in on_plane),
        stiffness=table.si.stiffness,
    )


def _of_cover(table: CoverJointTable, housing: Housing) -> BoltedJoint:
    flange, z = housing.flange, housing.cover_start
    if flange is None:
        clamped = housing.wall("cover"), housing.height - housing.wall("cover")
    else:
        clamped = flange.height / 2, flange.height / 2
    bolt = Bolt.of_size(table.bolt, clamped=clamped, tapped=flange is None, outer=table.si.outer_diameter)
    if flange is not None and bolt.head > flange.width:
        raise HousingError(
            f"the bolt heads of {1000 * bolt.head:.4g} mm do not fit on the flange of {1000 * flange.width:.4g} mm. "
            "Set a smaller bolt, or raise flange.width_mm"
        )
    places = [*table.si.positions]
    if table.pitch_mm is not None:
        places += cover_bolts(housing, bolt, table.si.pitch)
    return BoltedJoint(
        plane=SplitPlane(through=(0.0, 0.0, z), normal=(0.0, 0.0, 1.0)),
        bolt=bolt,
        places=tuple((x, y, z) for x, y in places),
        stiffness=table.si.stiffness,
    )


def cover_bolts(housing: Housing, bolt: Bolt, pitch: float) -> list[tuple[float, float]]:
    """Places (x, y) of bolts around a cover, at distances of at most `pitch` (m) except across bosses.

    They stand on the middle line of the flange, of the walls where there is no flange: at its corners, evenly in
    between, and next to every boss that interrupts the flange.
    """
    (low, high), flange = housing.box, housing.flange
    inset = np.array([-flange.width / 2] * 2 if flange else [housing.wall("end") / 2, housing.wall("side") / 2])
    start, end = low[:2] + inset, high[:2] - inset
    places = [(x, float(y)) for x in (float(start[0]), float(end[0])) for y in _evenly(start[1], end[1], pitch)]
    for side, y in ((-1, float(start[1])), (1, float(end[1]))):
        bosses = [bore for bore in housing.bores if bore.side == side and _interrupts(housing, bore)]
        for first, last in _free(float(start[0]), float(end[0]), bosses, bolt.head / 2):
            places += [(x, y) for x in _evenly(first, last, pitch)]
    return list(dict.fromkeys((round(x, 9), round(y, 9)) for x, y in places))


def _interrupts(housing: Housing, bore: Bore) -> bool:
    if (flange := housing.flange) is None:
        return False
    return abs(bore.z - flange.split) < (bore.boss_diameter + flange.height) / 2


def _free(start: float, end: float, bosses: list[Bore], margin: float) -> Iterator[tuple[float, float]]:
    """Stretches of a line along x between bosses, the axes of the bolts a margin away from them."""
    at = start
    for bore in sorted(bosses, key=lambda bore: bore.x):
        reach = bore.boss_diameter / 2 + margin
        if bore.x - reach >= at:
            yield at, bore.x - reach
        at = max(at, bore.x + reach)
    if end >= at:
        yield at, end


def _evenly(start: float, end: float, pitch: float) -> list[float]:
    """Places from start to end at distances of at most a pitch; one where there is room for one."""
    if end - start < pitch / 4:
        return [(start + end) / 2]
    return np.linspace(start, end, math.ceil((end - start) / pitch - 1e-9) + 1).tolist()


def _point(values: np.ndarray) -> Point:
    x, y, z = values.tolist()
    return x, y, z
