"""Result folders: one run alone fills one, it is whole or absent, and no run loses what it finished."""

import os
import signal
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from pipelines.io.errors import InputError, WorkError
from pipelines.runs import claims, run_folder
from pipelines.runs.claims import claimed

STAMP = "2026-01-31_12-00-00"


@pytest.fixture
def one_second(monkeypatch):
    """The clock stands still: all runs begin in the same second."""
    monkeypatch.setattr(claims.time, "strftime", lambda _: STAMP)


def fill(claim, text="x"):
    (claim.folder / run_folder.RESPONSE).write_text(text, encoding="utf-8")
    (claim.folder / run_folder.RUN).write_text(text, encoding="utf-8")


def visible(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_folder_appears_when_everything_is_there(tmp_path, one_second):
    with claimed("rig", root=tmp_path) as claim:
        fill(claim)
        assert not claim.final.exists()
    assert visible(tmp_path / "rig") == [STAMP]
    assert visible(claim.final) == [run_folder.RESPONSE, run_folder.RUN]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
@pytest.mark.parametrize("out", [None, "new", "there"])
def test_a_failed_run_leaves_nothing(tmp_path, error, out):
    (tmp_path / "there").mkdir()

    def run():
        with claimed("rig", out and tmp_path / out, root=tmp_path) as claim:
            fill(claim)
            raise error

    with pytest.raises(error):
        run()
    assert [path for path in tmp_path.rglob("*") if path.name not in ("rig", "there")] == []


def test_runs_that_begin_in_one_second_all_keep_their_results(tmp_path, one_second):
    with claimed("rig", root=tmp_path) as first, claimed("rig", root=tmp_path) as second:
        fill(first, "first")
        fill(second, "second")
    found = {(path / run_folder.RUN).read_text(encoding="utf-8") for path in (tmp_path / "rig").iterdir()}
    assert found == {"first", "second"}


def test_twenty_four_starts_in_one_second_leave_twenty_four_results(tmp_path, one_second):
    together = threading.Barrier(24)

    def run(number):
        together.wait()
        with claimed("rig", root=tmp_path) as claim:
            fill(claim, str(number))
        run_folder.note_latest(claim.final)
        return claim.final

    with ThreadPoolExecutor(24) as pool:
        folders = list(pool.map(run, range(24)))
    for number, folder in enumerate(folders):
        assert (folder / run_folder.RUN).read_text(encoding="utf-8") == str(number)
    names = {STAMP, *(f"{STAMP}_{number}" for number in range(2, 25)), run_folder.LATEST}
    assert set(visible(tmp_path / "rig")) == names
    assert run_folder.find_run("rig", root=tmp_path) in folders


CHILD = """
import sys
sys.path[:0] = {path!r}
from pathlib import Path
from pipelines.runs import claims, run_folder
claims.time.strftime = lambda _: {stamp!r}
with claims.claimed("rig", root=Path({root!r})) as claim:
    (claim.folder / run_folder.RESPONSE).write_text(sys.argv[1], encoding="utf-8")
    print("at work", flush=True)
    sys.stdin.readline()
run_folder.note_latest(claim.final)
"""


def start(root, number=0):
    code = CHILD.format(path=sys.path, stamp=STAMP, root=str(root))
    command = [sys.executable, "-c", code, str(number)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def test_processes_that_begin_in_one_second_all_keep_their_results(tmp_path):
    processes = [start(tmp_path, number) for number in range(6)]
    for process in processes:
        assert process.stdout.readline() == "at work\n"
    assert not list((tmp_path / "rig").glob("[!.]*")), "half a result can be seen"
    for process in processes:
        process.communicate("go on\n")
        assert process.returncode == 0
    found = [path.read_text(encoding="utf-8") for path in (tmp_path / "rig").glob(f"*/{run_folder.RESPONSE}")]
    assert sorted(found) == [str(number) for number in range(6)]
    assert len(visible(tmp_path / "rig")) == 6 + 1


def test_what_a_killed_run_left_is_swept_but_not_what_a_living_one_writes(tmp_path, one_second):
    dead, living = start(tmp_path), start(tmp_path)
    for process in (dead, living):
        assert process.stdout.readline() == "at work\n"
    dead.send_signal(signal.SIGKILL if os.name == "posix" else signal.SIGTERM)
    dead.communicate()
    assert len(visible(tmp_path / "rig")) == 4
    with claimed("rig", root=tmp_path):
        names = visible(tmp_path / "rig")
    assert len(names) == 4, "the marker and the files of the living run, and our own"
    living.communicate("go on\n")
    assert living.returncode == 0
    assert len([name for name in visible(tmp_path / "rig") if name.startswith(STAMP)]) == 2
    assert not list((tmp_path / "rig").glob(".*"))


@pytest.mark.parametrize("host", [b"another host", b""], ids=["another host", "just being made"])
def test_what_another_host_may_be_writing_is_not_swept(tmp_path, host):
    (tmp_path / "rig" / f".partial-{STAMP}").mkdir(parents=True)
    (tmp_path / "rig" / f".unfinished-{STAMP}").write_bytes(host)
    with claimed("rig", root=tmp_path):
        pass
    assert visible(tmp_path / "rig")[:2] == [f".partial-{STAMP}", f".unfinished-{STAMP}"]


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="takes the rights of another user")
def test_what_another_user_left_is_not_swept():
    """Even in a folder where everybody may remove everything."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o777)
        partial, marker = folder / f".partial-{STAMP}", folder / f".unfinished-{STAMP}"
        partial.mkdir()
        marker.write_bytes(claims._host())
        os.seteuid(65534)
        try:
            claims._sweep(folder)
        finally:
            os.seteuid(0)
        assert partial.exists()
        assert marker.exists()
        claims._sweep(folder)
        assert list(folder.iterdir()) == []


def test_one_folder_is_given_to_one_run_alone(tmp_path):
    for out in (tmp_path / "new", tmp_path / "there"):
        if out.name == "there":
            out.mkdir()
        with claimed("rig", out) as claim:
            fill(claim)
            with pytest.raises(InputError, match="another run is writing there"), claimed("rig", out):
                pass
        assert visible(out) == [run_folder.RESPONSE, run_folder.RUN]
        with pytest.raises(InputError, match="nothing is overwritten"), claimed("rig", out):
            pass


def test_a_folder_that_is_there_is_filled_and_not_replaced(tmp_path, monkeypatch):
    """It may be a mounted volume, a link, or the folder in which the command was started."""
    (tmp_path / "volume").mkdir()
    before = os.stat(tmp_path / "volume").st_ino
    monkeypatch.chdir(tmp_path / "volume")
    with claimed("rig", ".") as claim:
        fill(claim)
    assert visible(tmp_path / "volume") == [run_folder.RESPONSE, run_folder.RUN]
    assert os.stat(tmp_path / "volume").st_ino == before


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_a_link_to_an_empty_folder_is_followed(tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "far")
    with claimed("rig", tmp_path / "link") as claim:
        fill(claim)
    assert visible(tmp_path / "far") == [run_folder.RESPONSE, run_folder.RUN]


def test_a_folder_that_someone_else_makes_meanwhile_costs_nothing(tmp_path, caplog):
    with claimed("rig", tmp_path / "mine") as claim:
        fill(claim)
        (tmp_path / "mine").mkdir()
        (tmp_path / "mine" / "letter").write_text("x", encoding="utf-8")
    assert claim.final == tmp_path / "mine_2"
    assert visible(tmp_path / "mine_2") == [run_folder.RESPONSE, run_folder.RUN]
    assert visible(tmp_path / "mine") == ["letter"]
    assert "the results are in" in caplog.text


def test_results_that_cannot_be_moved_are_kept_and_named(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(28, "No space left on device")

    def run():
        with claimed("rig", tmp_path / "mine") as claim:
            fill(claim)
            monkeypatch.setattr(claims.os, "rename", refuse)

    with pytest.raises(WorkError, match=r"They are in .*partial-mine"):
        run()
    monkeypatch.undo()
    assert visible(tmp_path / ".partial-mine") == [run_folder.RESPONSE, run_folder.RUN]
    with pytest.raises(InputError, match="could not be moved there"), claimed("rig", tmp_path / "mine"):
        pass
    assert visible(tmp_path) == [".partial-mine"]
