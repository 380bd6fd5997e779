"""Recordings that cannot be used: one sentence each, with what, where, value, limit and remedy; suspicions are told."""

import json

import h5py
import numpy as np
import pytest
from measured import RATE, WRITERS, machine, signals, write_text
from scipy.io import savemat

from pipelines.io.errors import InputError
from pipelines.io.universal_file import Function, write_function
from pipelines.recordings.machine_file import read_machine
from pipelines.recordings.machine_table import TachometerTable
from pipelines.recordings.read_recording import read_recording


def refusal(path, **changes):
    """The sentence with which a file is refused; it names the file."""
    with pytest.raises(InputError) as error:
        read_recording(path, machine(**changes))
    text = str(error.value)
    assert path.name in text
    assert "\n" not in text
    return text


def saved(tmp_path, values):
    np.save(tmp_path / "r.npy", values)
    return tmp_path / "r.npy"


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("share", [0.02, 0.55, 0.98])
def test_a_file_that_is_cut_off_is_refused(name, share, tmp_path):
    path = tmp_path / name
    WRITERS[name](path, signals())
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    if name == "r.csv":  # of which a part is whole unless a line is cut
        text = path.read_text(encoding="utf-8")
        path.write_text(text[: text.rindex(",")], encoding="utf-8")
    said = refusal(path, rate_Hz=RATE)
    assert any(words in said for words in ("cut off", "ends within", "at least 256", "is empty", "numbers alone"))


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_of_another_content_is_refused(name, tmp_path):
    (tmp_path / name).write_bytes(bytes(range(256)) * 40)
    assert refusal(tmp_path / name, rate_Hz=RATE)


@pytest.mark.parametrize("name", WRITERS)
def test_an_empty_file_is_refused(name, tmp_path):
    (tmp_path / name).touch()
    assert "is empty (0 bytes)" in refusal(tmp_path / name)


def test_a_file_that_is_not_there_and_one_of_an_unknown_ending_are_refused(tmp_path):
    saved(tmp_path, signals())
    assert "Did you mean r.npy?" in refusal(tmp_path / "rr.npy")
    assert 'the ending ".xls" is unknown. Allowed are .csv, .txt' in refusal(tmp_path / "r.xls")
    assert "its name has no ending" in refusal(tmp_path / "record")
    assert "is a folder" in refusal(folder(tmp_path / "r.csv"))


def folder(path):
    path.mkdir()
    return path


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_gaps_are_counted_and_the_first_is_named(bad, tmp_path):
    values = signals()
    values[[700, 701, 2000], 1] = bad
    said = refusal(saved(tmp_path, values), rate_Hz=RATE)
    assert '"channel 2" has gaps: 3 of 3000 samples are NaN or infinite, the first is sample 701.' in said


def test_gaps_beyond_the_first_block_are_found(tmp_path):
    values = np.random.default_rng(1).normal(size=300_000)
    values[299_999] = np.nan
    assert "1 of 300000 samples are NaN or infinite, the first is sample 300000" in refusal(
        saved(tmp_path, values), rate_Hz=RATE
    )


@pytest.mark.parametrize("value", [0.0, 4.5, np.nan])
def test_a_silent_channel_is_refused_where_it_is_named_and_else_left_out(value, tmp_path):
    values = signals()
    values[:, 0] = value
    silence = "holds no number" if np.isnan(value) else f"is {value:g} throughout"
    named = {"one": {"z": 1}, "two": {"z": 2}}
    assert f'"channel 1" {silence}' in refusal(saved(tmp_path, values), rate_Hz=RATE, sensors=named)
    assert f'"channel" {silence}' in refusal(saved(tmp_path, values[:, :1]), rate_Hz=RATE)
    with read_recording(saved(tmp_path, values), machine(rate_Hz=RATE)) as found:
        assert list(found.sensor.values) == ["channel 2"]
        assert f"channel 1 z {silence} and is not used" in found.attrs["warnings"]


def test_a_recording_of_a_few_samples_is_refused(tmp_path):
    assert "has 255 samples, at least 256 are needed" in refusal(saved(tmp_path, signals(255)), rate_Hz=RATE)


