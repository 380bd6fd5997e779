"""Effect of modifications and faults on a mesh law: gaps and compliances added to the tables of a healthy pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fem.contact.faults.tooth_fault import ToothFault
from fem.contact.law import MeshLaw
from fem.contact.slice_frame import law_points
from fem.contact.teeth import with_variants
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications, check_modifications, lead_gap, lead_points, profile_gap

if TYPE_CHECKING:
    from fem.contact.wheels.crack_surface import CrackSurface


def modified_law(law: MeshLaw, pair: GearPair, modifications: PairModifications) -> MeshLaw:
    """The law of a pair with modified flanks and misaligned axes; compliances are unchanged.

    Raises
    ------
    GeometryError : a modification that does not fit on the flanks
    """
    if modifications.none:
        return law
    check_modifications(pair, modifications)
    face = np.union1d(law.lead_coordinate, lead_points(pair, modifications))
    before = np.interp(face, law.lead_coordinate, law.lead_gap)
    return law.replaced(
        gap=law.gap + profile_gap(pair, modifications, law_points(law, pair)),
        lead_coordinate=face,
        lead_gap=before + lead_gap(pair, modifications, law.flank, face),
    )


def damaged_law(
    law: MeshLaw,
    pair: GearPair,
    gear: str,
    faults: Sequence[ToothFault],
    surfaces: Mapping[float, CrackSurface] | None = None,
) -> MeshLaw:
    """The law with a variant of the teeth of "pinion" or "wheel" that has all of `faults`.

    Parameters
    ----------
    law : of one flank of the pair
    pair : the gears in mesh
    gear : "pinion" or "wheel"
    faults : of the same tooth
    surfaces : crack surfaces of this gear in space, by the angle of the crack; a crack at another angle is computed as
        a plane one in every slice

    Raises
    ------
    GeometryError : a fault that does not fit on the tooth
    """
    compliance = np.zeros((law.face_coordinate.size, law.compliance.size))
    gap, modes = np.zeros_like(compliance), np.zeros((0, 3, *compliance.shape))
    for fault in faults:
        fault.check(getattr(pair, gear))
        surface = None if fault.surface_angle is None else (surfaces or {}).get(fault.surface_angle)
        if surface is None:
            compliance = compliance + fault.compliance(law, pair, gear)
        else:
            modes = np.concatenate([modes, fault.modes(law, pair, gear, surface)])
        gap = gap + fault.gap(law, pair, gear)
    return with_variants(law, gear, compliance, gap, modes)
