"""Finished runs are found by path, scene, folder and number, listed with what sets them apart, compared and removed."""

import json
import os
import shutil
import subprocess
from dataclasses import replace

import pytest

from pipelines.cli.main import main
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError
from pipelines.runs.kept_runs import differing, kept_runs
from pipelines.runs.removed_runs import runs_to_remove
from pipelines.runs.run import run_scene
from pipelines.runs.run_folder import find_run, note_latest
from pipelines.scene.load_scene import load_scene

DAY = 86400.0
NOW = 1.8e9
MADE = (  # scene, folder, container in kg, verdict, days before NOW
    ("minimal", "first", 100.0, "", 40),
    ("minimal", "second", 120.0, "Pinion 1 rises most: 12.5 dB. More.\n\nmore", 3),
    ("bench", "only", None, "One tooth of the wheel chipped: seen.", 1),
)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Three runs without signals, oldest first."""
    monkeypatch.chdir(tmp_path)
    for scene, name, mass, verdict, days in MADE:
        folder = tmp_path / "runs" / scene / name
        folder.mkdir(parents=True)
        settings = {} if mass is None else {"load.container_kg": mass}
        (folder / "scene.resolved.toml").write_text(load_scene(scene, settings).resolved(), encoding="utf-8")
        (folder / "response.nc").write_bytes(b"x" * 1000)
        os.utime(folder / "response.nc", (NOW - DAY * days,) * 2)
        if verdict:
            (folder / "verdict.txt").write_text(verdict, encoding="utf-8")
        note_latest(folder)
    return tmp_path


def test_runs_are_listed_newest_first_with_verdict_size_and_age(here):
    found = kept_runs(here / "runs", NOW)
    assert [(run.number, run.scene, run.folder.name) for run in found] == [
        (1, "bench", "only"), (2, "minimal", "second"), (3, "minimal", "first"),
    ]  # fmt: skip
    assert [round(run.age / DAY) for run in found] == [1, 3, 40]
    assert found[1].verdict == "Pinion 1 rises most: 12.5 dB."
    assert all(run.bytes > 1000 for run in found)


@pytest.mark.parametrize("name", ["2", "minimal", "minimal/second", "runs/minimal/second", "minimal.toml"])
def test_a_run_is_named_by_number_scene_folder_or_path(here, name):
    assert find_run(name).resolve() == here / "runs" / "minimal" / "second"


def test_a_number_beyond_the_list_is_refused_with_the_list(here):
    for number in ("0", "4"):
        with pytest.raises(
            InputError, match=rf"run {number}: there is no run of this number; .* has 3 runs\. List them: gearcase runs"
        ):
            find_run(number)


def test_a_folder_that_is_called_like_a_number_counts_more(here):
    shutil.copytree(here / "runs" / "bench" / "only", here / "3")
    assert find_run("3").name == "3"


def test_the_list_shows_what_sets_runs_of_a_scene_apart_and_nothing_else(here, capsys):
    assert main(["runs", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["differs_in"] for row in rows] == [{}, {"load.container_kg": 120.0}, {"load.container_kg": 100.0}]
    assert [row["verdict"] for row in rows][2] is None
    assert main(["runs"]) == 0
    text = capsys.readouterr().out
    assert "load.container_kg=120" in text
    assert "not diagnosed" in text
    assert main(["runs", "list", "bench"]) == 0
    assert "minimal" not in capsys.readouterr().out


def test_runs_with_other_baselines_differ_in_them(here):
    for name, count in (("first", 0), ("second", 8)):
        (here / "runs" / "minimal" / name / "run.json").write_text(json.dumps({"baseline": count}), encoding="utf-8")
    _, second, first = kept_runs(here / "runs", NOW)
    unlike = differing([second, first])
    assert [unlike[run.number]["--baseline"] for run in (second, first)] == [8, 0]


def test_what_a_run_has_alone_is_named_before_what_many_runs_have(here):
    one = kept_runs(here / "runs", NOW)[1]
    values = [{"a": 1, "b": 2}, {"a": 1, "b": 2}, {"a": 1, "b": 3}, {"a": 4, "b": 2}]
    runs = [replace(one, number=number, settings=settings) for number, settings in enumerate(values)]
    assert [next(iter(differing(runs)[number])) for number in (2, 3)] == ["b", "a"]


def test_the_table_of_lines_is_no_verdict(here):
    (here / "runs" / "minimal" / "first" / "diagnosis.txt").write_text("A line is marked as detected.")
    assert kept_runs(here / "runs", NOW)[2].verdict == ""


def test_a_spoiled_scene_file_hides_no_run(here):
    (here / "runs" / "bench" / "only" / "scene.resolved.toml").write_text("a = [", encoding="utf-8")
    assert kept_runs(here / "runs", NOW)[0].settings == {}


@pytest.mark.parametrize(
    ("options", "folders"),
    [
        ({"older_than": 2 * DAY}, ["second", "first"]),
        ({"keep": 1}, ["first"]),
        ({"older_than": 50 * DAY, "keep": 1}, []),
        ({}, ["only", "second", "first"]),
    ],
)
def test_old_runs_and_those_behind_the_newest_are_chosen(here, options, folders):
    assert [run.folder.name for run in runs_to_remove(kept_runs(here / "runs", NOW), **options)] == folders


def test_nothing_is_removed_without_yes_and_the_newest_is_noted_anew(here, capsys):
    assert main(["runs", "clean", "2"]) == 0
    assert "Nothing was removed" in capsys.readouterr().out
    assert (here / "runs" / "minimal" / "second").is_dir()
    assert main(["runs", "clean", "2", "--yes"]) == 0
    assert "1 run removed" in capsys.readouterr().out
    assert find_run("minimal").name == "first"
    assert main(["runs", "clean", "bench", "--yes"]) == 0
    assert main(["runs", "clean"]) == 2
    assert "Give their names, --older-than DAYS or --keep N" in capsys.readouterr().err
    with pytest.raises(InputError, match="no result here"):
        find_run("bench")


def test_without_a_run_the_list_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["runs"]) == 0
    assert capsys.readouterr().out == "No runs under ./runs.\n"


FAULTY = {
    "control": "without-faults",
    "faults": [{"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}],
    "simulation.end_s": 0.07,
    "drive": {"times_s": [0.0, 0.07], "speeds_rpm": [6000.0, 6000.0]},
    "diagnosis": {"gear": "pinion", "windows_s": {"lifting": [0.005, 0.07]}},
}


def test_real_runs_are_compared_opened_diagnosed_and_exported_by_number(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    for mass in (80.0, 120.0):
        scene = load_scene("minimal", FAULTY | {"load.container_kg": mass})
        run_scene(scene, with_report=False, work=Work(quiet=True))
    assert main(["runs", "compare", "1", "2"]) == 0
    out = capsys.readouterr().out
    (row,) = [line for line in out.splitlines() if line.startswith("load.container_kg")]
    assert row.split()[1:] == ["120.0", "80.0"]
    assert "sensor_3, m/s2 rms" in out
    assert main(["runs", "compare", "1", "2", "--json"]) == 0
    (row,) = [row for row in json.loads(capsys.readouterr().out) if row["key"] == "load.container_kg"]
    assert [*row.values()][1:] == ["120.0", "80.0"]
    assert main(["diagnose", "2", "--json"]) == 0
    lines = json.loads(capsys.readouterr().out)["lines"]
    assert {line["kind"] for line in lines} == {"envelope", "mesh", "sideband"}
    assert main(["diagnose", "2", "--window", "0.005", "0.07", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] is None
    assert all(one["value"] > 0 for one in found["features"])
    assert main(["diagnose", "2@0.005:0.07", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["features"] == found["features"]
    assert main(["diagnose", "2", "--window", "0.005", "9"]) == 2
    assert "the window from 0.005 to 9 s is not within the recording" in capsys.readouterr().err
    assert main(["export", "2", "--to", "csv"]) == 0
    assert len(list(tmp_path.glob("runs/minimal/*/response.csv"))) == 1
    assert main(["runs", "open", "1"]) == 2
    assert "there is no report" in capsys.readouterr().err
    (find_run("1") / "report.html").write_text("<p>", encoding="utf-8")
    assert main(["runs", "open", "1"]) == 0
    assert opened == [(find_run("1") / "report.html").resolve().as_uri()]


def test_a_shell_takes_the_script_of_its_completion(tmp_path, capsys):
    assert main(["completion", "bash"]) == 0
    script = tmp_path / "gearcase.bash"
    script.write_text(capsys.readouterr().out, encoding="utf-8")
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash here")
    code = f"source {script}; complete -p gearcase"
    done = subprocess.run([bash, "-c", code], capture_output=True, text=True, check=True)
    assert "gearcase" in done.stdout
    for name in ("check", "runs", "clean", "--older-than"):
        assert name in script.read_text(encoding="utf-8")
