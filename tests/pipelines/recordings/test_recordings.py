"""Recordings: every format comes back to the precision that it stores, in m/s2, over even time, under its names."""

import json
import sys
import tracemalloc

import h5py
import numpy as np
import pytest
import pyuff
import xarray
from measured import RATE, WRITERS, machine, signals, write_text
from scipy.io import savemat, wavfile
from synthetic import response

from pipelines.diagnosis.result_export import export
from pipelines.io.errors import InputError
from pipelines.io.universal_file import Function, read_functions, write_function
from pipelines.recordings import formats
from pipelines.recordings.formats import BY_ENDING, memory_needed
from pipelines.recordings.machine_table import SpeedTable, TachometerTable
from pipelines.recordings.read_recording import read_recording
from pipelines.recordings.recording_channels import RecordedChannel, RecordedContents

PRECISION = {
    "r.csv": 1e-11,
    "r.uff": 1e-11,
    "r.xlsx": 1e-15,
}  # of the digits that are written; all others keep every bit
WITHOUT_RATE = ("r.npy",)


@pytest.mark.parametrize("name", WRITERS)
def test_a_recording_comes_back_from_every_format(name, tmp_path):
    values, path = signals(), tmp_path / name
    WRITERS[name](path, values)
    known = machine(rate_Hz=RATE) if name in WITHOUT_RATE else machine()
    with read_recording(path, known) as found:
        assert found.acceleration.dims == ("time", "sensor", "axis")
        assert found.acceleration.attrs["units"] == "m/s2"
        assert list(found.axis.values) == ["z"]
        np.testing.assert_allclose(found.acceleration.values[:, :, 0], values, rtol=PRECISION.get(name, 0.0), atol=0.0)
        np.testing.assert_allclose(found.time.values, np.arange(len(values)) / RATE, atol=1e-9)
        assert found.attrs["source"] == name
        assert json.loads(found.attrs["warnings"]) == {}


def _lvm(path, moment):
    day, clock = moment.split(" ")
    head = f"LabVIEW Measurement\t\nDate\t{day.replace('-', '/')}\nTime\t{clock}.5\n***End_of_Header***\t\ntime\ta\n"
    path.write_text(head + "".join(f"{i / RATE:.6f}\t{value}\n" for i, value in enumerate(signals(300)[:, 0])))


def _stamps(path, moment):
    rows = [f"{moment}.{100 * i:06d},{value}\n" for i, value in enumerate(signals(300)[:, 0])]
    path.write_text("when,a\n" + "".join(rows))


def _hdf5(path, moment):
    WRITERS["r.h5"](path, signals())
    with h5py.File(path, "a") as file:
        file.attrs["start_time"] = moment


def _uff(path, moment):
    with path.open("w", encoding="ascii") as file:
        head = Function(lines=("a", "NONE", moment), size=300, start=0.0, step=1.0 / RATE, quantity=12)
        write_function(file, head, [signals(300)[:, 0]])


@pytest.mark.parametrize("moment", ["2026-03-09 07:05:04", "09-Mar-26 07:05:04", "9-MAR-2026 07:05:04"])
@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("r.lvm", _lvm),
        ("r.uff", _uff),
        ("r.csv", _stamps),
        ("r.h5", _hdf5),
        ("r.npz", lambda path, moment: np.savez(path, a=signals()[:, 0], fs=RATE, start=moment)),
        ("r.mat", lambda path, moment: savemat(path, {"rec": {"a": signals()[:, 0], "fs": RATE, "start": moment}})),
    ],
)
def test_the_time_at_which_a_recording_begins_is_read_from_its_file(name, write, moment, tmp_path):
    write(tmp_path / name, moment)
    with read_recording(tmp_path / name, machine()) as found:
        assert found.attrs["begin"] == "2026-03-09T07:05:04"
    WRITERS["r.csv"](tmp_path / "r.csv", signals())
    with read_recording(tmp_path / "r.csv", machine()) as found:
        assert found.attrs["begin"] == ""


