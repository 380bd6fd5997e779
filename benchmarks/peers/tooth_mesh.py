"""One pitch of a gear as 20-node hexahedra: a tooth on the true profile and the body under it, down to the bore.

A sector is a lattice (radial, around, along the face) with odd counts, of which an element uses three each way. Its
rows follow the contact line: at every face station they are finest where the two flanks touch, so that a contact of
0.07 mm width is resolved along an inclined line without a fine mesh everywhere.

Frame of a sector: gear axis along z, tooth centre line along +x, loaded flank at positive angles. Lengths m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from fem.gears.gear import Gear
from fem.gears.profile import form_radius, half_tooth_profile, roll_length

Lattice = np.ndarray  # (radial, around, face)


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Numbers of elements of a sector, and the size of the smallest (m): `contact` along the flank at the contact line.

    below, above: rows on the involute under and over the contact line; fillet: rows from mid fillet to the form circle;
    across: columns of the tooth; land: columns on each root land; layers: from root to bore; face: along the face.
    even: rows of equal size on each side of the contact line, so that the two flanks match there.
    """

    contact: float
    below: int
    above: int
    fillet: int
    across: int
    land: int
    layers: int
    face: int
    even: int = 0


@dataclass(frozen=True, eq=False, kw_only=True)
class Sector:
    """Radii (m) and angles (rad, from the tooth centre line) of the body and the tooth; they share one line of nodes.

    body_*: (layers, around, face) from the root to the bore; tooth_*: (rows, columns, face), row 0 lies on the body,
    the last column is the loaded flank; first: column of the body where the tooth begins; contact_row: first row on the
    involute; depth (layers,): 0 at the root, 1 at the bore; station (face,): -1/2 to 1/2.
    """

    body_radius: Lattice
    body_angle: Lattice
    tooth_radius: Lattice
    tooth_angle: Lattice
    first: int
    contact_row: int
    depth: np.ndarray
    station: np.ndarray


