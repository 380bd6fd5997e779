"""Recordings side by side: differences of known tones are exact, whatever the rate, the length and the sensors."""

import csv
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray
from matplotlib.backends.backend_agg import FigureCanvasAgg

import gearcase
from pipelines.cli.main import main
from pipelines.diagnosis.comparison.compared_features import features_of, most_different_shaft
from pipelines.diagnosis.comparison.compared_recording import brought_together, compared_recording
from pipelines.diagnosis.comparison.curves import curves
from pipelines.report.figures.comparison_plots import _mark, envelopes_figure
from pipelines.report.figures.plots import new_figure
from pipelines.scene.load_scene import load_scene
from pipelines.signals.features.synchronous_averages import FEWEST_TURNS
from pipelines.signals.orders.kinematics import Bearing, Gear, Kinematics, Shaft

SPEED = 25.0  # turns per second of the first shaft
KINEMATICS = Kinematics(
    shafts=(Shaft(name="shaft_1", ratio=1.0), Shaft(name="shaft_2", ratio=0.5)),
    gears=(
        Gear(name="stage 1 pinion", shaft="shaft_1", stage=1, teeth=20),
        Gear(name="stage 1 wheel", shaft="shaft_2", stage=1, teeth=40),
    ),
)


def recording(tones, rate=10_000.0, seconds=2.0, sensors=("a", "b"), axes=("z",), sense=1.0, noise=0.0):
    """Tones {order of the first shaft: amplitude in m/s2} at every sensor, with the recorded angle of shaft 1."""
    time = np.arange(round(seconds * rate)) / rate
    angle = sense * 2 * np.pi * SPEED * time
    signal = sum(amplitude * np.cos(order * angle + order) for order, amplitude in tones.items())
    laid = np.tile(signal[:, None, None], (1, len(sensors), len(axes)))
    laid = laid + noise * np.random.default_rng(3).standard_normal(laid.shape)
    return xarray.Dataset(
        {
            "acceleration": (("time", "sensor", "axis"), laid),
            "shaft_angle": (("time", "shaft"), angle[:, None]),
        },
        coords={"time": time, "sensor": list(sensors), "axis": list(axes), "shaft": ["shaft_1"]},
    )


def together(*recordings, windows=None):
    """The recordings as parts with the same channels and rate."""
    return brought_together([compared_recording(f"r{i}", one, KINEMATICS, windows) for i, one in enumerate(recordings)])


def difference(found, component, feature, row=1):
    return found.difference[row, found.lines.index((component, feature))]


def test_differences_of_two_tones_are_those_of_their_amplitudes():
    parts = together(recording({20: 1.0, 21: 0.2}), recording({20: 1.0, 21: 0.5}))
    found = features_of(parts)
    rise = 20 * np.log10(0.5 / 0.2)
    assert difference(found, "stage 1 pinion", "sideband_ratio") == pytest.approx(rise, abs=1e-3)
    assert difference(found, "whole machine", "rms") == pytest.approx(10 * np.log10(1.25 / 1.04), abs=1e-3)
    drawn = curves(parts, ("a", "z"), "shaft_1")
    np.testing.assert_allclose(drawn.spectrum[:, np.isclose(drawn.orders, 20)].ravel(), [1.0, 1.0], rtol=1e-4)
    np.testing.assert_allclose(drawn.spectrum[:, np.isclose(drawn.orders, 21)].ravel(), [0.2, 0.5], rtol=1e-4)


def test_a_recording_does_not_differ_from_itself():
    one = recording({20: 1.0, 1: 0.1}, noise=0.1)
    found = features_of(together(one, one))
    assert np.all(found.difference[np.isfinite(found.difference)] == 0.0)


def test_the_difference_of_a_weak_order_is_that_of_its_values():
    tones = {20: 1.0, 21: 0.2, 1: 0.001}
    found = features_of(together(recording(tones), recording(tones | {1: 0.003, 21: 0.3})))
    assert difference(found, "shaft_1", "order_1") == pytest.approx(20 * np.log10(3.0), abs=0.01)
    assert found.value[:, found.lines.index(("shaft_1", "order_1"))] == pytest.approx([0.001, 0.003], rel=1e-3)


