"""Compiled functions called through their address: one copy, made when first called, kept on disk by its sources."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import njit, types
from waiting import HANGING

from fem.compiled import FLOAT, INTEGER, VECTOR, apart, inner, sources, stored

MODULE = """
import sys
from pathlib import Path
import numpy as np
from numba import njit, types
from fem.compiled import FLOAT, INTEGER, VECTOR, apart, sources, stored
from factor import FACTOR, scaled
FILES = sources(Path(__file__), Path(__file__).with_name("factor.py"))

@apart(types.Tuple((FLOAT, INTEGER)), VECTOR, INTEGER)
@stored(FILES, entry=False)
def weighted(values, count):
    total = 0.0
    for i in range(count):
        total += scaled(values[i])
    return total, count

@stored(FILES)
def entry(values):
    total, count = weighted(values, len(values))
    return total / count

if __name__ == "__main__":
    import whole
    print(whole.entry(np.arange(5.0)), len(whole.entry.stats.cache_hits))
"""
FACTOR = """
from fem.compiled import inner
FACTOR = {}
@inner()
def scaled(value):
    return FACTOR * value
"""


@pytest.fixture
def program(tmp_path, monkeypatch):
    """A small program of two files; `start` runs it in a process of its own."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "stored"))
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[1]))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # by its time, a file changed within a second is the old one
    (tmp_path / "whole.py").write_text(MODULE, encoding="utf-8")

    def start(factor):
        (tmp_path / "factor.py").write_text(FACTOR.replace("{}", str(factor)), encoding="utf-8")
        return subprocess.Popen([sys.executable, str(tmp_path / "whole.py")], stdout=subprocess.PIPE, text=True)

    return start


def answer(process):
    printed, _ = process.communicate(timeout=HANGING)
    assert process.returncode == 0
    value, hits = printed.split()
    return float(value), int(hits)


def test_stored_code_is_used_until_a_source_changes(program):
    assert answer(program(3.0)) == (6.0, 0)
    assert answer(program(3.0)) == (6.0, 1)
    assert answer(program(4.0)) == (8.0, 0)  # only the file of the inner function changed


def test_two_processes_may_compile_at_once(program):
    assert [answer(process)[0] for process in (program(5.0), program(5.0))] == [10.0, 10.0]
    assert answer(program(5.0)) == (10.0, 1)


def test_a_function_apart_is_compiled_when_first_called():
    function = njit(_twice)
    twice = apart(types.UniTuple(FLOAT, 2), FLOAT, FLOAT)(function)

    @njit
    def caller(x, wanted):
        return twice(x, x + 1) if wanted else (0.0, 0.0)  # an integer in place of a number, too

    assert caller(3, False) == (0.0, 0.0)
    assert not function.overloads
    assert caller(3, True) == (6.0, 8.0)
    assert list(function.overloads) == [(FLOAT, FLOAT)]


def _twice(a, b):
    return 2.0 * a, 2.0 * b


def test_errors_of_the_function_and_of_its_compilation_reach_the_caller(monkeypatch):
    @njit
    def refuses(values, at):
        if at >= len(values):
            raise IndexError("beyond the end")
        return values[at]

    @njit
    def nonsense(x):
        return x.missing

    refuses_apart, nonsense_apart = apart(FLOAT, VECTOR, INTEGER)(refuses), apart(FLOAT, FLOAT)(nonsense)

    @njit
    def one(values, at):
        return refuses_apart(values, at)

    @njit
    def other(x):
        return nonsense_apart(x)

    assert one(np.ones(2), 1) == 1.0
    with pytest.raises(IndexError, match="beyond the end"):
        one(np.ones(2), 2)
    said = []
    monkeypatch.setattr(sys, "unraisablehook", lambda args: said.append(str(args.exc_value)))
    with pytest.raises(RuntimeError, match="nonsense could not be compiled"):
        other(1.0)
    assert "Unknown attribute 'missing'" in said[0]


def test_an_inner_function_runs_in_python_too():
    @inner(fastmath={"contract"})
    def square(x):
        return x * x

    @njit
    def cube(x):
        return square(x) * x

    assert square(3) == 9
    assert cube(3.0) == 27.0


def test_sources_lists_the_files_of_a_folder(tmp_path):
    (tmp_path / "b.py").touch()
    (tmp_path / "a.py").touch()
    (tmp_path / "notes.txt").touch()
    assert [path.name for path in sources(tmp_path)] == ["compiled.py", "a.py", "b.py"]
    changed = [stored((tmp_path / "a.py",))(_copy_of_twice()).py_func.__qualname__]
    (tmp_path / "a.py").write_text("x = 1", encoding="utf-8")
    changed += [stored((tmp_path / "a.py",))(_copy_of_twice()).py_func.__qualname__]
    assert changed[0] != changed[1]


def _copy_of_twice():
    def copy(a):
        return a

    return copy
