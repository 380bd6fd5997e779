"""Parts of the machine and recorded channels, in SI: the input of the step `simulate` besides mesh laws and casing.

This module does not import the scene. A stored result thus depends on the values, not on the code that converts them.
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
    """Deviations and faults of the teeth of a gear; the n-th tooth of `damaged` is variant n of the mesh law.

    `deviations` are sampled with the seed of the gear, `prescribed` ones are given; None if there are none.
    `clearances` are pairs of tooth number and clearance on both flanks by a fault, m (inf for a missing tooth).
    """

    deviations: RandomDeviations | None
    prescribed: PrescribedDeviations | None
    clearances: tuple[tuple[int, float], ...]
    damaged: tuple[int, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class GearMesh(GearedShafts):
    """A gear mesh of the machine with deviations and faults of its teeth, without its mesh laws."""

    pair: GearPair
    pinion: GearTeeth
    wheel: GearTeeth


@dataclass(frozen=True, eq=False, kw_only=True)
class MachineParts(Train):
    """The parts of the multibody model, without mesh laws and casing."""

    meshes: tuple[GearMesh, ...]


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """Recorded channels besides those of the machine: sensors on the casing, or journals if there is no casing."""

    sensors: tuple[str, ...]
    journals: bool

    def channels(self, machine: Train) -> tuple[str, ...]:
        """Names of all recorded channels of a machine."""
        names = channels.channel_names(machine, self.sensors)
        if self.journals:
            names += tuple(
                channels.journal_acceleration(bearing.name, axis)
                for bearing in machine.bearings
                for axis in channels.DIRECTIONS
            )
        return names
