"""Reading a data set: what was written is read, run by run; pieces are the signals again, with noise that repeats."""

import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
import xarray
from datasets import PLAN, RATE, SAMPLES, make_dataset, signals

import gearcase
from pipelines.datasets.columns import as_array, read_columns
from pipelines.datasets.rows import row_path, write_table
from pipelines.datasets.store import SIGNALS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("whole") / "known")


@pytest.fixture
def dataset(folder):
    return gearcase.open_dataset(folder)


def test_signals_and_rows_are_what_was_written(dataset):
    assert dataset.acceleration.dims == ("run", "sensor", "axis", "time")
    for run in range(8):
        expected = signals(run, float(dataset.speed_rpm[run]))
        assert np.array_equal(dataset.acceleration[run].values, expected["acceleration"])
        assert np.array_equal(dataset.shaft_angle[run].values, expected["shaft_angle"])
    assert set(dataset.split.values) == {"train", "test"}
    assert list(dataset.label.values == "missing-tooth") == list(dataset.state.values == "missing")
    assert dataset.acceleration.sel(run=3, sensor="sensor_4", axis="y").shape == (SAMPLES,)
    assert dataset.time.values[1] == 1 / RATE


def test_a_run_is_read_when_it_is_asked_for_and_no_other(folder, tmp_path):
    for chunk in (folder / SIGNALS / "acceleration").glob("c.5.*"):
        whole = chunk.read_bytes()
        chunk.write_bytes(b"damaged")
        try:
            dataset = gearcase.open_dataset(folder)
            assert np.isfinite(dataset.acceleration[4].values).all()
            with pytest.raises(Exception, match=r".+"):
                dataset.acceleration[5].load()
        finally:
            chunk.write_bytes(whole)


def test_a_data_set_that_grows_has_runs_without_status(tmp_path):
    growing = make_dataset(tmp_path / "growing", left_out=(2, 5), failed=(3,))
    dataset = gearcase.open_dataset(growing)
    assert list(dataset.status.values) == ["done", "done", "", "failed", "done", "", "done", "done"]
    assert np.isnan(dataset.acceleration[2].values).all()
    assert np.isnan(dataset.speed_rpm.values[[2, 5]]).all()
    assert dataset.reason.values[3] == "it broke"
    assert [int(one.run[0]) for one in gearcase.pieces(dataset)] == [0, 1, 4, 6, 7]


def test_the_table_gives_the_same_columns_as_the_rows(tmp_path):
    folder = make_dataset(tmp_path / "both", failed=(1,))
    table = read_columns(folder, 8)
    (folder / "rows.parquet").unlink()
    rows = read_columns(folder, 8)
    assert table.keys() == rows.keys()
    for name, values in rows.items():
        np.testing.assert_array_equal(table[name], values)
        assert table[name].dtype == values.dtype


def test_a_table_older_than_the_rows_is_not_believed(tmp_path):
    folder = make_dataset(tmp_path / "older")
    row_path(folder, 3).unlink()
    assert list(gearcase.open_dataset(folder).status.values[2:5]) == ["done", "", "done"]
    write_table(folder)
    assert list(gearcase.open_dataset(folder).status.values[2:5]) == ["done", "", "done"]


def test_variables_named_like_a_signal_or_a_dimension_hide_nothing(tmp_path):
    plan = PLAN.replace("speed_rpm", "time").replace("seed = {", "start = {").replace('"$seed"', '"$start"')
    dataset = gearcase.open_dataset(make_dataset(tmp_path / "named", plan))
    assert dataset.time.dims == ("time",)
    assert dataset.variable_time.values.min() >= 600.0
    assert list(next(gearcase.pieces(dataset, 0.4)).start.values) == [0.0, 0.4]


def test_columns_have_the_type_of_their_values():
    assert as_array([1, 2]).dtype == np.int64
    assert np.isnan(as_array([1, None])[1])
    assert list(as_array(["a", None])) == ["a", ""]
    assert as_array([True, False]).tolist() == [1, 0]
    assert as_array(["x" * 1000, "y"]).dtype == object


def test_a_folder_that_is_no_data_set_is_refused(tmp_path, folder):
    with pytest.raises(gearcase.InputError, match="not the folder of a data set"):
        gearcase.open_dataset(tmp_path)
    (tmp_path / "campaign.json").write_bytes((folder / "campaign.json").read_bytes())
    with pytest.raises(gearcase.InputError, match="cannot be read"):
        gearcase.open_dataset(tmp_path)


