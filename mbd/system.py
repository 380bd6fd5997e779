"""System: the assembled machine as M q'' + C q' + K q = f + B^T lambda, with its linear reference and its rows.

q is measured in the frame that rolls with the train (see `mbd.layout`): total motion = R phi_m(t) + q. Rolling loads
no spring, so K R = 0 but for the couplings, whose motors roll too; what is left of it is the inertia force
-M R phi_m''. f is the constant load (gravity, static torque). The matrices hold a linear reference of every mesh
(mean stiffness at the nominal load) and rope; lambda is the difference to the real forces (see `mbd.forces`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.casing.body import ReducedBody
from mbd.bearings import BEARING_AXES
from mbd.channels import ChannelRows, bearing_row, channel_names, channel_rows
from mbd.forces import ForceTable, force_table
from mbd.gear_mesh import mesh_rows
from mbd.layout import Layout, layout
from mbd.load import Rope, StaticTorque
from mbd.machine import Machine
from mbd.mesh_reference import mean_stiffness, nominal_forces, reference_load
from mbd.reduction import modal_basis
from mbd.shafts import shaft_matrices

DEFAULT_BAND = 20e3  # Hz


@dataclass(frozen=True, eq=False)
class Part:
    """Matrices of one linear part on the coordinates ``index``; parts sum to the system without its references.

    Massless parts are springs and dampers on ``rows`` (row, n): force row_stiffness u + row_damping u'.
    """

    name: str
    kind: str  # "shaft" | "bearing" | "casing" | "drive" | "load"
    index: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    rows: np.ndarray
    row_stiffness: np.ndarray
    row_damping: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class System:
    """What the integrators advance. Shapes: n coordinates, m forces, r modes; SI."""

    layout: Layout
    parts: tuple[Part, ...]
    mass: np.ndarray  # (n, n)
    damping: np.ndarray  # (n, n), with the references
    stiffness: np.ndarray  # (n, n), with the references
    rolling: np.ndarray  # R (n,)
    constant_force: np.ndarray  # f (n,)
    rows: np.ndarray  # B (m, n)
    row_names: tuple[str, ...]
    observed: np.ndarray  # (mesh, n) rotation of each driving gear, after the force rows
    table: ForceTable
    reference: dict[str, tuple[float, float]]  # (k0, c0) of each mesh and of the rope of one drum
    channels: ChannelRows
    basis: np.ndarray  # Phi (n, r): q = Phi p, mass-orthonormal
    frequencies: np.ndarray  # omega (r,), rad/s

    @property
    def machine(self) -> Machine:
        """The machine it was assembled from."""
        return self.layout.machine

    @property
    def all_rows(self) -> np.ndarray:
        """Force rows, then observed rows."""
        return np.vstack([self.rows, self.observed])


def assemble(
    machine: Machine, casing: ReducedBody, channels: tuple[str, ...] | None = None, band: float = DEFAULT_BAND
) -> System:
    """Put the machine into its casing.

    Parameters
    ----------
    machine, casing : the parts
    channels : names from `mbd.channels`; None asks for all but sensors
    band : Hz, modes above it are kept only by their static response; inf keeps all

    Raises
    ------
    MachineError : contradictory parts, unknown channels, a motion without stiffness, an indefinite mass
    """
    lay = layout(machine, casing)
    parts = (*_shaft_parts(lay), *_bearing_parts(lay), *_casing_part(lay), *_drive_part(lay), *_load_part(lay))
    mass, damping, stiffness = (np.zeros((lay.size, lay.size)) for _ in range(3))
    for part in parts:
        at = np.ix_(part.index, part.index)
        mass[at] += part.mass
        damping[at] += part.damping
        stiffness[at] += part.stiffness
    rows, row_names, observed = _force_rows(lay)
    loads = {m.name: reference_load(m, nominal_forces(machine)[m.name]) for m in machine.meshes}
    mesh_stiffness = {m.name: mean_stiffness(m.drive, loads[m.name]) for m in machine.meshes}
    table = force_table(machine, loads, mesh_stiffness)
    reference: dict[str, tuple[float, float]] = {}
    for i, mesh in enumerate(machine.meshes):
        k0, tilt = mesh_stiffness[mesh.name]
        reference[mesh.name] = (k0, mesh.damping_time * k0)
        delta, psi = rows[4 * i], rows[4 * i + 1]
        stiffness += k0 * np.outer(delta, delta) + tilt * np.outer(psi, psi)
        damping += mesh.damping_time * k0 * np.outer(delta, delta)
    for j, (k0, c0) in enumerate(zip(table.rope_stiffness, table.rope_damping, strict=True)):
        row = rows[4 * len(machine.meshes) + j]
        reference["rope"] = (float(k0), float(c0))
        stiffness += k0 * np.outer(row, row)
        damping += c0 * np.outer(row, row)
    rolling, constant = lay.rolling(), _constant_force(lay)
    basis, frequencies = modal_basis(
        mass, stiffness, np.column_stack([rows.T, constant, mass @ rolling, stiffness @ rolling]), band, lay.names
    )
    names = channel_names(machine) if channels is None else tuple(channels)
    return System(
        layout=lay,
        parts=parts,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        rolling=rolling,
        constant_force=constant,
        rows=rows,
        row_names=row_names,
        observed=observed,
        table=table,
        reference=reference,
        channels=channel_rows(names, lay, rows, reference),
        basis=basis,
        frequencies=frequencies,
    )


def natural_frequencies(system: System) -> np.ndarray:
    """Undamped frequencies (Hz) of the linear reference within the band, ascending."""
    return system.frequencies / (2 * np.pi)


def mesh_mode_frequency(system: System, share: float = 0.1) -> float:
    """Highest frequency (Hz) of a mode that stores at least ``share`` of its strain energy in one mesh; 0 if none."""
    top = 0.0
    for i, mesh in enumerate(system.machine.meshes):
        stored = system.reference[mesh.name][0] * (system.rows[4 * i] @ system.basis) ** 2 / system.frequencies**2
        if (stored > share).any():
            top = max(top, float(system.frequencies[stored > share].max()))
    return top / (2 * np.pi)


def _shaft_parts(lay: Layout) -> list[Part]:
    parts = []
    for shaft in lay.machine.shafts:
        m, k = shaft_matrices(shaft, lay.nodes[shaft.name])
        base = lay.bases[shaft.name]
        m, k = base.T @ m @ base, base.T @ k @ base
        if shaft.model == "torsion":  # the rigid motions store nothing: remove the round-off
            k[:5], k[:, :5] = 0.0, 0.0
        index = np.arange(lay.size)[lay.spans[shaft.name]]
        parts.append(_massive(lay, shaft.name, "shaft", index, m, shaft.damping_time * k, k))
    return parts


def _row_part(name: str, kind: str, rows: np.ndarray, stiffness: np.ndarray, damping: np.ndarray) -> Part:
    index = np.flatnonzero(np.any(rows != 0.0, axis=0))
    r = rows[:, index]
    zero = np.zeros((len(index), len(index)))
    c, k = r.T @ (damping[:, None] * r), r.T @ (stiffness[:, None] * r)
    return Part(name, kind, index, zero, c, k, rows, stiffness, damping)


def _massive(
    lay: Layout, name: str, kind: str, index: np.ndarray, mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray
) -> Part:
    return Part(name, kind, index, mass, damping, stiffness, np.zeros((0, lay.size)), np.zeros(0), np.zeros(0))


def _bearing_parts(lay: Layout) -> list[Part]:
    parts = []
    for bearing in lay.machine.bearings:
        held = [(axis, k) for axis, k in zip(BEARING_AXES, bearing.stiffness, strict=True) if k > 0]
        rows = np.array([bearing_row(lay, bearing, axis) for axis, _ in held])
        k = np.array([k for _, k in held])
        parts.append(_row_part(bearing.name, "bearing", rows, k, bearing.damping_time * k))
    return parts


def _casing_part(lay: Layout) -> list[Part]:
    casing = lay.casing
    if not len(casing.coordinate_names):
        return []
    index = np.arange(lay.size)[lay.spans["casing"]]
    return [_massive(lay, "casing", "casing", index, casing.mass, casing.damping, casing.stiffness)]


def _drive_part(lay: Layout) -> list[Part]:
    couplings = lay.machine.couplings
    rows = np.array([lay.angle_row(c.shaft, c.y) for c in couplings])
    k, c = np.array([c.stiffness for c in couplings]), np.array([c.damping for c in couplings])
    return [_row_part("drive", "drive", rows, k, c)]


def _load_part(lay: Layout) -> list[Part]:
    if not isinstance(lay.machine.load, Rope):
        return []
    zero = np.zeros((1, 1))
    mass = np.array([[lay.machine.load.container_mass]])
    return [_massive(lay, "load", "load", np.array([lay.size - 1]), mass, zero, zero)]


def _force_rows(lay: Layout) -> tuple[np.ndarray, tuple[str, ...], np.ndarray]:
    machine = lay.machine
    rows, names, observed = [], [], []
    for mesh in machine.meshes:
        pair = mesh_rows(mesh, machine.shaft(mesh.driving), machine.shaft(mesh.driven))
        for row in pair:
            first, second = lay.node_row(mesh.driving, mesh.y, row[:6]), lay.node_row(mesh.driven, mesh.y, row[6:])
            rows.append(first + second)
        names += [f"{mesh.name}:{flank}:{what}" for flank in ("drive", "coast") for what in ("delta", "psi")]
        observed.append(lay.angle_row(mesh.driving, mesh.y))
    load = machine.load
    if isinstance(load, Rope):
        for i, y in enumerate(load.drums):
            row = load.travel_per_radian * lay.angle_row(load.shaft, y)
            row[-1] -= 1.0
            rows.append(row)
            names.append(f"rope:{i}:stretch")
    shape = (-1, lay.size)
    return np.array(rows).reshape(shape), tuple(names), np.array(observed).reshape(shape)


def _constant_force(lay: Layout) -> np.ndarray:
    machine = lay.machine
    force = np.zeros(lay.size)
    for shaft in machine.shafts:
        nodes, base = lay.nodes[shaft.name], lay.bases[shaft.name]
        lift = np.tile(np.eye(6)[2], len(nodes))
        force[lay.spans[shaft.name]] -= machine.gravity * base.T @ (shaft_matrices(shaft, nodes)[0] @ lift)
    load = machine.load
    if isinstance(load, StaticTorque):
        for y in load.drums:
            force -= load.torque * lay.angle_row(load.shaft, y)
    else:
        force[-1] -= machine.gravity * load.container_mass
    return force
