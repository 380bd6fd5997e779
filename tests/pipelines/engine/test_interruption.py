"""Interruption: after SIGINT or SIGKILL at any moment the next run goes on and gives the same bits."""

import os
import random
import signal
import subprocess
import sys
import time

import pytest
from time_limit import HANGING

from pipelines.engine.storage import digest
from pipelines.runs.run_folder import RESPONSE, find_run

SCENE = ("minimal", "--set", "simulation.end_s=0.1", "--set", "diagnosis.windows_s={}")
MOMENTS = 10

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")


def start(folder):
    command = [sys.executable, "-m", "pipelines.cli.main", "simulate", *SCENE]
    environment = {**os.environ, "GEARCASE_CACHE": str(folder / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def signals(folder):
    """Digest of every result that looks whole, by its folder."""
    import xarray

    out = {}
    for run in sorted((folder / "runs" / "minimal").glob("[!.]*/")):
        with xarray.open_dataset(run / RESPONSE, engine="h5netcdf") as data:
            labels = ("provenance", "steps", "build_ledger")
            data.attrs = {name: value for name, value in data.attrs.items() if name not in labels}
            out[run.name] = digest(data.load())
    return out


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Digest and seconds of a run that nobody disturbs, compiled code being stored already."""
    folders = [tmp_path_factory.mktemp("undisturbed") for _ in range(2)]
    for folder in folders:
        begin = time.perf_counter()
        process = start(folder)
        assert process.wait() == 0, process.stderr.read()
        process.communicate()
        seconds = time.perf_counter() - begin
    first, second = ([*signals(folder).values()] for folder in folders)
    assert first == second
    return first[0], seconds


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGINT", "SIGKILL"])
def test_the_next_run_goes_on_and_gives_the_same_bits(undisturbed, tmp_path, name):
    wanted, seconds = undisturbed
    draw = random.Random(name)
    for moment in sorted(draw.uniform(0.05, 1.0) * seconds for _ in range(MOMENTS // 2)):
        process = start(tmp_path)
        time.sleep(moment)
        process.send_signal(getattr(signal, name))
        _, err = process.communicate(timeout=HANGING)
        if name == "SIGINT" and "Fatal Python error" not in err:  # so a starting interpreter may answer
            assert "in _guarded" not in err  # other tracebacks are of the interpreter: of its start or its end
            assert process.returncode in (0, 130, -signal.SIGINT)
        assert all(found == wanted for found in signals(tmp_path).values()), "half a result looks whole"
    process = start(tmp_path)
    _, err = process.communicate(timeout=HANGING)
    assert process.returncode == 0, err
    assert "damaged" not in err
    found = signals(tmp_path)
    assert find_run("minimal", root=tmp_path / "runs").name in found
    assert set(found.values()) == {wanted}
    assert not list((tmp_path / "runs" / "minimal").glob(".partial-*"))


PARENT = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it
sys.path[:0] = {path!r}
from pipelines.engine.run_graph import run_graph
from pipelines.engine.cache import Cache
from pipelines.engine.step import Graph, Step
from test_run_graph import make_slowly
graph = Graph(Step(name=f"s{{n}}", kind="slow", build=make_slowly, spec={seconds} + n, seconds=9.0) for n in range(2))
run_graph(graph, Cache({cache!r}), ["s0", "s1"], processes=2)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL], ids=["SIGINT", "SIGKILL"])
def test_no_process_outlives_its_parent(tmp_path, number):
    import psutil

    code = PARENT.format(path=[os.path.dirname(__file__), *sys.path], cache=str(tmp_path), seconds=HANGING)
    parent = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.DEVNULL)
    children = []
    deadline = time.monotonic() + HANGING / 3
    while len(children) < 2 and time.monotonic() < deadline:
        children = psutil.Process(parent.pid).children()
        time.sleep(0.05)
    assert len(children) == 2
    parent.send_signal(number)
    parent.wait(timeout=HANGING / 3)
    _, alive = psutil.wait_procs(children, timeout=HANGING / 3)
    assert alive == []