@pytest.mark.parametrize(
    ("text", "begin"),
    [
        ("31-Dec-99 23:59:59", "1999-12-31T23:59:59"),
        ("01-Jan-69 00:00:00", "2069-01-01T00:00:00"),
        ("31-Feb-17 12:00:00", ""),
        ("25-Juk-17 12:00:00", ""),
        ("test 125-Jun-17 12:00:00", ""),
    ],
)
def test_a_year_of_two_digits_is_between_1970_and_2069_and_no_date_is_invented(text, begin):
    assert RecordedContents(channels=(), texts=text).begin == begin


def test_every_known_ending_is_written_by_a_test():
    tried = {ending for one in set(BY_ENDING.values()) for ending in one.endings if f"r{one.endings[0]}" in WRITERS}
    assert tried == BY_ENDING.keys()


def test_any_part_of_a_recording_is_what_the_whole_has_there(tmp_path):
    values, path = signals(), tmp_path / "r.npy"
    np.save(path, values)
    places = {"one": {"x": 1, "z": 2}, "two": {"z": 1}}
    with read_recording(path, machine(rate_Hz=RATE, sensors=places)) as found:
        whole = found.acceleration.values.copy()
    with read_recording(path, machine(rate_Hz=RATE, sensors=places)) as found:
        part = found.acceleration.isel(time=slice(100, 900, 7), sensor=[1, 0])
        np.testing.assert_array_equal(part.values, whole[100:900:7, [1, 0]])
        np.testing.assert_array_equal(found.acceleration.isel(time=5).values, whole[5])
        np.testing.assert_array_equal(found.acceleration.sel(sensor="one", axis="z").values, values[:, 1])
    assert np.isnan(whole[:, 1, 0]).all()  # the axis x, which the second sensor does not have


