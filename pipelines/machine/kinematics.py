"""Kinematics of a scene for the diagnosis of its runs: shafts, gears and pass orders of rolling bearings."""

from __future__ import annotations

from collections.abc import Sequence

from mbd.parts.rolling_elements import RollingElements, pass_frequencies
from pipelines.machine.bearings import RollingBearing
from pipelines.machine.layout import Layout
from pipelines.signals.orders.kinematics import Bearing, Gear, Kinematics, Shaft


def kinematics_of(layout: Layout, rolling: Sequence[RollingBearing]) -> Kinematics:
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
