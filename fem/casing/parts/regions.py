"""Parts of a meshed housing: the elements whose centre is in a box.

Elements in no region form the rest of the housing. Mounts under the feet and bolted joints are also parts, but without
elements (`fem.casing.parts.casing_choices`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.casing.mesh.mesh import MeshError
from fem.elements.solid_elements import solid_element


@dataclass(frozen=True, kw_only=True)
class Region:
    """A box (m), open on the sides whose corners are infinite."""

    name: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]


def elements_inside(nodes: np.ndarray, elements: np.ndarray, regions: Sequence[Region]) -> list[np.ndarray]:
    """Numbers of the elements of every region.

    Parameters
    ----------
    nodes, elements : of the mesh, (n, 3) in m and (e, k)
    regions : boxes

    Raises
    ------
    MeshError : a region without elements, or an element in two of them
    """
    middle = nodes[elements[:, : solid_element(elements).corners]].mean(axis=1)
    inside = [((middle > region.low) & (middle < region.high)).all(axis=1) for region in regions]
    for number, (region, chosen) in enumerate(zip(regions, inside, strict=True)):
        if not chosen.any():
            raise MeshError(f"casing part {region.name}: no element lies in it; correct its box")
        for other, taken in zip(regions[:number], inside[:number], strict=True):
            if both := int((chosen & taken).sum()):
                raise MeshError(
                    f"casing parts {other.name} and {region.name} share {both} elements; separate the boxes"
                )
    return [np.flatnonzero(chosen) for chosen in inside]
