"""Check: one published or exact number, or a few of one kind, and the library's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

Values = Sequence[float]


@dataclass(frozen=True, kw_only=True)
class Check:
    """A row of docs/validation.md.

    `reference` in `unit`; `compute` returns as many values of the library. The deviation is the largest of
    |ours / reference - 1| or of |ours - reference|, and must stay below `gate`. `test` is the test that asserts it, as
    "file::function". `cheap` checks take less than about a second together and are computed again by the tests.
    """

    subject: str
    quantity: str
    source: str
    unit: str
    reference: tuple[float, ...]
    gate: float
    compute: Callable[[], Values]
    test: str
    kind: Literal["relative", "absolute"] = "relative"
    cheap: bool = True

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


def numbers(values: Values) -> str:
    """Values of a cell."""
    return "; ".join(f"{value:.7g}" for value in values)
