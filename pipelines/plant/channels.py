"""The channels that the motion of a scene records."""

from __future__ import annotations

from mbd.coordinates import channels
from mbd.parts.machine import Machine
from pipelines.scene.scene import Scene


def wanted_channels(scene: Scene, machine: Machine) -> tuple[str, ...]:
    """All channels of the machine with the scene's sensors; without a casing, the journals stand in for sensors."""
    names = channels.channel_names(machine, tuple(sensor.name for sensor in scene.sensors))
    if scene.casing.model == "none":
        names += tuple(channels.journal_acceleration(b.name, a) for b in machine.bearings for a in channels.DIRECTIONS)
    return names
