"""The table [casing.housing] of a scene for a file, and the changes that align the shafts with their bearing seats."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fem.casing.mesh.imported_housing import CAD_SUFFIXES, OFF_AXIS
from fem.casing.recognition.housing_contents import FlatFace, GeometryContents
from fem.casing.recognition.shaft_fit import ShaftFit
from fem.casing.reduced.attachment import FARTHEST_SENSOR
from fem.elements.facets import nearest_on_facets
from mbd.parts.coordinate_layout import BEARING_PLACE_TOLERANCE
from pipelines.io.toml_text import format_value
from pipelines.scene.scene import Scene

_DOWN, _SLOPING = -0.9998, -0.8  # upper limit of the z component of the normal of a face on the ground
_NOT_SMALL = 0.002  # of the area of the largest flat face: lower limit for all faces in the plane of the feet together
_LEVEL = 1e-4  # m, tolerance of the height of faces in one plane


def housing_block(contents: GeometryContents, file: str, suffix: str, fit: ShaftFit, scene: Scene) -> str:
    """TOML text of the table; comments above it list the changes that the scene needs.

    Parameters
    ----------
    contents, file, suffix : contents of the file, its name for the scene, and its suffix
    fit : position of the housing in the frame of the scene
    scene : the scene with the shafts
    """
    lines = [f"# {words}" for words in (*changes(fit, scene), *_far_sensors(contents, fit, scene))]
    model = "step" if suffix in CAD_SUFFIXES else "mesh"
    lines += ["[casing.housing]", f'model = "{model}"', f"file = {format_value(file)}", f'unit = "{contents.unit}"']
    if model == "step" and len(contents.solids) > 1:
        chosen = seat_solids(contents, fit)
        lines.append(f"solids = {chosen}")
        lines += ["glue = true"] if len(chosen) > 1 else []
    origin = [_round(1000 * value, 4) for value in fit.origin]
    axes = [[_round(value, 9) for value in row] for row in fit.axes]
    lines.append(f"origin_mm = {origin}")
    if not np.allclose(axes, np.eye(3), atol=1e-9):
        lines.append(f"axes = {axes}")
    lines.append("bearings = [")
    for seat in fit.seats:
        x, y, z = (_round(1000 * value, 4) for value in fit.placed(seat.bore.centre))
        diameter = _round(1000 * seat.bore.diameter, 4)
        lines.append(f'  {{ name = "{seat.bearing}", through_mm = [{x}, {y}, {z}], diameter_mm = {diameter} }},')
    lines.append("]")
    lines += _grounds(contents, fit)
    return "\n".join([*lines, ""])


def seat_solids(contents: GeometryContents, fit: ShaftFit) -> list[int]:
    """Numbers of the solids with bearing seats, and of all solids in contact with them."""
    parts = {contents.solids[seat.bore.solid - 1].part for seat in fit.seats}
    return [solid.number for solid in contents.solids if solid.part in parts]


def changes(fit: ShaftFit, scene: Scene) -> Iterator[str]:
    """Changes of the scene that move its bearings to the seats."""
    off = {seat.shaft: seat.off for seat in fit.seats if seat.off > OFF_AXIS}
    for shaft, distance in off.items():
        yield (
            f"shaft {shaft + 1} is {1000 * distance:.3g} mm from the axis of its seats (limit {1000 * OFF_AXIS:g} mm): "
            f"set centre_distance_mm and direction_deg of its stage, below"
        )
    if off:
        at = {seat.shaft: fit.placed(seat.bore.centre) for seat in fit.seats}
        for one, two in zip(sorted(at), sorted(at)[1:], strict=False):
            x, _, z = at[two] - at[one]
            yield (
                f"  shafts {one + 1} and {two + 1}: distance of the seats {1000 * np.hypot(x, z):.4f} mm, at "
                f"{np.degrees(np.arctan2(z, x)):.4f} deg"
            )
    missing = sum(len(shaft.bearing_positions_mm) for shaft in scene.shafts) - len(fit.seats)
    for number, table in enumerate(scene.shafts):
        seats = [seat for seat in fit.seats if seat.shaft == number]
        moved = [seat for seat in seats if abs(seat.middle - seat.y) > BEARING_PLACE_TOLERANCE]
        if moved and len(seats) == len(table.bearing_positions_mm):
            places = [_round(1000 * seat.middle, 4) for seat in seats]
            yield f"shaft {number + 1}: set bearing_positions_mm = {places}, the middles of its seats"
    if missing > 0:
        yield f"{missing} bearings of the scene have no bore: move them, or support them on the ground"


def _far_sensors(contents: GeometryContents, fit: ShaftFit, scene: Scene) -> Iterator[str]:
    """Messages on sensors that are not on the housing, each with the nearest position on it."""
    chosen = np.isin(contents.solid, seat_solids(contents, fit))
    triangles = contents.triangles[chosen]
    places = fit.placed(contents.points)
    for sensor in scene.sensors:
        position = np.array(sensor.si.position)
        on = np.einsum("fa,fad->fd", nearest_on_facets(places, triangles, position), places[triangles])
        distance = np.linalg.norm(on - position, axis=1)
        nearest = int(distance.argmin())
        if distance[nearest] > FARTHEST_SENSOR:
            yield (
                f"sensor {sensor.name} is {1000 * distance[nearest]:.3g} mm away from the housing (limit "
                f"{1000 * FARTHEST_SENSOR:g} mm): set position_mm = {[_round(1000 * x, 1) for x in on[nearest]]}"
            )


def _grounds(contents: GeometryContents, fit: ShaftFit) -> list[str]:
    """TOML lines of the ground: the lowest flat face that points down (-z), else the largest face, to be corrected."""
    chosen = set(seat_solids(contents, fit))
    flats = [flat for flat in contents.flats if flat.solid in chosen]
    if not flats:
        return ["# no flat face was found: give the faces that are fixed to the ground", "grounds = []"]
    for least, remark in ((_DOWN, ""), (_SLOPING, "# no flat face looks down (-z), this one slopes\n")):
        down = sorted(
            (float(fit.placed(one.centre)[2]), one.number, one) for one in flats if (one.normal @ fit.axes)[2] < least
        )
        for level, _, one in down:
            area = sum(other.area for height, _, other in down if abs(height - level) < _LEVEL)
            if area > _NOT_SMALL * flats[0].area:
                return [f"{remark}grounds = [{_plane(one, fit)}]   # every flat face in this plane"]
    return [
        f"# no flat face looks down: the largest one, face {flats[0].number}, is given; correct it",
        f"grounds = [{_plane(flats[0], fit)}]",
    ]


def _plane(flat: FlatFace, fit: ShaftFit) -> str:
    place = [_round(1000 * value, 4) for value in fit.placed(flat.centre)]
    normal = [_round(value, 9) for value in flat.normal @ fit.axes]
    return f"{{ through_mm = {place}, normal = {normal} }}"


def _round(value: float, digits: int) -> float:
    return round(float(value), digits) + 0.0
