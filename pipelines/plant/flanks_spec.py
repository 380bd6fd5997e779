"""What is added to the mesh law of a sound, unmodified gear pair."""

from __future__ import annotations

from dataclasses import dataclass

from fem.gears.faults import Damage, WornTooth
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications


@dataclass(frozen=True, kw_only=True)
class FlanksSpec:
    """Everything that is added to the law of a sound, unmodified pair; damage by gear, one entry for each tooth."""

    pair: GearPair
    modifications: PairModifications
    pinion_damage: tuple[tuple[Damage, ...], ...] = ()
    wheel_damage: tuple[tuple[Damage, ...], ...] = ()
    pinion_wear: tuple[WornTooth, ...] = ()
    wheel_wear: tuple[WornTooth, ...] = ()

    @property
    def empty(self) -> bool:
        """True when nothing is added."""
        return self.modifications.none and not (
            self.pinion_damage or self.wheel_damage or self.pinion_wear or self.wheel_wear
        )
