"""What the first screen of a report holds: the verdict, the numbers and two figures it rests on, and the ranking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class Average:
    """A time-synchronous average over one turn of a shaft, at rising places.

    `reference` is that of the healthy control, None if there is none; `marked` the stretch of places that the suspected
    tooth takes, None without a suspicion, and `marked_name` words for it.
    """

    place: np.ndarray  # (n,), deg or teeth
    value: np.ndarray  # (n,), in `unit`
    reference: np.ndarray | None = None  # (n,), in `unit`
    across: str  # what `place` is, with its unit: "tooth of the stage 1 wheel in mesh"
    unit: str
    marked: tuple[float, float] | None = None
    marked_name: str = ""
    caption: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Envelope:
    """An envelope spectrum; `marked` are lines (place, label) that the verdict reads, `band` the words for its band."""

    line: np.ndarray  # (n,), order or Hz
    amplitude: np.ndarray  # (n,), in `unit`
    reference: np.ndarray | None = None  # (n,), in `unit`
    across: str  # what `line` is, with its unit
    unit: str
    marked: Sequence[tuple[float, str]] = ()
    band: str
    caption: str


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """A component with its evidence in dB and its p-value ("-" where there is none)."""

    component: str
    evidence: float
    p_value: str
    remark: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class FirstScreen:
    """What stands before everything else; parts that a run does not have are left out.

    `sentences` are the verdict, the answer first; `found` says whether a fault is seen, None if nothing was looked for;
    `label` says what was compared with, such as "against 8 healthy recordings". `figures` are names with their values:
    f_m, f_r, speed. `ranking_note` explains the columns of the ranking.
    """

    sentences: Sequence[str] = ()
    found: bool | None = None
    label: str = ""
    figures: Sequence[tuple[str, str]] = ()
    average: Average | None = None
    envelope: Envelope | None = None
    ranking: Sequence[Ranked] = ()
    ranking_note: str = ""
