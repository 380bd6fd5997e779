"""Kinematics of a parallel-shaft train: lifting speed of every shaft per motor speed, through branches and loops.

A link couples two rotations: a gear mesh with the ratio z1/z2, or a shaft coupling with the ratio 1. Angles are
positive in the lifting sense, so that every ratio is positive. A loop of links can turn only if the ratios around it
agree; otherwise it locks.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbd.elements.component import Link


def shaft_ratios(links: Sequence[Link], start: str) -> dict[str, float]:
    """Lifting angle of every connected shaft per lifting angle of the shaft ``start``, by the ratios of the links.

    Closed loops agree: a scene whose loop locks is refused before.
    """
    result = {start: 1.0}
    waiting = list(links)
    while ready := next((link for link in waiting if link.first in result or link.second in result), None):
        waiting.remove(ready)
        if ready.first not in result:
            result[ready.first] = result[ready.second] / ready.ratio
        elif ready.second not in result:
            result[ready.second] = result[ready.first] * ready.ratio
    return result


def power_flow(flows: Sequence[tuple[int, int]], motors: Sequence[int], drawn: np.ndarray) -> np.ndarray:
    """Power (flow + motor,) through each mesh or coupling and from each motor.

    It follows from the balance of every shaft. Parallel paths are statically indeterminate; the split with the least
    sum of squares is used. The last argument is the power taken from every shaft (shaft,); without motors its sum is 0.

    Parameters
    ----------
    flows : (giver, taker) of every mesh and coupling, numbers of shafts from 0
    motors : number of the shaft that each motor of prescribed speed turns
    """
    balance = np.zeros((len(drawn), len(flows) + len(motors)))
    for k, (giver, taker) in enumerate(flows):
        balance[giver, k], balance[taker, k] = -1.0, 1.0
    for k, shaft in enumerate(motors, len(flows)):
        balance[shaft, k] = 1.0
    size = abs(drawn).max() or 1.0
    share = np.linalg.lstsq(balance, drawn / size, rcond=None)[0]
    whole = np.round(share)
    return size * np.where(abs(share - whole) < 1e-12, whole, share)
