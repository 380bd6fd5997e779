"""Bearings are diagnosed without healthy recordings, by impacts at a pass order."""

from __future__ import annotations

import re

import numpy as np
import pytest

from pipelines.cli.main import main
from pipelines.diagnosis.impacts import CLEAR
from pipelines.io.errors import InputError
from pipelines.runs.judged_recording import judge_files
from pipelines.runs.judged_words import file_facts, file_words, files_grid
from pipelines.signals.features.passing import PASSING, pass_levels

RATE, SECONDS, SPEED = 12000, 6.0, 29.0  # Hz, s, Hz of the shaft
OUTER, INNER = 3.585, 5.415  # passes per turn
MACHINE = """
ratios = [1.0]
speed = { rpm = 1740, uncertainty_percent = 0.3 }
rate_Hz = 12000
bearings = [{ name = "DE", shaft = 1, BPFO = 3.585, BPFI = 5.415, BSF = 2.357, FTF = 0.398 }]
"""


def impacts(order: float, slip: float, random: np.random.Generator) -> np.ndarray:
    """Decaying oscillations of 3 kHz at a pass order, the elements slipping at random by 0.5 % on average."""
    signal = np.zeros(round(RATE * SECONDS))
    steps = (1.0 + 0.005 * random.standard_normal(4000)) / (SPEED * order * (1.0 + slip))
    starts = np.round(RATE * np.cumsum(steps)).astype(int)
    signal[starts[starts < len(signal)]] = 1.0
    decay = np.arange(120) / RATE
    return np.convolve(signal, np.exp(-decay / 1e-3) * np.sin(2.0 * np.pi * 3000.0 * decay))[: len(signal)]


def unbalanced(random: np.random.Generator) -> np.ndarray:
    """Lines of the shaft that also modulate noise, as healthy machines have."""
    time = np.arange(round(RATE * SECONDS)) / RATE
    turn = 2.0 * np.pi * SPEED * time
    noise = random.standard_normal(len(time)) * (1.0 + 0.5 * np.cos(turn) + 0.3 * np.cos(4.0 * turn))
    return 0.3 * noise + np.cos(turn) + 0.3 * np.cos(2.0 * turn)


def judged(tmp_path, signal: np.ndarray, machine: str = MACHINE):
    (tmp_path / "machine.toml").write_text(machine, encoding="utf-8")
    np.save(tmp_path / "record.npy", signal)
    return next(judge_files([tmp_path / "record.npy"], machine=tmp_path / "machine.toml"))


@pytest.mark.parametrize(("order", "slip", "name"), [(OUTER, -0.012, "DE BPFO"), (INNER, 0.004, "DE BPFI")])
def test_impacts_at_a_pass_order_name_the_race_whatever_the_slip(tmp_path, order, slip, name):
    random = np.random.default_rng(1)
    found = judged(tmp_path, unbalanced(random) + 2.0 * impacts(order, slip, random))
    assert found.impacts[0].component == name
    assert found.impacts[0].clear
    assert not any(one.clear for one in found.impacts[1:])
    assert file_words(found).startswith(f"Damaged: {name}, impacts at its pass order ")


@pytest.mark.parametrize("rpm", [1675, 1710, 1790])  # the shaft turns at 1740 rpm
def test_a_speed_known_within_5_percent_follows_from_the_multiples_of_the_shaft(tmp_path, rpm):
    random = np.random.default_rng(1)
    signal = unbalanced(random) + 2.0 * impacts(OUTER, 0.0, random)
    exact = judged(tmp_path, signal).impacts[0]
    rough = MACHINE.replace("rpm = 1740, uncertainty_percent = 0.3", f"rpm = {rpm}, uncertainty_percent = 5")
    found = judged(tmp_path, signal, rough).impacts[0]
    assert found.component == "DE BPFO"
    assert abs(found.level - exact.level) < 1.0


def test_the_speed_that_the_multiples_of_the_shaft_show_is_stated_if_no_other_is_possible(tmp_path):
    random = np.random.default_rng(1)
    signal = unbalanced(random) + 2.0 * impacts(OUTER, 0.0, random)
    nominal = MACHINE.replace("rpm = 1740, uncertainty_percent = 0.3", "rpm = 1675, uncertainty_percent = 5")
    facts = file_facts(judged(tmp_path, signal, nominal))
    assert abs(facts["speed_rpm"] / (60.0 * SPEED) - 1.0) < 1e-3
    assert facts["speed_uncertainty_percent"] < 1.0
    assert "the multiples of the shafts in the envelope determine it better" in facts["turning"]


