"""Features: the same of a run, of its exported file and of its row in a data set; exact for known signals."""

import json
import os

import numpy as np
import pyarrow.parquet as pq
import pytest
from datasets import RATE, SAMPLES, SENSORS, TEETH, make_dataset
from serial_executor import InOrder

import gearcase
from benchmarks.feature_table import PAGE, feature_table_page
from pipelines.cli.main import main
from pipelines.datasets.feature_source import FEATURES, FeatureSource, write_features
from pipelines.datasets.feature_tables import FEATURE_ROWS
from pipelines.datasets.rows import read_row, row_path, write_row
from pipelines.io.errors import InputError
from pipelines.signals.features.average_features import meshing
from pipelines.signals.features.average_features import synchronous as features_of_average
from pipelines.signals.features.definitions import BY_NAME
from pipelines.signals.features.shaft_turns import cut_turns
from pipelines.signals.features.statistics import statistics
from pipelines.signals.features.synchronous_averages import FEWEST_TURNS, Average
from pipelines.signals.orders.rotation import Rotation

TIME = np.arange(8000) / 8000


def make_features(folder, start=0.0, end=np.inf, noise=0.0, on_progress=lambda done, total: None, executor=None):
    """Number of runs computed now, and of rows of the table of a data set."""
    counts = [0]

    def count(done, total):
        counts[0] = done
        on_progress(done, total)

    frames = FeatureSource([folder], None, start, end, noise).frames(executor or InOrder(), count)
    rows = write_features(folder / FEATURES, frames)
    return counts[0], rows


def synchronous(signal, time, angle, teeth=None):
    """Features of the average of all turns of a shaft."""
    rotation = Rotation(angle=angle, source="stored angle", error=0.0, absolute=True)
    cut = cut_turns(signal, time, rotation, 1.0, (time[0], time[-1]))
    averaged = Average(values=cut.values.mean(axis=1), orders=cut.orders, teeth=[teeth] if teeth else [])
    return features_of_average(averaged) | (meshing(averaged, teeth) if teeth else {})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("features") / "known", failed=(3,))


def test_statistics_of_a_sine_and_of_noise_are_those_of_the_books():
    sine = 3.0 * np.sin(2 * np.pi * 50 * TIME)
    found = {name: float(value) for name, value in statistics(sine).items()}
    assert found["rms"] == pytest.approx(3 / np.sqrt(2))
    assert found["crest_factor"] == pytest.approx(np.sqrt(2))
    assert found["kurtosis"] == pytest.approx(1.5)
    assert found["skewness"] == pytest.approx(0.0, abs=1e-12)
    noise = np.random.default_rng(1).standard_normal((2, 200_000))
    assert np.allclose(statistics(noise)["kurtosis"], 3.0, atol=0.05)
    exponential = np.random.default_rng(1).exponential(size=400_000)
    assert float(statistics(exponential)["skewness"]) == pytest.approx(2.0, rel=0.05)


def test_ratios_of_a_constant_are_not_numbers():
    found = statistics(np.zeros((1, 100)))
    assert np.isnan(found["crest_factor"])
    assert np.isnan(found["kurtosis"])
    assert found["rms"] == 0.0


def speeding_up(turns, length=TIME):
    """Angle of a shaft whose speed rises by half."""
    return 2 * np.pi * turns * (length + 0.25 * length**2) / 1.25


def test_mesh_orders_and_sidebands_keep_their_amplitudes_while_the_speed_changes():
    angle = speeding_up(30)
    tones = {20: 2.0, 19: 0.3, 21: 0.5, 40: 0.1}
    signal = sum(size * np.cos(order * angle + 0.4) for order, size in tones.items())
    found = synchronous(signal[None], TIME, angle, 20)
    expected = {
        "mesh_1": 2.0, "mesh_1_lower": 0.3, "mesh_1_upper": 0.5,
        "mesh_2": 0.1, "mesh_2_lower": 0.0, "mesh_3": 0.0,
        "tsa_rms": np.sqrt((2.0**2 + 0.3**2 + 0.5**2 + 0.1**2) / 2),
        "residual_rms": np.sqrt((0.3**2 + 0.5**2) / 2),
    }  # fmt: skip
    for name, value in expected.items():
        assert found[name][0] == pytest.approx(value, abs=0.004), name


