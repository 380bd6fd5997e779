"""The tutorials work as they are printed, and every command line of the pages is one that the command takes.

`python tests/repository/test_tutorials.py` runs the tutorials and writes their output of
today into the blocks of their pages.
"""

import contextlib
import io
import re
import shlex
import tempfile
import tomllib
from pathlib import Path

import pytest

from pipelines.cli.command_line import parser
from pipelines.cli.main import main
from pipelines.scene.load_scene import load_scene

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted((ROOT / "docs").rglob("*.md"))
PAGES = [page for page in PAGES if "reference" not in page.parts and "gallery" not in page.parts]
TUTORIALS = [
    *(ROOT / "docs" / name for name in ("first-steps.md", "design.md")),
    *sorted((ROOT / "docs" / "tutorials").glob("*.md")),
]
BLOCK = re.compile(r"(?:File\s`(?P<file>[\w.-]+)`[^`]*)?^```(?P<kind>\w+)\n(?P<text>.*?)^```", re.M | re.S)


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


def worked(page):
    """Pairs of printed and actual output of a page, the actual one trimmed as the page is; in the working folder."""
    pairs, names, output = [], {"__name__": "tutorial"}, io.StringIO()
    for name, kind, text in blocks(page):
        if kind in ("text", "none"):  # none: sentences, which the page wraps
            if not text.startswith("gearcase "):
                pairs.append((text, trimmed(output.getvalue(), text)))
            continue
        with contextlib.redirect_stdout(output if kind == "toml" else (output := io.StringIO())):
            if kind == "toml":
                Path(name).write_text(text, encoding="utf-8")
            elif kind == "python":
                exec(compile(text, page.name, "exec"), names)
            elif kind == "sh":
                for line in text.splitlines():
                    assert main(shlex.split(line, comments=True)[1:]) == 0, line
    return pairs


def trimmed(output, text):
    """As many lines of an output as each part of a text has, from where it begins with the same two words, or one."""
    parts, rest = [], output.splitlines()
    for part in text.split("...\n"):
        lines = part.splitlines() or ["..."]  # a text may end in dots
        places = ([n for n, line in enumerate(rest) if line.split()[:k] == lines[0].split()[:k]] for k in (2, 1))
        start = next((found[0] for found in places if found), len(rest))
        parts.append("".join(f"{line.rstrip()}\n" for line in rest[start : start + len(lines)]))
        rest = rest[start + len(lines) :]
    return "...\n".join(parts)


def read(text):
    """Words and numbers of a text."""
    number = re.compile(r"[(\[]*([+-]?\d+(?:\.\d*)?(?:e[+-]?\d+)?)[%)\].,;:]*")
    return [float(found[1]) if (found := number.fullmatch(word)) else word for word in text.split()]


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_works_as_it_is_printed(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pairs = worked(page)
    assert pairs
    for printed, actual in pairs:
        close = [pytest.approx(one, rel=0.02) if isinstance(one, float) else one for one in read(printed)]
        assert read(actual) == close, "run: python tests/repository/test_tutorials.py"


def rewrite():
    """Put the output of today into the pages."""
    for page in TUTORIALS:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            text = page.read_text(encoding="utf-8")
            for printed, actual in worked(page):
                text = text.replace(f"\n{printed}```", f"\n{actual}```")
            page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    rewrite()
