"""Every shipped scene runs: 0.1 s of motion with coarse models, finite numbers, the ledger as it should be."""

import json
import sys

import numpy as np
import pytest
import xarray
from coarse import coarse, diagnosable

import gearcase
from pipelines.io.errors import SceneError
from pipelines.report.figures import render
from pipelines.runs import run_folder
from pipelines.runs.run import run_scene
from pipelines.scene.load_scene import load_scene, shipped_names


@pytest.mark.parametrize("name", shipped_names())
def test_a_shipped_scene_runs(name, tmp_path):
    loaded = load_scene(name, coarse(name))
    finished = run_scene(loaded, out=tmp_path / "out", with_control=False, with_report=False)
    with xarray.open_dataset(finished.folder / run_folder.RESPONSE, engine="h5netcdf") as data:
        data.load()
    samples = round(0.1 * loaded.scene.simulation.output_rate_Hz)
    if loaded.scene.sensors:
        assert data.acceleration.sizes == {"time": samples, "sensor": len(loaded.scene.sensors), "axis": 3}
    else:
        assert "acceleration" not in data
        assert data.sizes["time"] == samples
    for variable in data.data_vars.values():
        assert np.isfinite(variable.values).all()
        assert variable.attrs["units"]
    assert data.attrs["state"] == ("+".join(fault.kind for fault in loaded.scene.faults) or "healthy")
    ledger = json.loads(data.attrs["build_ledger"])
    rope, elastic = loaded.scene.load.model == "rope", loaded.scene.casing.model == "craig-bampton"
    assert ledger["recovery_rows"] == 3 * len(loaded.scene.sensors)
    assert (ledger["rope_coordinates"] > 0) == rope
    assert ("casing_meshes" in ledger) == elastic
    assert ("factorisations" in ledger) == elastic


def test_one_sensor_means_three_recovery_rows(tmp_path):
    settings = coarse("rig-healthy") | {"sensors": [{"name": "sensor_3", "position_mm": [76.7, -150.0, 35.5]}]}
    finished = run_scene(load_scene("rig-healthy", settings), out=tmp_path / "out", with_report=False)
    assert finished.ledger["recovery_rows"] == 3


@pytest.fixture(scope="module")
def whole_run(tmp_path_factory):
    """A faulty scene with its control, both loads, diagnosis and report; test_readme.py draws the casing."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    scene = gearcase.Scene.from_file("rig-missing-tooth").changed(diagnosable("rig-missing-tooth"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(render, "command", lambda _: [sys.executable, "-S", "-c", "pass"])
        return gearcase.run(scene, out=folder), folder


def test_a_whole_run_leaves_everything_in_its_folder(whole_run):
    data, folder = whole_run
    assert {p.name for p in folder.iterdir()} == {
        "response.nc", "control.nc", "diagnosis.nc", "diagnosis.csv", "diagnosis.json", "diagnosis.md", "diagnosis.txt",
        "verdict.json", "verdict.txt", "report.html", "run.json", "log.jsonl",
        "scene.asked.toml", "scene.resolved.toml",
    }  # fmt: skip
    assert data.acceleration.sel(sensor="sensor_3", axis="z").sizes == {"time": 6000}
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "missing" in page
    facts = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    assert facts["ledger"]["simulations"] == 4
    assert facts["ledger"]["casing_meshes"] == facts["ledger"]["factorisations"] == 1
    assert facts["models"]["casing"] == "craig-bampton"
    assert all(step["seconds"] >= 0 and step["peak MB"] > 10 for step in facts["steps"])


def test_the_resolved_scene_of_a_run_gives_the_same_run(whole_run, tmp_path):
    data, folder = whole_run
    again = load_scene(folder / "scene.resolved.toml")
    finished = run_scene(again, out=tmp_path / "again", with_report=False)
    assert {r.name for r in finished.records if not r.reused} == set()
    with xarray.open_dataset(finished.folder / run_folder.RESPONSE, engine="h5netcdf") as second:
        assert second.acceleration.values.tobytes() == data.acceleration.values.tobytes()


def test_the_lines_are_found_again_from_the_folder(whole_run, capsys):
    from pipelines.cli.main import main

    assert main(["diagnose", str(whole_run[1])]) == 0
    out = capsys.readouterr().out
    assert "f_m - f_r" in out
    assert main(["diagnose", str(whole_run[1]), "--set", "diagnosis.sensor=sensor_5", "--set", "diagnosis.axis=x"]) == 0
    assert "sensor_5" in capsys.readouterr().out
    assert main(["diagnose", str(whole_run[1]), "--set", "load.container_kg=4"]) == 2
    assert "Set keys of [diagnosis] only, or simulate again" in capsys.readouterr().err


def test_a_window_without_a_revolution_is_refused_before_the_signals_are_made(tmp_path):
    settings = diagnosable("rig-missing-tooth") | {"diagnosis.windows_s": {"lifting": [0.58, 0.6]}}
    with pytest.raises(SceneError, match=r"diagnosis\.windows_s\.lifting = \[0\.58, 0\.6\]: has 0\.4 revolutions"):
        run_scene(load_scene("rig-missing-tooth", settings), out=tmp_path / "out", both_loads=False)
    assert not (tmp_path / "out").exists()
