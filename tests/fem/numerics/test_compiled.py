"""Compiled functions called through their address: one copy, made when first called, kept on disk by its sources."""

import importlib
import importlib.util
import os
import shutil
import signal
import stat
import subprocess
import sys
import threading
import types as types_of_python
from pathlib import Path

import numpy as np
import pytest
from numba import njit, types
from numba.core.dispatcher import Dispatcher
from numba.core.errors import NumbaError
from sources import ROOT
from time_limit import HANGING

from fem.numerics import compiled, compiled_files
from fem.numerics.compiled import FLOAT, INTEGER, VECTOR, Signature, by_address, reached, stored, views
from fem.numerics.inner_functions import Inner, inner
from fem.storage.cache_folder import CacheWarning
from pipelines.engine.code_version import reachable
from pipelines.engine.storage import class_modules
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.steps.machine_steps import machine_steps

posix = pytest.mark.skipif(os.name != "posix", reason="owners and modes as POSIX has them")

MODULE = """
import sys
import numpy as np
from numba import njit, types
from fem.numerics.compiled import FLOAT, INTEGER, VECTOR, by_address, stored
from factor import FACTOR, scaled

@by_address(types.Tuple((FLOAT, INTEGER)), VECTOR, INTEGER)
@stored(__file__, entry=False)
def weighted(values, count):
    total = 0.0
    for i in range(count):
        total += scaled(values[i])
    return total, count

@stored(__file__)
def entry(values):
    total, count = weighted(values, len(values))
    return total / count

if __name__ == "__main__":
    import whole
    print(whole.entry(np.arange(5.0)), len(whole.entry.stats.cache_hits))
"""
FACTOR = """
from fem.numerics.inner_functions import inner
FACTOR = {}
@inner()
def scaled(value):
    return FACTOR * value
"""


