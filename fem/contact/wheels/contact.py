"""Direct contact solution on a `ContactCompliance`: line loads of all tooth pairs, for given force or approach.

With i = (pair, slice), force F_i = w_i f_i and free approach x_i = delta + psi y_i - gap_i - h_i,

    F_i > 0:  x_i = sum_j C_ij F_j + A f_i (B_i - ln f_i)        F_i = 0:  x_i <= sum_j C_ij F_j
    sum F_i = F,   sum F_i y_i = M

are the conditions of the convex problem min 1/2 F.C F + sum w_i f_i^2 A (B_i/2 + 1/4 - ln(f_i)/2) - x.F over F >= 0,
with delta and psi as the multipliers of the two sums if these are given instead. It is solved by Newton's method on the
loaded set, for all mesh positions at once. A contact leaves the set when its load becomes zero and returns where the
surfaces would overlap.

Above ln f = B - 1, where the Hertz contact is nearly as wide as its depth d, its approach is held constant, as in
`fem.contact.evaluation.hertz`. Reference: Johnson (1985), Contact Mechanics, 5.9 (quadratic programme).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fem.contact.frame import ModelError
from fem.contact.wheels.compliance import ContactCompliance

_ROUNDS = 200
_CLOSE = 1e-9  # largest step of a converged solution, relative to the largest load
_FIRST_REACH = 2e-6  # m, largest gap of the contacts loaded in the first iteration


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactState:
    """Solved contacts at the grid positions index / positions, with arrays (state,) or (state, pair, slice)."""

    cycle: np.ndarray  # c' of the flank
    approach: np.ndarray  # delta, m
    tilt: np.ndarray  # psi, rad
    force: np.ndarray  # F, N
    moment: np.ndarray  # M, N m
    energy: np.ndarray  # U, J
    no_load: np.ndarray  # delta at first contact of a slice at this tilt, m
    pair: np.ndarray  # (state, pair) tooth pair numbers
    line_load: np.ndarray  # f per face width, N/m
    half_width: np.ndarray  # a of the Hertz contact, m
    pressure: np.ndarray  # largest Hertz pressure, Pa
    share: np.ndarray  # (state, pair) of F


def solve(
    record: ContactCompliance,
    index: np.ndarray | None = None,
    *,
    sign: int = 1,
    force: np.ndarray | float | None = None,
    approach: np.ndarray | float | None = None,
    tilt: np.ndarray | float | None = 0.0,
    clearance: Mapping[int, np.ndarray | float] | None = None,
) -> ContactState:
    """Solve for given force or approach, and for given tilt or (tilt None) zero moment.

    Parameters
    ----------
    record : compliances of the pair
    index : int (state,), grid positions: c' = index / positions, any integers; default one cycle
    sign : +1 drive, -1 coast: the face coordinate is y = sign * hand * zeta
    force, approach : F in N or delta in m, one of them, (state,) or a number
    tilt : psi in rad, (state,) or a number
    clearance : of tooth pairs by their number p, in m, for the whole face or by slice of zeta; +inf for a missing
        tooth. Pair p is at xi = c' - p + cycle_shift

    Raises
    ------
    ModelError : no contact can carry the force, the iteration fails, or the record is for the other flank
    """
    if record.flank == -sign:
        raise ModelError(
            f"model solid: these compliances are those of the flank {record.flank:+d}, not of {sign:+d}: "
            "with an offset web each flank has separate compliances. Compute the record of that flank"
        )
    count = len(record.position)
    index = np.arange(count) if index is None else np.atleast_1d(np.asarray(index, dtype=int))
    inside, turns = index % count, index // count
    numbers = record.pair + turns[:, None]
    shape = (len(index), *record.gap.shape[1:])
    gap = record.gap[inside]
    for number, value in (clearance or {}).items():
        gap = gap + np.where((numbers == number)[:, :, None], np.broadcast_to(value, shape[2]), 0.0)
    y = np.broadcast_to(sign * record.hand * record.face, shape).reshape(len(index), -1)
    width = np.broadcast_to(record.slice_width, shape).reshape(len(index), -1)
    problem = _Problem(
        compliance=record.compliance.reshape(count, y.shape[1], y.shape[1])[inside],
        slope=record.contact_slope,
        offset=record.contact_offset[inside].reshape(len(index), -1),
        gap=gap.reshape(len(index), -1),
        y=y,
        width=width,
    )
    given = [None if v is None else np.broadcast_to(np.asarray(v, dtype=float), index.shape) for v in (force, approach)]
    turn = None if tilt is None else np.broadcast_to(np.asarray(tilt, dtype=float), index.shape)
    loads, delta, psi = _newton(problem, given[0], given[1], turn)
    line = loads / width
    half = record.depth * np.sqrt(line) * np.exp((0.5 - problem.offset) / 2)
    total = loads.sum(axis=1)
    free = np.where(np.isfinite(problem.gap), problem.gap - psi[:, None] * y, np.inf).min(axis=1)
    by_pair = loads.reshape(shape).sum(axis=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        pressure = np.where(line > 0, 2 * line / (np.pi * half), 0.0)
        share = by_pair / total[:, None]
    return ContactState(
        cycle=index / count,
        approach=delta,
        tilt=psi,
        force=total,
        moment=(loads * y).sum(axis=1),
        energy=problem.energy(loads),
        no_load=free,
        pair=numbers,
        line_load=line.reshape(shape),
        half_width=half.reshape(shape),
        pressure=pressure.reshape(shape),
        share=share,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class _Problem:
    """Arrays of all states with the contacts i in one row; compliance (state, i, i)."""

    compliance: np.ndarray
    slope: float
    offset: np.ndarray
    gap: np.ndarray
    y: np.ndarray
    width: np.ndarray

    def at(self, states: np.ndarray) -> _Problem:
        """The problem of selected states."""
        return _Problem(
            compliance=self.compliance[states],
            slope=self.slope,
            offset=self.offset[states],
            gap=self.gap[states],
            y=self.y[states],
            width=self.width[states],
        )

    def approach(self, delta: np.ndarray, psi: np.ndarray) -> np.ndarray:
        """x (state, i), -inf where no contact is possible."""
        return delta[:, None] + psi[:, None] * self.y - self.gap

    def hertz(self, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Approach A f (B - ln f) and its derivative by the force, both finite and the former 0 without load."""
        line = np.where(loads > 0, loads / self.width, 1.0)
        depth = self.offset - np.log(line)
        top = self.slope * np.exp(np.minimum(self.offset - 1.0, 700.0))
        value = np.where(depth > 1, self.slope * line * depth, top)
        return np.where(loads > 0, value, 0.0), np.where(depth > 1, self.slope * (depth - 1), 0.0) / self.width

    def energy(self, loads: np.ndarray) -> np.ndarray:
        """Strain energy (state,), J: the complementary energy with the Hertz part replaced by its strain energy."""
        line = np.where(loads > 0, loads / self.width, 1.0)
        depth = self.offset - np.log(line)
        top = np.exp(np.minimum(self.offset - 1.0, 700.0))
        stored = np.where(depth > 1, line**2 * (depth / 2 - 0.25), top**2 / 4)  # x f - complementary energy
        body = np.einsum("ci,cij,cj->c", loads, self.compliance, loads, optimize=True) / 2
        return body + np.where(loads > 0, self.width * self.slope * stored, 0.0).sum(axis=1)


