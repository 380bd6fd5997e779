"""Features of a data set: exact for signals that are known, tied to the shafts by their angles, made once."""

import json
import os
from concurrent.futures import Executor, Future

import numpy as np
import pyarrow.parquet as pq
import pytest
from datasets import RATE, SAMPLES, TEETH, make_dataset

import gearcase
from pipelines.datasets.feature_pass import FEATURE_ROWS, make_features
from pipelines.datasets.rows import read_row, row_path, write_row
from pipelines.io.errors import InputError
from pipelines.signals.features.average import FEWEST_TURNS, average
from pipelines.signals.features.statistics import statistics
from pipelines.signals.features.synchronous import synchronous as features_of_average
from pipelines.signals.features.turns import cut_turns
from pipelines.signals.orders.rotation import Rotation

TIME = np.arange(8000) / 8000


class InOrder(Executor):
    """Does what it is given at once, in this process."""

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        future.set_result(function(*args, **kwargs))
        return future


def synchronous(signal, time, angle, meshes):
    """Features of the average of all turns of a shaft."""
    rotation = Rotation(angle=angle, source="stored angle", error=0.0, absolute=True)
    cut = cut_turns(signal, time, rotation, 1.0, (time[0], time[-1]))
    return features_of_average(average(cut.values, cut.orders, meshes))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("features") / "known", failed=(3,))


def test_statistics_of_a_sine_and_of_noise_are_those_of_the_books():
    sine = 3.0 * np.sin(2 * np.pi * 50 * TIME)
    found = {name: float(value) for name, value in statistics(sine).items()}
    assert found["rms"] == pytest.approx(3 / np.sqrt(2))
    assert found["crest_factor"] == pytest.approx(np.sqrt(2))
    assert found["kurtosis"] == pytest.approx(1.5)
    assert found["mean"] == pytest.approx(0.0, abs=1e-12)
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
    found = synchronous(signal[None], TIME, angle, {1: 20})
    expected = {
        "stage_1_mesh_1": 2.0, "stage_1_mesh_1_lower": 0.3, "stage_1_mesh_1_upper": 0.5,
        "stage_1_mesh_2": 0.1, "stage_1_mesh_2_lower": 0.0, "stage_1_mesh_3": 0.0,
        "tsa_rms": np.sqrt((2.0**2 + 0.3**2 + 0.5**2 + 0.1**2) / 2),
        "residual_rms": np.sqrt((0.3**2 + 0.5**2) / 2),
    }  # fmt: skip
    for name, value in expected.items():
        assert found[name][0] == pytest.approx(value, abs=0.004), name


def test_averaging_divides_noise_by_the_root_of_the_revolutions():
    turns = 40
    angle = 2 * np.pi * (turns + 0.01) * TIME
    noise = np.random.default_rng(3).standard_normal((20, TIME.size))
    found = synchronous(noise, TIME, angle, {})
    kept = found["tsa_rms"].mean()
    assert kept == pytest.approx(1 / np.sqrt(turns), rel=0.15)  # interpolation takes a little of white noise


def test_one_impact_in_a_revolution_makes_the_average_peak():
    angle = speeding_up(30)
    meshing = np.cos(20 * angle) + 0.2 * np.cos(40 * angle)
    impact = 0.5 * np.exp(-(((angle % (2 * np.pi)) - 2.0) ** 2) / 0.01) * np.cos(27 * angle)
    sound, damaged = (synchronous(x[None], TIME, angle, {1: 20}) for x in (meshing, meshing + impact))
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
    found = synchronous(np.cos(20 * angle)[None], TIME, angle, {1: 20})
    assert found["stage_1_mesh_1"][0] == pytest.approx(1.0, rel=0.02)
    assert np.isnan(found["stage_1_mesh_2"][0])


def table(folder):
    return pq.read_table(folder / "features.parquet").to_pylist()


