"""Table of lines: one row for each line of a case and window, with the levels of the faulty run and of its control."""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from fem.storage.records import Record, array, names

IN_ENVELOPE = ("envelope", "bearing", "pass")  # kinds of lines of the envelope; all others are of the spectrum
LOADS = {
    "rope": "rope load",
    "static-torque": "constant torque",
    "torque": "torque load",
}  # by load_case, as shown
RESOLUTION = 1e-9  # m/s2; smaller amplitudes are replaced by it, so that a line of an error-free run has a finite level


@dataclass(frozen=True, eq=False, kw_only=True)
class LineTable(Record):
    """Columns along the lines. Levels are 20 log10 of amplitude ratios, flags are 0 or 1.

    `kind` is one of

    - "envelope": k f_r in the envelope
    - "sideband": n f_m + k f_r in the spectrum
    - "mesh": n f_m in the spectrum, for reference, no evidence
    - "bearing": a pass frequency of a bearing in the envelope, at the nearest bin, for reference, no evidence
    - "pass": a line of a spalled bearing in the envelope (order: its harmonic), the largest bin in the range of slip
    - "shaft": an order of a faulty shaft in the spectrum, the largest of the three bins around it
    """

    load_case: tuple[str, ...] = names("line")  # "rope" | "static-torque"
    deviations: tuple[str, ...] = names("line")  # "off" | "seed 1" ...
    window: tuple[str, ...] = names("line")
    kind: tuple[str, ...] = names("line")
    label: tuple[str, ...] = names("line")
    order: np.ndarray = array("line", units="1", dtype=int)  # k
    mesh_harmonic: np.ndarray = array("line", units="1", dtype=int)  # n, 0 in the envelope
    frequency: np.ndarray = array("line", units="Hz")
    faulty: np.ndarray = array("line", units="m s-2")
    healthy: np.ndarray = array("line", units="m s-2")
    faulty_floor: np.ndarray = array("line", units="m s-2")
    healthy_floor: np.ndarray = array("line", units="m s-2")
    difference: np.ndarray = array("line", units="dB")  # faulty over healthy
    over_floor: np.ndarray = array("line", units="dB")  # faulty over its local floor
    healthy_over_floor: np.ndarray = array("line", units="dB")
    detected: np.ndarray = array("line", units="1", dtype=int)
    rope_mode: np.ndarray = array("line", units="Hz")  # 0: no rope
    near_rope: np.ndarray = array("line", units="1", dtype=int)  # the rope mode is within the width of this line

    def __len__(self) -> int:
        return len(self.label)

    def where(self, **equal: Any) -> Self:
        """The rows whose columns equal the given values, e.g. ``table.where(load_case="rope", kind="sideband")``."""
        keep = [i for i in range(len(self)) if all(getattr(self, name)[i] == value for name, value in equal.items())]
        return self.at(keep)

    def of(self, *kinds: str) -> Self:
        """The rows of the given kinds."""
        return self.at([i for i, kind in enumerate(self.kind) if kind in kinds])

    def at(self, keep: Sequence[int]) -> Self:
        """The rows of these numbers."""
        rows = np.array(keep, dtype=int)
        return self.replaced(**{name: np.asarray(column)[rows] for name, column in self._columns().items()})

    def _columns(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    def units(self) -> dict[str, str]:
        """Unit of every column, "" for text."""
        return {field.name: field.metadata.get("units", "") for field in dataclasses.fields(self)}

    def to_dicts(self) -> list[dict[str, Any]]:
        """One dict per row with plain Python values, for JSON."""
        columns = {name: np.asarray(column).tolist() for name, column in self._columns().items()}
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    def write_csv(self, path: Path | str) -> Path:
        """Write all rows; the header names each column with its unit."""
        path = Path(path)
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow([f"{name} [{unit}]" if unit else name for name, unit in self.units().items()])
            writer.writerows(row.values() for row in self.to_dicts())
        return path


def joined(tables: Iterable[LineTable]) -> LineTable:
    """All rows of several tables, in their order."""
    tables = tuple(tables)
    fields = [field.name for field in dataclasses.fields(LineTable)]
    columns: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in tables]) for name in fields}
    return LineTable(**columns)


def level(amplitude: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """20 log10(amplitude / reference) in dB; amplitudes below `RESOLUTION` are replaced by it."""
    return 20 * np.log10(np.maximum(amplitude, RESOLUTION) / np.maximum(reference, RESOLUTION))
