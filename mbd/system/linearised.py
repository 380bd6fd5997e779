"""Linearised model: small free motion M q'' + C_t q' + K_t q = 0 about the loaded equilibrium, with the motors held.

With the slopes S_u = d lambda/du, S_v = d lambda/du' of the residual forces on the rows B at the equilibrium

    K_t = K - B^T S_u B,   C_t = C - B^T S_v B:

the tangent of every element at its force, damping as in the time step; the parts are linear already. Eigenvalues lambda
come in the modal basis of the system, which the time step uses as well. At a motor speed the state is the rest in the
rolling frame at mesh cycle, cage angle and rope length of t = 0: C_t then holds the gyroscopic moments Omega G (all of
them, where the time step keeps the strongest planes) and K_t the friction that follows the tooth forces, which is not
symmetric.

The vibration also turns the gears, which shifts the mesh cycle and changes F at constant delta. The time step contains
this effect without its counterpart, a torque dU/dc, which would make K_t asymmetric. It is neglected here: it changes
frequencies by at most 0.08 % (scene `minimal` and rig, `iso` laws, no casing), or 0.35 % at a missing tooth.

The energy of a mode is its mean over a period, strain phi^H K phi/4 and kinetic |lambda|^2 phi^H M phi/4, split by
part. Masses and strain of shafts and casing are theirs; meshes, bearings, couplings and ropes are springs alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from fem.storage.records import Record, array, integer, names
from mbd.elements.element import WIDTH
from mbd.elements.element_table import instant, slope_matrix
from mbd.elements.mode_words import ModeWords
from mbd.elements.newton import forces_at
from mbd.parts.machine import Machine
from mbd.parts.modal_basis import SMALLEST_FREQUENCY
from mbd.parts.part_checks import MachineError, positive
from mbd.system.statics import State, equilibrium, foot_forces
from mbd.system.system import System

DEFAULT_UP_TO = 10e3  # Hz
LEAST_LOAD = 1e-6  # of the load of the linear reference: below it a flank counts as just touching


@dataclass(frozen=True, eq=False, kw_only=True)
class Tangent:
    """Matrices of small motion, SI; n coordinates, m rows."""

    stiffness: np.ndarray  # K_t (n, n)
    damping: np.ndarray  # C_t (n, n)
    row_stiffness: np.ndarray  # (m, m) of the elements on their rows
    force_slope: np.ndarray  # S_u (m, m)
    force_slope_rate: np.ndarray  # S_v (m, m)
    mesh_forces: np.ndarray  # (mesh,) N, drive flank less coast flank
    mesh_stiffness: np.ndarray  # (mesh,) dF/d delta of both flanks, N/m


@dataclass(frozen=True, eq=False, kw_only=True)
class LinearModes(Record):
    """Oscillating modes in rising frequency; free motion has the frequency f sqrt(1 - zeta^2).

    Shares are parts of the strain plus kinetic energy of a mode and sum to 1 over both. Amplitudes and phases are
    those of every channel of the system while the mode holds 1 J.
    """

    frequencies: np.ndarray = array("mode", units="Hz")  # |lambda|/(2 pi)
    damping_ratios: np.ndarray = array("mode", units="1")  # -Re lambda/|lambda|
    dominant: tuple[str, ...] = names("mode")  # in plain words, e.g. "mesh 1", "rope bounce"
    part_names: tuple[str, ...] = names("part")
    part_kinds: tuple[str, ...] = names("part")  # "shaft" | "bearing" | "coupling" | "mesh" | "casing" | ...
    strain_shares: np.ndarray = array("mode", "part", units="1")
    kinetic_shares: np.ndarray = array("mode", "part", units="1")
    channel_names: tuple[str, ...] = names("channel")
    channel_units: tuple[str, ...] = names("channel")
    amplitudes: np.ndarray = array("channel", "mode", units="per channel")
    phases: np.ndarray = array("channel", "mode", units="rad")
    mesh_names: tuple[str, ...] = names("mesh")
    mesh_forces: np.ndarray = array("mesh", units="N")
    mesh_stiffness: np.ndarray = array("mesh", units="N/m")
    foot_names: tuple[str, ...] = names("foot")
    foot_forces: np.ndarray = array("foot", "axis", units="N")  # of the ground on the casing at rest
    overdamped: int = integer()  # motions of any frequency that do not oscillate

    def __repr__(self) -> str:
        span = f", {self.frequencies[0]:.5g} to {self.frequencies[-1]:.5g} Hz" if len(self.frequencies) else ""
        return f"<LinearModes: {len(self.frequencies)} modes{span}>"

    @property
    def shares(self) -> np.ndarray:
        """Share (mode, part) of the whole energy."""
        return self.strain_shares + self.kinetic_shares

    def share(self, name: str) -> np.ndarray:
        """Share (mode,) of the parts of that name or kind; KeyError with the known names if there is none."""
        chosen = [name in both for both in zip(self.part_names, self.part_kinds, strict=True)]
        if not any(chosen):
            raise KeyError(f"{name!r} is no part of these modes; known: {', '.join(self.part_names)}")
        return self.shares[:, chosen].sum(axis=1)


def turned(machine: Machine, angle: float) -> Machine:
    """The machine after its motors have rolled by ``angle`` (rad): mesh cycles and rope length move, nothing else.

    Raises
    ------
    MachineError : the drums have then wound more rope than there is
    """
    if not math.isfinite(angle):
        raise MachineError(f"motor angle: {angle!r} is not a finite number.")
    return machine.turned(angle)


def tangent(system: System, state: State) -> Tangent:
    """Matrices of small motion about a state of rest.

    Raises
    ------
    MachineError : a mesh carries no force, so that its stiffness is 0 on one side and not on the other
    """
    table, m = system.table, len(system.rows)
    now, u, force, still = instant(table), system.all_rows @ state.displacement, np.zeros(m), np.zeros(m)
    slope_u, slope_v = np.zeros((m, WIDTH)), np.zeros((m, WIDTH))
    clock = state.motor_angle, state.motor_speed, 0.0
    forces_at(table, clock, u, still, u[:0], slope_u[:0], force, slope_u, slope_v, now)
    forces, stiffness = [], []
    for name, sides in system.contacts.items():
        rows = [system.at(side.name).start for side in sides]
        carried = now.elastic[rows]
        if carried.max() <= LEAST_LOAD * table.scale[rows[0]]:
            raise MachineError(
                f"{name.replace('_', ' ')} carries no force at the equilibrium, and a flank that just touches has no "
                "tangent stiffness. Set a load in the scene, such as load.torque_N_m."
            )
        forces.append(carried[0] - carried[1:].sum())
        stiffness.append(now.stiffness[rows, 0].sum())
    by_u, by_v = (_without_matrices(system, slope_matrix(slope, table)) for slope in (slope_u, slope_v))
    damping = system.damping - system.rows.T @ by_v @ system.rows
    if system.gyroscopic.size:
        damping = damping + state.motor_speed * system.gyroscopic
    return Tangent(
        stiffness=system.stiffness - system.rows.T @ by_u @ system.rows,
        damping=damping,
        row_stiffness=np.diag(table.stiffness) - by_u,
        force_slope=by_u,
        force_slope_rate=by_v,
        mesh_forces=np.array(forces),
        mesh_stiffness=np.array(stiffness),
    )


def _without_matrices(system: System, slope: np.ndarray) -> np.ndarray:
    """The slopes (m, m) without those of elements that stand for a matrix, or turn on while the view stands still."""
    result = slope.copy()
    for element in system.elements:
        if element.in_matrix:
            result[system.at(element.name)] = 0.0
    return result


def linear_modes(
    system: System, state: State | None = None, up_to: float = DEFAULT_UP_TO, speed: float = 0.0
) -> LinearModes:
    """Modes of small motion about a state of rest.

    Parameters
    ----------
    system : the machine in its casing
    state : None for the loaded equilibrium at the motor speed
    up_to : Hz, highest frequency; keep it well below the band the system was assembled for
    speed : of the motors for the equilibrium, rad/s

    Raises
    ------
    EquilibriumError : there is no equilibrium
    MachineError : ``up_to`` is not positive, a mesh carries no force, or nothing holds some motion
    """
    positive("up_to (Hz)", up_to)
    state = equilibrium(system, speed) if state is None else state
    small = tangent(system, state)
    values, shapes, overdamped = _eigen(system, small)
    keep = abs(values) <= 2 * np.pi * up_to
    values, shapes = values[keep], shapes[:, keep]
    words, strain, kinetic = _energies(system, small, values, shapes)
    total = 0.25 * np.sum(shapes.conj() * (small.stiffness @ shapes), axis=0).real
    total += 0.25 * abs(values) ** 2 * np.sum(shapes.conj() * (system.mass @ shapes), axis=0).real
    readings = _readings(system, small, values, shapes / np.sqrt(total))
    return LinearModes(
        frequencies=abs(values) / (2 * np.pi),
        damping_ratios=-values.real / abs(values),
        dominant=_dominant(words, strain, kinetic),
        part_names=tuple(words),
        part_kinds=tuple(word.kind for word in words.values()),
        strain_shares=(strain / total).T,
        kinetic_shares=(kinetic / total).T,
        channel_names=system.channels.names,
        channel_units=system.channels.units,
        amplitudes=abs(readings),
        phases=np.angle(readings),
        mesh_names=tuple(system.contacts),
        mesh_forces=small.mesh_forces,
        mesh_stiffness=small.mesh_stiffness,
        foot_names=system.layout.casing.feet,
        foot_forces=foot_forces(system, state),
        overdamped=overdamped,
    )


def _eigen(system: System, small: Tangent) -> tuple[np.ndarray, np.ndarray, int]:
    """lambda (mode,) with Im > 0 by rising |lambda|, shapes (coordinate, mode), number of overdamped motions.

    In the undamped tangent modes the state (omega p, p') has the matrix [[0, omega], [-omega - N/omega, -C]], N the
    part of the stiffness that is not symmetric.
    """
    reduced = system.basis.T @ small.stiffness @ system.basis
    even = 0.5 * (reduced + reduced.T)
    squares, vectors = linalg.eigh(even)
    if squares[0] < (2 * np.pi * SMALLEST_FREQUENCY) ** 2:
        names_, shape = system.layout.names, system.basis @ vectors[:, 0]
        worst = names_[int(np.argmax(abs(shape) * np.sqrt(np.diag(system.mass))))]
        raise MachineError(
            f"linearised machine: a motion dominated by {worst} has no stiffness (omega^2 = {squares[0]:.3g}). "
            "Set a load that keeps every mesh in contact and every rope tight."
        )
    omega, modes = np.sqrt(squares), system.basis @ vectors
    n = len(omega)
    damping = modes.T @ small.damping @ modes
    follower = vectors.T @ (reduced - even) @ vectors / omega
    values, vectors = linalg.eig(np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega) - follower, -damping]]))
    keep = np.flatnonzero(values.imag > 0.0)
    keep = keep[np.argsort(abs(values[keep]))]
    amplitudes = vectors[:n, keep] / omega[:, None]
    real = np.exp(-0.5j * np.angle(np.sum(amplitudes**2, axis=0)))  # p^T M p real: the shape as real as it can be
    return values[keep], modes @ (amplitudes * real), int(np.sum(values.imag == 0.0)) // 2


def _energies(
    system: System, small: Tangent, values: np.ndarray, shapes: np.ndarray
) -> tuple[dict[str, ModeWords], np.ndarray, np.ndarray]:
    """Words of each part by name, and mean strain and kinetic energy (part, mode)."""
    words: dict[str, ModeWords] = {}
    m = len(system.rows)
    strain: dict[str, np.ndarray] = {}
    kinetic: dict[str, np.ndarray] = {}

    def add(name: str, word: ModeWords, stored: np.ndarray, moving: np.ndarray | float) -> None:
        words.setdefault(name, word)
        strain[name] = strain.get(name, 0.0) + 0.25 * stored
        kinetic[name] = kinetic.get(name, 0.0) + 0.25 * abs(values) ** 2 * moving

    for part in system.parts:
        own = shapes[part.index]
        add(part.modes_of or part.name, part.words, _form(part.stiffness, own), _form(part.mass, own))
    for name, word in {element.part: element.words for element in system.elements}.items():
        if word is not None:
            at = np.concatenate([np.arange(m)[system.at(e.name)] for e in system.elements if e.part == name])
            add(name, word, _form(small.row_stiffness[np.ix_(at, at)], system.rows[at] @ shapes), 0.0)
    return words, np.array(list(strain.values())), np.array(list(kinetic.values()))


def _form(matrix: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """phi^H A phi of every column."""
    return np.sum(shapes.conj() * (matrix @ shapes), axis=0).real


def _readings(system: System, small: Tangent, values: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Complex amplitude (channel, mode) of every channel."""
    channels, u = system.channels, system.rows @ shapes
    forces = small.force_slope @ u + small.force_slope_rate @ (u * values)
    found = channels.displacement @ shapes + channels.velocity @ (shapes * values)
    return found + channels.acceleration @ (shapes * values**2) + channels.forces @ forces


def _dominant(words: dict[str, ModeWords], strain: np.ndarray, kinetic: np.ndarray) -> tuple[str, ...]:
    """The part whose spring makes each mode, in its words.

    Kinds compete by their share of the strain energy: shafts move with whatever holds them. Those that own both spring
    and mass, as casing and rope, compete by the mean of their strain and kinetic shares. Within the kind that wins, the
    part with more than half of its strain energy gives the name.
    """
    strain, kinetic = strain / strain.sum(axis=0), kinetic / kinetic.sum(axis=0)
    kinds: dict[str, list[int]] = {}  # numbers of the parts of each kind
    for i, word in enumerate(words.values()):
        kinds.setdefault(word.kind, []).append(i)
    names_, every = list(words), list(words.values())
    scores = [
        0.5 * (strain + kinetic)[parts].sum(axis=0) if every[parts[0]].has_mass else strain[parts].sum(axis=0)
        for parts in kinds.values()
    ]
    found = []
    for mode, best in enumerate(np.argmax(scores, axis=0) if scores else ()):
        parts = list(kinds.values())[best]
        word, stored = every[parts[0]], dict[str, float]()
        for i in parts:
            group = every[i].group or names_[i]
            stored[group] = stored.get(group, 0.0) + float(strain[i, mode])
        top = max(stored, key=lambda group: stored[group])
        if word.moving and kinetic[parts, mode].sum() > 0.5:
            found.append(word.moving)
        elif word.always or stored[top] <= 0.5 * math.fsum(stored.values()):
            found.append(word.plural)
        else:
            found.append(top.replace("_", " "))
    return tuple(found)