def test_the_table_has_a_line_per_run_sensor_and_axis_with_known_levels(tmp_path):
    folder = make_dataset(tmp_path / "known", failed=(3,))
    made, lines = make_features(folder, InOrder())
    assert (made, lines) == (7, 7 * 6)
    for line in table(folder):
        channel = 1 + 3 * ("sensor_3", "sensor_4").index(line["sensor"]) + "xyz".index(line["axis"])
        assert line["mean"] == pytest.approx(0.01 * line["run"] * channel, abs=0.02 * channel)
        assert line["shaft_1_stage_1_mesh_1"] == pytest.approx(2.0 * channel, rel=0.01)
        assert line["shaft_1_stage_1_mesh_1_upper"] == pytest.approx(0.5 * channel, rel=0.02)
        turns = 0.8 * read_row(folder, line["run"])["values"]["speed_rpm"] / 60 * TEETH[0] / TEETH[1]
        if turns > FEWEST_TURNS + 1.2:  # the first turn begins at the first sample, where no value can be interpolated
            assert line["shaft_2_stage_1_mesh_1"] == pytest.approx(2.0 * channel, rel=0.2)
        if turns < FEWEST_TURNS:
            assert line["shaft_2_stage_1_mesh_1"] is None
    assert {line["run"] for line in table(folder)} == {0, 1, 2, 4, 5, 6, 7}
    assert TEETH == (20, 55)
    assert SAMPLES / RATE == 0.8


def test_what_is_made_is_not_made_again_unless_the_run_or_the_start_changed(tmp_path):
    folder = make_dataset(tmp_path / "again")
    assert make_features(folder, InOrder())[0] == 8
    before = (folder / "features.parquet").read_bytes()
    row_path(folder, 2, FEATURE_ROWS).unlink()
    row_path(folder, 5, FEATURE_ROWS).write_text('{"run": 5, "made', encoding="utf-8")
    row = read_row(folder, 6)
    write_row(folder, 6, row | {"checksums": row["checksums"] | {"acceleration": "0"}})
    assert make_features(folder, InOrder())[0] == 3
    assert (folder / "features.parquet").read_bytes() == before
    assert make_features(folder, InOrder(), start=0.2)[0] == 8
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
        make_features(folder, Lazy(), on_progress=stop)
    (folder / FEATURE_ROWS / ".4-killed.partial").write_text("{", encoding="utf-8")
    assert make_features(folder, Lazy())[0] == 5
    make_features(whole, InOrder())
    assert (folder / "features.parquet").read_bytes() == (whole / "features.parquet").read_bytes()
    assert not [name for name in os.listdir(folder / FEATURE_ROWS) if name.endswith(".partial")]


def test_a_run_that_is_gone_has_no_features(tmp_path):
    folder = make_dataset(tmp_path / "gone")
    make_features(folder, InOrder())
    row_path(folder, 1).unlink()
    make_features(folder, InOrder())
    assert 1 not in {line["run"] for line in table(folder)}


def test_noise_is_that_of_the_pieces(tmp_path):
    folder = make_dataset(tmp_path / "noisy")
    make_features(folder, InOrder(), noise=0.5)
    lines = {(line["run"], line["sensor"], line["axis"]): line for line in table(folder)}
    for one in gearcase.pieces(gearcase.open_dataset(folder), noise_m_s2=0.5):
        rms = np.sqrt(np.mean(one.values[0].astype(float) ** 2, axis=-1))
        for i, sensor in enumerate(one.sensor.values):
            for j, axis in enumerate(one.axis.values):
                assert lines[int(one.run[0]), sensor, axis]["rms"] == pytest.approx(rms[i, j])


def test_a_start_beyond_the_end_is_refused(folder):
    with pytest.raises(InputError, match=r"last 0\.8 s"):
        make_features(folder, InOrder(), start=0.8)


def test_no_feature_row_holds_what_is_no_number(folder):
    make_features(folder, InOrder())
    rows = list((folder / FEATURE_ROWS).iterdir())
    assert rows
    for path in rows:
        json.loads(path.read_text(encoding="utf-8"), parse_constant=pytest.fail)
