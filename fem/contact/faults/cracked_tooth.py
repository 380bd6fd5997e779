"""A crack in the root fillet, with the added compliance of finite elements with an open slit instead of a closed one.

The extent along the face is rounded to whole slices, with an error of at most half a slice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from fem.contact.faults.tooth_fault import END, ToothFault, from_end
from fem.contact.law import MeshLaw
from fem.contact.slice_frame import law_points
from fem.gears.gear import Gear
from fem.gears.gear_checks import require
from fem.gears.geometry import GearPair
from fem.options import option

if TYPE_CHECKING:
    from fem.contact.wheels.crack_surface import CrackSurface


@dataclass(frozen=True, kw_only=True)
class CrackedTooth(ToothFault):
    """A crack in the root fillet. It is open while the tooth is loaded on the cracked side.

    The depth changes linearly to `far_depth` (m) at the far end of the extent; None: the same depth; 0: a crack across
    a corner.

    It starts where the fillet is at 45 degrees to the radius. The angle pi/2 is straight across the tooth; a smaller
    one points down into the rim. `extent` is its length (m) along the face from `end`; None: the whole face. `flank`
    "drive" or "coast" is the side of its mouth. Load on the other flank closes the crack, which then has no effect.
    """

    depth: float = option(
        unit="mm",
        gt=0,
        text="length of the crack in the transverse section, at the end of the face where it starts",
    )
    far_depth: float | None = option(
        None,
        unit="mm",
        ge=0,
        text="length of the crack at the far end of extent_mm; 0: a crack across a corner; without it: depth_mm",
    )
    angle: float = option(
        math.radians(70.0),
        unit="deg",
        ge=40,
        le=90,
        text="angle between crack and tooth centre line; 90: straight across the tooth, smaller: into the rim",
    )
    extent: float | None = option(
        None, unit="mm", gt=0, text="length of the crack along the face; without it: whole face"
    )
    end: Literal["-y", "+y"] = option("+y", text=END)
    flank: Literal["drive", "coast"] = option("drive", text="side of the tooth where the crack starts")

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a crack without depth, or one that nearly separates the tooth or the rim."""
        from fem.contact.wheels.crack_surface import DEEPEST
        from fem.gears.sector_mesh import root_chord

        label = f"cracked tooth of gear z={gear.teeth}"
        radius, chord = root_chord(gear)
        require(
            0.0 < self.depth <= DEEPEST * chord,
            f"{label}: depth_mm = {1000 * self.depth:.4g} is more than {DEEPEST} of the tooth root thickness of "
            f'{1000 * chord:.4g} mm. Set at most {1000 * DEEPEST * chord:.4g}, or kind = "missing-tooth"',
        )
        far = self.depth if self.far_depth is None else self.far_depth
        require(
            0.0 <= far <= DEEPEST * chord,
            f"{label}: far_depth_mm = {1000 * far:.4g} is more than {DEEPEST} of the tooth root thickness. Set 0 to "
            f"{1000 * DEEPEST * chord:.4g}, or delete it",
        )
        deepest = max(self.depth, far)
        mouth = math.asin(chord / 2 / radius)
        tip = math.hypot(
            radius * math.cos(mouth) - deepest * math.cos(self.angle), chord / 2 - deepest * math.sin(self.angle)
        )
        floor = gear.rim_inner_radius + 0.3 * (gear.root_radius - gear.rim_inner_radius)
        require(
            tip >= floor,
            f"{label}: the crack ends at the diameter {2000 * tip:.6g} mm; it must end above {2000 * floor:.6g} mm, "
            "which "
            "leaves 30 % of the rim. Reduce depth_mm or raise angle_deg",
        )
        require(
            self.extent is None or 0.0 < self.extent <= gear.face_width,
            f"{label}: extent_mm = {1000 * (self.extent or 0.0):.4g} is more than the face width. Set at most "
            f"{1000 * gear.face_width:.4g}, or delete it for the whole face",
        )

    def reach(self, face_width: float) -> tuple[float, float]:
        """Both ends (m) of the cracked part of the face, ascending."""
        half = face_width / 2
        extent = face_width if self.extent is None else self.extent
        return (half - extent, half) if self.end == "+y" else (-half, extent - half)

    def depth_at(self, face: np.ndarray, face_width: float) -> np.ndarray:
        """Depth (m) at face coordinates, 0 beyond the cracked part."""
        extent = face_width if self.extent is None else self.extent
        far = self.depth if self.far_depth is None else self.far_depth
        inwards = from_end(face, face_width, self.end)
        return np.where(inwards <= extent * (1 + 1e-12), self.depth + (far - self.depth) * inwards / extent, 0.0)

    def compliance(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Compliance (slice, position), m2/N, in the cracked slices, on the flank of the mouth.

        Every slice has the compliance of a plane crack of its depth, without support by the uncracked part of the face.
        """
        added = super().compliance(law, pair, gear)
        if self.flank == law.flank:
            from fem.contact.faults.cracked_beam import cracked_beam_compliance
            from fem.contact.faults.cracked_section import crack_compliance

            points = law_points(law, pair)
            plane = cracked_beam_compliance if law.model == "energy" else crack_compliance
            depths = self.depth_at(law.face_coordinate, pair.face_width)
            for depth in np.unique(depths[depths > 0.0]):
                added[depths == depth] += plane(pair, gear, depth, self.angle, points)
        return added

    @property
    def surface_angle(self) -> float:
        """Angle of the crack."""
        return self.angle

    def modes(self, law: MeshLaw, pair: GearPair, gear: str, surface: CrackSurface) -> np.ndarray:
        """Modes of the opening; none on the other flank, whose load closes the crack.

        Parameters
        ----------
        law, pair, gear, surface : those of `ToothFault.modes`
        """
        if self.flank != law.flank:
            return super().modes(law, pair, gear, surface)
        from fem.contact.faults.crack_modes import crack_modes

        face = pair.face_width
        return crack_modes(law, pair, gear, lambda y: self.depth_at(y, face), self.reach(face), surface)

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> None:
        """Not estimated: it is strongly nonlinear in the depth."""
