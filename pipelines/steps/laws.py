"""Stage `law`: the mesh law of a gear pair, both flanks."""

from __future__ import annotations

from fem.contact.law import MeshLaw
from pipelines.plant.mesh_laws import LawSpec, mesh_laws


def build(spec: LawSpec) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank."""
    return mesh_laws(spec)
