"""Gear pairs that several tests share, in engineers' units."""

import math

from fem.gears.geometry import Gear, GearPair


def gear_pair(
    teeth, module_mm, helix_deg, face_mm, shifts=(0.0, 0.0), centre_mm=None, tip_mm=0.0, bores_mm=(1.0, 1.0), **extra
):
    """A pair on the rack 1 / 1.25 / 0.38 at 20 degrees."""
    gears = [
        Gear(
            teeth=z,
            normal_module=module_mm / 1000,
            helix_angle=math.radians(helix_deg),
            face_width=face_mm / 1000,
            profile_shift=x,
            bore_radius=bore / 1000,
            tip_alteration=tip_mm / 1000,
            hand=hand,
        )
        for z, x, bore, hand in zip(teeth, shifts, bores_mm, ("right", "left"), strict=True)
    ]
    centre = None if centre_mm is None else centre_mm / 1000
    return GearPair(pinion=gears[0], wheel=gears[1], centre_distance=centre, **extra)


def kisssoft_helical():
    """KISSsoft report 03/2017, third stage, published in gfsReboucas/Drivetrain."""
    return gear_pair((24, 95), 14, 10, 360, (0.4800, 0.6691), 861, -0.938, (179.10 / 2, 1193.32 / 2))


def kisssoft_spur():
    """The sun-planet mesh of the second stage in the same report."""
    return gear_pair((18, 36), 21, 0, 550, (0.3890, 0.5039), 584, -1.75)