def test_a_data_set_opens_without_dask(folder):
    code = (
        "import sys; sys.modules['dask'] = None; import gearcase\n"
        f"found = gearcase.open_dataset({str(folder)!r})\n"
        "print(len(list(gearcase.pieces(found, 0.1))), float(found.acceleration[1].max()) > 1)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout == "8 True\n", done.stderr


def test_pieces_side_by_side_are_the_run_again(dataset):
    for one in gearcase.pieces(dataset, 0.2):
        again = np.concatenate(list(one.values), axis=-1)
        assert np.array_equal(again, dataset.acceleration.sel(run=int(one.run[0])).values)
        assert np.allclose(one.start, [0.0, 0.2, 0.4, 0.6])


def test_overlapping_pieces_repeat_that_share(dataset):
    one = next(gearcase.pieces(dataset, 0.2, overlap=0.75))
    assert one.sizes["piece"] == 13
    quarter = one.sizes["time"] // 4
    assert np.array_equal(one[0, ..., quarter:], one[1, ..., :-quarter])


def test_the_same_piece_has_the_same_noise_whatever_else_is_chosen(dataset):
    def found(part, run, **options):
        options = {"seconds": 0.1, "noise_m_s2": 0.3, "seed": 4} | options
        return next(one for one in gearcase.pieces(part, **options) if int(one.run[0]) == run)

    whole = found(dataset, 6)
    assert np.array_equal(found(dataset.isel(run=slice(None, None, -1)), 6), whole)
    assert np.array_equal(found(dataset, 6, sensors=["sensor_4"])[:, 0], whole[:, 1])
    later = dataset.isel(time=slice(1000, None))
    assert np.array_equal(found(later, 6), whole.isel(piece=slice(2, None)))
    assert found(later, 6).start[0] == pytest.approx(0.2)
    assert np.array_equal(found(dataset, 6, overlap=0.5)[::2], whole)
    assert not np.array_equal(found(dataset, 6, seed=5), whole)


def test_noise_has_its_rms_is_white_and_differs_between_channels_and_runs(dataset):
    clean = {int(one.run[0]): one.values for one in gearcase.pieces(dataset)}
    noise = {int(o.run[0]): o.values[0] - clean[int(o.run[0])][0] for o in gearcase.pieces(dataset, noise_m_s2=0.5)}
    channels = np.stack([noise[run] for run in sorted(noise)]).reshape(-1, SAMPLES)
    assert channels.std() == pytest.approx(0.5, rel=0.01)
    together = np.corrcoef(channels)
    assert np.abs(together - np.eye(len(together))).max() < 5 / np.sqrt(SAMPLES)
    lagged = [np.corrcoef(one[1:], one[:-1])[0, 1] for one in channels]
    assert np.abs(lagged).max() < 5 / np.sqrt(SAMPLES)


def test_pieces_never_mix_runs_or_parts_of_the_split(dataset):
    for one in gearcase.pieces(dataset, 0.1):
        for name in ("run", "split", "group", "label", "speed_rpm"):
            assert len(np.unique(one[name])) == 1


def test_pieces_that_cannot_be_are_refused(dataset):
    for wrong in ({"seconds": 2.0}, {"seconds": 0.0}, {"seconds": 0.1, "overlap": 1.0}, {"noise_m_s2": -1.0}):
        with pytest.raises(gearcase.InputError):
            gearcase.pieces(dataset, **wrong)
    with pytest.raises(gearcase.InputError, match="sensor_3, sensor_4"):
        gearcase.pieces(dataset, sensors=["sensor_9"])
    with pytest.raises(gearcase.InputError, match="no accelerations"):
        gearcase.pieces(dataset.drop_vars("acceleration"))


def test_memory_holds_a_few_runs_however_many_there_are(tmp_path):
    dataset = gearcase.open_dataset(make_dataset(tmp_path / "many", PLAN.replace("scenes = 8", "scenes = 24")))
    one = dataset.acceleration[0].nbytes
    for _ in gearcase.pieces(dataset.isel(run=[0, 1]), 0.1, noise_m_s2=0.1):
        pass  # what is loaded once: modules, metadata
    tracemalloc.start()
    try:
        for _ in gearcase.pieces(dataset, 0.1, noise_m_s2=0.1):
            pass
        assert tracemalloc.get_traced_memory()[1] < 12 * one
    finally:
        tracemalloc.stop()


def test_all_pieces_can_be_laid_side_by_side(dataset):
    train = dataset.isel(run=dataset.split == "train")
    together = xarray.concat(list(gearcase.pieces(train, 0.4)), "piece")
    assert together.sizes["piece"] == 2 * train.sizes["run"]
    assert set(together.split.values) == {"train"}