def test_what_a_lower_rate_cannot_hold_is_compared_in_neither():
    """The second recorder is faster and sees a tone of 6 kHz that the first one cannot have."""
    slow, fast = recording({20: 1.0, 3: 0.3}), recording({20: 1.0, 3: 0.3, 240: 5.0}, rate=25_600.0)
    parts = together(slow, fast)
    assert [part.rate for part in parts] == pytest.approx([10_000.0, 10_000.0])
    found = features_of(parts)
    for feature in ("rms", "crest_factor", "kurtosis"):
        assert abs(difference(found, "whole machine", feature)) < 0.05
    drawn = curves(parts, ("a", "z"), "shaft_1")
    assert drawn.orders[-1] == pytest.approx(0.45 * 10_000.0 / SPEED, abs=0.1)
    np.testing.assert_allclose(drawn.spectrum[1], drawn.spectrum[0], atol=2e-3)
    np.testing.assert_allclose(drawn.average[1], drawn.average[0], atol=2e-3)
    later = together(slow, fast.assign_coords(time=fast.time + 100.0))[1]
    assert later.time[[0, -1]] == pytest.approx([100.0, 102.0], abs=1e-3)


def test_lengths_and_windows_may_differ():
    tones = {20: 1.0, 20.5: 0.2}
    parts = brought_together(
        [
            compared_recording("short", recording(tones, seconds=1.0), KINEMATICS),
            compared_recording("long", recording(tones, seconds=4.0), KINEMATICS, {"middle": (1.0, 3.5)}),
        ]
    )
    assert [part.windows[0].turns for part in parts] == pytest.approx([25.0, 62.5], abs=0.01)
    drawn = curves(parts, ("a", "z"), "shaft_2")
    assert drawn.turns == 23  # one is left out at either end of a recording
    np.testing.assert_allclose(drawn.spectrum[1], drawn.spectrum[0], atol=1e-3)
    np.testing.assert_allclose(drawn.average[1], drawn.average[0], atol=1e-3)


def test_a_window_of_a_louder_part_is_louder():
    quiet, loud = recording({20: 1.0}), recording({20: 4.0})
    both = xarray.concat([quiet, loud.assign_coords(time=loud.time + 2.0)], dim="time")
    both["shaft_angle"][:, 0] = 2 * np.pi * SPEED * both.time.values
    parts = brought_together(
        [
            compared_recording(name, both, KINEMATICS, {name: span})
            for name, span in (("first", (0.2, 1.8)), ("second", (2.2, 3.8)))
        ]
    )
    assert difference(features_of(parts), "whole machine", "rms") == pytest.approx(20 * np.log10(4.0), abs=1e-3)


def test_lowering_has_the_spectrum_and_the_average_of_lifting():
    """Backwards through the same places: a line at order 1.25 stays one line, a tooth stays where it is."""
    tones = {20: 1.0, 1.25: 0.5}
    drawn = curves(together(recording(tones), recording(tones, sense=-1.0)), ("a", "z"), "shaft_1")
    np.testing.assert_allclose(drawn.spectrum[1], drawn.spectrum[0], atol=5e-3)
    places = drawn.average.shape[1]
    mesh = np.fft.rfft(drawn.average, axis=-1)[:, 20] * 2 / places
    np.testing.assert_allclose(np.abs(mesh), 1.0, rtol=1e-3)


def test_common_sensors_are_compared_whatever_their_order():
    loud = recording({20: 3.0}, sensors=("c", "b"), axes=("x", "z"))
    loud.acceleration.loc[{"sensor": "c"}] = 99.0 * loud.acceleration.sel(sensor="c")
    parts = together(recording({20: 1.0}), loud)
    assert parts[0].channels == parts[1].channels == (("b", "z"),)
    assert difference(features_of(parts), "whole machine", "rms") == pytest.approx(20 * np.log10(3.0), abs=1e-3)


def test_without_a_common_sensor_the_error_names_those_there_are():
    with pytest.raises(ValueError, match=r"no channel is in all recordings \(r0: a z, b z; r1: c z\)"):
        together(recording({20: 1.0}), recording({20: 1.0}, sensors=("c",)))


def test_the_envelope_shows_the_modulation_that_the_spectrum_has_as_sidebands():
    modulated = {20: 1.0, 19.5: 0.2, 20.5: 0.2}  # amplitude 1 + 0.4 cos(shaft 2), when the phases fit
    drawn = curves(together(recording({20: 1.0}), recording(modulated)), ("a", "z"), "shaft_2")
    line = np.isclose(drawn.orders, 0.5)
    assert drawn.envelope[0, line] < 1e-3
    # squared: 1 + 0.8 cos + 0.16 cos^2, whose mean is 1.08
    assert drawn.envelope[1, line] == pytest.approx(0.8 / 1.08, rel=1e-2)


