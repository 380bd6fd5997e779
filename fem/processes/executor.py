"""Child processes that take calls: one mechanism for steps, scenes of a campaign, and libraries that may crash.

A child starts as `fem.processes.child.command`. It reads calls from its standard input and answers on its standard
output, both as pickles; whatever else is printed there goes to its standard error. Nothing is written to files, so
a process that is killed leaves none behind. The end of the input, however the parent ends, ends the child too.
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
_GONE = 3  # exit code of a child whose parent is gone
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
    """What a call in a child raised, in words: an error of a type that does not survive pickle."""


def tell_share(share: float) -> None:
    """Report to the listener that this share (0 to 1) of the work is done; without one nothing happens."""
    if listener := _LISTENER.get():
        listener(share)


@contextmanager
def listening(listener: Callable[[float], None]) -> Iterator[None]:
    """Report to a function the shares of the work in the block."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)


def in_thread(call: Callable[..., Any], *arguments: Any) -> Future:
    """The result of a call in a thread; a thread that is not finished ends with the process."""
    future: Future = Future()

    def run() -> None:
        try:
            future.set_result(call(*arguments))
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return future


class Processes(Executor):
    """At most `count` child processes with one thread for BLAS and OpenMP; they start when they are needed.

    Calls are functions of modules; they, their arguments and results must survive pickle. A future raises what the
    call raised, or ProcessEnded. Leaving the block with an error, or an interrupt, kills the children. What they print
    goes to `output`, by default to standard error of this process.
    """

    def __init__(self, count: int, output: IO[bytes] | None = None) -> None:
        self._output = output
        self._threads = ThreadPoolExecutor(count)
        self._lock = threading.Lock()
        self._children: list[subprocess.Popen] = []
        self._idle: list[subprocess.Popen] = []
        self._closed = False

    def submit(self, call: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """The result of a call in a child."""
        return self.listened(None, call, *args, **kwargs)

    def listened(
        self, listener: Callable[[float], None] | None, call: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> Future:
        """The result of a call in a child.

        Parameters
        ----------
        listener : called with the shares (0 to 1) of the work that is done, in a thread; None: nobody
        call, *args, **kwargs : function of a module, and what it is called with
        """
        return self._threads.submit(self._answered, listener, pickle.dumps((call, args, kwargs)))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the children: after their calls, or (not `wait`) at once."""
        if not wait:
            self._kill()
        self._threads.shutdown(wait=True, cancel_futures=cancel_futures or not wait)
        self._kill()

    def __exit__(self, kind: object, *_: object) -> None:
        """End the children; at once after an error."""
        self.shutdown(wait=kind is None)

    def end_idle(self) -> None:
        """End the children without work: one that has built a casing holds its memory, over 1 GB."""
        while child := self._waiting():
            self._end(child)

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
        """Exit code of a child that is ended, if it has not ended yet."""
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
        """A child that is alive; those that died while they waited have nothing to lose."""
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
                start_new_session=os.name == "posix",  # an interrupt from the keyboard reaches the parent only
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
                code = child.wait(timeout=1.0)  # its own code, not that of `_end`
            except subprocess.TimeoutExpired:
                code = 0
            self._end(child)
            raise ProcessEnded(code) from error
        self._idle.append(child)
        for category, text in notes:
            if category is CacheWarning:
                warn_once(text)  # each process finds out for itself that there is no cache
            else:
                warnings.warn(category(text), stacklevel=2)
        if kind == "error":
            raise content
        return content


def answer(call: bytes) -> bytes:
    """Do the work of a call; its result, or its error, and the warnings."""
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
    """The error itself if it survives the way to the parent, else one of a known type with its words."""
    try:
        if str(pickle.loads(pickle.dumps(error))) == str(error):
            return error
    except Exception as reason:
        logging.getLogger(__name__).debug("%r cannot be sent: %r", error, reason)
    kind = ValueError if isinstance(error, ValueError) else RemoteError
    return kind(f"{type(error).__name__}: {error}")


def serve() -> None:
    """Answer calls until the input ends; that ends this process, at work or not.

    It may be killed at any moment. A lock that a library makes here (numcodecs does) must not need to be removed then;
    with the start method "fork" it has no name in the system. No process is started here.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
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
    """Have what libraries printed where it is read, before the answer."""
    sys.stdout.flush()
    if os.name == "posix":
        import ctypes

        ctypes.CDLL(None).fflush(None)


if __name__ == "__main__":
    from fem.processes.executor import serve as _serve  # whose listener is that of the work

    _serve()
