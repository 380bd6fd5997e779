"""The share of a step that is done, from the place where the work goes on to whoever shows it.

A long loop says so as it goes, ``tell_share(0.25)``; without a listener that does nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_LISTENER: ContextVar[Callable[[float], None] | None] = ContextVar("listener of the share", default=None)


def tell_share(share: float) -> None:
    """Tell the listener that this share (0 to 1) of the step is done."""
    listener = _LISTENER.get()
    if listener is not None:
        listener(share)


@contextmanager
def listening(listener: Callable[[float], None]) -> Iterator[None]:
    """Have a function told the shares of what is built in the block."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)
