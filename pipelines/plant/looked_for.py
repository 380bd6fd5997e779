"""What the diagnosis of a scene looks for: the lines of the suspected gear, in the windows of constant speed."""

from __future__ import annotations

from collections import Counter

import numpy as np

from pipelines.plant.bearings import bearing_frequencies
from pipelines.plant.facts import rope_frequency, stage_facts
from pipelines.plant.layout import Layout, lay_out
from pipelines.scene.scene import Scene
from pipelines.scene.tables.motion import RopeTable
from pipelines.signals.analysis import DiagnosisSettings


def diagnosis_settings(scene: Scene, layout: Layout | None = None) -> DiagnosisSettings | None:
    """What the diagnosis of a scene looks for; None if the scene gives no windows or has no sensors."""
    table = scene.diagnosis
    if not table.windows_s or not scene.sensors:
        return None
    layout = layout or lay_out(scene)
    stage = stage_facts(scene, layout)[table.stage - 1]
    on_wheel = table.gear == "wheel"
    faulty = Counter((f.stage, f.gear, f.kind) for f in scene.faults)
    words = ", ".join(
        f"{'one tooth' if count == 1 else f'{count} teeth'} of the stage {number} {gear} {kind.removesuffix('-tooth')}"
        for (number, gear, kind), count in faulty.items()
    )
    modes = {
        name: rope_frequency(scene, _rope_length(scene, layout, sum(w) / 2)) for name, w in table.windows_s.items()
    }
    return DiagnosisSettings(
        revolution_frequency=stage.wheel_frequency if on_wheel else stage.pinion_frequency,
        mesh_frequency=stage.mesh_frequency,
        windows=dict(table.windows_s),
        rope_mode={name: value for name, value in modes.items() if value is not None},
        bearings=bearing_frequencies(scene, layout),
        sensor=table.sensor,
        axis=table.axis,
        band=table.envelope_band_Hz,
        shaft=f"shaft_{layout.pair_shafts[table.stage - 1][on_wheel] + 1}",
        fault=words or "no fault",
    )


def _rope_length(scene: Scene, layout: Layout, time: float) -> float | None:
    """Free rope length (m) at a time (s): the length at the start less what the drums have wound."""
    from scipy.integrate import trapezoid

    if not isinstance(scene.load, RopeTable):
        return None
    times, speeds = np.array(scene.drive.times_s), np.array(scene.drive.speeds_rpm) * 2 * np.pi / 60
    fine = np.linspace(0.0, time, 2001)
    angle = float(trapezoid(np.interp(fine, times, speeds), fine)) * layout.shaft_ratios[layout.loaded]
    return scene.load.rope_length_m - angle * scene.load.drum_radius_mm / 1000 / scene.load.reeving_ratio
