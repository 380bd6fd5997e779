"""Input of any kind: exit code 2, in seconds; at most 20 lines, at most 200 characters of any value."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from report_pages import body_of
from sources import ROOT

from pipelines.cli.main import main
from pipelines.io.errors import Problem, SceneError
from pipelines.io.shown_text import message_text, shown, shown_value
from pipelines.scene.load_scene import load_scene
from pipelines.scene.new import new_scene

posix = pytest.mark.skipif(os.name != "posix", reason="pipes and devices of a POSIX system")
LIMIT_S = 10.0  # of this process: a machine that is busy with others takes longer


def refused(capsys, *arguments):
    """What a command says that must be refused."""
    start = time.process_time()
    try:
        code = main(list(arguments))
    except SystemExit as end:
        code = end.code
    seconds = time.process_time() - start
    out, err = capsys.readouterr()
    assert code == 2, err
    assert out == ""
    assert "error of the program" not in err
    assert "Traceback" not in err
    assert len(err.splitlines()) <= 20
    assert not [run[0] for run in re.finditer(r"(.)\1{200,}", err)], "more than 200 characters of a value"
    assert all(c == "\n" or c.isprintable() for c in err), "a terminal would obey this"
    assert seconds < LIMIT_S
    return err


def scene(folder, text, name="my.toml"):
    content = text if isinstance(text, bytes) else text.encode()
    (folder / name).write_bytes(content)
    return name


MINIMAL = 'extends = "minimal"\n'
HOUSING = """[casing]
model = "rigid"
[casing.housing]
model = "step"
file = "%s"
unit = "mm"
bearings = [
  { name = "bearing_1", group = "a" }, { name = "bearing_2", group = "b" },
  { name = "bearing_3", group = "c" }, { name = "bearing_4", group = "d" },
]
grounds = [{ group = "e" }]
"""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"title = {'9' * 5000}\n", "too many digits"),
        (f"title = 0x{'f' * 5000}\n", "64 bits"),
        (f"a = {'[' * 400}{']' * 400}\n", "is nested"),
        (f"a = {'{a=' * 400}1{'}' * 400}\n", "nested"),
        (f"a = {'[' * 4000}{']' * 4000}\n", "nested too deep"),
        (f"a = {'[' * 40}{']' * 40}\n", "nested deeper than 32"),
        (f"a = {'{a=' * 40}1{'}' * 40}\n", "nested deeper than 32"),
        (f"{'a.' * 400}a = 1\n", "more than 32 parts"),
        (f"x = 1\n[{'a.' * 400}a]\n", r"more than 32 parts (line 3)"),
        (f"{'a.' * 40_000}a = 1\n", "more than 32 parts"),  # by the parser alone: minutes
        (" . ".join(['"\\"a"'] * 20_000) + " = 1\n", "more than 32 parts"),
        ('title = "\\u001b[31m"\n', r"\u001b[31m"),
        ('title = "\\u202egnp"\n', r"\u202egnp"),
        ('title = "two\\nlines"\n', "must be one line"),
        ('"\\u001b[2J" = 1\n', r"\x1b[2J"),
        (f'title = "{"x" * 300}"\n', "too long"),
        (f'title = "{"ß" * 300_000}"\n', "more than 1000"),
        (f"{'k' * 5000} = 1\n", "at most 100 characters"),
        (f"[diagnosis]\nsensor = '{'x' * 900}'\n", "there is no such sensor"),
        (f"control = '{'x' * 900}'\n", "there is no shipped scene of this name"),
        (f"[drive]\ntimes_s = [{'true, ' * 50_000}]\n", "and 4"),
        (f"sensors = [{'{}, ' * 50_000}]\n", "sensors"),
        (HOUSING % "a\\u0000b", "control character"),
        (HOUSING % ("x" * 900), "cannot be read"),
        (HOUSING % "", "must not be empty"),
        (HOUSING % ".", "is a folder"),
    ],
    ids=lambda value: repr(value[:24]),
)
def test_what_a_scene_file_may_hold(capsys, here, text, words):
    base = MINIMAL if not text.startswith(" ") else ""
    assert words in refused(capsys, "check", scene(here, base + text))


def test_the_file_of_a_control_that_is_not_there_is_named(capsys, here):
    name = scene(here, MINIMAL + 'control = "nosuch"\n')
    assert f'{name}: control = "nosuch": there is no shipped scene' in refused(capsys, "check", name)


def test_thousands_of_unknown_keys_are_answered_within_2_s(capsys, here):
    name = scene(here, MINIMAL + "".join(f"container_{i}_kg = {i}\n" for i in range(20_000)))
    refused(capsys, "check", name)  # loads the modules
    start = time.process_time()
    err = refused(capsys, "check", name)
    assert time.process_time() - start < 2.0
    assert "20000 problems" in err
    assert re.search(r"and 199\d\d more$", err)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        (".".join(["a"] * 5000) + "=1", "nested deeper"),
        ("drive={" + ", ".join(f"k{i}=1" for i in range(5000)) + "}", " more"),
        (f"load.container_kg={'9' * 5000}", "too many digits"),
        (f"load.container_kg={'[' * 400}{']' * 400}", "nested deeper"),
        (f"stages.{'9' * 5000}.module_mm=1", "at most 100 characters"),
        ("x" * 5000, "has no value"),
        ("\x1b[2J=1", r"\x1b[2J"),
        ("title=\x1b[31mred", r"\u001b[31mred"),
        ("title=\udce9", "control characters"),
        ("drive.times_s=[" + "0, " * 50_000 + "]", "times_s has 50000 values"),
    ],
    ids=lambda value: repr(value[:24]),
)
def test_what_a_setting_may_hold(capsys, here, setting, words):
    assert words in refused(capsys, "check", "minimal", "--set", setting)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a\0b.toml", r"a\x00b.toml"),
        ("", "must not be empty"),
        ("x" * 300 + ".toml", "cannot be read"),
        ("/".join(["x" * 200] * 40) + ".toml", "cannot be read"),
        ("x" * 3000, "there is no shipped scene of this name"),
        ("\x1b[31m.toml", r"\x1b[31m.toml"),
        ("\udce9.toml", "must be UTF-8"),
        ("my.toml/other.toml", "cannot be read"),
        ("folder.toml", "is a folder"),
        ("minimal\u202e", r"minimal\u202e"),
    ],
)
def test_names_that_no_scene_can_have(capsys, here, name, words):
    scene(here, MINIMAL)
    (here / "folder.toml").mkdir()
    assert words in refused(capsys, "check", name)


@posix
def test_pipes_sockets_devices_and_loops_are_no_files(capsys, here):
    os.mkfifo("pipe.toml")
    os.mkfifo("pipe.step")
    Path("loop.toml").symlink_to("loop.toml")
    Path("zero.toml").symlink_to("/dev/zero")
    Path("zero.step").symlink_to("/dev/zero")
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind("socket.toml")
        assert "is a socket" in refused(capsys, "check", "socket.toml")
    assert "is a pipe" in refused(capsys, "check", "pipe.toml")
    assert "is a device" in refused(capsys, "check", "zero.toml")
    assert "symbolic links" in refused(capsys, "check", "loop.toml")
    assert "is a pipe" in refused(capsys, "check", scene(here, MINIMAL + HOUSING % "pipe.step"))
    assert "is a device" in refused(capsys, "check", scene(here, MINIMAL + HOUSING % "zero.step"))
    assert "is a device" in refused(capsys, "check", scene(here, 'extends = "zero.toml"\n'))
    assert "is a pipe" in refused(capsys, "check", scene(here, MINIMAL + 'control = "pipe.toml"\n'))
    Path("response.nc").symlink_to("/dev/zero")
    assert "no result here" in refused(capsys, "export", ".", "--to", "csv")
    Path("latest.txt").write_text("x" * 5000, encoding="utf-8")
    assert "at most" in refused(capsys, "diagnose", ".")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("title = 'é'\n".encode("utf-16"), "not UTF-8 text (line 1)"),
        ("title = 'e'\n".encode("utf-16-le"), "not valid TOML"),
        (b"\0" * 5000, "not valid TOML"),
        (b"title = 'x'\rcontrol = 'y'\r", "not valid TOML"),
        (b"", "is missing"),
        (b"\x7fELF" + bytes(range(256)), "not UTF-8"),
    ],
)
def test_files_of_other_programs(capsys, here, content, words):
    assert words in refused(capsys, "check", scene(here, content))


def test_a_file_beyond_the_limit_is_not_read(capsys, here):
    with open("huge.toml", "wb") as file:
        file.truncate(20_000_000_000)
    assert "20000.0 MB, at most 1 MB" in refused(capsys, "check", "huge.toml")


def test_a_chain_of_a_thousand_scenes(capsys, here):
    for number in range(1000):
        scene(here, f'extends = "s{number + 1}.toml"\n', f"s{number}.toml")
    scene(here, MINIMAL, "s1000.toml")
    assert "more than 20 scenes extend one another" in refused(capsys, "check", "s0.toml")
    scene(here, 'extends = "s0.toml"\n', "s9.toml")
    assert "forms a circle (s0.toml -> s1.toml" in refused(capsys, "check", "s0.toml")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["converge", "minimal", "--over", "x" * 5000], "choose from"),
        (["check", "minimal", "\x1b[31m" * 500], r"\x1b[31m"),
        (["run", "minimal", "--processes", "9" * 5000], "whole number from 1"),
        (["run", "minimal", "--seeds", "1000000000"], "whole number from 1 to 1000"),
        (["modes", "minimal", "--up-to", "x" * 5000], "finite number"),
        (["new", ""], "must not be empty"),
        (["new", "."], "must end in .toml"),
        (["new", "x" * 300 + ".toml"], "cannot be written"),
        (["new", "a\nb.toml"], "control characters"),
        (["run", "minimal", "--out", "a\0b"], "control characters"),
        (["run", "minimal", "--out", "x" * 300], "cannot be written"),
        (["run", "minimal", "--out", "file/below"], "is not a folder"),
        (["run", "minimal", "--out", "empty/.."], "not an empty folder"),
        (["simulate", "minimal", "--out", "."], "not an empty folder"),
        (["tradeoff", "minimal", "--out", "file/plot.png"], "is not a folder"),
        (["converge", "minimal", "--over", "step", "--out", "empty.png"], "is a folder"),
        (["inspect", "minimal", "--out", "file"], "is not a folder"),
        (["inspect", "minimal", "--mesh", "file/teeth.vtu"], "is not a folder"),
        (["casing", "minimal", "--export", "file/casing.h5"], "is not a folder"),
        (["export", "x" * 5000, "--to", "csv"], "no result here"),
        (["diagnose", "file"], "has no ending"),
    ],
    ids=lambda value: " ".join(value)[:40] if isinstance(value, list) else "",
)
def test_arguments(capsys, here, arguments, words):
    scene(here, "", "file")
    (here / "empty").mkdir()
    (here / "empty.png").mkdir()
    assert words in refused(capsys, *arguments)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read and write everything")
def test_no_right_to_read_or_write(capsys, here):
    scene(here, MINIMAL)
    (here / "my.toml").chmod(0)
    assert "Permission denied" in refused(capsys, "check", "my.toml")
    (here / "closed").mkdir(mode=0o500)
    assert "no write permission" in refused(capsys, "run", "minimal", "--out", "closed/mine")


@pytest.mark.parametrize("content", [b"", b"no netCDF", b"\x89HDF\r\n\x1a\n" + b"\0" * 100])
def test_a_damaged_result_is_bad_input(capsys, here, content):
    (here / "mine").mkdir()
    (here / "mine" / "response.nc").write_bytes(content)
    assert "cannot be read as signals" in refused(capsys, "export", "mine", "--to", "csv")


def test_a_result_without_signals_is_bad_input(capsys, here):
    import xarray

    (here / "mine").mkdir()
    xarray.Dataset({"a": ("b", [1.0])}).to_netcdf(here / "mine" / "response.nc", engine="h5netcdf")
    assert "no signals over time" in refused(capsys, "export", "mine", "--to", "csv")


def in_a_shell(line, folder, **environment):
    """Exit code and standard error of a shell line in which $gearcase is the command."""
    gearcase = f"{sys.executable} -m pipelines.cli.main"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    command = ["sh", "-c", line.replace("$gearcase", gearcase)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, timeout=120, check=False)
    return done.returncode, done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")


@posix
def test_closed_streams(here):
    code, _, err = in_a_shell("$gearcase cache info >&-", here)
    assert (code, err) == (
        2,
        "gearcase: standard output is closed. Redirect it to a file or to /dev/null.\n",
    )
    code, out, _ = in_a_shell("$gearcase cache info 2>&- <&-", here)
    assert code == 0
    assert "stored" in out
    code, _, err = in_a_shell("$gearcase cache info | head -0", here)
    assert err == ""
    code, _, err = in_a_shell("$gearcase cache info >/dev/full", here)
    assert code == 1
    assert err.startswith("gearcase: ")
    assert len(err.splitlines()) == 1


@posix
def test_a_removed_working_folder(here):
    (here / "gone").mkdir()
    code, _, err = in_a_shell("cd gone && rmdir ../gone && $gearcase run minimal", here)
    assert code == 2
    assert err.startswith("gearcase: the working folder does not exist any more")
    assert len(err.splitlines()) == 1


@posix
def test_a_poor_environment(here):
    (here / "file").write_text("", encoding="utf-8")
    scene(here, MINIMAL + 'title = "Kran Größe 起重机"\n')
    poor = {
        "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "COLUMNS": "0", "LINES": "0", "TERM": "dumb",
        "TMPDIR": str(here / "nowhere"), "GEARCASE_CACHE": str(here / "file"),
    }  # fmt: skip
    code, out, err = in_a_shell("$gearcase check my.toml && $gearcase explain my.toml", here, **poor)
    assert code == 0, err
    assert out.startswith("Kran Gr")


def test_messages_are_bounded_and_printable():
    assert shown("a\x1b[31m\u202e\n") == r"a\x1b[31m\u202e\n"
    assert len(shown("\x1b" * 10_000)) == 200
    assert len(shown_value(["x" * 10**6] * 10**6)) == 200
    assert len(shown_value({"x" * 10**6: 10**5000})) == 200
    assert len(message_text("line\n" * 1000).splitlines()) == 20
    many = SceneError("s", [Problem(f"a.{n}", "wrong") for n in range(30)], unlisted=70)
    assert str(many).splitlines()[0] == "s: 100 problems"
    assert str(many).splitlines()[-1] == "  and 82 more"
    assert len(str(many).splitlines()) == 20


def test_a_scene_with_a_long_list_is_copied_at_once(tmp_path):
    numbers = "".join(f"  {n}.5,  # [{n}\n" for n in range(20_000))
    table = f'extends = "minimal"\n[drive]\ntimes_s = [\n 0.0,\n{numbers}]\nspeeds_rpm = [{"0.0, " * 20_001}]\n'
    (tmp_path / "long.toml").write_text(table, encoding="utf-8")
    start = time.process_time()
    path = new_scene(tmp_path / "copy.toml", str(tmp_path / "long.toml"))
    assert time.process_time() - start < LIMIT_S
    assert len(load_scene(path).scene.drive.times_s) == 20_001


def test_markup_in_a_title_stays_text(tmp_path):
    from pipelines.report.figures.frame_files import film_page
    from pipelines.report.figures.labelled_pictures import plain
    from pipelines.report.figures.plots import dress, new_figure
    from pipelines.report.first_screen import screen_parts
    from pipelines.report.report import write_report

    title = "<script>alert(1)</script> [bold]$\\frac$ & $x"
    first = screen_parts(sentences=[title], figures=[(title, title)])
    page = write_report(
        tmp_path / "report.html",
        title,
        body_of(title=title, first=first, summary={title: title}),
        {},
    )
    for text in (page.read_text(encoding="utf-8"), film_page(title, [], title, [], 40)):
        assert "<script>alert" not in text
        assert "&lt;script&gt;alert" in text
    figure = new_figure(2.0)
    dress(figure.subplots(), plain(title), "", "")
    figure.suptitle(plain(title))
    figure.savefig(tmp_path / "figure.png")  # without `plain` a formula that cannot be read
