"""Trend over recordings: in the order of time, with limits that few healthy machines exceed; first file above."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from test_impacts import INNER, MACHINE, RATE, impacts, unbalanced

from pipelines.cli.main import main
from pipelines.diagnosis.trend import Course, level_courses
from pipelines.report.figures.trend_plots import trend_figure
from pipelines.signals.levels import ChannelLevel

SIZES = (0.0, 0.0, 0.05, 1.0, 2.0)  # of the impacts, by day


def record(name: str, size: float, seed: int, day: int | None = None) -> str:
    """Vibration with impacts of the inner race; the file states the day, if there is one."""
    random = np.random.default_rng(seed)
    signal = unbalanced(random) + size * impacts(INNER, 0.0, random)
    facts = {} if day is None else {"start": f"2026-03-{day:02d} 08:00:00"}
    np.savez(name, a=signal, fs=float(RATE), **facts)
    return name


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("machine.toml").write_text(MACHINE, encoding="utf-8")


def trend(capsys, *words: str) -> dict:
    assert main(["diagnose", *words, "--machine", "machine.toml", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_files_given_in_any_order_are_in_that_of_their_times_and_the_first_with_damage_is_named(folder, capsys):
    names = [record(f"{day}.npz", size, day, day) for day, size in enumerate(SIZES, 1)]
    found = trend(capsys, *reversed(names))
    assert found["order"] == "In the order of the times in the files."
    assert [one["recording"] for one in found["recordings"]] == names
    courses = {one["name"]: one for one in found["trend"]}
    assert courses["DE BPFI"]["first_above"] == "4.npz"
    assert courses["DE BPFI"]["limit"] == 20.0
    assert courses["DE BPFO"]["first_above"] is None
    assert courses["acceleration a z"]["limit"] is None  # without healthy recordings


def test_without_all_times_the_order_is_the_given_one_and_healthy_recordings_give_limits_and_ranges(folder, capsys):
    names = [record(f"{day}.npz", size, day, day if day != 2 else None) for day, size in enumerate(SIZES, 1)]
    healthy = [record(f"h{seed}.npz", 0.0, 10 + seed) for seed in range(6)]
    found = trend(capsys, *reversed(names), "--baseline", *healthy)
    assert found["order"] == "In the order in which they were given, because 1 of 5 do not state when they begin."
    assert [one["recording"] for one in found["recordings"]] == names[::-1]
    courses = {one["name"]: one for one in found["trend"]}
    inner, level = courses["DE BPFI"], courses["acceleration a z"]
    assert (inner["limit"], inner["first_above"]) == (1.0, "5.npz")
    assert max(inner["values"][3:]) < 1.0 < min(inner["values"][:2])
    assert inner["healthy"][0] < 0.5 * sum(inner["healthy"]) < 1.0
    assert 0.95 * level["healthy"][0] < level["values"][-1] < level["limit"]


def test_the_page_of_a_trend_has_its_figures_and_the_pages_of_its_recordings(folder, capsys):
    names = [record(f"{day}.npz", size, day, day) for day, size in enumerate(SIZES[2:4], 1)]
    Path("cut.csv").write_text("t,a\n0,1\n0.1\n", encoding="utf-8")
    assert main(["diagnose", *names, "cut.csv", "--machine", "machine.toml", "--out", "seen"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("DE BPFI")]
    assert re.fullmatch(r"DE BPFI +impacts dB +- +20.00 +2 +[\d.]+ +[\d.]+", rows[-1])
    shown = Path("seen/report.html").read_text(encoding="utf-8")
    assert shown.count("<figure") == 3  # impacts, acceleration, velocity
    assert "Dashed: limit." in shown
    assert "Shaded" not in shown  # without healthy recordings
    links = re.findall('<a href="([^"]+)"', shown)
    assert links == ["1/report.html", "2/report.html"]
    assert all(Path("seen", link).is_file() for link in links)
    assert "<p>Refused: cut.csv: " in shown


def test_the_title_of_a_panel_is_within_the_figure(folder):
    names = [f"velocity gearbox_drive_end_{number} z" for number in range(3)]
    values = {"values": np.arange(3.0), "above": np.array([False, True, True]), "limit": 1.0, "healthy": None}
    figure = trend_figure([Course(name=name, unit="mm/s", **values) for name in names], None)
    titles = [axes.title for axes in figure.axes] + [axes._left_title for axes in figure.axes]
    ends = [title.get_window_extent(FigureCanvasAgg(figure).get_renderer()).x1 for title in titles]
    assert max(ends) <= figure.bbox.x1


def test_the_tables_of_thirty_recordings_are_readable_in_100_columns(folder, capsys):
    names = [record(f"measured_at_the_drive_end_on_day_{day:02d}.npz", 0.0, day, day) for day in range(1, 31)]
    assert main(["diagnose", *names, "--machine", "machine.toml"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith("Not examined: ")]
    assert max(map(len, lines)) <= 100
    values = [line for line in lines if line.startswith("DE BPFI  ")]
    assert len(" ".join(values).split("dB")[1].split()) == 3 + 30 + 2 * (len(values) - 1)  # all, none twice


def levels(random: np.random.Generator, offset: float = 0.0) -> list[ChannelLevel]:
    """Levels of a healthy machine at four sensors, which scatter by 1 dB and are raised by an offset in dB."""
    factors = 10.0 ** ((random.standard_normal((4, 2)) + offset) / 20.0)
    return [
        ChannelLevel(sensor=f"s{place}", axis="z", window="w", acceleration=float(a), velocity=float(v))
        for place, (a, v) in enumerate(factors)
    ]


def test_at_most_1_percent_of_healthy_machines_exceed_a_limit_of_their_levels_and_6_times_their_scatter_does():
    random = np.random.default_rng(0)
    count, above = 1000, 0
    for _ in range(count):
        healthy = [levels(random) for _ in range(8)]
        above += any(one.first for one in level_courses([levels(random)], healthy))
    assert above <= 0.01 * count + 3.0 * np.sqrt(0.01 * count)
    raised = level_courses([levels(random), levels(random), levels(random, 12.0)], [levels(random) for _ in range(8)])
    assert {one.first for one in raised} == {3}


def test_a_file_that_cannot_be_used_is_refused_in_the_table_and_the_others_are_judged(folder, capsys):
    good = [record(f"{day}.npz", 1.0, day, day) for day in (1, 2)]
    Path("cut.csv").write_text("t,a\n0,1\n0.1\n", encoding="utf-8")
    assert main(["diagnose", good[0], "cut.csv", good[1], "--machine", "machine.toml"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^- +cut\.csv +refused ", out, re.MULTILINE)
    assert "\nRefused: cut.csv: " in out
    found = trend(capsys, good[0], "cut.csv", good[1])
    assert [one["recording"] for one in found["recordings"]] == good
    assert list(found["refused"]) == ["cut.csv"]
    assert main(["diagnose", "cut.csv", "cut.csv", "--machine", "machine.toml"]) == 2


@pytest.mark.parametrize(("uncertainty", "averaged"), [("0.3", False), ("0.01", True)])
def test_the_page_has_an_average_only_of_a_shaft_whose_angle_is_known(folder, capsys, uncertainty, averaged):
    """0.3 % of the 174 turns are 0.5 turns, and averages need 0.25."""
    text = MACHINE.replace("uncertainty_percent = 0.3", f"uncertainty_percent = {uncertainty}")
    Path("machine.toml").write_text(text, encoding="utf-8")
    assert main(["diagnose", record("1.npz", 1.0, 1), "--machine", "machine.toml", "--out", "seen"]) == 0
    page = Path("seen/report.html").read_text(encoding="utf-8")
    assert ("Time-synchronous averages over a revolution" in page) == averaged
