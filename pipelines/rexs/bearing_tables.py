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
BOTH = "its balls hold both"
BALLS = ("radial_grooved_ball_bearing", "angular_contact_ball_bearing", "four_point_contact_ball_bearing")


def bearing_table(bearing: RexsBearing, shaft: RexsShaft, path: str) -> tuple[dict[str, Any], list[Note]]:
    """Table of a bearing, and the assumptions made.

    Parameters
    ----------
    bearing : the bearing of the gear unit
    shaft : in the bearing; its diameter replaces a missing bore
    path : of the table in the scene
    """
    if bearing.axial == "no_direction" or not bearing.radial:
        return _springs(bearing, shaft, path, "carries no thrust" if bearing.radial else "carries no radial load")
    if bearing.elements is not None:
        return _given(bearing, path)
    known = designations()
    wanted = bearing.designation.replace(" ", "").upper().split("-")[0].split("/")[0]
    if wanted in known:
        value = f'designation "{wanted}"'
        reason = f"rolling elements of the catalogue for {bearing.label}; the file gives none; no clearance"
        return {"model": "hertz", "designation": wanted}, [
            _assumed(path, value, reason),
            *_one_way(bearing, path, BOTH),
        ]
    if bearing.kind == BALLS[0] and bearing.inner_diameter and bearing.outer_diameter and bearing.static_rating:
        return _estimated(bearing, bearing.inner_diameter, bearing.outer_diameter, bearing.static_rating, path)
    return _springs(bearing, shaft, path, "not in the catalogue and without rolling elements in the file")


def between_table(bearing: RexsBearing, shaft: RexsShaft, path: str) -> tuple[dict[str, float], list[Note]]:
    """Keys of [[couplings]] for a bearing between two shafts: springs in all directions but the rotation."""
    springs, notes = _springs(bearing, shaft, path, "between two shafts", 0.0)
    return {
        "torsional_stiffness_N_m_per_rad": 0.0,
        "radial_stiffness_N_per_um": springs["radial_stiffness_N_per_um"],
        "axial_stiffness_N_per_um": springs["axial_stiffness_N_per_um"],
        "tilt_stiffness_N_m_per_rad": springs["tilt_stiffness_N_m_per_rad"],
        "damping_time_us": 5.0,
    }, notes


def _given(bearing: RexsBearing, path: str) -> tuple[dict[str, Any], list[Note]]:
    elements = bearing.elements
    assert elements is not None
    table: dict[str, Any] = {
        "model": "hertz",
        "kind": "ball" if elements.length is None or bearing.kind in BALLS else "roller",
        "elements": elements.count,
        "element_diameter_mm": elements.diameter,
        "pitch_diameter_mm": elements.pitch_diameter,
        "contact_angle_deg": elements.contact_angle,
    }
    if table["kind"] == "roller":
        table["roller_length_mm"] = elements.length
    return table, [_assumed(path, "no clearance", f"{bearing.label}: clearances are not read")]


def _estimated(
    bearing: RexsBearing, bore: float, outside: float, rating: float, path: str
) -> tuple[dict[str, Any], list[Note]]:
    diameter, pitch = BALL_SHARE * (outside - bore), (bore + outside) / 2
    count = max(3, round(rating / (BALL_RATING * diameter**2)))
    table = {
        "model": "hertz",
        "kind": "ball",
        "elements": count,
        "element_diameter_mm": diameter,
        "pitch_diameter_mm": pitch,
    }
    value = f"{count} balls of {diameter:.4g} mm on a pitch diameter of {pitch:g} mm"
    reason = f"{bearing.label}: from its bore, outside diameter and static rating; no clearance"
    return table, [_assumed(path, value, reason), *_one_way(bearing, path, BOTH)]


def _one_way(bearing: RexsBearing, path: str, both: str) -> list[Note]:
    """Note on a bearing with thrust in one direction in the file; `both` states that the scene carries both."""
    if bearing.axial not in ("positive", "negative"):
        return []
    reason = f"{bearing.label} carries thrust in the {bearing.axial} direction only; {both}"
    return [Note(kind="changed", where=path, value="thrust in both directions", reason=reason)]


def _springs(
    bearing: RexsBearing, shaft: RexsShaft, path: str, why: str, least: float = FREE
) -> tuple[dict[str, Any], list[Note]]:
    bore = bearing.inner_diameter or max(  # that of the shaft
        max(s.outer) for s in shaft.sections if s.start - 1e-6 <= bearing.y <= s.end + 1e-6
    )
    kind = "roller" if "roller" in bearing.kind else "ball"
    radial = RADIAL[kind] * bore if bearing.radial else least
    given = (
        ""
        if bearing.radial_stiffness is None
        else f"; its {bearing.radial_stiffness:g} N/m are taken as rigid and not used"
    )
    if bearing.radial_stiffness is not None and 0 < bearing.radial_stiffness < RIGID * 1e6:
        radial, given = bearing.radial_stiffness / 1e6, "; radial stiffness of the file"
    axial = least if bearing.axial == "no_direction" else radial / 2
    table = {
        "model": "linear",
        "radial_stiffness_N_per_um": radial,
        "axial_stiffness_N_per_um": axial,
        "tilt_stiffness_N_m_per_rad": 1e6 * radial * (LEVER * bore / 1000) ** 2,
    }
    value = f"springs of {radial:g} N/um radial, {axial:g} N/um axial"
    assumed = _assumed(path, value, f"{bearing.label}: {why}; by its bore of {bore:g} mm{given}")
    return table, [assumed, *_one_way(bearing, path, "springs hold both")]


def _assumed(path: str, value: str, reason: str) -> Note:
    return Note(kind="assumed", where=path, value=value, reason=reason)
