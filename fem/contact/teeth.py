"""Contributions of single teeth to a mesh law: clearance, slopes and curvatures along profile and face, damage.

Tooth terms are an array (z, 6) per gear and flank with the columns h, a1, a2, b1, b2, variant. A pair adds to its gap,
for both of its teeth,

    h + a1 xi + a2 xi^2 + b1 (y/b) + b2 (y/b)^2

with the position xi on the path of contact in base pitches (0 at the pitch point, increasing towards the tip of the
pinion, the same on both flanks), the face coordinate y from mid face and the face width b: h and b in m, a1 in m per
base pitch, a2 in m per base pitch squared. b1 is the difference between the ends of the face. A positive gap is missing
material, so that the flank touches later; h = inf is a missing tooth. The slopes represent the slope deviations
f_Halpha and f_Hbeta of ISO 1328-1:2013, the curvatures the long-wave part of the form deviations. `variant` is 0 for a
healthy tooth, else the number of a variant in the law (`MeshLaw.pinion_variant_gap` and related fields).

Terms are selected by tooth counters, so that no table over the hunting cycle is needed.
"""

from __future__ import annotations

import numpy as np

from fem.contact.law import MeshLaw

COLUMNS = ("clearance", "profile_slope", "profile_curvature", "lead_slope", "lead_curvature", "variant")


class LawError(ValueError):
    """A MeshLaw, its tooth terms or a state cannot be evaluated."""


def tooth_terms(
    teeth: int,
    *,
    clearance: np.ndarray | float = 0.0,
    profile_slope: np.ndarray | float = 0.0,
    profile_curvature: np.ndarray | float = 0.0,
    lead_slope: np.ndarray | float = 0.0,
    lead_curvature: np.ndarray | float = 0.0,
    variant: np.ndarray | int = 0,
) -> np.ndarray:
    """Tooth terms (teeth, 6) of one gear and flank, from numbers or arrays (teeth,).

    Parameters
    ----------
    teeth : number of teeth
    clearance : m, +inf for a missing tooth
    profile_slope, profile_curvature : m per base pitch, m per base pitch squared
    lead_slope, lead_curvature : m, of y/b and of (y/b)^2
    variant : number of the variant in the law, 0 for a healthy tooth
    """
    terms = np.empty((teeth, len(COLUMNS)))
    given = (clearance, profile_slope, profile_curvature, lead_slope, lead_curvature, variant)
    for k, value in enumerate(given):
        terms[:, k] = value
    return checked_terms("gear", teeth, terms)


def checked_terms(gear: str, teeth: int, value: np.ndarray | None) -> np.ndarray:
    """Tooth terms (teeth, 6): zeros for None, clearances alone from an array (teeth,).

    Raises
    ------
    LawError : wrong shape
    """
    given = np.zeros(teeth) if value is None else np.array(value, dtype=float)
    terms = np.zeros((teeth, len(COLUMNS)))
    if given.shape == (teeth,):
        terms[:, 0] = given
    elif given.shape == terms.shape:
        terms[:] = given
    else:
        raise LawError(
            f"clearance of the {gear}: shape {given.shape}, one value for each of its {teeth} teeth needed, or tooth "
            f"terms ({teeth}, {len(COLUMNS)})"
        )
    return terms


def least_clearance(law: MeshLaw, pinion: np.ndarray, wheel: np.ndarray) -> float:
    """Lower bound (m) of the gaps of all pairs: there is no contact at a smaller approach delta + |psi y|."""
    last = law.position_start + law.position_step * (law.gap.size - 1)
    far = max(abs(law.position_start), abs(last))
    part = float(np.abs(law.face_coordinate).max() / law.slice_width.sum())
    reach = np.array([far, far**2, part, part**2])
    least = float(np.min(law.gap)) + float(np.min(law.slice_lead_gap))
    for terms, variants in ((pinion, law.pinion_variant_gap), (wheel, law.wheel_variant_gap)):
        here = terms[np.isfinite(terms[:, 0])]
        if here.size == 0:
            return float("inf")
        least += float((here[:, 0] - np.abs(here[:, 1:5]) @ reach).min())
        least += min(0.0, float(variants.min())) if variants.size and here[:, 5].any() else 0.0
    return least


def with_variants(
    law: MeshLaw, gear: str, compliance: np.ndarray | float, gap: np.ndarray | float, modes: np.ndarray | None = None
) -> MeshLaw:
    """The law with one more variant of "pinion" or "wheel"; its number is the new count of variants.

    Parameters
    ----------
    law : of the pair
    gear : "pinion" or "wheel"
    compliance : m2/N, >= 0, added to its pair; broadcasts to (slice, position)
    gap : m, likewise; +inf where the tooth is chipped away
    modes : (mode, near, slice, position) of added compliance on its pair and the adjacent pairs, see `fem.contact.law`;
        None for none

    Raises
    ------
    LawError : negative compliance
    """
    shape = (1, law.face_coordinate.size, law.compliance.size)
    added = {"compliance": compliance, "gap": gap}
    if np.min(compliance) < 0.0:
        raise LawError(
            f"tooth variant of the {gear}: compliance falls to {np.min(compliance):.4g} m2/N; damage makes a tooth "
            "softer, give values >= 0"
        )
    changes = {}
    for name, value in added.items():
        field = f"{gear}_variant_{name}"
        changes[field] = np.concatenate([getattr(law, field), np.broadcast_to(value, shape)])
    field = f"{gear}_variant_modes"
    there, added_modes = getattr(law, field), np.zeros((0, 3, *shape[1:])) if modes is None else modes
    count = max(there.shape[1], len(added_modes))
    both = np.zeros((len(there) + 1, count, 3, *shape[1:]))
    both[:-1, : there.shape[1]] = there
    both[-1, : len(added_modes)] = added_modes
    return law.replaced(**changes, **{field: both})
