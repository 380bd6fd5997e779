"""Linearised view: small free motion M q'' + C_t q' + K_t q = 0 about the loaded equilibrium, the motors standing.

With the slopes S_u = d lambda/du, S_v = d lambda/du' of the residual forces on the rows B at the equilibrium

    K_t = K - B^T S_u B,   C_t = C - B^T S_v B:

the tangent stiffness of every flank at its force, the ropes at their length, damping as in the time step. Bearings,
shafts, couplings and casing are linear already. Eigenvalues lambda come in the modal basis of the system, which the
time step uses as well. At a motor speed the state is the rest in the rolling frame at mesh cycle, cage angle and rope
length of t = 0: C_t then holds the gyroscopic moments Omega G (all of them, where the time step keeps the strongest
planes) and K_t the friction that follows the tooth forces, which is not symmetric.

The vibration also turns the gears and so shifts the mesh cycle, which changes F at frozen delta. The time step has this
without its counterpart, a torque dU/dc, so that K_t would be asymmetric. It is left out: in the scene `minimal` and the
rig (`iso` laws, no casing) it moves frequencies by at most 0.08 %; by 0.35 %, a motor mode, at a missing tooth.

The energy of a mode is its mean over a period, strain phi^H K phi/4 and kinetic |lambda|^2 phi^H M phi/4, split by
part. Masses and strain of shafts and casing are theirs; meshes, bearings, couplings and ropes are springs alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from fem.storage.records import Record, array, integer, names
from mbd.coordinates.modal_basis import SMALLEST_FREQUENCY
from mbd.forces.element import WIDTH
from mbd.forces.flank import flank_name
from mbd.forces.gyroscopic_plane import KIND as GYROSCOPIC
from mbd.forces.newton import forces_at
from mbd.forces.table import instant, slope_matrix
from mbd.parts.checks import MachineError, finite, positive
from mbd.parts.machine import Machine
from mbd.system.statics import State, equilibrium
from mbd.system.system import System

DEFAULT_UP_TO = 10e3  # Hz
LEAST_LOAD = 1e-6  # of the load of the linear reference: below it a flank counts as just touching
ROPE = "rope"  # the part that is made of the ropes and the container


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
    overdamped: int = integer()  # motions of any frequency that do not oscillate

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
    finite("motor angle", angle)
    ratios, load = machine.ratios(), machine.load
    meshes = tuple(
        replace(m, cycle_at_start=m.cycle_at_start + m.cycles_per_radian * ratios[m.driving] * angle)
        for m in machine.meshes
    )
    return replace(machine, meshes=meshes, load=load.turned(angle, ratios[load.shaft]))


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
    approaches = np.array(
        [[system.at(flank_name(mesh.name, side)).start for side in (0, 1)] for mesh in system.machine.meshes], dtype=int
    ).reshape(-1, 2)
    forces = now.elastic[approaches]
    for mesh, both, (drive, _) in zip(system.machine.meshes, forces, approaches, strict=True):
        if both.max() <= LEAST_LOAD * table.scale[drive]:
            raise MachineError(
                f"mesh {mesh.name}: carries no force at the equilibrium; a flank that just touches has no tangent "
                "stiffness. Give the machine a load."
            )
    by_u, by_v = slope_matrix(slope_u, table), slope_matrix(slope_v, table)
    damping = system.damping - system.rows.T @ _without_planes(system, by_v) @ system.rows
    if system.machine.gyroscopic:
        damping = damping + state.motor_speed * system.gyroscopic
    return Tangent(
        stiffness=system.stiffness - system.rows.T @ by_u @ system.rows,
        damping=damping,
        row_stiffness=np.diag(table.stiffness) - by_u,
        force_slope=by_u,
        force_slope_rate=by_v,
        mesh_forces=forces[:, 0] - forces[:, 1],
        mesh_stiffness=now.stiffness[approaches, 0].sum(axis=1),
    )


def _without_planes(system: System, slope: np.ndarray) -> np.ndarray:
    """The slopes (m, m) without those of the gyroscopic planes."""
    result = slope.copy()
    for element in system.elements:
        if element.kind == GYROSCOPIC:
            result[system.at(element.name)] = 0.0
    return result


def linear_modes(
    system: System, state: State | None = None, up_to: float = DEFAULT_UP_TO, speed: float = 0.0
) -> LinearModes:
    """Modes of small motion about ``state`` (if None the loaded equilibrium at the motor ``speed``, rad/s) up to a
    frequency (Hz).

    Keep ``up_to`` well below the band the system was assembled for.

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
    kinds, strain, kinetic = _energies(system, small, values, shapes)
    total = 0.25 * np.sum(shapes.conj() * (small.stiffness @ shapes), axis=0).real
    total += 0.25 * abs(values) ** 2 * np.sum(shapes.conj() * (system.mass @ shapes), axis=0).real
    readings = _readings(system, small, values, shapes / np.sqrt(total))
    return LinearModes(
        frequencies=abs(values) / (2 * np.pi),
        damping_ratios=-values.real / abs(values),
        dominant=_dominant(system.machine, kinds, strain, kinetic),
        part_names=tuple(kinds),
        part_kinds=tuple(kinds.values()),
        strain_shares=(strain / total).T,
        kinetic_shares=(kinetic / total).T,
        channel_names=system.channels.names,
        channel_units=system.channels.units,
        amplitudes=abs(readings),
        phases=np.angle(readings),
        mesh_names=tuple(m.name for m in system.machine.meshes),
        mesh_forces=small.mesh_forces,
        mesh_stiffness=small.mesh_stiffness,
        overdamped=overdamped,
    )


