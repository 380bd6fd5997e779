"""A call in a process of its own: its result, its exception, its crash and what it prints."""

import ctypes
import logging
import operator
import os
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from fem.processes import own_process
from fem.processes.own_process import bounded, call_in_own_process

FILE = Path("any.step")


class TornError(Exception):
    """What the caller wants to be told."""


def apart(call, *arguments):
    return call_in_own_process("any.step: the library that reads it", TornError, "export it again", call, *arguments)


def test_the_result_is_that_of_the_call():
    assert np.array_equal(apart(np.cumsum, np.arange(4)), [0, 1, 3, 6])
    assert apart(os.getpid) != os.getpid()


def test_an_exception_is_the_same_exception():
    with pytest.raises(ZeroDivisionError):
        apart(operator.truediv, 1, 0)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")
@pytest.mark.parametrize(("call", "arguments", "how"), [(os.abort, (), "SIGABRT"), (ctypes.string_at, (0,), "SIGSEGV")])
def test_a_crash_is_an_exception_with_the_file_and_the_remedy(call, arguments, how, capfd):
    with pytest.raises(TornError, match=rf"^any.step: the library that reads it crashed \({how}\); export it again$"):
        apart(call, *arguments)
    assert capfd.readouterr() == ("", "")


def test_what_is_printed_past_python_goes_to_the_log(capfd, caplog):
    with caplog.at_level(logging.INFO):
        apart(os.system, "echo a library speaks && echo and complains >&2")
    assert capfd.readouterr() == ("", "")
    assert "library: a library speaks" in caplog.text
    assert "library: and complains" in caplog.text


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not hold a process to its limit")
def test_reading_a_small_file_cannot_take_all_memory(tmp_path):
    """A table of 30 GB is refused inside, and room is as before behind."""
    import resource

    (tmp_path / "a.brep").write_bytes(b"small")
    before = resource.getrlimit(resource.RLIMIT_AS)
    with bounded(tmp_path / "a.brep"), pytest.raises(MemoryError):
        np.empty(30 << 30, np.uint8)
    assert resource.getrlimit(resource.RLIMIT_AS) == before


def read_without_end(file):
    own_process._SECONDS = 0.2
    with bounded(file):
        time.sleep(60.0)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")
def test_reading_without_end_is_ended(tmp_path):
    (tmp_path / "a.brep").write_bytes(b"small")
    with pytest.raises(
        TornError, match=r"^any.step: the library that reads it did not end in its time; export it again$"
    ):
        apart(read_without_end, tmp_path / "a.brep")