def test_the_averages_are_those_of_the_shaft_that_differs_most():
    healthy = recording({20: 1.0, 0.5: 0.01, 1: 0.01}, noise=0.01)
    worn = recording({20: 1.0, 0.5: 0.2, 1: 0.01}, noise=0.01)
    found = features_of(together(healthy, worn))
    assert most_different_shaft(found, KINEMATICS, ["shaft_1", "shaft_2"]) == "shaft_2"


def test_a_bearing_fault_makes_its_own_shaft_differ_most():
    bearing = Bearing(name="bearing_1", shaft="shaft_2", orders={"BSF": 2.31})
    machine = replace(KINEMATICS, bearings=(bearing,))
    assert bearing.strikes == {"bearing_1 2 BSF": 4.62}
    time = np.arange(40_000) / 10_000.0
    carrier = np.random.default_rng(5).standard_normal(time.size)
    knocks = 1.0 + 0.9 * np.cos(4.62 * 0.5 * 2 * np.pi * SPEED * time)
    pair = [recording({20: 1.0}, seconds=4.0, noise=0.3) for _ in range(2)]
    pair[1].acceleration.values += 0.3 * (carrier * knocks)[:, None, None]
    pair[0].acceleration.values += 0.3 * carrier[:, None, None]
    found = features_of(tuple(compared_recording(name, one, machine) for name, one in zip("ab", pair, strict=True)))
    assert ("bearing_1 2 BSF", "pass_order") in found.lines
    assert most_different_shaft(found, machine, ["shaft_1", "shaft_2"]) == "shaft_2"


def test_an_average_from_an_unknown_mark_is_turned_to_lie_over_the_first():
    one = compared_recording("one", recording({20: 1.0, 1: 0.5, 3: 0.3}), KINEMATICS)
    shifted = replace(one.rotation, angle=one.rotation.angle + np.pi / 2, absolute=False)
    drawn = curves((one, replace(one, rotation=shifted)), ("a", "z"), "shaft_1")
    assert drawn.turned == (False, True)
    np.testing.assert_allclose(drawn.average[1], drawn.average[0], atol=1e-3)


def write(path, signal, rate=10_000.0):
    """A text file of two sensors and a tachometer with one pulse per turn."""
    time = np.arange(len(signal)) / rate
    pulses = 5.0 * ((SPEED * time) % 1.0 < 0.1)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time [s]", "drive end [m/s2]", "free end [m/s2]", "key [V]"])
        writer.writerows(
            [[f"{value:.9g}" for value in row] for row in zip(time, signal, 0.5 * signal, pulses, strict=True)]
        )


def test_names_of_orders_are_above_the_curves_and_do_not_overlap():
    orders = {"BPFO": 3.58, "BPFI": 5.42, "BSF": 2.36, "FTF": 0.4}
    bearings = tuple(Bearing(name=f"bearing_{n}", shaft=f"shaft_{1 + n // 3}", orders=orders) for n in range(1, 5))
    shafts = (Shaft(name="shaft_1", ratio=1.0), Shaft(name="shaft_2", ratio=0.47))
    place = np.arange(1, 2000) / 100.0
    rows = np.stack([1e-2 + np.exp(-((place - 3.58) ** 2) / 1e-3)] * 2)
    found = SimpleNamespace(orders=place, envelope=rows, channel=("a", "z"), band=(1.0, 2.0), turns=64)
    figure = envelopes_figure(found, ["A", "B"], Kinematics(shafts=shafts, bearings=bearings))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    axes = figure.axes[0]
    assert "bearing_1, bearing_2 BPFO" in [text.get_text() for text in axes.texts]
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in axes.texts]
    assert not any(one.overlaps(other) for n, one in enumerate(boxes) for other in boxes[:n])
    top = axes.transData.transform((1.0, rows.max()))[1]
    assert min(box.y0 for box in boxes) > top


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.toml").write_text(
        'teeth = [[20, 40]]\nsensors = { drive = "drive end", free = "free end" }\n[tachometer]\nchannel = "key"\n',
        encoding="utf-8",
    )
    time = np.arange(15_000) / 10_000.0
    for name, amplitude in (("healthy", 0.1), ("worn", 0.4)):
        noise = np.random.default_rng(1).normal(size=time.size)
        turn = 2 * np.pi * SPEED * time
        write(tmp_path / f"{name}.csv", np.cos(20 * turn) * (1 + amplitude * np.cos(turn)) + 0.01 * noise)
    return tmp_path


