"""Trajectory: what a run returns, sampled at the output rate, with its books and counters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.records import Record, array, names, scalar, text
from fem.stored_array import StoredArray

TOTAL_LIMIT = 1e-6  # of all work of the sources
PART_LIMIT = 0.01  # of what a part dissipates, see `mbd.books`
ROUND_OFF = 1e-10  # of all work of the sources, and of the joule or so of strain that machines at rest hold


@dataclass(frozen=True, eq=False, kw_only=True)
class Trajectory(Record):
    """Channels over time; ``values[i]`` is the channel ``channel_names[i]`` in ``channel_units[i]``.

    `values` is an array, or a `StoredArray` that reads what it is asked for. `motors` to `sensors` name what the
    channels belong to, see `mbd.channels`.
    """

    integrator: str = text()
    time: np.ndarray = array("time", units="s")
    channel_names: tuple[str, ...] = names("channel")
    channel_units: tuple[str, ...] = names("channel")
    values: np.ndarray | StoredArray = array("channel", "time", units="per channel")
    motors: tuple[str, ...] = names("motor")
    shafts: tuple[str, ...] = names("shaft")
    meshes: tuple[str, ...] = names("mesh")
    bearings: tuple[str, ...] = names("bearing")
    sensors: tuple[str, ...] = names("sensor")
    step: float = scalar(units="s")
    step_error: float = scalar(units="1")  # estimated error of accelerations by the step, 0: no estimate
    output_rate: float = scalar(units="Hz")
    pass_band: float = scalar(units="Hz")  # flat up to here; above output_rate - pass_band removed
    counter_names: tuple[str, ...] = names("counter")
    counters: np.ndarray = array("counter", units="1")
    book_parts: tuple[str, ...] = names("part")
    book_columns: tuple[str, ...] = names("entry")
    books: np.ndarray = array("part", "entry", units="J")

    def channel(self, name: str) -> np.ndarray:
        """Values (time,) of one channel; KeyError with the known names if absent."""
        if name not in self.channel_names:
            raise KeyError(f"{name!r} is not a channel of this run; known: {', '.join(self.channel_names)}")
        return self.values[self.channel_names.index(name)]

    def counter(self, name: str) -> int:
        """One counter, e.g. ``"steps"``."""
        return int(self.counters[self.counter_names.index(name)])

    def book(self, part: str, entry: str) -> float:
        """One entry (J) of the energy book, e.g. ``("total", "residual")``."""
        return float(self.books[self.book_parts.index(part), self.book_columns.index(entry)])

    def open_parts(self) -> tuple[str, ...]:
        """Parts, and the total, whose energy book leaves a residual beyond its limit; none for a sound run."""
        floor = ROUND_OFF * max(1.0, self.book("total", "scale"))
        return tuple(
            part
            for part in self.book_parts
            if abs(self.book(part, "residual")) > max(_limit(part) * self.book(part, "scale"), floor)
        )

    def open_books(self) -> tuple[str, ...]:
        """A sentence for every one of `open_parts`."""
        return tuple(
            f"energy book of {part}: {self.book(part, 'residual'):.2g} J left over; limit {_limit(part):g} of "
            f"{self.book(part, 'scale'):.2g} J"
            for part in self.open_parts()
        )


def _limit(part: str) -> float:
    return TOTAL_LIMIT if part == "total" else PART_LIMIT
