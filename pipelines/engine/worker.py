"""The child of `processes`: builds the steps of the job files that its parent names, until that is gone.

What the work needs is imported as part of the work: what cannot be imported is answered like any other error.
"""

from __future__ import annotations

import logging
import os
import pickle
import queue
import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipelines.io.errors import WorkError

GONE = 3  # exit code of a child whose parent is gone


def asked() -> Iterator[str]:
    """Names of job files as the parent writes them. The end of the input ends this process, at work or not."""
    names: queue.SimpleQueue[str] = queue.SimpleQueue()

    def watch() -> None:
        given = b""
        while more := os.read(0, 4096):  # not sys.stdin, whose lock would be held at the end of the interpreter
            *lines, given = (given + more).split(b"\n")
            for line in lines:
                names.put(line.decode())
        os._exit(GONE)

    threading.Thread(target=watch, name="parent watch", daemon=True).start()
    while True:
        yield names.get()


def work(job: Path) -> None:
    """Build the step of a job file and write the answer beside it."""
    answer: tuple[str, Any]
    with warnings.catch_warnings(record=True) as caught:
        try:
            answer = ("result", _built(job))
        except Exception as error:
            answer = ("error", _sendable(error))
    notes = [(w.category, str(w.message)) for w in caught]
    partial = job.with_suffix(".partial")
    partial.write_bytes(pickle.dumps((*answer, notes)))
    os.replace(partial, job.with_suffix(".answer"))


def _built(job: Path) -> Any:
    try:
        from pipelines.engine.build_step import build_here, one_thread
        from pipelines.engine.cache import Cache
        from pipelines.engine.share import listening

        step, key, upstream, cache_folder = pickle.loads(job.read_bytes())
    except ImportError as error:
        raise WorkError(
            f"a child process cannot import {error.name or 'a module'} ({error}). Modules in the working folder "
            "and in that of the script are not found there. Run again with processes = 1 (--processes 1)."
        ) from error
    with one_thread(), listening(lambda share: _write_share(job, share)):
        return build_here(step, key, upstream, Cache(cache_folder)).stored()


def _write_share(job: Path, share: float) -> None:
    """Where the parent finds it; it is small enough to be written in one piece."""
    job.with_suffix(".share").write_text(f"{share:.4f}", encoding="ascii")


def _sendable(error: Exception) -> Exception:
    """The error itself if it survives the way to the parent, else one of a known type with its words."""
    try:
        copy = pickle.loads(pickle.dumps(error))
        if str(copy) == str(error):
            return error
    except Exception as reason:
        logging.getLogger(__name__).debug("%r cannot be sent: %r", error, reason)
    kind = ValueError if isinstance(error, ValueError) else WorkError
    return kind(f"{type(error).__name__}: {error}")


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    for name in asked():
        work(Path(sys.argv[1]) / name)
