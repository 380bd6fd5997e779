"""Arrays of a dataset that are read, part by part, when they are used."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from xarray.backends import BackendArray
from xarray.core import indexing

Place = tuple[int | slice, ...]  # a number or slice along each dimension


class LazyArray(BackendArray):
    """An array of a shape and type; `read` returns the part at a place."""

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype, read: Callable[[Place], np.ndarray]) -> None:
        self.shape, self.dtype, self._read = shape, dtype, read

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)
