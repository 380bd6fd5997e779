"""Faults of single teeth, with their severity: missing, chipped, cracked, worn.

Each class holds what an inspection report would state, in m and rad, and checks itself against a gear. Faces are those
of the gear pair: y from mid face, end "-y" or "+y". What a fault does to a mesh law stands in
`fem.contact.wheels.damage`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.gears.gear import Gear
from fem.gears.rack import GeometryError, require
from fem.gears.sector import root_chord

ENDS = ("-y", "+y")
DEEPEST_CRACK = 0.8  # of the tooth's root chord
CRACK_ANGLES = (math.radians(40.0), math.radians(90.0))
DEEPEST_WEAR = 0.2  # modules


def missing_tooth(clearance: np.ndarray, tooth: int) -> np.ndarray:
    """The clearances (z,) of one flank with tooth number `tooth` (0 .. z - 1) broken off: +inf there, a new array.

    Apply it to the drive and the coast flank alike. The compliance of its neighbours is left as it is: it changes by
    about 1 %.

    Raises
    ------
    GeometryError : no such tooth
    """
    result = np.array(clearance, dtype=float)
    if not 0 <= tooth < result.size:
        raise GeometryError(f"missing tooth: number is {tooth!r}; the gear has teeth 0 to {result.size - 1}")
    result[tooth] = np.inf
    return result


@dataclass(frozen=True, kw_only=True)
class ChippedTooth:
    """A piece broken off a tooth: `depth` from the tip (m) over `extent` of the face (m) from one end.

    corner: the depth falls evenly to nothing over the extent (a broken tip corner); otherwise it is the same over it.
    """

    extent: float
    depth: float
    end: str = "+y"
    corner: bool = False

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a chip that does not fit on the tooth."""
        label = f"chipped tooth of gear z={gear.teeth}"
        require(self.end in ENDS, f"{label}: end is {self.end!r}; choose one of {', '.join(ENDS)}")
        require(
            0.0 < self.extent <= gear.face_width,
            f"{label}: extent is {self.extent:.4g} m; give a value in (0, {gear.face_width:.4g}] m, the face width",
        )
        height = gear.tip_radius - gear.root_radius
        require(
            0.0 < self.depth <= height * (1 + 1e-9),
            f"{label}: depth is {self.depth:.4g} m; give a value in (0, {height:.4g}] m, the tooth height",
        )

    def depth_at(self, face: np.ndarray, face_width: float) -> np.ndarray:
        """Depth (m) of the chip below the tip circle at the face coordinates (slice,)."""
        inwards = face_width / 2 - face if self.end == "+y" else face_width / 2 + face
        if self.corner:
            return self.depth * np.clip(1.0 - inwards / self.extent, 0.0, None)
        return np.where(inwards < self.extent, self.depth, 0.0)


@dataclass(frozen=True, kw_only=True)
class CrackedTooth:
    """A crack in the root fillet of one flank: `depth` (m) along it, `angle` to the tooth's centre line (rad).

    It starts where the fillet runs at 45 degrees to the radius; angle pi/2 goes straight across the tooth, less goes
    down into the rim. `extent` (m) of the face from `end`, None: the whole face. flank "drive" or "coast": the side of
    the mouth. Under load on the other flank the crack is pressed shut and does nothing.
    """

    depth: float
    angle: float = math.radians(70.0)
    extent: float | None = None
    end: str = "+y"
    flank: str = "drive"

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a crack that is none or nearly cuts the tooth or the rim off."""
        label = f"cracked tooth of gear z={gear.teeth}"
        require(self.end in ENDS, f"{label}: end is {self.end!r}; choose one of {', '.join(ENDS)}")
        require(self.flank in ("drive", "coast"), f"{label}: flank is {self.flank!r}; choose 'drive' or 'coast'")
        low, high = CRACK_ANGLES
        require(
            low - 1e-9 <= self.angle <= high + 1e-9,
            f"{label}: angle is {math.degrees(self.angle):.4g} deg to the centre line; give a value in "
            f"[{math.degrees(low):.0f}, {math.degrees(high):.0f}] deg",
        )
        radius, chord = root_chord(gear)
        require(
            0.0 < self.depth <= DEEPEST_CRACK * chord,
            f"{label}: depth is {self.depth:.4g} m; give a value in (0, {DEEPEST_CRACK * chord:.4g}] m, "
            f"{DEEPEST_CRACK} of the tooth root thickness {chord:.4g} m; cut through, it is a missing tooth",
        )
        mouth = math.asin(chord / 2 / radius)
        tip = math.hypot(
            radius * math.cos(mouth) - self.depth * math.cos(self.angle), chord / 2 - self.depth * math.sin(self.angle)
        )
        floor = gear.rim_inner_radius + 0.3 * (gear.root_radius - gear.rim_inner_radius)
        require(
            tip >= floor,
            f"{label}: the crack ends at radius {tip:.6g} m; it must stay above {floor:.6g} m, 30 % of the rim: reduce "
            "depth or raise angle",
        )
        require(
            self.extent is None or 0.0 < self.extent <= gear.face_width,
            f"{label}: extent is {self.extent!r} m; give a value in (0, {gear.face_width:.4g}] m or leave it out",
        )

    def covers(self, face: np.ndarray, face_width: float) -> np.ndarray:
        """Which face coordinates (slice,) lie on the cracked part."""
        if self.extent is None:
            return np.ones(np.shape(face), dtype=bool)
        inwards = face_width / 2 - face if self.end == "+y" else face_width / 2 + face
        return np.asarray(inwards < self.extent)


@dataclass(frozen=True, kw_only=True)
class WornTooth:
    """Material worn off both flanks: `depth` (m, normal to the flank) at the worst place.

    place "flank": even over the whole flank. "pitch" (pitch point) or "root" (lower end of the active profile): a
    cosine bell that has fallen to nothing at the roll length `width` / 2 (m) to either side.
    """

    depth: float
    place: str = "flank"
    width: float | None = None

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for wear that is none or eats the tooth up."""
        label = f"worn tooth of gear z={gear.teeth}"
        limit = DEEPEST_WEAR * gear.normal_module
        require(
            0.0 < self.depth <= limit,
            f"{label}: depth is {self.depth:.4g} m; give a value in (0, {limit:.4g}] m, {DEEPEST_WEAR} modules",
        )
        require(
            self.place in ("flank", "pitch", "root"),
            f"{label}: place is {self.place!r}; choose 'flank', 'pitch' or 'root'",
        )
        require(
            (self.width is None) == (self.place == "flank") and (self.width is None or self.width > 0.0),
            f"{label}: width is {self.width!r} m with place {self.place!r}; local wear needs a width > 0, even wear "
            "none",
        )

    def gap_at(self, roll: np.ndarray, pitch_roll: float, root_roll: float) -> np.ndarray:
        """Wear (m) at the roll lengths (position,); those of pitch point and root end are given."""
        if self.width is None:
            return np.full(np.shape(roll), self.depth)
        centre = pitch_roll if self.place == "pitch" else root_roll
        return self.depth * np.cos(np.clip(np.pi * (roll - centre) / self.width, -np.pi / 2, np.pi / 2)) ** 2


Damage = ChippedTooth | CrackedTooth | WornTooth  # what becomes a variant of a mesh law