def test_the_command_writes_table_and_figures(files, capsys):
    assert main(["compare", "healthy.csv", "worn.csv", "worn.csv@0.2:1.2", "--machine", "bench.toml"]) == 0
    said = capsys.readouterr().out
    assert "0.2 to 1.2" in said
    assert said.count("1500") == 3  # rpm of each
    assert said.count("tachometer on shaft_1, 1 pulse per turn") == 3
    with (files / "comparison" / "features.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    (ratio,) = [row for row in rows if (row["component"], row["feature"]) == ("stage 1 pinion", "sideband_ratio")]
    assert float(ratio["B - A dB"]) == pytest.approx(20 * np.log10(4.0), abs=0.3)
    assert float(ratio["C - A dB"]) == pytest.approx(20 * np.log10(4.0), abs=0.3)
    for name in ("orders", "envelope-orders", "average", "rms"):
        assert (files / "comparison" / f"{name}.svg").read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["healthy.csv"], "1 recording given. Give 2 to 10"),
        (["healthy.csv", "worn.csv@lowering"], "lowering is not a window. Give start and end in seconds"),
        (["healthy.csv", "worn.csv@5:6"], "the recording lasts from 0 to 1.4999 s"),
        (["healthy.csv", "worn.csv@1.0:0.5"], "its start before its end"),
        (["healthy.csv", "worn.csv@1:1.05"], "worn.csv@1:1.05: no shaft makes 3 revolutions between 1 and 1.05 s"),
        (
            ["healthy.csv", "worn.csv", "--sensor", "motor"],
            "motor: not a channel of all recordings. Set --sensor and --axis to one of drive z",
        ),
        (["healthy.csv", "worn.csv", "--shaft", "3"], "--shaft 3: no shaft of this number makes enough revolutions"),
        (["healthy.csv", "nowhere.csv"], "nowhere.csv"),
    ],
)
def test_what_cannot_be_compared_is_said_in_one_sentence(files, capsys, words, message):
    assert main(["compare", *words, "--machine", "bench.toml"]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert len(said.splitlines()) == 1
    assert not (files / "comparison").exists()


def test_windows_of_a_run_go_by_their_names(tmp_path, monkeypatch, capsys):
    """Response and scene in one folder, as a run leaves them; lowering is half as loud."""
    monkeypatch.chdir(tmp_path)
    Path("hoist").mkdir()
    Path("hoist/scene.resolved.toml").write_text(load_scene("rig-healthy").resolved(), encoding="utf-8")
    run = recording({20: 1.0}, rate=2_000.0, seconds=5.1, noise=0.01)
    run["acceleration"] = run.acceleration.where(run.time < 2.75, 0.5 * run.acceleration)
    run.to_netcdf("hoist/response.nc", engine="h5netcdf")
    assert main(["compare", "hoist@lifting", "hoist@lowering", "--sensor", "b", "--out", "seen"]) == 0
    said = capsys.readouterr().out
    assert "0.5 to 2.5" in said
    assert "3 to 5" in said
    (rms,) = [line for line in said.splitlines() if line.startswith("whole machine   rms")]
    assert rms.split()[-1] == "-6.0"
    assert Path("seen/average.svg").exists()


def test_in_python_the_same_features_come_as_labelled_arrays(files):
    machine = "bench.toml"
    with gearcase.open_recording("healthy.csv", machine) as one, gearcase.open_recording("worn.csv", machine) as other:
        found = gearcase.compare({"healthy": one, "worn": other}, machine)
        rise = float(found.difference.sel(recording="worn", component="stage 1 pinion", feature="sideband_ratio"))
        assert rise == pytest.approx(20 * np.log10(4.0), abs=0.3)
        np.testing.assert_allclose(found.speed, 2 * np.pi * SPEED, rtol=1e-3)
        verdict = gearcase.judge(other, [one], machine)
        pinion = next(finding for finding in verdict.findings if finding.component == "stage 1 pinion")
        own = found.difference.sel(recording="worn", component="stage 1 pinion").dropna("feature")
        assert "sideband_ratio" in pinion.evidence.features
        assert pinion.evidence.increase >= float(own.mean()) - 1e-6  # the mean of the channels is no more than the best
        with pytest.raises(gearcase.InputError, match=r"1 recording given\. Give two or more"):
            gearcase.compare({"one": one}, machine)
        with pytest.raises(gearcase.InputError, match="no healthy recording"):
            gearcase.judge(other, [], machine)


def test_the_time_that_a_slow_shaft_needs_follows_from_the_longest_window():
    slow = replace(KINEMATICS, shafts=(*KINEMATICS.shafts, Shaft(name="slow", ratio=0.02)))
    windows = {"long": (0.1, 1.7), "late": (1.8, 1.95)}
    part = compared_recording("r", recording({20: 1.0}), slow, windows)
    (line,) = features_of([part, part]).tables[0].left_out
    assert line == f"slow: 0.8 turns in a window, {(FEWEST_TURNS + 1) * 2:g} s would be needed"


def test_the_names_of_orders_that_almost_coincide_are_all_readable():
    """2 BSF and BPFI of a bearing can differ by a hundredth of an order."""
    figure = new_figure(2.6)
    axes, span = figure.subplots(), (0.0, 20.0)
    axes.set_xlim(*span)
    marks = {"bearing_1 BPFI": 5.43, "shaft_1": 1.0, "bearing_1 2 BSF": 5.42, "bearing_1 BPFO": 3.57, "$f_{m1}$": 5.6}
    _mark(axes, marks, span, named=True)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.texts]
    assert {text.get_text() for text in axes.texts} == set(marks) - {"$f_{m1}$"}
    assert figure.get_supxlabel() == "Also marked: $f_{m1}$: 5.6"
    assert not any(one.overlaps(other) for n, one in enumerate(boxes) for other in boxes[:n])


