"""One call in a separate process, for libraries that a damaged file or a bad geometry of the user may crash.

OpenCASCADE, gmsh and the HDF5 library end the process on some of them, and print to the terminal directly. A child
therefore opens files of the user and meshes, so that no session, run or notebook is lost. The child does the whole work
and returns its result; its output goes to the log.

It imports the libraries that it needs (1 s of processor time) and ends with its parent.
"""

from __future__ import annotations

import logging
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar, TypeVarTuple

from fem.processes.executor import ProcessEnded, Processes

_log = logging.getLogger(__name__)
_Arguments = TypeVarTuple("_Arguments")
_Result = TypeVar("_Result")
_MEMORY, _PER_BYTE = 4 << 30, 200  # a STEP file of 3 MB needs 0.55 GB and 20 times its size
_SECONDS, _SECONDS_PER_BYTE = 60.0, 20e-6  # a STEP or IGES file needs 0.7e-6 s per byte
_ENDED = {"SIGKILL": "crashed (SIGKILL, perhaps for lack of memory)", "SIGALRM": "did not end in its time"}
READER = "{}: the library that reads it"
DAMAGED = "it is damaged, or its format does not fit its ending. Export it again"


def call_in_own_process(
    task: str,
    error: type[Exception],
    remedy: str,
    call: Callable[[*_Arguments], _Result],
    *arguments: *_Arguments,
) -> _Result:
    """Call a function of a module in a child process; returns its result or raises its error.

    Parameters
    ----------
    task : what crashed, for the message
    error : type raised if the child ends without an answer
    remedy : end of its message
    call, *arguments : the work; they and the result must be picklable

    Raises
    ------
    error : the process ended, mostly by a crash of a library; also every error of the call
    """
    with tempfile.TemporaryFile() as said:
        try:
            with Processes(1, said) as child:
                return child.submit(call, *arguments).result()
        except ProcessEnded as ended:
            how = _ENDED.get(str(ended), f"crashed ({ended})")
            raise error(f"{task} {how}; {remedy}") from ended
        finally:
            said.seek(0)
            for line in said.read().decode("utf-8", "replace").splitlines():
                _log.info("library: %s", line)


@contextmanager
def bounded(file: Path) -> Iterator[None]:
    """Limit memory and time to what the reading of a file may need, if the system can limit them.

    A wrong number in the file can make OpenCASCADE allocate memory until the system ends arbitrary processes, or repeat
    a loop without end. A process that exceeds the time is ended by SIGALRM.
    """
    if sys.platform == "win32":
        yield
        return
    import resource

    usual, most = resource.getrlimit(resource.RLIMIT_AS)
    size = file.stat().st_size
    bound = _MEMORY + _PER_BYTE * size
    limits = [one for one in (usual, most) if one != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(bound, *limits) if limits else bound, most))
    signal.setitimer(signal.ITIMER_REAL, _SECONDS + _SECONDS_PER_BYTE * size)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        resource.setrlimit(resource.RLIMIT_AS, (usual, most))