@pytest.fixture
def program(tmp_path, monkeypatch):
    """A small program of two files; `start` runs it in a process of its own."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "stored"))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # by its time, a file changed within a second is the old one
    (tmp_path / "whole.py").write_text(MODULE, encoding="utf-8")

    def start(factor):
        (tmp_path / "factor.py").write_text(FACTOR.replace("{}", str(factor)), encoding="utf-8")
        command = [sys.executable, str(tmp_path / "whole.py")]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    return start


def answer(process, said=""):
    """The value and how often stored code served; on standard error stands nothing, or once what is `said`."""
    printed, complaints = process.communicate(timeout=HANGING)
    assert process.returncode == 0, complaints
    assert complaints.count("CacheWarning") == (1 if said else 0), complaints
    assert said in complaints
    value, hits = printed.split()
    return float(value), int(hits)


def test_of_two_processes_at_once_one_compiles_and_the_other_waits_for_its_code(program, tmp_path):
    assert sorted(answer(process) for process in (program(5.0), program(5.0))) == [(10.0, 0), (10.0, 1)]
    assert answer(program(5.0)) == (10.0, 1)
    assert not list(tmp_path.rglob("*.lock"))


def test_a_process_compiles_itself_what_another_one_failed_to(program, tmp_path):
    (tmp_path / "factor.py").write_text(FACTOR.replace("{}", "5.0"), encoding="utf-8")
    code = "import whole; whole.entry('no vector')"
    broken = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, check=False)
    assert b"numba" in broken.stderr
    assert not list((tmp_path / "stored").rglob("*.lock"))
    assert answer(program(5.0)) == (10.0, 0)


def stored_files(folder):
    return {path.name.partition("_")[0]: path for path in folder.rglob("*.code")}


def test_code_is_kept_under_the_cache_root_for_its_owner_alone_until_a_source_changes(program, tmp_path, monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("GEARCASE_CACHE", str(tmp_path / "cache"))
    assert answer(program(3.0)) == (6.0, 0)
    assert set(stored_files(tmp_path / "cache" / "compiled")) == {"whole.entry", "whole.weighted"}
    assert answer(program(3.0)) == (6.0, 1)
    assert not list(tmp_path.rglob("*.nb?"))  # what the compiler itself would have written
    if os.name == "posix":
        folders = [tmp_path / "cache", *(p for p in (tmp_path / "cache").rglob("*") if p.is_dir())]
        assert {stat.S_IMODE(folder.stat().st_mode) for folder in folders} == {0o700}
    assert answer(program(4.0)) == (8.0, 0)  # only the file of the inner function changed


def test_without_a_place_to_write_code_is_compiled_in_memory_and_that_is_said_once(program, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("GEARCASE_CACHE", str(tmp_path / "file" / "cache"))
    assert answer(program(3.0), said="set GEARCASE_CACHE to a folder that can be written") == (6.0, 0)


@pytest.mark.slow
@pytest.mark.parametrize("harm", ["flip", "cut", "swap", "empty"])
def test_damaged_code_is_compiled_again(program, tmp_path, harm):
    assert answer(program(3.0)) == (6.0, 0)
    files = stored_files(tmp_path / "stored")
    content = bytearray(files["whole.entry"].read_bytes())
    content[len(content) // 2] ^= 1
    half = content[: len(content) // 2]
    put = {"flip": content, "cut": half, "swap": files["whole.weighted"].read_bytes(), "empty": b""}[harm]
    files["whole.entry"].write_bytes(put)
    assert answer(program(3.0), said="is damaged. It is compiled again") == (6.0, 0)
    assert answer(program(3.0)) == (6.0, 1)


@pytest.mark.slow
@posix
@pytest.mark.parametrize("which", ["folder", "file"])
def test_code_that_others_could_have_written_is_not_run(program, tmp_path, which):
    assert answer(program(3.0)) == (6.0, 0)
    file = stored_files(tmp_path / "stored")["whole.entry"]
    (file if which == "file" else file.parent).chmod(0o777)
    assert answer(program(3.0), said="can be written by other users (mode 777)") == (6.0, 0)


def test_a_users_own_compiled_functions_are_left_alone(tmp_path, monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    (tmp_path / "own.py").write_text("from numba import njit\n@njit(cache=True)\ndef f(x):\n    return x\n")
    (tmp_path / "main.py").write_text("import fem.contact.evaluation.kernel, own\nprint(own.f.stats.cache_path)")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(tmp_path / "main.py")]
    printed = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert Path(printed.strip()) == tmp_path / "__pycache__"


def test_a_full_disk_does_not_stop_the_run(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    compiled_files.write("f.code", "key", b"code")
    assert compiled_files.read("f.code", "key") == b"code"
    monkeypatch.setattr(os, "replace", full)
    with pytest.warns(CacheWarning, match="No space left"):
        compiled_files.write("f.code", "key", b"other code")
    assert [path.name for path in compiled_files.compiled_folder().iterdir()] == ["f.code"]
    assert compiled_files.read("f.code", "key") == b"code"


def test_a_function_called_by_address_is_compiled_when_first_called():
    function = njit(_twice)
    twice = by_address(types.UniTuple(FLOAT, 2), FLOAT, FLOAT)(function)

    @njit
    def caller(x, wanted):
        return twice(x, x + 1) if wanted else (0.0, 0.0)  # an integer in place of a number, too

    assert caller(3, False) == (0.0, 0.0)
    assert not function.overloads
    assert caller(3, True) == (6.0, 8.0)
    assert list(function.overloads) == [(FLOAT, FLOAT)]


def test_one_of_several_functions_is_chosen_by_its_number():
    """Functions of one signature, picked while the caller runs; only what is called is compiled."""
    signature = Signature(FLOAT, FLOAT)
    functions = [njit(lambda x: x + 1.0), njit(lambda x: 3.0 * x), njit(lambda x: -x)]
    cells = np.array([signature.cell(function) for function in functions])
    call = signature.call

    @njit
    def total(cells, x):
        found = 0.0
        for cell in cells:
            found += call(cell, x)
        return found

    assert total(cells[:2], 5.0) == 21.0
    assert total(cells[1:2], 5.0) == 15.0
    assert [len(function.overloads) for function in functions] == [1, 1, 0]


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

    refuses_called, nonsense_called = by_address(FLOAT, VECTOR, INTEGER)(refuses), by_address(FLOAT, FLOAT)(nonsense)

    @njit
    def one(values, at):
        return refuses_called(values, at)

    @njit
    def other(x):
        return nonsense_called(x)

    assert one(np.ones(2), 1) == 1.0
    with pytest.raises(IndexError, match="beyond the end"):
        one(np.ones(2), 2)
    said = []
    monkeypatch.setattr(sys, "unraisablehook", lambda args: said.append(str(args.exc_value)))
    with pytest.raises(RuntimeError, match="nonsense could not be compiled"):
        other(1.0)
    assert "Unknown attribute 'missing'" in said[0]


def test_views_stand_one_behind_the_other_in_a_vector():
    @njit
    def filled(numbers, rows):
        first, second, third = views(numbers, 1, 3, (rows, 2))
        first[0, 1], second[rows - 1, 0], third[0, 0] = 1.0, 2.0, 3.0
        return first.shape, second[rows - 1].sum() + numbers[0]

    numbers = np.zeros(20)
    assert filled(numbers, 3) == ((3, 2), 2.0)
    assert np.flatnonzero(numbers).tolist() == [1 + 1, 1 + 6 + 4, 1 + 12]


def test_elements_and_rows_of_a_view_are_read_and_written():
    @njit
    def swapped(numbers, i, j):
        (view,) = views(numbers, 2, 1, (2, 3, 4))
        view[i, j, 3] += view[1, 2, i] - view[0, 0, j]
        view[0, 1] = view[1, 2]
        return view[1].sum(), view[i, j].sum(), view[i, j, 3]

    numbers = np.arange(26.0)
    cube = numbers[2:].reshape(2, 3, 4).copy()
    cube[1, 0, 3] += cube[1, 2, 1] - cube[0, 0, 0]
    cube[0, 1] = cube[1, 2]
    assert swapped(numbers, 1, 0) == (cube[1].sum(), cube[1, 0].sum(), cube[1, 0, 3])
    assert np.array_equal(numbers[2:], cube.ravel())


def test_an_inner_function_cannot_make_an_array():
    @inner()
    def made(n):
        return np.zeros(n)

    @njit
    def total(n):
        return made(n).sum()

    with pytest.raises(NumbaError, match="Only accept returning of array passed"):
        total(3)


def test_an_inner_function_runs_in_python_too():
    @inner(fastmath={"contract"})
    def square(x):
        return x * x

    @njit
    def cube(x):
        return square(x) * x

    assert square(3) == 9
    assert cube(3.0) == 27.0


def called_files(function, seen):
    """Files of everything that a compiled function can take from its globals, directly or not."""
    own = getattr(function, "py_func", function)
    own = getattr(own, "__wrapped__", own)
    if own in seen or not hasattr(own, "__code__"):
        return
    seen[own] = Path(own.__code__.co_filename)
    names = set(own.__code__.co_names)
    for name, value in own.__globals__.items():
        if name not in names:
            continue
        members = [value]
        if isinstance(value, types_of_python.ModuleType):
            members = [getattr(value, word, None) for word in names]
        for member in members:
            if isinstance(member, Dispatcher | Inner):
                called_files(member, seen)


def called_by(module):
    """Files of ours that the compiled functions of a module are made of."""
    seen = {}
    for value in list(vars(importlib.import_module(module)).values()):
        if isinstance(value, Dispatcher | Inner):
            called_files(value, seen)
    return {path.resolve() for path in seen.values() if ROOT in path.resolve().parents}


COMPILED = ["mbd.integrators.modal_loop", "mbd.elements.newton", "mbd.forces.flank", "mbd.forces.rope"]


@pytest.mark.parametrize("module", COMPILED)
def test_the_key_of_a_motion_holds_every_file_of_its_compiled_code(module):
    simulate = machine_steps(make_machine(load_scene("rig-healthy").scene))[-1]
    parts = (simulate.build.__module__, *simulate.modules, *class_modules(simulate.spec))
    read = {Path(importlib.util.find_spec(name).origin).resolve() for name in reachable(*parts)}
    assert called_by(module) <= read


@pytest.mark.parametrize("module", COMPILED[:3])
def test_every_file_that_compiled_code_calls_counts_for_its_copy_on_disk(module, tmp_path):
    """In a copy: the files are found by their imports in whatever folder, and an edit of any of them changes the name
    under which the code is stored."""
    loaded, called = importlib.import_module(module), called_by(module)
    assert len(called) > 1
    assert called <= set(reached(loaded.__file__))
    for package in ("fem", "mbd"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    copy = tmp_path / Path(loaded.__file__).relative_to(ROOT)
    names = {stored(str(copy))(_copy_of_twice()).py_func.__qualname__}
    for number, path in enumerate(sorted(called), 2):
        edited = tmp_path / path.relative_to(ROOT)
        edited.write_text(edited.read_text(encoding="utf-8") + "\n# edited\n", encoding="utf-8")
        names.add(stored(str(copy))(_copy_of_twice()).py_func.__qualname__)
        assert len(names) == number, f"{path.name} does not count"


def _copy_of_twice():
    def copy(a):
        return a

    return copy


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_arrives_while_code_is_compiled_is_handled_after_it(number):
    handled = threading.Event()
    before = signal.signal(number, lambda *_: handled.set())
    try:
        with compiled._interrupts_held():
            signal.raise_signal(number)
            assert not handled.is_set()
        assert any(handled.wait(0.01) for _ in range(500))
    finally:
        signal.signal(number, before)