def test_averaging_divides_noise_by_the_root_of_the_revolutions():
    turns = 40
    angle = 2 * np.pi * (turns + 0.01) * TIME
    noise = np.random.default_rng(3).standard_normal((20, TIME.size))
    found = synchronous(noise, TIME, angle)
    kept = found["tsa_rms"].mean()
    assert kept == pytest.approx(1 / np.sqrt(turns), rel=0.15)  # interpolation takes a little of white noise


def test_one_impact_in_a_revolution_makes_the_average_peak():
    angle = speeding_up(30)
    meshing = np.cos(20 * angle) + 0.2 * np.cos(40 * angle)
    impact = 0.5 * np.exp(-(((angle % (2 * np.pi)) - 2.0) ** 2) / 0.01) * np.cos(27 * angle)
    sound, damaged = (synchronous(x[None], TIME, angle, 20) for x in (meshing, meshing + impact))
    assert damaged["fm4"][0] > 8.0
    assert damaged["residual_rms"][0] > 20 * sound["residual_rms"][0]
    assert damaged["tsa_kurtosis"][0] > sound["tsa_kurtosis"][0]


def test_what_does_not_turn_often_enough_is_not_averaged():
    signal = np.random.default_rng(1).standard_normal((1, TIME.size))
    for angle in (np.zeros_like(TIME), 2 * np.pi * 2.5 * TIME):
        rotation = Rotation(angle=angle, source="stored angle", error=0.0, absolute=True)
        cut = cut_turns(signal, TIME, rotation, 1.0, (0.0, 1.0))
        assert cut is None or cut.count < FEWEST_TURNS


def test_orders_beyond_half_the_rate_have_no_level():
    angle = 2 * np.pi * 100.3 * TIME  # 79.8 samples a turn: 39 orders
    found = synchronous(np.cos(20 * angle)[None], TIME, angle, 20)
    assert found["mesh_1"][0] == pytest.approx(1.0, rel=0.02)
    assert np.isnan(found["mesh_2"][0])


def table(folder):
    """Value by run, sensor, axis, component and feature."""
    keys = ("run", "sensor", "axis", "component", "feature")
    return {tuple(row[key] for key in keys): row["value"] for row in pq.read_table(folder / FEATURES).to_pylist()}


def test_the_table_has_a_row_for_each_run_channel_component_and_feature_with_known_values(tmp_path):
    folder = make_dataset(tmp_path / "known", failed=(3,))
    assert make_features(folder)[0] == 7
    found = table(folder)
    assert {run for run, *_ in found} == {0, 1, 2, 4, 5, 6, 7}
    for run in (0, 1, 2, 4, 5, 6, 7):
        turns = SAMPLES / RATE * read_row(folder, run)["values"]["speed_rpm"] / 60 * TEETH[0] / TEETH[1]
        for number, (sensor, axis) in enumerate(((one, axis) for one in SENSORS for axis in "xyz"), 1):
            pinion, wheel = ((run, sensor, axis, f"stage 1 {gear}") for gear in ("pinion", "wheel"))
            assert found[*pinion, "mesh_1"] == pytest.approx(2.0 * number, rel=0.01)
            assert found[*pinion, "mesh_1_upper"] == pytest.approx(0.5 * number, rel=0.02)
            assert ((*wheel, "mesh_1") in found) >= (turns > FEWEST_TURNS + 1.2)
            assert ((*wheel, "mesh_1") in found) <= (turns >= FEWEST_TURNS)


