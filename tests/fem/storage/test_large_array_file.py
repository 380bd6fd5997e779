"""Arrays that stay in a file: the same numbers and the same digest as in memory, a full disk is an error in words."""

import errno
import tracemalloc
from dataclasses import dataclass

import h5py
import numpy as np
import pytest

from fem.storage.hdf5_file import CarefulFile, careful_file
from fem.storage.large_array_file import StoredArray
from fem.storage.records import Record, array, names


@dataclass(frozen=True, eq=False, kw_only=True)
class Table(Record):
    row: tuple[str, ...] = names("row")
    values: np.ndarray | StoredArray = array("row", "column", units="N")


@pytest.fixture
def numbers():
    return np.random.default_rng(1).standard_normal((3, 1000))


@pytest.fixture
def stored(tmp_path, numbers):
    out = StoredArray.create(tmp_path / "values.npy", numbers.shape)
    for first in (0, 300, 700):
        last = min(1000, first + 400)
        out[:, first:last] = numbers[:, first:last]
    return out


def test_every_part_reads_as_from_memory(stored, numbers):
    for key in (1, slice(2), (2, slice(10, 20)), (slice(None), slice(500, None, 7)), (1, 5), ([0, 2], slice(3))):
        np.testing.assert_array_equal(stored[key], numbers[key])
    np.testing.assert_array_equal(np.asarray(stored), numbers)
    np.testing.assert_array_equal(np.load(stored.path), numbers)


def test_a_record_has_one_digest_whether_its_array_is_in_a_file_or_in_memory(stored, numbers, tmp_path):
    in_file = Table(row="abc", values=stored)
    assert in_file.digest() == in_file.in_memory().digest() == Table(row="abc", values=numbers).digest()
    in_file.save(tmp_path / "whole.h5")
    in_file.save(tmp_path / "rest.h5", without=["values"])
    assert Table.load(tmp_path / "whole.h5").digest() == in_file.digest()
    assert Table.load(tmp_path / "rest.h5", values=stored).digest() == in_file.digest()
    assert (tmp_path / "whole.h5").stat().st_size > (tmp_path / "rest.h5").stat().st_size + numbers.nbytes / 2


def test_another_shape_or_kind_is_refused(stored, tmp_path):
    with pytest.raises(ValueError, match="length 3"):
        Table(row="ab", values=stored)
    np.save(tmp_path / "other.npy", np.arange(3))
    with pytest.raises(ValueError, match="expected a table of float64"):
        StoredArray(tmp_path / "other.npy")
    with pytest.raises(IndexError, match="does not fill"):
        stored[:, 0:10] = np.zeros((3, 11))


def test_a_channel_is_read_without_the_others(tmp_path):
    out = StoredArray.create(tmp_path / "values.npy", (50, 20_000))
    tracemalloc.start()
    assert out[17].shape == (20_000,)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * np.asarray(out).nbytes / 50


class Disk:
    """A file on a disk with room for `room` bytes."""

    def __init__(self, file, room):
        self.file, self.room = file, room

    def write(self, content):
        fits = max(0, min(len(content), self.room - self.file.tell()))
        if content and not fits:
            raise OSError(errno.ENOSPC, "No space left on device")
        return self.file.write(content[:fits])

    def __getattr__(self, name):
        return getattr(self.file, name)


@pytest.mark.parametrize("room", [0, 100, 3000, 40_000, 70_000, 10**7])
def test_hdf5_closes_in_peace_on_a_full_disk(tmp_path, room):
    """However much was written when the disk became full, and whatever HDF5 reads back afterwards."""
    with open(tmp_path / "file.h5", "w+b", buffering=0) as raw:
        disk = CarefulFile(Disk(raw, room))
        with h5py.File(disk, "w") as file:
            for number in range(40):
                data = file.create_dataset(f"group/{number}", (3000,), "f8", chunks=(300,), compression="gzip")
                data[:] = np.random.default_rng(number).standard_normal(3000)
            for number in range(40):
                expected = np.random.default_rng(number).standard_normal(3000)
                np.testing.assert_array_equal(file[f"group/{number}"][:], expected)
        if room < 10**7:
            with pytest.raises(OSError, match="No space left"):
                disk.check()
        else:
            disk.check()
    if room == 10**7:
        with h5py.File(tmp_path / "file.h5") as file:
            assert len(file["group"]) == 40


def test_writing_returns_the_number_of_bytes(tmp_path):
    with open(tmp_path / "file", "w+b", buffering=0) as raw:
        assert CarefulFile(raw).write(b"abc") == 3


def test_a_careful_file_appears_whole_or_not_at_all(tmp_path):
    def interrupted():
        with careful_file(tmp_path / "file.h5") as disk, h5py.File(disk, "w") as file:
            file["a"] = 1.0
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []
    with careful_file(tmp_path / "file.h5") as disk, h5py.File(disk, "w") as file:
        file["a"] = 1.0
    assert [path.name for path in tmp_path.iterdir()] == ["file.h5"]
