"""CASINGS: the elastic casing models by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fem.named_classes import named_class

if TYPE_CHECKING:
    from fem.casing.models.elastic_casing import ElasticCasing

CASINGS = {
    "static": ("fem.casing.models.static_casing", "StaticCasing"),
    "craig-bampton": ("fem.casing.models.craig_bampton", "CraigBamptonCasing"),
}


def elastic_casing(name: str, **options: Any) -> ElasticCasing:
    """The model of that name with its options.

    Raises
    ------
    ValueError : no such model
    """
    made: ElasticCasing = named_class(CASINGS, name, "casing model", ValueError)(**options)
    return made
