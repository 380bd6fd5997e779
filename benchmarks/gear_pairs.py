"""Gears and pairs that benchmarks and tests share, in engineers' units, on the rack 1 / 1.25 / 0.38 at 20 degrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.path import slice_fraction

Two = tuple[float, float]


def gear(
    teeth: int,
    module_mm: float = 2.0,
    helix_deg: float = 0.0,
    face_mm: float = 12.0,
    *,
    shift: float = 0.0,
    tip_mm: float = 0.0,
    bore_mm: float | None = None,
    hand: str = "right",
) -> Gear:
    """A gear with the bore radius `bore_mm`, r_f / 1.4 unless given."""
    root_mm = (teeth / math.cos(math.radians(helix_deg)) / 2 - 1.25 + shift) * module_mm
    return Gear(
        teeth=teeth,
        normal_module=module_mm / 1000,
        helix_angle=math.radians(helix_deg),
        face_width=face_mm / 1000,
        profile_shift=shift,
        tip_alteration=tip_mm / 1000,
        bore_radius=(root_mm / 1.4 if bore_mm is None else bore_mm) / 1000,
        hand=hand,
    )


def gear_pair(
    teeth: tuple[int, int],
    module_mm: float,
    helix_deg: float,
    face_mm: float,
    shifts: Two = (0.0, 0.0),
    centre_mm: float | None = None,
    tip_mm: float = 0.0,
    bores_mm: Two | tuple[None, None] = (1.0, 1.0),
    hands: tuple[str, str] = ("right", "left"),
    **extra: Any,
) -> GearPair:
    """A pair of steel, all but without bores unless `bores_mm` (radii) are given; `extra` goes to `GearPair`."""
    pinion, wheel = (
        gear(z, module_mm, helix_deg, face_mm, shift=x, tip_mm=tip_mm, bore_mm=bore, hand=hand)
        for z, x, bore, hand in zip(teeth, shifts, bores_mm, hands, strict=True)
    )
    centre = None if centre_mm is None else centre_mm / 1000
    return GearPair(pinion=pinion, wheel=wheel, centre_distance=centre, **extra)


def thick_rimmed_pair(
    helix_deg: float = 0.0,
    face_mm: float = 12.0,
    teeth: tuple[int, int] = (20, 55),
    hands: tuple[str, str] = ("right", "left"),
) -> GearPair:
    """A pair of module 2 mm with bores at r_f / 1.4."""
    return gear_pair(teeth, 2, helix_deg, face_mm, bores_mm=(None, None), hands=hands)


def kisssoft_helical() -> GearPair:
    """KISSsoft report 03/2017, third stage, published in gfsReboucas/Drivetrain: z 24/95, m_n 14 mm, beta 10 deg."""
    return gear_pair((24, 95), 14, 10, 360, (0.4800, 0.6691), 861, -0.938, (179.10 / 2, 1193.32 / 2))


def kisssoft_spur() -> GearPair:
    """The sun-planet mesh of the second stage in the same report: z 18/36, m 21 mm."""
    return gear_pair((18, 36), 21, 0, 550, (0.3890, 0.5039), 584, -1.75)


def pair_of_17_and_43() -> GearPair:
    """The helical pair of a published contact solution in space: m_n 1 mm, beta 20 deg, b 10 mm."""
    return gear_pair((17, 43), 1, 20, 10, centre_mm=31.925333, bores_mm=(5.568, 15.450))


def line_length(pair: GearPair, cycle: np.ndarray | float, *, missing: bool = False) -> np.ndarray:
    """Total length of the contact lines at the mesh cycles `cycle` (m), without load and tip-edge contact.

    L(c) = sum_p b phi(c - p) / cos(beta_b), phi the part of the face that lies on the path of contact; the mean over
    a cycle is eps_alpha b / cos(beta_b). `missing` leaves pair 0 out: the dip lasts eps_gamma cycles and, while the
    missing line would be complete, is 1/max(eps_alpha, eps_beta) of the mean.
    """
    cycle = np.atleast_1d(np.asarray(cycle, dtype=float))
    ramp = pair.overlap_ratio
    reach = ramp / 2 + max(-pair.xi_start, pair.xi_end)
    around = np.arange(-math.ceil(reach) - 1, math.ceil(reach) + 2)
    pairs = np.floor(cycle)[:, None] + around[None, :]
    part = slice_fraction(cycle[:, None] - pairs, pair.xi_start, pair.xi_end, ramp)
    if missing:
        part = np.where(pairs == 0, 0.0, part)
    return part.sum(axis=1) * pair.face_width / math.cos(pair.base_helix_angle)
