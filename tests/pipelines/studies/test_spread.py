"""Spread over a population: indices of functions that have known ones, intervals that hold 90 % of further machines."""

import re

import datasets
import numpy as np
import pandas as pd
import pytest
from scipy import stats
from serial_executor import InOrder

from pipelines.cli.main import main
from pipelines.datasets.campaign_scenes import sampled_scenes
from pipelines.datasets.estimate import estimate
from pipelines.datasets.feature_tables import dataset_rows
from pipelines.datasets.folder import begin, identity_facts
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.scene.load_scene import changed, load_scene
from pipelines.studies.spread.population_spread import FEWEST, MEAN, SHARES, spread_plan
from pipelines.studies.spread.sobol_indices import first_order

SHORT = ("simulation.end_s=0.8", "diagnosis.windows_s={ lifting = [0.1, 0.8] }")
RANDOM = np.random.default_rng(3)
PLAN = """
scene = "bench"                 # the command applies the population to its own scene
scenes = 32
[variables]
factor = { from = 0.0, to = 1.0 }
gears = { from = 1, to = 16 }
[settings]
load.container_kg = "$100.0 + factor"
deviations.seed = "$gears"
"""


def ishigami(x):
    """Function of three inputs with the indices 0.314, 0.442 and 0."""
    return np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])


def indices(inputs, output, groups=None, unordered=()):
    """Index and standard error (input,) of one output."""
    groups = [str(number) for number in range(len(output))] if groups is None else groups
    return (one[:, 0] for one in first_order(inputs, output[:, None], groups, unordered))


def test_indices_of_given_data_are_those_of_the_ishigami_function_and_of_samples_made_for_them():
    x = RANDOM.uniform(-np.pi, np.pi, (3, 2000))
    found, error = indices(dict(zip("abc", x, strict=True)), ishigami(x))
    made = stats.sobol_indices(func=ishigami, n=4096, dists=[stats.uniform(-np.pi, 2 * np.pi)] * 3, rng=1).first_order
    for expected, tolerance in ((np.array([0.3139, 0.4424, 0.0]), 0.0), (np.ravel(made), 0.02)):
        assert np.all(np.abs(found - expected) < 3.0 * error + tolerance)
    assert np.all(error < 0.03)


def test_indices_of_few_runs_have_no_bias_and_errors_that_are_not_too_small():
    exact, found = np.array([0.3139, 0.4424, 0.0]), []
    for _ in range(30):
        x = RANDOM.uniform(-np.pi, np.pi, (3, 100))
        index, error = indices(dict(zip("abc", x, strict=True)), ishigami(x))
        found.append((index - exact, error))
    deviation, error = np.array(found).transpose(1, 0, 2)
    assert np.all(np.abs(deviation.mean(axis=0)) < 0.05)  # without the correction 0.12 for the last one
    assert np.all(np.mean(np.abs(deviation) < 1.645 * error, axis=0) > 0.8)


