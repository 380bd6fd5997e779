"""Quantities of a design: objectives and limits by name, with their statistic over the deviations."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fem.contact.evaluation.mesh_cycle import ORDERS
from pipelines.io.errors import InputError
from pipelines.io.shown_text import nearest_name, shown
from pipelines.steps.flank_candidates import LOADED, CandidateResults

NOMINAL = "nominal"
STATISTICS: dict[str, Callable[[np.ndarray], np.ndarray]] = {  # of (candidate, sample), the nominal pair first
    NOMINAL: lambda values: values[:, 0],
    "mean": lambda values: values[:, 1:].mean(axis=1),
    "q90": lambda values: np.quantile(values[:, 1:], 0.9, axis=1),
    "worst": lambda values: values[:, 1:].max(axis=1),
}
LEVEL, RATIO_ERROR = "level", "ratio-error"
UNITS = {"pressure": "MPa", "root-stress": "MPa", "load-factor": "", LEVEL: "m/s2", RATIO_ERROR: "%"}
NAMES = ("te", "te-max", *(f"te{order}" for order in range(1, ORDERS + 1)), *LOADED, LEVEL, RATIO_ERROR)
_LIMIT = re.compile(r"\s*([\w:-]+)\s*<=\s*([-+.\w]+)\s*")


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A quantity and its statistic over the samples.

    te, te-max: peak-to-peak transmission error, mean and largest over the torques; te1, te2, ...: amplitude of a mesh
    order, mean over the torques; those of `LOADED`: at the greatest torque; level, level-SENSOR: rms acceleration of
    all sensors or of one, at the orders of the mesh frequency, root mean square over the torques;
    ratio-error: of z2/z1 from that of the scene
    """

    name: str
    statistic: str

    @property
    def label(self) -> str:
        """Name with unit, for tables."""
        unit = UNITS.get(LEVEL if self.of_level else self.name, "um")
        words = self.name if self.statistic == NOMINAL else f"{self.name} {self.statistic}"
        return f"{words} {unit}".strip()

    @property
    def of_level(self) -> bool:
        """Whether it needs the response of the sensors."""
        return self.name.partition("-")[0] == LEVEL

    def of(self, found: CandidateResults) -> np.ndarray:
        """Values (candidate,) in the unit of the label."""
        return np.asarray(STATISTICS[self.statistic](self.samples(found)))

    def samples(self, found: CandidateResults) -> np.ndarray:
        """Values (candidate, sample) in the unit of the label."""
        if self.name in found.loaded:
            return found.loaded[self.name] / (1e6 if UNITS[self.name] == "MPa" else 1.0)
        if self.of_level:
            at = [n for n, one in enumerate(found.sensors) if self.name in (LEVEL, f"{LEVEL}-{one}")]
            return np.asarray(np.sqrt((found.levels[..., at] ** 2).mean(axis=(2, 3))))
        if self.name == "te-max":
            return 1e6 * found.peak_to_peak.max(axis=2)
        if self.name == "te":
            return 1e6 * found.peak_to_peak.mean(axis=2)
        return 1e6 * found.orders[..., int(self.name[2:]) - 1].mean(axis=2)


@dataclass(frozen=True, kw_only=True)
class Limit:
    """A quantity and its largest allowed value."""

    quantity: Quantity
    most: float


def parse_quantity(text: str, sensors: Sequence[str] = (), *, sampled: bool) -> Quantity:
    """`NAME` or `NAME:STATISTIC`; without a statistic the 90 % quantile if there are samples, else the nominal value.

    `sensors` are the names of the sensors of the scene.

    Raises
    ------
    InputError : an unknown name or statistic, a statistic without samples
    """
    name, colon, statistic = text.partition(":")
    statistic = statistic if colon else "q90" if sampled else NOMINAL
    names = (*NAMES, *(f"{LEVEL}-{one}" for one in sensors))
    if not sensors and name.partition("-")[0] == LEVEL:
        raise InputError(
            f'{shown(text)}: no sensor is at a known speed. Set [[sensors]], a casing.model other than "none", '
            'drive.model = "speed", and simulation.output_rate_Hz to at least 2.5 times the mesh frequency.'
        )
    for word, known, what in ((name, names, "quantity"), (statistic, STATISTICS, "statistic")):
        if word not in known:
            near = nearest_name(word, known)
            hint = f"Did you mean {near}? " if near else ""
            raise InputError(f"{shown(text)}: {shown(word)!r} is not a {what}. {hint}Choose one of {', '.join(known)}.")
    if statistic != NOMINAL and not sampled:
        raise InputError(f"{shown(text)}: there are no deviations to take the {statistic} of. Set --samples 20.")
    return Quantity(name=name, statistic=statistic)


def parse_limit(text: str, sensors: Sequence[str] = (), *, sampled: bool) -> Limit:
    """`NAME[:STATISTIC] <= NUMBER`.

    Raises
    ------
    InputError : as `parse_quantity`, or not of this form
    """
    parts = _LIMIT.fullmatch(text)
    try:
        most = float(parts[2]) if parts else math.nan
    except ValueError:
        most = math.nan
    if parts is None or not math.isfinite(most):
        raise InputError(f'--limit "{shown(text)}": is not a limit. Write --limit "pressure <= 1200".')
    return Limit(quantity=parse_quantity(parts[1], sensors, sampled=sampled), most=most)
