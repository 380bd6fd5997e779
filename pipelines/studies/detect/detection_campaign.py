"""The campaign of a study of detectability: the healthy and damaged machines that are simulated.

Every machine has different deviations: the seeds count up from `deviations.seed` of the scene. The first machines are
the healthy baseline, then follow healthy machines that test for false alarms, then damaged ones. The number of the
damaged tooth increases by one from machine to machine. Values of the fault vary only for the damaged machines. Other
values, such as a load, vary for all machines, and each of them has a separate baseline.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pipelines.datasets.plan import Plan, plan_of_study
from pipelines.datasets.typical_spread import put_setting
from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_P
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.machine.machine_model import MachineModel
from pipelines.scene.load_scene import LoadedScene
from pipelines.scene.scene import Scene
from pipelines.scene.shaft_faults import without_shaft_faults
from pipelines.steps.verdict import known_damages
from pipelines.studies.detect.detection_axis import Over

STATE, SPECIMEN = "state", "specimen"
HEALTHY, DAMAGED = "healthy", "damaged"
_DROPPED = ("control", "title", "diagnosis")  # tables and keys that do not change the motion


@dataclass(frozen=True, kw_only=True)
class Design:
    """Varied keys `over`, and numbers of machines: `baseline` and tested `healthy` ones, `damaged` ones per value.

    Machines are numbered from 1 in this order.
    """

    over: tuple[Over, ...] = ()
    baseline: int = 8
    healthy: int = 20
    damaged: int = 10


def detection_plan(loaded: LoadedScene, machine: MachineModel, design: Design) -> Plan:
    """The plan of the campaign.

    Parameters
    ----------
    loaded, machine : the scene with its fault, and its machine model
    design : varied keys and numbers of machines

    Raises
    ------
    InputError : the scene has no fault, all machines would be equal, the baseline is too small, or a key is given twice
    SceneError : the plan is not valid
    """
    _check(loaded, machine, design)
    healthy = healthy_case(loaded)
    damaged: dict[str, Any] = {"faults": _shifted_teeth(loaded.scene)} if loaded.scene.tooth_faults else {}
    common: dict[str, Any] = {"deviations": {"seed": f"$({loaded.scene.deviations.seed} + {SPECIMEN}) - 1"}}
    for over in design.over:
        put_setting(damaged if over.first_key in healthy else common, over.key.split("."), f"${over.variable}")
    last_healthy = design.baseline + design.healthy
    return plan_of_study(
        loaded,
        machine,
        {
            "title": f"Detectability: {'; '.join(machine.fault_words)}"[:200],
            "design": "grid",
            "constraints": [f"({STATE} == '{HEALTHY}') == ({SPECIMEN} <= {last_healthy})"],
            "variables": {
                STATE: [HEALTHY, DAMAGED],
                **{over.variable: list(over.values) for over in design.over},
                SPECIMEN: {"from": 1, "to": last_healthy + design.damaged},
            },
            "settings": common,
            "cases": {STATE: {HEALTHY: healthy, DAMAGED: damaged}},
        },
        f"detect-{loaded.name}",
    )


def healthy_case(loaded: LoadedScene) -> dict[str, Any]:
    """The tables of a scene that contain faults, with the faults removed."""
    without = without_shaft_faults(loaded.tree, loaded.scene)
    changed = {key: without.get(key, []) for key in loaded.tree if without.get(key) != loaded.tree[key]}
    return {**changed, "faults": []}


def _check(loaded: LoadedScene, machine: MachineModel, design: Design) -> None:
    if not known_damages(machine):
        raise InputError(f"{shown(loaded.name)}: the scene has no fault to detect. Add one in [[faults]].")
    if not loaded.scene.deviations.enabled:
        raise InputError(
            f"{shown(loaded.name)}: deviations.enabled = false makes all healthy machines equal, so that any change is "
            "an alarm. Set it to true."
        )
    if design.baseline < FEWEST_FOR_P:
        raise InputError(
            f"--baseline {design.baseline}: the p-values need {FEWEST_FOR_P} healthy machines or more. "
            f"Set --baseline {FEWEST_FOR_P} or more."
        )
    keys = [over.variable for over in design.over]
    if len(set(keys)) < len(keys):
        raise InputError("--over: a key is given twice. Give all its values in one --over.")
    for over in design.over:
        if over.first_key in _DROPPED or over.key == "deviations.seed":
            raise InputError(
                f"--over {shown(over.key)}: no motion depends on this key, or it already differs between all machines. "
                "Give another key; for noise, set --noise."
            )


def _shifted_teeth(scene: Scene) -> dict[str, Any]:
    """Settings that increase the number of each damaged tooth by one from machine to machine."""

    def teeth(stage: int, gear: str) -> int:
        return int(getattr(scene.stages[stage - 1], f"{gear}_teeth"))

    return {
        str(number): {"tooth": f"$({fault.tooth} + {SPECIMEN}) % {teeth(fault.stage, fault.gear)}"}
        for number, fault in scene.tooth_faults.items()
        if fault.tooth is not None
    }
