"""What the first steps tell a reader to type works: commands and Python block, in one folder, in order; the README."""

import re
import shlex

import pytest
from sources import ROOT

from pipelines.cli.command_line import COMMANDS
from pipelines.cli.main import main

README = (ROOT / "README.md").read_text(encoding="utf-8")
STEPS = (ROOT / "docs" / "first-steps.md").read_text(encoding="utf-8")
TASKS = (ROOT / "docs" / "how-to.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", STEPS, flags=re.MULTILINE | re.DOTALL)


def gearcase_lines():
    """All lines of shell blocks that start with gearcase; a backslash goes on."""
    lines = [
        line for kind, text in BLOCKS if kind in ("sh", "console") for line in text.replace("\\\n", " ").splitlines()
    ]
    return [line.removeprefix("$ ") for line in lines if line.removeprefix("$ ").startswith("gearcase ")]


def test_the_first_steps_show_commands_and_python():
    assert len(gearcase_lines()) >= 4
    assert any(kind == "python" for kind, _ in BLOCKS)


def test_the_blocks_of_the_first_steps_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in gearcase_lines():
        code = main(shlex.split(line)[1:])
        assert code == 0, f"{line}\n{capsys.readouterr().err}"
    assert "report.html" in capsys.readouterr().out
    for kind, text in BLOCKS:
        if kind == "python":
            exec(compile(text, "first-steps.md", "exec"), {"__name__": "steps"})
    assert capsys.readouterr().out


@pytest.mark.parametrize("line", re.findall(r"`(gearcase [a-z][^`]*)`", TASKS))
def test_commands_named_in_the_text_exist(line):
    assert line.split()[1] in COMMANDS


def test_the_readme_is_short_and_its_links_lead_somewhere():
    """Five lines, one picture, two commands, what to read next: the site says the rest better."""
    assert len(README.splitlines()) < 40
    assert README.count("![") == 1
    assert len(re.findall(r"^    make ", README, re.M)) == 2
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert len(links) > 8
    assert not [link for link in links if not (ROOT / link).exists()]