def trained(period: float):
    """Curves of impulses at every `period` turns of the first shaft, in noise."""
    shafts = (KINEMATICS.shafts[0], Shaft(name="shaft_2", ratio=0.4))
    train = replace(KINEMATICS, shafts=shafts, gears=(KINEMATICS.gears[0], replace(KINEMATICS.gears[1], teeth=50)))
    run = recording({20: 0.0}, noise=0.01)
    run.acceleration[:: round(period * 10_000 / SPEED)] += 10.0
    return curves([compared_recording("r", run, train)], ("a", "z"), "shaft_1")


@pytest.mark.parametrize(("period", "ratio", "other"), [(2.5, 0.4, 1.0), (1.0, 1.0, 0.4)])
def test_the_cepstrum_of_impulses_has_lines_at_their_period_and_its_multiples_only(period, ratio, other):
    found = trained(period)
    step = 0.5 / found.orders[-1]
    away = np.abs(found.quefrency - period * np.round(found.quefrency / period))
    at_period = found.cepstrum[0, round(period / step)]
    between = found.cepstrum[0, (found.quefrency > 0.5) & (away > 5.0 * step)]
    assert at_period > 4.0 * np.abs(between).max()
    assert found.rahmonics(ratio)[0] > 2.0 * abs(found.rahmonics(other)[0])  # five turns are two and a half twice
    assert np.isnan(found.rahmonics(0.1)[0])  # thirty turns in a block of fifty, of which half are shown


def test_the_cepstrum_of_an_echo_is_half_its_factor_at_its_delay():
    found, factor, delay = trained(1.0), 0.6, 3.0
    echo = np.abs(1.0 + factor * np.exp(-2j * np.pi * found.orders * delay))
    cepstrum = replace(found, spectrum=echo[None]).cepstrum[0]
    place = round(delay * 2.0 * found.orders[-1])
    assert cepstrum[place] == pytest.approx(factor / 2, abs=1e-3)  # ln|1 + a exp(-jwT)| = a cos wT - a^2/2 cos 2wT ...
    assert cepstrum[2 * place] == pytest.approx(-(factor**2) / 4, abs=1e-3)


def test_names_of_many_lines_leave_two_thirds_of_a_logarithmic_axis_to_the_curves():
    """24 bearings have 96 pass orders. Those without a free row are named below the figure."""
    bearings = tuple(
        Bearing(name=f"bearing_{n}", shaft="shaft_1", orders={"BPFO": 3.0 + 0.01 * n, "BPFI": 5.0 + 0.01 * n})
        for n in range(24)
    )
    train = replace(KINEMATICS, bearings=bearings)
    found = curves([compared_recording("r", recording({20: 1.0}, noise=0.01), train)], ("a", "z"), "shaft_1")
    figure = envelopes_figure(found, ["A"], train)
    low, high = np.log(figure.axes[0].get_ylim())
    shown = np.log(found.envelope[:, (found.orders > 0.0) & (found.orders <= 10.0)].max())
    assert (high - shown) / (high - low) < 1 / 3 + np.log(2.0) / (high - low)
    named = figure.get_supxlabel() + "".join(text.get_text() for text in figure.axes[0].texts)
    assert all(one.name in named.replace("\n", " ") for one in bearings)
