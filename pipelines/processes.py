"""Build stages in processes of their own: started as commands, so that a user's script needs no main guard.

The parent writes a job file and holds the child's standard input open; a child whose parent is gone reads the end of
its input and stops. The child stores its result in the cache and answers with a file.
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
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from pipelines.build import Result, build_here, one_thread
from pipelines.cache import Cache
from pipelines.errors import WorkError
from pipelines.stages import Stage

_POLL_SECONDS = 0.02
_GONE = 3  # exit code of a child whose parent is gone


@dataclass(frozen=True)
class _Child:
    stage: Stage
    key: str
    process: subprocess.Popen
    job: Path

    def close(self) -> None:
        """Free the pipe that tells the child that we are alive."""
        if self.process.stdin is not None:
            self.process.stdin.close()


class Pool:
    """Children at work. Leaving the block ends those that still run."""

    def __init__(self) -> None:
        self._children: dict[str, _Child] = {}
        self._folder: tempfile.TemporaryDirectory | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for child in self._children.values():
            child.process.kill()
        for child in self._children.values():
            child.process.wait()
            child.close()
        self._children.clear()
        if self._folder is not None:
            self._folder.cleanup()

    def __len__(self) -> int:
        return len(self._children)

    def names(self) -> set[str]:
        """Names of the stages at work."""
        return set(self._children)

    def builds(self, key: str) -> bool:
        """True if a stage with this key is at work."""
        return any(key == child.key for child in self._children.values())

    def start(self, stage: Stage, key: str, upstream: Mapping[str, Result], cache_folder: Path) -> None:
        """Begin to build a stage."""
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="gearcase-", ignore_cleanup_errors=True)
        job = Path(self._folder.name) / f"{len(list(Path(self._folder.name).iterdir()))}.job"
        job.write_bytes(pickle.dumps((stage, key, {n: r.stored() for n, r in upstream.items()}, cache_folder)))
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
        command = [sys.executable, "-m", "pipelines.processes", str(job)]
        alone = os.name == "posix"  # an interrupt from the keyboard reaches the parent only, which ends its children
        process = subprocess.Popen(command, stdin=subprocess.PIPE, env=environment, start_new_session=alone)
        self._children[stage.name] = _Child(stage, key, process, job)

    def wait(self) -> list[tuple[Stage, Result]]:
        """Sleep until at least one child is done; raises what a stage raised."""
        while True:
            done = [name for name, child in self._children.items() if child.process.poll() is not None]
            if done:
                return [self._answer(name) for name in done]
            time.sleep(_POLL_SECONDS)

    def _answer(self, name: str) -> tuple[Stage, Result]:
        child = self._children.pop(name)
        child.close()
        answer = child.job.with_suffix(".answer")
        if not answer.exists():
            raise WorkError(
                f"stage {name}: its process ended with code {child.process.returncode} and no answer, perhaps for lack "
                "of memory. Run again with --processes 1, or with a coarser model."
            )
        kind, content, notes = pickle.loads(answer.read_bytes())
        for category, text in notes:
            warnings.warn(category(text), stacklevel=2)
        if kind == "error":
            raise content
        return child.stage, content


def _stop_with_parent() -> None:
    """End this process when its standard input ends."""

    def watch() -> None:
        while os.read(0, 1):  # not sys.stdin, whose lock would be held at the end of the interpreter
            pass
        os._exit(_GONE)

    threading.Thread(target=watch, name="parent watch", daemon=True).start()


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


def work(job: Path) -> None:
    """Build the stage of a job file and write the answer beside it."""
    stage, key, upstream, cache_folder = pickle.loads(job.read_bytes())
    answer: tuple[str, Any]
    with warnings.catch_warnings(record=True) as caught:
        try:
            with one_thread():
                result = build_here(stage, key, upstream, Cache(cache_folder))
            answer = ("result", result.stored())
        except Exception as error:
            answer = ("error", _sendable(error))
    notes = [(w.category, str(w.message)) for w in caught]
    partial = job.with_suffix(".partial")
    partial.write_bytes(pickle.dumps((*answer, notes)))
    os.replace(partial, job.with_suffix(".answer"))


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    _stop_with_parent()
    work(Path(sys.argv[1]))
