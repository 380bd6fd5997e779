"""Compiled evaluation of a MeshLaw: forces, energy and their derivatives at one state.

In a slice of width w let x_p be the free approach of pair p (delta + psi y - gap - h), phi_p its fraction and f_p its
line load. The complementary energy

    W*(f) = w { sum_p phi_p [C f_p^2/2 + A f_p^2 (B/2 + 1/4 - ln(f_p)/2)] + sum_{p<q} c_pq phi_p phi_q f_p f_q }

has dW*/df_p = w phi_p (C f_p + A f_p (B - ln f_p) + sum_q c_pq phi_q f_q), so the contact conditions are those of the
convex problem min W*(f) - w sum phi_p x_p f_p, f >= 0, and its negative minimum is the strain energy U. By the envelope
theorem every first derivative of U is the explicit one: dU/d delta = F, dU/d psi = M, and dU/dc uses the slopes of the
tables inside the present grid cell (tables are linear between grid points, so it is exact).

The Hertz term A f (B - ln f) stops growing at ln f = B - 1, where its contact width reaches the depth at which the
displacement is counted; above it is held constant, which keeps the law monotone at any load.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fem.contact.kernel import MAX_PAIRS, evaluate, evaluate_many, evaluate_shares
from fem.contact.law import MeshLaw

__all__ = [
    "LawError",
    "MeshResponse",
    "checked_clearances",
    "evaluate",
    "evaluate_law",
    "evaluate_shares",
    "law_tables",
    "share_reach",
    "shares",
]


class LawError(ValueError):
    """A MeshLaw or its clearances cannot be evaluated."""


class MeshResponse(NamedTuple):
    """What `evaluate` returns, as floats or arrays."""

    force: Any  # F, N
    moment: Any  # M, N m
    energy: Any  # U, J
    stiffness: Any  # dF/d delta, N/m
    coupling_stiffness: Any  # dF/d psi = dM/d delta, N
    tilt_stiffness: Any  # dM/d psi, N m
    energy_slope: Any  # dU/dc, J


def law_tables(law: MeshLaw) -> tuple:
    """The flat tuple of arrays and numbers that `evaluate` takes; build it once per law.

    Raises
    ------
    LawError : compliances not positive, fractions outside [0, 1], a grid that spans more than MAX_PAIRS pairs
    """
    n = law.compliance.size
    span = (n - 1) * law.position_step
    for bad, message in (
        (n < 2 or law.position_step <= 0.0, f"{n} positions with step {law.position_step!r}; give >= 2 with step > 0"),
        (span > MAX_PAIRS - 2, f"positions span {span:.4g} pitches; the limit is {MAX_PAIRS - 2}"),
        (law.compliance.min() <= 0.0, f"smallest compliance is {law.compliance.min():.4g} m2/N; it must be > 0"),
        (law.contact_slope < 0.0, f"contact_slope is {law.contact_slope:.4g} m2/N; it must be >= 0"),
        (law.fraction.min() < 0.0 or law.fraction.max() > 1.0, "fraction leaves [0, 1]"),
        (law.gap.min() < 0.0, f"smallest gap is {law.gap.min():.4g} m; it must be >= 0"),
        (law.cycle_sign not in (1, -1), f"cycle_sign is {law.cycle_sign}; it must be +1 or -1"),
        (min(law.pinion_teeth, law.wheel_teeth) < 1, "tooth numbers must be >= 1"),
    ):
        if bad:
            raise LawError(f"mesh law {law.model!r} ({law.flank}): {message}")
    grid = np.column_stack([law.compliance, law.contact_offset, law.gap, law.fraction, *law.coupling])
    return (
        np.array(law.face_coordinate),
        np.array(law.slice_width),
        np.array(law.cycle_shift),
        float(law.cycle_sign),
        float(law.cycle_offset),
        float(law.position_start),
        1.0 / float(law.position_step),
        np.ascontiguousarray(grid),
        float(law.contact_slope),
        bool(law.coupling.size and law.coupling.min() < 0.0),
        int(law.pinion_teeth),
        int(law.wheel_teeth),
        int(law.wheel_tooth_offset),
    )


def share_reach(law: MeshLaw) -> int:
    """Half size of the array that `evaluate_shares` needs to hold every candidate pair."""
    last = law.position_start + (law.compliance.size - 1) * law.position_step
    return math.ceil(max(abs(law.position_start), abs(last)) + float(np.abs(law.cycle_shift).max())) + 1


def checked_clearances(
    law: MeshLaw, pinion: np.ndarray | None, wheel: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Clearance arrays (z1,) and (z2,) in m, zeros where None.

    Raises
    ------
    LawError : wrong length, NaN or -inf
    """
    checked = []
    for name, value, teeth in (("pinion", pinion, law.pinion_teeth), ("wheel", wheel, law.wheel_teeth)):
        array = np.zeros(teeth) if value is None else np.array(value, dtype=float)
        if array.shape != (teeth,):
            raise LawError(
                f"clearance of the {name}: shape {array.shape}, one value for each of its {teeth} teeth needed"
            )
        if np.isnan(array).any() or (array == -np.inf).any():
            raise LawError(
                f"clearance of the {name}: NaN or -inf at tooth {int(np.argmin(array > -np.inf))}; give m or +inf"
            )
        checked.append(array)
    return checked[0], checked[1]


def evaluate_law(
    law: MeshLaw,
    cycle: np.ndarray | float,
    delta: np.ndarray | float,
    psi: np.ndarray | float = 0.0,
    clearance_pinion: np.ndarray | None = None,
    clearance_wheel: np.ndarray | None = None,
) -> MeshResponse:
    """Response at states that broadcast against each other, as arrays of their common shape."""
    h1, h2 = checked_clearances(law, clearance_pinion, clearance_wheel)
    states = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (cycle, delta, psi)))
    for name, value in zip(("cycle", "delta", "psi"), states, strict=True):
        if not np.isfinite(value).all():
            raise LawError(f"mesh law {law.model!r}: {name} is not finite; give finite numbers in SI")
    out = np.empty((states[0].size, 7))
    flat = [np.array(v).ravel() for v in states]
    evaluate_many(law_tables(law), flat[0], flat[1], flat[2], h1, h2, out)
    return MeshResponse(*(column.reshape(states[0].shape) for column in out.T))


def shares(
    law: MeshLaw,
    cycle: float,
    delta: float,
    psi: float = 0.0,
    clearance_pinion: np.ndarray | None = None,
    clearance_wheel: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Pair numbers p (n,) near mesh and their forces (n,) in N, which sum to F."""
    h1, h2 = checked_clearances(law, clearance_pinion, clearance_wheel)
    reach = share_reach(law)
    force = np.zeros(2 * reach + 1)
    evaluate_shares(law_tables(law), float(cycle), float(delta), float(psi), h1, h2, force)
    return math.floor(law.cycle_sign * cycle + law.cycle_offset) + np.arange(-reach, reach + 1), force
