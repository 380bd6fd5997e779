"""Direct contact solution on a `ContactCompliance`: line loads of all tooth pairs at one mesh position, for a force.

With i = (pair, slice), force F_i = w_i f_i and free approach x_i = delta - gap_i - h_i,

    F_i > 0:  x_i = sum_j C_ij F_j + A f_i (B_i - ln f_i)        F_i = 0:  x_i <= sum_j C_ij F_j
    sum F_i = F

are the conditions of the convex problem min 1/2 F.C F + sum w_i f_i^2 A (B_i/2 + 1/4 - ln(f_i)/2) - x.F over F >= 0,
with delta as the multiplier of the sum. It is solved by Newton's method on the loaded set. A contact leaves the set
when its load becomes zero and returns where the surfaces would overlap. A tilt psi is a clearance of -psi y_i.

Above ln f = B - 1, where the Hertz contact is nearly as wide as its depth d, its approach is held constant, as in
`fem.contact.evaluation.line_contact`. Reference: Johnson (1985), Contact Mechanics, 5.9 (quadratic programme).
"""

from __future__ import annotations

import numpy as np

from fem.contact.slice_frame import ModelError
from fem.contact.wheels.compliance import ContactCompliance

_ROUNDS = 200
_CLOSE = 1e-9  # largest step of a converged solution, relative to the largest load
_FIRST_REACH = 2e-6  # m, largest gap of the contacts loaded in the first iteration


def contact_at(
    record: ContactCompliance, index: int, force: float, clearance: np.ndarray | float = 0.0
) -> tuple[float, np.ndarray]:
    """Contact at the mesh position index / positions, any whole number of cycles on.

    Parameters
    ----------
    record : compliances of the flank that is loaded
    index : grid position; of a later cycle, pair p of the record is pair p + index // positions
    force : N, > 0, along the transverse line of action
    clearance : h added to the gaps of the record, m, that broadcasts to (pair, slice); inf: cannot touch

    Returns
    -------
    approach : delta, m
    line_load : f (pair, slice) per face width, N/m

    Raises
    ------
    ModelError : no tooth pair can touch, or the iteration has not settled
    """
    place, width = index % len(record.position), np.broadcast_to(record.slice_width, record.gap.shape[1:])
    gap, w, B = (record.gap[place] + clearance).ravel(), width.ravel(), record.contact_offset[place].ravel()
    C, A = record.compliance[place].reshape(gap.size, gap.size), record.contact_slope
    if not np.isfinite(gap).any():
        raise ModelError(
            f"model solid: no tooth pair can touch at state {index}; too many teeth are missing side by side. Delete "
            "one of these faults"
        )
    loads = np.where(gap - gap.min() <= _FIRST_REACH, 1.0, 0.0)
    loads *= force / loads.sum()
    delta, own, unloaded = 0.0, np.diagonal(C), A * np.maximum(B, 1.0) / w
    for _ in range(_ROUNDS):
        on = loads > 0.0
        line = loads[on] / w[on]
        depth = B[on] - np.log(line)
        hertz = A * np.where(depth > 1.0, line * depth, np.exp(np.minimum(B[on] - 1.0, 700.0)))
        sum_row = np.full((1, len(line)), C.max())  # scaled like the compliances
        system = C[np.ix_(on, on)] + np.diag(A * np.maximum(depth - 1.0, 0.0) / w[on])
        matrix = np.block([[system, -np.ones((len(line), 1))], [sum_row, np.zeros((1, 1))]])
        rest = delta - gap[on] - C[np.ix_(on, on)] @ loads[on] - hertz
        *move, change = np.linalg.solve(matrix, np.append(rest, C.max() * (force - loads.sum())))
        trial, delta = loads.copy(), delta + float(change)
        trial[on] += move
        new = np.maximum(trial, 0.0)
        left = delta - gap - C @ new  # approach minus deflection
        gone, back = on & (trial <= 0.0), ~on & (left > 1e-12 * abs(delta) + 1e-18)
        new = np.where(gone & (left > 0.0), 0.1 * loads, new)
        loads = np.where(back, left / (own + unloaded), new)
        if not (gone | back).any() and np.abs(move).max() <= _CLOSE * loads.max():
            return delta, (loads / w).reshape(width.shape)
    raise ModelError(
        f"model solid: the contact iteration has not settled within {_ROUNDS} rounds (at state {index}, delta "
        f"{delta:.4g} m); give a larger force, or fewer slices"
    )
