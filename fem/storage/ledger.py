"""Build ledger: counts of expensive operations of the finite elements, for callers that request them.

The code that does the work calls ``count("factorisations")``. A caller collects the counts in a block `counting`;
without such a block `count` has no effect.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_OPEN: ContextVar[tuple[Counter[str], ...]] = ContextVar("open build ledgers", default=())


def count(name: str, number: int = 1) -> None:
    """Add a number to every open count."""
    for counts in _OPEN.get():
        counts[name] += number


@contextmanager
def counting() -> Iterator[Counter[str]]:
    """Collect the counts of the operations in the block."""
    counts: Counter[str] = Counter()
    token = _OPEN.set((*_OPEN.get(), counts))
    try:
        yield counts
    finally:
        _OPEN.reset(token)
