"""A shorter simulation keeps the windows that still fit, and says which fell away."""

import warnings

import pytest

from pipelines.cli.main import main
from pipelines.io.errors import SceneError, SceneWarning
from pipelines.scene.load_scene import changed, control_of, load_scene

RIG = "rig-missing-tooth"  # windows: lifting 0.5 to 2.5 s, lowering 3 to 5 s


def windows(loaded):
    return list(loaded.scene.diagnosis.windows_s)


@pytest.mark.parametrize(("end", "kept"), [(5.0, ["lifting", "lowering"]), (2.5, ["lifting"]), (1.0, [])])
def test_windows_that_end_within_the_simulation_stay(end, kept):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert windows(load_scene(RIG, {"simulation.end_s": end})) == kept
    assert len(told) == (len(kept) < 2)


def test_the_warning_names_what_fell_away_and_what_is_left():
    with pytest.warns(SceneWarning, match=r"simulation\.end_s = 2\.7 .*: lowering \(to 5 s\); kept: lifting\."):
        load_scene(RIG, ["simulation.end_s=2.7"])


def test_a_scene_on_top_of_another_and_its_control_are_shortened_alike(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.toml").write_text(f'extends = "{RIG}"\n[simulation]\nend_s = 2.7\n', encoding="utf-8")
    with pytest.warns(SceneWarning):
        assert windows(load_scene("short.toml")) == ["lifting"]
    with pytest.warns(SceneWarning):
        shortened = changed(load_scene(RIG), {"simulation.end_s": 2.7})
    assert windows(control_of(shortened)) == ["lifting"]


def test_the_command_says_it_once(capsys):
    assert main(["check", RIG, "--set", "simulation.end_s=2.7"]) == 0
    assert capsys.readouterr().err.count("lowering") == 1


@pytest.mark.parametrize("span", ["[3.0, 5.0]", "[1.0, 9.0]"])
def test_a_window_that_is_asked_for_with_the_end_is_refused(span):
    with pytest.raises(SceneError, match=r"lowering = .* the window ends after"):
        load_scene(RIG, ["simulation.end_s=2.7", f"diagnosis.windows_s.lowering={span}"])


@pytest.mark.filterwarnings("ignore::pipelines.io.errors.SceneWarning")
def test_what_was_shortened_loads_again_as_it_is():
    loaded = load_scene(RIG, {"simulation.end_s": 2.7})
    again = changed(loaded, {"load.container_kg": 800.0})
    assert windows(again) == ["lifting"]
    assert "lowering" not in loaded.resolved()
