"""Blocked forces of gears and shafts on a casing, independent of the casing that receives them.

At one frequency a casing with the receptance Y moves under the forces F of the bearings by u = Y F. The forces of the
machine are its blocked forces f, on a casing that does not move, minus the forces of its dynamic stiffness P:
F = f - P u. So

    f = (I + P Y) F,    F' = (I + P Y')^-1 f

gives the forces F' on any other casing Y', whatever excites the machine. P is that of the
tangent machine (`mbd.system.linearised`) without the casing, its coordinates o condensed: P = D_cc - D_co D_oo^-1 D_oc.

Where F is known in part (runs record no moments of bearings), the rest follows from the main excitation:
forces g on the rows B of the loaded flanks have the blocked forces -D_co D_oo^-1 B^T g, and g is a least-squares fit
to the known forces. The remainder of the known forces is attributed to blocked forces along the known coordinates.
The coupling of frequencies by the time-varying mesh stiffness is not modelled.

References
----------
Moorhouse, Elliott & Evans (2009), In situ measurement of the blocked force of structure-borne sound sources, J. Sound
Vib. 325, 679-685; ISO 20270:2019.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.parts.machine_casing import NAME
from mbd.system.linearised import tangent
from mbd.system.statics import State
from mbd.system.system import System

NOTHING = 1e-12  # of the largest term of a matrix: round-off


@dataclass(frozen=True, eq=False, kw_only=True)
class MachineAtSeats:
    """Tangent machine, seen from the casing at its `seats`, the coordinates that the machine acts on."""

    seats: np.ndarray  # (seat,) numbers of coordinates of the casing
    own: tuple[np.ndarray, ...]  # K, C, M (seat, seat) that the machine adds to the casing
    across: tuple[np.ndarray, ...]  # K, C, M (seat, other)
    back: tuple[np.ndarray, ...]  # K, C, M (other, seat)
    rest: tuple[np.ndarray, ...]  # K, C, M (other, other)
    flanks: np.ndarray  # (other, row) of the loaded flanks

    def at(self, omega: float) -> tuple[np.ndarray, np.ndarray]:
        """P (seat, seat) at a circular frequency (rad/s), and blocked forces (seat, row) of forces on the flanks."""
        own, across, back, rest = (
            stiffness + 1j * omega * damping - omega**2 * mass
            for stiffness, damping, mass in (self.own, self.across, self.back, self.rest)
        )
        moved = np.linalg.solve(rest, np.hstack([back, self.flanks]))
        return own - across @ moved[:, : len(own)], -across @ moved[:, len(own) :]


def machine_at_seats(system: System, state: State) -> MachineAtSeats:
    """Tangent machine about a state of rest, without its casing.

    Raises
    ------
    MachineError : a mesh carries no force, so that it has no tangent stiffness
    """
    small, body = tangent(system, state), system.layout.casing
    matrices = small.stiffness, small.damping, system.mass
    casing = system.layout.index(NAME)
    other = np.setdiff1d(np.arange(system.layout.size), casing)
    alone = body.stiffness, body.damping, body.mass
    own = [matrix[np.ix_(casing, casing)] - part for matrix, part in zip(matrices, alone, strict=True)]
    acted = np.zeros(len(casing), dtype=bool)
    for matrix, added in zip(matrices, own, strict=True):
        for block in (added, matrix[np.ix_(casing, other)], matrix[np.ix_(other, casing)].T):
            acted |= abs(block).max(axis=1, initial=0.0) > NOTHING * abs(matrix).max(initial=0.0)
    seats = np.flatnonzero(acted)
    at = casing[seats]
    return MachineAtSeats(
        seats=seats,
        own=tuple(added[np.ix_(seats, seats)] for added in own),
        across=tuple(matrix[np.ix_(at, other)] for matrix in matrices),
        back=tuple(matrix[np.ix_(other, at)] for matrix in matrices),
        rest=tuple(matrix[np.ix_(other, other)] for matrix in matrices),
        flanks=_loaded_rows(system, state)[:, other].T,
    )


def _loaded_rows(system: System, state: State) -> np.ndarray:
    """Rows (row, coordinate) of the flanks that carry the load, of every contact."""
    found = [np.zeros((0, system.layout.size))]
    for number, sides in enumerate(system.contacts.values()):
        loaded = sides[0] if state.mesh_force[number] > 0.0 else sides[-1]
        found.append(system.rows[system.at(loaded.name)])
    return np.vstack(found)


def blocked_forces(
    stiffness: np.ndarray, receptance: np.ndarray, forces: np.ndarray, known: np.ndarray, flanks: np.ndarray
) -> np.ndarray:
    """Blocked forces f (seat,) from forces on a casing, some of which are known.

    Parameters
    ----------
    stiffness, receptance : P and Y (seat, seat)
    forces : F (seat,), complex
    known : (seat,) bool
    flanks : (seat, row) blocked forces of unit forces on the flanks
    """
    coupled = np.eye(len(forces)) + stiffness @ receptance
    if known.all():
        return coupled @ forces
    pushed = np.linalg.solve(coupled, flanks)
    size = np.linalg.norm(pushed[known], axis=0)
    fit = np.linalg.lstsq(pushed[known] / size, forces[known])[0] / size
    left, missing = np.where(known, forces - pushed @ fit, 0.0), np.flatnonzero(~known)
    left[missing] = np.linalg.solve(coupled[np.ix_(missing, missing)], -(coupled @ left)[missing])
    return flanks @ fit + coupled @ left
