"""Casing model `none`: bearings held by the ground; no casing motion, no sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from fem.casing.geometry.housing import Housing
from fem.casing.reduced.body import ReducedBody
from fem.casing.reduced.modes import grounded_body
from fem.elements.materials import Material


@dataclass(frozen=True, kw_only=True)
class NoCasing:
    """Bearings to ground."""

    model: Literal["none"] = "none"

    def reduce(self, housing: Housing | Mapping[str, Sequence[float]], material: Material | None = None) -> ReducedBody:
        """A body without coordinates. Instead of a housing, bearing points {name: (x, y, z)} (m) will do."""
        if isinstance(housing, Housing):
            return grounded_body({bore.name: tuple(housing.bore_centre(bore)) for bore in housing.bores})
        return grounded_body(housing)
