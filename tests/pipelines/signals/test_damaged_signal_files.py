"""HDF5 files of signals with single flipped bits, wrong lengths or a cut: read soundly, or refused in one sentence."""

import time

import h5py
import numpy as np
import pytest
from measured import RATE, machine, signals

from fem.casing.imported.imported_body import MatrixError
from fem.casing.imported.matrix_files import read_matrices
from mbd.output.trajectory import Trajectory
from mbd.parts import channels
from pipelines.cli.main import main
from pipelines.io.errors import InputError
from pipelines.recordings.read_recording import read_recording
from pipelines.runs.run_folder import RESPONSE, loaded_run
from pipelines.signals.response_file import has_checksum, open_response, write_response

CHECKSUM = 48  # bytes at the end of response.nc


def motion(samples=400):
    """Noise in all channels of one stage without sensors."""
    shafts, bearings = ("shaft_1", "shaft_2"), ("bearing_1", "bearing_2")
    spelled = [*channels.motor_channels("motor_1"), *channels.mesh_channels("mesh_1")]
    spelled += [name for shaft in shafts for name in channels.shaft_channels(shaft)]
    spelled += [channels.bearing_force(bearing, axis) for bearing in bearings for axis in "xyz"]
    return Trajectory(
        integrator="exponential", time=np.arange(samples) / RATE, channel_names=spelled,
        channel_units=["rad"] * len(spelled), values=np.random.default_rng(0).normal(size=(len(spelled), samples)),
        motors=("motor_1",), sources=(), shafts=shafts, meshes=("mesh_1",), bearings=bearings, sensors=(),
        step=1e-5, step_error=0.0, diverged_at=0.0, parting_rate=0.0, output_rate=RATE, pass_band=0.4 * RATE,
        counter_names=("steps",), counters=[1], energy_parts=("total", "shaft_1"),
        energy_entries=("stored", "dissipated", "received", "parametric", "residual", "scale"),
        energies=np.zeros((2, 6)),
    )  # fmt: skip


@pytest.fixture(scope="module")
def response(tmp_path_factory):
    """The bytes of a small response.nc."""
    path = tmp_path_factory.mktemp("written") / RESPONSE
    write_response(motion(), {"scene": "small", "seed": 1, "steps": "[1, 2, 3]"}, path)
    return path.read_bytes()


def flipped(content, rng, among):
    """The bytes with one bit flipped in one of the first `among` bytes."""
    found = bytearray(content)
    found[rng.integers(among)] ^= 1 << int(rng.integers(8))
    return bytes(found)


def refused(read, path, **given):
    """The sentence of ours with which a file is refused, "" if it is read."""
    try:
        read(path, **given).close()
    except InputError as error:
        text = str(error)
    else:
        return ""
    assert path.name in text
    assert "\n" not in text
    return text


def refusal(path):
    """The sentence with which a response is refused, "" if all of it is read."""
    text = refused(lambda path: open_response(path).load(), path)
    assert not text or text.startswith(f"{path}: cannot be read as signals (")
    assert not text or text.endswith("The file is damaged or cut off; copy it again, or run the scene again.")
    return text


@pytest.mark.parametrize("form", ["head", "whole"])
def test_every_flipped_bit_of_a_response_is_found(response, form, tmp_path):
    rng = np.random.default_rng(1)
    path = tmp_path / RESPONSE
    size = len(response) - CHECKSUM
    for _ in range(200):
        path.write_bytes(flipped(response, rng, {"head": min(20_000, size), "whole": size}[form]))
        assert "does not match its checksum" in refusal(path)


def test_a_response_without_checksum_is_refused_by_its_reader_or_can_be_read(response, tmp_path, capfd):
    """As one that another program changed, or that an older version wrote."""
    rng = np.random.default_rng(2)
    path = tmp_path / RESPONSE
    content = response[:-CHECKSUM]
    path.write_bytes(content)
    assert refusal(path) == ""
    found = []
    for _ in range(30):
        path.write_bytes(flipped(content, rng, min(20_000, len(content))))
        found.append(bool(refusal(path)))
    assert 5 < sum(found) < 30
    assert capfd.readouterr().err == ""