def test_complex_numbers_and_texts_are_refused(tmp_path):
    assert "holds complex numbers (complex128)" in refusal(saved(tmp_path, signals() * 1j), rate_Hz=RATE)
    with h5py.File(tmp_path / "r.h5", "w") as file:
        file["words"] = np.array([b"one", b"two"] * 300)
    assert "no channel has the unit of an acceleration; the channels are words" in refusal(
        tmp_path / "r.h5", rate_Hz=RATE
    )
    words = {"bearing": {"z": "words"}}
    assert '"words" holds no numbers' in refusal(tmp_path / "r.h5", rate_Hz=RATE, sensors=words)
    np.save(tmp_path / "o.npy", np.array([{}, 1], dtype=object), allow_pickle=True)
    assert "cannot be read as NPY" in refusal(tmp_path / "o.npy", rate_Hz=RATE)


def test_a_channel_that_is_not_there_is_refused_with_those_that_are(tmp_path):
    WRITERS["r.mat"](tmp_path / "r.mat", signals())
    said = refusal(tmp_path / "r.mat", sensors={"bearing": {"z": "drive_ends"}})
    assert 'there is no channel "drive_ends", the file has drive_end, free_end. Did you mean "drive_end"?' in said
    assert "there is no channel 3, the file has 2" in refusal(tmp_path / "r.mat", sensors={"bearing": {"z": 3}})
    tacho = TachometerTable(channel="key", pulses_per_turn=1.0, shaft=1, level=None)
    assert 'there is no channel "key"' in refusal(tmp_path / "r.mat", tachometer=tacho)


def test_channels_of_different_lengths_are_refused_unless_sensors_of_one_length_are_named(tmp_path):
    savemat(tmp_path / "r.mat", {"a": signals()[:, 0], "b": signals(900)[:, 0], "fs": RATE})
    assert "different numbers of samples (a 3000, b 900)" in refusal(tmp_path / "r.mat")
    with read_recording(tmp_path / "r.mat", machine(sensors={"one": {"z": "b"}})) as found:
        assert found.sizes["time"] == 900


def test_a_rate_that_contradicts_the_file_is_refused(tmp_path):
    WRITERS["r.mat"](tmp_path / "r.mat", signals())
    assert 'rate_Hz gives 25600 Hz, "drive_end" 10000 Hz' in refusal(tmp_path / "r.mat", rate_Hz=25_600.0)
    with read_recording(tmp_path / "r.mat", machine(rate_Hz=RATE * (1 + 5e-5))) as found:
        assert 1.0 / found.time.values[1] == pytest.approx(RATE * (1 + 5e-5))  # within 1e-4: the machine's


def test_a_file_without_time_or_rate_asks_for_it(tmp_path):
    assert "holds neither the time nor the sampling rate. Set rate_Hz" in refusal(saved(tmp_path, signals()))


def timed(tmp_path, time):
    savemat(tmp_path / "r.mat", {"time": time, "a": signals()[:, 0]})
    return tmp_path / "r.mat"


def test_a_lost_sample_makes_the_time_uneven(tmp_path):
    steps = np.arange(3000) / RATE
    lost = np.concatenate([steps[:1500], steps[1500:] + 1.0 / RATE])
    said = refusal(timed(tmp_path, lost))
    assert 'the time in "time" is uneven: sample 150' in said
    assert "deviates from even steps by 0.5 steps, 0.4 are allowed" in said
    assert f"The first jump is from sample 1500 ({steps[1499]:.6g}) to the next ({steps[1501]:.6g})" in said


def test_jitter_is_refused_and_rounded_instants_are_not(tmp_path):
    steps = np.arange(3000) / 9_999.7
    jitter = np.random.default_rng(2).uniform(-0.2, 0.2, 3000) / RATE
    assert "is uneven" in refusal(timed(tmp_path, steps + jitter))
    with read_recording(timed(tmp_path, np.round(steps, 5)), machine()) as found:  # a tenth of a step
        assert 1.0 / found.time.values[1] == pytest.approx(9_999.7, rel=1e-4)
    path = timed(tmp_path, np.round(steps * 1.3, 4))
    assert "if the time only has too few digits, set time = false" in refusal(path, rate_Hz=RATE / 1.3)
    with read_recording(path, machine(rate_Hz=RATE / 1.3, time=False)) as found:
        assert found.time.values[1] == pytest.approx(1.3 / RATE)


