"""A run writes its signals before anything is made of them: what fails afterwards does not cost them."""

import json
import os
import subprocess
import sys

import pytest

from pipelines.cli.main import main
from pipelines.engine.cache import Cache
from pipelines.report.figures import render
from pipelines.runs import run_folder

SCENE = """
extends = "minimal"
control = "without-faults"
faults = [{ kind = "missing-tooth", stage = 1, gear = "pinion", tooth = 0 }]
simulation = { end_s = 0.07 }
drive = { times_s = [0.0, 0.07], speeds_rpm = [6000.0, 6000.0] }
diagnosis = { gear = "pinion", windows_s = { lifting = [0.005, 0.07] } }
"""
RUN = ("run", "mine.toml", "--quiet", "--processes", "1")
SIGNALS = {"response.nc", "control.nc", "run.json", "log.jsonl", "scene.asked.toml", "scene.resolved.toml"}
RANKING = {"verdict.json", "verdict.txt"}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GEARCASE_CACHE", str(tmp_path / "cache"))  # a diagnosis that is stored could not fail
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-c", "pass"])
    (tmp_path / "mine.toml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def failing(*_, **__):
    raise IndexError("boolean index did not match")


def test_a_failing_diagnosis_leaves_the_signals_and_can_be_repeated(here, monkeypatch, capsys):
    with monkeypatch.context() as broken:
        broken.setattr("pipelines.diagnosis.control_diagnosis.diagnose", failing)
        assert main(RUN) == 1
    err = capsys.readouterr().err
    folder = run_folder.find_run("mine")
    assert {path.name for path in folder.iterdir()} == SIGNALS | RANKING
    assert "IndexError: boolean index did not match" in err
    assert "(in step diagnose)" in err
    assert f"The signals are kept in {folder}." in err
    assert f"gearcase diagnose {folder}" in err
    log = [json.loads(line) for line in (folder / "log.jsonl").read_text(encoding="utf-8").splitlines()]
    assert any("boolean index" in "".join(line.get("traceback", [])) for line in log)
    assert main(["diagnose", "mine.toml"]) == 0
    assert "of the stage 1 pinion: found." in capsys.readouterr().out


def test_a_failing_report_leaves_signals_and_diagnosis(here, monkeypatch, capsys):
    monkeypatch.setattr("pipelines.report.report.report_body", failing)
    assert main(RUN) == 1
    err = capsys.readouterr().err
    folder = run_folder.find_run("mine")
    made = {f"diagnosis.{ending}" for ending in ("nc", "csv", "json", "md", "txt")}
    assert {path.name for path in folder.iterdir()} == SIGNALS | RANKING | made
    assert f"The signals are kept in {folder}." in err
    assert "gearcase diagnose" not in err
    facts = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    assert "simulate" in {step["step"] for step in facts["steps"]}


@pytest.mark.slow
def test_three_runs_started_together_leave_three_results(here):
    """As a shell starts them: for kg in 80 100 120; do gearcase simulate minimal --set load.container_kg=$kg & done"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    arguments = [
        "-m",
        "pipelines.cli.main",
        "simulate",
        "mine.toml",
        "--processes",
        "1",
        "--set",
        "simulation.end_s=0.01",
    ]
    arguments += ["--set", "diagnosis.windows_s={}"]
    processes = [
        subprocess.Popen(
            [sys.executable, *arguments, "--set", f"load.container_kg={mass}"], env=environment, stderr=subprocess.PIPE
        )
        for mass in (80, 100, 120)
    ]
    for process in processes:
        _, err = process.communicate()
        assert process.returncode == 0, err
    folders = [path for path in (here / "runs" / "mine").iterdir() if path.is_dir()]
    assert len(folders) == 3
    assert run_folder.find_run("mine") in [path.relative_to(here) for path in folders]
    assert all((path / run_folder.RESPONSE).is_file() for path in folders)


@pytest.mark.slow
def test_a_report_whose_pictures_were_left_out_is_made_again(here):
    """The reason may be gone next time; a page without its pictures was kept for good."""
    assert main(RUN) == 0
    assert not list(Cache().entries("report"))
    assert list(Cache().entries("diagnose"))


@pytest.mark.slow
def test_provenance_is_what_the_stages_say_of_themselves(here):
    """A scene without finite elements names none of their libraries; a list by hand did, and left out losses."""
    assert main(RUN) == 0
    facts = json.loads((run_folder.find_run("mine") / run_folder.RUN).read_text(encoding="utf-8"))
    assert facts["models"]["losses"] == "none"
    assert facts["models"] | {"mesh": ["iso"], "casing": "rigid", "integrator": "exponential"} == facts["models"]
    assert {"python", "gearcase", "numpy", "scipy", "numba", "xarray", "matplotlib"} <= facts["versions"].keys()
    assert not {"scikit-fem", "gmsh", "pymetis"} & facts["versions"].keys()
