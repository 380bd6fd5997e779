"""Executors that simulate scenes: processes of this machine, or workers of a Dask scheduler."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fem.processes.executor import Processes
from pipelines.io.errors import InputError, WorkError
from pipelines.io.user_files import regular_file

_CONNECT_SECONDS = 30


@dataclass(frozen=True, kw_only=True)
class Workers:
    """An executor and the number of scenes that it simulates at a time."""

    executor: Executor
    count: Callable[[], int]
    dashboard: str = ""


@contextlib.contextmanager
def local_workers(processes: int | None) -> Iterator[Workers]:
    """A pool of processes, by default one for each core. They end when this process ends, also if it is killed."""
    count = processes or os.cpu_count() or 1
    with Processes(count) as children:
        yield Workers(executor=children, count=lambda: count)


@contextlib.contextmanager
def dask_workers(scheduler: str | None, processes: int | None) -> Iterator[Workers]:
    """The workers of a Dask scheduler.

    Parameters
    ----------
    scheduler : its address, or the file that it wrote; None starts a scheduler on this machine, which accepts only
        processes of this user
    processes : of a scheduler that is started here; by default one for each core

    Raises
    ------
    InputError : the extra is not installed, or the scheduler does not answer
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
        yield Workers(
            executor=executor,
            count=lambda: max(1, sum(client.nthreads().values())),
            dashboard=client.dashboard_link or "",
        )


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
            regular_file(Path(scheduler))  # Dask would wait for a missing file without end
        return distributed.Client(**given, timeout=_CONNECT_SECONDS, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"--scheduler {scheduler}: no scheduler answers ({error}). Correct the address, or start a scheduler there."
        ) from error


def lost(error: BaseException) -> WorkError:
    """Error when all workers, or their scheduler, have ended."""
    return WorkError(
        f"the workers have ended ({type(error).__name__}: {error}). Finished scenes are kept. Repeat the command to "
        "simulate the others."
    )
