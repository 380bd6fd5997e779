"""ToothFault: base of the tooth faults, frozen classes of the dimensions in an inspection report, in m and rad.

Face coordinates are those of the gear pair: y from mid face, ends "-y" and "+y".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from fem.options import check_options

if TYPE_CHECKING:
    from fem.contact.wheels.crack_surface import CrackSurface

END = "end of the face where the damage starts"  # text of an option


@dataclass(frozen=True, kw_only=True)
class ToothFault:
    """A fault of a single tooth, with its check against a gear and its contributions to the laws of a pair.

    changes_flank : the tooth remains, with its own compliance and gap, as a variant of the mesh law
    clearance : of the tooth on either flank, m
    """

    changes_flank: ClassVar[bool] = True
    clearance: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        check_options(self, GeometryError)

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a fault that does not fit on the tooth."""

    def compliance(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Compliance (slice, position), m2/N, added by the fault of "pinion" or "wheel" on the flank of the law."""
        return np.zeros((law.face_coordinate.size, law.compliance.size))

    @property
    def surface_angle(self) -> float | None:
        """Angle (rad) of the surface of a crack; None for other faults."""
        return None

    def modes(self, law: MeshLaw, pair: GearPair, gear: str, surface: CrackSurface) -> np.ndarray:
        """Modes (mode, near, slice, position), (m/N)^(1/2), of the added compliance, see `fem.contact.law`.

        Parameters
        ----------
        law, pair, gear : the law of a flank, its gears, and the damaged one, "pinion" or "wheel"
        surface : of that gear, at the angle of the damage
        """
        return np.zeros((0, 3, law.face_coordinate.size, law.compliance.size))

    def gap(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Gap, m, added by the fault: (slice, position), or (position,) if it is constant along the face."""
        return np.zeros(law.compliance.size)

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float | None:
        """Estimated change (m) of the loaded approach `approach` of the mesh by the fault; None: not estimated.

        `alone` is False if all teeth have the fault. Here one tooth pair carries no load, and the others carry its
        share of the mean contact line, 1/max(eps_alpha, eps_beta), at least where lines are complete.
        """
        return approach * lost_share(pair) / (1 - lost_share(pair))


def lost_share(pair: GearPair) -> float:
    """Share of the mean contact line that is lost with a tooth pair."""
    return min(0.95, 1 / max(pair.transverse_contact_ratio, pair.overlap_ratio))


def from_end(face: np.ndarray, face_width: float, end: str) -> np.ndarray:
    """Distance (slice,) of the face coordinates from an end of the face."""
    return face_width / 2 - face if end == "+y" else face_width / 2 + face
