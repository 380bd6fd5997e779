"""Contact at many mesh positions by `fem.contact.wheels.direct_contact`, with tilt, clearances of pairs and energy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from fem.contact.wheels.compliance import ContactCompliance
from fem.contact.wheels.direct_contact import contact_at


class ContactStates(NamedTuple):
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
    share: np.ndarray  # (state, pair) of F


def solve(
    record: ContactCompliance,
    index: np.ndarray | None = None,
    *,
    force: np.ndarray | float,
    tilt: float | None = 0.0,
    sign: int = 1,
    clearance: Mapping[int, np.ndarray | float] | None = None,
) -> ContactStates:
    """Solve for forces (N), and for a given tilt (rad) or (tilt None) zero moment.

    ``index`` are grid positions, by default one cycle; ``sign`` is -1 for the coast flank; ``clearance`` is added to
    the gaps of the pairs of these numbers.
    """
    count = len(record.position)
    index = np.arange(count) if index is None else np.atleast_1d(index)
    y, states = sign * record.hand * record.face, []
    for number, load in zip(index.tolist(), np.broadcast_to(force, index.shape).tolist(), strict=True):
        pair = record.pair + number // count
        extra = np.zeros(record.gap.shape[1:])
        for one, value in (clearance or {}).items():
            extra[pair == one] += value

        def at(psi, number=number, load=load, extra=extra):
            return contact_at(record, number, load, extra - psi * y)

        def moment(psi, at=at):
            return float((at(psi)[1] * record.slice_width * y).sum())

        psi = float(brentq(moment, -0.01, 0.01, xtol=1e-16)) if tilt is None else tilt
        delta, line = at(psi)
        loads, gap = line * record.slice_width, record.gap[number % count] + extra - psi * y
        states.append(
            ContactStates(
                cycle=number / count,
                approach=delta,
                tilt=psi,
                force=loads.sum(),
                moment=(loads * y).sum(),
                energy=_energy(record, number % count, line),
                no_load=gap.min(),
                pair=pair,
                line_load=line,
                share=loads.sum(axis=1) / loads.sum(),
            )
        )
    return ContactStates(*(np.array(column) for column in zip(*states, strict=True)))


def _energy(record: ContactCompliance, place: int, line_load: np.ndarray) -> float:
    loads, A = line_load * record.slice_width, record.contact_slope
    line = np.where(line_load > 0, line_load, 1.0)
    depth = record.contact_offset[place] - np.log(line)
    top = np.exp(np.minimum(record.contact_offset[place] - 1.0, 700.0))
    stored = np.where(depth > 1, line**2 * (depth / 2 - 0.25), top**2 / 4)  # x f less the complementary energy
    body = np.einsum("ps,psqt,qt->", loads, record.compliance[place], loads, optimize=True) / 2
    return float(body + np.where(line_load > 0, record.slice_width * A * stored, 0.0).sum())
