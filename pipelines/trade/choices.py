"""The settings whose price is measured: every rung and main setting that a scene can switch, one at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from pipelines.scene import Scene
from pipelines.tables.casing import CraigBamptonCasingTable, NoCasingTable
from pipelines.trade.presets import PRESETS, preset_settings

Settings = dict[str, object]

PRESET, REFERENCE = "preset", "reference"
MESHES: dict[str, Settings] = {
    "iso": {"model": "iso"},
    "energy": {"model": "energy"},
    "plane, coarse": {"model": "plane", "refinement": 0.6},
    "plane": {"model": "plane"},
    "solid, coarse": {"model": "solid", "refinement": 0.7, "slices": 15},
    "solid": {"model": "solid"},
}
STEPS_US = (5.0, 10.0, 20.0, 33.4, 50.0, 100.0)
INTEGRATORS = ("exponential", "trapezoidal", "generalised-alpha")
CASING_SIZES, CASING_BANDS = (1.0, 1.3, 1.8), (0.5, 1.0)  # relative to the scene


@dataclass(frozen=True, kw_only=True)
class Choice:
    """One variant of a scene: `effect` is what it is about, `label` what it chooses there."""

    effect: str
    label: str
    settings: Settings = field(hash=False)

    @property
    def name(self) -> str:
        """Effect and label."""
        return f"{self.effect}: {self.label}"


def choices(scene: Scene) -> Iterator[Choice]:
    """The reference first, then each effect alone changed from it, then the presets."""
    best = preset_settings(scene, REFERENCE)
    yield Choice(effect=PRESET, label=REFERENCE, settings=best)
    for effect, label, change in _single(scene):
        kept = {key: value for key, value in best.items() if not key.startswith(_replaced(change))}
        yield Choice(effect=effect, label=label, settings=kept | change)
    meshes = {key: value for key, value in best.items() if key.endswith(".mesh")}
    for preset in PRESETS:
        if preset != REFERENCE:
            settings = preset_settings(scene, preset)
            yield Choice(effect=PRESET, label=preset, settings=settings)
            yield Choice(effect=PRESET, label=f"{preset}, mesh laws of {REFERENCE}", settings=settings | meshes)


def _replaced(change: Settings) -> tuple[str, ...]:
    """Tables whose keys of another rung must go when this change switches the rung."""
    return tuple(f"{key.removesuffix('.model')}." for key in change if key.endswith((".mesh", ".model")))


def _single(scene: Scene) -> Iterator[tuple[str, str, Settings]]:
    stages = range(1, len(scene.stages) + 1)
    for label, table in MESHES.items():
        yield "mesh law", label, {f"stages.{n}.mesh": table for n in stages}
    casing = scene.casing
    if isinstance(casing, CraigBamptonCasingTable):
        for size in CASING_SIZES:
            value = casing.element_size_mm * size
            yield "casing", f"elements of {value:.3g} mm", {"casing.element_size_mm": value}
        for band in CASING_BANDS:
            yield "casing", f"band {band * casing.band_Hz:g} Hz", {"casing.band_Hz": casing.band_Hz * band}
        yield "casing", "static", {"casing.model": "static", "casing.element_size_mm": casing.element_size_mm}
    if not isinstance(casing, NoCasingTable) and casing.model != "rigid":
        yield "casing", "rigid", {"casing.model": "rigid"}
    if scene.shaft_model.model == "timoshenko":
        length = scene.shaft_model.element_length_mm
        for factor in (0.5, 2.0):
            value = length * factor
            yield "shafts", f"elements of {value:.3g} mm", {"shaft_model.element_length_mm": value}
        yield "shafts", "torsion", {"shaft_model.model": "torsion"}
    for step in STEPS_US:
        yield "step", f"{step:g} us", {"simulation.step_us": step}
    for integrator in INTEGRATORS:
        if integrator != scene.simulation.integrator:
            yield "integrator", integrator, {"simulation.integrator": integrator}
    for rate in (0.5, 2.0):
        value = scene.simulation.output_rate_Hz * rate
        yield "output rate", f"{value:g} Hz", {"simulation.output_rate_Hz": value}
