"""The campaign of a study of detectability: which machines are simulated, healthy ones and damaged ones.

Every machine has deviations of its own, and no seed serves twice: they count up from the scene's `deviations.seed`, so
that another one there means other machines. The first ones are the healthy baseline, then come the healthy machines
that test for false alarms, then the damaged ones. The damaged tooth goes on by one from machine to machine. Values that
belong to the fault change the damaged machines alone; others, as a load, change all, and each such value has a baseline
of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pipelines.datasets.plan import Plan, plan_on
from pipelines.diagnosis.prediction import FEWEST_FOR_P
from pipelines.io.errors import InputError
from pipelines.io.shown import shown
from pipelines.machine.plant import Plant
from pipelines.scene.file import LoadedScene
from pipelines.scene.scene import Scene
from pipelines.scene.shaft_faults import without_shaft_faults
from pipelines.steps.verdict import known_damages
from pipelines.studies.detect.over import Over

STATE, SPECIMEN = "state", "specimen"
HEALTHY, DAMAGED = "healthy", "damaged"
_DROPPED = ("control", "title", "diagnosis")  # no motion depends on them


@dataclass(frozen=True, kw_only=True)
class Design:
    """Numbers of machines: healthy ones of the `baseline`, `healthy` ones for the test, `damaged` ones per value."""

    over: tuple[Over, ...] = ()
    baseline: int = 8
    healthy: int = 20
    damaged: int = 10

    @property
    def specimens(self) -> tuple[int, int, int]:
        """Numbers, counted from 1, of the last machine of the baseline, of the healthy ones, and of all."""
        return self.baseline, self.baseline + self.healthy, self.baseline + self.healthy + self.damaged


def detection_plan(loaded: LoadedScene, plant: Plant, design: Design) -> Plan:
    """The plan of the campaign.

    Parameters
    ----------
    loaded, plant : the scene with its fault, and its plant
    design : what is varied

    Raises
    ------
    InputError : the scene has no fault, all machines would be equal, the baseline is too small, or a key stands twice
    SceneError : the plan cannot be made
    """
    _check(loaded, plant, design)
    healthy = healthy_case(loaded)
    damaged: dict[str, Any] = {"faults": _shifted_teeth(loaded.scene)} if loaded.scene.tooth_faults else {}
    common: dict[str, Any] = {"deviations": {"seed": f"$({loaded.scene.deviations.seed} + {SPECIMEN}) - 1"}}
    for over in design.over:
        _put(damaged if over.first_key in healthy else common, over)
    _, last_healthy, last = design.specimens
    return plan_on(
        loaded,
        {
            "title": f"Detectability: {'; '.join(plant.fault_words)}"[:200],
            "design": "grid",
            "signals": ["acceleration" if plant.sensors else "journal_acceleration", "shaft_angle"],
            "constraints": [f"({STATE} == '{HEALTHY}') == ({SPECIMEN} <= {last_healthy})"],
            "variables": {
                STATE: [HEALTHY, DAMAGED],
                **{over.variable: list(over.values) for over in design.over},
                SPECIMEN: {"from": 1, "to": last},
            },
            "settings": common,
            "cases": {STATE: {HEALTHY: healthy, DAMAGED: damaged}},
            "split": {"test": 0.0},
        },
        f"detect-{loaded.name}",
    )


def healthy_case(loaded: LoadedScene) -> dict[str, Any]:
    """The tables of a scene that hold its faults, as they are without them."""
    without = without_shaft_faults(loaded.tree, loaded.scene)
    changed = {key: without.get(key, []) for key in loaded.tree if without.get(key) != loaded.tree[key]}
    return {**changed, "faults": []}


def _check(loaded: LoadedScene, plant: Plant, design: Design) -> None:
    if not known_damages(plant):
        raise InputError(f"{shown(loaded.name)}: the scene has no fault to detect. Add one in [[faults]].")
    if not loaded.scene.deviations.enabled:
        raise InputError(
            f"{shown(loaded.name)}: deviations.enabled = false makes all healthy machines equal, so that any change is "
            "an alarm. Set it to true."
        )
    if design.baseline < FEWEST_FOR_P:
        raise InputError(
            f"--baseline {design.baseline}: p-values need {FEWEST_FOR_P} healthy machines or more. Set at least that "
            "number."
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
    """The number of every damaged tooth, on by one from machine to machine."""
    return {
        str(number): {"tooth": f"$({fault.tooth} + {SPECIMEN}) % {_teeth(scene, fault.stage, fault.gear)}"}
        for number, fault in scene.tooth_faults.items()
        if fault.tooth is not None
    }


def _teeth(scene: Scene, stage: int, gear: str) -> int:
    pair = scene.stages[stage - 1]
    return pair.pinion_teeth if gear == "pinion" else pair.wheel_teeth


def _put(tree: dict[str, Any], over: Over) -> None:
    """The variable at its place in a tree of settings."""
    *path, last = over.key.split(".")
    for key in path:
        tree = tree.setdefault(key, {})
    tree[last] = f"${over.variable}"
