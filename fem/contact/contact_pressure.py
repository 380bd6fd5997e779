"""Hertz pressure for the line loads of a mesh law.

p_0 = sqrt(f E'/(pi R)), 1/E' = sum (1 - nu^2)/E, 1/R = (1/rho_1 + 1/rho_2) cos beta_b, with f per length of contact
line, which equals the transverse load per face width (ISO 6336-2:2019, clause 6; Johnson, Contact Mechanics, section
4.2).
"""

from __future__ import annotations

import numpy as np

from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair


def contact_pressure(
    pair: GearPair, law: MeshLaw, cycle: np.ndarray | float, pairs: np.ndarray, loads: np.ndarray
) -> np.ndarray:
    """Maximum Hertz pressure (n, slice) in Pa, or (position, n, slice).

    Parameters
    ----------
    pair, law : the gear pair and the law of one flank
    cycle : mesh cycle, or (position,) mesh cycles
    pairs : (n,) numbers of the loaded pairs, or (position, n)
    loads : (n, slice) N/m, or (position, n, slice)
    """
    own = law.cycle_sign * np.asarray(cycle) + law.cycle_offset
    positions = own[..., None, None] - pairs[..., None] + law.cycle_shift
    rolls = np.stack(pair.roll_lengths(positions), axis=-1)
    radii = np.maximum(rolls, 1e-3 * pair.base_pitch)
    curvature = (1 / radii).sum(axis=-1) * np.cos(pair.base_helix_angle)
    materials = (pair.pinion_material, pair.wheel_material)
    compliance = sum((1 - m.poisson_ratio**2) / m.elastic_modulus for m in materials)
    return np.sqrt(np.maximum(loads, 0.0) * curvature / (np.pi * compliance))


def flank_pressure(pair: GearPair, law: MeshLaw, cycle: np.ndarray, pairs: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """`contact_pressure` on the active flanks, and 0 beyond them.

    Contact of a tip edge beyond the active flank has no Hertzian pressure: the curvature of the flank ends there.

    Parameters
    ----------
    pair, law : the gear pair and the law of its drive flank
    cycle : (position,) mesh cycles
    pairs : (position, n) numbers of the pairs
    loads : (position, n, slice) N/m
    """
    xi = cycle[:, None, None] - pairs[..., None] + law.cycle_shift
    active = (xi >= pair.xi_start) & (xi <= pair.xi_end)
    return np.where(active, contact_pressure(pair, law, cycle, pairs, loads), 0.0)
