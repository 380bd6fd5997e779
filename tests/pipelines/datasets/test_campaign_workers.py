"""Workers: processes of this machine that end with their parent, and a scheduler that is closed to others."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time

import pytest

from pipelines.datasets import workers
from pipelines.datasets.workers import dask_workers, local_workers
from pipelines.io.errors import InputError


def test_local_workers_are_processes_of_their_own():
    with local_workers(2) as hands:
        found = {hands.executor.submit(os.getpid).result() for _ in range(4)}
        assert hands.count() == 2
    assert os.getpid() not in found
    assert not any(os.path.exists(f"/proc/{number}") for number in found)


def _lock_and_interrupt():
    """The name in the system of a lock such as libraries make, and how an interrupt is handled."""
    return multiprocessing.Lock()._semlock.name, signal.getsignal(signal.SIGINT)


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_a_worker_may_be_killed_at_any_moment():
    """A lock with a name would stay in the system; the interpreter would warn of a leaked semaphore."""
    with local_workers(1) as hands:
        assert hands.executor.submit(_lock_and_interrupt).result() == (None, signal.SIG_IGN)


def test_a_file_of_the_working_folder_stands_in_for_no_library(tmp_path, monkeypatch):
    (tmp_path / "queue.py").write_text("raise RuntimeError('the wrong queue')", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with local_workers(1) as hands:
        assert hands.executor.submit(os.getcwd).result() == str(tmp_path)


PARENT = """
import os, time
from pipelines.datasets.workers import local_workers
if __name__ == "__main__":
    with local_workers(1) as hands:
        print(hands.executor.submit(os.getpid).result(), flush=True)
        time.sleep(600)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_workers_end_with_a_killed_parent(tmp_path):
    (tmp_path / "parent.py").write_text(PARENT, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(
        [sys.executable, "parent.py"], cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True
    )
    number = int(process.stdout.readline())
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    end = time.monotonic() + 60
    while os.path.exists(f"/proc/{number}") and time.monotonic() < end:
        time.sleep(0.05)
    assert not os.path.exists(f"/proc/{number}")


@pytest.mark.parametrize("place", ["scheduler.json", "tcp://127.0.0.1:1", "nonsense://"])
def test_a_scheduler_that_is_not_there_is_said(tmp_path, monkeypatch, place):
    pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(workers, "_CONNECT_SECONDS", 1)
    with pytest.raises(InputError, match="no scheduler answers"), dask_workers(place, None):
        pass


CLUSTER = """
import distributed
import gearcase
from pipelines.datasets.workers import dask_workers

def whole_run():
    scene = gearcase.Scene.from_file("minimal").changed({"simulation.end_s": 0.02, "diagnosis.windows_s": {}})
    return gearcase.run(scene, out="run", control=False).sizes["time"]

if __name__ == "__main__":
    with dask_workers(None, 1) as hands:
        print("samples", hands.executor.submit(whole_run).result())
        address = hands.executor._client.scheduler.address
        print("scheme", address.partition(":")[0])
        for other in (None, distributed.Security.temporary()):
            at = address if other else address.replace("tls:", "tcp:")
            try:
                distributed.Client(at, security=other, timeout=5, set_as_default=False)
            except Exception as error:
                print("refused", type(error).__name__)
            else:
                print("let in")
"""


@pytest.mark.slow
def test_nobody_else_can_talk_to_a_scheduler_of_our_own(tmp_path):
    """Neither without a certificate nor with another one; every user of the machine can reach the port."""
    pytest.importorskip("distributed")
    (tmp_path / "cluster.py").write_text(CLUSTER, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "cluster.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
    )
    lines = done.stdout.splitlines()
    assert lines[:2] == ["samples 200", "scheme tls"], done.stderr
    assert [line.split()[0] for line in lines[2:]] == ["refused", "refused"], done.stdout
