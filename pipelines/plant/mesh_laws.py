"""Mesh laws by the model that a stage asks for. A missing tooth does not enter here."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair

if TYPE_CHECKING:
    from fem.contact.models.plane import Plane
    from fem.contact.models.solid import Solid
    from fem.gears.path import PathPoints


@dataclass(frozen=True, kw_only=True)
class LawSpec:
    """A gear pair and the rung of its law with options, 0 where the rung has none; `line_load` (N/m) is for `iso`."""

    pair: GearPair
    model: str  # "iso" | "energy" | "plane" | "solid"
    slices: int
    refinement: float
    positions: int
    line_load: float


def law_spec(
    pair: GearPair, model: str, *, slices: int, refinement: float, positions: int, line_load: float
) -> LawSpec:
    """The spec without what no law depends on: the play between the flanks, and the load of all rungs but `iso`."""
    return LawSpec(
        pair=replace(pair, backlash_allowance=0.0),
        model=model,
        slices=slices,
        refinement=refinement,
        positions=positions,
        line_load=line_load if model == "iso" else 0.0,
    )


def mesh_laws(spec: LawSpec) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank."""
    if spec.model == "iso":
        from fem.contact.models.iso import Iso

        iso = Iso(n_slices=spec.slices, line_load=spec.line_load or None)
        return iso.law(spec.pair, "drive"), iso.law(spec.pair, "coast")
    if spec.model == "energy":
        from fem.contact.models.energy import Energy

        return Energy(n_slices=spec.slices, positions=spec.positions).laws(spec.pair)
    return (_solid(spec) if spec.model == "solid" else _plane(spec)).laws(spec.pair)


def contact_path(spec: LawSpec) -> PathPoints:
    """The path of contact of a rung of finite elements, before any of them. RungError or GeometryError if it refuses
    its settings or the pair."""
    plane = _solid(spec).plane if spec.model == "solid" else _plane(spec)
    return plane.path(spec.pair)


def _plane(spec: LawSpec) -> Plane:
    from fem.contact.models.plane import Plane

    return Plane(n_slices=spec.slices, refinement=spec.refinement, positions=spec.positions)


def _solid(spec: LawSpec) -> Solid:
    from fem.contact.models.solid import Solid

    return Solid(n_slices=spec.slices, refinement=spec.refinement, positions=spec.positions)
