"""Functions for compiled callers, without the compiler: a file may define both options of a scene and such functions.

`fem.numerics.compiled` registers their type with the compiler.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

PLAIN: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
INLINE: dict[str, Any] = {"forceinline": True, "fastmath": {"contract"}}
NO_ENTRY: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
COUNTED: dict[str, Any] = {"_nrt": True}  # counts references to arrays, so that it can make and return them
UNCOUNTED: dict[str, Any] = {"_nrt": False}  # makes no arrays; the caller keeps those that it is given


class Inner:
    """A compiled function for compiled callers; called from Python, it runs as Python.

    Callers link its code and optimise it with theirs. It cannot make arrays, see UNCOUNTED.
    """

    def __init__(self, function: Callable, **options: Any) -> None:
        self.function = function
        self.options = {**PLAIN, **NO_ENTRY, **UNCOUNTED, **options}
        functools.update_wrapper(self, function)

    def __call__(self, *values: Any) -> Any:
        return self.function(*values)


def inner(**options: Any) -> Callable:
    """`njit` without the entry from Python, which is half of a small function's code or of one that takes tables."""
    return functools.partial(Inner, **options)