@dataclass(frozen=True)
class Profile:
    """The flank of a gear by arc length: negative on the fillet, 0 at the form circle, up to the tip (m)."""

    gear: Gear

    @cached_property
    def form_arc(self) -> float:
        """Involute arc from the base circle to the form circle."""
        return roll_length(self.gear, form_radius(self.gear)) ** 2 / (2.0 * self.gear.base_radius)

    @cached_property
    def length(self) -> float:
        """Involute arc from the form circle to the tip circle."""
        return roll_length(self.gear, self.gear.tip_radius) ** 2 / (2.0 * self.gear.base_radius) - self.form_arc

    @cached_property
    def fillet(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Arc (rising to 0), radius and angle of fine fillet points, and the arc where its slope is 45 degrees."""
        x, y = half_tooth_profile(self.gear, 1200, 1, 1)[:1201].T
        radius, angle = np.hypot(x, y), np.arctan2(x, y)
        arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        flat = np.flatnonzero(np.diff(radius) < -np.diff(angle) * radius[1:])
        middle = float(np.clip(arc[flat[-1] + 1], 0.3 * arc[-1], 0.9 * arc[-1]))
        return arc - arc[-1], radius, angle, middle - float(arc[-1])

    def at(self, arc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Radius (m) and angle (rad) of the flank at positions `arc`."""
        fillet_arc, fillet_radius, fillet_angle, _ = self.fillet
        roll = np.sqrt(2.0 * self.gear.base_radius * (np.maximum(arc, 0.0) + self.form_arc))
        base, alpha = self.gear.base_radius, np.arctan2(roll, self.gear.base_radius)
        at_base = self.gear.half_thickness_angle(base)
        radius = np.where(arc < 0.0, np.interp(arc, fillet_arc, fillet_radius), np.hypot(base, roll))
        angle = np.where(arc < 0.0, np.interp(arc, fillet_arc, fillet_angle), at_base - (roll / base - alpha))
        return radius, angle

    def arc_of_roll(self, roll: np.ndarray) -> np.ndarray:
        """Arc of the flank point at a roll length (m), held within the involute."""
        return np.clip(
            np.square(np.maximum(roll, 0.0)) / (2.0 * self.gear.base_radius) - self.form_arc, 0.0, self.length
        )


def graded(length: float, first: float, count: int, even: int = 0) -> np.ndarray:
    """Element ends 0 .. length, `count` elements: `even` ones of size `first`, then a geometric growth from it.

    All are equal where the length is shorter.
    """
    if count == 1 or first * count >= length:
        return np.linspace(0.0, length, count + 1)
    if even:
        return np.append(first * np.arange(even), even * first + graded(length - even * first, first, count - even))
    ratio = brentq(lambda q: first * (q**count - 1.0) / (q - 1.0) - length, 1.0 + 1e-9, 1e3)
    return np.append(first * (ratio ** np.arange(count) - 1.0) / (ratio - 1.0), length)


def with_middles(ends: np.ndarray) -> np.ndarray:
    """Element ends with the middles between them."""
    out = np.empty(2 * len(ends) - 1)
    out[::2], out[1::2] = ends, (ends[1:] + ends[:-1]) / 2.0
    return out


def contact_rows(profile: Profile, sizes: Sizes, contact_arc: np.ndarray) -> np.ndarray:
    """Ends of the rows on the involute (row, station), finest at `contact_arc` (station,)."""
    margin = 0.3 * sizes.contact
    touch = np.clip(contact_arc, margin * sizes.below, profile.length - margin * sizes.above)
    columns = [
        np.append(
            t - graded(t, sizes.contact, sizes.below, sizes.even)[:0:-1],
            t + graded(profile.length - t, sizes.contact, sizes.above, sizes.even),
        )
        for t in touch
    ]
    return np.column_stack(columns)


def sector(
    profile: Profile, sizes: Sizes, contact_arc: np.ndarray | None = None, ends: np.ndarray | None = None
) -> Sector:
    """A sector whose rows are finest at `contact_arc` (station,), or half way up the flank; or have given `ends`."""
    gear = profile.gear
    station = np.linspace(-0.5, 0.5, 2 * sizes.face + 1)
    if ends is None:
        half = np.full(station.size, 0.5 * profile.length)
        ends = contact_rows(profile, sizes, half if contact_arc is None else contact_arc)
    *_, middle = profile.fillet
    fillet = with_middles(np.linspace(middle, 0.0, sizes.fillet + 1))[:-1]
    rows = np.column_stack([np.concatenate([fillet, with_middles(column)]) for column in ends.T])
    # straight in arc and face coordinate within an element: a quadratic edge then lies on the flank, kinks included
    rows[:, 1::2] = (rows[:, :-1:2] + rows[:, 2::2]) / 2.0
    flank_radius, flank_angle = profile.at(rows)
    thickness = 2.0 * float((flank_radius * flank_angle)[fillet.size :].mean())
    across = 1.0 - with_middles(graded(2.0, 2.0 * sizes.contact / thickness, sizes.across))[::-1]
    tooth_radius = np.repeat(flank_radius[:, None, :], across.size, axis=1)
    tooth_angle = flank_angle[:, None, :] * across[None, :, None]

    pitch = math.pi / gear.teeth
    fillet_arc, *_ = profile.fillet
    land_radius, land_angle = profile.at(with_middles(np.linspace(fillet_arc[0], middle, sizes.land + 1))[:-1])
    top_radius = np.concatenate([land_radius, np.full(across.size, flank_radius[0, 0]), land_radius[::-1]])
    top_angle = np.concatenate([-land_angle, flank_angle[0, 0] * across, land_angle[::-1]])
    top_radius[[0, -1]], top_angle[[0, -1]] = gear.root_radius, (-pitch, pitch)
    first_layer = 0.3 * (2.0 * gear.root_radius * pitch) / max(1, sizes.across // 4)
    height = gear.root_radius - gear.bore_radius
    depth = with_middles(graded(1.0, min(1.0, first_layer / height), sizes.layers))
    body_radius = top_radius + depth[:, None] * (gear.bore_radius - top_radius)
    body_angle = top_angle + depth[:, None] * (np.linspace(-pitch, pitch, top_angle.size) - top_angle)
    return Sector(
        body_radius=np.repeat(body_radius[:, :, None], station.size, axis=2),
        body_angle=np.repeat(body_angle[:, :, None], station.size, axis=2),
        tooth_radius=tooth_radius,
        tooth_angle=tooth_angle,
        first=land_radius.size,
        contact_row=fillet.size,
        depth=depth,
        station=station,
    )