COMMON = {"simulation.end_s": 1.0, "drive.times_s": [0.0, 0.05, 1.0], "diagnosis.windows_s": {}, "deviations.seed": 7}
KEYS = ["sensor", "axis", "component", "feature"]


def test_a_run_its_exported_file_and_its_row_in_a_data_set_have_the_same_features(tmp_path, monkeypatch):
    """Equal to 1e-3 dB down to 80 dB below the signal, with the same sensor noise and without noise."""
    monkeypatch.chdir(tmp_path)
    gearcase.run(gearcase.Scene.from_file("minimal").changed(COMMON), out="run", control=False)
    assert main(["export", "run", "--to", "csv", "--out", "run.csv"]) == 0
    settings = "".join(f"{key} = {json.dumps(value)}\n" for key, value in COMMON.items() if "diagnosis" not in key)
    plan = 'scene = "minimal"\nscenes = 1\n[variables]\nx = { from = 7, to = 7 }\n[settings]\n'
    (tmp_path / "plan.toml").write_text(plan + settings.replace("seed = 7", 'seed = "$x"'), encoding="utf-8")
    folder = gearcase.campaign("plan.toml", processes=1).folder
    for noise in (0.0, 0.02):
        part = {"start": 0.1, "end": 0.95, "noise_m_s2": noise, "processes": 1}
        run, file, row = (
            gearcase.features(source, machine, **part).set_index(KEYS)
            for source, machine in (("run", None), ("run.csv", "minimal"), (folder, None))
        )
        assert run.level_dB.min() < (-50.0 if noise else -80.0)
        assert set(run.reset_index().feature) <= BY_NAME.keys()
        for other in (file, row):
            assert list(other.index) == list(run.index)
            np.testing.assert_allclose(other.level_dB, run.level_dB, rtol=0.0, atol=1e-3)
    whole = gearcase.features("run.csv", "minimal", processes=1).set_index(KEYS).value
    with gearcase.open_recording("run.csv", "minimal") as signal:
        rms = float(signal.acceleration[:, 0, 2].std())
    assert whole["sensor_3", "z", "whole machine", "rms"] == pytest.approx(rms)


