"""A stage of a gear unit as the table [[stages]] of a scene.

Where the file gives no tip circle, tips are shortened by k m_n = a - a_d - m_n (x1 + x2), so that the tip clearance
stays that of the basic rack (ISO 21771:2007, 5.4.5; a_d reference centre distance).
"""

from __future__ import annotations

import math
from typing import Any

from fem.elements.materials import STEEL
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from fem.gears.wheel_body import THINNEST_RIM
from pipelines.io.errors import SceneError
from pipelines.machine.layout import USUAL_BACKLASH, gear_pair
from pipelines.rexs.document import RexsError
from pipelines.rexs.gear_unit import GearUnit, Note, RexsGear, RexsShaft, RexsStage
from pipelines.scene.load_scene import validate
from pipelines.scene.merge import Merged
from pipelines.scene.tables.stages import StageTable

USUAL_RACK = {"rack_addendum": 1.0, "rack_dedendum": 1.25, "rack_tip_radius": 0.38}  # ISO 53 A


def stage_table(unit: GearUnit, number: int, notes: list[Note]) -> tuple[dict[str, Any], GearPair]:
    """Keys and values of the table of a stage, counted from 1, and its gears in SI; `notes` takes the assumptions made.

    Raises
    ------
    RexsError : the gears do not fit together, with the reason
    """
    stage, path = unit.stages[number - 1], f"stages.{number}"
    pinion, wheel = stage.pinion, stage.wheel
    _same(unit, stage)
    low, high = max(pinion.start, wheel.start), min(pinion.end, wheel.end)
    if high <= low:
        raise RexsError(
            f"{unit.source}: {stage.label}: its gears do not overlap along the shafts ({pinion.start:g} to "
            f"{pinion.end:g} mm and {wheel.start:g} to {wheel.end:g} mm). Correct their places."
        )
    for name, gear in (("pinion", pinion), ("wheel", wheel)):
        if gear.end - gear.start > (high - low) * (1 + 1e-9):
            wide = f"the {name} is {gear.end - gear.start:g} mm wide"
            reason = f"the common part of the faces; {wide}, the mass of the rest is left out"
            notes.append(Note("changed", f"{path}.face_width_mm", _text(high - low), reason))
    driving, driven = (unit.shafts[shaft] for shaft in stage.shafts)
    values: dict[str, Any] = {}
    if any(one.shafts != (place, place + 1) for place, one in enumerate(unit.stages)):
        values |= {"pinion_shaft": stage.shafts[0] + 1, "wheel_shaft": stage.shafts[1] + 1}
    values |= {
        "pinion_teeth": pinion.teeth,
        "wheel_teeth": wheel.teeth,
        "module_mm": pinion.module,
        "pressure_angle_deg": pinion.pressure_angle,
        "helix_angle_deg": abs(pinion.helix),
        "pinion_hand": "right" if pinion.helix >= 0 else "left",
        "face_width_mm": high - low,
        "pinion_profile_shift": pinion.profile_shift,
        "wheel_profile_shift": wheel.profile_shift,
        "centre_distance_mm": stage.centre_distance,
        "position_mm": (low + high) / 2,
        "direction_deg": _direction(unit, stage, driving, driven, notes, path),
    }
    for name, gear, shaft in zip(("pinion", "wheel"), (pinion, wheel), (driving, driven), strict=True):
        values[name] = _details(stage, gear, f"{path}.{name}", notes)
        key, middle = f"{name}_bore_mm", (low + high) / 2
        values[key] = _bore(gear, shaft, middle, values[name], f"{path}.{key}", unit, notes)
    pair = _pair(unit, stage, values)
    if pair.backlash < USUAL_BACKLASH:
        values["backlash_um"] = 1e6 * USUAL_BACKLASH
        reason = (
            f"tooth thickness allowances are not read; the centre distance alone leaves {pair.backlash * 1e6:.2f} um"
        )
        notes.append(Note("assumed", f"{path}.backlash_um", f"{1e6 * USUAL_BACKLASH:g}", reason))
    return values, pair


def _same(unit: GearUnit, stage: RexsStage) -> None:
    pinion, wheel = stage.pinion, stage.wheel
    for name, one, other in (
        ("normal_module", pinion.module, wheel.module),
        ("normal_pressure_angle", pinion.pressure_angle, wheel.pressure_angle),
        ("helix_angle_reference_diameter", pinion.helix, -wheel.helix),
    ):
        if not math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9):
            raise RexsError(
                f"{unit.source}: {stage.label}: {name} is {one:g} at {pinion.label} and "
                f"{-other if 'helix' in name else other:g} at {wheel.label}; external gears on parallel axes have the "
                "same module and pressure angle and opposite helices. Correct one."
            )


