"""Stage `law`: the mesh law of a gear pair, both flanks."""

from __future__ import annotations

from dataclasses import dataclass

from fem.contact.law import MeshLaw
from fem.contact.models.mesh_model import MeshModel
from fem.gears.geometry import GearPair


@dataclass(frozen=True, kw_only=True)
class LawSpec:
    """A gear pair without its play, and the model of its law."""

    pair: GearPair
    mesh: MeshModel


def build(spec: LawSpec) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank."""
    return spec.mesh.laws(spec.pair)
