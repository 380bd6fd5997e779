"""`--json`: what a command found, in numbers for programs; the schema that editors check scenes against."""

import json
import math
import tomllib
from importlib import resources

import jsonschema
import numpy as np
import pytest

from pipelines.cli.main import main
from pipelines.io.json_text import json_text
from pipelines.scene.load_scene import load_scene, shipped_names
from pipelines.scene.schema import scene_schema


def told(capsys, *words):
    assert main(list(words)) == 0
    return json.loads(capsys.readouterr().out)


def test_what_is_no_finite_number_is_null_and_arrays_are_lists():
    found = json.loads(json_text({"a": np.array([[1.0, math.nan]]), "b": (np.int64(2), math.inf), 3: None}))
    assert found == {"a": [[1.0, None]], "b": [2, None], "3": None}


def test_check_gives_its_facts_in_SI(capsys):
    found = told(capsys, "check", "rig-missing-tooth", "--json")
    assert found["units"] == "SI"
    assert found["facts"]["motor_speed"] == pytest.approx(900 / 60 * 2 * math.pi)
    assert found["facts"]["stages"][0]["mesh_frequency"] == pytest.approx(300.0)
    assert found["control"] == "rig-healthy"


def test_gears_and_modes_give_numbers_that_are_not_rounded(capsys):
    (row,) = told(capsys, "gears", "minimal", "--quiet", "--json")["pairs"]
    assert row["secant N/um"] == pytest.approx(row["load N"] / row["TE um"], rel=0.2)
    modes = told(capsys, "modes", "minimal", "--quiet", "--up-to", "400", "--json")["modes"]
    assert modes[0]["dominant"] == "motor coupling"
    assert all(mode["frequency_Hz"] <= 400 and 0 < mode["damping_ratio"] < 1 for mode in modes)
    assert all(sum(mode["shares"].values()) == pytest.approx(1.0) for mode in modes)


@pytest.fixture(scope="module")
def validator():
    schema = scene_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("name", shipped_names())
def test_every_shipped_scene_as_written_and_as_resolved_fits_the_schema(validator, name):
    text = (resources.files("pipelines.scene") / "shipped" / f"{name}.toml").read_text(encoding="utf-8")
    for tree in (tomllib.loads(text), tomllib.loads(load_scene(name).resolved())):
        assert [error.json_path for error in validator.iter_errors(tree)] == []


@pytest.mark.parametrize(
    "text",
    [
        "stages = [{ face_widht_mm = 12 }]",
        "simulation = { end_s = -1 }",
        "casing = { model = 'rubber' }",
        "shaft_model = { model = 3 }",
        "gearbox = 1",
    ],
)
def test_the_schema_refuses_what_a_scene_cannot_hold(validator, text):
    assert list(validator.iter_errors(tomllib.loads(text)))


@pytest.mark.parametrize("text", ["stages.1.face_width_mm = 14.0", "extends = 'bench'", "load.container_kg = 80"])
def test_the_schema_takes_a_variant_of_another_scene(validator, text):
    assert not list(validator.iter_errors(tomllib.loads(text)))


def test_the_schema_is_printed_or_written(capsys, tmp_path):
    assert told(capsys, "schema")["title"] == "gearcase scene"
    assert main(["schema", "--out", str(tmp_path / "scene.json")]) == 0
    assert "stages" in json.loads((tmp_path / "scene.json").read_text(encoding="utf-8"))["properties"]