def _direction(
    unit: GearUnit, stage: RexsStage, one: RexsShaft, other: RexsShaft, notes: list[Note], path: str
) -> float:
    """Direction from the pinion's axis to that of the wheel (deg); the distance must be that of the stage."""
    x, z = other.x - one.x, other.z - one.z
    distance, wanted = math.hypot(x, z), stage.centre_distance
    if abs(distance - wanted) > 1e-2 * wanted:
        raise RexsError(
            f"{unit.source}: {stage.label}: center_distance is {wanted:g} mm, but the axes of {one.label} and "
            f"{other.label} are at a distance of {distance:.6g} mm. Correct support_vector or center_distance."
        )
    if abs(distance - wanted) > 1e-4 * wanted:
        reason = f"center_distance; the distance of the axes in the file is {distance:.6g} mm"
        notes.append(Note("changed", f"{path}.centre_distance_mm", _text(wanted), reason))
    return math.degrees(math.atan2(z, x))


def _details(stage: RexsStage, gear: RexsGear, path: str, notes: list[Note]) -> dict[str, float]:
    """The table of one gear: rack and tip."""
    values = {"rack_addendum": gear.addendum, "rack_dedendum": _dedendum(gear), "rack_tip_radius": gear.tip_radius}
    if missing := [key for key, value in values.items() if value is None]:
        value = ", ".join(f"{key} {USUAL_RACK[key]:g}" for key in missing)
        notes.append(Note("assumed", path, value, "ISO 53 A; the file gives none"))
    details = {key: USUAL_RACK[key] if value is None else value for key, value in values.items()}
    standard = _reference_diameter(gear) / 2 + gear.module * (details["rack_addendum"] + gear.profile_shift)
    given = gear.tip_diameter
    height = 0.0 if given is None else (given - _reference_diameter(gear)) / 2 - gear.module * gear.profile_shift
    if given is not None and 0.3 * gear.module < height < 2 * gear.module:
        return details | {"tip_alteration_mm": given / 2 - standard}
    sum_of_shifts = stage.pinion.profile_shift + stage.wheel.profile_shift
    reference = (_reference_diameter(stage.pinion) + _reference_diameter(stage.wheel)) / 2
    alteration = stage.centre_distance - reference - gear.module * sum_of_shifts
    why = "the file gives no tip_diameter"
    if given is not None:
        why = f"tip_diameter = {given:g} mm of the file is no tip circle"
    reason = f"tips shortened to keep the tip clearance; {why}"
    notes.append(Note("assumed", f"{path}.tip_alteration_mm", _text(alteration), reason))
    return details | {"tip_alteration_mm": alteration}


def _dedendum(gear: RexsGear) -> float | None:
    if gear.root_diameter is None:
        return None
    return (_reference_diameter(gear) - gear.root_diameter) / 2 / gear.module + gear.profile_shift


def _reference_diameter(gear: RexsGear) -> float:
    return gear.teeth * gear.module / math.cos(math.radians(gear.helix))


def _bore(
    gear: RexsGear, shaft: RexsShaft, y: float, details: dict[str, float], path: str, unit: GearUnit, notes: list[Note]
) -> float:
    """Where the gear body begins: at the shaft's surface, or inside it where the gear is cut from the shaft."""
    root = _reference_diameter(gear) - 2 * gear.module * (details["rack_dedendum"] - gear.profile_shift)
    section = next((one for one in shaft.sections if one.start <= y <= one.end), None)
    if section is None:
        raise RexsError(
            f"{unit.source}: {gear.label}: its middle, y = {y:g} mm, is not on {shaft.label}. Correct its place."
        )
    diameter, largest = max(section.outer), root - 2 * THINNEST_RIM * gear.module
    if diameter <= largest:
        return diameter
    reason = f"{THINNEST_RIM} modules below the root circle: the gear is cut on its shaft of {diameter:g} mm"
    notes.append(Note("assumed", path, _text(largest), reason))
    return largest


def _pair(unit: GearUnit, stage: RexsStage, values: dict[str, Any]) -> GearPair:
    """The gears of a table in SI; RexsError with the reason where they do not work."""
    try:
        table, _ = validate(Merged(values), StageTable, unit.source)
        return gear_pair(table, STEEL)
    except (GeometryError, SceneError) as error:
        reasons = "; ".join(map(str, getattr(error, "problems", (error,))))
        raise RexsError(f"{unit.source}: {stage.label}: {reasons}") from error


def _text(value: float) -> str:
    return f"{value:.6g}"
