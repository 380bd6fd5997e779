"""Bearings of a document: places, designations, and the rolling elements where the file has them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pipelines.rexs.document import Document, RexsComponent
from pipelines.rexs.gear_unit import RexsBearing
from pipelines.rexs.part_places import Directions, Frame

KINDS = (
    "rolling_bearing_with_catalog_geometry",
    "rolling_bearing_with_detailed_geometry",
    "concept_bearing",
)
BALLS = ("radial_grooved_ball_bearing", "angular_contact_ball_bearing", "four_point_contact_ball_bearing")


def read_bearings(document: Document, shaft: RexsComponent, place: Frame, scene: Directions) -> list[RexsBearing]:
    """The bearings between a shaft and the casing.

    Parameters
    ----------
    document : the file
    shaft : whose bearings they are
    place : of the shaft
    scene : directions of the scene
    """
    found = []
    for bearing, inner, outer in _seated(document):
        own, side = (inner, "inner") if inner.kind == "shaft" else (outer, "outer")
        if {inner.kind, outer.kind} == {"shaft", "gear_casing"} and own.number_in_file == shaft.number_in_file:
            found.append(_bearing(document, bearing, side, place, scene, scene.sense(shaft, place)))
    return found


def read_between(
    document: Document, order: Mapping[int, int], frames: Mapping[int, Frame], scene: Directions
) -> Iterator[tuple[tuple[int, int], RexsBearing]]:
    """The bearings between two shafts, with the places of these in the order of the power flow.

    Parameters
    ----------
    document : the file
    order : place of each shaft in the order of the power flow, by its number in the file
    frames : of the shafts, by number
    scene : directions of the scene
    """
    for bearing, inner, outer in _seated(document):
        if inner.kind == outer.kind == "shaft":
            place = frames[inner.number_in_file]
            read = _bearing(document, bearing, "inner", place, scene, scene.sense(inner, place))
            yield (order[inner.number_in_file], order[outer.number_in_file]), read


def _seated(document: Document) -> Iterator[tuple[RexsComponent, RexsComponent, RexsComponent]]:
    """Every bearing with what carries its inner and its outer ring."""
    for relation in document.relations:
        bearing = document.components.get(relation.roles.get("assembly", -1))
        if relation.kind != "side" or bearing is None or bearing.kind not in KINDS:
            continue
        inner, outer = document.role(relation, "inner_part"), document.role(relation, "outer_part")
        for other in (inner, outer):
            if other.kind not in ("shaft", "gear_casing"):
                raise bearing.error(f"one ring is on {other.label}; only casing and shafts are read. Leave it out.")
        yield bearing, inner, outer


def _bearing(
    document: Document, bearing: RexsComponent, side: str, place: Frame, scene: Directions, sense: int
) -> RexsBearing:
    axial = bearing.text("axial_force_absorption")
    if sense < 0:
        axial = {"positive": "negative", "negative": "positive"}.get(axial, axial)
    rating = bearing.optional("radial_static_load_rating", "N")
    return RexsBearing(
        label=bearing.label,
        y=scene.along(place, bearing.number(f"u_coordinate_on_shaft_{side}_side", "mm")),
        kind=bearing.text("bearing_type"),
        designation=bearing.text("catalogue_designation") or bearing.text("name"),
        axial=axial,
        radial=bearing.text("radial_force_absorption") != "false",
        inner_diameter=bearing.optional("inner_diameter", "mm"),
        outer_diameter=bearing.optional("outer_diameter", "mm"),
        static_rating=bearing.optional("static_capacity", "N") if rating is None else rating,  # until version 1.0
        radial_stiffness=bearing.optional("radial_stiffness", "N / m"),
        elements=_elements(document, bearing, sense),
    )


def _elements(document: Document, bearing: RexsComponent, sense: int) -> dict[str, Any]:
    """Keys of the rolling elements of a bearing of one row, none where the file does not describe them."""
    rows = document.parts(bearing, "rolling_bearing_row")
    if len(rows) != 1:
        return {}
    row, rolling = rows[0], document.parts(rows[0], "rolling_element")
    count, pitch = row.optional("number_of_rolling_elements"), row.optional("reference_diameter", "mm")
    diameter = rolling[0].optional("diameter_of_rolling_element", "mm") if rolling else None
    if count is None or pitch is None or diameter is None:
        return {}
    towards = math.copysign(sense, -1.0) if row.text("axial_force_absorption_of_row") == "negative" else sense
    length = row.optional("significant_contact_length_inner_ring", "mm")
    length = length or rolling[0].optional("length_of_rolling_element", "mm")
    balls = length is None or bearing.text("bearing_type") in BALLS
    return {
        "kind": "ball" if balls else "roller",
        "elements": round(count),
        "element_diameter_mm": diameter,
        "pitch_diameter_mm": pitch,
        "contact_angle_deg": towards * (row.optional("pressure_angle", "deg") or 0.0),
        **({} if balls else {"roller_length_mm": length}),
    }
