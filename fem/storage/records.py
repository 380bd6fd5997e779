"""Records: results whose arrays are checked (named dimensions that agree, no NaN) and written to HDF5.

A record declares each field once: ``array("slice", units="m")`` or ``scalar(units="N")``. On creation the base class
checks that dimensions of the same name have one length, refuses NaN and makes read-only copies. It writes and reads
HDF5 with dimension scales (netCDF-4 conventions, so xarray opens the file). An array that is too large for memory may
be a `StoredArray`, which stays in its file; its writer must ensure that it is finite.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Collection
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from fem.storage import shown_html
from fem.storage.hdf5_file import careful_file
from fem.storage.large_array_file import StoredArray

_NAMES_SHOWN = 6


class RecordError(ValueError):
    """A record field has the wrong shape, a NaN, or a file holds another kind of record."""


def array(*dims: str, units: str, dtype: type = float, infinite: bool = False) -> Any:
    """Field for an array.

    Parameters
    ----------
    *dims : names of its dimensions; in a record those of the same name have the same length
    units : "1" if none
    dtype : of its elements, e.g. int or np.int32
    infinite : values may be inf
    """
    return dataclasses.field(
        metadata={"kind": "array", "dims": dims, "units": units, "dtype": dtype, "infinite": infinite}
    )


def scalar(*, units: str, infinite: bool = False) -> Any:
    """Field for one float in ``units``."""
    return dataclasses.field(metadata={"kind": "scalar", "units": units, "infinite": infinite})


def integer() -> Any:
    """Field for one whole number."""
    return dataclasses.field(metadata={"kind": "integer"})


def text() -> Any:
    """Field for one string."""
    return dataclasses.field(metadata={"kind": "text"})


def names(dim: str) -> Any:
    """Field for a tuple of strings along the dimension ``dim`` (names of points, rows, coordinates)."""
    return dataclasses.field(metadata={"kind": "names", "dims": (dim,)})


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Record:
    """Base of all results passed between stages. Subclasses: ``@dataclass(frozen=True, eq=False, kw_only=True)``

    `plotted` names a field and others of the same unit, which a notebook plots over it.
    """

    plotted: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        sizes: dict[str, int] = {}
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, self._checked(field, getattr(self, field.name), sizes))

    def _checked(self, field: dataclasses.Field, value: Any, sizes: dict[str, int]) -> Any:
        where, meta = f"{type(self).__name__}.{field.name}", field.metadata
        kind = meta.get("kind")
        if kind == "text":
            return str(value)
        if kind == "integer":
            return int(value)
        if kind == "names":
            value = tuple(str(v) for v in value)
            _same_size(where, meta["dims"], (len(value),), sizes)
            return value
        if kind == "scalar":
            value = float(value)
            _finite(where, np.asarray(value), meta["infinite"])
            return value
        if kind != "array":
            raise RecordError(f"{where}: declare the field with array(), scalar(), integer(), text() or names()")
        stored = isinstance(value, StoredArray)
        if not stored:  # an array that its caller cannot edit: a copy unless it is one already
            sealed = isinstance(value, np.ndarray) and value.flags.owndata and not value.flags.writeable
            value = np.asarray(value, meta["dtype"]) if sealed else np.array(value, meta["dtype"])
        if value.ndim != len(meta["dims"]):
            raise RecordError(f"{where}: shape {value.shape} does not fit the dimensions {meta['dims']}")
        _same_size(where, meta["dims"], value.shape, sizes)
        if not stored:
            _finite(where, value, meta["infinite"])
            value.flags.writeable = False
        return value

    def replaced(self, **changes: Any) -> Self:
        """A new record with some fields changed."""
        return dataclasses.replace(self, **changes)

    def stored_arrays(self) -> dict[str, StoredArray]:
        """The fields that are stored in separate files."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return {name: value for name, value in values.items() if isinstance(value, StoredArray)}

    def in_memory(self) -> Self:
        """The same record with all arrays in memory."""
        return self.replaced(**{name: np.asarray(value) for name, value in self.stored_arrays().items()})

    def save(self, path: Path | str, *, without: Collection[str] = ()) -> None:
        """Write all fields but `without` to an HDF5 file that xarray opens. A file that fails is removed."""
        import h5py

        with careful_file(path) as disk, h5py.File(disk, "w") as file:
            file.attrs["record"] = type(self).__name__
            scales: dict[str, Any] = {}
            for field in dataclasses.fields(self):
                value, meta = getattr(self, field.name), field.metadata
                if field.name in without:
                    continue
                if meta["kind"] in ("scalar", "integer", "text"):
                    file.attrs[field.name] = value
                    continue
                if meta["kind"] == "names":
                    data = file.create_dataset(field.name, data=list(value), dtype=h5py.string_dtype())
                else:
                    data = file.create_dataset(field.name, data=value)
                    data.attrs["units"] = meta["units"]
                for axis, dim in enumerate(meta["dims"]):
                    if dim not in scales:
                        name = dim if dim not in {f.name for f in dataclasses.fields(self)} else f"{dim}_"
                        scales[dim] = file.create_dataset(name, data=np.arange(data.shape[axis]))
                        scales[dim].make_scale(name)
                    data.dims[axis].attach_scale(scales[dim])

    @classmethod
    def load(cls, path: Path | str, **apart: StoredArray) -> Self:
        """Read what `save` wrote; the keyword arguments are the fields that it omitted.

        Raises
        ------
        RecordError : the file holds another kind of record, or a field without a default is missing
        OSError : the file is not HDF5 or is truncated
        """
        import h5py

        with h5py.File(path, "r") as file:
            found = file.attrs.get("record")
            if found != cls.__name__:
                raise RecordError(f"{path}: holds a record {found!r}, expected {cls.__name__!r}")
            values: dict[str, Any] = dict(apart)
            for field in dataclasses.fields(cls):
                if field.name in apart:
                    continue
                stored_as_attribute = field.metadata["kind"] in ("scalar", "integer", "text")
                if field.name not in (file.attrs if stored_as_attribute else file):
                    if field.default is not dataclasses.MISSING:  # of a later version than the file
                        continue
                    raise RecordError(f"{path}: field {field.name!r} of {cls.__name__} is missing")
                if stored_as_attribute:
                    values[field.name] = file.attrs[field.name]
                elif field.metadata["kind"] == "names":
                    values[field.name] = [v.decode() for v in file[field.name][()]]
                else:
                    values[field.name] = read = file[field.name][()]
                    read.flags.writeable = False
        return cls(**values)

    def _repr_html_(self) -> str:
        """A table of the fields with their units, and a plot of the fields `plotted`, for a notebook."""
        fields = dataclasses.fields(self)
        rows = [(field.name, *_shown(field, getattr(self, field.name))) for field in fields]
        page = shown_html.table(type(self).__name__, ("field", "value", "shape", "unit"), rows)
        if not self.plotted:
            return page
        units = {field.name: field.metadata.get("units", "") for field in fields}
        across, *upwards = self.plotted
        drawn = {name: getattr(self, name) for name in upwards}
        return page + shown_html.curves(f"{across}, {units[across]}", getattr(self, across), units[upwards[0]], drawn)

    def digest(self) -> str:
        """SHA-256 over the names and contents of all fields."""
        total = hashlib.sha256(type(self).__name__.encode())
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            total.update(field.name.encode())
            if isinstance(value, np.ndarray | StoredArray):
                total.update(str((value.dtype.str, value.shape)).encode())
                rows = range(len(value)) if isinstance(value, StoredArray) else (...,)
                for row in rows:
                    total.update(np.ascontiguousarray(value[row]).tobytes())
            else:
                total.update(repr(value).encode())
        return total.hexdigest()


