"""Contents of a document that a scene omits: parts, forces, attributes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from pipelines.io.shown_text import number_of, shown
from pipelines.rexs.document import Document
from pipelines.rexs.gear_unit import Note

_PARTS = {  # kinds that are read, or that only connect others
    *("gear_unit", "gear_casing", "shaft", "shaft_section", "cylindrical_gear", "cylindrical_stage", "external_load"),
    *("flank_geometry", "cylindrical_gear_flank", "stage_gear_data", "cylindrical_stage_gear_data", "material"),
    *("rolling_bearing_with_catalog_geometry", "rolling_bearing_with_detailed_geometry", "concept_bearing"),
    *("rolling_bearing_row", "rolling_element"),
}
_FORCES = {  # of external loads, in addition to the torque about the axis
    "force_u_direction": "N",
    "force_v_direction": "N",
    "force_w_direction": "N",
    "torque_around_v_axis": "N m",
    "torque_around_w_axis": "N m",
}
_ATTRIBUTES = {  # that change the motion of a unit, and are not read
    "lower_backlash_allowance_referenced_to_span",
    "upper_backlash_allowance_referenced_to_span",
    "minimum_transverse_backlash",
    "maximum_transverse_backlash",
    "din_3967_deviation_tolerance_series",
    "tooth_thickness_deviation_tolerance_series_din_3967_1978",
    "tooth_tip_chamfer",
    "inner_diameter_of_gear_body",
    "preload_distance",
    "preload_force",
    "radial_backlash",
    "radial_bearing_clearance",
    "bending_stiffness",
    "axial_stiffness",
    "mass_of_component",
    "misalignment_in_v_direction",
    "misalignment_in_w_direction",
    "angular_misalignment_around_v_axis",
    "angular_misalignment_around_w_axis",
}


def left_out(document: Document) -> Iterator[Note]:
    """Notes on omitted forces on shafts, parts, and values of parts that are read, if they influence the motion."""
    for load in document.of_kind("external_load"):
        for key, unit in _FORCES.items():
            if value := load.optional(key, unit):
                yield Note("left out", f"{load.label} {key}", f"{value:g} {unit}", "not read")
    counts = Counter(component.kind for component in document.components.values() if component.kind not in _PARTS)
    for kind, count in sorted(counts.items()):
        yield Note("left out", shown(kind), "", f"not read ({_times(count)})")
    values = Counter(
        (component.kind, key, attribute.text.strip())
        for component in document.components.values()
        for key, attribute in component.attributes.items()
        if key in _ATTRIBUTES and number_of(attribute.text or "0") != 0
    )
    for (kind, key, text), count in sorted(values.items()):
        yield Note("left out", f"{shown(kind)} {key}", shown(text, 40), f"not read ({_times(count)})")


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
