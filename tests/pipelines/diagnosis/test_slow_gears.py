"""The slow wheels of the rig: windows long enough for them, and a missing tooth of each that is seen."""

import pytest

from pipelines.machine.machine_conversion import make_drivetrain
from pipelines.runs.diagnosed_run import diagnose_folder, judge_folder
from pipelines.runs.run import run_scene
from pipelines.scene.load_scene import load_scene

SCENES = ("rig-missing-tooth-2", "rig-missing-tooth-3")


@pytest.mark.parametrize("name", SCENES)
def test_every_window_holds_ten_turns_of_the_faulty_wheel(name):
    settings = make_drivetrain(load_scene(name).scene).diagnosis
    assert list(settings.windows) == ["lifting", "lowering"]
    for start, end in settings.windows.values():
        assert (end - start) * settings.revolution_frequency >= 10


def test_the_container_stays_off_the_drums():
    """More than a metre of the five is left at the top."""
    train = make_drivetrain(load_scene("rig-long").scene)
    top = train.hoist.rope_length_at(17.25, train.parts.profile, train.layout.shaft_ratios[train.layout.loaded])
    assert 1.0 < top < 2.0


@pytest.mark.slow
def test_a_missing_tooth_of_the_stage_2_wheel_is_seen_up_and_down(tmp_path):
    finished = run_scene(load_scene(SCENES[0]), out=tmp_path / "run", with_report=False)
    judged = judge_folder(finished.folder)
    assert [case.verdict.first.component for case in judged["cases"]] == ["stage 2 wheel"] * 2
    assert all(case.verdict.damaged for case in judged["cases"])


@pytest.mark.slow
def test_a_missing_tooth_of_the_stage_3_wheel_shows_in_the_envelope(tmp_path):
    finished = run_scene(load_scene(SCENES[1]), out=tmp_path / "run", with_report=False)
    lines = diagnose_folder(finished.folder).lines
    for window in ("lifting", "lowering"):
        assert lines.where(window=window, kind="envelope").detected.sum() >= 4
