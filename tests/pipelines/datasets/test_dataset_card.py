"""The card of a data set says what is in it, and the ways to load it that it shows work."""

import re

import pytest
from datasets import PLAN, make_dataset

from pipelines.cli.main import main
from pipelines.datasets.card import write_card
from pipelines.datasets.labels import COLUMNS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    plan = PLAN.replace("scenes = 8", "scenes = 12\nlicence = 'CC-BY-4.0'")
    folder = make_dataset(tmp_path_factory.mktemp("card") / "known", plan, failed=(3,))
    assert main(["features", str(folder), "--processes", "1"]) == 0
    write_card(folder)
    return folder


@pytest.fixture
def card(folder):
    return (folder / "README.md").read_text(encoding="utf-8")


def test_the_card_names_what_is_stored_and_how_it_was_made(card):
    assert card.startswith("# Known signals\n")
    assert "| `acceleration` | (run, sensor, axis, time) | (12, 2, 3, 4000) | float32 | m/s2 |" in card
    assert all(f"| `{name}` |" in card for name in COLUMNS)
    assert "| speed_rpm | uniform from 600 to 1500 | drive.speeds_rpm |" in card
    assert "| seed | whole numbers from 1 to 6 | deviations.seed |" in card
    assert "Runs with equal `seed` are one group" in card
    assert "mesh iso" in card
    assert "worst 1.2 %" in card
    assert "Failed runs: 1," in card


def test_counts_of_the_card_are_those_of_the_runs(card):
    counts = re.findall(r"^\| (healthy|missing-tooth) \| (\d+) \| (\d+) \|$", card, re.M)
    assert len(counts) == 2
    assert sum(int(number) for _, *numbers in counts for number in numbers) == 11


def test_the_licence_is_that_of_the_plan_and_none_is_made_up(card, tmp_path):
    assert "\nLicence: CC-BY-4.0\n" in card
    silent = make_dataset(tmp_path / "silent")
    write_card(silent)
    assert "\nLicence: not stated." in (silent / "README.md").read_text(encoding="utf-8")


def test_a_card_can_be_written_while_nothing_is_done(tmp_path):
    folder = make_dataset(tmp_path / "empty", left_out=range(8))
    write_card(folder)
    assert "8 not done of 8 runs" in (folder / "README.md").read_text(encoding="utf-8")


BLOCKS = ("xarray, by run", "xarray alone", "pandas", "scikit-learn", "PyTorch")


@pytest.mark.parametrize("name", BLOCKS)
def test_what_the_card_says_on_loading_works(folder, card, monkeypatch, capsys, name):
    found = re.search(rf"^### {re.escape(name)}\n\n```python\n(.*?)^```", card, re.M | re.S)
    code = compile(found[1], name, "exec")
    if name == "PyTorch":
        pytest.importorskip("torch")
    monkeypatch.chdir(folder)
    exec(code, {"__name__": "card"})
    assert capsys.readouterr().out or name == "PyTorch"


def test_every_way_to_load_is_tested(card):
    assert tuple(re.findall(r"^### (.*)$", card, re.M)) == BLOCKS
