"""Model `plane`: finite elements of the whole toothed rings in the transverse section, for slices along the face.

All slices have the compliances of one section (`fem.contact.wheels.plane_section`) and are mutually independent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from fem.contact.law import MeshLaw
from fem.contact.models.mesh_model import MeshModel
from fem.contact.slice_frame import FLANKS, flank_frame, window_fraction
from fem.contact.wheels.plane_section import PlaneSection
from fem.gears.geometry import GearPair


@dataclass(frozen=True, kw_only=True)
class Plane(PlaneSection, MeshModel):
    """Mesh stiffness by plane finite elements of both gears, in slices along the face; it takes seconds.

    The time hardly depends on the number of slices.

    slices : slices of equal width over the face; the other options are those of the section
    """

    seconds: ClassVar[float] = 3.0
    libraries: ClassVar[tuple[str, ...]] = ("numpy", "scipy", "scikit-fem")
    model: Literal["plane"] = "plane"

    def check(self, pair: GearPair) -> None:
        """Refuse a pair without a path of contact."""
        self.path(pair)

    def laws(self, pair: GearPair) -> tuple[MeshLaw, MeshLaw]:
        """The laws of drive and coast flank, with common tables."""
        path = self.path(pair)
        tables = self.tables(pair, path)
        drive, coast = (
            MeshLaw(
                model=self.model,
                **flank_frame(pair, flank, self.slices),
                position_start=float(path.xi[0]),
                position_step=1.0 / self.positions,
                **tables,
                gap=path.gap,
                fraction=window_fraction(path.gap),
            )
            for flank in FLANKS
        )
        return drive, coast
