"""Stage `flanks`: a mesh law with its flanks modified, its axes misaligned and its damaged teeth added as variants.

What is not there costs nothing: a stage without any of it has no such step. Only a cracked tooth needs finite elements.
"""

from __future__ import annotations

from dataclasses import dataclass

from fem.contact.faults.changed_law import damaged_law, evenly_damaged_law, modified_law
from fem.contact.faults.tooth_fault import ToothFault
from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications


@dataclass(frozen=True, kw_only=True)
class FlanksSpec:
    """Everything that is added to the law of a sound, unmodified pair, by gear: damage, one entry for each damaged
    tooth, and faults that all teeth have."""

    pair: GearPair
    modifications: PairModifications
    pinion_damage: tuple[tuple[ToothFault, ...], ...] = ()
    wheel_damage: tuple[tuple[ToothFault, ...], ...] = ()
    pinion_wear: tuple[ToothFault, ...] = ()
    wheel_wear: tuple[ToothFault, ...] = ()

    @property
    def empty(self) -> bool:
        """True when nothing is added."""
        return self.modifications.none and not self.faults

    @property
    def faults(self) -> tuple[ToothFault, ...]:
        """All faults."""
        teeth = (*self.pinion_damage, *self.wheel_damage)
        return (*(fault for tooth in teeth for fault in tooth), *self.pinion_wear, *self.wheel_wear)


def build(spec: FlanksSpec, sound: tuple[MeshLaw, MeshLaw]) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank."""
    drive, coast = (_flank(spec, law) for law in sound)
    return drive, coast


def _flank(spec: FlanksSpec, law: MeshLaw) -> MeshLaw:
    law = modified_law(law, spec.pair, spec.modifications)
    for gear, common in (("pinion", spec.pinion_wear), ("wheel", spec.wheel_wear)):
        for fault in common:
            law = evenly_damaged_law(law, spec.pair, gear, fault)
    for gear, teeth in (("pinion", spec.pinion_damage), ("wheel", spec.wheel_damage)):
        for faults in teeth:
            law = damaged_law(law, spec.pair, gear, faults)
    return law
