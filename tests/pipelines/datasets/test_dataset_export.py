"""Exported pieces are the stored ones, in every format, with their labels beside them."""

import csv

import h5py
import numpy as np
import pytest
from datasets import make_dataset
from scipy.io import loadmat

import gearcase
from pipelines.cli.main import main

CUT = ("--seconds", "0.2", "--noise", "0.1", "--seed", "3", "--split", "train", "--sensors", "sensor_4")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("export") / "known", failed=(3,))


@pytest.fixture(scope="module")
def expected(folder):
    dataset = gearcase.open_dataset(folder)
    train = dataset.isel(run=dataset.split == "train")
    return list(gearcase.pieces(train, 0.2, noise_m_s2=0.1, seed=3, sensors=["sensor_4"]))


def exported(folder, form, out, *words):
    assert main(["dataset", "export", str(folder), "--to", form, "--out", str(out), *words]) == 0
    return out


def test_numpy_gets_one_array_of_pieces_and_one_per_column(folder, expected, tmp_path):
    with np.load(exported(folder, "npz", tmp_path / "p.npz", *CUT)) as found:
        assert np.array_equal(found["acceleration"], np.concatenate([one.values for one in expected]))
        for name in ("label", "split", "group", "run", "speed_rpm", "start"):
            assert np.array_equal(found[name], np.concatenate([one[name].values for one in expected])), name
        assert set(found["split"]) == {"train"}
        assert 3 not in found["run"]
        assert found["rate_Hz"] == 5000.0


def test_hdf5_has_the_same_arrays(folder, expected, tmp_path):
    with h5py.File(exported(folder, "hdf5", tmp_path / "p.hdf5", *CUT)) as found:
        assert np.array_equal(found["acceleration"], np.concatenate([one.values for one in expected]))
        labels = np.concatenate([one.label.values for one in expected])
        assert list(found["label"].asstr()) == list(labels)
        assert found["acceleration"].attrs["units"] == "m/s2"


def labels_of(folder):
    with open(folder / "labels.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_matlab_gets_a_file_per_run(folder, expected, tmp_path):
    lines = labels_of(exported(folder, "mat", tmp_path / "mat", *CUT))
    for line, one in zip(lines, expected, strict=True):
        found = loadmat(tmp_path / "mat" / line["file"], squeeze_me=True)
        assert np.array_equal(found["acceleration"], one.values.squeeze())
        assert found["label"] == line["label"] == one.label.values[0]
        assert np.allclose(found["start"], one.start)


def test_csv_gets_a_file_per_run_and_a_table_of_labels(folder, expected, tmp_path):
    lines = labels_of(exported(folder, "csv", tmp_path / "csv", *CUT))
    assert [int(line["run"]) for line in lines] == [int(one.run[0]) for one in expected]
    titles = (tmp_path / "csv" / lines[0]["file"]).read_text(encoding="utf-8").split(",")
    assert titles[2] == f"acceleration {expected[0].sensor.values[0]} {expected[0].axis.values[0]} [m/s2]"  # as exports
    found = np.loadtxt(tmp_path / "csv" / lines[0]["file"], delimiter=",", skiprows=1)
    assert np.allclose(found[:, 2:].T, np.concatenate(list(expected[0].values[:, 0]), axis=-1), rtol=1e-8)
    assert np.allclose(np.diff(found[:, 1]), 1 / 5000)


@pytest.mark.parametrize("form", ["npz", "hdf5", "csv"])
def test_what_comes_before_the_start_is_left_out(folder, tmp_path, form):
    words = ("--start", "0.3", "--seconds", "0.2", "--noise", "0.1", "--seed", "3", "--split", "train")
    place = exported(folder, form, tmp_path / f"later.{form}", *words)
    dataset = gearcase.open_dataset(folder)
    later = dataset.isel(run=dataset.split == "train").sel(time=slice(0.2999, None))
    cut = list(gearcase.pieces(later, 0.2, noise_m_s2=0.1, seed=3))
    if form == "csv":
        found = np.loadtxt(place / labels_of(place)[0]["file"], delimiter=",", skiprows=1)
        assert found[0, 1] == pytest.approx(0.3)
        assert len(found) == 2 * 1000  # of 0.5 s, two pieces of 0.2 s
        return
    values = np.concatenate([one.values for one in cut])
    with np.load(place) if form == "npz" else h5py.File(place) as found:
        assert np.array_equal(found["acceleration"], values)
        assert found["start"][0] == pytest.approx(0.3)
        assert len(found["label"]) == len(values) == len(found["start"])


def test_a_label_chooses_and_by_default_whole_runs_lie_in_the_data_set(folder, capsys):
    assert main(["dataset", "export", str(folder), "--to", "npz", "--label", "healthy"]) == 0
    place = folder / "pieces.npz"
    assert str(place) in capsys.readouterr().out
    with np.load(place) as found:
        assert set(found["label"]) == {"healthy"}
        assert found["acceleration"].shape[-1] == 4000
    place.unlink()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--label", "rusty"), "Allowed: healthy, missing-tooth"),
        (("--split", "validation"), "Allowed: test, train"),
        (("--seconds", "9"), "the runs last 0.8 s"),
        (("--start", "0.8"), "--start 0.8: the runs last 0.8 s"),
        (("--start", "0.3", "--seconds", "0.6"), "the runs last 0.5 s from 0.3 s on"),
        (("--sensors", "sensor_9"), "sensor_3, sensor_4"),
    ],
)
def test_what_is_not_there_is_refused(folder, tmp_path, capsys, words, said):
    assert main(["dataset", "export", str(folder), "--to", "npz", "--out", str(tmp_path / "p.npz"), *words]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [("--overlap", "1"), ("--noise", "-1"), ("--seed", "x"), ("--to", "xlsx")])
def test_arguments_that_cannot_be_are_refused(folder, words):
    with pytest.raises(SystemExit):
        main(["dataset", "export", str(folder), "--to", "npz", *words])


def test_features_by_the_command(folder, capsys):
    assert main(["features", str(folder), "--processes", "1"]) == 0
    assert f"{folder / 'features.parquet'}: " in capsys.readouterr().out
