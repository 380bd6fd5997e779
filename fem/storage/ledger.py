"""Build ledger: counts of the expensive things that finite elements do, kept by whoever asks for them.

The code that does the work says so at the place where it is done, ``count("factorisations")``; a caller that wants to
know opens a book around it. Without an open book counting does nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_BOOKS: ContextVar[tuple[Counter[str], ...]] = ContextVar("open build ledgers", default=())


def count(name: str, number: int = 1) -> None:
    """Enter a thing done into every open book."""
    for book in _BOOKS.get():
        book[name] += number


@contextmanager
def counting() -> Iterator[Counter[str]]:
    """A book of what is done while the block runs."""
    book: Counter[str] = Counter()
    token = _BOOKS.set((*_BOOKS.get(), book))
    try:
        yield book
    finally:
        _BOOKS.reset(token)
