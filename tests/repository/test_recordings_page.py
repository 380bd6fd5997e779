"""The example of docs/recordings.md works, and its tables name every key, every format and every unit."""

import re
from pathlib import Path

import numpy as np
import pytest
from measured import RATE
from sources import ROOT

from pipelines.cli.main import main
from pipelines.recordings.formats import BY_ENDING
from pipelines.recordings.machine_table import BearingTable, MachineTable, TachometerTable
from pipelines.recordings.units import ACCELERATIONS, VOLTAGES

PAGE = (ROOT / "docs" / "recordings.md").read_text(encoding="utf-8")


def block(kind):
    (text,) = re.findall(rf"^```{kind}\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)
    return text


def write_record(name, depth, seed):
    """Three seconds of the gearbox of the page, whose first shaft modulates its mesh more; speed is not recorded.

    All shafts modulate their meshes by ten orders, as pitch deviations do.
    """
    random = np.random.default_rng(seed)
    time = np.arange(round(3.0 * RATE)) / RATE
    turn = 2 * np.pi * 1480 / 60 * time
    ratios = (1.0, 21 / 62, 21 / 62 * 23 / 75)
    pitch = [
        sum(0.03 * np.cos(k * ratio * turn + random.uniform(0, 2 * np.pi)) for k in range(1, 11)) for ratio in ratios
    ]
    first = (1 + depth * np.cos(turn) + pitch[0] + pitch[1]) * (np.cos(21 * turn) + 0.5 * np.cos(42 * turn))
    second = (1 + pitch[1] + pitch[2]) * sum(0.3 / h * np.cos(h * 23 * ratios[1] * turn) for h in (1, 2, 3))
    ends = first + second + 0.1 * random.normal(size=(2, time.size))
    np.savetxt(
        name,
        np.stack([time, *ends], axis=1),
        fmt="%.7g",
        delimiter=",",
        header="time [s],drive end,free end",
        comments="",
    )
    return ends[0]


@pytest.mark.slow
def test_the_five_lines_of_the_page_are_enough_for_a_verdict(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert len(block("toml").splitlines()) == 5
    Path("bench.toml").write_text(block("toml").replace("25600", f"{RATE:.0f}"), encoding="utf-8")
    recorded = write_record("record.csv", 0.4, seed=10)
    for number in range(1, 7):
        write_record(f"healthy-{number}.csv", 0.02, seed=number)
    exec(compile(block("python"), "recordings.md", "exec"), {"__name__": "page"})
    level, verdict, *_ = capsys.readouterr().out.splitlines()
    np.testing.assert_allclose(float(level.split()[0]), 9.80665 * recorded.std(), rtol=1e-3)
    assert verdict.startswith("True stage 1 pinion +")


def test_a_diagnosed_file_has_a_page_with_its_figures_and_its_orders_have_pictures(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("bench.toml").write_text(block("toml").replace("25600", f"{RATE:.0f}"), encoding="utf-8")
    write_record("record.csv", 0.4, seed=10)
    write_record("healthy.csv", 0.02, seed=1)
    assert (
        main(["diagnose", "record.csv", "--machine", "bench.toml", "--baseline", "healthy.csv", "--out", "seen"]) == 0
    )
    words = capsys.readouterr().out
    shown = Path("seen/report.html").read_text(encoding="utf-8")
    assert words.splitlines()[-1] == f"report: {Path('seen') / 'report.html'}"
    assert "Diagnosis of record.csv" in shown
    assert "Strongest evidence: stage 1 pinion" in shown
    assert shown.count("<figure") == 7  # spectra, sidebands of two stages, envelopes, cepstra, averages, rms
    assert main(["orders", "record.csv", "--machine", "bench.toml", "--out", "seen"]) == 0
    words = capsys.readouterr().out
    assert re.search(r"\nshaft_1: [\d.]+ to [\d.]+ rpm \(known to [\w<. -]+ %\)\. Source: phase of ", words)
    rows = [line.split() for line in words.splitlines()]
    windows = int(rows[0][-2])
    found = {float(row[0]): float(row[1]) for row in rows if len(row) == 4 and row[0] in ("21", "42")}
    assert found == pytest.approx({21.0: 9.80665, 42.0: 0.5 * 9.80665}, rel=0.05)  # amplitudes in g
    assert main(["orders", "record.csv@0.2:1.2", "--machine", "bench.toml", "--out", "seen"]) == 0
    first, *rows = capsys.readouterr().out.splitlines()
    assert int(first.split()[-2]) < windows
    amplitudes = {float(row.split()[0]): float(row.split()[1]) for row in rows if row.split()[:1] in (["21"], ["42"])}
    assert amplitudes == pytest.approx(found, rel=0.05)
    assert main(["orders", "record.csv@soon", "--machine", "bench.toml", "--out", "seen"]) == 2
    assert "soon is not a window. Give start and end in seconds" in capsys.readouterr().err
    assert main(["orders", "record.csv", "--machine", "bench.toml", "--campbell"]) == 2


def test_every_key_of_a_machine_has_its_row():
    for key in MachineTable.model_fields:
        assert f"| `{key}` |" in PAGE
    for key in (*BearingTable.model_fields, *TachometerTable.model_fields):
        assert f"{key} = " in PAGE


def test_every_ending_and_unit_is_named():
    assert all(f"`{ending}`" in PAGE for ending in BY_ENDING)
    assert all(unit in PAGE for unit in (*ACCELERATIONS, *VOLTAGES))
