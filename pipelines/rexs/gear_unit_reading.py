"""From the components and relations of a document to a gear unit in the order of the power flow."""

from __future__ import annotations

from collections.abc import Iterator

from pipelines.rexs.document import Document, RexsComponent, RexsError
from pipelines.rexs.gear_unit import GearUnit, Note, RexsGear, RexsSection, RexsShaft, RexsStage
from pipelines.rexs.left_out import left_out
from pipelines.rexs.operation import Operation
from pipelines.rexs.part_places import Directions, Frame, directions, frame
from pipelines.rexs.rexs_bearings import read_bearings, read_between

_REFUSED = {  # kinds of components that no scene can hold, and why
    "planetary_stage": "planets and turning carriers are not modelled",
    "planet_carrier": "planets and turning carriers are not modelled",
    "ring_gear": "internal gears are not modelled",
    "bevel_gear": "bevel gears are not modelled: shafts must be parallel",
    "worm_gear": "worm gears are not modelled: shafts must be parallel",
    "switchable_coupling": "units that change gear are not modelled; write the file in one gear",
    "coupling": "couplings between shafts are not read; leave it out and write [[couplings]] into the scene",
    "involute_spline_connection": "splines are not modelled; write both parts as one shaft",
    "hydrodynamic_radial_plain_bearing": "plain bearings are not modelled",
    "slide_bearing": "plain bearings are not modelled",
}


def read_gear_unit(document: Document) -> GearUnit:
    """The gear unit of a document, in its most frequent load case.

    Raises
    ------
    RexsError : what no scene can hold, or what is missing or contradicts itself
    """
    for component in document.components.values():
        if component.kind in _REFUSED:
            raise component.error(f"{_REFUSED[component.kind]}. Only stages of external cylindrical gears are read.")
    carried = _carriers(document)
    frames = {shaft.number_in_file: _frame_of(document, shaft) for shaft in document.of_kind("shaft")}
    scene = directions(next(iter(frames.values())))
    senses = {number: scene.sense(document.components[number], place) for number, place in frames.items()}
    operation = Operation(document, carried, senses)
    scene = scene if operation.sense > 0 else scene.reversed()
    document = operation.document
    order = {shaft.number_in_file: place for place, shaft in enumerate(operation.shafts)}
    gears = {
        number: _gear(document, document.components[number], frames[shaft], scene) for number, shaft in carried.items()
    }
    return GearUnit(
        source=document.source,
        written_by=document.written_by,
        version=document.version,
        shafts=tuple(_shaft(document, shaft, frames[shaft.number_in_file], scene) for shaft in operation.shafts),
        stages=tuple(
            RexsStage(
                label=stage.label,
                shafts=(order[carried[pinion.number_in_file]], order[carried[wheel.number_in_file]]),
                pinion=gears[pinion.number_in_file],
                wheel=gears[wheel.number_in_file],
                centre_distance=stage.number("center_distance", "mm"),
            )
            for stage, (pinion, wheel) in operation.stages
        ),
        between=tuple(read_between(document, order, frames, scene)),
        output=order[operation.output.number_in_file],
        output_y=_output_place(operation, frames, scene),
        load_case=operation.load_case,
        other_cases=operation.other_cases,
        notes=(*operation.notes, *_guessed_places(document), *left_out(document)),
    )


def _carriers(document: Document) -> dict[int, int]:
    """The shaft that carries each cylindrical gear, by numbers of the file."""
    shafts = document.of_kind("shaft")
    found = {
        gear.number_in_file: shaft.number_in_file
        for shaft in shafts
        for gear in document.parts(shaft, "cylindrical_gear")
    }
    for gear in document.of_kind("cylindrical_gear"):
        if gear.number_in_file not in found:
            raise gear.error("no shaft carries it. Add the relation assembly of a shaft and this gear.")
    if len(shafts) < 2 or not found:
        raise RexsError(f"{document.source}: has no cylindrical gears on two shafts. Give a file of a gear unit.")
    return found


def _guessed_places(document: Document) -> Iterator[Note]:
    for gear in document.of_kind("cylindrical_gear"):
        if frame(document, gear) is None:
            value = f"{gear.number('u_coordinate_on_shaft', 'mm'):g} mm"
            reason = "taken as its mid face: it has no support_vector, and programs differ in what they write there"
            yield Note("assumed", f"{gear.label} u_coordinate_on_shaft", value, reason)


