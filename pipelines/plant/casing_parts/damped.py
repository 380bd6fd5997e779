"""Parts of a casing that have a damping of their own, in SI: where their elements are, and their loss factors."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fem.casing.geometry.housing import Housing
from fem.casing.meshing.source import Geometry
from fem.casing.parts.regions import Region
from pipelines.scene.tables.casing import COVER, FEET, ElasticBase

_FAR = math.inf


def loss_factors(table: ElasticBase) -> dict[str, float]:
    """Loss factors of the parts by name."""
    return {part.name: part.loss_factor for part in table.damped_parts}


def regions(table: ElasticBase, geometry: Geometry) -> tuple[Region, ...]:
    """Boxes of the parts that are made of elements.

    A cover begins at the split plane of the flange, without a flange at the underside of the top wall; feet lie below
    the floor.
    """
    return tuple(_regions(table, geometry))


def _regions(table: ElasticBase, geometry: Geometry) -> Iterator[Region]:
    for part in table.damped_parts:
        if part.box_mm is not None:
            (x, y, z), (to_x, to_y, to_z) = part.box_mm
            low, high = (x / 1000, y / 1000, z / 1000), (to_x / 1000, to_y / 1000, to_z / 1000)
            yield Region(name=part.name, low=low, high=high)
        elif isinstance(geometry, Housing) and part.name == COVER:
            yield Region(name=COVER, low=(-_FAR, -_FAR, geometry.cover_start), high=(_FAR, _FAR, _FAR))
        elif isinstance(geometry, Housing) and part.name == FEET:
            yield Region(name=FEET, low=(-_FAR, -_FAR, -_FAR), high=(_FAR, _FAR, -geometry.axis_height))
