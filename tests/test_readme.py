"""What the README tells a reader to type works: its gearcase lines and its Python block, in one folder, in order."""

import re
import shlex
from pathlib import Path

import pytest

from pipelines.cli import main
from pipelines.command_line import COMMANDS

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)


def gearcase_lines():
    """All lines of shell blocks that start with gearcase; a backslash goes on."""
    lines = [
        line for kind, text in BLOCKS if kind in ("sh", "console") for line in text.replace("\\\n", " ").splitlines()
    ]
    return [line.removeprefix("$ ") for line in lines if line.removeprefix("$ ").startswith("gearcase ")]


def test_the_readme_shows_commands_and_python():
    assert len(gearcase_lines()) >= 4
    assert any(kind == "python" for kind, _ in BLOCKS)


def test_the_blocks_of_the_readme_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in gearcase_lines():
        code = main(shlex.split(line)[1:])
        assert code == 0, f"{line}\n{capsys.readouterr().err}"
    assert "report.html" in capsys.readouterr().out
    for kind, text in BLOCKS:
        if kind == "python":
            exec(compile(text, "README.md", "exec"), {"__name__": "readme"})
    assert capsys.readouterr().out


@pytest.mark.parametrize("line", re.findall(r"`(gearcase [a-z][^`]*)`", README))
def test_commands_named_in_the_text_exist(line):
    assert line.split()[1] in {name for name, *_ in COMMANDS}


def test_the_claims_in_the_readme_are_those_of_the_verification_page():
    rows = [line for line in README.splitlines() if re.search(r"(holds|told|hold) \|$", line)]
    tables = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in (ROOT / "docs" / "verification.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("| ")
    ]
    assert len(rows) == 5
    for row in rows:
        name, least, without_losses, friction = (cell.strip() for cell in row.strip("|").split("|"))
        assert [name, least, without_losses, friction] in [
            [*table[:3], table[4]] for table in tables if len(table) == 6
        ]
