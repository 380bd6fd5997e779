"""docs/extending.md: every example, put into a copy of the product as the page says, does what it says."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from sources import ROOT

PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
PACKAGES = ("fem", "mbd", "pipelines", "gearcase", "meshes")
EXAMPLES = dict(part.split("\n", 1) for part in PAGE.split("\n## ")[1:])


def blocks(example):
    """(kind, path, text) of every block: "new" files, "diff" of a file, "check" to be run."""
    kind, path = "", ""
    for words, language, text in re.findall(r"(.*?)^```(\w+)\n(.*?)^```\n?", EXAMPLES[example], re.M | re.S):
        if found := re.search(r"^(New file|In) `([\w/.]+)`", words, re.M):
            kind, path = ("new" if found[1] == "New file" else "diff"), found[2]
        elif "Check:" in words:
            kind, path = "check", ""
        assert language == ("diff" if kind == "diff" else "python")
        yield kind, path, text


def patched(text, diff):
    """The text with the lines of a diff put in; what the diff leaves or takes away must stand there once."""
    lines = diff.splitlines(keepends=True)
    before = "".join(line[1:] for line in lines if line[0] in " -")
    after = "".join(line[1:] for line in lines if line[0] in " +")
    assert text.count(before) == 1, f"not there, or more than once:\n{before}"
    return text.replace(before, after)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The product with all examples in it."""
    folder = tmp_path_factory.mktemp("product")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for example in EXAMPLES:
        for kind, path, text in blocks(example):
            file = folder / path
            if kind == "new":
                assert not file.exists()
                file.write_text(text, encoding="utf-8")
            elif kind == "diff":
                file.write_text(patched(file.read_text(encoding="utf-8"), text), encoding="utf-8")
    return folder


KINDS = (
    "A mesh model",
    "A tooth fault",
    "A bearing",
    "A load",
    "An excitation",
    "A casing model",
    "An element type",
    "A command",
    "A channel",
    "A recording format",
)


def test_the_page_has_all_examples():
    assert tuple(EXAMPLES) == KINDS


@pytest.mark.parametrize("example", KINDS)
def test_an_extension_is_one_file_and_one_line_of_a_registry(example):
    found = [(kind, text) for kind, _, text in blocks(example)]
    ours = [] if example == "An element type" else ["new"]  # shape functions are those of a library
    assert [kind for kind, _ in found] == [*ours, "diff", "check"]
    assert [line[0] for line in found[-2][1].splitlines()].count("+") == 1


def run_check(copy, example):
    """The code after "Check" of an example, run in the product with the examples."""
    (code,) = [text for kind, _, text in blocks(example) if kind == "check"]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        [sys.executable, "-c", code], cwd=copy, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES)
def test_what_the_page_says_holds(copy, example):
    done = run_check(copy, example)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES)
def test_an_extension_without_its_line_is_refused_by_name(copy, example):
    path, diff = next((path, text) for kind, path, text in blocks(example) if kind == "diff")
    (line,) = re.findall(r"^\+(.*)$", diff, re.M)
    names = re.findall(r'"([\w .-]+)"', line)  # of a format also the endings
    file = copy / path
    whole = file.read_text(encoding="utf-8")
    back = re.sub(r"^[+-]", lambda sign: "-+"[sign[0] == "-"], diff, flags=re.M)
    file.write_text(patched(whole, back), encoding="utf-8")
    try:
        done = run_check(copy, example)
    finally:
        file.write_text(whole, encoding="utf-8")
    assert done.returncode != 0
    assert any(name in done.stderr for name in names), done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("example", [example for example in KINDS if example != "An element type"])
def test_an_extension_without_its_file_is_refused_by_name(copy, example):
    (path,) = [path for kind, path, _ in blocks(example) if kind == "new"]
    file = copy / path
    whole = file.read_text(encoding="utf-8")
    file.unlink()
    try:
        done = run_check(copy, example)
    finally:
        file.write_text(whole, encoding="utf-8")
    assert done.returncode != 0
    assert path.removesuffix(".py").replace("/", ".") in done.stderr, done.stderr


def test_the_examples_keep_the_rules_of_the_code(copy):
    config = ["--config", str(ROOT / "pyproject.toml"), "--no-cache"]
    for words in (["check", *config], ["format", "--check", *config]):
        done = subprocess.run(
            [sys.executable, "-m", "ruff", *words, str(copy)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
