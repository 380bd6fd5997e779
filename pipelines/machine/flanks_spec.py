"""Modifications, damage and wear of a gear pair, which change the mesh law of the healthy, unmodified pair."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fem.contact.faults.tooth_fault import ToothFault
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications


@dataclass(frozen=True, kw_only=True)
class FlanksSpec:
    """Changes of a healthy, unmodified gear pair: modifications, and damage and wear of each gear.

    Damage has one entry for each damaged tooth; wear consists of faults that all teeth have.
    """

    pair: GearPair
    modifications: PairModifications
    pinion_damage: tuple[tuple[ToothFault, ...], ...] = ()
    wheel_damage: tuple[tuple[ToothFault, ...], ...] = ()
    pinion_wear: tuple[ToothFault, ...] = ()
    wheel_wear: tuple[ToothFault, ...] = ()

    @property
    def faults(self) -> tuple[ToothFault, ...]:
        """All faults."""
        teeth = (*self.pinion_damage, *self.wheel_damage)
        return (*(fault for tooth in teeth for fault in tooth), *self.pinion_wear, *self.wheel_wear)

    @property
    def surfaces(self) -> tuple[tuple[str, float], ...]:
        """Gear ("pinion" or "wheel") and angle (rad) of each different crack surface."""
        teeth = (("pinion", self.pinion_damage), ("wheel", self.wheel_damage))
        found = ((gear, fault.surface_angle) for gear, damaged in teeth for tooth in damaged for fault in tooth)
        return tuple(dict.fromkeys((gear, angle) for gear, angle in found if angle is not None))

    @property
    def healthy(self) -> FlanksSpec:
        """The same pair with its modifications, without faults."""
        return replace(self, pinion_damage=(), wheel_damage=(), pinion_wear=(), wheel_wear=())

    @property
    def empty(self) -> bool:
        """Whether the pair has neither modifications nor faults."""
        return self.modifications.none and not self.faults
