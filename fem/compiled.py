"""Compiled functions that are called through their address: optimised once, and only if they are called at all.

The compiler links whatever a function calls into it and optimises the whole again, at every level of the calls and in
every entry point that is stored on disk: a large function called from ten places is compiled ten times. What `apart`
returns is called in compiled code like the function itself, but the caller holds no more than a call through a cell of
memory, which it knows by name. The cell is empty at first; the first call has the function compiled, or read from disk,
and the cell filled. A call costs about 10 ns.
"""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_kept: list[Any] = []  # compiled code refers to the cells as long as the process lives
_ADDRESS = ir.IntType(8).as_pointer()
_FILL = ir.FunctionType(ir.VoidType(), ()).as_pointer()


class _Cell(ctypes.Structure):
    _fields_ = (("address", ctypes.c_void_p), ("fill", ctypes.c_void_p))


def apart(name: str, function: Any, result: types.Type, arguments: tuple[types.Type, ...]) -> Callable:
    """The compiled `function` (what `njit` returns), to be called through its address by compiled code.

    Parameters
    ----------
    name : unlike that of any other such function
    function : takes `arguments` and returns `result`; stored on disk if it is made with ``cache=True``

    Raises (in the calling code)
    ----------------------------
    RuntimeError : the function could not be compiled; what the compiler said was printed
    """
    cell = _Cell()

    @ctypes.CFUNCTYPE(None)
    def fill() -> None:
        function.compile(arguments)
        code = function.overloads[arguments]
        cell.address = code.library.get_pointer_to_function(code.fndesc.llvm_func_name)

    cell.fill = ctypes.cast(fill, ctypes.c_void_p)
    _kept.append((cell, fill))
    symbol = f"gearcase.{name}"
    llvm.add_symbol(symbol, ctypes.addressof(cell))

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        held = ir.LiteralStructType((_ADDRESS, _FILL))
        if symbol not in builder.module.globals:
            ir.GlobalVariable(builder.module, held, symbol)
        place = builder.module.globals[symbol]
        address = cgutils.gep_inbounds(builder, place, 0, 0)
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(address))):
            builder.call(builder.load(cgutils.gep_inbounds(builder, place, 0, 1)), ())
            with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(address))):
                context.call_conv.return_user_exc(builder, RuntimeError, (f"{symbol} could not be compiled",))
        kind = context.call_conv.get_function_type(signature.return_type, signature.args).as_pointer()
        target = builder.bitcast(builder.load(address), kind)
        status, answer = context.call_conv.call_function(
            builder, target, signature.return_type, signature.args, values
        )
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return answer

    def call(typingctx: Any, *_: types.Type) -> tuple[Any, Callable]:
        return result(*arguments), generate

    own = list(inspect.signature(function.py_func).parameters.values())
    first = inspect.Parameter("typingctx", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    call.__signature__ = inspect.Signature([first, *own])  # type: ignore[attr-defined]
    return intrinsic(call)
