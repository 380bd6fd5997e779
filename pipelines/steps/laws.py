"""Step `law`: the mesh law of a gear pair, both flanks."""

from __future__ import annotations

from fem.contact.law import MeshLaw
from fem.contact.models.mesh_model import LawSpec


def build(spec: LawSpec) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank."""
    return spec.laws()
