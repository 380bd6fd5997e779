"""Compiled functions that are stored on disk under a digest of their sources and called through their address.

The compiler links every called function into its caller and optimises both again, at each level of the calls and in
each entry point that is stored on disk. A large function with ten callers would be compiled ten times. A function that
is decorated with `by_address` is called in compiled code as usual, but its caller holds only a call through a memory
cell with a name. The cell is empty at first. The first call compiles the function, or reads it from disk, and fills
the cell. Each function is thus optimised once, and only if it is called. A call costs about 10 ns.

A `Signature` does the same for functions that are chosen at run time: the caller gets the address of the cell as a
number and need not know the functions.

Documented means of Numba cost more, in compiling of the first run of `minimal` and in a time step of the rig:
`register_jitable` instead of `inner_functions.inner` 26 % and 7 %, slices instead of `views` 6 % and 79 %, arrays with
counted references 5 % and 30 %. The undocumented parts that are used here are the same in Numba 0.60 to 0.68.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import gc
import hashlib
import inspect
import operator
import pickle
import re
import signal
import sys
import threading
import zlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

import llvmlite
import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.errors import RequireLiteralValue
from numba.core.serialize import dumps
from numba.extending import intrinsic, lower_builtin, models, register_model, typeof_impl
from numba.np.arrayobj import populate_array

from fem.numerics import compiled_files
from fem.numerics.inner_functions import COUNTED, NO_ENTRY, PLAIN, Inner

FLOAT, INTEGER = types.float64, types.int64
VECTOR, MATRIX, CUBE, HYPERCUBE = (types.Array(FLOAT, n, "C") for n in (1, 2, 3, 4))
INTEGERS, INTEGER_MATRIX = types.Array(INTEGER, 1, "C"), types.Array(INTEGER, 2, "C")

SPREAD: dict[str, Any] = {
    **PLAIN,
    "inline": "always",
}  # of functions that call many others
SUMS: dict[str, Any] = {"forceinline": True, "fastmath": {"contract", "reassoc", "nsz"}}  # terms in any order
_OBJECTS = 200_000  # made between two collections of garbage, which else take a sixth of the time of compiling
_kept: list[Any] = []  # compiled code refers to the cells as long as the process lives
_INDEX, _ADDRESS = ir.IntType(32), ir.IntType(8).as_pointer()
_CELL = ir.LiteralStructType((_ADDRESS, ir.FunctionType(ir.VoidType(), ()).as_pointer()))


class _Cell(ctypes.Structure):
    _fields_ = (("address", ctypes.c_void_p), ("fill", ctypes.c_void_p))


_IMPORT = re.compile(r"^(?:import +([\w.]+)|from +([\w.]+) +import +(\([^)]*\)|[^\n]*))", re.MULTILINE)
_COMPILED = re.compile(r"^from (?:numba|fem\.(?:\w+\.)?(?:compiled|inner)) import", re.MULTILINE)


@functools.cache
def reached(file: str) -> tuple[Path, ...]:
    """The source files that determine the compiled functions of ``file``.

    Compiled code uses functions and constants that its file imports at the top level. Imported files of these packages
    that hold compiled functions are searched in the same way.
    """
    root = Path(file)
    while (root.parent / "__init__.py").is_file():
        root = root.parent
    root, found, waiting = root.parent, {Path(__file__)}, [Path(file)]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found.add(path)
        text = path.read_text(encoding="utf-8")
        if path == Path(file) or _COMPILED.search(text):
            for plain, module, names in _IMPORT.findall(text):
                members = [f"{module}.{word}" for word in re.findall(r"\w+", names)]
                places = [root.joinpath(*name.split(".")).with_suffix(".py") for name in (plain or module, *members)]
                waiting += [place for place in places if place.is_file()]
    return tuple(sorted(found))


def stored(file: str, entry: bool = True, **options: Any) -> Callable:
    """`njit` in ``file`` (``__file__``) with a copy on disk that is used until one of its source files changes.

    The code is stored under the name of the function, to which the checksum of the files that are `reached` is added.
    Without ``entry``, only compiled code may call the function.
    """
    options = {**PLAIN, **COUNTED, **({} if entry else NO_ENTRY), **options}
    total = 0
    for path in reached(file):
        total = zlib.crc32(path.read_bytes(), total)

    def decorate(function: Callable) -> Any:
        function.__qualname__ = f"{function.__qualname__}_{total:08x}"
        dispatcher = njit(**options)(function)
        files, compile_unlocked = _Stored(function), dispatcher.compile

        def compile_once(signature: Any) -> Any:
            before = gc.get_threshold()
            gc.set_threshold(max(before[0], _OBJECTS), *before[1:])
            try:
                return compile_unlocked(signature)
            finally:
                gc.set_threshold(*before)
                files.unlock()

        dispatcher._cache, dispatcher.compile = files, compile_once
        return dispatcher

    return decorate


class _Stored:
    """Cache of one compiled function, as Numba's dispatcher uses it, in the files of `compiled_files`.

    Numba's own cache chooses a folder when the function is defined and stops the program if it cannot write there. It
    also reads files of other users and damaged files, and compiles a function that another process is compiling; here
    the second process waits and reads.
    """

    def __init__(self, function: Callable) -> None:
        self._function = f"{function.__module__}.{function.__qualname__}"
        self._lock: BinaryIO | None = None

    @property
    def cache_path(self) -> str:
        """Folder of the cache, for statistics."""
        return str(compiled_files.compiled_folder())

    def load_overload(self, signature: Any, target: Any) -> CompileResult | None:
        """The code for a signature. None if it must be compiled; other processes then wait until it is saved."""
        target.refresh()
        name, key = self._name_and_key(signature, target.codegen())
        content = compiled_files.read(name, key)
        if content is None:
            self._lock = compiled_files.lock(name)
            content = compiled_files.read(name, key)
        return None if content is None else CompileResult._rebuild(target, *pickle.loads(content))

    def save_overload(self, signature: Any, result: Any) -> None:
        """Store the code for a signature."""
        if result.library.has_dynamic_globals:
            raise TypeError(f"{self._function} holds addresses of this process and cannot be stored")
        compiled_files.write(*self._name_and_key(signature, result.codegen), dumps(result._reduce()))

    def unlock(self) -> None:
        """Let other processes read the code, or compile it if this one failed to."""
        if self._lock is not None:
            compiled_files.unlock(self._lock)
            self._lock = None

    def _name_and_key(self, signature: Any, codegen: Any) -> tuple[str, str]:
        made_by = (sys.version, numba.__version__, llvmlite.__version__, codegen.magic_tuple())
        key = repr((self._function, str(signature), made_by))
        function = self._function.replace("<locals>", "locals")
        return f"{function}-{hashlib.sha256(key.encode()).hexdigest()[:16]}.code", key


class _Linked(JITCodeLibrary):
    """The code of an `Inner`, which callers link and optimise with theirs. It has no separate machine code."""

    @property
    def codegen(self) -> _Linked:
        """The library itself: it has no environment."""
        return self

    def set_env(self, *_: Any) -> None:
        """Does nothing: there is no machine code."""

    def get_pointer_to_function(self, name: str) -> int:
        """0: there is no machine code."""
        return 0

    def finalize(self) -> None:
        """Add the code of the called functions."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


