"""Build steps in processes of their own: started as commands, so that a user's script needs no main guard.

The parent writes a job file and its name on the child's standard input; the child (`pipelines.engine.worker`) stores
its result in the cache, answers with a file and waits for the next job, because starting Python and its libraries takes
long. A child whose parent is gone reads the end of its input and stops. The files lie in a folder that only this user
can read and write: reading one runs what it holds.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import tempfile
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Self, cast

from fem.processes.child import command, environment
from fem.storage.cache_folder import CacheWarning, warn_once
from pipelines.engine.build_step import Result
from pipelines.engine.step import Step
from pipelines.io.errors import WorkError

_POLL_SECONDS = 0.02
_SHARE_SECONDS = 0.5  # between two looks at how far the steps are


@dataclass(frozen=True)
class _Job:
    step: Step
    key: str
    path: Path

    @property
    def answer(self) -> Path:
        return self.path.with_suffix(".answer")

    @property
    def share(self) -> float | None:
        """Share of the step that is done, if it told one."""
        try:
            return float(self.path.with_suffix(".share").read_text(encoding="ascii"))
        except (FileNotFoundError, ValueError):  # none yet, or half written
            return None


class Pool:
    """Children at work or waiting for it. Leaving the block ends them all."""

    def __init__(self) -> None:
        self._working: list[tuple[subprocess.Popen, _Job]] = []
        self._idle: list[subprocess.Popen] = []
        self._folder: tempfile.TemporaryDirectory | None = None
        self._jobs = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._idle += [child for child, _ in self._working]
        self._working.clear()
        self.end_waiting()
        if self._folder is not None:
            self._folder.cleanup()

    def end_waiting(self) -> None:
        """End the children without work: one that has built a casing holds its memory, over 1 GB."""
        for child in self._idle:
            child.kill()
        for child in self._idle:
            child.wait()
            _input(child).close()
        self._idle.clear()

    def __len__(self) -> int:
        return len(self._working)

    def names(self) -> set[str]:
        """Names of the steps at work."""
        return {job.step.name for _, job in self._working}

    def builds(self, key: str) -> bool:
        """True if a step with this key is at work."""
        return any(key == job.key for _, job in self._working)

    def start(self, step: Step, key: str, upstream: Mapping[str, Result], cache_folder: Path) -> None:
        """Begin to build a step.

        Parameters
        ----------
        step, key : the step, and the key of its result
        upstream : results by the names of the steps that it takes
        cache_folder : of the cache where the result is stored

        Raises
        ------
        WorkError : the process ended before it took the step
        """
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="gearcase-", ignore_cleanup_errors=True)
        job = _Job(step, key, Path(self._folder.name) / f"{self._jobs}.job")
        self._jobs += 1
        job.path.write_bytes(pickle.dumps((step, key, {n: r.stored() for n, r in upstream.items()}, cache_folder)))
        child = self._waiting_child() or _new_child(Path(self._folder.name))
        self._working.append((child, job))
        try:
            _input(child).write(f"{job.path.name}\n".encode())
        except BrokenPipeError as error:
            raise _lost(step, child) from error

    def _waiting_child(self) -> subprocess.Popen | None:
        """One that is alive; those that died while they waited have nothing to lose."""
        while self._idle:
            child = self._idle.pop()
            if child.poll() is None:
                return child
            _input(child).close()
        return None

    def wait(
        self, advanced: Callable[[Step, float], None], enough: Callable[[], bool] = lambda: False
    ) -> list[tuple[Step, Result]]:
        """Sleep until at least one job is done, or until it is `enough`; the jobs that are done.

        Raises what a step raised. `advanced` is called with the share of each step that is done.
        """
        look = time.monotonic() + _SHARE_SECONDS
        while True:
            done = [one for one in self._working if one[1].answer.exists() or one[0].poll() is not None]
            if done or enough():
                return [self._result(child, job) for child, job in done]
            if time.monotonic() >= look:
                look += _SHARE_SECONDS
                for _, job in self._working:
                    if (share := job.share) is not None:
                        advanced(job.step, share)
            time.sleep(_POLL_SECONDS)

    def _result(self, child: subprocess.Popen, job: _Job) -> tuple[Step, Result]:
        if not job.answer.exists():
            raise _lost(job.step, child)
        self._working.remove((child, job))
        self._idle.append(child)
        kind, content, notes = pickle.loads(job.answer.read_bytes())
        for category, text in notes:
            if category is CacheWarning:
                warn_once(text)  # each process finds out for itself that there is no cache
            else:
                warnings.warn(category(text), stacklevel=2)
        if kind == "error":
            raise content
        return job.step, content


def _new_child(folder: Path) -> subprocess.Popen:
    alone = os.name == "posix"  # an interrupt from the keyboard reaches the parent only, which ends its children
    return subprocess.Popen(
        command("pipelines.engine.worker", str(folder)),
        bufsize=0,
        stdin=subprocess.PIPE,
        env=environment(),
        start_new_session=alone,
    )


def _input(child: subprocess.Popen) -> IO[bytes]:
    return cast("IO[bytes]", child.stdin)


def _lost(step: Step, process: subprocess.Popen) -> WorkError:
    code = process.wait()
    if code < 0:
        how = f"was killed by signal {signal.Signals(-code).name}, possibly because memory ran out"
    else:
        how = f"ended with exit code {code} and no result; its output is printed above"
    return WorkError(
        f"step {step.name}: its process {how}. Repeat the command with --processes 1, or choose a coarser preset."
    )
