"""Warnings of runs are counted wherever a data set is shown; the setting that they name removes them."""

import re
from concurrent.futures import ThreadPoolExecutor

import pytest
from datasets import PLAN, make_dataset
from sources import ROOT

import gearcase
from pipelines.cli.main import main
from pipelines.datasets.campaign_scenes import sampled_scenes, scene_of
from pipelines.datasets.card import write_card
from pipelines.datasets.plan import load_plan
from pipelines.datasets.rows import read_row, write_row, write_table
from pipelines.scene.load_scene import load_scene
from pipelines.signals.motion_warnings import needed_step_us

COARSE = """
scene = "minimal"
scenes = 3
[variables]
speed = { from = 600.0, to = 900.0 }
[settings]
simulation.end_s = 0.08
simulation.output_rate_Hz = 2500.0
simulation.step_us = 400.0
drive.times_s = [0.0, 0.01, 0.08]
drive.speeds_rpm = [0.0, "$speed", "$speed"]
"""


def simulated(folder, text):
    folder.mkdir(exist_ok=True)
    (folder / "plan.toml").write_text(text, encoding="utf-8")
    return gearcase.campaign(folder / "plan.toml", out=folder / "data", executor=ThreadPoolExecutor(1))


def warned(folder, kinds, step_errors):
    """A data set by hand whose runs have these warnings, from run 0 on."""
    made = make_dataset(folder)
    for run, (kind, error) in enumerate(zip(kinds, step_errors, strict=True)):
        row = read_row(made, run)
        row["quality"] |= {"warnings": kind, "step_error": error}
        write_row(made, run, row)
    write_table(made)
    write_card(made)
    return made


def shown(folder, capsys):
    """What `dataset info`, `dataset check` and the card show."""
    capsys.readouterr()
    texts = []
    for action in ("info", "check"):
        assert main(["dataset", action, str(folder)]) == 0
        texts.append(capsys.readouterr().out)
    return [*texts, (folder / "README.md").read_text(encoding="utf-8")]


def test_a_step_that_is_too_long_is_counted_everywhere_and_the_named_one_is_short_enough(tmp_path, capsys):
    done = simulated(tmp_path / "coarse", COARSE)
    (line,) = [line for line in done.lines() if line.startswith("warning: ")]
    assert "3 of 3 runs: the time step is too long" in line
    errors = [read_row(done.folder, run)["quality"]["step_error"] for run in range(3)]
    least, most = (f"{100 * error:.2g}" for error in (min(errors), max(errors)))
    assert f"is {least} to {most} % of their rms, limit 5 %" in line
    (step,) = re.findall(r"Set simulation\.step_us = ([\d.]+) under \[settings\] of the plan", line)
    assert all(line.removeprefix("warning: ") in text for text in shown(done.folder, capsys))
    assert step == needed_step_us(max(errors), step=400e-6, rate=2500.0)
    better = simulated(tmp_path / "fine", COARSE.replace("step_us = 400.0", f"step_us = {step}"))
    assert better.warnings == ()
    info, check, card = shown(better.folder, capsys)
    assert "\n  warnings none\n" in info
    assert check == "3 rows of 3 runs checked: 0 errors, 0 warnings\n"
    assert "Warning" not in card


def test_every_kind_is_counted_over_the_runs_that_have_it(tmp_path, capsys):
    kinds = ("step; energy", "", "repeat", "step; repeat", "", "", "", "")
    folder = warned(tmp_path / "mixed", kinds, (0.06, 0.01, 0.01, 0.24, 0.01, 0.01, 0.01, 0.01))
    info, check, card = shown(folder, capsys)
    for text in (info, check, card):
        assert "2 of 8 runs: the time step is too long. The error of the accelerations is 6 to 24 %" in text
        assert "2 of 8 runs: the motion cannot be repeated" in text
        assert "increase the load in the plan" in text
        assert "1 of 8 runs: the energy balance does not close. Set a smaller simulation.step_us" in text
    assert check.endswith("8 rows of 8 runs checked: 0 errors, 3 warnings\n")
    assert card.count("**Warning.**") == 3


def test_no_number_is_named_for_a_step_that_the_plan_varies(tmp_path, capsys):
    plan = PLAN.replace("[settings]", 'fine = { from = 10.0, to = 20.0 }\n[settings]\nsimulation.step_us = "$fine"')
    made = make_dataset(tmp_path / "varied", plan)
    row = read_row(made, 1)
    write_row(made, 1, row | {"quality": row["quality"] | {"warnings": "step", "step_error": 0.1}})
    write_card(made)
    texts = shown(made, capsys)
    assert all("Set a smaller simulation.step_us under [settings]" in text for text in texts)


def test_a_data_set_without_any_run_has_no_warnings(tmp_path, capsys):
    folder = make_dataset(tmp_path / "empty", left_out=range(8))
    assert main(["dataset", "info", str(folder)]) == 0
    assert "\n  warnings none\n" in capsys.readouterr().out


def plans():
    """Every plan of the pages and examples."""
    pages = [ROOT / "docs" / "campaigns.md", ROOT / "docs" / "tutorials" / "campaign.md"]
    found = {page.stem if page.parent.name == "docs" else "tutorial": page.read_text("utf-8") for page in pages}
    texts = {name: re.findall(r"^```toml\n(.*?)^```", text, re.M | re.S)[0] for name, text in found.items()}
    gallery = (ROOT / "examples" / "gallery" / "campaign.py").read_text("utf-8")
    texts["gallery"] = re.findall(r'"""\n(scene = .*?)"""', gallery, re.S)[0]
    return texts | {path.stem: path.read_text("utf-8") for path in sorted((ROOT / "examples").glob("*.toml"))}


@pytest.mark.parametrize("name", plans())
def test_no_shipped_plan_has_a_longer_time_step_than_its_scene(name, tmp_path):
    (tmp_path / "plan.toml").write_text(plans()[name], encoding="utf-8")
    plan = load_plan(tmp_path / "plan.toml")
    for one in sampled_scenes(plan)[:20]:
        assert scene_of(plan, one.values).scene.simulation.step_us <= (
            load_scene(plan.table.scene).scene.simulation.step_us
        )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["campaigns", "tutorial"])
def test_the_plans_of_the_pages_give_no_warnings(name, tmp_path):
    text = re.sub(r"^scenes = \d+", "scenes = 2", plans()[name], flags=re.M)
    assert simulated(tmp_path / name, text).warnings == ()
