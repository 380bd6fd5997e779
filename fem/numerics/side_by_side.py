"""Two functions in parallel threads.

Long computations are divided into two fixed halves, so that results depend neither on the number of cores nor on which
half ends first. Two cores help while the code releases the interpreter lock: NumPy's matrix products, compiled loops
with `nogil`, and the calls of `fem.numerics.blas`. SciPy's wrappers of BLAS and LAPACK and its sparse products keep
the lock.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

One = TypeVar("One")
Other = TypeVar("Other")


def side_by_side(one: Callable[[], One], other: Callable[[], Other]) -> tuple[One, Other]:
    """The results of both; `other` runs in a second thread. Exceptions are raised here, that of `one` first."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        later = pool.submit(other)
        result = one()
    return result, later.result()
