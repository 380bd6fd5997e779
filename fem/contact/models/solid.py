"""Model `solid`: 3-D finite elements of both wheels, as whole rings with free end faces, and contact along the face.

One sector of each wheel, in 27-node hexahedra, is condensed and closed to the ring exactly
(`fem.contact.wheels.solid_ring`). The compliances between all contacts are stored (`fem.contact.wheels.compliance`):
the effect of a load on its neighbours along the face, on the tooth pairs before and after it, and at the ends of the
face. Loads, tilts, reliefs, missing teeth and both flanks are solutions with this one tensor
(`fem.contact.wheels.direct_contact`).

Range: bodies with free end faces, solid or a rim on a web at its position along the face. A web wider than the face is
modelled as a ring with its modulus raised by b_s / b. The Hertz contact should be narrower than a slice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from fem.contact.law import MeshLaw
from fem.contact.models.mesh_model import MeshModel
from fem.contact.wheels.plane_section import PlaneSection
from fem.gears.geometry import GearPair
from fem.options import option

if TYPE_CHECKING:
    from fem.contact.wheels.compliance import ContactCompliance
    from fem.contact.wheels.crack_surface import CrackSurfaceSpec

SECTION = 0.25  # section refinement relative to `sector_mesh`: 0.2 m_n along the flank
PATCH = 0.2  # half-width of the patches, in m_n
PLACES = 31  # along the face, of the compliance from which laws of any number of slices are condensed
MOST_ALONG = 16  # elements of a crack surface along the face, times the refinement


@dataclass(frozen=True, kw_only=True)
class Solid(MeshModel):
    """Mesh stiffness by 3-D finite elements of both gears, with coupled slices; it takes up to a minute.

    Parameters
    ----------
    slices : slices of equal width over the face
    refinement : divides all element sizes of section and face and the patches (1: 0.2 m_n along the flank, 8 elements
        along the face)
    positions : mesh positions per cycle
    """

    seconds: ClassVar[float] = 3.0
    libraries: ClassVar[tuple[str, ...]] = ("numpy", "scipy", "scikit-fem")
    places_webs: ClassVar[bool] = True
    model: Literal["solid"] = "solid"
    slices: int = option(31, ge=3, le=101, text="number of slices along the face")
    refinement: float = option(1.0, ge=0.6, le=3, text="factor that divides all element sizes")
    positions: int = option(32, ge=8, le=512, text="mesh positions per base pitch that are solved")

    def axial_elements(self, pair: GearPair) -> int:
        """Number of elements along the face: 8, or more so that none is longer than 1.25 m_n; times the refinement."""
        longest = 1.25 * pair.pinion.normal_module
        return math.ceil(self.refinement * max(8.0, pair.face_width / longest) - 1e-9)

    def crack_surface(self, pair: GearPair, gear: str, angle: float) -> CrackSurfaceSpec:
        """The crack surface in space, with the elements of the model along the face, up to `MOST_ALONG`."""
        from fem.contact.wheels.crack_surface import CrackSurfaceSpec

        most = math.ceil(self.refinement * MOST_ALONG)
        return CrackSurfaceSpec(
            gear=getattr(pair, gear),
            material=getattr(pair, f"{gear}_material"),
            angle=angle,
            face_width=pair.face_width,
            refinement=self.refinement,
            axial_elements=min(self.axial_elements(pair), most),
        )

    @property
    def plane(self) -> PlaneSection:
        """The section for the compliance of a load uniform along the face, and for the path of contact."""
        return PlaneSection(refinement=max(1.0, self.refinement), positions=2 * self.positions)

    def check(self, pair: GearPair) -> None:
        """Refuse a pair without a path of contact."""
        self.plane.path(pair)

    def laws(self, pair: GearPair) -> tuple[MeshLaw, MeshLaw]:
        """The laws of drive and coast flank, condensed (`solid_condensation`) from one compliance if valid for both."""
        from fem.contact.models.solid_condensation import condense

        drive = self.compliance(pair, "drive", PLACES)
        coast = drive if drive.flank == 0 else self.compliance(pair, "coast", PLACES)
        return (
            condense(drive, pair, "drive", self.plane, self.model, self.slices),
            condense(coast, pair, "coast", self.plane, self.model, self.slices),
        )

    def compliance(self, pair: GearPair, flank: str = "drive", places: int | None = None) -> ContactCompliance:
        """Compliances between all contacts of one flank, or of both unless a web is offset.

        places : number along the face; by default the number of slices
        """
        from fem.contact.wheels.compliance import contact_compliance

        return contact_compliance(
            pair,
            1 if flank == "drive" else -1,
            slices=places or self.slices,
            positions=self.positions,
            section_refinement=SECTION * self.refinement,
            axial_elements=self.axial_elements(pair),
            plane=self.plane,
            patch=PATCH / self.refinement,
        )