def _shown(field: dataclasses.Field, value: Any) -> tuple[str, str, str]:
    """Value or range, shape and unit of a field as text. Stored arrays are not read for it."""
    meta = field.metadata
    if meta["kind"] == "names":
        more = f", ... ({len(value)} names)" if len(value) > _NAMES_SHOWN else ""
        return ", ".join(value[:_NAMES_SHOWN]) + more, f"{meta['dims'][0]} {len(value)}", ""
    if meta["kind"] != "array":
        return shown_html.number(value) if meta["kind"] == "scalar" else str(value), "", meta.get("units", "")
    shape = " x ".join(f"{dim} {size}" for dim, size in zip(meta["dims"], value.shape, strict=True))
    if isinstance(value, StoredArray):
        return "in a file", shape, meta["units"]
    if not value.size:
        return "", shape, meta["units"]
    low, high = shown_html.number(value.min()), shown_html.number(value.max())
    return low if low == high else f"{low} to {high}", shape, meta["units"]


def _same_size(where: str, dims: tuple[str, ...], shape: tuple[int, ...], sizes: dict[str, int]) -> None:
    for dim, size in zip(dims, shape, strict=True):
        if sizes.setdefault(dim, size) != size:
            raise RecordError(f"{where}: length {size} along {dim!r}, other fields have {sizes[dim]}")


def _finite(where: str, value: np.ndarray, infinite: bool) -> None:
    if not np.issubdtype(value.dtype, np.inexact):
        return
    bad = np.isnan(value) if infinite else ~np.isfinite(value)
    if bad.any():
        place = tuple(int(i) for i in np.argwhere(bad)[0])
        raise RecordError(f"{where}: {int(bad.sum())} values are not finite, the first at index {place}")
