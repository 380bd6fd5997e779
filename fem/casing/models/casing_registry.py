"""CASINGS: the casing models by name."""

from __future__ import annotations

from typing import Any

from fem.named_classes import named_class

CASINGS = {
    "none": ("fem.casing.models.no_casing", "NoCasing"),
    "rigid": ("fem.casing.models.rigid_casing", "RigidCasing"),
    "static": ("fem.casing.models.static_casing", "StaticCasing"),
    "craig-bampton": ("fem.casing.models.craig_bampton", "CraigBamptonCasing"),
    "matrices": ("fem.casing.models.matrices_casing", "MatricesCasing"),  # imported, reduced as static or craig-bampton
}


def casing_class(name: str) -> Any:
    """The model of that name. ValueError if there is none."""
    return named_class(CASINGS, name, "casing model", ValueError)
