"""Drive and load of a gear unit: a motor of prescribed speed, and a constant torque at the output."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pipelines.rexs.gear_unit import GearUnit, Note

RUN_UP, END = 0.1, 1.0  # s
TWIST = 0.01  # rad: of the coupling at the motor under the torque of the load case
SETTLING = 2.5e-4  # s: its damping over its stiffness


@dataclass(frozen=True)
class MotionTables:
    """Tables [drive] and [load]; `missing` are keys that the user must give, with the reason."""

    drive: dict[str, Any]
    load: dict[str, Any]
    missing: dict[str, str]
    notes: tuple[Note, ...]


def motion_tables(unit: GearUnit) -> MotionTables:
    """The drive with the speed of the load case, the load with its torque over the ratio; without losses."""
    case, missing = unit.load_case, {}
    torque = case.torque
    coupling = abs(torque) / TWIST if torque else 2000.0
    drive: dict[str, Any] = {
        "model": "speed",
        "times_s": [0.0, RUN_UP, END],
        "motors": 1,
        "coupling_stiffness_N_m_per_rad": coupling,
        "coupling_damping_N_m_s_per_rad": SETTLING * coupling,
    }
    if case.speed:
        drive["speeds_rpm"] = [0.0, case.speed, case.speed]
    else:
        missing["drive.speeds_rpm"] = "speed of the motor at times_s: the file gives no rotational_speed"
    place = unit.output_y if unit.output_y is not None else unit.shafts[unit.output].sections[-1].end
    load: dict[str, Any] = {"model": "torque", "position_mm": place}
    if unit.output != len(unit.shafts) - 1:
        load["shaft"] = unit.output + 1
    if torque:
        load["torque_N_m"] = abs(torque * unit.ratio)
    else:
        missing["load.torque_N_m"] = "torque that the driven machine takes: the file gives none"
    return MotionTables(drive, load, missing, _notes(unit, coupling))


def _notes(unit: GearUnit, coupling: float) -> tuple[Note, ...]:
    case = unit.load_case
    notes = [
        Note(
            kind="assumed",
            where="drive",
            value=f"from rest to speed in {RUN_UP:g} s, then {END - RUN_UP:g} s at speed",
            reason="the file has load cases, no motion; the motor stands at the -y end of its shaft",
        ),
        Note(
            kind="assumed",
            where="drive.coupling_stiffness_N_m_per_rad",
            value=f"{coupling:.4g}",
            reason=f"it twists by {TWIST:g} rad ({math.degrees(TWIST):.2g} deg) under the torque; the file has none",
        ),
        Note(
            kind="assumed",
            where="load.inertia_kg_m2",
            value="0",
            reason="the file has no driven machine",
        ),
    ]
    if case.torque is not None:
        notes.append(
            Note(
                kind="assumed",
                where="load.torque_N_m",
                value=f"{abs(case.torque * unit.ratio):.6g}",
                reason=f"{abs(case.torque):.6g} N m at the input times the ratio {unit.ratio:.6g}, without losses",
            )
        )
    return tuple(notes)