@pytest.mark.parametrize("name", ["r.npy", "r.h5", "r.csv"])
def test_a_streamed_file_takes_no_memory_for_its_samples(name, tmp_path, monkeypatch):
    monkeypatch.setattr("pipelines.recordings.delimited._LINES", 1000)
    monkeypatch.setattr(RecordedChannel.blocks, "__defaults__", (1000,))
    count, channels = 20_000, 16
    values, path = np.tile(signals(count), channels // 2), tmp_path / name
    if name == "r.csv":
        np.savetxt(path, values, fmt="%.6g", delimiter=",")
    elif name == "r.npy":
        np.save(path, values)
    else:
        with h5py.File(path, "w") as file:
            file["acc"] = values
    read_recording(path, machine(rate_Hz=RATE)).close()  # what is imported counts once
    tracemalloc.start()
    with read_recording(path, machine(rate_Hz=RATE)) as found:
        end = found.acceleration.isel(time=slice(-10, None)).values
        peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert memory_needed(path) == 0
    assert peak < count * channels * 8 / 2  # the time, one of 17 columns, and a block
    np.testing.assert_allclose(end[:, :, 0], values[-10:], rtol=1e-5)


@pytest.mark.parametrize("name", ["r.mat", "r.uff", "r.npz", "r.wav", "r.tdms"])
def test_a_file_that_fills_memory_says_how_much_before_it_is_read(name, tmp_path, monkeypatch):
    values = signals()
    WRITERS[name](tmp_path / name, values)
    assert memory_needed(tmp_path / name) >= values.astype(np.float32).nbytes
    monkeypatch.setattr(formats, "SHARE", 1e-9)
    with pytest.raises(InputError, match=r"takes 0 MB of memory, 0 MB may be used .* save it as HDF5, NPY or CSV"):
        read_recording(tmp_path / name, machine())


@pytest.mark.parametrize(
    ("separator", "decimal", "header"),
    [(",", ".", True), (",", ".", False), (" ", ".", False), (" ", ",", False)]
    + [(separator, decimal, header) for separator in ";\t" for decimal in ".," for header in (True, False)],
)
@pytest.mark.parametrize("time", [True, False])
def test_text_is_read_with_any_separator_and_decimal_mark(separator, decimal, header, time, tmp_path):
    values, path = signals(), tmp_path / "r.txt"
    write_text(path, values, separator, decimal, header=header, time=time)
    with read_recording(path, machine(rate_Hz=None if time else RATE)) as found:
        np.testing.assert_allclose(found.acceleration.values[:, :, 0], values, rtol=1e-11)
        assert found.time.values[-1] == pytest.approx((len(values) - 1) / RATE)
        if header:
            assert list(found.sensor.values) == ["drive end", "free end"]


@pytest.mark.parametrize(
    ("head", "encoding"),
    [
        ("recorder 5;\nserial 17;\n\ntime;drive end\ns;g\n", "utf-8"),
        ("# made on a bench\nZeit [s];drive end [g]\n", "utf-8-sig"),
        ("Zeit [s];drive end [g]\n", "utf-16"),
        ("Gerät;\ntime (ms);drive end (g)\n", "cp1252"),
    ],
)
def test_titles_units_and_remarks_above_the_numbers_are_understood(head, encoding, tmp_path):
    values, path = signals(600)[:, 0], tmp_path / "r.csv"
    factor = 1000.0 if "(ms)" in head else 1.0
    rows = [f"{factor * i / RATE:.7g};{value:.9g};\n".replace(".", ",") for i, value in enumerate(values)]
    path.write_text(head.replace("drive end\n", "drive end;\n") + "".join(rows), encoding=encoding)
    with read_recording(path, machine()) as found:
        np.testing.assert_allclose(found.acceleration.values[:, 0, 0], 9.80665 * values, rtol=1e-7)
        assert found.time.values[1] == pytest.approx(1.0 / RATE)


def test_a_line_of_units_may_have_none_for_the_last_column(tmp_path):
    values, path = signals(600)[:, 0], tmp_path / "r.csv"
    rows = [f"{number / RATE:.7g};{value:.9g};ok\n" for number, value in enumerate(values)]
    path.write_text("rate;2000 Hz;\nZeit;drive end;note\ns;g;\n" + "".join(rows), encoding="utf-8")
    with read_recording(path, machine()) as found:
        assert list(found.sensor.values) == ["drive end"]
        np.testing.assert_allclose(found.acceleration.values[:, 0, 0], 9.80665 * values, rtol=1e-7)


def test_a_single_column_under_one_title_may_have_decimal_commas(tmp_path):
    values = np.round(signals(600)[:, 0], 3)
    text = "drive end\n" + "".join(f"{value:.3f}\n".replace(".", ",") for value in values)
    (tmp_path / "r.csv").write_text(text, encoding="utf-8")
    with read_recording(tmp_path / "r.csv", machine(rate_Hz=RATE)) as found:
        np.testing.assert_allclose(found.acceleration.values[:, 0, 0], values)


def test_more_lines_than_a_block_stay_in_order(tmp_path, monkeypatch):
    monkeypatch.setattr("pipelines.recordings.delimited._LINES", 700)
    values = signals()
    write_text(tmp_path / "r.csv", values)
    with read_recording(tmp_path / "r.csv", machine()) as found:
        np.testing.assert_allclose(found.acceleration.values[:, :, 0], values, rtol=1e-11)


@pytest.mark.parametrize(("units", "factor"), [("g", 9.80665), ("mm/s2", 1e-3), ("m/s^2", 1.0), (None, 1.0)])
def test_units_become_metres_per_second_squared(units, factor, tmp_path):
    values = signals()
    np.save(tmp_path / "r.npy", values)
    plain = None if units is None else units.replace("^", "")
    with read_recording(tmp_path / "r.npy", machine(rate_Hz=RATE, units=plain)) as found:
        np.testing.assert_allclose(found.acceleration.values[:, :, 0], factor * values)


def test_volts_become_accelerations_by_the_sensitivity(tmp_path):
    values = signals()
    np.save(tmp_path / "r.npy", values)
    with read_recording(tmp_path / "r.npy", machine(rate_Hz=RATE, units="mV", sensitivity_mV_g=100.0)) as found:
        np.testing.assert_allclose(found.acceleration.values[:, :, 0], values / 100 * 9.80665)  # 100 mV are one g


@pytest.mark.parametrize(("kind", "full"), [(np.int16, 2**15), (np.int32, 2**31), (np.uint8, 2**7)])
def test_whole_numbers_of_a_wav_file_are_shares_of_its_full_scale(kind, full, tmp_path):
    shares = np.random.default_rng(3).uniform(-0.9, 0.9, 1000)
    wavfile.write(tmp_path / "r.wav", 8000, (shares * full + (128 if kind is np.uint8 else 0)).astype(kind))
    with read_recording(tmp_path / "r.wav", machine(scale=50.0)) as found:
        np.testing.assert_allclose(found.acceleration.values[:, 0, 0], 50.0 * shares, atol=50.0 * 1.5 / full)


def test_a_known_speed_is_a_constant_or_a_channel_that_is_no_sensor(tmp_path):
    values = signals()
    savemat(tmp_path / "r.mat", {"drive_end": values[:, 0], "n": np.linspace(1499.9, 1500.1, len(values)), "fs": RATE})
    constant = SpeedTable(rpm=1500.0, uncertainty_percent=0.5)
    channel = SpeedTable(channel="n", uncertainty_percent=0.5)
    for given, sensors in ((constant, ["drive_end", "n"]), (channel, ["drive_end"])):
        with read_recording(tmp_path / "r.mat", machine(speed=given)) as found:
            np.testing.assert_allclose(found.known_speed.values, 25.0, rtol=1e-4)
            assert found.known_speed.attrs == {"shaft": "shaft_1", "uncertainty": 0.005, "units": "Hz"}
            assert list(found.sensor.values) == sensors


def test_a_tachometer_is_kept_with_its_marks_and_is_no_sensor(tmp_path):
    values = signals()
    pulses = (np.arange(len(values)) % 400 < 40).astype(float)
    savemat(tmp_path / "r.mat", {"acc": values[:, 0], "tacho": pulses, "fs": RATE})
    tacho = TachometerTable(channel="tacho", pulses_per_turn=2.0, shaft=1, level=0.5)
    with read_recording(tmp_path / "r.mat", machine(tachometer=tacho)) as found:
        assert list(found.sensor.values) == ["acc"]
        np.testing.assert_array_equal(found.tachometer.values, pulses)
        marks = {name: found.tachometer.attrs[name] for name in ("pulses_per_turn", "shaft", "level")}
        assert marks == {"pulses_per_turn": 2.0, "shaft": "shaft_1", "level": 0.5}


def test_fields_of_a_structure_are_channels(tmp_path):
    values = signals()
    savemat(tmp_path / "r.mat", {"record": {"acc": values, "Fs": RATE, "note": "a text", "t": np.arange(3000) / RATE}})
    with read_recording(tmp_path / "r.mat", machine()) as found:
        assert list(found.sensor.values) == ["record.acc 1", "record.acc 2"]
        np.testing.assert_array_equal(found.acceleration.values[:, :, 0], values)


@pytest.mark.parametrize("name", ["Fs", "sr", "sample_rate", "SamplingFrequency"])
def test_a_structure_may_hold_the_sampling_rate_beside_the_rate_of_the_shaft(name, tmp_path):
    savemat(tmp_path / "r.mat", {"bearing": {"gs": signals()[:, 0], name: RATE, "rate": 25.0, "load": 270.0}})
    with read_recording(tmp_path / "r.mat", machine()) as found:
        assert found.time.values[1] == pytest.approx(1.0 / RATE)


def test_a_rate_alone_may_be_that_of_the_shaft(tmp_path):
    savemat(tmp_path / "r.mat", {"gs": signals()[:, 0], "rate": 25.0})
    with pytest.raises(InputError, match="neither the time nor the sampling rate"):
        read_recording(tmp_path / "r.mat", machine())


@pytest.mark.parametrize("form", ["2026-11-27T23:59:59.{:04d}Z", "27-Nov-26 23:59:59.{:04d}", "23:59:58.{:04d}"])
def test_time_stamps_are_the_time(form, tmp_path):
    values, path = signals(600)[:, 0], tmp_path / "r.csv"
    rows = [f"{form.format(10 * number)},ok,{value:.9g}\n" for number, value in enumerate(values)]
    path.write_text("when,state,drive end [g]\n" + "".join(rows), encoding="utf-8")
    with read_recording(path, machine()) as found:
        assert list(found.sensor.values) == ["drive end"]
        np.testing.assert_allclose(np.diff(found.time.values), 1e-3, rtol=1e-6)
        np.testing.assert_allclose(found.acceleration.values[:, 0, 0], 9.80665 * values, rtol=1e-7)
        assert found.time.values[0] == 0.0


def test_time_stamps_go_on_after_midnight(tmp_path):
    days = (
        [("2026-11-30", 23, 59, number) for number in range(60)],
        [("2026-12-01", 0, m, s) for m in range(5) for s in range(60)],
    )
    stamps = [f"{day}T{hour:02d}:{minute:02d}:{second:02d}" for part in days for day, hour, minute, second in part]
    rows = [f"{stamp};{value}\n" for stamp, value in zip(stamps, signals(360)[:, 0], strict=True)]
    (tmp_path / "r.csv").write_text("".join(rows), encoding="utf-8")
    with read_recording(tmp_path / "r.csv", machine()) as found:
        np.testing.assert_allclose(np.diff(found.time.values), 1.0)


def test_remarks_between_and_below_the_numbers_are_no_data(tmp_path):
    write_text(tmp_path / "r.csv", signals(600))
    lines = (tmp_path / "r.csv").read_text(encoding="utf-8").splitlines()
    lines[300:300] = ["# amplifier range 2"]
    (tmp_path / "r.csv").write_text("\n".join([*lines, "", "End of file", "% checked"]), encoding="utf-8")
    with read_recording(tmp_path / "r.csv", machine()) as found:
        assert found.sizes["time"] == 600


@pytest.mark.parametrize("x_column", [True, False])
def test_a_measurement_file_of_labview_has_its_units_and_its_rate(x_column, tmp_path):
    values = signals(600)
    settings = ["LabVIEW Measurement", "Separator\tTab", f"X_Columns\t{'One' if x_column else 'No'}"]
    segment = ["Channels\t2", "Samples\t600\t600", "Y_Unit_Label\tg\tg", "X0\t0.0\t0.0", "Delta_X\t0.0001\t0.0001"]
    rows = [
        f"{number / RATE:.6f}\t{one:.9g}\t{two:.9g}" if x_column else f"\t{one:.9g}\t{two:.9g}"
        for number, (one, two) in enumerate(values)
    ]
    end = "***End_of_Header***"
    text = [*settings, end, "", *segment, end, "X_Value\tdrive end\tfree end\tComment", *rows]
    (tmp_path / "r.lvm").write_text("\n".join(text), encoding="utf-8")
    with read_recording(tmp_path / "r.lvm", machine()) as found:
        assert list(found.sensor.values) == ["drive end", "free end"]
        assert found.time.values[1] == pytest.approx(1.0 / RATE)
        np.testing.assert_allclose(found.acceleration.values[:, :, 0], 9.80665 * values, rtol=1e-7)


def test_counts_become_accelerations_by_the_scale_of_each_sensor(tmp_path):
    counts = np.round(1000 * signals()).astype(np.int32)
    np.save(tmp_path / "r.npy", counts)
    places = {"one": {"z": 1}, "two": {"x": 2}}
    with read_recording(tmp_path / "r.npy", machine(rate_Hz=RATE, sensors=places)) as found:
        said = json.loads(found.attrs["warnings"])
        assert "holds whole numbers without units, which are read as m/s2" in said["counts one z"]
    scaled = machine(rate_Hz=RATE, sensors=places, units="g", scale={"one": 1e-3, "two": 2e-3})
    with read_recording(tmp_path / "r.npy", scaled) as found:
        assert json.loads(found.attrs["warnings"]) == {}
        np.testing.assert_allclose(found.acceleration.sel(sensor="one", axis="z"), 9.80665e-3 * counts[:, 0])
        np.testing.assert_allclose(found.acceleration.sel(sensor="two", axis="x"), 2 * 9.80665e-3 * counts[:, 1])


def test_a_response_of_a_run_is_read_as_it_is(tmp_path):
    run = response(duration=0.1)
    run.to_netcdf(tmp_path / "response.nc", engine="h5netcdf")
    with read_recording(tmp_path / "response.nc", machine()) as found:
        xarray.testing.assert_identical(found.load().drop_attrs(), run.drop_attrs())


@pytest.mark.parametrize("form", ["csv", "mat", "uff"])
def test_what_a_run_exports_is_read_with_its_sensors_and_axes(form, tmp_path):
    run = response(duration=0.1)
    export(run, tmp_path / f"r.{form}", form)
    with read_recording(tmp_path / f"r.{form}", machine(rate_Hz=RATE)) as found:
        wanted = run.acceleration.sel(sensor=found.sensor, axis=found.axis)
        assert found.sizes["sensor"] == 3
        assert found.sizes["axis"] == 3
        np.testing.assert_allclose(found.acceleration.values, wanted.values, rtol=1e-8, atol=1e-12)


def test_exported_functions_have_their_names_units_and_directions_for_others(tmp_path):
    run = response(duration=0.05)
    run.attrs["title"] = "a run"
    sets = pyuff.UFF(str(export(run, tmp_path / "r.uff", "uff"))).read_sets()
    assert len(sets) == sum(int(np.prod(v.shape[1:])) for v in run.data_vars.values())
    by_name = {one["id1"].strip(): one for one in sets}
    found = by_name["acceleration sensor_2 y"]
    assert (found["func_type"], found["ordinate_spec_data_type"], found["abscissa_spec_data_type"]) == (1, 12, 17)
    assert (found["rsp_ent_name"].strip(), found["rsp_node"], found["rsp_dir"]) == ("sensor_2", 2, 2)
    assert found["ordinate_axis_units_lab"].strip() == "m/s2"
    assert found["id2"].strip() == "a run"
    np.testing.assert_allclose(found["data"], run.acceleration.sel(sensor="sensor_2", axis="y").values, rtol=1e-11)
    np.testing.assert_allclose(found["x"], run.time.values, atol=1e-9)
    assert by_name["bearing_force bearing_1 x"]["ordinate_spec_data_type"] == 13


@pytest.mark.parametrize("size", [256, 257, 258, 259])
def test_a_function_of_any_length_is_written_and_read(size, tmp_path):
    values = np.random.default_rng(size).normal(size=size)
    head = Function(lines=("a",), size=size, start=0.5, step=1e-4, quantity=12, units="g", node=3, direction=-2)
    with (tmp_path / "r.uff").open("w", encoding="ascii") as file:
        write_function(file, head, [values[:128], values[128:]])
    with (tmp_path / "r.uff").open(encoding="ascii") as file:
        (found,) = read_functions(file)
    np.testing.assert_allclose(found.values, values, rtol=1e-12)
    assert (found.head.node, found.head.direction, found.head.units, found.head.start) == (3, -2, "g", 0.5)
    with read_recording(tmp_path / "r.uff", machine()) as recording:  # the sensor points the other way
        measured = recording.acceleration.sel(sensor="node_3", axis="y").values
        np.testing.assert_allclose(measured, -9.80665 * values, rtol=1e-11)


def test_a_universal_file_in_single_precision_and_at_uneven_steps_is_read(tmp_path):
    values, time = signals(400)[:, 0], np.arange(400) / RATE
    pairs = [f"{t:13.5E}{x:13.5E}" for t, x in zip(time, values, strict=True)]
    rows = "\n".join("".join(pairs[i : i + 3]) for i in range(0, len(pairs), 3))
    head = Function(lines=("drive end",), size=400, start=0.0, step=0.0, quantity=12)
    with (tmp_path / "even.uff").open("w", encoding="ascii") as file:
        write_function(file, head, [values])
    lines = (tmp_path / "even.uff").read_text(encoding="ascii").splitlines()
    lines[8] = f"{2:10d}{400:10d}{0:10d}" + lines[8][30:]
    text = "\n".join([*lines[:13], rows, lines[-1], ""])
    (tmp_path / "r.uff").write_text(text, encoding="ascii")
    with read_recording(tmp_path / "r.uff", machine()) as found:
        np.testing.assert_allclose(found.acceleration.values[:, 0, 0], values, rtol=1e-5, atol=1e-7)
        assert found.time.values[1] == pytest.approx(1.0 / RATE)


def test_tdms_without_its_package_says_what_to_install(tmp_path, monkeypatch):
    WRITERS["r.tdms"](tmp_path / "r.tdms", signals())
    monkeypatch.setitem(sys.modules, "nptdms", None)
    with pytest.raises(InputError, match=r"pip install 'gearcase\[tdms\]'"):
        read_recording(tmp_path / "r.tdms", machine())


def test_samples_are_read_from_the_file_when_they_are_looked_at(tmp_path):
    with h5py.File(tmp_path / "r.h5", "w") as file:
        file["acc"] = signals()[:, 0]
    found = read_recording(tmp_path / "r.h5", machine(rate_Hz=RATE))
    found.close()
    with pytest.raises(OSError, match="read data"):
        found.acceleration.load()
