"""Bearing of a gear unit as a table of a scene: its rolling elements if they are known, else springs.

Rolling elements come from the file, from the catalogue by the designation, or for deep groove balls from boundary
dimensions and static rating: D_w = 0.3 (D - d), D_pw = (d + D)/2, and the number from C_0 = f_0 Z D_w^2 cos(alpha) with
f_0 = 14 (ISO 76:2006, 4.1 and table 1; D_w of usual bearings of series 62 and 63 is 0.29 to 0.31 of D - d).
Springs depend on the size: radial stiffness per mm of bore, an axial one of half that where thrust is carried, tilt by
a lever of 0.4 bores. They are orders of magnitude, to be replaced by values of the manufacturer.
"""

from __future__ import annotations

from typing import Any

from mbd.parts.rolling_catalogue import designations
from pipelines.rexs.gear_unit import Note, RexsBearing, RexsShaft

BALL_SHARE, BALL_RATING = 0.3, 14.0
RADIAL = {"ball": 4.0, "roller": 8.0}  # N/um per mm of bore
FREE = 0.01  # N/um, the lowest stiffness that a scene accepts
LEVER = 0.4  # of the bore
RIGID = 1e6  # N/um: a higher stiffness means rigid
GROOVED = "radial_grooved_ball_bearing"


def bearing_table(bearing: RexsBearing, shaft: RexsShaft, path: str, notes: list[Note]) -> dict[str, Any]:
    """Table of a bearing.

    Parameters
    ----------
    bearing : the bearing of the gear unit
    shaft : in the bearing; its diameter replaces a missing bore
    path : of the table in the scene
    notes : takes the assumptions made
    """
    if bearing.axial == "no_direction" or not bearing.radial:
        why = "carries no thrust" if bearing.radial else "carries no radial load"
        return _springs(bearing, shaft, path, notes, why)
    if bearing.elements:
        notes.append(Note("assumed", path, "no clearance", f"{bearing.label}: clearances are not read"))
        return {"model": "hertz", **bearing.elements}
    wanted = bearing.designation.replace(" ", "").upper().split("-")[0].split("/")[0]
    bore, outside, rating = bearing.inner_diameter, bearing.outer_diameter, bearing.static_rating
    if wanted in designations():
        table, value = {"designation": wanted}, f'designation "{wanted}"'
        reason = f"rolling elements of the catalogue for {bearing.label}; the file gives none; no clearance"
    elif bearing.kind == GROOVED and bore and outside and rating:
        table, value = _balls(bore, outside, rating)
        reason = f"{bearing.label}: from its bore, outside diameter and static rating; no clearance"
    else:
        why = "not in the catalogue and without rolling elements in the file"
        return _springs(bearing, shaft, path, notes, why)
    notes.append(Note("assumed", path, value, reason))
    _note_thrust(bearing, path, notes, "its balls hold both")
    return {"model": "hertz", **table}


def between_table(bearing: RexsBearing, shaft: RexsShaft, path: str, notes: list[Note]) -> dict[str, Any]:
    """Keys of [[couplings]] for a bearing between two shafts: springs in all directions but the rotation.

    Parameters
    ----------
    bearing, shaft, path, notes : as in `bearing_table`
    """
    springs = _springs(bearing, shaft, path, notes, "between two shafts", 0.0)
    del springs["model"]
    return {"torsional_stiffness_N_m_per_rad": 0.0, **springs, "damping_time_us": 5.0}


def _balls(bore: float, outside: float, rating: float) -> tuple[dict[str, Any], str]:
    """Keys of the balls of a bearing by its boundary dimensions (mm) and static rating (N), and the same in words."""
    diameter, pitch = BALL_SHARE * (outside - bore), (bore + outside) / 2
    count = max(3, round(rating / (BALL_RATING * diameter**2)))
    table = {"kind": "ball", "elements": count, "element_diameter_mm": diameter, "pitch_diameter_mm": pitch}
    return table, f"{count} balls of {diameter:.4g} mm on a pitch diameter of {pitch:g} mm"


def _note_thrust(bearing: RexsBearing, path: str, notes: list[Note], both: str) -> None:
    """Note on a bearing with thrust in one direction in the file; `both` states that the scene carries both."""
    if bearing.axial in ("positive", "negative"):
        reason = f"{bearing.label} carries thrust in the {bearing.axial} direction only; {both}"
        notes.append(Note("changed", path, "thrust in both directions", reason))


def _springs(
    bearing: RexsBearing, shaft: RexsShaft, path: str, notes: list[Note], why: str, least: float = FREE
) -> dict[str, Any]:
    bore = bearing.inner_diameter or max(  # that of the shaft
        max(s.outer) for s in shaft.sections if s.start - 1e-6 <= bearing.y <= s.end + 1e-6
    )
    kind = "roller" if "roller" in bearing.kind else "ball"
    radial, given = RADIAL[kind] * bore if bearing.radial else least, ""
    if bearing.radial_stiffness is not None:
        given = f"; its {bearing.radial_stiffness:g} N/m are taken as rigid and not used"
        if 0 < bearing.radial_stiffness < RIGID * 1e6:
            radial, given = bearing.radial_stiffness / 1e6, "; radial stiffness of the file"
    axial = least if bearing.axial == "no_direction" else radial / 2
    value = f"springs of {radial:g} N/um radial, {axial:g} N/um axial"
    notes.append(Note("assumed", path, value, f"{bearing.label}: {why}; by its bore of {bore:g} mm{given}"))
    _note_thrust(bearing, path, notes, "springs hold both")
    return {
        "model": "linear",
        "radial_stiffness_N_per_um": radial,
        "axial_stiffness_N_per_um": axial,
        "tilt_stiffness_N_m_per_rad": 1e6 * radial * (LEVER * bore / 1000) ** 2,
    }
