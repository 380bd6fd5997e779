"""Build ledger: counts of the expensive things that finite elements do, kept by whoever asks for them.

The code that does the work says so at the place where it is done, ``count("factorisations")``; a caller that wants to
know opens a count around it. Without an open one counting does nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_OPEN: ContextVar[tuple[Counter[str], ...]] = ContextVar("open build ledgers", default=())


def count(name: str, number: int = 1) -> None:
    """Enter a thing done into every open count."""
    for counts in _OPEN.get():
        counts[name] += number


@contextmanager
def counting() -> Iterator[Counter[str]]:
    """Counts of what is done while the block runs."""
    counts: Counter[str] = Counter()
    token = _OPEN.set((*_OPEN.get(), counts))
    try:
        yield counts
    finally:
        _OPEN.reset(token)
