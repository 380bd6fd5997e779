"""Lines of known faults of bearings and shafts, and pass frequencies, at the highest motor speed."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.machine.bearings import BearingFault, RollingBearing
from pipelines.machine.kinematics import pass_orders
from pipelines.machine.layout import Layout
from pipelines.scene.shaft_faults import ShaftFault
from pipelines.signals.pass_lines import PassLines
from pipelines.signals.shaft_lines import ShaftLines


def pass_rates(layout: Layout, bearing: RollingBearing) -> dict[str, float]:
    """BPFO, BPFI, BSF, FTF (Hz) of a bearing at the highest motor speed."""
    turn = _turns(layout, bearing.shaft)
    return {label: turn * order for label, order in pass_orders(bearing.elements).items()}


def shaft_lines(layout: Layout, fault: ShaftFault) -> ShaftLines:
    """Orders of a faulty shaft at the highest motor speed."""
    return ShaftLines(shaft=f"shaft_{fault.shaft + 1}", frequency=abs(_turns(layout, fault.shaft)))


def _turns(layout: Layout, shaft: int) -> float:
    return layout.turns * layout.shaft_ratios[shaft]


def pass_lines(layout: Layout, rolling: Sequence[RollingBearing], fault: BearingFault) -> PassLines:
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
