"""Labels: what is wrong in a scene, read from its plant, so that no label can contradict what was simulated."""

from __future__ import annotations

import json
from typing import Any

from pipelines.plant.plant import Plant

HEALTHY = "healthy"
# All columns of a data set that are no variables of its plan.
COLUMNS = (
    *("run", "key", "status", "reason", "group", "split"),
    *("label", "places", "severity", "severity_key", "faults"),
    *("step_error", "repeatable_until_s", "warnings"),
    *("seconds", "loop_seconds"),
)
_SIZES = ("depth_mm", "depth_um")  # of a fault, the one that grows as it does


def labels(plant: Plant) -> dict[str, Any]:
    """Labels of a scene: kinds and places of all faults in words, the size of the first one, and all tables.

    `severity` is the number that stands in the scene under `severity_key`; None without a fault, or where the fault
    has no size, as a missing tooth.
    """
    told = plant.labels
    faults = json.loads(told["faults"])
    size = next((key for key in _SIZES if faults and faults[0].get(key) is not None), None)
    return {
        "label": told["state"],
        "places": "; ".join(plant.fault_words) or HEALTHY,
        "severity": faults[0][size] if size else None,
        "severity_key": size,
        "faults": told["faults"],
    }
