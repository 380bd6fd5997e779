"""Labels: the faults of a scene, read from the machine model in SI that is simulated, so that both always agree."""

from __future__ import annotations

import json
from typing import Any

from pipelines.machine.machine_model import MachineModel

HEALTHY = "healthy"
COLUMNS = {  # meaning of all columns of a data set that are not variables of its plan
    "run": "number of the scene in the plan, and along the first dimension of every array",
    "key": "SHA-256 of the scene with all its defaults; equal for equal scenes",
    "status": "done, failed, or empty while the campaign runs",
    "reason": "why it failed",
    "group": "runs of one group are in one part of the split",
    "split": "train, test or validation",
    "label": "kinds of all faults, or healthy",
    "places": "places of all faults, in words",
    "severity": "size of the first fault: the value of the key severity_key in its table",
    "severity_key": "key of that size with its unit, for example depth_mm",
    "faults": "all faults with all their values, JSON",
    "step_error": "estimated error of the accelerations caused by the time step, share of their rms",
    "repeatable_until_s": "time after which the motion depends on rounding (rattling gears); else that of the last "
    "sample",
    "warnings": "kinds of warning: step (step_error above 5 %), repeat (repeatable_until_s is before the end), energy "
    "(balance does not close)",
    "seconds": "computing time of the run, s",
    "loop_seconds": "part of it in the time loop, s",
}
_SIZES = {  # key of the size that determines the effect, by kind of fault
    "chipped-tooth": "depth_mm",
    "cracked-tooth": "depth_mm",
    "spalled-tooth": "height_mm",
    "pitted-tooth": "density",
    "worn-tooth": "depth_um",
    "bearing-spall": "width_mm",
    "unbalance": "unbalance_g_mm",
    "bent-shaft": "bow_um",
}


def labels(machine: MachineModel) -> dict[str, Any]:
    """Labels of a scene: kinds and places of all faults in words, the size of the first one, and all tables.

    `severity` is the value of the key `severity_key` in the scene; None without a fault, or where the fault has no
    size, as a missing tooth.
    """
    written = machine.labels
    faults = json.loads(written["faults"])
    size = _SIZES.get(faults[0]["kind"]) if faults else None
    return {
        "label": written["state"],
        "places": "; ".join(machine.fault_words) or HEALTHY,
        "severity": faults[0][size] if size else None,
        "severity_key": size,
        "faults": written["faults"],
    }
