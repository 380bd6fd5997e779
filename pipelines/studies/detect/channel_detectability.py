"""Detectability at each channel alone: which sensor and axis distinguishes damaged from healthy machines best.

The detectability index of a feature is d' = (m1 - m0) / s0. Here m1 and m0 are the mean levels of damaged and healthy
machines, and s0 is the standard deviation of the healthy ones, at least LEAST_SPREAD as for p-values. A channel has the
index of its best feature of the damaged component, the same feature for all sizes of the damage.

References
----------
Green & Swets (1966), Signal Detection Theory and Psychophysics, ch. 3 (d').
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.diagnosis.deviation_statistics import LEAST_SPREAD
from pipelines.diagnosis.judge import damage_p
from pipelines.diagnosis.verdict import ALARM
from pipelines.signals.features.feature_table import FeatureTable
from pipelines.studies.detect.probability import Machines, Share, share


@dataclass(frozen=True, kw_only=True)
class DetectionChannel:
    """A sensor and axis alone.

    `index` is d' of its best feature, the mean over all sizes. `detected` is the share of damaged machines of all sizes
    that give an alarm.
    """

    sensor: str
    axis: str
    index: float
    component: str
    feature: str
    detected: Share


def channels(sizes: Sequence[Machines]) -> tuple[DetectionChannel, ...]:
    """All channels, the highest index first.

    Parameters
    ----------
    sizes : machines of each size of the damage and each load, all with the same channels and features, among them those
        of the damaged component
    """
    table = sizes[0].baseline[0]
    damaged = {component for component, _ in sizes[0].damaged[0][1]}
    own = [line for line, component in enumerate(table.component) if component in damaged]
    indices = np.mean([_indices(one) for one in sizes], axis=0)  # (channel, line)
    best = [own[int(np.argmax(indices[channel, own]))] for channel in range(len(table.sensor))]
    found = [
        DetectionChannel(
            sensor=table.sensor[channel],
            axis=table.axis[channel],
            index=float(indices[channel, line]),
            component=table.component[line],
            feature=table.feature[line],
            detected=_detected(sizes, channel),
        )
        for channel, line in enumerate(best)
    ]
    return tuple(sorted(found, key=lambda channel: -channel.index))


def _indices(machines: Machines) -> np.ndarray:
    """d' (channel, line) of the damaged machines over all healthy ones."""
    healthy = np.array([table.channel_levels for table in (*machines.baseline, *machines.healthy)])
    damaged = np.array([table.channel_levels for table, _ in machines.damaged])
    spread = np.maximum(healthy.std(axis=0, ddof=1), LEAST_SPREAD)
    return np.asarray((damaged.mean(axis=0) - healthy.mean(axis=0)) / spread)


def _detected(sizes: Sequence[Machines], channel: int) -> Share:
    """Share of damaged machines of all sizes that give an alarm at one channel alone."""
    found = []
    for machines in sizes:
        baseline = [_alone(table, channel) for table in machines.baseline]
        found += [damage_p(_alone(table, channel), baseline) <= ALARM for table, _ in machines.damaged]
    return share(found)


def _alone(table: FeatureTable, channel: int) -> FeatureTable:
    """The features at one channel."""
    return table.replaced(
        sensor=table.sensor[channel : channel + 1],
        axis=table.axis[channel : channel + 1],
        value=table.value[channel : channel + 1],
        retained=table.retained[channel : channel + 1],
        of_average=table.of_average[channel : channel + 1],
        repeating=table.repeating[channel : channel + 1],
    )