def test_gears_that_several_machines_share_have_an_index_and_gears_of_one_machine_have_none():
    count = 400
    seed, grade = RANDOM.permutation(np.repeat(np.arange(count // 2), 2)), RANDOM.integers(3, size=count)
    x = RANDOM.normal(size=count)
    output = RANDOM.normal(size=count // 2)[seed] + grade + x + RANDOM.normal(size=count)
    found, error = indices({"seed": seed, "grade": grade, "x": x}, output, [str(one) for one in seed], ["seed"])
    assert np.all(np.abs(found - np.array([1.0, 2 / 3, 1.0]) / (3 + 2 / 3)) < 3.0 * error)
    alone, _ = indices({"seed": np.arange(count), "x": x}, output, None, ["seed"])
    assert np.isnan(alone[0])
    assert alone[1] == pytest.approx(found[2])


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A campaign of machines whose upper sideband rises with `factor` and with the gears, by the same variance."""
    place = tmp_path_factory.mktemp("spread")
    (place / "population.toml").write_text(PLAN, encoding="utf-8")
    loaded = changed(load_scene("minimal"), SHORT)
    machine = checked_machine(loaded.scene, "minimal")
    plan = spread_plan(loaded, machine, place / "population.toml", None)
    sampled = sampled_scenes(plan)
    of_gears = np.sqrt(1 / 12) * stats.norm.ppf((np.arange(16) + 0.5) / 16)

    def signals(run, speed_rpm):
        values, phi = sampled[run].values, 2 * np.pi * 15.0 * np.arange(datasets.SAMPLES) / datasets.RATE
        level = 10.0 * (values["factor"] + of_gears[values["gears"] - 1]) - 40.0
        one = np.cos(20 * phi) + 10 ** (level / 20) * np.cos(21 * phi)
        acceleration = np.broadcast_to(one, (2, 3, datasets.SAMPLES)).astype("<f4")
        return {"acceleration": acceleration, "shaft_angle": np.stack([phi, -phi * 20 / 55])}

    folder = place / "made"
    folder.mkdir()
    begin(folder, plan, loaded.resolved(), sampled, datasets.layout(), identity_facts(plan, sampled))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(datasets, "signals", signals)
        for sample in sampled:
            datasets.make_run(folder, plan, sample)
    monitored = machine.monitored
    list(dataset_rows(folder, monitored.windows, monitored.noise, InOrder(), lambda done, total: None))
    return place


def test_the_command_finds_which_variable_makes_the_spread_of_a_sideband(place, capsys):
    given = [f"--set={setting}" for setting in SHORT]
    arguments = ["spread", "minimal", *given, "--over", str(place / "population.toml"), "--out", str(place / "made")]
    assert main([*arguments, "-q", "--feature", "mesh_1_upper"]) == 0
    out = capsys.readouterr().out
    assert "32 machines" in out
    table = pd.read_csv(place / "made" / "spread.csv").fillna({"axis": ""})
    row = table[(table.sensor == MEAN) & (table.component == "stage 1 pinion")].set_index("feature").loc["mesh_1_upper"]
    for name in ("factor", "gears"):
        assert abs(row[name] - 0.5) < 1.645 * row[f"{name}_error"]
    assert row["median"] == pytest.approx(-35.0 + 10 * np.log10(2.0), abs=1.0)  # over the rms
    assert row.high - row.low == pytest.approx(2 * 1.645 * 10.0 * np.sqrt(2 / 12), rel=0.3)
    assert (place / "made" / "spread.png").stat().st_size > 10_000


def test_ends_of_an_interval_hold_nine_of_ten_further_machines():
    held = []
    for _ in range(2000):
        low, high = np.quantile(RANDOM.normal(size=FEWEST), [SHARES[0], SHARES[2]], method="weibull")
        held.append(stats.norm.cdf(high) - stats.norm.cdf(low))
    assert np.mean(held) == pytest.approx(0.9, abs=0.01)


@pytest.mark.parametrize(
    ("text", "count", "message"),
    [
        (PLAN, 5, "5 machines: an interval of 90 % needs 20 or more"),
        (PLAN.replace("scenes = 32", 'design = "grid"'), None, "a grid is no population"),
        (PLAN.replace("$gears", "$gear"), None, "'gear' is not a variable"),
        (PLAN.replace("to = 1.0", "to = -1.0"), None, "less than from"),
        (PLAN.replace("load.container_kg", "load.contaner_kg"), None, "container_kg"),
    ],
)
def test_a_population_that_cannot_be_used_is_refused_with_the_reason(tmp_path, text, count, message):
    (tmp_path / "plan.toml").write_text(text, encoding="utf-8")
    loaded = load_scene("minimal")
    machine = checked_machine(loaded.scene, "minimal")

    def expected():
        plan = spread_plan(loaded, machine, tmp_path / "plan.toml", count)
        return estimate(plan, sampled_scenes(plan))

    with pytest.raises(ValueError, match=re.escape(message)):
        expected()
