"""Misalignment angle of bearings: rotation of the shaft's section relative to the seat, about the axes across it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mbd.elements.channel_reading import ChannelKind, Reading
from mbd.elements.component import Component
from mbd.elements.coordinates import Coordinates
from mbd.parts.bearings import BEARING_AXES, BearingSpec
from mbd.parts.part_checks import MachineError


@dataclass(frozen=True, kw_only=True)
class BearingMisalignment(Component):
    """Angles (rad) of the shaft in each bearing about x and z; of a bearing on the ground they are absolute.

    The rotation of a Timoshenko beam is that of its section. Shear adds to the slope of the axis, not to this angle.
    """

    kind: ClassVar[ChannelKind] = ChannelKind(
        variable="bearing_misalignment",
        dims=("bearing", "tilt_axis"),
        quantity="misalignment_",
        labels=("x", "z"),
        text="rotation of the shaft in the bearing relative to its seat",
    )
    bearings: tuple[BearingSpec, ...]

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Names for the angles about x and z of each bearing."""
        return tuple(name for bearing in self.bearings for name in self.kind.spelled(bearing.name))

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """The angles; MachineError if the casing has no rotation of a seat."""
        found = {}
        for bearing in self.bearings:
            if bearing.support == "casing" and not lay.reads_casing(f"{bearing.name}:rx"):
                raise MachineError(
                    f"channel bearing-misalignment: the casing does not state the rotation of the seat of "
                    f"{bearing.name}, because this bearing has no tilting stiffness. Set "
                    "bearings.tilt_stiffness_N_m_per_rad above 0, or delete bearing-misalignment from "
                    "simulation.channels."
                )
            rows = bearing.rows(lay)
            for label, name in zip(self.kind.labels, self.kind.spelled(bearing.name), strict=True):
                found[name] = Reading("rad", displacement=rows[BEARING_AXES.index(f"r{label}")])
        return found
