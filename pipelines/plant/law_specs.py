"""The mesh laws that a scene asks for, one per stage, before its flanks are modified or damaged."""

from __future__ import annotations

from pipelines.plant.facts import stage_facts
from pipelines.plant.layout import Layout
from pipelines.plant.mesh_laws import LawSpec, law_spec
from pipelines.scene.scene import Scene
from pipelines.scene.tables.gears import EnergyMesh, PlaneMesh, SolidMesh


def law_specs(scene: Scene, layout: Layout) -> list[LawSpec]:
    """By stage."""
    return [
        law_spec(
            pair,
            stage.mesh.model,
            slices=stage.mesh.slices,
            refinement=stage.mesh.refinement if isinstance(stage.mesh, PlaneMesh | SolidMesh) else 0.0,
            positions=stage.mesh.positions if isinstance(stage.mesh, EnergyMesh | PlaneMesh | SolidMesh) else 0,
            line_load=facts.line_load,
        )
        for stage, pair, facts in zip(scene.stages, layout.pairs, stage_facts(scene, layout), strict=True)
    ]
