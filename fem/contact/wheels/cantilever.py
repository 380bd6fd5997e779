"""A tooth as a cantilever: its contour, and the compliances of bending, shear and compression."""

from __future__ import annotations

import math

import numpy as np

from fem.gears.gear import Gear
from fem.gears.profile import half_tooth_profile

SHEAR_FACTOR = 1.2
_POINTS = 400  # on the fillet and on the involute


def beam_contour(gear: Gear) -> tuple[np.ndarray, np.ndarray]:
    """Height above the gear axis, ascending, and half thickness (n,), m, from the start of the fillet at the root."""
    width, height = half_tooth_profile(gear, _POINTS, _POINTS, 1)[: 2 * _POINTS + 1].T
    first = int(np.flatnonzero(np.hypot(width, height) > gear.root_radius * (1.0 + 1e-9))[0]) - 1
    order = np.argsort(height[first:], kind="stable")
    return height[first:][order], width[first:][order]


def cantilever(
    height: np.ndarray, half_thickness: np.ndarray, load_height: float, load_offset: float, alpha: float,
    elastic_modulus: float, shear_modulus: float, lost: np.ndarray | float = 0.0,
) -> tuple[float, float, float]:  # fmt: skip
    """Bending, shear and axial compliance of a cantilever of unit width (m2/N).

    Parameters
    ----------
    height, half_thickness : (n,) m, contour from the clamped end to the load
    load_height, load_offset : m, point of the force: along the axis, and distance from it
    alpha : rad, inclination of the force to the normal of the axis, towards the clamped end
    elastic_modulus, shear_modulus : Pa
    lost : (n,) m, thickness lost for bending and shear by a crack
    """
    from scipy.integrate import trapezoid

    arm = math.cos(alpha) * (load_height - height) - load_offset * math.sin(alpha)
    section = 2.0 * half_thickness - lost
    bending = trapezoid(arm**2 / (elastic_modulus * section**3 / 12.0), height)
    sheared = trapezoid(1.0 / section, height)
    pressed = trapezoid(1.0 / (2.0 * half_thickness), height)
    return (
        float(bending),
        float(SHEAR_FACTOR * math.cos(alpha) ** 2 / shear_modulus * sheared),
        float(math.sin(alpha) ** 2 / elastic_modulus * pressed),
    )