def test_files_of_a_folder_are_one_table_and_one_without_features_is_named(tmp_path, monkeypatch, caplog, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.toml").write_text("teeth = [[20, 31]]\nrate_Hz = 5000\nspeed_rpm = 1500\n")
    angle = 2 * np.pi * 25 * np.arange(40_000) / RATE
    mesh = (1 + 0.5 * np.cos(angle) + 0.5 * np.cos(20 / 31 * angle)) * np.cos(20 * angle)
    (tmp_path / "records").mkdir()
    for name in ("a", "b"):
        np.save(f"records/{name}.npy", mesh + 0.01 * np.random.default_rng(len(name)).normal(size=angle.size))
    np.save("records/short.npy", mesh[:300])
    arguments = ["features", "records", "--machine", "bench.toml", "--processes", "1", "--out", "table.csv"]
    assert main(arguments) == 0
    assert "no features of 1 of 3 signals, records/short.npy: " in caplog.text
    with open("table.csv", encoding="utf-8") as file:
        assert {line.split(",")[0].strip('"') for line in file} == {"recording", "records/a.npy", "records/b.npy"}
    caplog.clear()
    text = "teeth = [[20, 31]]\nrate_Hz = 5000\nspeed = { rpm = 1490, uncertainty_percent = 1 }\n"
    text += "bearings = [{ name = 'DE', shaft = 1, BPFO = 3.585, BPFI = 5.415 }]\n"
    (tmp_path / "rough.toml").write_text(text)
    assert main(["features", "records", "--machine", "rough.toml", "--processes", "1", "--out", "rough.csv"]) == 0
    assert "no features of shaft_1 (stage 1 pinion) in 2 signals. The first: recording records/a.npy: " in caplog.text
    assert "set speed_rpm in place of speed" in caplog.text
    caplog.clear()
    capsys.readouterr()
    assert main([*arguments[:1], "records/short.npy", "nosuch", *arguments[2:]]) == 2
    said = caplog.text + capsys.readouterr().err
    assert said.count("nosuch: no result here") == said.count("records/short.npy: ") == 1
    caplog.clear()
    assert main(["features", "records", "--processes", "1"]) == 2
    assert not caplog.text  # the reason is the same for all and stated once
    assert capsys.readouterr().err.count("the machine is not known") == 1
    (tmp_path / "slow.toml").write_text(
        "teeth = [[20, 31]]\nrate_Hz = 5000\nspeed = { rpm = 1500, uncertainty_percent = 0.05 }\n"
        "bearings = [{ name = 'DE', shaft = 1, BPFO = 0.55, BPFI = 5.415 }]\n"
    )
    np.save("records/short.npy", mesh[:4000])
    assert main([*arguments[:3], "slow.toml", *arguments[4:]]) == 0
    assert "no features of DE BPFO in 1 signals. The first: recording records/short.npy: its pass freq" in caplog.text
    assert main([*arguments[:-1], "table.txt"]) == 2
    assert main(["features", "bench.toml", "--machine", "bench.toml"]) == 2


def test_the_page_has_the_table_of_all_definitions():
    page = PAGE.read_text(encoding="utf-8")
    assert page == feature_table_page(page), "run: python -m benchmarks.feature_table"


def test_what_is_made_is_not_made_again_unless_the_run_or_the_start_changed(tmp_path):
    folder = make_dataset(tmp_path / "again")
    assert make_features(folder)[0] == 8
    before = (folder / "features.parquet").read_bytes()
    row_path(folder, 2, FEATURE_ROWS).unlink()
    row_path(folder, 5, FEATURE_ROWS).write_text('{"run": 5, "made', encoding="utf-8")
    row = read_row(folder, 6)
    write_row(folder, 6, row | {"checksums": row["checksums"] | {"acceleration": "0"}})
    assert make_features(folder)[0] == 3
    assert (folder / "features.parquet").read_bytes() == before
    assert make_features(folder, start=0.2)[0] == 8
    assert (folder / "features.parquet").read_bytes() != before


def test_a_pass_that_is_stopped_goes_on_where_it_was(tmp_path):
    folder = make_dataset(tmp_path / "stopped")
    whole = make_dataset(tmp_path / "whole")

    def stop(done, left):
        if done == 3:
            raise KeyboardInterrupt

    class Lazy(InOrder):
        def map(self, function, *iterables, **kwargs):
            return map(function, *iterables)

    with pytest.raises(KeyboardInterrupt):
        make_features(folder, on_progress=stop, executor=Lazy())
    (folder / FEATURE_ROWS / ".4-killed.partial").write_text("{", encoding="utf-8")
    assert make_features(folder, executor=Lazy())[0] == 5
    make_features(whole)
    assert (folder / "features.parquet").read_bytes() == (whole / "features.parquet").read_bytes()
    assert not [name for name in os.listdir(folder / FEATURE_ROWS) if name.endswith(".partial")]


def test_a_run_that_is_gone_has_no_features(tmp_path):
    folder = make_dataset(tmp_path / "gone")
    make_features(folder)
    row_path(folder, 1).unlink()
    make_features(folder)
    assert 1 not in {run for run, *_ in table(folder)}


def test_a_start_beyond_the_end_is_refused(folder):
    with pytest.raises(InputError, match=r"last 0\.8 s"):
        make_features(folder, start=0.8)


def test_no_feature_row_holds_what_is_no_number(folder):
    make_features(folder)
    rows = list((folder / FEATURE_ROWS).iterdir())
    assert rows
    for path in rows:
        json.loads(path.read_text(encoding="utf-8"), parse_constant=pytest.fail)
