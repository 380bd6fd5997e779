"""Presets `draft`, `standard` and `reference`: settings of a scene for three accuracies, chosen by `gearcase tradeoff`.

A preset sets the numerical accuracy of a scene: mesh models with their refinement and slices, elements of the casing,
and time step. It does not change the physics: no preset selects shafts with torsion only or a casing without modes. The
band of the casing modes is part of the scene, so `casing.band_Hz` in a file of the user overrides the preset. A preset
reduces only the default of that key and the value of a shipped scene. `--set` overrides every value of a preset.

Reasons, on the shipped rig: `plane` shifts fault lines by up to 9 dB, independently of the refinement, so all presets
use `solid`. The slices of the face add tones at their passing frequency, n f_m / eps_beta, among the modes of the
casing. Compared with 61 slices, 15 change the RMS at the sensors by 0.6 % (2.8 % at most) and 31 by 0.1 % (2.5 %), and
the fault lines by 0.12 dB. These lines depend more on the flexibility of the bearing seats than on the rest of the
casing. A plain parametric housing gets cubic hexahedra with edge-singularity enrichment: on the rig, `standard` has
84,000 unknowns and frequencies 0.16 % too high (`python -m benchmarks.casing_limits`). Other housings get cubic
tetrahedra. Both are extrapolated by quadratic elements on the same mesh, except for hexahedra of `draft`.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.options import options_of

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from pipelines.scene.load_scene import LoadedScene
    from pipelines.scene.scene import Scene
    from pipelines.scene.tables.casing import ElasticBase
    from pipelines.scene.tables.stages import StageTable

Settings = dict[str, object]


@dataclass(frozen=True, kw_only=True)
class Level:
    """One preset: mesh law of every stage, mesh and band of the casing, time step.

    The number of slices along the face is `slices`, or more if they would be wider than `slice_width`, in mesh cycles.
    Element sizes and band are relative to those of the scene, the sizes to those of quadratic tetrahedra (`COARSER`
    converts those of other elements). Tetrahedra have an `element_size` and a `bore_size`, cubic ones a `cubic_size`,
    hexahedra an `extruded_size`.
    """

    refinement: float
    slices: int
    slice_width: float
    element_size: float
    bore_size: float
    cubic_size: float | None  # None: quadratic tetrahedra
    extruded_size: float
    extruded_extrapolated: bool  # other elements always are
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
COARSER = {"tetrahedron-20": 1.5, "hexahedron-32": 1.27}  # size over that of quadratic tetrahedra with as many unknowns
BETWEEN_BOSSES = 1.05  # distance of two axes, projected on x or z, over the sum of the radii of their bosses
PRESETS = tuple(LEVELS)
_BAND = "casing.band_Hz"


def preset_settings(scene: Scene, preset: str) -> Settings:
    """The values that a preset sets, by path."""
    level = LEVELS[preset]
    settings: Settings = {"simulation.step_us": level.step_us}
    for number, stage in enumerate(scene.stages, start=1):
        overlap_ratio = stage.face_width_mm * math.sin(stage.si.helix_angle) / (math.pi * stage.module_mm)  # ISO 21771
        slices = min(max(level.slices, math.ceil(overlap_ratio / level.slice_width)), most_slices())
        settings[f"stages.{number}.mesh"] = {"model": "solid", "refinement": level.refinement, "slices": slices}
    if scene.casing.elastic:
        settings |= _casing_mesh(scene, scene.casing, level)
    if (band := getattr(scene.casing, "band_Hz", None)) is not None:
        settings[_BAND] = band * level.band
    return settings


def most_slices() -> int:
    """Greatest number of slices of the mesh models."""
    from fem.contact.models.mesh_model import MeshModel

    return int(next(one.le for field, one in options_of(MeshModel) if field.name == "slices") or 0)


def _casing_mesh(scene: Scene, casing: ElasticBase, level: Level) -> Settings:
    """Settings of the casing mesh: hexahedra for a plain parametric housing whose scene does not select tetrahedra."""
    housing, coarser = casing.housing, COARSER.get(casing.element, 1.0)

    def sized(factor: float) -> float:
        """Element size for a factor relative to quadratic tetrahedra."""
        return casing.element_size_mm * (factor / coarser)

    if housing.model == "matrices":
        return {}
    hexahedra = housing.model == "parametric" and (
        casing.element.startswith("hexahedron")
        or (
            housing.plain
            and "element" not in casing.model_fields_set
            and _bosses_separate(scene.stages, housing.boss_diameters_mm)
        )
    )
    if hexahedra:
        return {
            "casing.element": "hexahedron-32",
            "casing.element_size_mm": sized(level.extruded_size),
            "casing.extrapolated": level.extruded_extrapolated,
        }
    if housing.model == "mesh":
        return {}
    linear = casing.element == "tetrahedron-4"  # linear elements are chosen only for comparison
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


def _bosses_separate(stages: Sequence[StageTable], boss_diameters: Sequence[float]) -> bool:
    """True if the bosses of each pair are separate in the projection on x or z, as hexahedra need."""
    from pipelines.scene.shaft_places import stage_shafts

    for stage, (pinion, wheel) in zip(stages, stage_shafts(stages), strict=True):
        helix, direction = stage.si.helix_angle, stage.si.direction
        distance = stage.module_mm * (stage.pinion_teeth + stage.wheel_teeth) / (2.0 * math.cos(helix))
        seen = distance * max(abs(math.cos(direction)), abs(math.sin(direction)))
        if seen < BETWEEN_BOSSES * (boss_diameters[pinion] + boss_diameters[wheel]) / 2.0:
            return False
    return True


def preset_on(loaded: LoadedScene, preset: str) -> LoadedScene:
    """A scene with the values of a preset, except for those that `--set` or Python settings override.

    Raises
    ------
    InputError : there is no such preset
    SceneError : the preset does not fit the scene
    """
    from pipelines.io.errors import InputError
    from pipelines.io.shown_text import shown
    from pipelines.scene.load_scene import changed, user_states

    if preset not in LEVELS:
        raise InputError(f"preset {shown(preset)}: there is no such preset. Set one of {', '.join(LEVELS)}.")
    settings = preset_settings(loaded.scene, preset)
    if _BAND in settings and user_states(loaded.source, _BAND):
        del settings[_BAND]
    return changed(changed(loaded, settings), (), loaded.settings)


def replaced(before: LoadedScene, after: LoadedScene) -> str:
    """The values of a scene and its defaults that a preset replaced, as "simulation.step_us 20 -> 50, ..."."""
    from pipelines.scene.merge import leaves
    from pipelines.scene.validation_messages import shown_number

    old, new = (leaves(loaded.scene.model_dump(mode="json")) for loaded in (before, after))
    return ", ".join(
        f"{'.'.join(map(str, path))} {shown_number(old[path])} -> {shown_number(new[path])}"
        for path in old
        if path in new and new[path] != old[path]
    )


def load_requested(options: argparse.Namespace) -> LoadedScene:
    """The scene of a command line.

    Raises
    ------
    SceneError, InputError : as in `pipelines.scene.load_scene.load_scene`
    """
    from pipelines.scene.load_scene import load_scene

    loaded = load_scene(options.scene, options.settings)
    if options.preset is None:
        return loaded
    fine = preset_on(loaded, options.preset)
    if (change := replaced(loaded, fine)) and not options.quiet:
        sys.stderr.write(f"preset {options.preset}: {change}; keep a value with --set\n")
    return fine
