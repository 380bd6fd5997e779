"""The parts of the machine and of its motion, in SI: what the step `simulate` reads besides laws and casing.

No scene is known here: a result hangs on the values, not on the code that converts them.
"""

from __future__ import annotations

from dataclasses import dataclass

from fem.gears.deviations import RandomDeviations
from fem.gears.geometry import GearPair
from fem.gears.prescribed import PrescribedDeviations
from mbd.parts import channels
from mbd.parts.gear_mesh import GearedShafts
from mbd.parts.machine import Train


@dataclass(frozen=True, kw_only=True)
class GearTeeth:
    """What is particular about the teeth of a gear; the n-th damaged tooth is variant n of the mesh law.

    `deviations` are sampled with the seed of the gear, `prescribed` ones stated; None: there are none.
    `clearances` are numbers of teeth with what their faults add on either flank, m (inf: the tooth is missing).
    """

    deviations: RandomDeviations | None
    prescribed: PrescribedDeviations | None
    clearances: tuple[tuple[int, float], ...]
    damaged: tuple[int, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class GearMesh(GearedShafts):
    """A gear pair in the machine without its laws, with what is particular about its teeth."""

    pair: GearPair
    pinion: GearTeeth
    wheel: GearTeeth


@dataclass(frozen=True, eq=False, kw_only=True)
class MachineParts(Train):
    """Everything that the multibody model is made of but the laws of its meshes and its casing."""

    meshes: tuple[GearMesh, ...]


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """What is recorded beside the machine's own channels: the sensors, and without a casing the journals instead."""

    sensors: tuple[str, ...]
    journals: bool

    def channels(self, machine: Train) -> tuple[str, ...]:
        """All channels of a machine that are recorded."""
        names = channels.channel_names(machine, self.sensors)
        if self.journals:
            names += tuple(
                channels.journal_acceleration(bearing.name, axis)
                for bearing in machine.bearings
                for axis in channels.DIRECTIONS
            )
        return names
