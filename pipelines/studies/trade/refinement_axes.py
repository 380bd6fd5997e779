"""Axes of refinement studies: the settings of each axis at a given fineness, and the probe that is evaluated.

Fineness 1 is the setting of the scene; 2 halves its element sizes, time steps and so on. The size of a level is
1/fineness.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipelines.scene.presets import Settings
    from pipelines.scene.scene import Scene


class AxisError(ValueError):
    """The scene has nothing to refine along an axis."""


@dataclass(frozen=True, kw_only=True)
class Axis:
    """An axis of refinement: `settings(scene, fineness)` by key; the probes `also` are only compared by level."""

    words: str
    probe: str
    formal_order: float | None  # of smooth solutions, limits the order assumed in bands; that of modes is their own
    ratio: float  # fineness between neighbouring levels
    settings: Callable[[Scene, float], Settings]
    also: tuple[str, ...] = ()


def _of_meshes(axis: str, key: str, made: Callable[[float], float]) -> Callable[[Scene, float], Settings]:
    """The settings of a key for every mesh that has it: `made` of its value multiplied by the fineness."""

    def settings(scene: Scene, fineness: float) -> Settings:
        found: Settings = {
            f"stages.{number}.mesh.{key}": made(getattr(stage.mesh, key) * fineness)
            for number, stage in enumerate(scene.stages, 1)
            if hasattr(stage.mesh, key)
        }
        return found or _nothing(axis, "stages.1.mesh.model", scene.stages[0].mesh.model, "plane")

    return settings


def _casing_mesh(scene: Scene, fineness: float) -> Settings:
    if not scene.casing.elastic:
        return _nothing("casing-mesh", "casing.model", scene.casing.model, "craig-bampton")
    if scene.casing.housing.model == "matrices":
        raise AxisError(
            "--over casing-mesh: casing.housing.model = 'matrices' has no mesh to refine. Refine the mesh in the "
            "program that made the matrices, and compare the modes that gearcase casing prints for both."
        )
    names = ("element_size_mm", "bore_element_size_mm", "foot_element_size_mm")
    sizes = {name: getattr(scene.casing, name) for name in names}
    return {f"casing.{name}": size / fineness for name, size in sizes.items() if size is not None}


def _modes(scene: Scene, fineness: float) -> Settings:
    band = getattr(scene.casing, "band_Hz", None)
    if band is None:
        return _nothing("modes", "casing.model", scene.casing.model, "craig-bampton")
    return {"casing.band_Hz": band * fineness}


def _shaft_elements(scene: Scene, fineness: float) -> Settings:
    if scene.shaft_model.model != "timoshenko":
        return _nothing("shaft-elements", "shaft_model.model", scene.shaft_model.model, "timoshenko")
    return {"shaft_model.element_length_mm": scene.shaft_model.element_length_mm / fineness}


def _step(scene: Scene, fineness: float) -> Settings:
    return {"simulation.step_us": scene.simulation.step_us / fineness}


def _nothing(axis: str, key: str, value: object, remedy: str) -> Settings:
    raise AxisError(f"--over {axis}: {key} = {value!r} has nothing to refine there. Set {key} to {remedy!r}.")


AXES = {
    "gear-mesh": Axis(
        words="finite elements of the gears",
        probe="gears",
        formal_order=4.0,
        ratio=2**0.5,
        settings=_of_meshes("gear-mesh", "refinement", float),
    ),
    "slices": Axis(
        words="slices along the face",
        probe="gears",
        formal_order=2.0,
        ratio=2.0,
        settings=_of_meshes("slices", "slices", lambda value: max(1, round(value))),
        also=("transmission",),
    ),
    "positions": Axis(
        words="positions per pitch",
        probe="gears",
        formal_order=2.0,
        ratio=2.0,
        settings=_of_meshes("positions", "positions", round),
    ),
    "casing-mesh": Axis(
        words="elements of the casing", probe="modes", formal_order=None, ratio=1.3, settings=_casing_mesh
    ),
    "modes": Axis(words="band of the casing modes", probe="machine", formal_order=None, ratio=1.5, settings=_modes),
    "shaft-elements": Axis(
        words="beam elements of the shafts",
        probe="machine",
        formal_order=4.0,
        ratio=2.0,
        settings=_shaft_elements,
    ),
    "step": Axis(words="time step", probe="signals", formal_order=2.0, ratio=2.0, settings=_step),
}
