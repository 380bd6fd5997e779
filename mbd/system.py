"""System: the assembled machine as M q'' + C q' + K q = f + B^T lambda, with its linear reference and its rows.

q is measured in the frame that rolls with the train (see `mbd.layout`): total motion = R phi_m(t) + q. Rolling loads
no spring, so K R = 0 but for the couplings, whose motors roll too; what is left of it is the inertia force
-M R phi_m''. f is the constant load (gravity, static torque). The matrices hold a linear reference of every mesh
(mean stiffness at the nominal load) and rope; lambda is the difference to the real forces (see `mbd.forces`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fem.casing.body import ReducedBody
from mbd.bearings import BEARING_AXES, springs
from mbd.channels import ChannelRows, bearing_row, channel_names, channel_rows
from mbd.checks import MachineError
from mbd.element_rows import ElementRows, bearing_drag, element_rows, gyroscopic_planes
from mbd.forces import ForceTable, force_table
from mbd.gear_mesh import mesh_rows
from mbd.gyroscopic import gyroscopic_matrix, planes
from mbd.layout import Layout, layout
from mbd.load import Rope, StaticTorque, pull_axis, rope_reference, vertical_rope
from mbd.losses import Coulomb
from mbd.machine import Machine
from mbd.mesh_reference import mean_stiffness, nominal_forces, reference_load
from mbd.reduction import modal_basis
from mbd.shafts import shaft_matrices, torsional_stiffness

DEFAULT_BAND = 20e3  # Hz


@dataclass(frozen=True, eq=False)
class Part:
    """Matrices of one linear part on the coordinates ``index``; parts sum to the system without its references.

    Massless parts are springs and dampers on ``rows`` (row, n): force row_stiffness u + row_damping u'.
    """

    name: str
    kind: str  # "shaft" | "bearing" | "coupling" | "casing" | "drive" | "load"
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
    rows: np.ndarray  # B (m, n): flanks, ropes, further elements
    row_names: tuple[str, ...]
    element_names: tuple[str, ...]  # parts that the further elements belong to, in their order
    gyroscopic: np.ndarray  # G (n, n) per motor speed; empty if left out
    gyroscopic_left_out: float  # share of its norm that the time step leaves out
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
    parts = (
        *_shaft_parts(lay),
        *_bearing_parts(lay),
        *_coupling_parts(lay),
        *_casing_part(lay),
        *_drive_part(lay),
        *_load_part(lay),
    )
    mass, damping, stiffness = (np.zeros((lay.size, lay.size)) for _ in range(3))
    for part in parts:
        at = np.ix_(part.index, part.index)
        mass[at] += part.mass
        damping[at] += part.damping
        stiffness[at] += part.stiffness
    rows, row_names, observed = _force_rows(lay)
    base = len(rows)
    loads = {m.name: reference_load(m, nominal_forces(machine)[m.name]) for m in machine.meshes}
    mesh_stiffness = {m.name: mean_stiffness(m.drive, loads[m.name]) for m in machine.meshes}
    reference = {name: (k0, machine.mesh(name).damping_time * k0) for name, (k0, _) in mesh_stiffness.items()}
    if isinstance(machine.load, Rope):
        reference["rope"] = rope_reference(machine.load)
    elements, constant, rolling = element_rows(lay, base, loads), _constant_force(lay), lay.rolling()
    for row, k0, c0 in _reference_springs(lay, rows, mesh_stiffness, reference, elements):
        stiffness += k0 * np.outer(row, row)
        damping += c0 * np.outer(row, row)
    if isinstance(machine.losses, Coulomb):
        bearing_drag(elements, lay, _bearing_loads(lay, stiffness, constant))
    rows = np.vstack([rows, elements.matrix()])
    patterns = np.column_stack([rows.T, constant, mass @ rolling, stiffness @ rolling])
    try:
        basis, frequencies = modal_basis(mass, stiffness, patterns, band, lay.names)
    except MachineError as error:  # what moves freely need not be what is too soft
        softest = min(machine.shafts, key=torsional_stiffness)
        raise MachineError(
            f"{error} The softest shaft in torsion is {softest.name} with {torsional_stiffness(softest):.3g} N m/rad."
        ) from error
    gyroscopic, left_out = np.zeros((0, 0)), 0.0
    if machine.gyroscopic:
        gyroscopic = _gyroscopic(lay)
        one, other, strengths, left_out = planes(basis.T @ gyroscopic @ basis)
        back = basis.T @ mass
        gyroscopic_planes(elements, one @ back, other @ back, strengths, machine.profile.highest or 1.0)
        rows = np.vstack([rows[:base], elements.matrix()])
    table = force_table(machine, loads, mesh_stiffness, elements.extra(rolling))
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
        row_names=(*row_names, *elements.row_names),
        element_names=tuple(elements.names),
        gyroscopic=gyroscopic,
        gyroscopic_left_out=left_out,
        observed=observed,
        table=table,
        reference=reference,
        channels=channel_rows(names, lay, rows, (*row_names, *elements.row_names), reference),
        basis=basis,
        frequencies=frequencies,
    )


def _reference_springs(
    lay: Layout,
    rows: np.ndarray,
    meshes: dict[str, tuple[float, float]],
    reference: dict[str, tuple[float, float]],
    elements: ElementRows,
) -> Iterator[tuple[np.ndarray, float, float]]:
    """Row, stiffness and damping of every spring of the linear reference."""
    for i, mesh in enumerate(lay.machine.meshes):
        yield rows[4 * i], *reference[mesh.name]
        yield rows[4 * i + 1], meshes[mesh.name][1], 0.0
    for row in rows[4 * len(lay.machine.meshes) :]:
        yield row, *reference["rope"]
    yield from zip(elements.rows, elements.stiffness, elements.damping, strict=True)


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
        if bearing.model == "hertz":
            continue  # a nonlinear element, see `mbd.elements`
        axes = np.array([bearing_row(lay, bearing, axis) for axis in BEARING_AXES])
        if bearing.damping is None:
            turn, k = springs(bearing.stiffness_matrix)
            c = bearing.damping_time * k
        else:  # springs and dampers have axes of their own
            (turn, k), (dampers, c) = springs(bearing.stiffness_matrix), springs(bearing.damping_matrix)
            turn, k, c = (
                np.vstack([turn, dampers]),
                np.concatenate([k, np.zeros(len(c))]),
                np.concatenate([np.zeros(len(k)), c]),
            )
        parts.append(_row_part(bearing.name, "bearing", turn @ axes, k, c))
    return parts


def _coupling_parts(lay: Layout) -> list[Part]:
    parts = []
    for joint in lay.machine.shaft_couplings:
        (one, other), (y_one, y_other) = joint.shafts, joint.y
        held = [(axis, k) for axis, k in enumerate(joint.stiffness) if k > 0]
        rows = np.array([lay.axis_row(one, y_one, axis) - lay.axis_row(other, y_other, axis) for axis, _ in held])
        k = np.array([k for _, k in held])
        parts.append(_row_part(joint.name, "coupling", rows, k, joint.damping_time * k))
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
    index = np.array([i for i, name in enumerate(lay.names) if name.startswith("container:")])
    zero = np.zeros((len(index), len(index)))
    mass = lay.machine.load.container_mass * np.eye(len(index))
    return [_massive(lay, "load", "load", index, mass, zero, zero)]


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
    if vertical_rope(machine.load):
        rows += [lay.stretch_row(y) for y in machine.load.drums]
        names += [f"rope:{i}:stretch" for i in range(len(machine.load.drums))]
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
            if load.direction is not None:
                pull = np.array([*pull_axis(load.direction), 0.0, 0.0, 0.0]) * load.torque / load.drum_radius
                force += lay.node_row(load.shaft, y, pull)
    else:
        force[-1] -= machine.gravity * load.container_mass
    return force


def _bearing_loads(lay: Layout, stiffness: np.ndarray, force: np.ndarray) -> dict[str, float]:
    """Force (N) in every bearing by name under the constant force ``force``, by the linear reference."""
    q = np.linalg.solve(stiffness, force)
    found = {}
    for bearing in lay.machine.bearings:
        motion = np.array([bearing_row(lay, bearing, axis) @ q for axis in BEARING_AXES])
        found[bearing.name] = float(np.linalg.norm((bearing.stiffness_matrix @ motion)[:3]))
    return found


def _gyroscopic(lay: Layout) -> np.ndarray:
    """G (n, n) of all shafts per speed of the motor."""
    ratios = lay.machine.ratios()
    matrix = np.zeros((lay.size, lay.size))
    for shaft in lay.machine.shafts:
        nodes, base, span = lay.nodes[shaft.name], lay.bases[shaft.name], lay.spans[shaft.name]
        matrix[span, span] = shaft.sense * ratios[shaft.name] * base.T @ gyroscopic_matrix(shaft, nodes) @ base
    return matrix
