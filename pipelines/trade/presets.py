"""Presets: what `draft`, `standard` and `reference` set in a scene. Chosen from the table of `gearcase tradeoff`.

A preset changes only how finely a scene is computed, never what it contains: rungs that leave out physics the scene
asks for (a torsion-only shaft, a casing without modes) are not among them.
"""

from __future__ import annotations

import argparse

from pipelines.scene import Scene
from pipelines.scene_file import LoadedScene, changed, load_scene
from pipelines.scene_file import Settings as Given
from pipelines.tables.casing import CraigBamptonCasingTable, StaticCasingTable
from pipelines.tables.gears import PlaneMesh

Settings = dict[str, object]

# refinement of the gear meshes, slices; element size and band of the casing relative to the scene; step in us and band
# in Hz of the time integration
_LEVELS: dict[str, tuple[float, int, float, float, float, float]] = {
    "draft": (0.7, 11, 1.5, 0.6, 50.0, 6000.0),
    "standard": (1.0, 15, 1.0, 1.0, 33.4, 20000.0),
    "reference": (1.4, 31, 0.8, 1.3, 10.0, 20000.0),
}
PRESETS = tuple(_LEVELS)


def preset_settings(scene: Scene, preset: str) -> Settings:
    """The values a preset sets, by path; `standard` is what a scene says that says nothing of its own."""
    refinement, slices, size, band, step, kept = _LEVELS[preset]
    settings: Settings = {"simulation.step_us": step, "simulation.band_Hz": kept}
    for number, stage in enumerate(scene.stages, 1):
        settings[f"stages.{number}.mesh.slices"] = slices
        if isinstance(stage.mesh, PlaneMesh):
            settings[f"stages.{number}.mesh.refinement"] = refinement
    if isinstance(scene.casing, StaticCasingTable | CraigBamptonCasingTable):
        settings["casing.element_size_mm"] = scene.casing.element_size_mm * size
    if isinstance(scene.casing, CraigBamptonCasingTable):
        settings["casing.band_Hz"] = scene.casing.band_Hz * band
    return settings


def load_preset(source: str, settings: Given, preset: str | None) -> LoadedScene:
    """A scene with its settings, computed as finely as a preset says where the settings say nothing.

    Raises
    ------
    SceneError, InputError : as `pipelines.scene_file.load_scene`
    """
    loaded = load_scene(source, settings)
    if preset is None:
        return loaded
    return changed(changed(loaded, preset_settings(loaded.scene, preset)), settings)


def load_asked(options: argparse.Namespace) -> LoadedScene:
    """The scene of a command line."""
    return load_preset(options.scene, options.settings, options.preset)
