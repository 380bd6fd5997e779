"""What follows from a plant before anything is computed: ratios, frequencies, torques, tooth loads."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mbd.forces.load_models import HangingLoad
from mbd.parts.train import power_flow
from pipelines.machine.layout import Layout

USUAL_LINE_LOAD = 100e3  # N/m


@dataclass(frozen=True, kw_only=True)
class StageFacts:
    """One stage at the highest motor speed and the largest load (SI)."""

    ratio: float
    centre_distance: float
    transverse_contact_ratio: float
    overlap_ratio: float
    mesh_frequency: float
    pinion_frequency: float
    wheel_frequency: float
    pinion_torque: float
    mesh_force: float
    shown_force: float  # at which curves and contacts are shown: without a load that of USUAL_LINE_LOAD
    line_load: float
    backlash: float


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Derived quantities of a plant (SI)."""

    motor_speed: float
    total_ratio: float
    output_torque: float
    input_torque: float
    stages: tuple[StageFacts, ...]
    rope_frequency: float | None
    container_speed: float | None  # None where nothing is hoisted


def power_flows(layout: Layout) -> list[float]:
    """Power over motor speed (N m) that each stage, then each coupling carries without losses; parallel paths share
    alike, see `mbd.parts.train`."""
    flows = [*layout.pair_shafts, *layout.coupling_shafts]
    drawn = np.array(layout.drawn) * np.array(layout.shaft_ratios)
    return power_flow(flows, [layout.driven], drawn)[: len(flows)].tolist()


def input_torque(layout: Layout) -> float:
    """Torque of all that is drawn on the driven shaft without losses (N m)."""
    return float(np.dot(layout.drawn, layout.shaft_ratios))


def motor_speed(layout: Layout) -> float:
    """Highest motor speed (rad/s)."""
    return layout.turns * 2 * math.pi


def stage_facts(layout: Layout) -> list[StageFacts]:
    """Every stage at the highest motor speed and the largest load."""
    flows = power_flows(layout)
    stages = []
    for number, pair in enumerate(layout.pairs):
        pinion_speed = layout.shaft_ratios[layout.pair_shafts[number][0]]
        frequency = motor_speed(layout) * pinion_speed / (2 * math.pi)
        pinion_torque = flows[number] / pinion_speed
        force = pinion_torque / pair.pinion.base_radius
        stages.append(
            StageFacts(
                ratio=pair.ratio,
                centre_distance=pair.axis_distance,
                transverse_contact_ratio=pair.transverse_contact_ratio,
                overlap_ratio=pair.overlap_ratio,
                mesh_frequency=frequency * pair.pinion.teeth,
                pinion_frequency=frequency,
                wheel_frequency=frequency / pair.ratio,
                pinion_torque=pinion_torque,
                mesh_force=force,
                shown_force=force or USUAL_LINE_LOAD * pair.face_width,
                line_load=abs(pinion_torque) / pair.working_radii[0] / pair.face_width,
                backlash=pair.backlash,
            )
        )
    return stages


def derive(layout: Layout, hoist: HangingLoad | None) -> Facts:
    """All derived quantities."""
    speed = motor_speed(layout)
    return Facts(
        motor_speed=speed,
        total_ratio=layout.ratio,
        output_torque=layout.load_torque,
        input_torque=input_torque(layout),
        stages=tuple(stage_facts(layout)),
        rope_frequency=None if hoist is None else hoist.rope_frequency(),
        container_speed=(
            None
            if hoist is None
            else speed * layout.shaft_ratios[layout.loaded] * hoist.drum_radius / hoist.reeving_ratio
        ),
    )