class _LinkedCompiler(Compiler):
    def __init__(self, typingctx: Any, targetctx: Any, library: None, *rest: Any) -> None:
        super().__init__(typingctx, targetctx, _Linked(targetctx.codegen(), "inner"), *rest)


@functools.cache
def _dispatcher_of(value: Inner) -> Any:
    return njit(pipeline_class=_LinkedCompiler, **value.options)(value.function)


@typeof_impl.register(Inner)
def _type_of_inner(value: Inner, _: Any) -> types.Type:
    return types.Dispatcher(_dispatcher_of(value))


class View(types.Array):
    """An array of `views`, in C order. Negative indices are not allowed, so that access needs a fifth of the code."""


register_model(View)(models.ArrayModel)


def _unsigned(function: Any, context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """Access to an array by unsigned indices, for which the compiler makes no code that counts from the end."""
    view, kind, *rest = signature.args
    own = types.UniTuple(types.uintp, kind.count) if isinstance(kind, types.UniTuple) else types.uintp
    index = context.cast(builder, values[1], kind, own)
    general = signature.return_type(types.Array(view.dtype, view.ndim, "C"), own, *rest)
    return context.get_function(function, general)(builder, (values[0], index, *values[2:]))


for _kind in (types.Integer, types.UniTuple):
    lower_builtin(operator.getitem, View, _kind)(functools.partial(_unsigned, operator.getitem))
    lower_builtin(operator.setitem, View, _kind, types.Any)(functools.partial(_unsigned, operator.setitem))


def _views(typingctx: Any, vector: Any, start: Any, count: Any, shape: Any) -> tuple[Any, Callable]:
    """Tuple of `count` arrays of one shape, which follow one another in a vector from its element `start` on.

    The arrays are valid as long as the caller keeps the vector, and must end within it. They need no memory. Where
    `start` and `shape` are constants, the compiler knows that the arrays do not overlap.
    """
    if not isinstance(count, types.IntegerLiteral):
        raise RequireLiteralValue("the number of views must be a literal")
    result = types.UniTuple(View(vector.dtype, shape.count, "C"), count.literal_value)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        data, place = context.make_array(vector)(context, builder, values[0]).data, values[1]
        sizes, strides = cgutils.unpack_tuple(builder, values[3]), [values[1].type(vector.dtype.bitwidth // 8)]
        for size in reversed(sizes[1:]):
            strides.insert(0, builder.mul(strides[0], size))
        total, arrays = functools.reduce(builder.mul, sizes), []
        for _ in range(result.count):
            array = context.make_array(result.dtype)(context, builder)
            where = builder.gep(data, [place])
            populate_array(array, data=where, shape=sizes, strides=strides, itemsize=strides[-1], meminfo=None)
            arrays.append(array._getvalue())
            place = builder.add(place, total)
        return context.make_tuple(builder, result, arrays)

    return result(vector, INTEGER, count, types.UniTuple(INTEGER, shape.count)), generate


views: Any = intrinsic(_views)


def by_address(result: types.Type, *arguments: types.Type) -> Callable:
    """Decorator that has compiled callers call a compiled function (the result of `njit`) through its address.

    The function takes `arguments` and returns `result`. If it cannot be compiled, the message of the compiler is
    printed and callers get a RuntimeError. ``compile()`` of the decorated function compiles it before the first call.
    """

    def decorate(function: Any) -> Callable:
        symbol = f"gearcase.{function.py_func.__module__}.{function.py_func.__name__}"
        llvm.add_symbol(symbol, _cell_of(function, arguments))
        called = _caller(symbol, result(*arguments), inspect.signature(function.py_func).parameters)
        called.compile = functools.partial(function.compile, arguments)
        return called

    return decorate


class Signature:
    """Functions with the same ``arguments`` and ``result``, of which the caller chooses one at run time.

    `cell` returns a number that represents a compiled function in this process. Compiled code calls the function by
    ``call(number, *arguments)``. Errors are those of `by_address`.
    """

    def __init__(self, result: types.Type, *arguments: types.Type) -> None:
        self._arguments = arguments
        parameters = ("cell", *(f"argument_{k}" for k in range(len(arguments))))
        self.call = _caller("", result(INTEGER, *arguments), parameters)

    def cell(self, function: Any) -> int:
        """The number that represents a compiled function (the result of `njit`) with this signature."""
        return _cell_of(function, self._arguments)


def _cell_of(function: Any, arguments: tuple[types.Type, ...]) -> int:
    """Address of a new cell; the first call through it compiles `function`."""
    cell = _Cell()

    @ctypes.CFUNCTYPE(None)
    def fill() -> None:
        with _interrupts_held():
            function.compile(arguments)
            code = function.overloads[arguments]
            cell.address = code.library.get_pointer_to_function(code.fndesc.llvm_func_name)

    cell.fill = ctypes.cast(fill, ctypes.c_void_p)
    _kept.append((cell, fill))
    return ctypes.addressof(cell)


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Delay Ctrl-C and SIGTERM until compiled code returns: an exception in a function that it calls is lost."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: held.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        if held:
            threading.Timer(0.01, signal.raise_signal, held[:1]).start()


def _caller(symbol: str, signature: Any, parameters: Iterable[str]) -> Any:
    """Function for compiled code: a call through the cell that the linker knows as `symbol`.

    Without a symbol, the first argument is the address of the cell.
    """

    def call(typingctx: Any, *_: types.Type) -> tuple[Any, Callable]:
        return signature, generate

    def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
        if not symbol:
            cell = builder.inttoptr(values[0], _CELL.as_pointer())
        elif symbol in builder.module.globals:
            cell = builder.module.globals[symbol]
        else:
            cell = ir.GlobalVariable(builder.module, _CELL, symbol)
        place, fill = (builder.gep(cell, [_INDEX(0), _INDEX(k)], inbounds=True) for k in (0, 1))
        with builder.if_then(_empty(builder, place), likely=False):
            builder.call(builder.load(fill), ())
            with builder.if_then(_empty(builder, place), likely=False):
                message = f"{symbol or 'a function chosen by its cell'} could not be compiled"
                context.call_conv.return_user_exc(builder, RuntimeError, (message,))
        own = slice(0 if symbol else 1, None)
        given = signature.return_type, signature.args[own]
        target = builder.bitcast(builder.load(place), context.call_conv.get_function_type(*given).as_pointer())
        status, answer = context.call_conv.call_function(builder, target, *given, values[own])
        with builder.if_then(status.is_error, likely=False):
            context.call_conv.return_status_propagate(builder, status)
        return answer

    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    names = [inspect.Parameter(name, kind) for name in ("typingctx", *parameters)]
    call.__signature__ = inspect.Signature(names)  # type: ignore[attr-defined]
    return intrinsic(call)


def _empty(builder: Any, place: Any) -> Any:
    return builder.icmp_unsigned("==", builder.load(place), _ADDRESS(None))