def test_time_in_single_precision_is_as_even_as_its_digits_allow(tmp_path):
    time = 100.0 + np.arange(3000) / 51_200
    with read_recording(timed(tmp_path, time.astype(np.float32)), machine(rate_Hz=51_200.0)) as found:
        assert found.time.values[-1] == pytest.approx(time[-1], abs=1e-5)


def test_time_that_falls_or_stands_or_has_unknown_units_is_refused(tmp_path):
    assert "it must increase" in refusal(timed(tmp_path, -np.arange(3000) / RATE))
    assert "it must increase" in refusal(timed(tmp_path, np.full(3000, 7.0)))
    write_text(tmp_path / "r.csv", signals())
    text = (tmp_path / "r.csv").read_text(encoding="utf-8").replace("time [s]", "time [fortnights]")
    (tmp_path / "r.csv").write_text(text, encoding="utf-8")
    assert "has the units fortnights, allowed are s, ms, us, min" in refusal(tmp_path / "r.csv")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("0.05,1.0,abc", 'line 502, column free end: "abc" is not a number'),
        ("0.05,,2.0", "line 502, column drive end: the cell is empty"),
        ("0.05,1.0", "line 502 has 2 cells, but the first line of data has 3"),
        ("0.05,1.0,2.0,3.0", "line 502 has 4 cells, but the first line of data has 3"),
        ("0.05,1.0,2.0,", "line 502 has 4 cells, but the first line of data has 3"),
        ("0.05,1.0,\uff12", 'line 502, column free end: "\uff12" is not a number'),
        ("2024-05-01 12:00:00,1.0,2.0", 'column time: "2024-05-01 12:00:00" is not a number'),
    ],
)
def test_a_bad_line_of_text_is_named(line, said, tmp_path):
    write_text(tmp_path / "r.csv", signals())
    lines = (tmp_path / "r.csv").read_text(encoding="utf-8").splitlines()
    lines[501] = line
    (tmp_path / "r.csv").write_text("\n".join(lines), encoding="utf-8")
    assert said in refusal(tmp_path / "r.csv")


def test_a_text_without_numbers_is_refused(tmp_path):
    (tmp_path / "r.txt").write_text("this is a letter\n" * 20, encoding="utf-8")
    assert "none of its first 20 lines holds numbers alone" in refusal(tmp_path / "r.txt")
    (tmp_path / "r.txt").write_text("this is a letter", encoding="utf-8")
    assert "no line holds numbers alone" in refusal(tmp_path / "r.txt")
    (tmp_path / "r.txt").write_text("\n\n", encoding="utf-8")
    assert "is empty" in refusal(tmp_path / "r.txt")


def test_units_that_are_no_acceleration_are_refused_where_a_sensor_names_them(tmp_path):
    with h5py.File(tmp_path / "r.h5", "w") as file:
        for name, units in (("speed", "rpm"), ("bearing", "V")):
            file[name] = signals()[:, 0]
            file[name].attrs["units"] = units
    named = {"one": {"z": "speed"}}
    assert '"speed" is in rpm, allowed are m/s2, mm/s2, g, mg, V, mV' in refusal(
        tmp_path / "r.h5", rate_Hz=RATE, sensors=named
    )
    assert '"bearing" is in V. Set sensitivity_mV_g' in refusal(tmp_path / "r.h5", rate_Hz=RATE)
    with read_recording(tmp_path / "r.h5", machine(rate_Hz=RATE, sensitivity_mV_g=100.0)) as found:
        assert list(found.sensor.values) == ["bearing"]  # the speed is no sensor


def test_units_that_the_machine_overrules_are_told(tmp_path):
    with h5py.File(tmp_path / "r.h5", "w") as file:
        file["bearing"] = signals()[:, 0]
        file["bearing"].attrs["units"] = "g"
    with read_recording(tmp_path / "r.h5", machine(rate_Hz=RATE, units="m/s2")) as found:
        np.testing.assert_array_equal(found.acceleration.values[:, 0, 0], signals()[:, 0])
        (said,) = json.loads(found.attrs["warnings"]).values()
    assert said == (
        "bearing z is read in m/s2 as the machine file gives it; the recording gives g. Correct units if this is wrong."
    )


