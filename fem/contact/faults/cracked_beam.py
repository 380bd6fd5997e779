"""A root crack in model `energy`, by the potential-energy method of the literature.

The tooth is a cantilever; its sections lose the material outside the line through the crack tip parallel to the tooth
axis. For a crack of depth q at the angle v to the axis, from the flank at the half thickness y_o, the half thickness of
the cracked side is at most h_q = y_o - q sin(v), and sections of half thickness y > h_q have

    I = (y + h_q)^3 / 12,    A = y + h_q    instead of (2 y)^3 / 12 and 2 y.

In the papers the crack starts at the clamped end. Here it starts in the fillet, and the wider sections below lose q
sin(v), so that nothing is lost without a crack. Axial and contact compliance are unchanged, since compression closes
the crack; so are body and neighbours. The model serves the comparison with the papers; other models use finite elements
for cracks.

Wu, Zuo & Parey (2008), J. Sound Vib. 317, 608-624; Chaari, Fakhfakh & Haddar (2009), Eur. J. Mech. A/Solids 28,
461-468.
"""

from __future__ import annotations

import math

import numpy as np

from fem.contact.wheels.cantilever import beam_contour, cantilever
from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints
from fem.gears.profile import flank_at_roll
from fem.gears.sector_mesh import root_chord


def cracked_beam_compliance(pair: GearPair, gear: str, depth: float, angle: float, points: PathPoints) -> np.ndarray:
    """Compliance (position,), m2/N, per unit face width, that a root crack adds to a beam tooth.

    Parameters
    ----------
    pair : the gears in mesh
    gear : "pinion" or "wheel"
    depth, angle : of the crack, m, and rad to the tooth axis; the method is valid up to that axis
    points : contact points (position,), on the flank of the crack mouth
    """
    own, material = getattr(pair, gear), getattr(pair, f"{gear}_material")
    radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
    mouth = root_chord(own)[1] / 2
    kept = max(mouth - depth * math.sin(angle), 0.0)
    height, width = beam_contour(own)
    place, _, normal = flank_at_roll(own, np.sqrt(np.maximum(radius**2 - own.base_radius**2, 0.0)))
    found = []
    for (y_load, u_load), (across, up) in zip(place, normal, strict=True):
        below = height < u_load
        u, y = np.append(height[below], u_load), np.append(width[below], y_load)
        load = (u_load, y_load, math.atan2(up, across), material.elastic_modulus, material.shear_modulus)
        cracked = cantilever(u, y, *load, lost=np.maximum(np.minimum(y, mouth) - kept, 0.0))
        found.append(sum(cracked) - sum(cantilever(u, y, *load)))
    return np.array(found)
