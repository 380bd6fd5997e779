"""Wear of both flanks: a gap over the profile, on the whole face or from one end of it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from fem.contact.faults.gap_on_slices import FaceParts, gap_on_slices
from fem.contact.faults.tooth_fault import END, ToothFault, from_end
from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.gear_checks import require
from fem.gears.geometry import GearPair
from fem.gears.path import path_points
from fem.options import option

DEEPEST = 0.2  # modules


@dataclass(frozen=True, kw_only=True)
class WornTooth(ToothFault):
    """Wear of both flanks of one tooth, or of all teeth.

    place "flank": constant over the whole flank. "pitch" (pitch point) or "root" (lower end of the active profile): a
    cosine bell that reaches zero at the roll length `width` / 2 (m) on either side. "profile": `parts` of the depth at
    the `diameters` (m), linear between them and constant beyond. extent : length (m) of the worn part of the face, from
    `end`; None: the whole face fading : the wear decreases linearly to zero over the extent; otherwise it is constant
    """

    depth: float = option(unit="um", gt=0, text="largest depth of wear, normal to the flank")
    place: Literal["flank", "pitch", "root", "profile"] = option(
        "flank",
        text="place of the wear; flank: evenly on the whole flank; pitch or root: locally at the pitch point or root; "
        "profile: by diameters_mm and parts",
    )
    width: float | None = option(
        None, unit="mm", gt=0, text='length of local wear along the line of action; for place = "pitch" and "root" only'
    )
    diameters: tuple[float, ...] = option((), unit="mm", gt=0, most=1000, text="diameters of a profile, ascending")
    parts: tuple[float, ...] = option((), ge=0, le=1, most=1000, text="wear at these diameters as a share of depth_um")
    extent: float | None = option(
        None,
        unit="mm",
        gt=0,
        text="length of the wear along the face, for one tooth only; without it: whole face",
    )
    end: Literal["-y", "+y"] = option("+y", text=END)
    fading: bool = option(False, text="true: the wear falls to zero over the extent")

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for wear without depth, or more than the tooth allows."""
        label = f"worn tooth of gear z={gear.teeth}"
        limit = DEEPEST * gear.normal_module
        require(
            0.0 < self.depth <= limit,
            f"{label}: depth_um = {1e6 * self.depth:.4g} is more than {DEEPEST} modules. Set at most {1e6 * limit:.4g}",
        )
        local = self.place in ("pitch", "root")
        require(
            (self.width is not None) == local and (self.width is None or self.width > 0.0),
            f"{label}: width_mm is the width of local wear. "
            + ("Set it" if local else 'Delete it, or set place = "pitch" or "root"'),
        )
        table = self.place == "profile"
        require(
            len(self.diameters) == len(self.parts) and (len(self.parts) >= 2) == table,
            f'{label}: place = "{self.place}" with {len(self.diameters)} diameters_mm and {len(self.parts)} parts. '
            + ("Set two or more of both, equally many" if table else 'Delete them, or set place = "profile"'),
        )
        require(
            all(low < high for low, high in pairwise(self.diameters)),
            f"{label}: diameters_mm of a profile must increase. Correct them",
        )
        require(
            self.extent is None or 0.0 < self.extent <= gear.face_width,
            f"{label}: extent_mm = {1000 * (self.extent or 0.0):.4g} is more than the face width. Set at most "
            f"{1000 * gear.face_width:.4g}, or delete it for the whole face",
        )
        require(not self.fading or self.extent is not None, f"{label}: fading = true needs extent_mm. Set it")

    def gap_at(self, radius: np.ndarray, pair: GearPair, gear: str) -> np.ndarray:
        """Wear (m) at radii of the flank of "pinion" or "wheel", of any shape."""
        own, side = getattr(pair, gear), 0 if gear == "pinion" else 1
        if self.place == "flank":
            return np.full(np.shape(radius), self.depth)
        if self.place == "profile":
            part: np.ndarray = np.interp(2.0 * radius, self.diameters, self.parts)
            return self.depth * part
        assert self.width is not None  # checked
        roll = np.sqrt(np.maximum(radius**2 - own.base_radius**2, 0.0))
        root = min(pair.roll_lengths(xi)[side] for xi in (pair.xi_start, pair.xi_end))
        centre = pair.roll_lengths(0.0)[side] if self.place == "pitch" else root
        bell: np.ndarray = np.cos(np.clip(np.pi * (roll - centre) / self.width, -np.pi / 2, np.pi / 2)) ** 2
        return self.depth * bell

    def gap(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Gap, m: (position,), or (slice, position) if only a part of the face is worn."""
        if self.extent is None:
            xi = law.position_start + law.position_step * np.arange(law.compliance.size)
            return self._profile(xi, pair, gear)
        edge = pair.face_width / 2 - self.extent
        return gap_on_slices(
            law, pair, [edge if self.end == "+y" else -edge], lambda at: self._part_gap(at, pair, gear)
        )

    def _profile(self, xi: np.ndarray, pair: GearPair, gear: str) -> np.ndarray:
        """Gap (m) at positions xi of any shape, on the worn part of the face."""
        points = path_points(pair, xi.ravel(), pair.pinion.normal_module, (np.inf, np.inf))
        radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
        return self.gap_at(radius.reshape(xi.shape), pair, gear)

    def _part_gap(self, at: FaceParts, pair: GearPair, gear: str) -> np.ndarray:
        """Gap (part, position), m, in parts of the face."""
        assert self.extent is not None
        inwards = from_end(at.face, pair.face_width, self.end) / self.extent
        worn = np.clip(1.0 - inwards, 0.0, 1.0) if self.fading else (inwards < 1.0).astype(float)
        return worn[:, None] * self._profile(at.xi, pair, gear)

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """The depth of the wear; for one tooth at most the value of a missing tooth."""
        missing = super().movement(pair, approach, alone=alone)
        assert missing is not None
        return min(self.depth, missing) if alone else self.depth
