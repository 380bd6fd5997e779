"""The example of docs/recordings.md works, and its tables name every key, every format and every unit."""

import re
from pathlib import Path

import numpy as np
from measured import RATE, signals

from pipelines.recordings.formats import BY_ENDING
from pipelines.recordings.machine_table import BearingTable, MachineTable, TachometerTable
from pipelines.recordings.units import ACCELERATIONS, VOLTAGES

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "recordings.md").read_text(encoding="utf-8")


def block(kind):
    (text,) = re.findall(rf"^```{kind}\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)
    return text


def test_the_five_lines_of_the_page_read_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert len(block("toml").splitlines()) == 5
    Path("bench.toml").write_text(block("toml").replace("25600", f"{RATE:.0f}"), encoding="utf-8")
    rows = "".join(f"{i / RATE:.4f},{a:.9g},{b:.9g}\n" for i, (a, b) in enumerate(signals()))
    Path("record.csv").write_text(f"time [s],drive end,free end\n{rows}", encoding="utf-8")
    exec(compile(block("python"), "recordings.md", "exec"), {"__name__": "page"})
    orders, level = capsys.readouterr().out.rsplit(" ", 1)
    assert orders.startswith("{1: 21.0, 2: 7.79")
    np.testing.assert_allclose(float(level), 9.80665 * signals()[:, 0].std(), rtol=1e-6)


def test_every_key_of_a_machine_has_its_row():
    for key in MachineTable.model_fields:
        assert f"| `{key}` |" in PAGE
    for key in (*BearingTable.model_fields, *TachometerTable.model_fields):
        assert f"{key} = " in PAGE


def test_every_ending_and_unit_is_named():
    assert all(f"`{ending}`" in PAGE for ending in BY_ENDING)
    assert all(unit in PAGE for unit in (*ACCELERATIONS, *VOLTAGES))