def test_a_window_can_end_with_the_recording_and_not_later(tmp_path):
    """Rounded times of samples end before 2 s: the last one plus one step is 1.9999999999999998 s."""
    rate = 20000
    judged(tmp_path, np.random.default_rng(1).standard_normal(2 * rate), MACHINE.replace("12000", str(rate)))
    files = tmp_path / "record.npy", (), tmp_path / "machine.toml"
    assert next(judge_files([files[0]], *files[1:], window=(0.1, 2.0))).recorded.turning.count("0.1 to 2 s") == 1
    for window in ((0.1, 2.0001), (2.0, 3.0), (1.0, 0.5)):
        with pytest.raises(InputError, match=rf"from {window[0]:g} to {window[1]:g} s is not within the recording"):
            next(judge_files([files[0]], *files[1:], window=window))


def test_orders_at_constant_speed_have_no_pictures_over_the_speed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    judged(tmp_path, unbalanced(np.random.default_rng(1)))
    assert main(["orders", "record.npy", "--machine", "machine.toml", "--orders", "1", "--out", "seen"]) == 0
    assert "The speed is constant within 1 %: there are no pictures over the speed." in capsys.readouterr().out
    assert not list((tmp_path / "seen").iterdir())


def test_orders_of_a_run_up_without_tachometer_name_the_file_and_ask_for_the_speed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    time = np.arange(round(RATE * SECONDS)) / RATE
    turn = 2 * np.pi * (20.0 * time + 2.0 * time**2)
    random = np.random.default_rng(1)
    judged(tmp_path, np.cos(20 * turn) + 0.1 * random.standard_normal(len(time)))
    (tmp_path / "gears.toml").write_text("teeth = [[20, 31]]\nspeed_rpm = 1740\nrate_Hz = 12000\n", encoding="utf-8")
    assert main(["orders", "record.npy", "--machine", "gears.toml"]) == 2
    message = capsys.readouterr().err
    assert "record.npy: the speed cannot be found" in message
    assert 'speed = { channel = "n", units = "rpm" }, which a run-up needs' in message


@pytest.mark.parametrize("seed", range(5))
def test_the_speed_of_noise_is_the_nominal_one_with_its_uncertainty(tmp_path, seed):
    noise = np.random.default_rng(seed).standard_normal(round(RATE * SECONDS))
    nominal = MACHINE.replace("rpm = 1740, uncertainty_percent = 0.3", "rpm = 1675, uncertainty_percent = 2")
    found = judged(tmp_path, noise, nominal)
    assert "1675 rpm (known to 2 %)" in found.recorded.turning
    assert files_grid(["a"], [found]).rows[0][5:7] == ("1675", "2")


@pytest.mark.parametrize("rpm", [1675, 1790])
def test_multiples_of_a_shaft_of_roughly_known_speed_are_no_impacts_of_a_bearing(tmp_path, rpm):
    time = np.arange(round(RATE * SECONDS)) / RATE
    random = np.random.default_rng(4)
    bursts = np.maximum(np.cos(2.0 * np.pi * SPEED * time), 0.0) ** 20  # many multiples, among them 3, 6 and 9
    machine = MACHINE.replace("rpm = 1740, uncertainty_percent = 0.3", f"rpm = {rpm}, uncertainty_percent = 5")
    found = judged(tmp_path, (1.0 + 3.0 * bursts) * random.standard_normal(len(time)), machine.replace("3.585", "3.05"))
    assert found.impacts[0].level < CLEAR - 5.0


def test_the_page_of_a_recording_of_bearings_alone_begins_with_the_race(tmp_path, capsys):
    random = np.random.default_rng(1)
    judged(tmp_path, unbalanced(random) + 2.0 * impacts(OUTER, 0.0, random))
    files = [str(tmp_path / name) for name in ("record.npy", "machine.toml")]
    assert main(["diagnose", files[0], "--machine", files[1], "--out", str(tmp_path / "seen")]) == 0
    page = (tmp_path / "seen" / "report.html").read_text(encoding="utf-8")
    assert '<div class="verdict fault" id="verdict"><p>Damaged: DE BPFO' in page


