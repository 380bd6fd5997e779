"""Executor of calls in child processes: for steps, scenes of a campaign, and libraries that may crash.

A child starts as `fem.processes.child.command`. It reads calls from its standard input and answers on its standard
output, both as pickles; other output is redirected to its standard error. No files are written, so a killed process
leaves none behind. The child ends with its input, that is, whenever the parent ends.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import IO, Any, cast

from fem.processes.child import command, environment
from fem.storage.cache_folder import CacheWarning, warn_once

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_GONE = 3  # exit code of a child whose parent has ended
_LISTENER: ContextVar[Callable[[float], None] | None] = ContextVar("listener of the share", default=None)


class ProcessEnded(Exception):
    """A child process ended without an answer, with an exit code, or by a signal (negative)."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code

    def __str__(self) -> str:
        """The name of the signal or the exit code."""
        return signal.Signals(-self.code).name if self.code < 0 else f"code {self.code}"


class RemoteError(RuntimeError):
    """An error raised in a child whose type cannot be pickled, as text."""


def tell_share(share: float) -> None:
    """Report the completed share (0 to 1) of the work to the listener, if there is one."""
    if listener := _LISTENER.get():
        listener(share)


@contextmanager
def listening(listener: Callable[[float], None]) -> Iterator[None]:
    """Report the completed shares of the work in the block to a function."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)


def in_thread(call: Callable[..., Any], *arguments: Any) -> Future:
    """The future of a call in a daemon thread, which ends with the process."""
    future: Future = Future()

    def run() -> None:
        try:
            future.set_result(call(*arguments))
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return future


class Processes(Executor):
    """Executor with at most `count` child processes, started on demand, each with one BLAS and OpenMP thread.

    Calls are functions of modules; they, their arguments and results must be picklable. A future raises the error of
    its call, or ProcessEnded. If an error or an interrupt leaves the block, the children are killed. Their output goes
    to `output`, by default to standard error of this process.
    """

    def __init__(self, count: int, output: IO[bytes] | None = None) -> None:
        self._output = output
        self._threads = ThreadPoolExecutor(count)
        self._lock = threading.Lock()
        self._children: list[subprocess.Popen] = []
        self._idle: list[subprocess.Popen] = []
        self._closed = False

    def submit(self, call: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """Future of a call in a child."""
        return self.listened(None, call, *args, **kwargs)

    def listened(
        self, listener: Callable[[float], None] | None, call: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> Future:
        """Future of a call in a child, with reports of its progress.

        Parameters
        ----------
        listener : callback in a thread with the completed share (0 to 1) of the work, or None
        call, *args, **kwargs : function of a module, and its arguments
        """
        return self._threads.submit(self._answered, listener, pickle.dumps((call, args, kwargs)))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the children after their calls or, without `wait`, immediately."""
        if not wait:
            self._kill()
        self._threads.shutdown(wait=True, cancel_futures=cancel_futures or not wait)
        self._kill()

    def __exit__(self, kind: object, *_: object) -> None:
        """End the children; immediately after an error."""
        self.shutdown(wait=kind is None)

    def end_idle(self) -> None:
        """End idle children: one that has built a casing still uses its memory, over 1 GB."""
        while child := self._waiting():
            self._end(child)

    @property
    def idle(self) -> int:
        """Number of children that wait for a call."""
        return len(self._idle)

    def _waiting(self) -> subprocess.Popen | None:
        with self._lock:
            return self._idle.pop() if self._idle else None

    def _kill(self) -> None:
        with self._lock:
            self._closed = True
            for child in list(self._children):
                child.kill()
        self.end_idle()

    def _end(self, child: subprocess.Popen) -> int:
        """Kill a child that is still running and close its pipes; returns its exit code."""
        child.kill()
        code = child.wait()
        cast("IO[bytes]", child.stdout).close()
        try:
            cast("IO[bytes]", child.stdin).close()
        except OSError as error:
            logging.getLogger(__name__).debug("input of an ended process: %s", error)
        self._children.remove(child)
        return code

    def _ready(self) -> subprocess.Popen:
        """A running child; idle children that have ended are dropped."""
        while child := self._waiting():
            if child.poll() is None:
                return child
            self._end(child)
        with self._lock:
            if self._closed:
                raise ProcessEnded(_GONE)
            child = subprocess.Popen(
                command("fem.processes.executor", *(["log"] if self._output else [])),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._output,
                env=environment(**dict.fromkeys(THREAD_VARIABLES, "1")),
                start_new_session=os.name == "posix",  # a keyboard interrupt reaches only the parent
            )
            self._children.append(child)
        return child

    def _answered(self, listener: Callable[[float], None] | None, call: bytes) -> Any:
        child = self._ready()
        given, answers = cast("IO[bytes]", child.stdin), cast("IO[bytes]", child.stdout)
        try:
            pickle.dump(call, given)
            given.flush()
            while isinstance(answer := pickle.load(answers), float):
                if listener is not None:
                    listener(answer)
            kind, content, notes = pickle.loads(answer)
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            try:
                code = child.wait(timeout=1.0)  # its exit code, before `_end` kills it
            except subprocess.TimeoutExpired:
                code = 0
            self._end(child)
            raise ProcessEnded(code) from error
        self._idle.append(child)
        for category, text in notes:
            if category is CacheWarning:
                warn_once(text)  # each process detects separately that there is no cache
            else:
                warnings.warn(category(text), stacklevel=2)
        if kind == "error":
            raise content
        return content


def answer(call: bytes) -> bytes:
    """Execute a pickled call; returns its result or error, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        try:
            work, arguments, named = pickle.loads(call)
            kind, content = "result", work(*arguments, **named)
        except Exception as error:
            kind, content = "error", _sendable(error)
    notes = [(warning.category, str(warning.message)) for warning in caught]
    try:
        return pickle.dumps((kind, content, notes))
    except Exception as error:
        return pickle.dumps(("error", _sendable(error), []))


def _sendable(error: Exception) -> Exception:
    """The error itself if it can be pickled, else one of a known type with its message."""
    try:
        if str(pickle.loads(pickle.dumps(error))) == str(error):
            return error
    except Exception as reason:
        logging.getLogger(__name__).debug("%r cannot be sent: %r", error, reason)
    kind = ValueError if isinstance(error, ValueError) else RemoteError
    return kind(f"{type(error).__name__}: {error}")


def serve() -> None:
    """Answer calls until the input ends; this also ends a process that is still computing.

    The process may be killed at any time. A lock created by a library (numcodecs) must then need no removal; with the
    start method "fork" it has no name in the system. No process is started here.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles interrupts
    if "log" in sys.argv:
        logging.basicConfig(level=logging.INFO, format="%(message)s")
    if os.name == "posix":
        multiprocessing.set_start_method("fork", force=True)
    answers, calls = os.fdopen(os.dup(1), "wb"), os.fdopen(os.dup(0), "rb")
    os.dup2(2, 1)
    given: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def watch() -> None:
        try:
            while True:
                given.put(pickle.load(calls))
        finally:
            os._exit(_GONE)

    def send(content: float | bytes) -> None:
        pickle.dump(content, answers)
        answers.flush()

    threading.Thread(target=watch, name="parent watch", daemon=True).start()
    while True:
        with listening(lambda share: send(float(share))):
            done = answer(given.get())
        _flush()
        send(done)


def _flush() -> None:
    """Flush the output of libraries before the answer."""
    sys.stdout.flush()
    if os.name == "posix":
        import ctypes

        ctypes.CDLL(None).fflush(None)


if __name__ == "__main__":
    from fem.processes.executor import serve as _serve  # the module that holds the listener of the work

    _serve()
