"""The hand-written pages name what exists: every model a scene may choose, every integrator, every module."""

import json
import re
import runpy
import typing

import pytest
from sources import ROOT

import gearcase
from benchmarks import page
from benchmarks.__main__ import RESULTS
from benchmarks.modules import modules
from fem.contact.models.mesh_model_registry import MODELS as MESHES
from mbd.forces.bearing_models import BEARINGS
from mbd.forces.hanging_loads import LOADS
from mbd.integrators.methods import METHODS
from pipelines.cli.command_line import COMMANDS
from pipelines.scene.tables import casing, losses, shafts
from pipelines.scene.tables.simulation import SimulationTable

DOCS = ROOT / "docs"


def choices(table, field="model"):
    return typing.get_args(table.model_fields[field].annotation)


MODELS = [
    *MESHES,
    *(choices(t)[0] for t in casing.CASING_TABLES),
    *LOADS,
    *BEARINGS,
    *(choices(t)[0] for t in typing.get_args(typing.get_args(losses.LossModel)[0])),
    *choices(shafts.ShaftModelTable),
    *choices(SimulationTable, "integrator"),
]


@pytest.mark.parametrize("model", MODELS)
def test_every_model_has_its_row_in_the_guide(model):
    text = (DOCS / "choosing-a-model.md").read_text(encoding="utf-8")
    assert re.search(rf"\| `{model}`( \(default\))? \|", text) or f"`{model}` is the one model" in text


def test_every_integrator_of_the_scene_exists():
    assert set(choices(SimulationTable, "integrator")) <= METHODS.keys()


@pytest.mark.parametrize("page", sorted(path.name for path in DOCS.glob("*.md")))
def test_modules_and_files_that_a_page_names_exist(page):
    text = (DOCS / page).read_text(encoding="utf-8")
    known = {*modules(), *(name.rpartition(".")[0] for name in modules())}
    for name in set(re.findall(r"`((?:fem|mbd|pipelines|gearcase)(?:\.\w+)+)`", text)):
        assert name in known or name.rpartition(".")[0] in known, name
    for name in set(re.findall(r"`((?:fem|mbd|pipelines|gearcase|tests|benchmarks)/[\w/.-]+)`", text)):
        if page != "extending.md":  # where files are made
            assert (DOCS.parent / name).exists(), name


@pytest.mark.parametrize("page", sorted(path.name for path in DOCS.glob("*.md")))
def test_links_between_pages_lead_somewhere(page):
    for target in re.findall(r"\]\(([\w./-]+\.md)\)", (DOCS / page).read_text(encoding="utf-8")):
        assert (DOCS / target).exists()


@pytest.mark.parametrize("name", ["conditions", "presets", "mesh", "casing", "models", "precision"])
def test_measured_blocks_of_the_guide_are_what_was_measured(name):
    text = (DOCS / "choosing-a-model.md").read_text(encoding="utf-8")
    block = page.blocks(json.loads(RESULTS.read_text(encoding="utf-8")))[name]
    assert page.BEGIN.format(name) in text
    assert page.filled(text, name, block) == text, "run: python -m benchmarks"


def test_the_reference_has_a_page_for_every_public_name_and_command():
    made = runpy.run_path(str(DOCS / "reference_pages.py"))
    assert {f"python/{name}.md" for name in gearcase.__all__} <= made["python_pages"]().keys()
    assert {f"commands/{name}.md" for name in COMMANDS} <= made["command_pages"]().keys()
