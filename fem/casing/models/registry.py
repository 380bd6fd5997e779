"""CASINGS: the elastic casing models by name.

A model is named by its module and class and imported when it is asked for, so that the result of one model does not
depend on the code of another.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

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
    if name not in CASINGS:
        raise ValueError(f"casing model {name!r} is unknown; known: {', '.join(CASINGS)}")
    module, kind = CASINGS[name]
    made: ElasticCasing = getattr(import_module(module), kind)(**options)
    return made
