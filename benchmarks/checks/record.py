"""Check: one published or exact number, or a few of one kind, and the library's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

Values = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Check:
    """A row of docs/validation.md, its fields in the order of the page.

    `reference` in `unit`; `compute` returns as many values of the library. The deviation is the largest of
    |ours / reference - 1| or of |ours - reference|, and must stay below `gate`. `test` is the test that asserts it, as
    "file::function".
    """

    quantity: str
    source: str
    unit: str
    reference: tuple[float, ...]
    gate: float
    compute: Callable[[], Values]
    test: str
    kind: Literal["relative", "absolute"] = "relative"

    def deviation(self, ours: Values) -> float:
        """The largest deviation, in parts of the reference or in `unit`."""
        if len(ours) != len(self.reference):
            raise ValueError(f"{self.quantity}: {len(ours)} values for {len(self.reference)} references")
        pairs = zip(ours, self.reference, strict=True)
        if self.kind == "relative":
            return max(abs(value / exact - 1.0) for value, exact in pairs)
        return max(abs(value - exact) for value, exact in pairs)

    def shown(self, value: float) -> str:
        """A deviation or gate as text."""
        return f"{100 * value:.2g} %" if self.kind == "relative" else f"{value:.2g} {self.unit}".strip()


@dataclass(frozen=True)
class Subject:
    """A table of docs/validation.md; `cheap` ones take less than about a second and are computed again by the tests."""

    title: str
    checks: tuple[Check, ...]
    cheap: bool = True


def numbers(values: Values) -> str:
    """Values of a cell."""
    return "; ".join(f"{value:.7g}" for value in values)
