"""The plan of a campaign: a TOML file, of which all errors are reported together.

scene = "bench"                     # a shipped scene, or a path ending in .toml
design = "sobol"
scenes = 2000

[variables]
speed_rpm = { from = 600.0, to = 1500.0 }
state = ["healthy", "chipped"]

[settings]                          # keys of the scene; "$..." is an expression of variables
drive.speeds_rpm = [0.0, "$speed_rpm", "$speed_rpm"]

[cases.state.healthy]               # settings for one value of a variable
faults = []
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from pipelines.datasets.expressions import Expression, ExpressionError
from pipelines.datasets.labels import COLUMNS
from pipelines.datasets.typical_spread import typical
from pipelines.datasets.variables import ListTable, Variable
from pipelines.io.errors import InputError, SceneError
from pipelines.io.not_a_scene import SCENE_KEYS
from pipelines.io.toml_text import format_document
from pipelines.machine.machine_model import MachineModel
from pipelines.scene.load_scene import LoadedScene, Source, find_source, load_scene, parse, validate
from pipelines.scene.merge import Merged, Whole, leaves, merge
from pipelines.scene.presets import preset_on
from pipelines.scene.shipped_files import anchored
from pipelines.scene.tables.scene_table import Number, Table
from pipelines.scene.tables.scene_table import Whole as Integer

MOST_SCENES = 1_000_000
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_FIXED = ("simulation.end_s", "simulation.output_rate_Hz", "sensors", "probes")  # they determine the shape of arrays
_VIEWS = ("diagnosis", "control", "title", "extends")  # the motion does not depend on them


class SplitTable(Table):
    """Split of the scenes into parts for training and test. Scenes with equal values of all of `by` stay together."""

    by: Annotated[
        tuple[str, ...] | None,
        Field(description="variables that form the groups; without it: those in deviations.seed"),
    ] = None
    test: Annotated[Number, Field(ge=0, lt=1, description="share of the groups for testing")] = 0.3
    validation: Annotated[Number, Field(ge=0, lt=1, description="share of the groups for validation")] = 0.0


class PlanTable(Table):
    """Plan of a campaign: a scene, the variables, and the design that samples them."""

    title: Annotated[str, Field(max_length=200, description="one line that names the campaign")] = ""
    licence: Annotated[str, Field(max_length=200, description="licence of the data set, printed in its card")] = ""
    scene: Annotated[str, Field(description="a shipped scene, or a path ending in .toml")]
    preset: Annotated[
        Literal["draft", "standard", "reference"] | None,
        Field(description="accuracy of meshes and time step; without it: as in the scene"),
    ] = None
    design: Annotated[
        Literal["grid", "random", "latin-hypercube", "sobol"], Field(description="how the scenes are chosen")
    ] = "sobol"
    spread: Annotated[
        Literal["typical"] | None,
        Field(description="typical: also vary what differs between machines of one design, see docs/campaigns.md"),
    ] = None
    scenes: Annotated[Integer | None, Field(ge=1, le=MOST_SCENES, description="number of scenes; not with a grid")] = (
        None
    )
    seed: Annotated[Integer, Field(ge=0, lt=2**63, description="seed of the random numbers")] = 1
    signals: Annotated[
        tuple[str, ...], Field(max_length=100, description="stored signals; without it: see docs/campaigns.md")
    ] = ()
    variables: Annotated[dict[str, Variable], Field(default={}, max_length=100, description="what is varied")]
    settings: Annotated[dict[str, Any], Field(default={}, description='keys of the scene, "$..." is an expression')]
    cases: Annotated[
        dict[str, dict[str, dict[str, Any]]], Field(default={}, description="settings for each value of a variable")
    ]
    constraints: Annotated[tuple[str, ...], Field(max_length=100, description="expressions that must be true")] = ()
    split: SplitTable = SplitTable()

    @model_validator(mode="after")
    def _consistent(self) -> PlanTable:
        problems = [*self._names(), *self._cases(), *self._expressions(), *self._paths(), *self._counts()]
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _names(self) -> Iterator[str]:
        for name in self.variables:
            if not _NAME.fullmatch(name):
                yield f"variables: {name!r} is not a valid name; use letters, digits and _, a letter first"
            elif name in COLUMNS:
                yield f"variables: {name!r} is a column of every data set; set another name"
            elif name not in self.cases and not any(re.search(rf"\b{name}\b", text) for _, text in self.references()):
                yield f'variables: {name!r} is not used; write "${name}" in [settings] or [cases], or delete it'
        for name in self.split.by or ():
            if name not in self.variables:
                yield f"split.by: {name!r} is not a variable; allowed: {', '.join(self.variables) or 'none'}"
        if self.split.test + self.split.validation >= 1.0:
            yield (
                f"split: test and validation add up to {self.split.test + self.split.validation:g}; reduce them below 1"
            )

    def _cases(self) -> Iterator[str]:
        for name, cases in self.cases.items():
            variable = self.variables.get(name)
            if not isinstance(variable, ListTable):
                yield f"cases.{name}: {name!r} is not a variable with a list of values; add it to [variables]"
                continue
            known = {str(value) for value in variable.values}
            for case in cases:
                if case not in known:
                    yield f"cases.{name}.{case}: not a value of {name}; allowed: {', '.join(sorted(known))}"
            for value in sorted(known - cases.keys()):
                yield f"cases.{name}: {value} has no settings; add [cases.{name}.{value}], empty if nothing changes"

    def _expressions(self) -> Iterator[str]:
        texts = [("constraints", text) for text in self.constraints]
        texts += [(".".join(path), text[1:]) for path, text in self.references()]
        for where, text in texts:
            try:
                names = Expression(text).names
            except ExpressionError as error:
                yield f"{where}: {error}"
                continue
            for name in names:
                if name not in self.variables:
                    yield f"{where}: {name!r} is not a variable; allowed: {', '.join(self.variables) or 'none'}"

    def _paths(self) -> Iterator[str]:
        """Errors of settings that a campaign cannot have, or that must be the same in all scenes."""
        varied = {path for path, _ in self.references()}
        varied |= {path for cases in self.cases.values() for case in cases.values() for path in leaves(case)}
        for path in sorted({*leaves(self.settings), *varied}):
            name = ".".join(path)
            if path[0] in _VIEWS:
                yield f"{name}: no motion depends on it; delete it (noise and pieces are made from the stored signals)"
            elif path in varied and name.startswith(_FIXED):
                yield (
                    f"{name}: must be equal in all scenes, because one array holds their signals; set a constant in "
                    "[settings]"
                )

    def _counts(self) -> Iterator[str]:
        if self.design == "grid":
            if self.scenes is not None:
                yield "scenes: the values of a grid give its number of scenes; delete the key"
            for name, variable in self.variables.items():
                try:
                    variable.grid()
                except ValueError as error:
                    yield f"variables.{name}: {error}"
        elif self.scenes is None:
            yield "scenes: is missing; set the number of scenes"

    def references(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Texts of all settings that begin with $, with their paths."""
        yield from expressions(self.settings)
        for cases in self.cases.values():
            for case in cases.values():
                yield from expressions(case)


