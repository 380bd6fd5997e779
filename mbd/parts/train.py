"""Kinematics of a parallel-shaft train: lifting speed of every shaft per motor speed, through branches and loops.

A link couples two rotations: a gear mesh with the ratio z1/z2, or a shaft coupling with the ratio 1. Angles are
positive in the lifting sense, so that every ratio is positive. A loop of links can turn only if the ratios around it
agree; otherwise it locks.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbd.elements.component import Link
from mbd.parts.checks import MachineError

RATIO_TOLERANCE = 1e-9  # relative: teeth are whole numbers, so that ratios agree to round-off or not at all


def shaft_ratios(shafts: Sequence[str], links: Sequence[Link], start: str) -> dict[str, float]:
    """Lifting angle of every shaft per lifting angle of the shaft ``start``, by the ratios of the links.

    Raises
    ------
    MachineError : a shaft that is not connected, or a closed loop whose ratios do not agree
    """
    result = {start: 1.0}
    waiting = list(links)
    while waiting:
        ready = next((link for link in waiting if link.first in result or link.second in result), None)
        if ready is None:
            break
        waiting.remove(ready)
        if ready.first not in result:
            result[ready.first] = result[ready.second] / ready.ratio
        elif ready.second not in result:
            result[ready.second] = result[ready.first] * ready.ratio
        else:
            _closed(ready, result)
    idle = [name for name in shafts if name not in result]
    if idle:
        raise MachineError(
            f"shafts {', '.join(idle)}: no mesh, coupling or motor turns them; remove them or connect them to {start}."
        )
    return result


def _closed(link: Link, ratios: dict[str, float]) -> None:
    around, own = ratios[link.second] / ratios[link.first], link.ratio
    if abs(around - own) > RATIO_TOLERANCE * own:
        raise MachineError(
            f"{link.name}: closes a loop from {link.first} to {link.second} with the ratio {own:.9g}, but the rest of "
            f"the loop has {around:.9g}: the train would lock. Choose teeth so that both paths agree, or open the loop."
        )


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
