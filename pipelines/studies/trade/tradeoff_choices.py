"""Choices of a trade-off: the models and main settings whose cost and accuracy are measured.

The presets come first, then the reference with one effect changed, then the combinations from which the presets were
chosen. Mesh laws and casings that several choices have in common are built once.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

from pipelines.scene.presets import PRESETS, Settings, preset_settings
from pipelines.scene.scene import Scene

PRESET, REFERENCE, COMBINATION = "preset", "reference", "combination"
MESHES: dict[str, Settings] = {
    "iso": {"model": "iso", "slices": 21},
    "energy": {"model": "energy", "slices": 21},
    "plane": {"model": "plane", "refinement": 1.0, "slices": 21},
    "solid, 15 slices": {"model": "solid", "refinement": 0.6, "slices": 15},
    "solid, 31 slices": {"model": "solid", "refinement": 0.6, "slices": 31},
    "solid, 101 slices": {"model": "solid", "refinement": 0.6, "slices": 101},
}
STEPS_US = (33.4, 50.0, 100.0)
INTEGRATORS = ("exponential", "trapezoidal", "generalised-alpha")
CASINGS = ((1.0, 1.0), (1.0, 0.5), (1.5, 1.0))  # element size and band relative to the scene


@dataclass(frozen=True, kw_only=True)
class Choice:
    """One variant of a scene; `effect` is the group of its settings, `label` the choice in this group."""

    effect: str
    label: str
    settings: Settings = field(hash=False)

    @property
    def name(self) -> str:
        """Effect and label."""
        return f"{self.effect}: {self.label}"


def choices(scene: Scene) -> Iterator[Choice]:
    """The reference, the other presets, the reference with one effect changed, and combinations, in this order."""
    best = preset_settings(scene, REFERENCE)
    yield Choice(effect=PRESET, label=REFERENCE, settings=best)
    meshes = {key: value for key, value in best.items() if key.endswith(".mesh")}
    for preset in PRESETS:
        if preset != REFERENCE:
            settings = preset_settings(scene, preset)
            yield Choice(effect=PRESET, label=preset, settings=settings)
            yield Choice(effect=PRESET, label=f"{preset}, laws of {REFERENCE}", settings=settings | meshes)
    for effect, label, change in _single(scene, best):
        # the other keys of a table go if the change selects another model
        tables = tuple(f"{key.removesuffix('.model')}." for key in change if key.endswith((".mesh", ".model")))
        kept = {key: value for key, value in best.items() if not key.startswith(tables)}
        yield Choice(effect=effect, label=label, settings=kept | change)
    yield from _combinations(scene)


def _single(scene: Scene, best: Settings) -> Iterator[tuple[str, str, Settings]]:
    stages = range(1, len(scene.stages) + 1)
    for label, table in MESHES.items():
        yield "mesh law", label, {f"stages.{n}.mesh": table for n in stages}
    casing = scene.casing
    if casing.model == "craig-bampton":
        element = str(best.get("casing.element", casing.element))
        for size, band in CASINGS:
            length, highest = casing.element_size_mm * size, casing.band_Hz * band
            settings: Settings = {"casing.element_size_mm": length, "casing.band_Hz": highest}
            if not element.startswith("hexahedron"):
                settings["casing.bore_element_size_mm"] = 0.5 * length
            yield "casing", f"{length:.3g} mm, {highest:g} Hz", settings
        extrapolated = bool(best.get("casing.extrapolated"))
        label = "not extrapolated" if extrapolated else "extrapolated"
        yield "casing", label, {"casing.extrapolated": not extrapolated}
        yield "casing", "static", {"casing.model": "static", "casing.element_size_mm": casing.element_size_mm}
    if casing.elastic:
        yield "casing", "rigid", {"casing.model": "rigid"}
    if scene.shaft_model.model == "timoshenko":
        length = scene.shaft_model.element_length_mm
        for factor in (0.5, 2.0):
            value = length * factor
            yield "shafts", f"elements of {value:.3g} mm", {"shaft_model.element_length_mm": value}
        yield "shafts", "torsion", {"shaft_model.model": "torsion"}
    if scene.bearings.model != "rigid":
        yield "bearings", "rigid", {"bearings.model": "rigid"}
    for step in STEPS_US:
        yield "step", f"{step:g} us", {"simulation.step_us": step}
    for integrator in INTEGRATORS:
        if integrator != scene.simulation.integrator:
            yield "integrator", integrator, {"simulation.integrator": integrator}
    for rate in (0.5, 2.0):
        value = scene.simulation.output_rate_Hz * rate
        yield "output rate", f"{value:g} Hz", {"simulation.output_rate_Hz": value}


def _combinations(scene: Scene) -> Iterator[Choice]:
    """Laws, casings and steps of the presets below the reference in all other ways, and with the laws of `plane`."""
    found = {preset: preset_settings(scene, preset) for preset in PRESETS if preset != REFERENCE}
    laws = {preset: {k: v for k, v in s.items() if k.endswith(".mesh")} for preset, s in found.items()}
    laws["plane"] = dict.fromkeys(next(iter(laws.values())), MESHES["plane"])
    casings = {preset: {k: v for k, v in s.items() if k.startswith("casing.")} for preset, s in found.items()}
    steps = {preset: s["simulation.step_us"] for preset, s in found.items()}
    for law, casing, step in itertools.product(laws, casings, steps):
        words = [f"mesh law {law}", *([f"casing {casing}"] if casings[casing] else []), f"step {steps[step]:g} us"]
        settings = laws[law] | casings[casing] | {"simulation.step_us": steps[step]}
        yield Choice(effect=COMBINATION, label=", ".join(words), settings=settings)
