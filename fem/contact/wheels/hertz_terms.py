"""A and B of the Hertz line contact of a tooth pair, in x = C f + A f (B - ln f).

`fem.contact.wheels.plane_section` derives them.
"""

from __future__ import annotations

import math

import numpy as np

from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints

TIP_ROUNDING = 0.05  # m_n: radius of tip edges that the gear leaves open, for contact beyond the path of contact


def contact_terms(pair: GearPair, path: PathPoints) -> tuple[float, np.ndarray]:
    """A (m2/N) and B (position,) of the Hertz term."""
    depth, cosine = pair.pinion.normal_module, math.cos(pair.base_helix_angle)
    materials = (pair.pinion_material, pair.wheel_material)
    reduced = 1.0 / sum(1.0 / material.plane_strain_modulus for material in materials)
    radius = contact_radius(pair, path) / cosine
    return 1.0 / (math.pi * reduced * cosine), 0.5 + np.log(depth**2 * math.pi * reduced / (4 * radius))


def contact_radius(pair: GearPair, path: PathPoints) -> np.ndarray:
    """Transverse radius of relative curvature (position,), m.

    Beyond the path a tip edge is in contact. Over a tenth of a pitch, in which edge contact develops, the radius
    changes to that of the rounded edge (of the gear, or TIP_ROUNDING), linearly in its logarithm.
    """
    beyond = np.maximum(pair.xi_start - path.xi, path.xi - pair.xi_end).clip(0.0)
    usual = TIP_ROUNDING * pair.pinion.normal_module
    edge = np.where(path.xi < 0.0, pair.wheel.tip_rounding or usual, pair.pinion.tip_rounding or usual)
    share = np.minimum(beyond / 0.1, 1.0)
    return path.relative_radius ** (1.0 - share) * np.minimum(edge, path.relative_radius) ** share
