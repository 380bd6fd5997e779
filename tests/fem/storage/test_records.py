"""Records: write -> read -> equal; wrong kind, wrong shape, NaN refused."""

import tracemalloc
from dataclasses import dataclass, field

import h5py
import numpy as np
import pytest

from fem.storage.records import Record, RecordError, array, names, scalar


@dataclass(frozen=True, eq=False, kw_only=True)
class Curve(Record):
    position: np.ndarray = array("position", units="1")
    value: np.ndarray = array("position", "axis", units="N", infinite=True)
    label: tuple[str, ...] = names("axis")
    load: float = scalar(units="N")


@dataclass(frozen=True, eq=False, kw_only=True)
class Other(Record):
    load: float = scalar(units="N")


def curve(**changes):
    fields = {"position": [0.0, 0.5], "value": np.array([[1.0, 2.0], [3.0, np.inf]]), "label": ("a", "b"), "load": 4.0}
    return Curve(**(fields | changes))


def test_write_read_is_equal(tmp_path):
    curve().save(tmp_path / "curve.h5")
    assert Curve.load(tmp_path / "curve.h5").digest() == curve().digest()


def test_xarray_opens_a_record(tmp_path):
    import xarray

    curve().save(tmp_path / "curve.h5")
    with xarray.open_dataset(tmp_path / "curve.h5", engine="h5netcdf") as data:
        assert data["value"].attrs["units"] == "N"
        assert data["value"].shape == (2, 2)


@pytest.mark.parametrize(
    "change",
    [{"position": [0.0]}, {"position": [0.0, np.nan]}, {"position": [0.0, np.inf]}, {"load": np.nan}, {"value": [1.0]}],
)
def test_bad_content_is_refused(change):
    with pytest.raises(RecordError):
        curve(**change)


def test_another_kind_is_refused(tmp_path):
    Other(load=1.0).save(tmp_path / "other.h5")
    with pytest.raises(RecordError, match="expected 'Curve'"):
        Curve.load(tmp_path / "other.h5")


@dataclass(frozen=True, eq=False, kw_only=True)
class Later(Other):
    """`Other` of a later version, with a field that has a default."""

    notes: tuple[str, ...] = field(default=(), metadata=names("note").metadata)


def test_a_file_of_an_earlier_version_lacks_only_fields_with_a_default(tmp_path):
    path = tmp_path / "other.h5"
    Other(load=4.0).save(path)
    with h5py.File(path, "a") as file:
        file.attrs["record"] = "Later"
    assert Later.load(path).notes == ()
    assert Later.load(path).load == 4.0
    with h5py.File(path, "a") as file:
        del file.attrs["load"]
    with pytest.raises(RecordError, match="'load' of Later is missing"):
        Later.load(path)


def test_the_caller_cannot_edit_a_record():
    source = np.array([0.0, 0.5])
    record = curve(position=source)
    source[0] = 7.0
    assert record.position[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        record.position[0] = 1.0


def test_reading_holds_an_array_once(tmp_path):
    count = 200_000
    curve(position=np.arange(count), value=np.ones((count, 2))).save(tmp_path / "curve.h5")
    tracemalloc.start()
    try:
        record = Curve.load(tmp_path / "curve.h5")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1.4 * (record.position.nbytes + record.value.nbytes)
    with pytest.raises(ValueError, match="read-only"):
        record.position[0] = 1.0
