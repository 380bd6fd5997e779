"""Rolling frame: how the frame moves in which the coordinates are measured.

Total motion = R phi + q with the rolling pattern R of the train. Where motors prescribe the speed, phi(t) is known. A
free train is driven by torques, and its frame is the rigid rolling itself: with K R = 0 and C R = 0, multiplying the
equations of motion by R^T gives

    J phi'' = R^T f + R^T B^T lambda,   J = R^T M R,

while q stays M-orthogonal to R, so that the inertia force -M R phi'' does no work on it and the modes of q have no
motion at 0 Hz. Within a step lambda is a polynomial of time, sum_s w_s(theta) lambda_(n+1-s), and so is phi'': speed
and angle are its exact integrals. The forces of a step are evaluated at the angle and speed that extrapolated forces
predict, which differ from those of the step by h^2 times the error of the extrapolated acceleration.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem.numerics.inner_functions import inner
from mbd.elements.element import Element
from mbd.parts.part_checks import MachineError

ROUND_OFF = 1e-12  # of the largest rolling of a row


class RollingFrame(NamedTuple):
    """What moves the frame (a tuple that numba reads)."""

    free: int  # 1 where torques move it, 0 where its motion is prescribed
    load: float  # R^T f / J, rad/s2
    push: np.ndarray  # (m,) R^T B^T / J, rad/s2 per unit of force


def rolling_frame(
    free: bool, mass: np.ndarray, rolling: np.ndarray, force: np.ndarray, rows: np.ndarray, elements: list[Element]
) -> RollingFrame:
    """The frame of a machine.

    Parameters
    ----------
    free : whether torques alone drive the train
    mass : M (n, n)
    rolling, force : R and f (n,)
    rows, elements : B (m, n) and the elements that they belong to

    Raises
    ------
    MachineError : an element of a free train whose linear reference would hold the rolling
    """
    turning = mass @ rolling
    inertia = float(rolling @ turning)
    along = rows @ rolling
    along[abs(along) < ROUND_OFF * abs(along).max(initial=0.0)] = 0.0
    if free:
        first = 0
        for element in elements:
            own = along[first : first + len(element.rows)]
            first += len(element.rows)
            held = element.reference("stiffness") + element.reference("damping")
            if ((own != 0.0) & (held != 0.0) & np.full(len(own), element.rolls)).any():
                raise MachineError(
                    f"{element.name}: its linear reference restrains the rotation of a train that torques drive. Omit "
                    "the reference, or drive the machine by speed."
                )
    return RollingFrame(int(free), float(rolling @ force) / inertia, along / inertia)


@inner()
def frame_acceleration(frame, powers, past_forces, force):
    """Mean over a step of phi'' (rad/s2), and of (1 - theta) phi'' theta = 0..1: speed grows by h times the first, the
    angle by h speed + h^2 times the second.

    Parameters
    ----------
    frame : `RollingFrame`
    powers : (k, s) polynomials of the hold, see `mbd.integrators.modal.Hold`
    past_forces : (3, m) forces lambda of the instants before, newest first
    force : (m,) forces at the end of the step
    """
    mean, early = 0.0, 0.0
    for s in range(powers.shape[1]):
        whole, part = 0.0, 0.0
        for k in range(len(powers)):
            whole += powers[k, s] / (k + 1)
            part += powers[k, s] / ((k + 1) * (k + 2))
        if whole != 0.0 or part != 0.0:
            a = frame.load
            for r in range(len(force)):
                if frame.push[r] != 0.0:
                    a += frame.push[r] * (force[r] if s == 0 else past_forces[s - 1, r])
            mean, early = mean + whole * a, early + part * a
    return mean, early
