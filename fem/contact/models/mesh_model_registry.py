"""MODELS: the mesh models by name."""

from __future__ import annotations

import dataclasses

from fem.contact.models.mesh_model import MeshModel
from fem.contact.slice_frame import ModelError
from fem.named_classes import named_class

MODELS = {
    "iso": ("fem.contact.models.iso", "Iso"),
    "energy": ("fem.contact.models.energy", "Energy"),
    "plane": ("fem.contact.models.plane", "Plane"),
    "solid": ("fem.contact.models.solid", "Solid"),
}


def mesh_model(name: str) -> type[MeshModel]:
    """The class of that name. ModelError if there is none."""
    return named_class(MODELS, name, "mesh model", ModelError)


def loaded_model(model: MeshModel, line_load: float) -> MeshModel:
    """The model at a line load (N/m, 0 for none), if it has a field for it."""
    if any(field.name == "line_load" for field in dataclasses.fields(model)):
        return dataclasses.replace(model, line_load=line_load or None)  # type: ignore[call-arg]
    return model
