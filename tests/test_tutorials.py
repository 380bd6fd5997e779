"""The tutorials work as they are printed, and every command line of the pages is one that the command takes."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest

from pipelines.cli import main
from pipelines.command_line import parser
from pipelines.scene.file import load_scene

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted((ROOT / "docs").rglob("*.md"))
PAGES = [page for page in PAGES if "reference" not in page.parts and "gallery" not in page.parts]
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
BLOCK = re.compile(r"(?:File `(?P<file>[\w.-]+)`[^`]*)?^```(?P<kind>\w+)\n(?P<text>.*?)^```", re.M | re.S)


def blocks(page):
    """File, kind and text of every block of code."""
    return [(one["file"], one["kind"], one["text"]) for one in BLOCK.finditer(page.read_text(encoding="utf-8"))]


def command_lines(page):
    """Lines of shell blocks that call the command; a backslash goes on."""
    lines = [
        line.strip()
        for _, kind, text in blocks(page)
        if kind == "sh"
        for line in text.replace("\\\n", " ").splitlines()
    ]
    return [line for line in lines if line.startswith("gearcase ")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_line_of_a_page_is_one_that_the_command_takes(page):
    for line in command_lines(page):
        parser().parse_args(shlex.split(line.partition(" > ")[0], comments=True)[1:])


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_the_files_of_a_tutorial_are_valid(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, kind, text in blocks(page):
        if kind == "toml":
            assert name, "a block of TOML is introduced by File `name`"
            (tmp_path / name).write_text(text, encoding="utf-8")
            if "variables" in tomllib.loads(text):
                assert main(["campaign", name, "--dry-run"]) == 0
            else:
                load_scene(name)


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_works_as_it_is_printed(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "tutorial"}
    for name, kind, text in blocks(page):
        if kind == "toml":
            (tmp_path / name).write_text(text, encoding="utf-8")
        elif kind == "python":
            exec(compile(text, page.name, "exec"), names)
        elif kind == "sh":
            for line in text.splitlines():
                assert main(shlex.split(line)[1:]) == 0, f"{line}\n{capsys.readouterr().err}"
