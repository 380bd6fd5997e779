"""MODELS: the mesh models by name.

A model is named by its module and class and imported when it is asked for, so that the result of one model does not
depend on the code of another.
"""

from __future__ import annotations

import dataclasses
from importlib import import_module
from typing import Any

from fem.contact.frame import RungError
from fem.contact.models.mesh_model import MeshModel

MODELS = {
    "iso": ("fem.contact.models.iso", "Iso"),
    "energy": ("fem.contact.models.energy", "Energy"),
    "plane": ("fem.contact.models.plane", "Plane"),
    "solid": ("fem.contact.models.solid", "Solid"),
}


def mesh_model(name: str, *, line_load: float, **options: Any) -> MeshModel:
    """The model of that name with its options; `line_load` (N/m, 0 for none) is given to models that ask for it.

    Raises
    ------
    RungError : no such model, or an option outside its range
    """
    if name not in MODELS:
        raise RungError(f"mesh model {name!r} is unknown; known: {', '.join(MODELS)}")
    module, kind = MODELS[name]
    made: type[MeshModel] = getattr(import_module(module), kind)
    if any(field.name == "line_load" for field in dataclasses.fields(made)):
        options["line_load"] = line_load or None
    return made(**options)
