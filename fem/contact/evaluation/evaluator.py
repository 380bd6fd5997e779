"""Evaluation of a MeshLaw: forces, energy and their derivatives at a state, line loads, approach at a load.

In a slice of width w let x_p be the free approach of pair p (delta + psi y less all gaps), phi_p its fraction and f_p
its line load. The complementary energy

    W*(f) = w { sum_p phi_p [C f_p^2/2 + A f_p^2 (B/2 + 1/4 - ln(f_p)/2)] + sum_{p<q} c_pq phi_p phi_q f_p f_q }

has dW*/df_p = w phi_p (C f_p + A f_p (B - ln f_p) + sum_q c_pq phi_q f_q), so the contact conditions are those of the
convex problem min W*(f) - w sum phi_p x_p f_p, f >= 0, and its negative minimum is the strain energy U. By the envelope
theorem its first derivatives are the explicit ones: dU/d delta = F, dU/d psi = M.

A slice in contact on a part of its width has less of both, see `fem.contact.part_contact`.

The Hertz term A f (B - ln f) stops growing at ln f = B - 1, where its contact width reaches the depth at which the
displacement is counted; above it is held constant, which keeps the law monotone at any load.

The line loads are solved in `fem.contact.evaluation.solver`; compiled callers take `fem.contact.evaluation.kernel`.
Nothing is kept between calls: equal states give equal answers.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fem.contact.evaluation.kernel import approach_many, evaluate_many, first_touch
from fem.contact.evaluation.law_tables import LARGEST_NEAR, MAX_SPAN, pack
from fem.contact.evaluation.slice_contacts import NEAR_ROOM
from fem.contact.law import MeshLaw
from fem.contact.teeth import LawError, checked_terms

Teeth = np.ndarray | None  # terms (z, 6), clearances (z,) in m, or None for sound teeth without deviation
Values = np.ndarray | float


class MeshResponse(NamedTuple):
    """What a law answers at a state, as arrays of one shape."""

    force: Any  # F, N
    moment: Any  # M, N m
    energy: Any  # U, J
    stiffness: Any  # dF/d delta, N/m
    cross_stiffness: Any  # dF/d psi = dM/d delta, N
    tilt_stiffness: Any  # dM/d psi, N m


class LawEvaluator:
    """A mesh law made ready for evaluation.

    A state is a mesh cycle c, an approach delta along the transverse line of action (m) and a tilt psi (rad).

    Parameters
    ----------
    law : the law; `packed` (n,) holds its numbers for `fem.contact.evaluation.kernel`

    Raises
    ------
    LawError : compliances not positive, fractions outside [0, 1], a grid that spans too many pitches
    """

    def __init__(self, law: MeshLaw) -> None:
        _check(law)
        self.law = law
        self.packed = pack(law)

    def evaluate(
        self, cycle: Values, delta: Values, psi: Values = 0.0, pinion: Teeth = None, wheel: Teeth = None
    ) -> MeshResponse:
        """Response at states.

        Parameters
        ----------
        cycle, delta, psi : 1, m, rad, numbers or arrays that broadcast together
        pinion, wheel : what single teeth bring, see `Teeth`

        Raises
        ------
        LawError : a state is not finite, or as `teeth`
        """
        return self._respond(cycle, delta, psi, *self.teeth(pinion, wheel))

    def line_loads(
        self, cycle: Values, delta: Values, psi: Values = 0.0, pinion: Teeth = None, wheel: Teeth = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Numbers p (n, pair) of all pairs that may be near mesh at n states, and their loads (n, pair, slice), N/m.

        The load is phi f, what the strain energy loses per width and gap opened there.

        Parameters
        ----------
        cycle, delta, psi : 1, m, rad, numbers or (n,)
        pinion, wheel : see `Teeth`
        """
        law = self.law
        last = law.position_start + (law.compliance.size - 1) * law.position_step
        reach = math.ceil(max(abs(law.position_start), abs(last)) + float(np.abs(law.cycle_shift).max())) + 1
        c = np.broadcast_arrays(np.atleast_1d(cycle), delta, psi)[0]
        loads = np.zeros((c.size, 2 * reach + 1, law.face_coordinate.size))
        self._respond(c, delta, psi, *self.teeth(pinion, wheel), loads)
        first = np.floor(law.cycle_sign * c + law.cycle_offset).astype(int)
        return first[:, None] + np.arange(-reach, reach + 1), loads

    def shares(
        self, cycle: float, delta: float, psi: float = 0.0, pinion: Teeth = None, wheel: Teeth = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Numbers p (n,) of the pairs near mesh and their forces (n,) in N at one state, which sum to F.

        Parameters
        ----------
        cycle, delta, psi : 1, m, rad
        pinion, wheel : see `Teeth`
        """
        pairs, loads = self.line_loads(cycle, delta, psi, pinion, wheel)
        return pairs[0], loads[0] @ self.law.slice_width

    def no_load(self, cycle: Values, psi: Values = 0.0, pinion: Teeth = None, wheel: Teeth = None) -> np.ndarray:
        """delta (n,) in m at which the force of the law begins: the least gap + h - psi y over its slices and pairs.

        The flanks touch earlier if a slice is tilted, see `fem.contact.evaluation.first_touch`.

        Parameters
        ----------
        cycle, psi : 1, rad, numbers or (n,)
        pinion, wheel : see `Teeth`

        Raises
        ------
        LawError : no pair can touch at some cycle
        """
        c, tilt = (np.array(v, dtype=float) for v in np.broadcast_arrays(np.atleast_1d(cycle), psi))
        found = np.empty(c.size)
        first_touch(self.packed, c, tilt, *self.teeth(pinion, wheel), np.empty(NEAR_ROOM), found)
        if not np.isfinite(found).all():
            raise LawError(
                f"mesh law {self.law.model!r}: no tooth pair can touch at cycle {c[~np.isfinite(found)][0]:.6g}: "
                "too many teeth are missing side by side. Delete one of these faults"
            )
        return found

    def approach_at(
        self, force: Values, cycle: Values, psi: Values = 0.0, pinion: Teeth = None, wheel: Teeth = None
    ) -> np.ndarray:
        """delta in m at which the law carries a force, (n,), or forces, (n, m).

        Parameters
        ----------
        force : N, > 0, a number or (m,), ascending
        cycle : 1, a number or (n,)
        psi : rad, a number or (n,)
        pinion, wheel : see `Teeth`

        Raises
        ------
        LawError : no pair can touch, or the force is not reached within the gaps that the law knows
        """
        forces, teeth = np.atleast_1d(np.asarray(force, dtype=float)), self.teeth(pinion, wheel)
        c, tilt = (np.array(v, dtype=float) for v in np.broadcast_arrays(np.atleast_1d(cycle), psi))
        found = np.empty((c.size, forces.size))
        approach_many(self.packed, forces, c, tilt, *teeth, self.no_load(c, tilt, *teeth), found)
        if np.isnan(found).any():
            row, column = np.argwhere(np.isnan(found))[0]
            raise LawError(
                f"mesh law {self.law.model!r}: F = {forces[column]:.6g} N is not reached at cycle {c[row]:.6g}: the "
                "deflection is beyond the tip-edge gaps that the law contains. Reduce the force"
            )
        return found[:, 0] if np.ndim(force) == 0 else found

    def teeth(self, pinion: Teeth, wheel: Teeth) -> tuple[np.ndarray, np.ndarray]:
        """Tooth terms (z1, 6) and (z2, 6) of what is given as `Teeth`.

        Raises
        ------
        LawError : wrong shape, a variant that the law does not have
        """
        law, checked = self.law, []
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

    def _respond(
        self, cycle: Values, delta: Values, psi: Values, pinion: np.ndarray, wheel: np.ndarray, loads: Any = None
    ) -> MeshResponse:
        """Response at states, with checked teeth; line loads of the states into loads (n, place, slice)."""
        given = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (cycle, delta, psi)))
        for name, value in zip(("cycle", "delta", "psi"), given, strict=True):
            if not np.isfinite(value).all():
                raise LawError(f"mesh law {self.law.model!r}: {name} is not finite; give finite numbers in SI")
        states = np.stack([value.ravel() for value in given], axis=1)
        answer = np.empty((len(states), 6))
        evaluate_many(self.packed, states, pinion, wheel, answer, np.empty((1, 0, 0)) if loads is None else loads)
        return MeshResponse(*(column.reshape(given[0].shape) for column in answer.T))


def _check(law: MeshLaw) -> None:
    n = law.compliance.size
    span = (n - 1) * law.position_step
    overlap = float(np.ptp(law.cycle_shift))
    softest = min(
        float(v.min()) if v.size else 0.0 for v in (law.pinion_variant_compliance, law.wheel_variant_compliance)
    )
    for bad, message in (
        (n < 2 or law.position_step <= 0.0, f"{n} positions with step {law.position_step!r}; give >= 2 with step > 0"),
        (span > MAX_SPAN, f"positions span {span:.4g} pitches; the limit is {MAX_SPAN}"),
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
