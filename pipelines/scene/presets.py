"""Presets: what `draft`, `standard` and `reference` set in a scene. Chosen from the table of `gearcase tradeoff`.

A preset sets how finely a scene is computed: mesh models with their refinement and slices, elements of the casing,
time step. It keeps the physics of the scene: no preset takes a torsion-only shaft or a casing without modes. The band
of the casing modes is a part of what a scene contains, so that a `casing.band_Hz` in a file of the user overrides the
preset. A preset reduces only the default of that key and the value of a shipped scene, which its figures were measured
with. `--set` overrides all of it.

What decides, on the shipped rig: `plane` shifts lines of the fault by up to 9 dB, which no refinement cures, so
all presets take `solid`. The slices of the face add tones at their own passing frequency, n f_m / eps_beta, among the
modes of the casing: 15 instead of 61 move the RMS of the sensors by 0.6 % (2.8 % at most), 31 by 0.1 % (2.5 %), the
lines of the fault by 0.12 dB. The flexibility of the bearing seats moves these lines more than the rest of the casing.
A plain parametric housing takes cubic hexahedra, which follow the stresses at its edges: on the rig `standard` has
84,000 unknowns and frequencies 0.16 % too high (`python -m benchmarks.casing_limits`). Other housings take cubic
tetrahedra. Both are extrapolated by quadratic displacements on the same mesh; `draft` is not, where it has hexahedra.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.options import option_of

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from pipelines.scene.file import LoadedScene
    from pipelines.scene.scene import Scene
    from pipelines.scene.tables.casing import ElasticBase
    from pipelines.scene.tables.gears import StageTable

Settings = dict[str, object]


@dataclass(frozen=True, kw_only=True)
class Level:
    """Mesh law of every stage; element sizes and band of the casing relative to size and band of the scene; step.

    There are so many slices along the face, and more where they would be wider than `slice_width`, in mesh cycles.
    Sizes of elements are relative to those of quadratic tetrahedra that the scene asks for (`COARSER`: where it asks
    for others). Tetrahedra have an `element_size` and a `bore_size`, cubic ones a `cubic_size`, hexahedra an
    `extruded_size`.
    """

    refinement: float
    slices: int
    slice_width: float
    element_size: float
    bore_size: float
    cubic_size: float | None  # None: quadratic ones are taken
    extruded_size: float
    extruded_extrapolated: bool  # others always are
    band: float
    step_us: float


LEVELS = {
    "draft": Level(
        refinement=0.6,
        slices=15,
        slice_width=0.08,
        element_size=1.1,
        bore_size=0.55,
        cubic_size=None,
        extruded_size=1.7,
        extruded_extrapolated=False,
        band=0.3,
        step_us=100.0,
    ),
    "standard": Level(
        refinement=0.7,
        slices=15,
        slice_width=0.08,
        element_size=0.8,
        bore_size=0.32,
        cubic_size=1.5,
        extruded_size=1.27,
        extruded_extrapolated=True,
        band=0.7,
        step_us=50.0,
    ),
    "reference": Level(
        refinement=1.0,
        slices=61,
        slice_width=0.02,
        element_size=0.64,
        bore_size=0.25,
        cubic_size=1.1,
        extruded_size=0.82,
        extruded_extrapolated=True,
        band=1.0,
        step_us=20.0,
    ),
}
COARSER = {"tetrahedron-20": 1.5, "hexahedron-32": 1.27}  # than quadratic tetrahedra, of about as many unknowns
BETWEEN_BOSSES = 1.05  # distance of two axes, seen along x or z, over the sum of the radii of their bosses
PRESETS = tuple(LEVELS)
_BAND = "casing.band_Hz"


def preset_settings(scene: Scene, preset: str) -> Settings:
    """The values a preset sets, by path."""
    from pipelines.scene.tables.casing import ElasticBase

    level = LEVELS[preset]
    settings: Settings = {"simulation.step_us": level.step_us}
    for number, stage in enumerate(scene.stages, start=1):
        slices = min(max(level.slices, math.ceil(_overlap_ratio(stage) / level.slice_width)), most_slices())
        settings[f"stages.{number}.mesh"] = {"model": "solid", "refinement": level.refinement, "slices": slices}
    if isinstance(scene.casing, ElasticBase):
        settings |= _casing_mesh(scene, scene.casing, level)
    if (band := getattr(scene.casing, "band_Hz", None)) is not None:
        settings[_BAND] = band * level.band
    return settings


def most_slices() -> int:
    """Of every mesh model."""
    from fem.contact.models.mesh_model import MeshModel

    return int(option_of(MeshModel, "slices").le or 0)


def _overlap_ratio(stage: StageTable) -> float:
    """eps_beta (ISO 21771)."""
    return stage.face_width_mm * math.sin(stage.si.helix_angle) / (math.pi * stage.module_mm)


def _casing_mesh(scene: Scene, casing: ElasticBase, level: Level) -> Settings:
    """Hexahedra of a plain parametric housing, unless its scene asks for tetrahedra: then cubic ones."""
    from pipelines.scene.tables.housing import HousingBase, MatricesHousingTable, MeshHousingTable

    housing, coarser = casing.housing, COARSER.get(casing.element, 1.0)

    def sized(factor: float) -> float:
        """As large as that, relative to quadratic tetrahedra."""
        return casing.element_size_mm * (factor / coarser)

    if isinstance(housing, MatricesHousingTable):
        return {}
    hexahedra = isinstance(housing, HousingBase) and (
        casing.element.startswith("hexahedron")
        or (
            housing.plain
            and "element" not in casing.model_fields_set
            and _bosses_apart(scene.stages, housing.boss_diameters_mm)
        )
    )
    if hexahedra:
        return {
            "casing.element": "hexahedron-32",
            "casing.element_size_mm": sized(level.extruded_size),
            "casing.extrapolated": level.extruded_extrapolated,
        }
    if isinstance(housing, MeshHousingTable):
        return {}
    linear = casing.element == "tetrahedron-4"  # asked for to compare with
    if level.cubic_size is not None and not linear:
        return {
            "casing.element": "tetrahedron-20",
            "casing.element_size_mm": sized(level.cubic_size),
            "casing.extrapolated": True,
        }
    return {
        "casing.element": "tetrahedron-4" if linear else "tetrahedron-10",
        "casing.element_size_mm": sized(level.element_size),
        "casing.bore_element_size_mm": sized(level.bore_size),
        "casing.extrapolated": not linear,
    }


def _bosses_apart(stages: Sequence[StageTable], boss_diameters: Sequence[float]) -> bool:
    """Whether the bosses of each pair lie apart seen along x or z, as hexahedra ask; by the reference circles."""
    from pipelines.scene.train import stage_shafts

    for stage, (pinion, wheel) in zip(stages, stage_shafts(stages), strict=True):
        helix, direction = stage.si.helix_angle, stage.si.direction
        distance = stage.module_mm * (stage.pinion_teeth + stage.wheel_teeth) / (2.0 * math.cos(helix))
        seen = distance * max(abs(math.cos(direction)), abs(math.sin(direction)))
        if seen < BETWEEN_BOSSES * (boss_diameters[pinion] + boss_diameters[wheel]) / 2.0:
            return False
    return True


def preset_on(loaded: LoadedScene, preset: str) -> LoadedScene:
    """A scene computed as finely as a preset says, where its own settings say nothing.

    Raises
    ------
    InputError : there is no such preset
    SceneError : the preset does not fit the scene
    """
    from pipelines.io.errors import InputError
    from pipelines.io.shown import shown
    from pipelines.scene.file import changed, user_states

    if preset not in LEVELS:
        raise InputError(f"preset {shown(preset)}: there is no such preset. Set one of {', '.join(LEVELS)}.")
    settings = preset_settings(loaded.scene, preset)
    if _BAND in settings and user_states(loaded.source, _BAND):
        del settings[_BAND]
    return changed(changed(loaded, settings), (), loaded.settings)


def replaced(before: LoadedScene, after: LoadedScene) -> str:
    """The values of a scene that a preset replaced, as "simulation.step_us 20 -> 50, ..."; "" if none."""
    from pipelines.scene.merge import leaves

    old, new = leaves(before.tree), leaves(after.tree)
    return ", ".join(
        f"{'.'.join(map(str, path))} {old[path]} -> {new[path]}"
        for path in old
        if path in new and new[path] != old[path]
    )


def load_asked(options: argparse.Namespace) -> LoadedScene:
    """The scene of a command line.

    Raises
    ------
    SceneError, InputError : as `pipelines.scene.file.load_scene`
    """
    from pipelines.scene.file import load_scene

    loaded = load_scene(options.scene, options.settings)
    if options.preset is None:
        return loaded
    fine = preset_on(loaded, options.preset)
    if (change := replaced(loaded, fine)) and not options.quiet:
        sys.stderr.write(f"preset {options.preset}: {change}; keep a value with --set\n")
    return fine
