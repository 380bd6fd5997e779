"""Diagnosis of rolling bearings without healthy recordings, by impacts at pass orders.

A healthy bearing has no impacts at the pass orders of its races and rolling elements. Gears, shafts and cages modulate
the vibration of healthy machines as well, and cannot be diagnosed without a reference.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipelines.signals.features.feature_table import WHOLE, left_out_words
from pipelines.signals.features.passing import PASSING, SIDEBANDS

if TYPE_CHECKING:
    from pipelines.signals.features.feature_table import FeatureTable

CAGE = " FTF"  # end of the name of the pass order of a cage
CLEAR = 20.0  # dB; levels at orders of healthy elements in measured recordings are up to 18 dB, see docs/diagnosis.md


@dataclass(frozen=True, kw_only=True)
class Impacts:
    """Level (dB) of a pass order over the envelope spectrum around it, at the channel where it is highest."""

    component: str
    sensor: str
    axis: str
    level: float

    @property
    def clear(self) -> bool:
        """Whether the level reaches the limit for damage."""
        return self.level >= CLEAR


def in_race_or_element(component: str, feature: str) -> bool:
    """Whether a feature of a component is the level of impacts of a race or a rolling element."""
    return feature == PASSING and not component.endswith(CAGE)


def impacts(table: FeatureTable) -> tuple[Impacts, ...]:
    """Impacts at the pass orders of all races and rolling elements in a recording, the highest level first."""
    found = []
    for (component, feature), levels in zip(table.lines, table.value.T, strict=True):
        if in_race_or_element(component, feature):
            best = int(levels.argmax())
            level = 20.0 * math.log10(levels[best])
            found.append(Impacts(component=component, sensor=table.sensor[best], axis=table.axis[best], level=level))
    return tuple(sorted(found, key=lambda one: -one.level))


def impact_words(table: FeatureTable) -> str:
    """Sentences on the damage that impacts show, components that healthy recordings would add, and those left out."""
    found = impacts(table)
    others = [name for name, feature in table.lines if name != WHOLE and feature not in (PASSING, SIDEBANDS)]
    named = ", ".join(dict.fromkeys(others))
    more = f" Give healthy recordings to diagnose {named}: --baseline FILE FILE ..." if others else ""
    more += f" {left_out_words(table.left_out)}".rstrip()
    if not found:
        return f"There is no verdict without healthy recordings to compare with.{more}"
    first = found[0]
    named = " or ".join(one.component for one in found if one.level == first.level)  # equal bearings on one shaft
    answer = "Damaged:" if first.clear else "No damage of an examined part of a bearing is clear. The highest level:"
    return (
        f"{answer} {named}, impacts at its pass order {first.level:.0f} dB over the envelope spectrum around "
        f"it at {first.sensor} {first.axis} (limit {CLEAR:g} dB).{more}"
    )
