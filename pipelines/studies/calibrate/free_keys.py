"""The free keys of a calibration, and the plans of its campaigns."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pipelines.datasets.plan import Plan, VariedKey, plan_of_study
from pipelines.datasets.typical_spread import put_setting
from pipelines.io.errors import InputError
from pipelines.io.shown_text import number_of, shown
from pipelines.machine.machine_model import MachineModel
from pipelines.scene.load_scene import LoadedScene

FEWEST = 40  # runs of a campaign; half of them for the emulator
SPECIMENS = 4  # pairs of gears of each model that is compared with the recording
STATE, SPECIMEN = "state", "specimen"
BEFORE, AFTER = "before", "after"
_EXAMPLE = (
    "Write --free KEY=LOW..HIGH with a key of the scene whose value is a number, such as "
    "casing.damping_ratio=0.01..0.05."
)


@dataclass(frozen=True, kw_only=True)
class Free(VariedKey):
    """A free key of the scene, and the ends of its uniform prior in the unit of the key."""

    low: float
    high: float


def parse_free(text: str) -> Free:
    """The free key of `KEY=low..high`.

    Raises
    ------
    InputError : there is no key or no range, or the range is empty
    """
    key, _, given = text.partition("=")
    low, _, high = given.partition("..")
    found = Free(key=key.strip(), low=number_of(low), high=number_of(high))
    if not (all(found.key.split(".")) and math.isfinite(found.low) and math.isfinite(found.high)):
        raise InputError(f"--free {shown(text)}: is not a key with a range of numbers. {_EXAMPLE}")
    if not found.low < found.high:
        raise InputError(f"--free {shown(text)}: the range is empty. Give the lower end first. {_EXAMPLE}")
    return found


def calibration_plan(loaded: LoadedScene, machine: MachineModel, free: Sequence[Free], count: int) -> Plan:
    """The plan of the campaign: free keys over their priors, and another pair of gears in each run.

    Parameters
    ----------
    loaded, machine : the scene, and its machine model
    free : the free keys
    count : number of runs

    Raises
    ------
    InputError : no free key, a key twice, or too few runs
    SceneError : the plan is not valid
    """
    if not free or len({one.key for one in free}) < len(free):
        raise InputError(f"--free: give one or more keys, each once. {_EXAMPLE}")
    if count < FEWEST:
        raise InputError(f"--runs {count}: an emulator needs {FEWEST} runs or more. Increase --runs.")
    if any(one.key == "deviations.seed" for one in free):
        raise InputError("--free deviations.seed: differs in all runs. Delete it.")
    variables = {one.variable: {"from": one.low, "to": one.high} for one in free}
    variables[SPECIMEN] = {"from": 1, "to": 1_000_000}
    settings = {one.key: f"${one.variable}" for one in free} | {"deviations.seed": f"${SPECIMEN}"}
    tables = {"design": "latin-hypercube", "scenes": count, "variables": variables, "settings": _tree(settings)}
    return plan_of_study(loaded, machine, tables, f"calibrate-{loaded.name}")


def agreement_plan(loaded: LoadedScene, machine: MachineModel, values: Mapping[str, float]) -> Plan:
    """The plan of the scene before the calibration, and after it with other values by key; each with several gears."""
    cases = {BEFORE: {}, AFTER: _tree(values)}
    variables = {STATE: [BEFORE, AFTER], SPECIMEN: {"from": 1, "to": SPECIMENS}}
    settings = _tree({"deviations.seed": f"${SPECIMEN}"})
    tables = {"design": "grid", "variables": variables, "settings": settings, "cases": {STATE: cases}}
    return plan_of_study(loaded, machine, tables, f"calibrate-{loaded.name}")


def _tree(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings by key as nested tables."""
    tree: dict[str, Any] = {}
    for key, value in settings.items():
        put_setting(tree, key.split("."), value)
    return tree
