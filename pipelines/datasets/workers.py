"""Who simulates the scenes: processes of this machine, or workers of a Dask scheduler, both as an executor."""

from __future__ import annotations

import contextlib
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipelines.engine.build_step import one_thread
from pipelines.io.errors import InputError, WorkError
from pipelines.io.user_files import regular_file

_CONNECT_SECONDS = 30


@dataclass(frozen=True, kw_only=True)
class Workers:
    """An executor and how many scenes it takes at once; `renew` makes another one after its processes died."""

    executor: Executor
    count: Callable[[], int]
    renew: Callable[[], Executor] | None = None
    dashboard: str = ""


@contextlib.contextmanager
def local_workers(processes: int | None) -> Iterator[Workers]:
    """A pool of processes, as many as there are cores if None. They end when this process does, however it does."""
    count = processes or os.cpu_count() or 1
    pools: list[ProcessPoolExecutor] = []

    def made() -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")  # a fork would copy the threads of numerical libraries
        pools.append(ProcessPoolExecutor(count, mp_context=context, initializer=_begin))
        return pools[-1]

    safe = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"  # no file of the working folder stands in for a module of the library
    try:
        with one_thread():
            yield Workers(executor=made(), count=lambda: count, renew=made)
    except BaseException:
        for pool in pools:  # nobody waits for scenes at work: they are simulated again
            for process in list((getattr(pool, "_processes", None) or {}).values()):
                process.kill()
        raise
    finally:
        for pool in pools:
            pool.shutdown(wait=True, cancel_futures=True)
        if safe is None:
            del os.environ["PYTHONSAFEPATH"]
        else:
            os.environ["PYTHONSAFEPATH"] = safe


def _begin() -> None:
    """Prepare a process of the pool: it leaves interrupts to its parent, and ends when that is gone.

    It may be killed at any moment. A lock that a library makes here (numcodecs does) must not need to be removed then;
    with the start method "fork" it has no name in the system. No process is started here.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if os.name == "posix":
        multiprocessing.set_start_method("fork", force=True)
    parent = multiprocessing.parent_process()
    assert parent is not None, "not a child"

    def watch() -> None:  # a process that waits for work from a queue would wait for ever
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(3)

    threading.Thread(target=watch, name="parent watch", daemon=True).start()


@contextlib.contextmanager
def dask_workers(scheduler: str | None, processes: int | None) -> Iterator[Workers]:
    """The workers of a Dask scheduler.

    Parameters
    ----------
    scheduler : its address, or the file that it wrote; None: a scheduler of our own on this machine, which only this
        user's processes can talk to
    processes : of our own scheduler, as many as there are cores if None

    Raises
    ------
    InputError : the extra is not installed, the scheduler does not answer
    """
    try:
        import distributed
    except ImportError as error:
        raise InputError(
            f"--cluster and --scheduler need Dask ({error}). Install it with: pip install 'gearcase[campaign]'"
        ) from error
    with contextlib.ExitStack() as opened:
        if scheduler is None:
            client = opened.enter_context(_own_cluster(distributed, processes))
        else:
            client = opened.enter_context(_client(distributed, scheduler))
        executor = opened.enter_context(client.get_executor(pure=False))

        def count() -> int:
            threads = sum(client.nthreads().values())
            return max(1, threads)

        yield Workers(executor=executor, count=count, dashboard=client.dashboard_link or "")


@contextlib.contextmanager
def _own_cluster(distributed: Any, processes: int | None) -> Iterator[Any]:
    try:
        security = distributed.Security.temporary()
    except ImportError as error:
        raise InputError(
            f"--cluster needs the package cryptography ({error}). Install it with: pip install 'gearcase[campaign]'"
        ) from error
    with (
        distributed.LocalCluster(
            n_workers=processes or os.cpu_count() or 1,
            threads_per_worker=1,
            security=security,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
        ) as cluster,
        distributed.Client(cluster, security=security, set_as_default=False) as client,
    ):
        yield client


def _client(distributed: Any, scheduler: str) -> Any:
    in_file = scheduler.endswith(".json")
    given = {"scheduler_file": scheduler} if in_file else {"address": scheduler}
    try:
        if in_file:
            regular_file(Path(scheduler))  # Dask would wait for it without end
        return distributed.Client(**given, timeout=_CONNECT_SECONDS, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"--scheduler {scheduler}: no scheduler answers ({error}). Correct the address, or start a scheduler there."
        ) from error


def lost(error: BaseException) -> WorkError:
    """What is said when the workers, or their scheduler, are gone for good."""
    return WorkError(
        f"the workers have ended ({type(error).__name__}: {error}). Finished scenes are kept. Repeat the command to "
        "simulate the others."
    )
