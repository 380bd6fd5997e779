"""Frequency response of the linearised machine: channels over a force on one row.

With the tangent matrices of `mbd.system.linearised` about the loaded equilibrium and a force F e^(i omega t) on the row
r, (K_t + i omega C_t - omega^2 M) q = r^T F, and a channel is D q + i omega V q - omega^2 A q.
"""

from __future__ import annotations

import numpy as np

from mbd.system.linearised import tangent
from mbd.system.statics import State, equilibrium
from mbd.system.system import System


def frequency_response(
    system: System, force: str, frequencies: np.ndarray, state: State | None = None, speed: float = 0.0, row: int = 0
) -> np.ndarray:
    """Complex amplitude (channel, frequency) of every channel per newton, or newton metre, on a row of an element.

    Parameters
    ----------
    system : the machine in its casing
    force : name of the element: an outside force, or the flank of a mesh
    frequencies : (frequency,) Hz
    state : where the machine is; None for the loaded equilibrium
    speed : of the motors for the equilibrium, rad/s
    row : number of the row of the element
    """
    small = tangent(system, equilibrium(system, speed) if state is None else state)
    rows, channels, at = system.rows, system.channels, system.at(force).start + row
    found = np.zeros((len(channels.names), len(frequencies)), dtype=complex)
    for i, omega in enumerate(2 * np.pi * np.asarray(frequencies)):
        q = np.linalg.solve(small.stiffness + 1j * omega * small.damping - omega**2 * system.mass, rows[at])
        forces = (small.force_slope + 1j * omega * small.force_slope_rate) @ (rows @ q)
        forces[at] += 1.0
        found[:, i] = channels.displacement @ q + 1j * omega * (channels.velocity @ q)
        found[:, i] += channels.forces @ forces - omega**2 * (channels.acceleration @ q)
    return found
