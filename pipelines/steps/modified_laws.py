"""Stage `flanks`: a mesh law with its flanks modified, its axes misaligned and its damaged teeth added as variants.

What is not there costs nothing: a stage without any of it has no such step. Only a cracked tooth needs finite elements.
"""

from __future__ import annotations

from fem.contact.law import MeshLaw
from fem.contact.wheels.damage import damaged_law, modified_law, wear_gap
from pipelines.plant.flanks_spec import FlanksSpec


def build(spec: FlanksSpec, sound: tuple[MeshLaw, MeshLaw]) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank."""
    drive, coast = (_flank(spec, law) for law in sound)
    return drive, coast


def _flank(spec: FlanksSpec, law: MeshLaw) -> MeshLaw:
    law = modified_law(law, spec.pair, spec.modifications)
    for gear, wears in (("pinion", spec.pinion_wear), ("wheel", spec.wheel_wear)):
        for wear in wears:
            law = law.replaced(gap=law.gap + wear_gap(law, spec.pair, gear, wear))
    for gear, teeth in (("pinion", spec.pinion_damage), ("wheel", spec.wheel_damage)):
        for damage in teeth:
            law = damaged_law(law, spec.pair, gear, damage)
    return law