def expressions(value: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """Texts in a tree that begin with $, with their paths; items of lists count from 1."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from expressions(item, (*path, str(key)))
    elif isinstance(value, list | tuple):
        for number, item in enumerate(value, 1):
            yield from expressions(item, (*path, str(number)))
    elif isinstance(value, str) and value.startswith("$"):
        yield path, value


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A valid plan with its scene. `tree` is the scene before variables are set, without control and windows."""

    name: str
    text: str
    table: PlanTable
    tree: Mapping[str, Any]


def load_plan(file: str | Path) -> Plan:
    """Read a plan and its scene.

    Raises
    ------
    SceneError : with all problems of the plan, or of the scene
    InputError : a file is missing or not TOML
    """
    source, tree = plan_tables(file)
    table, _ = validate(Merged(tree), PlanTable, source.shown)
    found = find_source(table.scene, source.folder)
    loaded = load_scene(found.name if found.folder is None else found.folder / f"{found.name}.toml")
    scene = preset_on(loaded, table.preset).tree if table.preset else loaded.tree
    return Plan(
        name=source.name, text=source.text, table=_populated(table, tree, scene, source.shown), tree=_bare(scene)
    )


def plan_tables(file: str | Path) -> tuple[Source, dict[str, Any]]:
    """The file of a plan, and its tables, not validated.

    Raises
    ------
    InputError : it is missing, not TOML, or a scene
    """
    name = str(file)
    if not name.endswith(".toml"):
        raise InputError(f"{name}: the plan of a campaign must end in .toml. docs/campaigns.md shows one.")
    if not Path(name).is_file():
        raise InputError(f"{name}: no such file. Correct the path, or write a plan as docs/campaigns.md shows.")
    source = find_source(name)
    tree = parse(source)
    if any(key in tree for key in SCENE_KEYS):
        raise InputError(
            f"{source.shown}: this is a scene, and the plan of a campaign is needed. Write a plan that names the "
            "scene, as docs/campaigns.md shows."
        )
    return source, dict(anchored(tree, source.folder))


def _populated(table: PlanTable, tree: Mapping[str, Any], scene: Mapping[str, Any], shown: str) -> PlanTable:
    """A plan with the variables and settings of its population; `tree` are its tables, `shown` is its name."""
    if not table.spread:
        return table
    variables, settings = typical(scene, table.settings)
    settings = merge(Merged(settings), table.settings).tree
    spread = {"variables": variables | tree.get("variables", {}), "settings": settings}
    return validate(Merged({**tree, **spread}), PlanTable, shown)[0]


def stored_plan(facts: Mapping[str, Any]) -> Plan:
    """The plan in campaign.json.

    Raises
    ------
    InputError : this version cannot read the plan
    """
    try:
        table, _ = validate(Merged(dict(facts["facts"]["plan"])), PlanTable, "the stored plan")
    except SceneError as error:
        raise InputError(
            f"{error}\nAnother version of gearcase made this data set. Install that version to read it."
        ) from error
    return Plan(name=facts["name"], text="", table=table, tree=facts["facts"]["scene"])


@dataclass(frozen=True, kw_only=True)
class VariedKey:
    """A key of the scene that a study varies, with items counted from 1 as in `--set`."""

    key: str

    @property
    def variable(self) -> str:
        """Its name as a variable of a plan: "load_torque_N_m"."""
        return self.key.replace(".", "_").replace("-", "_")


def plan_of_study(loaded: LoadedScene, machine: MachineModel, tables: Mapping[str, Any], name: str) -> Plan:
    """The plan of a study on a loaded scene with all its settings: accelerations and shaft angles, without a split.

    Parameters
    ----------
    loaded, machine : the scene and its machine
    tables : those of a plan file, without scene, signals and split
    name : of the plan

    Raises
    ------
    SceneError : with all problems of the tables
    """
    signals = ["acceleration" if machine.sensors else "journal_acceleration", "shaft_angle"]
    told = {"scene": loaded.name, **tables, "signals": signals, "split": {"test": 0.0}}
    table, _ = validate(Merged(told), PlanTable, f"plan {name}")
    table = _populated(table, told, loaded.tree, f"plan {name}")
    return Plan(name=name, text=format_document(told), table=table, tree=_bare(loaded.tree))


def _bare(tree: Mapping[str, Any]) -> dict[str, Any]:
    """A scene without control, and without windows of the diagnosis, which may exceed its duration."""
    bare = {key: value for key, value in tree.items() if key != "control"}
    diagnosis = {key: value for key, value in bare.get("diagnosis", {}).items() if key != "windows_s"}
    return {**bare, "diagnosis": Whole(diagnosis)} if diagnosis else {k: v for k, v in bare.items() if k != "diagnosis"}
