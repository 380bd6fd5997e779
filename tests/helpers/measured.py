"""A measured signal, a machine for it, and the same signal written in every format that is read."""

import csv

import h5py
import numpy as np
import openpyxl
import pyuff
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat, wavfile

from pipelines.recordings.machine_file import MeasuredMachine
from pipelines.recordings.machine_table import MachineTable
from pipelines.signals.orders.kinematics import Kinematics, Shaft

RATE = 10_000.0
SAMPLES = 3000


def signals(samples=SAMPLES, seed=7):
    """Noise and a tone on two channels, (samples, 2), m/s2, as float32 has them."""
    time = np.arange(samples) / RATE
    noise = np.random.default_rng(seed).normal(size=(samples, 2))
    return (noise + 3.0 * np.cos(2 * np.pi * 300.0 * time)[:, None]).astype(np.float32).astype(float)


def machine(**changes):
    """A machine with one shaft at 1500 rpm; without sensors every channel is one. `changes` are keys of its file."""
    kinematics = Kinematics(shafts=(Shaft(name="shaft_1", ratio=1.0),), frequency=25.0)
    return MeasuredMachine(kinematics=kinematics, table=MachineTable(speed_rpm=1500.0, **changes))


def write_text(path, values, separator=",", decimal=".", header=True, time=True):
    """Columns as other programs write them."""
    columns = [np.arange(len(values)) / RATE, *values.T] if time else [*values.T]
    titles = [*(["time [s]"] if time else []), "drive end [m/s2]", "free end [m/s2]"]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, delimiter=separator, quoting=csv.QUOTE_NONE)
        if header:
            writer.writerow(titles)
        for row in zip(*columns, strict=True):
            writer.writerow([f"{value:.12g}".replace(".", decimal) for value in row])


def _write_csv(path, values):
    write_text(path, values)


def _write_mat(path, values):
    savemat(path, {"drive_end": values[:, 0], "free_end": values[:, 1], "fs": RATE})


def _write_hdf5(path, values):
    with h5py.File(path, "w") as file:
        file.attrs["fs"] = RATE
        for name, column in zip(("drive_end", "free_end"), values.T, strict=True):
            file.create_dataset(f"run/{name}", data=column).attrs["units"] = "m/s^2"


def _write_mat73(path, values):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, column in zip(("drive_end", "free_end"), values.T, strict=True):
            file.create_dataset(name, data=column[None, :]).attrs["MATLAB_class"] = np.bytes_("double")
        file.create_dataset("fs", data=[[RATE]]).attrs["MATLAB_class"] = np.bytes_("double")
        file.create_dataset("note", data=np.zeros((300, 1), np.uint16)).attrs["MATLAB_class"] = np.bytes_("char")
    head = b"MATLAB 7.3 MAT-file".ljust(124) + (0x0200).to_bytes(2, "little") + b"IM"
    with path.open("r+b") as file:
        file.write(head)


def _write_uff(path, values):
    sets = [
        pyuff.prepare_58(
            id1=name, func_type=1, rsp_node=1, rsp_dir=3, ref_node=0, ref_dir=0, num_pts=len(values),
            abscissa_spacing=1, abscissa_spec_data_type=17, ordinate_spec_data_type=12, orddenom_spec_data_type=0,
            x=np.arange(len(values)) / RATE, data=column.copy(), rsp_ent_name=name[:5],
        )
        for name, column in zip(("drive end", "free end"), values.T, strict=True)
    ]  # fmt: skip
    pyuff.UFF(str(path)).write_sets(sets)


def _write_npy(path, values):
    np.save(path, values.astype(np.float32))


def _write_npz(path, values):
    np.savez(path, drive_end=values[:, 0], free_end=values[:, 1], fs=RATE)


def _write_wav(path, values):
    wavfile.write(path, int(RATE), values.astype(np.float32))


def _write_tdms(path, values):
    with TdmsWriter(path) as file:
        for name, column in zip(("drive end", "free end"), values.T, strict=True):
            facts = {"wf_increment": 1.0 / RATE, "unit_string": "m/s^2"}
            file.write_segment([ChannelObject("measured", name, column, properties=facts)])


def _write_xlsx(path, values):
    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet()
    sheet.append(["time [s]", "drive end [m/s2]", "free end [m/s2]"])
    for number, row in enumerate(values.tolist()):
        sheet.append([number / RATE, *row])
    book.save(path)


WRITERS = {
    "r.csv": _write_csv,
    "r.mat": _write_mat,
    "v73.mat": _write_mat73,
    "r.h5": _write_hdf5,
    "r.uff": _write_uff,
    "r.npy": _write_npy,
    "r.npz": _write_npz,
    "r.wav": _write_wav,
    "r.tdms": _write_tdms,
    "r.xlsx": _write_xlsx,
}