def _newton(
    problem: _Problem, force: np.ndarray | None, approach: np.ndarray | None, tilt: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces (state, i), delta and psi (state,); all states at once, converged states are skipped."""
    states = len(problem.gap)
    psi = np.zeros(states) if tilt is None else tilt.copy()
    free = np.where(np.isfinite(problem.gap), problem.gap - psi[:, None] * problem.y, np.inf)
    if force is not None and not np.isfinite(free).any(axis=1).all():
        raise ModelError(
            f"model solid: no tooth pair can touch at state {int(np.argmin(np.isfinite(free).any(axis=1)))}; too many "
            "teeth are missing side by side. Delete one of these faults"
        )
    near = free - (free.min(axis=1, initial=np.inf) if approach is None else approach)[:, None]
    loaded = near <= (_FIRST_REACH if force is not None else 0.0)
    start = force if force is not None else np.ones(states)
    loads = np.where(loaded, (start / np.maximum(loaded.sum(axis=1), 1))[:, None], 0.0)
    delta = np.zeros(states) if approach is None else approach.copy()
    busy = np.arange(states)
    for _ in range(_ROUNDS):
        part = problem.at(busy)
        target = None if force is None else force[busy]
        new, delta[busy], psi[busy], done = _step(part, loads[busy], delta[busy], psi[busy], target, tilt is None)
        loads[busy] = new
        busy = busy[~done]
        if not len(busy):
            return loads, delta, psi
    raise ModelError(
        f"model solid: the contact iteration of {len(busy)} of {states} states has not settled within {_ROUNDS} rounds "
        f"(first at state {busy[0]}, delta {delta[busy[0]]:.4g} m); give a larger force, or fewer slices"
    )


def _step(
    problem: _Problem,
    loads: np.ndarray,
    delta: np.ndarray,
    psi: np.ndarray,
    force: np.ndarray | None,
    balanced: bool,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """One Newton step: new loads, delta, psi, and which states are solved."""
    states, size = loads.shape
    active = loads > 0
    hertz, rate = problem.hertz(loads)
    rest = problem.approach(delta, psi) - np.einsum("cij,cj->ci", problem.compliance, loads) - hertz
    matrix = np.zeros((states, size + 2, size + 2))
    both = active[:, :, None] & active[:, None, :]
    matrix[:, :size, :size] = np.where(both, problem.compliance, 0.0)
    here = np.arange(size)
    matrix[:, here, here] = np.where(active, matrix[:, here, here] + rate, 1.0)
    right = np.zeros((states, size + 2, 1))
    right[:, :size, 0] = np.where(active, rest, 0.0)
    matrix[:, [size, size + 1], [size, size + 1]] = 1.0
    for row, wanted, weights in (
        (size, force, np.where(active, 1.0, 0.0)),
        (size + 1, np.zeros(states) if balanced else None, np.where(active, problem.y, 0.0)),
    ):
        if wanted is not None:
            matrix[:, :size, row], matrix[:, row, :size], matrix[:, row, row] = -weights, weights, 0.0
            right[:, row, 0] = wanted - (weights * loads).sum(axis=1)
    scale = np.ones(size + 2)  # scales compliances and sums to similar magnitudes
    scale[size:] = problem.compliance.max()
    answer = np.linalg.solve(matrix * scale[:, None] * 1.0, right * scale[:, None])[..., 0]
    move, delta, psi = answer[:, :size], delta + answer[:, size], psi + answer[:, size + 1]
    trial = np.where(active, loads + move, 0.0)
    new = np.maximum(trial, 0.0)
    left = problem.approach(delta, psi) - np.einsum("cij,cj->ci", problem.compliance, new)  # approach minus deflection
    gone, back = active & (trial <= 0), ~active & (left > 1e-12 * np.abs(delta)[:, None] + 1e-18)
    new = np.where(gone & (left > 0), 0.1 * loads, new)
    own = np.diagonal(problem.compliance, axis1=1, axis2=2)
    new = np.where(back, left / (own + problem.slope * np.maximum(problem.offset, 1.0) / problem.width), new)
    largest = np.maximum(new.max(axis=1), 1e-300)
    done = (
        ~gone.any(axis=1)
        & ~back.any(axis=1)
        & (np.abs(move).max(axis=1, where=active, initial=0.0) <= _CLOSE * largest)
    )
    return new, delta, psi, done
