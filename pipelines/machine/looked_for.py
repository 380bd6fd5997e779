"""Monitored lines of a diagnosis: those of the monitored gear and of known faults, in windows of constant speed."""

from __future__ import annotations

from collections.abc import Sequence

from mbd.forces.load_models import HangingLoad
from mbd.parts.drive import SpeedProfile
from pipelines.machine.bearings import BearingFault, RollingBearing
from pipelines.machine.kinematics import pass_orders
from pipelines.machine.layout import Layout
from pipelines.scene.shaft_faults import ShaftFault
from pipelines.scene.tables.analysis import LookedFor
from pipelines.signals.analysis import DiagnosisSettings
from pipelines.signals.pass_lines import PassLines
from pipelines.signals.shaft_lines import ShaftLines


def diagnosis_settings(
    monitored: LookedFor,
    layout: Layout,
    hoist: HangingLoad | None,
    profile: SpeedProfile,
    rolling: Sequence[RollingBearing],
    spalls: Sequence[BearingFault] = (),
    shafts: Sequence[ShaftFault] = (),
) -> DiagnosisSettings | None:
    """The lines and windows of a diagnosis; None if it is not possible.

    Parameters
    ----------
    monitored : signal, gear and windows that are diagnosed
    layout, hoist, profile : the train, its load on ropes, and the speed of its motors
    rolling : bearings whose pass frequencies are listed
    spalls, shafts : faults of bearings and of shafts, whose lines are monitored
    """
    if not monitored.possible:
        return None
    stage = layout.stages[monitored.stage - 1]
    on_wheel = monitored.gear == "wheel"
    shaft = layout.pair_shafts[monitored.stage - 1][on_wheel]
    ratio = layout.shaft_ratios[layout.loaded]
    modes = {
        name: hoist.rope_frequency_at(sum(window) / 2, profile, ratio)
        for name, window in monitored.windows.items()
        if hoist is not None and monitored.speed_is_known
    }
    return DiagnosisSettings(
        revolution_frequency=stage.wheel_frequency if on_wheel else stage.pinion_frequency,
        mesh_frequency=stage.mesh_frequency,
        windows=monitored.windows,
        rope_mode={name: value for name, value in modes.items() if value is not None},
        bearings=_bearing_frequencies(layout, rolling),
        passes=tuple(dict.fromkeys(_pass_lines(layout, rolling, fault) for fault in spalls)),
        turning=tuple(shaft_lines(layout, fault) for fault in shafts),
        sensor=monitored.sensor or "",
        axis=monitored.axis,
        band=monitored.band,
        shaft=f"shaft_{shaft + 1}",
        speed_is_known=monitored.speed_is_known,
    )


def _bearing_frequencies(layout: Layout, rolling: Sequence[RollingBearing]) -> dict[str, float]:
    """Pass frequencies (Hz) of all rolling bearings at the highest motor speed: "bearing_3 BPFO", BPFI, BSF, FTF."""
    return {
        f"{bearing.name} {label}": value for bearing in rolling for label, value in pass_rates(layout, bearing).items()
    }


def pass_rates(layout: Layout, bearing: RollingBearing) -> dict[str, float]:
    """BPFO, BPFI, BSF, FTF (Hz) of a bearing at the highest motor speed."""
    turn = _turns(layout, bearing.shaft)
    return {label: turn * order for label, order in pass_orders(bearing.elements).items()}


def shaft_lines(layout: Layout, fault: ShaftFault) -> ShaftLines:
    """Orders of a faulty shaft at the highest motor speed."""
    return ShaftLines(shaft=f"shaft_{fault.shaft + 1}", frequency=abs(_turns(layout, fault.shaft)))


def _turns(layout: Layout, shaft: int) -> float:
    return layout.turns * layout.shaft_ratios[shaft]


def _pass_lines(layout: Layout, rolling: Sequence[RollingBearing], fault: BearingFault) -> PassLines:
    name = fault.bearing
    rates = pass_rates(layout, next(bearing for bearing in rolling if bearing.name == name))
    label, frequency, spacing, spacing_label = {
        "outer-ring": ("BPFO", rates["BPFO"], 0.0, ""),
        "inner-ring": ("BPFI", rates["BPFI"], _turns(layout, fault.shaft), f"f_shaft_{fault.shaft + 1}"),
        "element": ("2 BSF", 2 * rates["BSF"], rates["FTF"], "FTF"),
    }[fault.spall.on]
    return PassLines(
        label=f"{name} {label}",
        fault=fault.name,
        frequency=frequency,
        spacing=spacing,
        spacing_label=spacing_label,
        spread=fault.slip,
    )
