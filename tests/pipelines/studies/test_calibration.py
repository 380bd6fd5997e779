"""Calibration: posteriors of models that have a known one; keys without influence on a recording keep their prior."""

import argparse
import re
import sys

import numpy as np
import pytest
from scipy import stats

from pipelines.cli import calibrate
from pipelines.io.errors import InputError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.recordings.machine_file import read_machine
from pipelines.scene.load_scene import load_scene
from pipelines.studies.calibrate.calibration import IDENTIFIABLE, Calibration, recorded_levels
from pipelines.studies.calibrate.free_keys import AFTER, Free, agreement_plan, calibration_plan, parse_free
from pipelines.studies.calibrate.posterior import emulator, sample

pytest.importorskip("emcee")
SCATTER = 0.7  # dB


def levels(points, seed):
    """Levels (run, 40 lines) that depend linearly on the first parameter, bent on the second, and not on the third."""
    random = np.random.default_rng(seed)
    slopes = np.linspace(-6.0, 6.0, 20)
    first, second = points[:, :1] * slopes, (points[:, 1:2] + 0.3 * points[:, 1:2] ** 2) * slopes
    return np.hstack([first, second]) + random.normal(0.0, SCATTER, (len(points), 40))


@pytest.fixture(scope="module")
def emulated():
    points = np.random.default_rng(1).random((160, 3))
    return emulator(points, levels(points, 2))


def posterior(emulated, point, seed):
    return sample(emulated, emulated.summaries(levels(np.array([point]), seed))[0])


def test_the_posterior_of_a_linear_parameter_has_the_width_of_the_normal_distribution(emulated):
    found = posterior(emulated, (0.5, 0.5, 0.5), 3)
    exact = SCATTER / np.sqrt(np.sum(np.linspace(-6.0, 6.0, 20) ** 2))  # of least squares with the known slopes
    assert exact < found[:, 0].std() < 1.6 * exact
    assert abs(found[:, 0].mean() - 0.5) < 4.0 * exact


def test_a_parameter_without_influence_keeps_its_prior_and_is_not_identifiable(emulated):
    found = posterior(emulated, (0.5, 0.5, 0.9), 4)
    free = tuple(Free(key=f"table.key_{number}", low=0.0, high=1.0) for number in range(3))
    made = Calibration(name="x", free=free, samples=found, agreement={}, inside=40, lines=40, runs=160)
    assert made.width[2] == pytest.approx(1.0, abs=0.15)
    assert np.all(made.width[:2] < IDENTIFIABLE)
    assert np.all(np.abs(made.correlation[2, :2]) < 0.3)


@pytest.mark.slow
def test_intervals_hold_the_truth_and_its_ranks_are_uniform(emulated):
    truths = np.random.default_rng(5).random((40, 3))
    ranks = np.array([np.mean(posterior(emulated, one, 10 + n) < one, axis=0) for n, one in enumerate(truths)])
    held = np.mean((ranks > 0.05) & (ranks < 0.95))
    assert stats.binom.ppf(0.001, ranks.size, 0.9) <= held * ranks.size <= stats.binom.ppf(0.999, ranks.size, 0.9)
    assert all(stats.kstest(column, "uniform").pvalue > 1e-3 for column in ranks.T)


def test_a_free_key_is_a_variable_of_the_campaign_and_its_mean_a_setting_of_the_calibrated_scene():
    loaded = load_scene("minimal")
    machine = checked_machine(loaded.scene, "minimal")
    free = parse_free("casing.mount_stiffness_N_per_um=100..400")
    table = calibration_plan(loaded, machine, [free], 50).table
    assert table.variables["casing_mount_stiffness_N_per_um"].to == 400.0
    assert table.settings["deviations"]["seed"] == "$specimen"
    cases = agreement_plan(loaded, machine, {free.key: 250.0}).table.cases["state"]
    assert cases[AFTER] == {"casing": {"mount_stiffness_N_per_um": 250.0}}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["load.container_kg"], "is not a key with a range of numbers"),
        (["load.container_kg=a..b"], "is not a key with a range of numbers"),
        (["load.container_kg=120..80"], "the range is empty"),
        (["load.container_kg=80..120"] * 2, "each once"),
        (["deviations.seed=1..9"], "differs in all runs"),
        ([], "give one or more keys"),
    ],
)
def test_free_keys_that_cannot_be_used_are_refused_with_the_reason(given, message):
    loaded = load_scene("minimal")
    machine = checked_machine(loaded.scene, "minimal")
    with pytest.raises(InputError, match=re.escape(message)):
        calibration_plan(loaded, machine, [parse_free(one) for one in given], 50)


@pytest.mark.parametrize("scene", ["minimal", "bench", "rig-healthy"])
def test_the_key_of_the_remedy_is_one_of_the_scene(scene):
    with pytest.raises(InputError) as refused:
        parse_free("load")
    example = parse_free(re.search(r"such as (\S+)\.$", str(refused.value))[1])
    assert load_scene(scene, {example.key: example.low}).scene.casing.damping_ratio == example.low


def test_a_missing_library_is_named_with_the_command_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(InputError, match=r"pip install 'gearcase\[calibrate\]'"):
        next(calibrate.main(argparse.Namespace(dry_run=True)))  # before the plan, which would be of no use


def test_recordings_without_a_channel_of_the_scene_are_refused_before_anything_is_simulated(tmp_path, caplog):
    rate, random = 10000.0, np.random.default_rng(8)
    samples = int(2 * rate)
    tooth = np.cos(2 * np.pi * 20 * 15.0 * np.arange(samples) / rate)
    np.savez(tmp_path / "r.npz", a=tooth + 0.1 * random.normal(size=samples), fs=rate)
    given = "teeth = [[20, 55]]\nspeed = { rpm = 860, uncertainty_percent = 0.001 }\nsensors = { %s = { z = 'a' } }\n"
    machine = checked_machine(load_scene("minimal").scene, "minimal")
    for name in ("other", machine.sensors[0].name):
        (tmp_path / f"{name}.toml").write_text(given % name, encoding="utf-8")
    source = f"{tmp_path / 'r.npz'}@0:2"
    with pytest.raises(InputError, match=r"no feature in common\. The recordings have the channels other z, the scene"):
        recorded_levels(machine, read_machine(tmp_path / "other.toml"), [source])
    caplog.clear()
    found = recorded_levels(machine, read_machine(tmp_path / f"{machine.sensors[0].name}.toml"), [source])
    assert all(line[0] == machine.sensors[0].name for half in found for line in half)
    assert "shaft 1 turns at 860 rpm, in the scene at 900 rpm" in caplog.text
