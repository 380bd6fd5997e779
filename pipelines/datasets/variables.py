"""Variables of a plan, and the conversion of numbers between 0 and 1 to their values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from pipelines.scene.tables.scene_table import Number, Table, Whole

MOST = 10_000  # values of a list, levels of a grid
NEAREST = 1e-15  # smallest distance of a share from 0 and 1, where a distribution may be infinite
Level = float | int | str | bool


class RangeTable(Table):
    """Any number in a range, or any whole number if both limits are whole."""

    from_: Annotated[Number | Whole, Field(alias="from", description="least value")]
    to: Annotated[Number | Whole, Field(description="largest value")]
    levels: Annotated[
        Whole | None, Field(ge=2, le=MOST, description="number of values from `from` to `to` in a grid")
    ] = None

    @model_validator(mode="after")
    def _rising(self) -> RangeTable:
        if self.to < self.from_:
            raise ValueError(f"to = {self.to:g} is less than from = {self.from_:g}; exchange them")
        return self

    @property
    def whole(self) -> bool:
        """True if only whole numbers are allowed."""
        return isinstance(self.from_, int) and isinstance(self.to, int)

    def at(self, shares: np.ndarray) -> list[Level]:
        """Values at the cumulative shares (n,), from 0 to below 1."""
        width = self.to - self.from_
        if self.whole:
            return (int(self.from_) + np.minimum(np.floor(shares * (width + 1)), width).astype(np.int64)).tolist()
        return (self.from_ + shares * width).tolist()

    def grid(self) -> list[Level]:
        """The values of a grid. ValueError if their number is not defined."""
        if self.whole and self.levels is None:
            return list(range(int(self.from_), int(self.to) + 1))
        if self.levels is None:
            raise ValueError("a grid needs a number of values; set levels, or give a list of values")
        steps = [self.from_ + (self.to - self.from_) * i / (self.levels - 1) for i in range(self.levels)]
        return list(dict.fromkeys(round(value) for value in steps)) if self.whole else [float(v) for v in steps]


class DistributionTable(Table):
    """A continuous distribution of scipy.stats with its parameters, truncated at `from` and `to` if given."""

    distribution: Annotated[
        str, Field(pattern=r"^[a-z][a-z0-9_]*$", description="name in scipy.stats, for example norm")
    ]
    parameters: Annotated[dict[str, Number], Field(default={}, description="of scipy.stats: loc, scale and shapes")]
    from_: Annotated[Number | None, Field(alias="from", description="least value")] = None
    to: Annotated[Number | None, Field(description="largest value")] = None

    @model_validator(mode="after")
    def _known(self) -> DistributionTable:
        found = self._frozen()
        low, high = self._limits(found)
        if not low < high:
            raise ValueError(f"{self.distribution} has no values from {self.from_} to {self.to}; correct the limits")
        return self

    def _frozen(self) -> Any:
        from scipy import stats

        found = getattr(stats, self.distribution, None)
        if not isinstance(found, stats.rv_continuous):
            raise ValueError(
                f"{self.distribution!r} is not a continuous distribution of scipy.stats; give one, for example norm"
            )
        try:
            frozen = found(**self.parameters)
            median = float(frozen.median())
        except TypeError as error:
            raise ValueError(f"{self.distribution} does not accept these parameters ({error}); correct them") from error
        if not math.isfinite(median):
            raise ValueError(f"{self.distribution} has no values with these parameters; correct them")
        return frozen

    def _limits(self, frozen: Any) -> tuple[float, float]:
        low = 0.0 if self.from_ is None else float(frozen.cdf(self.from_))
        return low, 1.0 if self.to is None else float(frozen.cdf(self.to))

    def at(self, shares: np.ndarray) -> list[Level]:
        """Values at the cumulative shares (n,), from 0 to below 1."""
        frozen = self._frozen()
        low, high = self._limits(frozen)
        return frozen.ppf(np.clip(low + shares * (high - low), NEAREST, 1.0 - NEAREST)).tolist()

    def grid(self) -> list[Level]:
        """Raise ValueError: a distribution has no grid."""
        raise ValueError("a distribution cannot be part of a grid; give a list of values, or set another design")


class ListTable(Table):
    """One of several values, all numbers or all texts, with a probability proportional to its weight."""

    values: Annotated[tuple[Level, ...], Field(min_length=1, max_length=MOST, description="numbers, or texts")]
    weights: Annotated[
        tuple[Number, ...] | None, Field(description="relative frequency of each value; if left out, equal")
    ] = None

    @model_validator(mode="after")
    def _alike(self) -> ListTable:
        kinds = {"text" if isinstance(v, str) else "flag" if isinstance(v, bool) else "number" for v in self.values}
        if len(kinds) > 1:
            raise ValueError("numbers, texts and true/false are mixed; give values of one kind")
        if len(set(self.values)) < len(self.values):
            raise ValueError("a value is given twice; set weights to make it more frequent")
        if self.weights is not None:
            if len(self.weights) != len(self.values):
                raise ValueError(
                    f"{len(self.weights)} weights for {len(self.values)} values; give one weight per value"
                )
            if min(self.weights) < 0.0 or not sum(self.weights) > 0.0:
                raise ValueError("weights must be 0 or more, and one above 0; correct them")
        return self

    def at(self, shares: np.ndarray) -> list[Level]:
        """Values at the cumulative shares (n,), from 0 to below 1."""
        ends = np.cumsum(self.weights or (1.0,) * len(self.values))
        places = np.searchsorted(ends, shares * ends[-1], side="right")
        last = int(np.searchsorted(ends, ends[-1]))  # later values have the weight 0
        return [self.values[place] for place in np.minimum(places, last)]

    def grid(self) -> list[Level]:
        """All values."""
        return list(self.values)


def _as_table(given: Any) -> Any:
    """The table for a plain list of values."""
    return {"values": given} if isinstance(given, list | tuple) else given


def _kind(given: Any) -> str:
    """The kind of a table, by its keys."""
    if isinstance(given, Table):
        return type(given).__name__
    keys = given if isinstance(given, Mapping) else ()
    return "DistributionTable" if "distribution" in keys else "ListTable" if "values" in keys else "RangeTable"


Variable = Annotated[
    Annotated[RangeTable, Tag("RangeTable")]
    | Annotated[DistributionTable, Tag("DistributionTable")]
    | Annotated[ListTable, Tag("ListTable")],
    Discriminator(_kind),
    BeforeValidator(_as_table),
]
