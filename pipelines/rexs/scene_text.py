"""Gear unit as the text of a scene: TOML with comments on all that is assumed, changed and left out."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pipelines.io.shown_text import shown
from pipelines.io.toml_text import format_value
from pipelines.rexs.bearing_tables import bearing_table, between_table
from pipelines.rexs.document import RexsError
from pipelines.rexs.gear_unit import GearUnit, Note, RexsSection, RexsShaft
from pipelines.rexs.motion_tables import motion_tables
from pipelines.rexs.stage_tables import stage_table

DIGITS = 12  # significant digits that are written
PIECES = 4  # cylinders in place of a conical stretch
JOINT = 1e-6  # mm: sections with a smaller gap are connected
STEEL = {"elastic_modulus_GPa": 206.0, "poisson_ratio": 0.3, "density_kg_m3": 7850.0}
GRADE = 5
HARMONICS = 20  # least output rate divided by the fastest mesh frequency: ten harmonics
SIMPLEST = (
    Note("assumed", "casing.model", "none", "bearings are held by the ground: REXS has no housing"),
    Note("assumed", "stages.mesh.model", "iso", "a first look within seconds"),
)
HEADINGS = {
    "assumed": "Assumed: not given in the file.",
    "changed": "Changed: a scene cannot express it as the file has it.",
    "left out": "Left out: in the file, not in this scene.",
}


@dataclass(frozen=True)
class SceneText:
    """A scene, its differences from the file, and the keys that the user must still give."""

    text: str
    notes: tuple[Note, ...]
    missing: Mapping[str, str]


def scene_text(unit: GearUnit, name: str) -> SceneText:
    """Scene of a gear unit; `name` is its title.

    Raises
    ------
    RexsError : impossible in a scene: gears that do not fit, gaps in a shaft, a shaft without bearings
    """
    notes = [*unit.notes]
    stages = [line for number in range(1, len(unit.stages) + 1) for line in _stage_lines(unit, number, notes)]
    drive, load, missing = motion_tables(unit, notes)
    material, grade = _material(unit, notes), _grade(unit, notes)
    body = [
        f"title = {format_value(shown(name, 100))}",
        "",
        "[gear_material]",
        *_keys(material),
        *stages,
        *(line for number, shaft in enumerate(unit.shafts, 1) for line in _shaft_lines(unit, number, shaft, notes)),
        *_between_lines(unit, notes),
        "",
        "[shaft_model]",
        'model = "timoshenko"',
        "",
        "[deviations]",
        "enabled = true",
        f"iso_grade = {grade}",
        "seed = 1",
        "",
        "[casing]",
        'model = "none"  # signals are bearing forces; for sensors set a housing, see docs/scene-keys.md:',
        '# model = "rigid", with [casing.housing] (box, or model = "step" with a file), [casing.material], [[sensors]]',
        *_motion_lines(unit, drive, load, missing),
    ]
    notes += SIMPLEST
    return SceneText("\n".join([*_head(unit, notes), *body, ""]), tuple(notes), missing)


def _head(unit: GearUnit, notes: Iterable[Note]) -> Iterator[str]:
    yield f"# From {shown(unit.source)}: REXS {shown(unit.version)}, written by {shown(unit.written_by, 60)}."
    yield "# y is u of the file (-u if the speed of its input is negative), z is w; positions in mm."
    comment = textwrap.TextWrapper(118, initial_indent="# ", subsequent_indent="#   ", break_long_words=False)
    for kind, heading in HEADINGS.items():
        found = [note for note in notes if note.kind == kind]
        if found:
            yield "#"
            yield f"# {heading}"
        for note in found:
            value = f" = {note.value}" if note.value else ""
            yield from comment.wrap(shown(f"- {note.where}{value}: {note.reason}", 1000))
    yield ""


def _keys(table: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {format_value(_rounded(value))}" for key, value in table.items()]


def _rounded(value: Any) -> Any:
    """Numbers without the round-off of their last digits."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") + 0.0  # no -0
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if isinstance(value, Mapping):
        return {key: _rounded(item) for key, item in value.items()}
    return value


def _material(unit: GearUnit, notes: list[Note]) -> dict[str, float]:
    """Material of all gears and shafts: that of the first shaft with a material."""
    given = [shaft.material for shaft in unit.shafts if shaft.material]
    material = given[0] if given else STEEL
    modulus, ratio, density = material.values()
    reason = "that of the shafts, taken for the gears too" if given else "steel; the file gives none"
    several = any(one != material for one in given)
    if several:
        reason = "one material for all, that of the first shaft that names one; the file has several"
    value = f"E {modulus:g} GPa, nu {ratio:g}, {density / 1000:g} kg/dm3"
    notes.append(Note("changed" if several else "assumed", "gear_material", value, reason))
    return material


def _grade(unit: GearUnit, notes: list[Note]) -> int:
    grades = {gear.grade for stage in unit.stages for gear in (stage.pinion, stage.wheel) if gear.grade is not None}
    grade = max(grades, default=GRADE)
    if len(grades) != 1:
        reason = f"the coarsest of {sorted(grades)}" if grades else "the file gives none"
        notes.append(Note("assumed", "deviations.iso_grade", f"{grade}", reason))
    return grade


