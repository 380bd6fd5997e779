"""A run judges itself: against healthy machines with other deviations, or the control alone."""

import json
import sys
from types import SimpleNamespace

import pytest
import xarray

from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError
from pipelines.report.figures import render
from pipelines.runs.judged_recording import other_speeds
from pipelines.runs.recorded_file import RecordedFile, recording_path
from pipelines.runs.run import run_scene
from pipelines.scene.load_scene import load_scene
from pipelines.signals.motion_warnings import chance_of_run
from pipelines.steps import verdict as verdict_step

SHORT = {
    "drive.speeds_rpm": [0.0, 1800.0, 1800.0],
    "simulation.end_s": 0.3,
    "diagnosis.windows_s": {"steady": [0.1, 0.3]},
    "diagnosis.gear": "pinion",
    "control": "without-faults",
}
MISSING = {**SHORT, "faults": [{"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 3}]}


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    """Of gears and casing: they are tested in test_report_contents.py and test_renderer.py."""
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-S", "-c", "pass"])


def judged(folder, settings, **options):
    finished = run_scene(load_scene("minimal", settings), out=folder, work=Work(quiet=True, processes=1), **options)
    return finished, json.loads((folder / "verdict.json").read_text())


def test_a_missing_tooth_is_found_blind_against_other_healthy_machines(tmp_path):
    finished, verdict = judged(tmp_path / "faulty", MISSING, baseline=6)
    assert finished.words.startswith("Missing tooth 3 of the stage 1 pinion: found. ")
    verdict = verdict["cases"][0]["verdict"]
    assert verdict["damaged"]
    first = verdict["findings"][0]
    assert first["component"] == "stage 1 pinion"
    assert abs(first["tooth"] - 3) <= 1
    assert verdict["healthy"] == 6


@pytest.mark.slow
def test_a_healthy_machine_raises_no_alarm(tmp_path):
    _, verdict = judged(tmp_path / "healthy", {**SHORT, "control": None, "deviations.seed": 20}, baseline=6)
    assert not verdict["cases"][0]["verdict"]["damaged"]


def test_a_result_folder_may_have_a_dot_in_its_name(tmp_path):
    (tmp_path / "run.1").mkdir()
    with pytest.raises(InputError, match="no result here"):
        recording_path(tmp_path / "run.1")
    assert recording_path(tmp_path / "record.csv") == tmp_path / "record.csv"


def test_healthy_recordings_of_another_speed_are_warned_of():
    def recorded(rpm):
        return RecordedFile(
            name="a.csv", table=SimpleNamespace(speed=[rpm / 60]), levels=(), error=0.0, turning="", warnings=()
        )

    near, far = {"near.csv": recorded(1540)}, {f"far-{n}.csv": recorded(1200) for n in range(4)}
    assert other_speeds(recorded(1500), near) == []
    (words,) = other_speeds(recorded(1500), near | far)
    assert words.startswith("4 of 5 healthy recordings differ from 1500 rpm by more than 3 %: far-0.csv 1200 rpm, ")
    assert "far-2.csv 1200 rpm and others. " in words
    assert "far-3.csv" not in words
    assert words.endswith("Give healthy recordings of the same speed and load.")


def test_a_scene_without_faults_is_its_own_control(tmp_path):
    scene = load_scene("minimal", {**SHORT, "deviations.seed": 20})
    finished = run_scene(scene, out=tmp_path / "run", work=Work(quiet=True, processes=1))
    assert finished.words.startswith("A line is marked")
    assert not (tmp_path / "run" / "verdict.json").exists()


def test_against_the_exact_control_limits_come_from_samples_of_the_sensor_noise(tmp_path):
    finished, verdict = judged(tmp_path / "control", MISSING)
    verdict = verdict["cases"][0]["verdict"]
    assert (verdict["exact"], verdict["damaged"]) == (True, True)
    assert verdict["findings"][0]["component"] == "stage 1 pinion"
    assert verdict["findings"][0]["evidence"]["p"] < 1e-3
    assert verdict["different"]
    assert (verdict["healthy"], verdict["tested"]) == (5, 0)
    assert finished.words.startswith("Missing tooth 3 of the stage 1 pinion: found. ")
    assert "5 samples of the sensor noise" in finished.words
    assert "effect of the fault" in finished.words


def test_healthy_machines_differ_by_their_deviations(tmp_path):
    with pytest.raises(InputError, match=r"--baseline: the gears of this scene have no deviations"):
        judged(tmp_path / "none", {**MISSING, "deviations.enabled": False}, baseline=6)
    with pytest.raises(InputError, match=r"--baseline: there is no healthy control"):
        judged(tmp_path / "none", {**MISSING, "control": None}, baseline=6)


@pytest.mark.parametrize(
    ("until", "microseconds", "words"),
    [
        ("the end", 900_000, ""),
        (1.8, 0, ""),  # after the evaluated windows
        (1.2, 0, "the motion is chaotic and cannot be repeated after 1.2 s"),
        ("the end", 1_500_000, "the teeth of mesh_1 are out of contact for 75 % of the time"),
    ],
)
def test_a_run_that_depends_on_chance_has_no_verdict_against_its_control(until, microseconds, words):
    attributes = {"repeatable_until_s": until, "counters": json.dumps({"mesh_1:microseconds_open": microseconds})}
    chance = chance_of_run(xarray.Dataset(coords={"time": [0.0, 2.0]}, attrs=attributes), 1.5)
    assert chance == words
    features = [{"tables": {}, "failure": "", "chance": chance}]
    if chance:
        failure = verdict_step.build(None, (), (("torque", "off"),), True, own=features, healthy=features)["failure"]
        assert failure.startswith(f"{words}, so that differences from the healthy control need not be effects")
        assert failure.endswith("or compare with other healthy machines: --baseline 8.")
