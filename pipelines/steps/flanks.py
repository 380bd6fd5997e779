"""Step `flanks`: the mesh law of a gear pair with what its flanks and teeth have added to it.

These are modified flanks, misaligned axes, and damaged teeth as variants. What is not there costs nothing: a stage
without any of it has no step `flanks`. Only a cracked tooth needs finite elements: those of its crack surface, which
another step condenses, or, for models that have none, of the section with the crack.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fem.contact.faults.changed_law import damaged_law, modified_law
from fem.contact.law import MeshLaw
from pipelines.machine.flanks_spec import FlanksSpec

if TYPE_CHECKING:
    from fem.contact.wheels.crack_surface import CrackSurface


def build_modified(
    spec: FlanksSpec, *, unmodified: tuple[MeshLaw, MeshLaw], surfaces: Sequence[CrackSurface] = ()
) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank; `surfaces` are those of the spec, or none."""
    known: dict[str, dict[float, CrackSurface]] = {"pinion": {}, "wheel": {}}
    for (gear, angle), surface in zip(spec.surfaces if surfaces else (), surfaces, strict=True):
        known[gear][angle] = surface
    drive, coast = (_flank(spec, law, known) for law in unmodified)
    return drive, coast


def _flank(spec: FlanksSpec, law: MeshLaw, surfaces: Mapping[str, Mapping[float, CrackSurface]]) -> MeshLaw:
    law = modified_law(law, spec.pair, spec.modifications)
    for gear, common in (("pinion", spec.pinion_wear), ("wheel", spec.wheel_wear)):
        for fault in common:
            law = law.replaced(gap=law.gap + fault.gap(law, spec.pair, gear))  # on all teeth, constant along the face
    for gear, teeth in (("pinion", spec.pinion_damage), ("wheel", spec.wheel_damage)):
        for faults in teeth:
            law = damaged_law(law, spec.pair, gear, faults, surfaces[gear])
    return law