def test_a_response_that_is_cut_off_is_refused(response, tmp_path):
    path = tmp_path / RESPONSE
    for share in (0.0, 0.01, 0.5, 0.98):
        path.write_bytes(response[: int(share * len(response))])
        assert refusal(path)


def test_other_programs_read_and_change_a_response(response, tmp_path):
    path = tmp_path / RESPONSE
    path.write_bytes(response)
    assert has_checksum(path)
    with h5py.File(path, "r+") as file:
        file.attrs["note"] = "looked at"
    assert not has_checksum(path)
    assert loaded_run(tmp_path).attrs["note"] == "looked at"


def test_commands_refuse_a_damaged_response_in_one_sentence(response, tmp_path, capsys):
    (tmp_path / RESPONSE).write_bytes(flipped(response, np.random.default_rng(3), len(response) // 2))
    for command in (["export", str(tmp_path), "--to", "csv"], ["runs", "compare", str(tmp_path), str(tmp_path)]):
        assert main(command) == 2
        (said,) = capsys.readouterr().err.splitlines()
        assert f"{tmp_path / RESPONSE}: cannot be read as signals" in said


def test_a_damaged_response_is_no_recording(response, tmp_path):
    path = tmp_path / "copy.nc"
    path.write_bytes(flipped(response, np.random.default_rng(4), len(response) // 2))
    with pytest.raises(InputError, match=r"copy\.nc: cannot be read as signals .* does not match its checksum"):
        read_recording(path, machine())
    path.write_bytes(response)  # of a machine without sensors
    with pytest.raises(InputError, match=r"copy\.nc: holds no acceleration"):
        read_recording(path, machine())


def recording(path, **storage):
    with h5py.File(path, "w") as file:
        file.create_dataset("all", data=signals(4000), **storage).attrs["units"] = "m/s2"


def test_a_recording_with_a_flipped_bit_is_refused_or_read(tmp_path):
    rng = np.random.default_rng(5)
    path = tmp_path / "r.h5"
    recording(path, chunks=(100, 2), compression="gzip")
    content = path.read_bytes()
    found = []
    for _ in range(100):
        path.write_bytes(flipped(content, rng, len(content)))
        found.append(bool(refused(read_recording, path, machine=machine(rate_Hz=RATE))))
    assert sum(found) > 50


@pytest.mark.parametrize("bit", [16, 30, 50])
def test_a_wrong_length_is_refused_at_once(bit, tmp_path):
    """HDF5 takes what is not stored for zeros: a length of 2^30 takes minutes to read, one of 2^16 looks like data."""
    path = tmp_path / "r.h5"
    recording(path, chunks=(512, 2), maxshape=(None, 2))
    wrong_length(path, 4000, bit)
    begin = time.process_time()
    with pytest.raises(InputError, match=r'r\.h5: "all 1" has \d+ x 2 values by its header, but the file holds 8 of'):
        read_recording(path, machine(rate_Hz=RATE))
    assert time.process_time() - begin < 1.0


def test_a_wrong_length_of_a_response_without_checksum_is_refused_at_once(tmp_path):
    path = tmp_path / "r.nc"
    with h5py.File(path, "w") as file:
        file.create_dataset("acceleration", data=signals(4000)[:, :, None], maxshape=(None, 2, 1))
        file["time"], file["sensor"], file["axis"] = np.arange(4000) / RATE, ["a", "b"], ["z"]
    wrong_length(path, 4000, 40)
    with pytest.raises(InputError, match=r"acceleration has .* values by its header, but the file holds"):
        open_response(path)


def test_a_wrong_size_of_a_matrix_is_refused_at_once(tmp_path):
    path = tmp_path / "k.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("stiffness", data=np.eye(77), chunks=(11, 11), maxshape=(None, None))
    wrong_length(path, 77, 30)
    with pytest.raises(MatrixError, match=r"k\.h5: stiffness has \d+ x 77 values by its header"):
        read_matrices(path)


def wrong_length(path, length, bit):
    """Flip a bit of the first dimension of the first dataset of this length."""
    content = bytearray(path.read_bytes())
    unlimited = length.to_bytes(8, "little")
    content[content.index(unlimited) + bit // 8] ^= 1 << (bit % 8)
    path.write_bytes(content)
