"""Child processes: nothing in the working folder or in that of the script is run; our packages are the parent's."""

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest
from sources import ROOT

from fem.processes import child
from fem.processes.executor import Processes, answer
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph, Step
from pipelines.io.errors import WorkError
from pipelines.report.figures import render

PLANTED = "import pathlib; pathlib.Path(__file__).with_name('planted').touch()\n"
NAMES = ("queue", "json", "runpy", "numpy", "psutil", "pyvista", "xarray", "sitecustomize", "pipelines", "benchmarks")


def look_around(_):
    import queue

    import numpy

    import pipelines

    return {"process": os.getpid(), "path": sys.path, "from": [m.__file__ for m in (queue, numpy, pipelines)]}


def end_by_signal(_):
    os.kill(os.getpid(), 9)


def two_stages(build=look_around):
    return Graph(Step(name=f"s{n}", kind="look", build=build, spec=n, seconds=9.0) for n in range(2))


@pytest.fixture
def planted(tmp_path, monkeypatch):
    """The working folder holds files named like modules of the library, of others and of ours."""
    folder = tmp_path / "work"
    folder.mkdir()
    for name in NAMES:
        (folder / f"{name}.py").write_text(PLANTED, encoding="utf-8")
    monkeypatch.chdir(folder)
    return folder


def harmless(folder):
    return not list(folder.rglob("planted"))


@pytest.mark.slow
@pytest.mark.parametrize("first", ["", "work", "absolute"])
def test_a_worker_runs_nothing_of_the_working_folder(planted, tmp_path, monkeypatch, first):
    here = look_around(None)
    monkeypatch.setenv("PYTHONPATH", str(planted))
    first = {"": "", "work": ".", "absolute": str(planted)}[first]
    monkeypatch.setattr(sys, "path", [first, *sys.path])
    found = run_graph(two_stages(), Cache(tmp_path / "cache"), ["s0", "s1"], processes=2)
    seen = [found.value(name) for name in ("s0", "s1")]
    there = next(one for one in seen if one["process"] != here["process"])
    assert there["from"] == here["from"]
    assert not {"", ".", str(planted)} & set(there["path"])
    assert harmless(planted)


@pytest.mark.parametrize("module", ["pipelines.cli.main", "benchmarks.child"])
def test_a_program_of_ours_runs_nothing_of_the_working_folder(planted, monkeypatch, module):
    monkeypatch.setenv("PYTHONPATH", str(planted))
    command = child.command(module, "--help", "no such part")
    done = subprocess.run(command, env=child.environment(), capture_output=True, text=True, check=False)
    assert "usage: gearcase" in done.stdout or "KeyError" in done.stderr  # it started
    assert harmless(planted)


def test_the_renderer_runs_nothing_of_the_working_folder(planted, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(planted))
    assert "KeyError" in render._run_job(tmp_path, {}, {}, 120.0)  # it came as far as the empty job
    assert harmless(planted)


def test_the_folder_of_the_script_is_not_searched(tmp_path):
    script = tmp_path / "study.py"
    script.write_text("from fem.processes.child import _folders; print(_folders())", encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (ROOT, tmp_path / "tools")))}
    (tmp_path / "tools").mkdir()
    folders = subprocess.run(
        [sys.executable, script], env=environment, capture_output=True, text=True, check=True
    ).stdout
    assert repr(str(tmp_path)) not in folders
    assert repr(str(tmp_path / "tools")) in folders


def test_the_library_comes_before_what_the_user_added(tmp_path):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (ROOT, tmp_path)))}
    (tmp_path / "queue.py").write_text(PLANTED, encoding="utf-8")
    (tmp_path / "tool.py").write_text("import queue; print(queue.__file__)", encoding="utf-8")
    program = "import subprocess; from fem.processes.child import *; subprocess.run(command('tool'), env=environment())"
    command = [sys.executable, "-P", "-c", program]
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, check=True)
    assert Path(done.stdout.strip()) == Path(os.__file__).with_name("queue.py")
    assert harmless(tmp_path)


def test_a_module_that_is_not_found_is_named(planted, tmp_path, monkeypatch):
    """A stage of a module in the working folder: here it is imported, in a process of its own it is not."""
    (planted / "own_stages.py").write_text("def build(spec):\n    return {}\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(planted))
    import own_stages

    graph = two_stages(own_stages.build)
    with pytest.raises(WorkError, match=r"cannot import own_stages .*--processes 1") as found:
        run_graph(graph, Cache(tmp_path / "cache"), ["s0", "s1"], processes=2)
    assert "memory" not in str(found.value)
    assert harmless(planted)


def test_a_child_that_cannot_start_says_which_module(tmp_path):
    done = subprocess.run(child.command("pipelines.absent"), capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith("a child process cannot import")
    assert "pipelines.absent" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_lack_of_memory_is_supposed_only_where_a_signal_ended_the_process(tmp_path):
    with pytest.raises(WorkError, match="was killed by signal SIGKILL, possibly because memory ran out"):
        run_graph(two_stages(end_by_signal), Cache(tmp_path), ["s0", "s1"], processes=2)


def test_a_call_leaves_no_file_even_while_it_runs(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    with Processes(1) as children:
        assert children.submit(os.listdir, str(tmp_path)).result() == []
    assert not list(tmp_path.iterdir())


def test_a_warning_of_several_children_about_one_cache_is_given_once(tmp_path, recwarn):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    run_graph(two_stages(), Cache(tmp_path / "file" / "cache"), ["s0", "s1"], processes=2)
    assert [str(w.message).partition(" cannot")[0] for w in recwarn] == [f"the cache {tmp_path}/file/cache"]


class LocalError(Exception):
    """Its pickle cannot be read."""

    def __init__(self, one, other):
        super().__init__(f"{one} {other}")


def fail_locally():
    raise LocalError("odd", "words")


def test_an_error_that_cannot_be_pickled_keeps_its_words():
    kind, error, _ = pickle.loads(answer(pickle.dumps((fail_locally, (), {}))))
    assert kind == "error"
    assert "LocalError" in repr(error)  # itself, where a library taught pickle to take any error
    assert "odd words" in repr(error)


def test_folders_go_to_the_child_as_they_are(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "path", ["", str(ROOT / "tests"), "__editable__.tool.finder.__path_hook__"])
    monkeypatch.chdir(tmp_path)
    home, names, folders = json.loads(child.command("pipelines.report.figures.renderer")[4])
    assert (home, folders) == (str(ROOT), sys.path[1:])
    assert set(names) == set(child.PACKAGES)