def test_several_recordings_give_a_table_and_a_page_each(tmp_path, monkeypatch, capsys):
    random = np.random.default_rng(1)
    judged(tmp_path, unbalanced(random))
    (tmp_path / "record.npy").rename(tmp_path / "monday.npy")
    judged(tmp_path, unbalanced(random) + 2.0 * impacts(OUTER, 0.0, random))
    monkeypatch.chdir(tmp_path)
    assert main(["diagnose", "monday.npy", "record.npy", "--machine", "machine.toml", "--out", "seen"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if ".npy" in line][:2]
    assert [row[2] for row in rows] == ["-", "damaged"]
    assert rows[1][3:5] == ["DE", "BPFO"]
    assert all((tmp_path / "seen" / number / "report.html").is_file() for number in "12")


def test_a_table_of_recordings_has_a_row_for_each_and_their_warnings(tmp_path, capsys):
    random = np.random.default_rng(1)
    channel = "rpm = 1740, uncertainty_percent = 0.3", "channel = 2, uncertainty_percent = 0.3"
    machine = MACHINE.replace(*channel).replace("rate_Hz", "sensors = { housing = 1 }\nrate_Hz")
    (tmp_path / "machine.toml").write_text(machine, encoding="utf-8")
    for name, speed in (("slow", 0.9), ("fast", 1.0)):
        signal = unbalanced(random)
        np.save(tmp_path / f"{name}.npy", np.stack([signal, np.full(len(signal), 60.0 * speed * SPEED)], axis=1))
    slow, fast, file = (str(tmp_path / name) for name in ("slow.npy", "fast.npy", "machine.toml"))
    assert main(["diagnose", fast, fast, "--machine", file, "--baseline", slow]) == 0
    printed = capsys.readouterr().out
    assert len([line for line in printed.splitlines() if line[1:].strip().startswith(fast)]) == 2
    assert printed.count("Warning: 1 of 1 healthy recordings differ") == 1  # that of both


@pytest.mark.parametrize("seed", range(5))
def test_lines_of_the_shaft_are_no_impacts_of_a_bearing(tmp_path, seed):
    found = judged(tmp_path, unbalanced(np.random.default_rng(seed)))
    assert found.impacts[0].level < CLEAR - 5.0
    assert file_words(found).startswith("No damage of an examined part of a bearing is clear.")


@pytest.mark.parametrize(("uncertainty", "useful"), [("0.3", False), ("0.01", True)])
def test_healthy_recordings_are_requested_only_for_components_that_they_help_to_diagnose(tmp_path, uncertainty, useful):
    machine = MACHINE.replace("uncertainty_percent = 0.3", f"uncertainty_percent = {uncertainty}")
    words = file_words(judged(tmp_path, unbalanced(np.random.default_rng(0)), machine))
    assert ("Give healthy recordings to diagnose shaft_1: --baseline" in words) == useful
    assert ("--baseline" in words) == useful


def test_one_line_however_strong_is_no_comb():
    turns, places = 100, 256
    envelope = 1.0 + np.cos(2.0 * np.pi * OUTER * np.arange(turns * places) / places)
    envelope += 1e-5 * np.random.default_rng(2).standard_normal(envelope.shape)
    (level,) = pass_levels(envelope.reshape(1, turns, places), {"BPFO": OUTER})["BPFO", PASSING]
    assert 20.0 * np.log10(level) < CLEAR


def test_a_cage_is_not_judged_without_healthy_recordings(tmp_path):
    random = np.random.default_rng(3)
    found = judged(tmp_path, unbalanced(random) + 2.0 * impacts(0.398, 0.0, random))
    assert all("FTF" not in one.component for one in found.impacts)


def test_a_cage_that_turns_too_seldom_is_named_in_text_facts_and_pages(tmp_path, capsys):
    judged(tmp_path, unbalanced(np.random.default_rng(1)))
    (tmp_path / "record.npy").rename(tmp_path / "monday.npy")
    judged(tmp_path, unbalanced(np.random.default_rng(2)))
    files = [str(tmp_path / name) for name in ("record.npy", "monday.npy")]
    asked = ["--machine", str(tmp_path / "machine.toml"), "--window", "0", "1"]
    reason = r"DE FTF: its pass frequency \(11\.5\d* Hz\) has too few periods; the window has 1 s, "
    assert main(["diagnose", files[0], *asked]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("No damage of an examined part of a bearing is clear.")
    assert re.search(f"Not examined: {reason}", printed)
    assert main(["diagnose", files[0], *asked, "--json"]) == 0
    assert re.search(reason, capsys.readouterr().out)
    assert main(["diagnose", *files, *asked, "--out", str(tmp_path / "seen")]) == 0
    assert re.search(f"Not examined: {reason}", capsys.readouterr().out)
    for page in ("report.html", "1/report.html"):
        assert re.search(f"Not examined: {reason}", (tmp_path / "seen" / page).read_text(encoding="utf-8"))
