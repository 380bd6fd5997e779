"""Compiled evaluation of a MeshLaw: forces, energy and their derivatives at one state.

In a slice of width w let x_p be the free approach of pair p (delta + psi y less all gaps), phi_p its fraction and f_p
its line load. The complementary energy

    W*(f) = w { sum_p phi_p [C f_p^2/2 + A f_p^2 (B/2 + 1/4 - ln(f_p)/2)] + sum_{p<q} c_pq phi_p phi_q f_p f_q }

has dW*/df_p = w phi_p (C f_p + A f_p (B - ln f_p) + sum_q c_pq phi_q f_q), so the contact conditions are those of the
convex problem min W*(f) - w sum phi_p x_p f_p, f >= 0, and its negative minimum is the strain energy U. By the envelope
theorem every first derivative of U is the explicit one: dU/d delta = F, dU/d psi = M, and dU/dc uses the slopes of the
tables inside the present grid cell (tables are linear between grid points, so it is exact).

The Hertz term A f (B - ln f) stops growing at ln f = B - 1, where its contact width reaches the depth at which the
displacement is counted; above it is held constant, which keeps the law monotone at any load.

Solution: x(f) is nearly a straight line, because ln f changes little. Secant compliances with a rough logarithm give f
within a few per cent; each Newton step then squares the error and divides it by 50, so that two or three steps reach
round-off. Sixteen slices of at most two loaded pairs go through the same vector instructions
(`fem.contact.evaluation.paired_slices`); all other slices are solved one by one
(`fem.contact.evaluation.general_slices`). Nothing is kept between calls: equal states give equal answers.

Measured on the stage 1 pair of the shipped rig with 15 slices (one core of an AMD EPYC, 3 GHz class): 0.85 us per call
against 3.1 us for a Newton iteration slice by slice. A closed form of the single pair by Lambert's W would need a
logarithm per step just as well, and a start from the loads of the call before could save one of three steps at most (by
estimate, not measured) at the price of answers that depend on the history; neither is used.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fem.contact.evaluation.kernel import evaluate, evaluate_many, evaluate_shares, evaluate_two
from fem.contact.evaluation.packing import LARGEST_NEAR, MAX_PAIRS, pack
from fem.contact.law import MeshLaw
from fem.contact.teeth import LawError, checked_terms

__all__ = [
    "LawError",
    "MeshResponse",
    "Teeth",
    "checked_teeth",
    "evaluate",
    "evaluate_law",
    "evaluate_shares",
    "evaluate_two",
    "law_tables",
    "share_reach",
    "shares",
]

Teeth = np.ndarray | None  # terms (z, 6), clearances (z,) in m, or None for sound teeth without deviation


class MeshResponse(NamedTuple):
    """What `evaluate` returns, as floats or arrays."""

    force: Any  # F, N
    moment: Any  # M, N m
    energy: Any  # U, J
    stiffness: Any  # dF/d delta, N/m
    cross_stiffness: Any  # dF/d psi = dM/d delta, N
    tilt_stiffness: Any  # dM/d psi, N m
    energy_slope: Any  # dU/dc, J


def law_tables(law: MeshLaw) -> np.ndarray:
    """The flat array of numbers that `evaluate` takes; build it once per law.

    Raises
    ------
    LawError : compliances not positive, fractions outside [0, 1], a grid that spans more than MAX_PAIRS pairs
    """
    n = law.compliance.size
    span = (n - 1) * law.position_step
    overlap = float(np.ptp(law.cycle_shift))
    softest = min(
        float(v.min()) if v.size else 0.0 for v in (law.pinion_variant_compliance, law.wheel_variant_compliance)
    )
    for bad, message in (
        (n < 2 or law.position_step <= 0.0, f"{n} positions with step {law.position_step!r}; give >= 2 with step > 0"),
        (span > MAX_PAIRS - 2, f"positions span {span:.4g} pitches; the limit is {MAX_PAIRS - 2}"),
        (
            span + overlap > LARGEST_NEAR - 2,
            f"positions and overlap span {span + overlap:.4g} pitches; the limit is {LARGEST_NEAR - 2}",
        ),
        (law.compliance.min() <= 0.0, f"smallest compliance is {law.compliance.min():.4g} m2/N; it must be > 0"),
        (softest < 0.0, f"smallest compliance of a tooth variant is {softest:.4g} m2/N; it must be >= 0"),
        (
            min(law.spread_compliance.min(), law.spread_length, law.body_compliance, law.tilt_compliance) < 0.0,
            "a compliance or the length that loads spread along the face is negative",
        ),
        (
            law.body_compliance * law.tilt_compliance < law.skew_compliance**2,
            f"skew_compliance is {law.skew_compliance:.4g} 1/N; its square must not exceed body times tilt compliance",
        ),
        (law.contact_slope < 0.0, f"contact_slope is {law.contact_slope:.4g} m2/N; it must be >= 0"),
        (law.fraction.min() < 0.0 or law.fraction.max() > 1.0, "fraction leaves [0, 1]"),
        (np.isneginf(law.gap).any(), "gap is -inf somewhere; give m or +inf"),
        (law.cycle_sign not in (1, -1), f"cycle_sign is {law.cycle_sign}; it must be +1 or -1"),
        (min(law.pinion_teeth, law.wheel_teeth) < 1, "tooth numbers must be >= 1"),
    ):
        if bad:
            raise LawError(f"mesh law {law.model!r} ({law.flank}): {message}")
    return pack(law)


def share_reach(law: MeshLaw) -> int:
    """Half size of the array that `evaluate_shares` needs to hold every candidate pair."""
    last = law.position_start + (law.compliance.size - 1) * law.position_step
    return math.ceil(max(abs(law.position_start), abs(last)) + float(np.abs(law.cycle_shift).max())) + 1


def checked_teeth(law: MeshLaw, pinion: Teeth, wheel: Teeth) -> tuple[np.ndarray, np.ndarray]:
    """Tooth terms (z1, 6) and (z2, 6) of what is given as `Teeth`.

    Raises
    ------
    LawError : wrong shape, NaN or -inf, a variant that the law does not have
    """
    checked = []
    for name, value, teeth, known in (
        ("pinion", pinion, law.pinion_teeth, len(law.pinion_variant_gap)),
        ("wheel", wheel, law.wheel_teeth, len(law.wheel_variant_gap)),
    ):
        terms = checked_terms(name, teeth, value)
        if terms[:, 5].max() > known:
            raise LawError(
                f"variant of the {name}: {terms[:, 5].max():.0f} at tooth {int(terms[:, 5].argmax())}, the law "
                f"{law.model!r} has {known}; add it with fem.contact.teeth.with_variants"
            )
        checked.append(terms)
    return checked[0], checked[1]


def evaluate_law(
    law: MeshLaw,
    cycle: np.ndarray | float,
    delta: np.ndarray | float,
    psi: np.ndarray | float = 0.0,
    pinion: Teeth = None,
    wheel: Teeth = None,
) -> MeshResponse:
    """Response at states that broadcast, as arrays of their common shape; teeth as for `checked_teeth`."""
    h1, h2 = checked_teeth(law, pinion, wheel)
    states = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (cycle, delta, psi)))
    for name, value in zip(("cycle", "delta", "psi"), states, strict=True):
        if not np.isfinite(value).all():
            raise LawError(f"mesh law {law.model!r}: {name} is not finite; give finite numbers in SI")
    out = np.empty((states[0].size, 7))
    flat = [np.array(v).ravel() for v in states]
    evaluate_many(law_tables(law), flat[0], flat[1], flat[2], h1, h2, out)
    return MeshResponse(*(column.reshape(states[0].shape) for column in out.T))


def shares(
    law: MeshLaw, cycle: float, delta: float, psi: float = 0.0, pinion: Teeth = None, wheel: Teeth = None
) -> tuple[np.ndarray, np.ndarray]:
    """Pair numbers p (n,) near mesh and their forces (n,) in N, which sum to F."""
    h1, h2 = checked_teeth(law, pinion, wheel)
    reach = share_reach(law)
    force = np.zeros(2 * reach + 1)
    evaluate_shares(law_tables(law), float(cycle), float(delta), float(psi), h1, h2, force)
    return math.floor(law.cycle_sign * cycle + law.cycle_offset) + np.arange(-reach, reach + 1), force
