"""What follows from a scene before anything is computed: ratios, frequencies, torques, tooth loads."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mbd.parts.machine import STANDARD_GRAVITY
from mbd.parts.train import power_flow
from pipelines.plant.layout import Layout
from pipelines.scene.scene import Scene
from pipelines.scene.tables.motion import RopeTable


@dataclass(frozen=True, kw_only=True)
class StageFacts:
    """One stage at the highest motor speed and the hanging load (SI)."""

    ratio: float
    centre_distance: float
    transverse_contact_ratio: float
    overlap_ratio: float
    mesh_frequency: float
    pinion_frequency: float
    wheel_frequency: float
    pinion_torque: float
    mesh_force: float
    line_load: float
    backlash: float


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Derived quantities of a scene (SI)."""

    motor_speed: float
    total_ratio: float
    output_torque: float
    input_torque: float
    stages: tuple[StageFacts, ...]
    bearing_points: tuple[tuple[float, float, float], ...]
    rope_frequency: float | None
    container_speed: float


def output_torque(scene: Scene) -> float:
    """Torque of the hanging weight on the last shaft (N m): m g R / reeving."""
    load = scene.load
    return load.container_kg * STANDARD_GRAVITY * load.drum_radius_mm / 1000 / load.reeving_ratio


def rope_stiffness(load: RopeTable, length: float) -> float:
    """Stiffness that carries the container (N/m): falls * E A / L, A the metallic area."""
    area = load.rope_fill_factor * math.pi / 4 * (load.rope_diameter_mm / 1000) ** 2
    return load.rope_falls * load.rope_modulus_GPa * 1e9 * area / length


def rope_frequency(scene: Scene, length: float | None = None) -> float | None:
    """Bounce frequency of the container on its rope, drum held (Hz); None without rope or container."""
    load = scene.load
    if not isinstance(load, RopeTable) or load.container_kg == 0:
        return None
    stiffness = rope_stiffness(load, load.rope_length_m if length is None else length)
    return math.sqrt(stiffness / load.container_kg) / (2 * math.pi)


def bearing_names(scene: Scene) -> list[tuple[str, int, int]]:
    """Name, shaft and place on it (0-based) of every bearing: bearing_1, bearing_2, ... carried by the casing, numbered
    in shaft order from -y; ground_bearing_1, ... by the ground."""
    found: list[tuple[str, int, int]] = []
    counts = {"casing": 0, "ground": 0}
    for number, shaft in enumerate(scene.shafts):
        supports = shaft.bearing_supports or ("casing",) * len(shaft.bearing_positions_mm)
        for place, support in enumerate(supports):
            counts[support] += 1
            found.append((f"{'' if support == 'casing' else 'ground_'}bearing_{counts[support]}", number, place))
    return found


def bearing_points(scene: Scene, layout: Layout) -> tuple[tuple[float, float, float], ...]:
    """(x, y, z) of bearing_1, bearing_2, ... (m), those that the casing carries."""
    return tuple(
        (layout.axes[shaft][0], scene.shafts[shaft].bearing_positions_mm[place] / 1000, layout.axes[shaft][1])
        for name, shaft, place in bearing_names(scene)
        if not name.startswith("ground")
    )


def power_flows(scene: Scene, layout: Layout) -> list[float]:
    """Share of the load's power that each stage, then each coupling carries without losses; parallel paths share alike,
    see `mbd.parts.train`."""
    flows = [*layout.pair_shafts, *((c.shafts[0] - 1, c.shafts[1] - 1) for c in scene.couplings)]
    return power_flow(len(scene.shafts), flows, [layout.driven], layout.loaded)[: len(flows)].tolist()


def input_torque(scene: Scene, layout: Layout) -> float:
    """Torque of the hanging weight on the driven shaft without losses (N m)."""
    return output_torque(scene) / layout.ratio


def motor_speed(scene: Scene) -> float:
    """Highest motor speed (rad/s)."""
    return max(abs(value) for value in scene.drive.speeds_rpm) / 60 * 2 * math.pi


def stage_facts(scene: Scene, layout: Layout) -> list[StageFacts]:
    """Every stage at the highest motor speed and the hanging load."""
    shares = power_flows(scene, layout)
    stages = []
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pairs, strict=True)):
        pinion_speed = layout.shaft_ratios[layout.pair_shafts[number][0]]
        turn = motor_speed(scene) * pinion_speed / (2 * math.pi)
        pinion_torque = input_torque(scene, layout) * shares[number] / pinion_speed
        force = pinion_torque / pair.pinion.base_radius
        stages.append(
            StageFacts(
                ratio=pair.ratio,
                centre_distance=pair.axis_distance,
                transverse_contact_ratio=pair.transverse_contact_ratio,
                overlap_ratio=pair.overlap_ratio,
                mesh_frequency=turn * stage.pinion_teeth,
                pinion_frequency=turn,
                wheel_frequency=turn / pair.ratio,
                pinion_torque=pinion_torque,
                mesh_force=force,
                line_load=abs(pinion_torque) / pair.working_radii[0] / pair.face_width,
                backlash=pair.backlash,
            )
        )
    return stages


def derive(scene: Scene, layout: Layout) -> Facts:
    """All derived quantities."""
    speed = motor_speed(scene)
    stages = stage_facts(scene, layout)
    drum_speed = speed * layout.shaft_ratios[layout.loaded] * scene.load.drum_radius_mm / 1000
    return Facts(
        motor_speed=speed,
        total_ratio=layout.ratio,
        output_torque=output_torque(scene),
        input_torque=input_torque(scene, layout),
        stages=tuple(stages),
        bearing_points=bearing_points(scene, layout),
        rope_frequency=rope_frequency(scene),
        container_speed=drum_speed / scene.load.reeving_ratio,
    )
