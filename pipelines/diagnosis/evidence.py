"""Evidence of components: how far groups of features of a recording deviate from those of healthy recordings.

Each order of a shaft is a group, since unbalance raises the first order only. A gear has two groups, features of the
whitened signal and all others. Whitening shows small damage that flank deviations mask, but it removes an increase of
the level. Features of the whole signal are not evidence of a component.

Damage of a gear repeats with its shaft, impacts of a bearing do not. But an average over N revolutions retains 1/N of
their power, and they raise all features of gears. Let A be the power of the average, n the part of it that does not
repeat with the shaft, and n_h the largest n of the healthy recordings. The evidence of a gear counts by

    1 - 2 (n - n_h)/A,     at least 0 and at most 1,     with the mean of (n - n_h)/A over the channels.

So it counts completely if the average retains no more than in healthy recordings, and not at all if half of its power
is more than that. This also applies to a shaft whose gears are not known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipelines.diagnosis.deviation_statistics import (
    FEWEST_FOR_P,
    LEAST_SPREAD,
    at_speed,
    deviations,
    limit,
    moderated,
    probability,
)
from pipelines.diagnosis.impacts import CLEAR, in_race_or_element
from pipelines.signals.features.feature_table import WHOLE, FeatureTable
from pipelines.signals.features.passing import SIDEBANDS
from pipelines.signals.features.recording_features import OF_SHAFT, OF_WHITENED

LEAST_ORDER = -40.0  # dB over the rms of healthy recordings; weaker orders of a shaft are no evidence
_OVER_HEALTHY = 6.0  # dB, least level of clear impacts over every healthy recording


class HealthyReference:
    """Healthy recordings of one machine, as arrays over (recording, channel, line).

    `levels` (dB) contain little of weak orders of a shaft, see `counted`. `groups` are component and numbers of the
    lines of each group, `first_lines` the first of each. `shares` are those of the vibration that repeats with the
    shaft, in the mean over the channels (recording, line).
    """

    def __init__(self, baseline: Sequence[FeatureTable]) -> None:
        self._feature, lines = baseline[0].feature, baseline[0].lines
        levels = np.array([one.channel_levels for one in baseline])
        self._rms = levels[:, :, lines.index((WHOLE, "rms"))].mean(axis=0)
        self.levels = counted(levels, self._feature, self._rms)
        self.shares = np.array([one.repeating.mean(axis=0) for one in baseline])
        self._speeds = np.array([one.speed.mean() for one in baseline])
        self._retained = np.array([one.retained for one in baseline])
        groups: dict[tuple[str, str | bool], list[int]] = {}
        for number, (component, feature) in enumerate(lines):
            if component != WHOLE:
                kind = feature if feature in OF_SHAFT or feature == SIDEBANDS else feature in OF_WHITENED
                groups.setdefault((component, kind), []).append(number)
        self.groups = [(component, own) for (component, _), own in groups.items()]
        self.first_lines = [own[0] for own in groups.values()]

    def features(self, lines: Sequence[int]) -> tuple[str, ...]:
        """Names of the features of some lines."""
        return tuple(self._feature[i] for i in lines)

    def evidence(self, table: FeatureTable, accepted: np.ndarray) -> GroupEvidence:
        """The evidence of a recording, compared with `accepted` healthy ones (accepted,), numbers from 0."""
        more = np.maximum(table.retained - self._retained[accepted].max(axis=0), 0.0)
        share = np.divide(more, table.of_average, out=np.zeros_like(more), where=more > 0.0).mean(axis=0)
        return GroupEvidence(
            reference=self,
            levels=counted(table.channel_levels, self._feature, self._rms),
            healthy=at_speed(self.levels[accepted], self._speeds[accepted], float(table.speed.mean())),
            weight=np.maximum(1.0 - 2.0 * share, 0.0)[self.first_lines],
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class GroupEvidence:
    """Deviations of a recording from healthy ones, by channel and line or group of a reference.

    `levels` (channel, line) and `healthy` (recording, channel, line) are in dB, the latter at the speed of the
    recording. `weight` (group,) is the factor of the evidence by repetition. With fewer than FEWEST_FOR_P healthy
    recordings there are no deviations.
    """

    reference: HealthyReference
    levels: np.ndarray
    healthy: np.ndarray
    weight: np.ndarray

    @property
    def enough(self) -> bool:
        """Whether the healthy recordings are enough for limits."""
        return len(self.healthy) >= FEWEST_FOR_P

    @cached_property
    def rises(self) -> np.ndarray:
        """Levels (channel, line) over the healthy mean, dB."""
        return np.asarray(self.levels - self.healthy.mean(axis=0))

    @cached_property
    def of_lines(self) -> tuple[np.ndarray, int]:
        """Deviations (channel, line) and the prior degrees of freedom d0 of `moderated`."""
        spread, prior = self._moderated
        return deviations(self.levels, self.healthy, spread), prior

    @cached_property
    def of_groups(self) -> tuple[np.ndarray, int]:
        """Deviations (channel, group) of the means over groups, weighted by repetition, and d0 of these means."""
        spread, _ = self._moderated
        centred = self._means((self.healthy - self.healthy.mean(axis=0)) / spread)
        kinds = [" ".join(self.reference.features(own)) for _, own in self.reference.groups]
        together, prior = moderated(centred, kinds, 1.0)
        return self.weight * deviations(self._means(self.rises / spread), centred, together) + 0.0, prior  # no -0

    @cached_property
    def clear(self) -> np.ndarray:
        """Whether groups (channel, group) are clear impacts of a bearing that no healthy recording has."""
        lines = self.reference.first_lines
        named = zip(self.reference.groups, self.reference.features(lines), strict=True)
        impacts = [in_race_or_element(component, feature) for (component, _), feature in named]
        over = (self.levels - self.healthy.max(axis=0))[:, lines]
        return np.asarray(np.array(impacts) & (self.levels[:, lines] >= CLEAR) & (over >= _OVER_HEALTHY))

    @cached_property
    def p(self) -> np.ndarray:
        """p-values (channel, group) of damage, corrected for their number, 0 for clear impacts."""
        deviation, prior = self.of_groups
        columns = [
            probability(column, len(self.healthy), prior, len(own))
            for column, (_, own) in zip(deviation.T, self.reference.groups, strict=True)
        ]
        return np.where(self.clear, 0.0, np.minimum(np.stack(columns, axis=1) * deviation.size, 1.0))

    @property
    def p_damaged(self) -> float:
        """Probability that any component of a healthy machine has as strong evidence."""
        return float(self.p.min())

    @property
    def p_different(self) -> float:
        """Probability that a healthy machine deviates as much to either side in any feature, or has such evidence."""
        deviation, prior = self.of_lines
        alone = float(probability(np.abs(deviation).max(), len(self.healthy), prior))
        return min(2.0 * min(2.0 * deviation.size * alone, self.p_damaged), 1.0)

    def limits(self, chance: float) -> list[float]:
        """Deviation of each group that a healthy machine exceeds at any channel and group with a probability."""
        deviation, prior = self.of_groups
        each = chance / deviation.size
        return [limit(each, len(self.healthy), prior, len(own)) for _, own in self.reference.groups]

    @cached_property
    def _moderated(self) -> tuple[np.ndarray, int]:
        return moderated(self.healthy, self.reference.features(range(self.levels.shape[-1])), LEAST_SPREAD)

    def _means(self, values: np.ndarray) -> np.ndarray:
        """Sums (..., group) of values (..., line), each divided by the square root of the size of the group."""
        groups = self.reference.groups
        return np.stack([values[..., own].sum(axis=-1) / math.sqrt(len(own)) for _, own in groups], axis=-1)


def counted(levels: np.ndarray, features: Sequence[str], rms: np.ndarray) -> np.ndarray:
    """Levels (..., feature), dB, for a diagnosis: the power at LEAST_ORDER is added to that of an order of a shaft.

    Lines that hardly contribute to the vibration, or consist of noise, then scatter little. The maximum of the level
    and LEAST_ORDER is not suitable: levels just below it would be equal in all healthy recordings, without any scatter,
    and the next recording may exceed it.

    Parameters
    ----------
    levels : (..., feature), dB
    features : names
    rms : level (...) of the healthy vibration, dB
    """
    least = np.where(np.isin(features, list(OF_SHAFT)), np.asarray(rms)[..., None] + LEAST_ORDER, -np.inf)
    neper = math.log(10.0) / 10.0  # of powers, per dB
    with np.errstate(invalid="ignore"):  # the level of a feature that a recording lacks is NaN
        return np.asarray(np.logaddexp(levels * neper, least * neper) / neper)
