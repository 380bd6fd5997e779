"""Gyroscopic moments of all parts in the time step: a pair of forces on two modal rows, per plane of their matrix.

In the modal basis a few planes of G are sufficient: G = sum g (a b^T - b a^T), by the real Schur form of Phi^T G Phi.
The planes that contain ``KEPT`` of its norm enter the time step, each as a force on two rows, at the present speed;
`planes` returns the share that is left out. The forces g Omega (b', -a') do no work. The linearised model uses the
whole matrix in their place.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import linalg

from mbd.elements.element import Element, rule
from mbd.parts.linear_reference import Assembly

KIND = "gyroscopic"
KEPT = 0.999


@rule(__file__)
def plane_rule(values, motion, answer):
    """Forces on the rows a and b; ``values`` is the strength (kg m2)."""
    g = values[0] * motion.speed
    answer.lost[0], answer.lost[1] = g * motion.v[1], -g * motion.v[0]
    answer.lost_by_v[0, 1], answer.lost_by_v[1, 0] = g, -g


def elements(assembly: Assembly) -> Iterator[Element]:
    """Strongest planes in the modes of the machine, if the scene includes gyroscopic moments."""
    if not assembly.machine.gyroscopic:
        return
    basis, _ = assembly.modes
    first, second, strengths, _ = planes(basis.T @ assembly.gyroscopic @ basis)
    back = basis.T @ assembly.mass
    for i, (a, b, strength) in enumerate(zip(first @ back, second @ back, strengths, strict=True)):
        size = abs(float(strength)) * (assembly.machine.highest_speed or 1.0)
        yield Element(
            kind=KIND,
            name=f"{KIND}:{i}",
            part="",
            rule=plane_rule,
            values=(float(strength),),
            rows=np.vstack([a, b]),
            row_names=("a", "b"),
            scale=(size, size),
            in_matrix=True,
        )


def planes(reduced: np.ndarray, kept: float = KEPT) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Rows a, b (plane, mode) and strengths g (plane,) of a skew matrix (mode, mode), strongest first, and the share of
    its Frobenius norm in the omitted planes."""
    form, vectors = linalg.schur(0.5 * (reduced - reduced.T), output="real")
    size, found, i = float(abs(form).max(initial=0.0)), [], 0
    while i < len(form) - 1:
        pair = abs(form[i, i + 1]) > 1e-12 * size
        if pair:
            found.append(i)
        i += 2 if pair else 1
    at = np.array(sorted(found, key=lambda k: -abs(form[k, k + 1])), dtype=int)
    strength = form[at, at + 1]
    whole = float(np.sum(strength**2))
    if whole == 0.0:
        empty = np.zeros((0, len(reduced)))
        return empty, empty, np.zeros(0), 0.0
    left = 1 - np.cumsum(strength**2) / whole
    n = int(np.argmax(left <= 1 - kept**2)) + 1
    return vectors[:, at[:n]].T, vectors[:, at[:n] + 1].T, strength[:n], float(np.sqrt(max(left[n - 1], 0.0)))