def _frame_of(document: Document, shaft: RexsComponent) -> Frame:
    place = frame(document, shaft)
    if place is None:
        raise shaft.error("has no place: support_vector, u_axis_vector and w_axis_vector are missing. Add them.")
    return place


def _shaft(document: Document, shaft: RexsComponent, place: Frame, scene: Directions) -> RexsShaft:
    x, z = scene.across(place)
    bearings = read_bearings(document, shaft, place, scene)
    return RexsShaft(
        label=shaft.label,
        x=x,
        z=z,
        sections=tuple(sorted(_sections(document, shaft, place, scene), key=lambda section: section.start)),
        bearings=tuple(sorted(bearings, key=lambda bearing: bearing.y)),
        material=_material(document, shaft),
    )


def _sections(document: Document, shaft: RexsComponent, place: Frame, scene: Directions) -> Iterator[RexsSection]:
    sections = document.parts(shaft, "shaft_section")
    if not sections:
        raise shaft.error("has no sections. Give its shaft_section parts.")
    for section in sections:
        start = section.number("u_coordinate_on_shaft", "mm")
        ends = scene.along(place, start), scene.along(place, start + section.number("length", "mm"))
        outer, inner = (
            (section.number(f"{side}_diameter_begin", "mm"), section.number(f"{side}_diameter_end", "mm"))
            for side in ("outer", "inner")
        )
        if ends[0] > ends[1]:
            ends, outer, inner = ends[::-1], outer[::-1], inner[::-1]
        yield RexsSection(start=ends[0], end=ends[1], outer=outer, inner=inner)


def _material(document: Document, shaft: RexsComponent) -> dict[str, float]:
    for relation in document.relations:
        if relation.kind == "reference" and relation.roles.get("origin") == shaft.number_in_file:
            material = document.components.get(relation.roles.get("referenced", -1))
            if material is not None and material.kind == "material":
                return {
                    "elastic_modulus_GPa": material.number("elastic_modulus", "N / mm^2") / 1000,
                    "poisson_ratio": material.number("poisson_ratio"),
                    "density_kg_m3": 1000 * material.number("density", "kg / dm^3"),
                }
    return {}


def _gear(document: Document, gear: RexsComponent, shaft: Frame, scene: Directions) -> RexsGear:
    place = frame(document, gear)
    own = gear.optional("u_coordinate_on_shaft", "mm")
    if place is None and own is None:
        raise gear.error("has no place: neither support_vector nor u_coordinate_on_shaft. Give one.")
    middle = scene.along(place) if place is not None else scene.along(shaft, own or 0.0)
    width = gear.number("face_width", "mm")
    flank = _flank(document, gear)
    module = gear.number("normal_module", "mm")
    edge = flank.optional("tool_edge_radius", "mm")
    grade = gear.optional("tolerance_class_according_to_iso_1328_2013")
    return RexsGear(
        label=gear.label,
        teeth=round(gear.number("number_of_teeth")),
        module=module,
        helix=gear.number("helix_angle_reference_diameter", "deg"),
        pressure_angle=flank.number("normal_pressure_angle", "deg"),
        profile_shift=flank.number("addendum_modification_coefficient"),
        start=middle - width / 2,
        end=middle + width / 2,
        tip_diameter=gear.optional("tip_diameter", "mm"),
        root_diameter=gear.optional("root_diameter", "mm"),
        addendum=flank.optional("addendum_coefficient_basic_profile"),
        tip_radius=None if edge is None else edge / module,
        grade=None if grade is None else round(grade),
    )


def _flank(document: Document, gear: RexsComponent) -> RexsComponent:
    """The flank that stands for both: they must agree in pressure angle and profile shift."""
    for relation in document.relations:
        if relation.kind == "flank" and relation.roles.get("gear") == gear.number_in_file:
            left, right = document.role(relation, "left"), document.role(relation, "right")
            for key, unit in (("normal_pressure_angle", "deg"), ("addendum_modification_coefficient", "none")):
                one, other = left.number(key, unit), right.number(key, unit)
                if one != other:
                    raise gear.error(
                        f"{key} is {one:g} on the left flank and {other:g} on the right one; a scene has one value. "
                        "Write both alike."
                    )
            return left
    raise gear.error("has no flanks. Add the relation flank with the flanks left and right.")


def _output_place(operation: Operation, frames: dict[int, Frame], scene: Directions) -> float | None:
    if operation.output_load is None:
        return None
    place = operation.output_load.optional("u_coordinate_on_shaft", "mm")
    return None if place is None else scene.along(frames[operation.output.number_in_file], place)
