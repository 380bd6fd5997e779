"""Line loads and Hertz pressure of one state of a mesh law, slice by slice, by virtual work.

The load on pair p in slice s is what the strain energy loses per gap opened there, w phi f = -dU/dg_ps: the tooth takes
a table whose gap is larger by g in that slice alone. This holds for every form of the law, coupled slices too. Central
differences over `STEP` are exact to their third derivative, which is nothing here.

Pressure: p_0 = sqrt(f E'/(pi R)), 1/E' = sum (1 - nu^2)/E, 1/R = (1/rho_1 + 1/rho_2) cos beta_b, with f per length of
contact line, which equals the transverse load per face width (ISO 6336-2:2019, clause 6; Johnson, Contact Mechanics,
section 4.2).
"""

from __future__ import annotations

import numpy as np

from fem.contact.evaluation.evaluator import Teeth, checked_teeth, evaluate_law, shares
from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair

STEP = 1e-9  # m of gap
_VARIANT = 5  # column of the tooth terms


def line_loads(
    law: MeshLaw, cycle: float, delta: float, psi: float = 0.0, pinion: Teeth = None, wheel: Teeth = None
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (n,) of the loaded pairs and their loads (n, slice) per face width, N/m."""
    first, second = checked_teeth(law, pinion, wheel)
    pairs, force = shares(law, cycle, delta, psi, first, second)
    pairs = pairs[force > 0.0]
    slices = law.face_coordinate.size
    probe = _with_probes(law)
    loads = np.zeros((pairs.size, slices))
    for row, pair in enumerate(pairs):
        tooth = int(law.cycle_sign * pair) % law.pinion_teeth
        terms = first.copy()
        for s in range(slices):
            energies = []
            for side in range(2):
                terms[tooth, _VARIANT] = 1 + 2 * (int(first[tooth, _VARIANT]) * slices + s) + side
                energies.append(float(evaluate_law(probe, cycle, delta, psi, terms, second).energy))
            loads[row, s] = (energies[1] - energies[0]) / (2 * STEP * law.slice_width[s])
    return pairs, np.where(loads > 1e-6 * loads.max(initial=0.0), loads, 0.0)


def _with_probes(law: MeshLaw) -> MeshLaw:
    """The law with every pinion variant, the sound one first, opened and closed by `STEP` in one slice at a time."""
    slices, positions = law.face_coordinate.size, law.gap.size
    sound = np.zeros((1, slices, positions))
    gaps = np.concatenate([sound, law.pinion_variant_gap])
    compliances = np.concatenate([sound, law.pinion_variant_compliance])
    change = STEP * np.eye(slices)[:, None, :, None] * np.array([1.0, -1.0])[None, :, None, None]
    opened = gaps[:, None, None] + change[None]
    shape = (-1, slices, positions)
    spread = np.broadcast_to(compliances[:, None, None], opened.shape)
    return law.replaced(pinion_variant_gap=opened.reshape(shape), pinion_variant_compliance=spread.reshape(shape))


def contact_pressure(pair: GearPair, law: MeshLaw, cycle: float, pairs: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """Greatest Hertz pressure (n, slice) in Pa under the line loads (n, slice) of the pairs (n,) at a mesh cycle."""
    own = law.cycle_sign * cycle + law.cycle_offset
    positions = own - pairs[:, None] + law.cycle_shift
    rolls = np.array([pair.roll_lengths(xi) for xi in positions.ravel()]).reshape(*positions.shape, 2)
    radii = np.maximum(rolls, 1e-3 * pair.base_pitch)
    curvature = (1 / radii).sum(axis=-1) * np.cos(pair.base_helix_angle)
    materials = (pair.pinion_material, pair.wheel_material)
    compliance = sum((1 - m.poisson_ratio**2) / m.elastic_modulus for m in materials)
    return np.sqrt(np.maximum(loads, 0.0) * curvature / (np.pi * compliance))
