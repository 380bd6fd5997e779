"""Every model that a scene can choose runs with its control to diagnosis and report; the tables list the models.

The default tests take the models of all fields side by side, the slow ones each model alone.
"""

import sys
from typing import Literal, get_args, get_origin

import numpy as np
import pytest
import xarray

from pipelines.engine.run_graph import Work
from pipelines.io.errors import SceneError
from pipelines.report.figures import render
from pipelines.runs import run_folder
from pipelines.runs.run import run_scene
from pipelines.scene.load_scene import load_scene
from pipelines.scene.merge import Whole
from pipelines.scene.scene import Scene
from pipelines.signals.line_table import LineTable

SHORT = {  # six turns of the pinion
    "control": "without-faults",
    "faults": [{"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}],
    "simulation.end_s": 0.07,
    "drive.times_s": [0.0, 0.07],
    "drive.speeds_rpm": [6000.0, 6000.0],
    "diagnosis.gear": "pinion",
    "diagnosis.windows_s": {"steady": [0.005, 0.07]},
}
# what a model needs beyond its name
MINIMAL = {
    ("bearings", "hertz"): {"bearings.designation": "6205"},
    ("load", "torque"): {"load.torque_N_m": 55.0},
    ("drive", "torque"): {"torque_N_m": 20.0, "start_rpm": 6000.0},
    ("drive", "induction-motor"): {"synchronous_rpm": 6200.0, "rated_rpm": 6000.0, "rated_torque_N_m": 20.0},
    ("drive", "controlled-motor"): {
        "times_s": [0.0, 0.07],
        "speeds_rpm": [6000.0, 6000.0],
        "proportional_N_m_s_per_rad": 2.0,
        "limit_N_m": 60.0,
        "starting_torque_N_m": 20.0,
    },
    ("casing", "none"): {"sensors": []},
    ("casing", "static"): {"casing.element_size_mm": 40.0},
    ("casing", "craig-bampton"): {"casing.element_size_mm": 40.0, "casing.band_Hz": 1000.0},
}


def models(table):
    """Names of the models by the field of the scene that chooses between them."""
    found = {}
    for name, field in table.model_fields.items():
        if field.discriminator is not None:
            members = get_args(field.annotation)
            tags = [member.model_fields[field.discriminator].annotation for member in members]
            assert all(get_origin(tag) is Literal for tag in tags)
            found[name] = [tag for literal in tags for tag in get_args(literal)]
    return found


MODELS = models(Scene)
SIDE_BY_SIDE = [
    {field: names[number % len(names)] for field, names in MODELS.items()}
    for number in range(max(len(names) for names in MODELS.values()))
]
ALONE = [{field: name} for field, names in MODELS.items() for name in names]


def words(chosen):
    return ", ".join(f"{field} {name}" for field, name in chosen.items())


def loaded(chosen):
    settings = dict(SHORT)
    for field, name in chosen.items():
        if field == "drive" and name != "speed":  # a table of its own; its speed settles too late for a diagnosis
            settings = {key: value for key, value in settings.items() if not key.startswith(("drive.", "diagnosis."))}
            settings |= {"drive": Whole({"model": name, **MINIMAL[field, name]}), "control": None}
            settings["diagnosis.windows_s"] = Whole()
        else:
            settings |= {f"{field}.model": name, **MINIMAL.get((field, name), {})}
    try:
        return load_scene("minimal", settings)
    except SceneError as error:
        pytest.fail(f"{words(chosen)}: add what it needs beyond its name to MINIMAL in {__file__}.\n{error}")


def test_the_tables_are_read():
    assert {"bearings", "casing", "load", "losses"} <= MODELS.keys()
    assert {"rigid", "linear", "hertz"} <= set(MODELS["bearings"])


@pytest.mark.parametrize(
    "chosen",
    [*SIDE_BY_SIDE, *(pytest.param(one, marks=pytest.mark.slow) for one in ALONE)],
    ids=words,
)
def test_every_model_runs_with_its_control(chosen, tmp_path, monkeypatch):
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-c", "pass"])  # pictures are tested elsewhere
    scene = loaded(chosen)
    finished = run_scene(scene, out=tmp_path / "out", both_loads=False, work=Work(processes=1))
    diagnosed = scene.scene.drive.model == "speed"
    for name in (run_folder.RESPONSE, run_folder.CONTROL)[: 1 + diagnosed]:
        with xarray.open_dataset(finished.folder / name, engine="h5netcdf") as data:
            assert all(np.isfinite(variable.values).all() for variable in data.data_vars.values())
    assert (finished.folder / "report.html").is_file()
    assert not [reason for reason in finished.left_out if "diagnosis" in reason]
    if scene.scene.sensors and diagnosed:  # without a casing there is none to look at
        lines = LineTable.load(finished.folder / "diagnosis.nc")
        assert ("bearing" in lines.kind) == (scene.scene.bearings.model == "hertz")
        assert len(lines.of("envelope", "sideband"))
        assert finished.words
