"""The mesh models that a scene asks for, one per stage."""

from __future__ import annotations

from fem.contact.models.mesh_model import MeshModel
from fem.contact.models.registry import mesh_model
from pipelines.plant.facts import stage_facts
from pipelines.plant.layout import Layout
from pipelines.scene.scene import Scene


def mesh_models(scene: Scene, layout: Layout) -> list[MeshModel]:
    """By stage. The keys of a mesh table are the options of its model.

    Raises
    ------
    RungError : an option outside the range of its model
    """
    loads = [facts.line_load for facts in stage_facts(scene, layout)]
    return [
        mesh_model(stage.mesh.model, line_load=load, **stage.mesh.model_dump(exclude={"model"}))
        for stage, load in zip(scene.stages, loads, strict=True)
    ]
