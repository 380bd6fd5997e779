"""The plan of a data set as it was stored, and what it says of every run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipelines.datasets.plan import Plan, PlanTable
from pipelines.datasets.scenes import scene_of
from pipelines.io.errors import InputError, SceneError
from pipelines.scene.file import validate
from pipelines.scene.merge import Merged
from pipelines.scene.train import stage_shafts


def stored_plan(facts: Mapping[str, Any]) -> Plan:
    """The plan in campaign.json.

    Raises
    ------
    InputError : it is none that this version reads
    """
    try:
        table, _ = validate(Merged(dict(facts["facts"]["plan"])), PlanTable, "the stored plan")
    except SceneError as error:
        raise InputError(
            f"{error}\nAnother version of gearcase made this data set. Install that version to read it."
        ) from error
    return Plan(name=facts["name"], text="", table=table, tree=facts["facts"]["scene"])


def shaft_meshes(plan: Plan, values: Mapping[str, Any]) -> list[dict[int, int]]:
    """For every shaft of the scene of these values, the teeth of its gears by the number of their stage.

    SceneError, ExpressionError as `pipelines.datasets.scenes.scene_of`.
    """
    scene = scene_of(plan, values).scene
    found: list[dict[int, int]] = [{} for _ in scene.shafts]
    for number, (stage, ends) in enumerate(zip(scene.stages, stage_shafts(scene.stages), strict=True), 1):
        for shaft, teeth in zip(ends, (stage.pinion_teeth, stage.wheel_teeth), strict=True):
            found[shaft][number] = teeth
    return found
