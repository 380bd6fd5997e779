"""One call in a process of its own: for libraries that a damaged file of the user may crash.

OpenCASCADE, gmsh and the libraries of HDF5 end the process on some damaged files, and write to the terminal past
Python. So no file of the user is opened by them where a session, a run or a notebook would be lost: a child does the
whole work, and sends what it made of the file. What is printed there goes to the log.

The child begins with an import of the libraries that it needs (1 s of processor time); it ends when its parent does.
"""

from __future__ import annotations

import logging
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
_MEMORY, _PER_BYTE = 4 << 30, 200  # a STEP file of 3 MB took 0.55 GB and 20 times its size
DAMAGED = "it is damaged, or its format does not fit its ending. Export it again"


def opened_apart(
    file: Path,
    error: type[Exception],
    remedy: str,
    call: Callable[[*_Arguments], _Result],
    *arguments: *_Arguments,
) -> _Result:
    """What a call of a function of a module returns, or raises, in a child process.

    Parameters
    ----------
    file : that the call opens, for the message
    error : raised where the child ends without an answer
    remedy : the rest of its message
    call, *arguments : the work; they and the result must survive pickle

    Raises
    ------
    error : the process ended, mostly because a library crashed; and whatever the call raises
    """
    with tempfile.TemporaryFile() as said:
        try:
            with Processes(1, said) as child:
                return child.submit(call, *arguments).result()
        except ProcessEnded as ended:
            how = f"{ended}, perhaps for lack of memory" if str(ended) == "SIGKILL" else ended
            raise error(f"{file.name}: the library that reads it crashed ({how}); {remedy}") from ended
        finally:
            said.seek(0)
            for line in said.read().decode("utf-8", "replace").splitlines():
                _log.info("library: %s", line)


@contextmanager
def bounded_memory(file: Path) -> Iterator[None]:
    """No more memory than the reading of a file may need, where the system can limit it.

    A number that is wrong can make OpenCASCADE ask for more and more, until the system ends processes of its choice.
    """
    if sys.platform == "win32":
        yield
        return
    import resource

    usual, most = resource.getrlimit(resource.RLIMIT_AS)
    bound = _MEMORY + _PER_BYTE * file.stat().st_size
    limits = [one for one in (usual, most) if one != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(bound, *limits) if limits else bound, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (usual, most))
