"""Kinematics of a scene for the diagnosis of its runs: shafts, gears and pass orders of rolling bearings.

With the lines of known faults of bearings and shafts at the highest motor speed.
"""

from __future__ import annotations

from collections.abc import Sequence

from mbd.parts.rolling_elements import RollingElements, pass_frequencies
from pipelines.machine.layout import TrainLayout
from pipelines.machine.scene_bearings import BearingFault, RollingBearing
from pipelines.scene.shaft_faults import ShaftFault
from pipelines.signals.orders.kinematics import Bearing, Gear, Kinematics, Shaft
from pipelines.signals.pass_lines import PassLines
from pipelines.signals.shaft_lines import ShaftLines

STRIKES = {"outer-ring": "BPFO", "inner-ring": "BPFI", "element": "2 BSF"}  # passes of a spall by its place


def kinematics_of(layout: TrainLayout, rolling: Sequence[RollingBearing]) -> Kinematics:
    """The kinematics of a scene, with the names of its runs, at the highest speed of the drive.

    `rolling` are the bearings with known rolling elements; other bearings have no pass orders.
    """
    first = layout.shaft_ratios[0]
    return Kinematics(
        shafts=tuple(
            Shaft(name=f"shaft_{number}", ratio=abs(ratio / first))
            for number, ratio in enumerate(layout.shaft_ratios, 1)
        ),
        gears=tuple(
            Gear(name=f"stage {stage} {name}", shaft=f"shaft_{shaft + 1}", stage=stage, teeth=gear.teeth, cycle=cycle)
            for stage, (pair, shafts, cycle) in enumerate(
                zip(layout.pairs, layout.pair_shafts, layout.cycles_at_start, strict=True), 1
            )
            for name, gear, shaft in zip(("pinion", "wheel"), (pair.pinion, pair.wheel), shafts, strict=True)
        ),
        bearings=tuple(
            Bearing(name=bearing.name, shaft=f"shaft_{bearing.shaft + 1}", orders=pass_orders(bearing.elements))
            for bearing in rolling
        ),
        frequency=layout.turns * abs(first),
    )


def pass_orders(elements: RollingElements) -> dict[str, float]:
    """BPFO, BPFI, BSF and FTF as orders of the shaft, for a fixed outer race and without slip."""
    per = pass_frequencies(elements)
    return {"BPFO": per.outer, "BPFI": per.inner, "BSF": per.spin, "FTF": per.cage}


def pass_rates(layout: TrainLayout, bearing: RollingBearing) -> dict[str, float]:
    """BPFO, BPFI, BSF, FTF (Hz) of a bearing at the highest motor speed."""
    turn = _turns(layout, bearing.shaft)
    return {label: turn * order for label, order in pass_orders(bearing.elements).items()}


def shaft_lines(layout: TrainLayout, fault: ShaftFault) -> ShaftLines:
    """Orders of a faulty shaft at the highest motor speed."""
    return ShaftLines(shaft=f"shaft_{fault.shaft + 1}", frequency=abs(_turns(layout, fault.shaft)))


def _turns(layout: TrainLayout, shaft: int) -> float:
    return layout.turns * layout.shaft_ratios[shaft]


def pass_lines(layout: TrainLayout, rolling: Sequence[RollingBearing], fault: BearingFault) -> PassLines:
    """Pass frequency, sidebands and slip of a spall in one of the rolling bearings."""
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
