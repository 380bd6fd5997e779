"""Load on the drums: a constant torque, or a container on ropes.

`Rope`: the container (mass m) hangs on n falls that lead to the drums; a drum angle phi lifts it by
phi R/reeving. A drum carries n/drums falls of the stiffness k = (n/drums) EA/L with the length
L = L_0 - phi R/reeving of the rigidly rolling train, and the force max(0, k s + c s') while the stretch
s = phi R/reeving - x > 0; else the rope is slack. c = 2 zeta sqrt(k m/drums).

With a direction d (unit vector across the shaft) the ropes also pull the drum: it moves by u and s = (phi R - d . u)/
reeving - x, so that F/reeving acts along d. Without one the pull is balanced at the drum. `RopePendulum` lets the
container swing, a `Ground` may carry it; both are in `mbd.hanging`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeGuard

import numpy as np

from mbd.checks import MachineError, finite, not_negative, positive
from mbd.drive import SpeedProfile
from mbd.hanging import Ground

NO_DRUM = "load: no drum; give at least one y position on the output shaft."


@dataclass(frozen=True, kw_only=True)
class StaticTorque:
    """A constant torque (N m, lowering positive) on each drum, at the positions ``drums`` (m) of ``shaft``.

    With a ``direction`` (rad, from +x to +z) the torque is that of a rope, which pulls along it with
    torque/``drum_radius``.
    """

    shaft: str
    drums: tuple[float, ...]
    torque: float
    direction: float | None = None
    drum_radius: float = 0.0
    model: Literal["static-torque"] = "static-torque"

    def __post_init__(self) -> None:
        if not self.drums:
            raise MachineError(NO_DRUM)
        finite("load torque", self.torque)
        if self.direction is not None:
            finite("load direction", self.direction)
            positive("load drum_radius", self.drum_radius, "A rope that pulls the drum leaves it at some radius.")


@dataclass(frozen=True, kw_only=True)
class Rope:
    """A container on ropes; ``axial_stiffness`` is EA of one rope (N), ``falls`` their number over all drums."""

    shaft: str
    drums: tuple[float, ...]
    container_mass: float
    drum_radius: float
    falls: int
    axial_stiffness: float
    length: float
    reeving: float = 2.0
    damping_ratio: float = 0.02
    follow_length: bool = True  # False: keep the stiffness of the initial length
    direction: float | None = None  # rad from +x to +z in which the ropes pull the drums
    ground: Ground | None = None
    model: Literal["rope", "rope-pendulum"] = "rope"

    def __post_init__(self) -> None:
        if not self.drums:
            raise MachineError(NO_DRUM)
        for name in ("container_mass", "drum_radius", "falls", "axial_stiffness", "length", "reeving"):
            positive(f"rope {name}", getattr(self, name))
        not_negative("rope damping_ratio", self.damping_ratio)
        if self.direction is not None:
            finite("rope direction", self.direction)

    @property
    def travel_per_radian(self) -> float:
        """Rise of the container per radian of the drum (m)."""
        return self.drum_radius / self.reeving

    @property
    def stiffness_times_length(self) -> float:
        """EA of all falls of one drum (N): k = this / L."""
        return self.falls * self.axial_stiffness / len(self.drums)

    @property
    def stands(self) -> bool:
        """Whether the container stands on the ground at t = 0 with the rope slack."""
        return self.ground is not None and self.ground.level > 0.0


@dataclass(frozen=True, kw_only=True)
class RopePendulum(Rope):
    """The same, swinging below a trolley at rest; ``sway`` (rad) in x and y at t = 0, where it is let go."""

    sway: tuple[float, float] = (0.0, 0.0)
    model: Literal["rope", "rope-pendulum"] = "rope-pendulum"

    def __post_init__(self) -> None:
        super().__post_init__()
        for angle in self.sway:
            if not abs(angle) < math.radians(75):
                raise MachineError(f"rope sway {angle!r} rad must be below 75 deg.")
        if self.ground is not None:
            raise MachineError("rope: a swinging container has no ground under it; use the load model 'rope'.")


Load = StaticTorque | Rope | RopePendulum


def vertical_rope(load: Load) -> TypeGuard[Rope]:
    """Whether the container hangs on ropes that stay vertical."""
    return isinstance(load, Rope) and not isinstance(load, RopePendulum)


def pull_axis(direction: float | None) -> tuple[float, float, float]:
    """Unit vector (x, y, z) of the ropes' pull at the drum; zero if it is balanced there."""
    return (0.0, 0.0, 0.0) if direction is None else (math.cos(direction), 0.0, math.sin(direction))


def rope_reference(load: Rope) -> tuple[float, float]:
    """Stiffness (N/m) and damping (N s/m) of the ropes of one drum at their length at t = 0."""
    stiffness = load.stiffness_times_length / load.length
    return stiffness, 2 * load.damping_ratio * math.sqrt(stiffness * load.container_mass / len(load.drums))


def check_wound_rope(load: Rope, ratio: float, profile: SpeedProfile, end: float) -> None:
    """Raise MachineError if the drums, at ``ratio`` times the motor speed, would wind all rope before ``end`` (s)."""
    if not load.follow_length:
        return
    corners = profile.times[(profile.times > 0.0) & (profile.times < end)]
    times = np.concatenate([np.linspace(0.0, end, 1001), corners])
    wound = load.travel_per_radian * ratio * profile.angle(times)
    if wound.max() >= load.length:
        when = times[wound >= load.length].min()
        raise MachineError(
            f"rope: its {load.length:.4g} m are wound up at t = {when:.4g} s (by {end:.4g} s the drums would take "
            f"{wound.max():.4g} m). Start with a longer rope, or lift less."
        )
