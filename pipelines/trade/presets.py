"""Presets: what `draft`, `standard` and `reference` set in a scene. Chosen from the table of `gearcase tradeoff`.

A preset changes only how finely a scene is computed, never what it contains: rungs that leave out physics the scene
asks for (a torsion-only shaft, a casing without modes) are not among them.
Of the mesh stiffness it takes the rung, too.
"""

from __future__ import annotations

import argparse

from pipelines.scene import Scene
from pipelines.scene_file import LoadedScene, changed, load_scene
from pipelines.scene_file import Settings as Given
from pipelines.tables.casing import CraigBamptonCasingTable, ElasticBase

Settings = dict[str, object]

# mesh rung of every stage; element size and band of the casing relative to the scene; step in us
_LEVELS: dict[str, tuple[dict[str, object], float, float, float]] = {
    "draft": ({"model": "plane", "refinement": 0.6, "slices": 11}, 1.5, 0.6, 50.0),
    "standard": ({"model": "solid", "refinement": 0.7, "slices": 15}, 1.0, 1.0, 33.4),
    "reference": ({"model": "solid", "refinement": 1.0, "slices": 21}, 0.8, 1.2, 10.0),
}
PRESETS = tuple(_LEVELS)


def preset_settings(scene: Scene, preset: str) -> Settings:
    """The values a preset sets, by path."""
    mesh, size, band, step = _LEVELS[preset]
    settings: Settings = {"simulation.step_us": step}
    for number in range(1, len(scene.stages) + 1):
        settings[f"stages.{number}.mesh"] = mesh
    if isinstance(scene.casing, ElasticBase):
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
