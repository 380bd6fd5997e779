"""The load of a scene, in SI: drums, ropes, container, ground."""

from __future__ import annotations

import math
from typing import Any

from mbd.forces.ground import Ground
from mbd.forces.pendulum import RopePendulum
from mbd.forces.rope import Rope
from mbd.parts.load import Load, StaticTorque
from pipelines.plant.facts import output_torque
from pipelines.plant.layout import Layout
from pipelines.scene.scene import Scene
from pipelines.scene.tables.motion import RopePendulumTable, RopeTable


def drums(scene: Scene, layout: Layout) -> tuple[float, ...]:
    """y of the drums (m)."""
    given = tuple(y / 1000 for y in scene.load.drum_positions_mm)
    return given or shaft_ends(scene, layout.loaded)


def shaft_ends(scene: Scene, shaft: int) -> tuple[float, float]:
    """y of the two ends of a shaft (m)."""
    sections = scene.shafts[shaft].sections
    return sections[0].start_mm / 1000, sections[-1].end_mm / 1000


def load_spec(scene: Scene, layout: Layout) -> Load:
    """The load on the drums."""
    table, shaft, places = scene.load, f"shaft_{layout.loaded + 1}", drums(scene, layout)
    radius = table.drum_radius_mm / 1000
    direction = None if table.rope_direction_deg is None else math.radians(table.rope_direction_deg)
    if not isinstance(table, RopeTable) or table.container_kg == 0:
        torque = output_torque(scene) / len(places)
        return StaticTorque(shaft=shaft, drums=places, torque=torque, direction=direction, drum_radius=radius)
    area = table.rope_fill_factor * math.pi / 4 * (table.rope_diameter_mm / 1000) ** 2
    ground = None
    if table.ground_level_m is not None:
        ground = Ground(
            level=table.ground_level_m,
            stiffness=table.ground_stiffness_N_per_um * 1e6,
            damping_ratio=table.ground_damping_ratio,
        )
    common: dict[str, Any] = {
        "shaft": shaft,
        "drums": places,
        "container_mass": table.container_kg,
        "drum_radius": radius,
        "falls": table.rope_falls,
        "axial_stiffness": table.rope_modulus_GPa * 1e9 * area,
        "length": table.rope_length_m,
        "reeving": table.reeving_ratio,
        "damping_ratio": table.rope_damping_ratio,
        "direction": direction,
        "ground": ground,
    }
    if isinstance(table, RopePendulumTable):
        return RopePendulum(**common, sway=(math.radians(table.sway_x_deg), math.radians(table.sway_y_deg)))
    return Rope(**common)
