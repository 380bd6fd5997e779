"""What the diagnosis looks for: the lines of the suspected gear, in the windows of constant speed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mbd.parts.drive import SpeedProfile
from mbd.parts.rolling_elements import pass_frequencies
from pipelines.plant.bearings import RollingBearing
from pipelines.plant.facts import stage_facts
from pipelines.plant.flanks import Fault
from pipelines.plant.layout import Layout
from pipelines.plant.torques.hoist import Hoist
from pipelines.signals.analysis import DiagnosisSettings


@dataclass(frozen=True, kw_only=True)
class LookedFor:
    """Where the diagnosis looks: a channel, a gear of a stage (from 1), windows (s), the band of the envelope (Hz).

    `noise` (m/s2 rms) is added to the signals before; `possible` is False without windows or sensors.
    """

    sensor: str
    axis: str
    stage: int
    gear: str
    windows: Mapping[str, tuple[float, float]]
    band: str | tuple[float, float]
    noise: float
    possible: bool


def diagnosis_settings(
    asked: LookedFor,
    layout: Layout,
    hoist: Hoist | None,
    profile: SpeedProfile,
    rolling: Sequence[RollingBearing],
    faults: Sequence[Fault],
) -> DiagnosisSettings | None:
    """The lines and windows of a diagnosis; None if it is not possible.

    Parameters
    ----------
    asked : where the diagnosis looks
    layout, hoist, profile : the train, its rope, and the speed of its motors
    rolling : bearings whose pass frequencies are named
    faults : for the words on what is wrong
    """
    if not asked.possible:
        return None
    stage = stage_facts(layout)[asked.stage - 1]
    on_wheel = asked.gear == "wheel"
    faulty = Counter((f.stage, f.gear, f.kind) for f in faults)
    words = ", ".join(
        f"{'one tooth' if count == 1 else f'{count} teeth'} of the stage {number} {gear} {kind.removesuffix('-tooth')}"
        for (number, gear, kind), count in faulty.items()
    )
    ratio = layout.shaft_ratios[layout.loaded]
    modes = {
        name: hoist.rope_frequency(hoist.rope_length_at(sum(window) / 2, profile, ratio))
        for name, window in asked.windows.items()
        if hoist is not None and hoist.rope_strength is not None
    }
    return DiagnosisSettings(
        revolution_frequency=stage.wheel_frequency if on_wheel else stage.pinion_frequency,
        mesh_frequency=stage.mesh_frequency,
        windows=asked.windows,
        rope_mode={name: value for name, value in modes.items() if value is not None},
        bearings=_bearing_frequencies(layout, rolling),
        sensor=asked.sensor,
        axis=asked.axis,
        band=asked.band,
        shaft=f"shaft_{layout.pair_shafts[asked.stage - 1][on_wheel] + 1}",
        fault=words or "no fault",
    )


def _bearing_frequencies(layout: Layout, rolling: Sequence[RollingBearing]) -> dict[str, float]:
    """Pass frequencies (Hz) of all rolling bearings at the highest motor speed: "bearing_3 BPFO", BPFI, BSF, FTF."""
    found: dict[str, float] = {}
    for bearing in rolling:
        turn, per = layout.turns * layout.shaft_ratios[bearing.shaft], pass_frequencies(bearing.elements)
        lines = {"BPFO": per.outer, "BPFI": per.inner, "BSF": per.spin, "FTF": per.cage}
        found |= {f"{bearing.name} {label}": turn * value for label, value in lines.items()}
    return found
