"""One call in a process of its own: for libraries that a damaged file of the user may crash.

OpenCASCADE, gmsh and the libraries of HDF5 end the process on some damaged files, and write to the terminal past
Python. So no file of the user is opened by them where a session, a run or a notebook would be lost: a child does the
whole work, and sends what it made of the file. What is printed there goes to the log.

The child begins with an import of the libraries that it needs (1 s of processor time); it ends when its parent does.
"""

from __future__ import annotations

import logging
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar, TypeVarTuple

from fem.processes.child import command, environment

_log = logging.getLogger(__name__)
_JOB, _ANSWER, _SAID = "job", "answer", "said"
_Arguments = TypeVarTuple("_Arguments")
_Result = TypeVar("_Result")
_MEMORY, _PER_BYTE = 4 << 30, 200  # a STEP file of 3 MB took 0.55 GB and 20 times its size
DAMAGED = "it is damaged, or its content does not match its file extension. Export it again"


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
    with tempfile.TemporaryDirectory(prefix="gearcase-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        (folder / _JOB).write_bytes(pickle.dumps((call, arguments)))
        code = _run(folder)
        for line in (folder / _SAID).read_text("utf-8", "replace").splitlines():
            _log.info("library: %s", line)
        if not (folder / _ANSWER).exists():
            how = signal.Signals(-code).name if code < 0 else f"code {code}"
            how += ", perhaps for lack of memory" if how == "SIGKILL" else ""
            raise error(f"{file.name}: the library that reads it crashed ({how}); {remedy}")
        done, content = pickle.loads((folder / _ANSWER).read_bytes())
    if done:
        return content
    raise content


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


def _run(folder: Path) -> int:
    """Exit code of the child; it is ended if this process is interrupted."""
    with (folder / _SAID).open("wb") as said:
        child = subprocess.Popen(
            command("fem.processes.own_process", str(folder)),
            stdin=subprocess.PIPE,  # its end tells the child that this process is gone
            stdout=said,
            stderr=subprocess.STDOUT,
            env=environment(),
            start_new_session=os.name == "posix",  # an interrupt from the keyboard reaches the parent only
        )
        try:
            return child.wait()
        finally:
            child.kill()
            child.communicate()


def _end_with_parent() -> None:
    os.read(0, 1)
    os._exit(1)


def _main(folder: Path) -> None:
    threading.Thread(target=_end_with_parent, name="parent watch", daemon=True).start()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    call, arguments = pickle.loads((folder / _JOB).read_bytes())
    try:
        answer = (True, call(*arguments))
    except Exception as error:
        answer = (False, error)
    partial = folder / "partial"
    partial.write_bytes(pickle.dumps(answer))
    os.replace(partial, folder / _ANSWER)


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
