"""Gyroscopic moments of shafts and disks that turn at the speed Omega about +y: forces -Omega G u' with G skew.

The momentum J_p Omega (-rz, 1, rx) of a tilted disk asks for the moments M_x = -J_p Omega rz', M_z = J_p Omega rx': G
has
-J_p in (rx, rz) and J_p in (rz, rx). A beam element spreads
2 rho I over its length as its rotary inertia is spread, in the same shape functions (Nelson, 1980). G does no work.

In the modal basis only a few planes of G matter: G = sum g (a b^T - b a^T), by the real Schur form of Phi^T G Phi. The
planes that hold ``KEPT`` of its norm enter the time step, each as a force on two rows, at the speed of the moment;
what is left out is stated by `planes`. The torque by a change of speed on a tilted disk, J_p Omega' times the tilt, is
neglected.

References
----------
Nelson (1980), J. Mech. Des. 102(4), 793-803; Genta (2005), Dynamics of Rotating Systems, 4.5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from mbd.parts.shafts import ShaftSpec, node_at, rotary_inertia

if TYPE_CHECKING:
    from mbd.coordinates.layout import Layout

KEPT = 0.999


def gyroscopic_matrix(spec: ShaftSpec, nodes: np.ndarray) -> np.ndarray:
    """G (6 node, 6 node) of a shaft with its disks, kg m2 and consistent units, per rad/s about +y."""
    size = 6 * len(nodes)
    matrix = np.zeros((size, size))
    for at, tilt in rotary_inertia(spec, nodes):
        # tilt (4, 4) is the rotary inertia in one plane over (v1, t1, v2, t2); z-plane (uz, rx), x-plane (ux, -rz)
        z_plane = [at + 2, at + 3, at + 8, at + 9]
        x_plane = [at + 0, at + 5, at + 6, at + 11]
        flip = np.diag([1.0, -1.0, 1.0, -1.0])
        block = 2.0 * tilt @ flip
        matrix[np.ix_(z_plane, x_plane)] += block
        matrix[np.ix_(x_plane, z_plane)] -= block.T
    for disk in spec.disks:
        at = 6 * node_at(nodes, disk.y)
        matrix[at + 3, at + 5] -= disk.polar_inertia
        matrix[at + 5, at + 3] += disk.polar_inertia
    return matrix


def rolling_matrix(lay: Layout) -> np.ndarray:
    """G (n, n) of all shafts of a machine per speed of the motor."""
    ratios = lay.machine.ratios()
    matrix = np.zeros((lay.size, lay.size))
    for shaft in lay.machine.shafts:
        nodes, base, span = lay.nodes[shaft.name], lay.bases[shaft.name], lay.spans[shaft.name]
        matrix[span, span] = shaft.sense * ratios[shaft.name] * base.T @ gyroscopic_matrix(shaft, nodes) @ base
    return matrix


def planes(reduced: np.ndarray, kept: float = KEPT) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Rows a, b (plane, mode), strengths g (plane,) of a skew matrix (mode, mode), strongest first, and the share of
    its
    Frobenius norm that the planes left out hold."""
    form, turn = linalg.schur(0.5 * (reduced - reduced.T), output="real")
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
    return turn[:, at[:n]].T, turn[:, at[:n] + 1].T, strength[:n], float(np.sqrt(max(left[n - 1], 0.0)))
