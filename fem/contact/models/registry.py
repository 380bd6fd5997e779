"""MODELS: the mesh models by name."""

from __future__ import annotations

import dataclasses
from typing import Any

from fem.contact.frame import ModelError
from fem.contact.models.mesh_model import MeshModel
from fem.named_classes import named_class

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
    ModelError : no such model, or an option outside its range
    """
    made: type[MeshModel] = named_class(MODELS, name, "mesh model", ModelError)
    if any(field.name == "line_load" for field in dataclasses.fields(made)):
        options["line_load"] = line_load or None
    return made(**options)