def _eigen(system: System, small: Tangent) -> tuple[np.ndarray, np.ndarray, int]:
    """lambda (mode,) with Im > 0 by rising |lambda|, shapes (coordinate, mode), number of overdamped motions.

    In the undamped tangent modes the state (omega p, p') has the matrix [[0, omega], [-omega - N/omega, -C]], N the
    part of the stiffness that is not symmetric.
    """
    reduced = system.basis.T @ small.stiffness @ system.basis
    even = 0.5 * (reduced + reduced.T)
    squares, turn = linalg.eigh(even)
    if squares[0] < (2 * np.pi * SMALLEST_FREQUENCY) ** 2:
        names_, shape = system.layout.names, system.basis @ turn[:, 0]
        worst = names_[int(np.argmax(abs(shape) * np.sqrt(np.diag(system.mass))))]
        raise MachineError(
            f"linearised machine: a motion dominated by {worst} has no stiffness (omega^2 = {squares[0]:.3g}). "
            "Load the machine so that every mesh and rope is tight."
        )
    omega, modes = np.sqrt(squares), system.basis @ turn
    n = len(omega)
    damping = modes.T @ small.damping @ modes
    follower = turn.T @ (reduced - even) @ turn / omega
    values, vectors = linalg.eig(np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega) - follower, -damping]]))
    keep = np.flatnonzero(values.imag > 0.0)
    keep = keep[np.argsort(abs(values[keep]))]
    amplitudes = vectors[:n, keep] / omega[:, None]
    real = np.exp(-0.5j * np.angle(np.sum(amplitudes**2, axis=0)))  # p^T M p real: the shape as real as it can be
    return values[keep], modes @ (amplitudes * real), int(np.sum(values.imag == 0.0)) // 2


def _energies(
    system: System, small: Tangent, values: np.ndarray, shapes: np.ndarray
) -> tuple[dict[str, str], np.ndarray, np.ndarray]:
    """Kind of each part by name, and mean strain and kinetic energy (part, mode)."""
    kinds: dict[str, str] = {}
    m = len(system.rows)
    strain: dict[str, np.ndarray] = {}
    kinetic: dict[str, np.ndarray] = {}

    def add(name: str, kind: str, stored: np.ndarray, moving: np.ndarray | float) -> None:
        kinds.setdefault(name, kind)
        strain[name] = strain.get(name, 0.0) + 0.25 * stored
        kinetic[name] = kinetic.get(name, 0.0) + 0.25 * abs(values) ** 2 * moving

    for part in system.parts:
        name, kind = (ROPE, ROPE) if part.kind == "load" else (part.name, part.kind)
        add(name, kind, _form(part.stiffness, shapes[part.index]), _form(part.mass, shapes[part.index]))
    springs = {element.part: element.spring for element in system.elements if element.spring}
    for name, spring in springs.items():
        at = np.concatenate([np.arange(m)[system.at(e.name)] for e in system.elements if e.part == name])
        add(name, spring, _form(small.row_stiffness[np.ix_(at, at)], system.rows[at] @ shapes), 0.0)
    return kinds, np.array(list(strain.values())), np.array(list(kinetic.values()))


def _form(matrix: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """phi^H A phi of every column."""
    return np.sum(shapes.conj() * (matrix @ shapes), axis=0).real


def _readings(system: System, small: Tangent, values: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Complex amplitude (channel, mode) of every channel."""
    channels, u = system.channels, system.rows @ shapes
    forces = small.force_slope @ u + small.force_slope_rate @ (u * values)
    found = channels.displacement @ shapes + channels.velocity @ (shapes * values)
    return found + channels.acceleration @ (shapes * values**2) + channels.forces @ forces


def _dominant(machine: Machine, kinds: dict[str, str], strain: np.ndarray, kinetic: np.ndarray) -> tuple[str, ...]:
    """The part whose spring makes each mode, in words.

    Kinds compete by their share of the strain energy: shafts move with whatever holds them. Casing and rope, which own
    both spring and mass, compete by the mean of their strain and kinetic shares. Within the kind that wins, the part
    with more than half of its strain energy gives the name.
    """
    strain, kinetic = strain / strain.sum(axis=0), kinetic / kinetic.sum(axis=0)
    kind_of = np.array(list(kinds.values()))
    order = list(dict.fromkeys(kinds.values()))
    scores = np.array([strain[kind_of == kind].sum(axis=0) for kind in order])
    for kind in ("casing", ROPE):
        if kind in order:
            scores[order.index(kind)] = 0.5 * (strain + kinetic)[kind_of == kind].sum(axis=0)
    holds = {bearing.name: bearing.shaft for bearing in machine.bearings}
    found = []
    for mode, kind in enumerate(np.array(order)[scores.argmax(axis=0)] if scores.size else ()):
        if kind == ROPE:
            bounce = kinetic[list(kinds).index(ROPE), mode] > 0.5
            found.append("rope bounce" if bounce else "rope")
            continue
        stored: dict[str, float] = {}
        for name, value in zip(kinds, strain[:, mode], strict=True):
            if kinds[name] == kind:
                word = f"bearings of {holds[name]}" if name in holds else name
                stored[word] = stored.get(word, 0.0) + float(value)
        top = max(stored, key=lambda word: stored[word])
        single = stored[top] > 0.5 * math.fsum(stored.values())
        found.append(_WORDS.get(kind) or (top.replace("_", " ") if single else _PLURAL[kind]))
    return tuple(found)


_WORDS = {"casing": "casing", "drive": "motor coupling", "ground": "ground"}
_PLURAL = {"coupling": "couplings", "shaft": "shafts", "bearing": "bearings", "mesh": "meshes"}
