"""The load of a scene, in SI: drums, ropes, container, ground, and how the container bounces on its rope."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mbd.forces.ground import Ground
from mbd.forces.pendulum import RopePendulum
from mbd.forces.rope import Rope
from mbd.parts.load import Load, StaticTorque
from mbd.parts.machine import STANDARD_GRAVITY
from pipelines.machine.places import shaft_ends
from pipelines.scene.tables.motion import LoadBase, LoadModel, RopePendulumTable, RopeTable
from pipelines.scene.tables.shafts import ShaftTable

if TYPE_CHECKING:
    from mbd.parts.drive import SpeedProfile


@dataclass(frozen=True, kw_only=True)
class Hoist:
    """What hangs on the drums: mass (kg), radius of the drums (m), rope speed at the drum over container speed.

    ``rope_strength`` (N) is the axial stiffness EA of all falls together, None where no container hangs on a rope;
    ``rope_length`` (m) is the free length at t = 0.
    """

    mass: float
    drum_radius: float
    reeving: float
    rope_strength: float | None = None
    rope_length: float = 0.0

    def rope_frequency(self, length: float | None = None) -> float | None:
        """Bounce frequency of the container on its rope, drum held (Hz); None without rope or container."""
        if self.rope_strength is None:
            return None
        stiffness = self.rope_strength / (self.rope_length if length is None else length)
        return math.sqrt(stiffness / self.mass) / (2 * math.pi)

    def rope_length_at(self, time: float, profile: SpeedProfile, ratio: float) -> float:
        """Free rope length (m) at a time (s): that at the start less what the drums, at ``ratio`` of the motors' speed,
        have wound."""
        angle = float(profile.angle(np.array([time]))[0]) * ratio
        return self.rope_length - angle * self.drum_radius / self.reeving


def hoist(table: LoadModel) -> Hoist | None:
    """What hangs on the drums; None where nothing does."""
    if not isinstance(table, LoadBase):
        return None
    common = {
        "mass": table.container_kg,
        "drum_radius": table.si.drum_radius,
        "reeving": table.reeving_ratio,
    }
    if not isinstance(table, RopeTable) or table.container_kg == 0:
        return Hoist(**common)
    strength = table.rope_falls * _rope_strength(table)
    return Hoist(**common, rope_strength=strength, rope_length=table.rope_length_m)


def output_torque(load: LoadBase) -> float:
    """Torque of the hanging weight on the shaft of the drums (N m): m g R / reeving."""
    return load.container_kg * STANDARD_GRAVITY * load.si.drum_radius / load.reeving_ratio


def _rope_strength(load: RopeTable) -> float:
    """Axial stiffness EA of one fall (N), A the metallic area."""
    area = load.rope_fill_factor * math.pi / 4 * load.si.rope_diameter**2
    return load.si.rope_modulus * area


def drums(load: LoadBase, shaft: ShaftTable) -> tuple[float, ...]:
    """y of the drums (m) on their shaft."""
    given: tuple[float, ...] = load.si.drum_positions
    return given or shaft_ends(shaft)


def load_spec(table: LoadBase, shaft: str, places: tuple[float, ...]) -> Load:
    """The load on the drums at `places` (m) of a shaft."""
    radius = table.si.drum_radius
    direction = table.si.rope_direction
    if not isinstance(table, RopeTable) or table.container_kg == 0:
        torque = output_torque(table) / len(places)
        return StaticTorque(shaft=shaft, drums=places, torque=torque, direction=direction, drum_radius=radius)
    ground = None
    if table.ground_level_m is not None:
        ground = Ground(
            level=table.ground_level_m,
            stiffness=table.si.ground_stiffness,
            damping_ratio=table.ground_damping_ratio,
        )
    common: dict[str, Any] = {
        "shaft": shaft,
        "drums": places,
        "container_mass": table.container_kg,
        "drum_radius": radius,
        "falls": table.rope_falls,
        "axial_stiffness": _rope_strength(table),
        "length": table.rope_length_m,
        "reeving": table.reeving_ratio,
        "damping_ratio": table.rope_damping_ratio,
        "direction": direction,
        "ground": ground,
    }
    if isinstance(table, RopePendulumTable):
        return RopePendulum(**common, sway=(table.si.sway_x, table.si.sway_y))
    return Rope(**common)
