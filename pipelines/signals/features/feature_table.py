"""Table of the features of a recording by channel (sensor, axis), component of the machine and feature."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fem.storage.records import Record, array, names
from pipelines.signals.features.definitions import BY_NAME, reference_value
from pipelines.signals.orders.speed_evidence import NO_SIDEBANDS

if TYPE_CHECKING:
    import xarray

WHOLE = "whole machine"  # features of the signal over time, which belong to no component


@dataclass(frozen=True, eq=False, kw_only=True)
class FeatureTable(Record):
    """Features of a recording; `value` is in the unit of the signal or dimensionless.

    A line is a feature of a component. `of_average` is the power of the average over turns in the envelope band, and
    `retained` its part that does not repeat with the shaft; 1 and 0 for features that are not of turns. `repeating` is
    the share of the whitened vibration that repeats with the shaft, 1 for features that are not of turns. `conditional`
    names the shaft of a line and the reason if its speed is conditional. `tooth` is the tooth of each `gear` that is in
    mesh when the strongest impact begins, which is significant only if the gear is damaged. `band_low` and `band_high`
    are the ends of the envelope band by `window`, `speed` is the mean speed of the first shaft. `left_out` are shafts
    with too few turns and bearing parts whose pass order is not resolved, with the reason.
    """

    sensor: tuple[str, ...] = names("channel")
    axis: tuple[str, ...] = names("channel")
    component: tuple[str, ...] = names("line")
    feature: tuple[str, ...] = names("line")
    value: np.ndarray = array("channel", "line", units="per feature")
    retained: np.ndarray = array("channel", "line", units="(m/s2)^2")
    of_average: np.ndarray = array("channel", "line", units="(m/s2)^2")
    repeating: np.ndarray = array("channel", "line", units="1")
    conditional: tuple[str, ...] = names("line")
    gear: tuple[str, ...] = names("gear")
    tooth: np.ndarray = array("gear", units="1", dtype=int)
    window: tuple[str, ...] = names("window")
    band_low: np.ndarray = array("window", units="Hz")
    band_high: np.ndarray = array("window", units="Hz")
    speed: np.ndarray = array("window", units="Hz")
    left_out: tuple[str, ...] = names("left_out")

    @property
    def channel_levels(self) -> np.ndarray:
        """20 log10 of the values (channel, line), dB."""
        return np.asarray(20.0 * np.log10(np.maximum(self.value, np.finfo(float).tiny)))

    @property
    def levels(self) -> np.ndarray:
        """The levels averaged over the channels (line,), dB."""
        return np.mean(self.channel_levels, axis=0)

    @property
    def lines(self) -> tuple[tuple[str, str], ...]:
        """Component and feature of every line."""
        return tuple(zip(self.component, self.feature, strict=True))

    def tooth_of(self, gear: str) -> int | None:
        """The tooth of a gear that is in mesh when an impact begins; None if its position is not known."""
        return int(self.tooth[self.gear.index(gear)]) if gear in self.gear else None

    def columns(self) -> dict[str, np.ndarray]:
        """A row for each channel and line as columns: names, value in its unit, and level (dB) over its reference.

        A feature that is not above 0 has no level (NaN).
        """
        count, rms = len(self.lines), self.value[:, self.lines.index((WHOLE, "rms"))]
        references = [[reference_value(name, one) for name in self.feature] for one in rms]
        level = np.full(self.value.shape, np.nan)
        np.log10(self.value / references, out=level, where=self.value > 0.0)
        named = {"component": self.component, "feature": self.feature, "unit": [BY_NAME[i].unit for i in self.feature]}
        return {
            "sensor": np.repeat(self.sensor, count),
            "axis": np.repeat(self.axis, count),
            **{name: np.tile(values, len(rms)) for name, values in named.items()},
            "value": self.value.ravel(),
            "level_dB": 20.0 * level.ravel(),
        }


def left_out_words(left_out: Sequence[str]) -> str:
    """A sentence with the names and reasons of `left_out`, names of one reason together; "" if it is empty."""
    names: dict[str, list[str]] = {}
    for name, _, reason in (one.partition(": ") for one in left_out):
        names.setdefault(reason, []).append(name)
    words = "; ".join(f"{', '.join(own)}: {reason}" for reason, own in names.items())
    return f"Not examined: {words}." if words else ""


def confirmed(tables: Sequence[FeatureTable]) -> list[FeatureTable]:
    """The tables of one machine without components of conditional speed, which are added to `left_out`.

    A recording in which two shafts have a known speed confirms their tooth numbers. In another recording that has a
    known speed of one of them, the speed of the other is then known, too, unless its sidebands have another spacing.
    """
    reasons = [dict(zip(table.component, table.conditional, strict=True)) for table in tables]
    known = [{name for name, reason in own.items() if not reason} - {WHOLE} for own in reasons]
    found = []
    for table, own, here in zip(tables, reasons, known, strict=True):
        also = set().union(*(other for other in known if here & other))
        left = {
            name: reason
            for name, reason in own.items()
            if reason and not (reason.endswith(NO_SIDEBANDS) and name in also)
        }
        dropped = {line for line in table.lines if line[0] in left}
        found.append(_without(table, dropped, tuple(dict.fromkeys(left.values()))))
    return found


def with_common_components(tables: Sequence[FeatureTable]) -> list[FeatureTable]:
    """The tables with the features that all of them have; the others are added to `left_out`.

    The reason for a shaft is that of the first recording that lacks it.
    """
    tables = confirmed(tables)
    common = set.intersection(*(set(table.lines) for table in tables))
    reasons = dict(one.split(": ", 1) for table in reversed(tables) for one in table.left_out)
    lacking: dict[str, list[str]] = {}  # features by component, of shafts that no recording lacks
    for component, feature in dict.fromkeys(line for table in tables for line in table.lines if line not in common):
        if not any(component in shaft for shaft in reasons):
            lacking.setdefault(component, []).append(BY_NAME[feature].words)
    unlike = tuple(f"{component}: not all recordings have its {', '.join(them)}" for component, them in lacking.items())
    found = []
    for table in tables:
        here = {one.partition(": ")[0] for one in table.left_out}
        elsewhere = tuple(f"{name}: in another recording {why}" for name, why in reasons.items() if name not in here)
        found.append(_without(table, set(table.lines) - common, (*unlike, *elsewhere)))
    return found


def _without(table: FeatureTable, lines: Container[tuple[str, str]], reasons: tuple[str, ...]) -> FeatureTable:
    """A table without lines, with the reasons."""
    kept = [number for number, line in enumerate(table.lines) if line not in lines]
    return replace(
        table,
        component=tuple(table.component[number] for number in kept),
        feature=tuple(table.feature[number] for number in kept),
        value=table.value[:, kept],
        retained=table.retained[:, kept],
        of_average=table.of_average[:, kept],
        repeating=table.repeating[:, kept],
        conditional=tuple(table.conditional[number] for number in kept),
        left_out=table.left_out + reasons,
    )


def labelled_array(values: Mapping[tuple[str, ...], float], dims: Sequence[str]) -> xarray.DataArray:
    """An array with named axes from values by their labels, in the order of the values; missing values are NaN."""
    import xarray

    known = [list(dict.fromkeys(labels)) for labels in zip(*values, strict=True)]
    out = np.full([len(labels) for labels in known], np.nan)
    for place, value in values.items():
        out[tuple(labels.index(label) for labels, label in zip(known, place, strict=True))] = value
    return xarray.DataArray(out, dims=dims, coords=dict(zip(dims, known, strict=True)))
