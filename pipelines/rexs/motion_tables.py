"""Drive and load of a gear unit: a motor of prescribed speed, and a constant torque at the output."""

from __future__ import annotations

import math
from typing import Any

from pipelines.rexs.gear_unit import GearUnit, Note

RUN_UP, END = 0.1, 1.0  # s
TWIST = 0.01  # rad: of the coupling at the motor under the torque of the load case
SETTLING = 2.5e-4  # s: its damping over its stiffness


def motion_tables(unit: GearUnit, notes: list[Note]) -> tuple[dict[str, Any], dict[str, Any], dict[str, str]]:
    """Tables [drive] with the speed of the load case and [load] with its torque over the ratio, without losses.

    The third one has the keys that the user must give, with the reason; `notes` takes the assumptions made.
    """
    case, torque, missing = unit.load_case, unit.load_case.torque, {}
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
    assumed = {
        "drive": (
            f"from rest to speed in {RUN_UP:g} s, then {END - RUN_UP:g} s at speed",
            "the file has load cases, no motion; the motor stands at the -y end of its shaft",
        ),
        "drive.coupling_stiffness_N_m_per_rad": (
            f"{coupling:.4g}",
            f"it twists by {TWIST:g} rad ({math.degrees(TWIST):.2g} deg) under the torque; the file has none",
        ),
        "load.inertia_kg_m2": ("0", "the file has no driven machine"),
    }
    if torque is not None:
        assumed["load.torque_N_m"] = (
            f"{abs(torque * unit.ratio):.6g}",
            f"{abs(torque):.6g} N m at the input times the ratio {unit.ratio:.6g}, without losses",
        )
    notes += [Note("assumed", where, *words) for where, words in assumed.items()]
    return drive, load, missing
