"""Gyroscopic moments of all shafts in the time step: a pair of forces on two modal rows, per plane of `gyroscopic`.

The forces g Omega (b', -a') do no work. The linearised view takes the whole matrix in their place.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mbd.forces.element import Element, rule
from mbd.parts.gyroscopic import planes, rolling_matrix

if TYPE_CHECKING:
    from mbd.forces.assembly import Assembly

KIND = "gyroscopic"


@rule(__file__)
def plane_rule(values, motion, answer):
    """Forces on the rows a and b; ``values`` is the strength (kg m2)."""
    g = values[0] * motion.speed
    answer.lost[0], answer.lost[1] = g * motion.v[1], -g * motion.v[0]
    answer.lost_by_v[0, 1], answer.lost_by_v[1, 0] = g, -g


def elements(assembly: Assembly) -> Iterator[Element]:
    """The strongest planes in the modes of the machine, if gyroscopic moments count."""
    if not assembly.machine.gyroscopic:
        return
    basis, _ = assembly.modes
    first, second, strengths, _ = planes(basis.T @ rolling_matrix(assembly.layout) @ basis)
    back = basis.T @ assembly.mass
    for i, (a, b, strength) in enumerate(zip(first @ back, second @ back, strengths, strict=True)):
        size = abs(float(strength)) * (assembly.machine.profile.highest or 1.0)
        yield Element(
            kind=KIND,
            name=f"{KIND}:{i}",
            part="",
            rule=plane_rule,
            values=(float(strength),),
            rows=np.vstack([a, b]),
            row_names=("a", "b"),
            scale=(size, size),
        )