@pytest.mark.parametrize("limit", [2.0, 3.0])
def test_a_clipped_signal_is_told_with_its_share(limit, tmp_path):
    noise = np.random.default_rng(4).normal(size=20_000)
    share = np.mean(np.abs(noise) >= limit)
    with read_recording(saved(tmp_path, np.clip(noise, -limit, limit)), machine(rate_Hz=RATE)) as found:
        (said,) = json.loads(found.attrs["warnings"]).values()
    assert f"is clipped: {share:.2%} of its samples lie at its extreme values, {-limit:g} and {limit:g} m/s2" in said


@pytest.mark.parametrize("kind", ["noise", "tone", "tone of 16 bits", "tone of 8 bits"])
def test_a_signal_that_is_not_clipped_is_not_told_to_be(kind, tmp_path):
    time = np.arange(20_000) / RATE
    values = np.random.default_rng(5).normal(size=20_000) if kind == "noise" else np.cos(2 * np.pi * 31.7 * time)
    levels = {"tone of 16 bits": 2**15, "tone of 8 bits": 2**7}.get(kind)
    values = values if levels is None else np.round(values * levels) / levels
    with read_recording(saved(tmp_path, values), machine(rate_Hz=RATE)) as found:
        assert json.loads(found.attrs["warnings"]) == {}


def test_a_universal_file_of_binary_or_complex_functions_is_refused(tmp_path):
    head = Function(lines=("a",), size=300, start=0.0, step=1e-4, quantity=12)
    with (tmp_path / "r.uff").open("w", encoding="ascii") as file:
        write_function(file, head, [signals(300)[:, 0]])
    text = (tmp_path / "r.uff").read_text(encoding="ascii")
    (tmp_path / "r.uff").write_text(text.replace("    58\n", "    58b\n", 1), encoding="ascii")
    assert "binary (58b), text is read; save it as ASCII" in refusal(tmp_path / "r.uff")
    complex_form = text.replace(f"{4:10d}{300:10d}", f"{6:10d}{300:10d}")
    (tmp_path / "r.uff").write_text(complex_form, encoding="ascii")
    assert "are complex" in refusal(tmp_path / "r.uff")
    (tmp_path / "r.uff").write_text(text.replace(f"{1:5d}{0:10d}", f"{4:5d}{0:10d}"), encoding="ascii")
    assert "no channel has the unit of an acceleration" in refusal(tmp_path / "r.uff")  # a frequency response alone


def test_two_channels_of_one_sensor_and_axis_ask_for_names(tmp_path):
    head = Function(lines=("a",), size=300, start=0.0, step=1e-4, quantity=12, node=1, direction=1)
    with (tmp_path / "r.uff").open("w", encoding="ascii") as file:
        write_function(file, head, [signals(300)[:, 0]])
        write_function(file, head, [signals(300)[:, 1]])
    assert "node_1 x exists twice, as a and a (2)" in refusal(tmp_path / "r.uff")


def test_what_nptdms_guesses_at_is_refused_and_not_printed(tmp_path, capfd):
    WRITERS["r.tdms"](tmp_path / "r.tdms", signals())
    content = (tmp_path / "r.tdms").read_bytes()
    (tmp_path / "r.tdms").write_bytes(content.replace(b"wf_increment", b"wf_\xf3ncrement"))
    assert "is damaged or cut off (Error decoding string" in refusal(tmp_path / "r.tdms")
    assert capfd.readouterr() == ("", "")


def test_a_classic_netcdf_file_says_how_to_convert_it(tmp_path):
    (tmp_path / "r.nc").write_bytes(b"CDF\x01" + bytes(100))
    assert "nccopy -k nc4" in refusal(tmp_path / "r.nc")


def test_a_machine_file_with_the_stages_of_a_scene_is_told_how_teeth_are_given(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text("speed_rpm = 1500\n[[stages]]\npinion_teeth = 25\nwheel_teeth = 62\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"speed_rpm can only be in a machine file.* replace stages by teeth = \[\["):
        read_machine(path)


def test_a_machine_file_of_stages_alone_is_told_what_is_missing(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text("[[stages]]\npinion_teeth = 25\nwheel_teeth = 62\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"bench.toml: holds stages alone.* by teeth = \[\[.* set speed_rpm"):
        read_machine(path)
