"""The example: it runs on a data set as campaigns make it, keeps groups apart, and a leaking split flatters it."""

import importlib.util
import shutil
import subprocess
import sys

import numpy as np
import pandas
import pytest
from datasets import PLAN, make_dataset
from sources import ROOT

from pipelines.cli.main import main
from pipelines.datasets.estimate import estimate
from pipelines.datasets.plan import load_plan
from pipelines.datasets.scenes import sampled_scenes

EXAMPLE = ROOT / "examples" / "classify_bench.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("classify_bench", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_the_example_goes_through_on_known_signals(example, tmp_path, monkeypatch, capsys):
    folder = make_dataset(tmp_path / "known", PLAN.replace("scenes = 8", "scenes = 30"))
    monkeypatch.setattr(example, "REPEATS", 1)
    done = []

    def command(*words):
        done.append(words[0])
        if words[0] == "features":
            assert main([*words, "--processes", "1"]) == 0

    monkeypatch.setattr(example, "_gearcase", command)
    example.main(folder)
    text = capsys.readouterr().out
    assert done == ["campaign", "features"]
    assert "missing-tooth" in text
    assert "by chance" in text
    assert (folder / "confusion.png").stat().st_size > 1000


def test_pieces_of_one_run_in_both_parts_flatter_a_classifier_that_knows_nothing(example, monkeypatch):
    """Labels by lot, and values that tell the run alone: right by chance, unless the run has been seen."""
    monkeypatch.setattr(example, "REPEATS", 3)
    random = np.random.default_rng(0)
    run = np.repeat(np.arange(60), 6)
    labels = pandas.Series(random.permutation(np.repeat(["a", "b", "c"], 20))[run])
    values = random.standard_normal((60, 8))[run] + 0.05 * random.standard_normal((360, 8))
    assert example.scores(values, labels, run) < 0.55
    assert example.scores(values, labels, np.arange(360)) > 0.95


def test_the_plan_of_the_example_can_be_run_and_keeps_specimens_apart():
    plan = load_plan(EXAMPLE.with_suffix(".toml"))
    sampled = sampled_scenes(plan)
    assert {sample.group for sample in sampled if sample.split == "test"}.isdisjoint(
        sample.group for sample in sampled if sample.split == "train"
    )
    assert len(sampled) == 240
    first = [sample for sample in sampled if sample.run < 12]
    assert estimate(plan, first).labels.keys() == {"healthy", "chipped-tooth", "cracked-tooth"}


@pytest.mark.slow
def test_from_an_empty_folder_to_the_confusion_matrix(tmp_path):
    """The whole way with 48 scenes of 0.5 s."""
    text = EXAMPLE.with_suffix(".toml").read_text(encoding="utf-8")
    text = text.replace("scenes = 240", "scenes = 48").replace("end_s = 1.0", "end_s = 0.6").replace(", 1.0]", ", 0.6]")
    (tmp_path / "classify_bench.toml").write_text(text, encoding="utf-8")
    shutil.copy(EXAMPLE, tmp_path)
    code = [sys.executable, "classify_bench.py", "made"]
    done = subprocess.run(code, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "by chance" in done.stdout
    for words in (("check",), ("info",)):
        assert main(["dataset", *words, str(tmp_path / "made")]) == 0
