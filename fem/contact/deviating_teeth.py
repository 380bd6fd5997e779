"""Prescribed deviations of teeth in a mesh law, as a gap table per tooth in addition to the tooth terms.

A tooth with waves, eccentricity or measured flanks becomes a variant of the law with a gap over (slice, position); its
compliance and modes are unchanged. Gaps of variants must be >= 0, as the law skips contacts whose free approach without
them is negative. The least value of each table is therefore added to the clearance of its tooth. Tables need 8 bytes
each for gap and compliance per entry: 65 teeth, 61 slices and 128 positions are 8 MB for each flank. Gaps are linear
between the positions of the law, which reduces the amplitude of a wave of n points by the factor sinc^2(1/n) (by 2.7 %
at n = 11, 5 % at n = 8).
"""

from __future__ import annotations

import math

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.slice_frame import law_points
from fem.contact.teeth import checked_terms
from fem.gears.geometry import GearPair
from fem.gears.prescribed import PrescribedDeviations, measured_gap, rotation_waves


def deviating_law(
    law: MeshLaw, pair: GearPair, gear: str, terms: np.ndarray, given: PrescribedDeviations
) -> tuple[MeshLaw, np.ndarray]:
    """The law with a table for every tooth of "pinion" or "wheel" that needs one, and the tooth terms that select them.

    Parameters
    ----------
    law, pair : of one flank, and its gears
    gear, given : the gear and its prescribed deviations
    terms : (tooth,) or (tooth, 6) of its teeth, which are kept
    """
    count = getattr(pair, gear).teeth
    terms = checked_terms(gear, count, terms)
    gaps = _gaps(law, pair, gear, given)
    if not gaps:
        return law, terms
    opening = getattr(law, f"{gear}_variant_gap")
    variants = terms[list(gaps), -1].astype(int)  # of other damage of the teeth
    tables = np.stack(list(gaps.values()))
    least = tables.min(axis=(1, 2))
    terms[list(gaps), 0] += least
    terms[list(gaps), -1] = len(opening) + 1 + np.arange(len(gaps))
    changes = {}
    for name in ("gap", "compliance", "modes"):
        there = getattr(law, f"{gear}_variant_{name}")
        own = np.concatenate([np.zeros((1, *there.shape[1:])), there])[variants]
        if name == "gap":
            own += tables - least[:, None, None]
        changes[f"{gear}_variant_{name}"] = np.concatenate([there, own])
    return law.replaced(**changes), terms


def _gaps(law: MeshLaw, pair: GearPair, gear: str, given: PrescribedDeviations) -> dict[int, np.ndarray]:
    """Gap (slice, position), m, by tooth."""
    count, found = getattr(pair, gear).teeth, {}
    waves = list(rotation_waves(pair, gear, law.flank, given))
    if waves:
        turns = _rotation(law, gear, count)
        for tooth in range(count):
            turn = turns + 2.0 * math.pi * tooth / count
            found[tooth] = sum((amount * np.exp(1j * order * turn)).real for order, amount in waves)
    if given.measured is not None:
        points = law_points(law, pair)
        radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
        for tooth, gap in zip(
            given.measured.tooth.tolist(),
            measured_gap(given.measured, law.flank, radius, law.face_coordinate),
            strict=True,
        ):
            found[tooth] = found.get(tooth, 0.0) + gap
    return found


def _rotation(law: MeshLaw, gear: str, teeth: int) -> np.ndarray:
    """Rotation (slice, position), rad, of the gear when its tooth 0 touches there.

    Pair p touches at c' = xi + p - shift, with c' = sign c + offset and the tooth sign p, or sign p + wheel offset.
    """
    xi = law.position_start + law.position_step * np.arange(law.compliance.size)
    cycle = law.cycle_sign * (xi - law.cycle_shift[:, None] - law.cycle_offset)
    return 2.0 * math.pi / teeth * (cycle - (law.wheel_tooth_offset if gear == "wheel" else 0))