def _stage_lines(unit: GearUnit, number: int, notes: list[Note]) -> Iterator[str]:
    values, pair = stage_table(unit, number, notes)
    yield from ("", f"[[stages]]  # {number}: {unit.stages[number - 1].label}")
    for name, gear in (("pinion", pair.pinion), ("wheel", pair.wheel)):
        diameters = ", ".join(
            f"{symbol} {2000 * radius:.4f}"
            for symbol, radius in (
                ("d", gear.reference_radius),
                ("d_a", gear.tip_radius),
                ("d_f", gear.root_radius),
                ("d_b", gear.base_radius),
            )
        )
        yield f"# {name}: {diameters} mm"
    angle = math.degrees(pair.working_pressure_angle)
    yield (
        f"# alpha_wt {angle:.4f} deg, eps_alpha {pair.transverse_contact_ratio:.4f}, eps_beta {pair.overlap_ratio:.4f}"
    )
    yield from _keys(values)
    yield 'mesh = { model = "iso" }  # "plane": 2-D finite elements, seconds; "solid": 3-D, tens of seconds'


def _shaft_lines(unit: GearUnit, number: int, shaft: RexsShaft, notes: list[Note]) -> Iterator[str]:
    if not shaft.bearings:
        raise RexsError(f"{unit.source}: {shaft.label}: has no bearing. Add the relation side of one with this shaft.")
    yield from ("", f"[[shafts]]  # {number}: {shaft.label}", "sections = [")
    for section in _cylinders(unit, shaft, notes, f"shafts.{number}.sections"):
        yield f"    {format_value(_rounded(section))},"
    yield from ("]", *_keys({"bearing_positions_mm": [bearing.y for bearing in shaft.bearings]}), "bearings = [")
    for place, bearing in enumerate(shaft.bearings, 1):
        table = bearing_table(bearing, shaft, f"shafts.{number}.bearings.{place}", notes)
        yield f"    {format_value(_rounded(table))},  # {bearing.label}"
    yield "]"


def _between_lines(unit: GearUnit, notes: list[Note]) -> Iterator[str]:
    """Bearings between two shafts, as couplings without torsional stiffness."""
    for number, (shafts, bearing) in enumerate(unit.between, 1):
        springs = between_table(bearing, unit.shafts[shafts[0]], f"couplings.{number}", notes)
        places = {"shafts": [shaft + 1 for shaft in shafts], "positions_mm": [bearing.y, bearing.y]}
        yield from ("", f"[[couplings]]  # {bearing.label}, between two shafts", *_keys(places | springs))


def _cylinders(unit: GearUnit, shaft: RexsShaft, notes: list[Note], path: str) -> Iterator[dict[str, float]]:
    """Sections without gaps; conical ones become steps of the mean diameter."""
    before: RexsSection | None = None
    for section in shaft.sections:
        if before is not None and abs(section.start - before.end) > JOINT:
            raise RexsError(
                f"{unit.source}: {shaft.label}: a section ends at y = {before.end:g} mm, the next starts at "
                f"{section.start:g} mm. Sections must join: correct u_coordinate_on_shaft or length."
            )
        start = section.start if before is None else before.end
        before = section
        conical = section.outer[0] != section.outer[1] or section.inner[0] != section.inner[1]
        if conical:
            where = f"{path} from y = {start:g} to {section.end:g} mm"
            notes.append(Note("changed", where, f"{PIECES} steps", "conical; a scene has cylinders"))
        pieces = PIECES if conical else 1
        for piece in range(pieces):
            middle = (piece + 0.5) / pieces
            low, high = (start + (section.end - start) * share / pieces for share in (piece, piece + 1))
            yield {
                "start_mm": _rounded(low),
                "end_mm": _rounded(high),
                "diameter_mm": section.outer[0] + middle * (section.outer[1] - section.outer[0]),
                "bore_mm": section.inner[0] + middle * (section.inner[1] - section.inner[0]),
            }


def _motion_lines(
    unit: GearUnit, drive: dict[str, Any], load: dict[str, Any], missing: dict[str, str]
) -> Iterator[str]:
    yield from ("", "[drive]", f"# load case {unit.load_case.name}")
    for case in unit.other_cases:
        turning = "no speed" if case.speed is None else f"{case.speed:g} rpm"
        twisting = "no torque" if case.torque is None else f"{case.torque:g} N m at the input"
        yield f"# load case {case.name}: {turning}, {twisting}"
    yield from (*_keys(drive), *_missing(missing, "drive"), "", "[load]", *_keys(load), *_missing(missing, "load"))
    speed = abs(unit.load_case.speed or 0.0) / 60
    fastest = max(speed * unit.speeds[stage.shafts[0]] * stage.pinion.teeth for stage in unit.stages)
    rate = max(10_000.0, 1000.0 * math.ceil(HARMONICS * fastest / 1000))
    yield from ("", "[simulation]", *_keys({"end_s": drive["times_s"][-1], "output_rate_Hz": rate, "step_us": 20.0}))


def _missing(missing: Mapping[str, str], table: str) -> Iterator[str]:
    for path, words in missing.items():
        if path.startswith(f"{table}."):
            yield f"# {path.partition('.')[2]} = ...  # TO BE SET: {words}"
