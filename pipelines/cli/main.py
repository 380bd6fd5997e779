"""The command `gearcase`: runs one command, and turns errors into a message and an exit code.

Exit codes: 0 success, 1 the work failed, 2 the input cannot be used, 130 interrupted (SIGINT, SIGTERM).
The commands are listed in `pipelines.cli.command_line.COMMANDS`.
"""

from __future__ import annotations

import contextlib
import importlib
import logging
import os
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, TextIO

from fem.processes.child import collect_rarely
from pipelines.cli.command_line import Printed, command_parser, parser

if TYPE_CHECKING:
    import argparse


def program() -> int:
    """`main` in a separate process."""
    collect_rarely()
    return main()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code. Only usage errors of argparse are raised, as SystemExit."""
    if not _streams_open():
        return 2
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a console that lacks a character must not stop a run
    given = sys.argv[1:] if arguments is None else arguments
    top = parser(given)
    options, unknown = top.parse_known_args(given)
    if unknown:
        command_parser(top, options.command).error(f"unrecognized arguments: {' '.join(unknown)}")
    if options.version:
        from pipelines.engine.code_version import library_versions

        sys.stdout.write(f"gearcase {library_versions('gearcase')['gearcase']}\n")
        return 0
    if options.command is None:
        top.print_help(sys.stderr)
        return 2
    return _guarded(options)


def _streams_open() -> bool:
    """False, with a message, if nothing can be printed. Closed descriptors are opened, so that no file gets them."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)
            os.dup2(nowhere, descriptor)
            if nowhere != descriptor:
                os.close(nowhere)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - as long as the process
    if sys.stdout is None:
        sys.stderr.write("gearcase: standard output is closed. Redirect it to a file or to /dev/null.\n")
        return False
    return True


def _guarded(options: argparse.Namespace) -> int:
    from pipelines.io.errors import CacheWarning, SceneWarning
    from pipelines.io.shown_text import shown

    _log_to_terminal(options.verbose)
    try:
        os.getcwd()
    except OSError as error:
        sys.stderr.write(
            f"gearcase: the working folder does not exist any more ({error.strerror}). Change to another folder.\n"
        )
        return 2
    try:
        with _interrupted_by_sigterm(), warnings.catch_warnings():
            warnings.simplefilter("always", CacheWarning)
            warnings.simplefilter("always", SceneWarning)
            warnings.showwarning = _show_warning
            return _printed(importlib.import_module(f"pipelines.cli.{options.command}").main(options))
    except KeyboardInterrupt:
        sys.stderr.write("gearcase: interrupted. Finished steps are kept; repeat the command to continue from there.\n")
        return 130
    except BrokenPipeError:
        _to_nowhere(sys.stdout, sys.stderr)
        return 0  # the reader has stopped on purpose, as `head` does
    except Exception as error:
        try:
            sys.stdout.flush()
        except OSError:
            _to_nowhere(sys.stdout)
        if options.verbose:
            sys.stderr.write("".join(f"{shown(line, 500)}\n" for line in traceback.format_exc().splitlines()))
        return _report(error, verbose=options.verbose)


def _printed(lines: Printed) -> int:
    """Print the lines of a command as they come, and return its exit code."""
    while True:
        try:
            line = next(lines)
        except StopIteration as end:
            return end.value or 0
        sys.stdout.write(line if line.endswith("\n") else f"{line}\n")
        sys.stdout.flush()  # raises here if the disk is full or the reader has ended, not when the interpreter ends


def _to_nowhere(*streams: TextIO) -> None:
    """Discard unwritten output. Otherwise the interpreter tries again when it ends, and changes the exit code."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(nowhere, stream.fileno())


@contextlib.contextmanager
def _interrupted_by_sigterm() -> Iterator[None]:
    """Treat SIGTERM, of `kill` or a batch system, like Ctrl-C: child processes, locks and partial files are removed."""
    if threading.current_thread() is not threading.main_thread():  # only the main thread can handle signals
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before or signal.SIG_DFL)


def _report(error: Exception, *, verbose: bool) -> int:
    """Print the message of an error; 2 if it is about the input, else 1."""
    from pipelines.io.shown_text import message_text

    ours = type(error).__module__.partition(".")[0] in ("fem", "mbd", "pipelines")
    text = str(error) if ours else f"{type(error).__name__}: {error}"
    if isinstance(error, OSError):
        ours, text = True, f"{error}. Check free disk space and write permission there, then repeat the command."
    notes = "".join(f"\n  ({note})" for note in getattr(error, "__notes__", ()))
    hint = (
        ""
        if ours or verbose
        else "\n  This is an error of the program. Repeat the command with -v and report the traceback."
    )
    sys.stderr.write(f"{message_text(f'gearcase: {text}{notes}')}{hint}\n")
    return 2 if ours and isinstance(error, ValueError) else 1


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    from pipelines.io.shown_text import message_text

    sys.stderr.write(f"{message_text(f'warning: {message}')}\n")


def _first_time(shown: set[str]) -> Callable[[logging.LogRecord], bool]:
    """Filter of warnings: whether their text is not yet in `shown`, to which it is added."""

    def new(record: logging.LogRecord) -> bool:
        text = record.getMessage()
        repeated = record.levelno >= logging.WARNING and text in shown
        shown.add(text)
        return not repeated

    return new


def _log_to_terminal(verbose: bool) -> None:
    handler = logging.StreamHandler(sys.stderr)
    handler.setLevel(logging.INFO if verbose else logging.WARNING)
    form = "%(levelname)s %(name)s: %(message)s" if verbose else "warning: %(message)s"
    handler.setFormatter(logging.Formatter(form))
    handler.addFilter(_first_time(set()))
    logging.basicConfig(handlers=[handler], level=handler.level)


if __name__ == "__main__":
    sys.exit(program())
