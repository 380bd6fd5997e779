"""System: the assembled machine as M q'' + C q' + K q = f + B^T lambda, with its linear reference and its rows.

q is measured in the frame that rolls with the train (see `mbd.coordinates.layout`): total motion = R phi_m(t) + q.
Rolling loads no spring, so K R = 0 but for the couplings, whose motors roll too; what is left of it is the inertia
force -M R phi_m''. f is the constant load (gravity, static torque). The matrices hold a linear reference of every mesh
(mean stiffness at the nominal load) and of every other nonlinear element; lambda is the difference to the real forces
(see `mbd.forces.element`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.casing.reduced.body import ReducedBody
from mbd.coordinates.channels import ChannelRows, bearing_row, channel_names, channel_rows
from mbd.coordinates.layout import Layout, layout
from mbd.forces.assembly import Assembly
from mbd.forces.element import Element
from mbd.forces.registry import SOURCES_OF_FORCE
from mbd.forces.table import Table, element_table
from mbd.parts.bearings import BEARING_AXES, springs
from mbd.parts.gyroscopic import planes, rolling_matrix
from mbd.parts.machine import Machine
from mbd.parts.shafts import shaft_matrices

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
    elements: tuple[Element, ...]  # everything nonlinear, in the order of its rows
    rows: np.ndarray  # B (m, n) of all elements
    row_names: tuple[str, ...]
    rolls: np.ndarray  # (m,) motion of the row per motor angle of the elements whose forces work on it
    observed: np.ndarray  # (k, n) rows that elements observe only, after the force rows
    table: Table  # the elements for compiled code
    gyroscopic: np.ndarray  # G (n, n) per motor speed; empty if left out
    gyroscopic_left_out: float  # share of its norm that the time step leaves out
    channels: ChannelRows
    basis: np.ndarray  # Phi (n, r): q = Phi p, mass-orthonormal
    frequencies: np.ndarray  # omega (r,), rad/s

    @property
    def machine(self) -> Machine:
        """The machine it was assembled from."""
        return self.layout.machine

    def at(self, name: str) -> slice:
        """Rows of the element called ``name``."""
        i = [element.name for element in self.elements].index(name)
        return slice(int(self.table.row[i]), int(self.table.row[i + 1]))

    def element(self, name: str) -> Element:
        """The element called ``name``."""
        return next(element for element in self.elements if element.name == name)

    def observed_by(self, name: str, motion: np.ndarray) -> np.ndarray:
        """What the element called ``name`` observes, from displacements (row + observed,) of `all_rows`."""
        i = [element.name for element in self.elements].index(name)
        first, end = self.table.seen[i] + len(self.rows)
        return motion[first:end]

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
    channels : names from `mbd.coordinates.channels`; None asks for all but sensors
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
    assembly = Assembly(lay, mass, damping, stiffness, _constant_force(lay), band)
    for elements in SOURCES_OF_FORCE.values():
        assembly.add(elements(assembly))
    rows, (basis, frequencies) = assembly.rows, assembly.modes
    table, observed = element_table(assembly.elements, lay.size)
    gyroscopic, left_out = np.zeros((0, 0)), 0.0
    if machine.gyroscopic:
        gyroscopic = rolling_matrix(lay)
        left_out = planes(basis.T @ gyroscopic @ basis)[3]
    names = channel_names(machine) if channels is None else tuple(channels)
    return System(
        layout=lay,
        parts=parts,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        rolling=assembly.rolling,
        constant_force=assembly.constant_force,
        elements=tuple(assembly.elements),
        rows=rows,
        row_names=tuple(f"{element.name}:{word}" for element in assembly.elements for word in element.row_names),
        rolls=_rolls(assembly),
        observed=observed,
        table=table,
        gyroscopic=gyroscopic,
        gyroscopic_left_out=left_out,
        channels=channel_rows(names, lay, assembly.elements),
        basis=basis,
        frequencies=frequencies,
    )


def _rolls(assembly: Assembly) -> np.ndarray:
    rolling = assembly.rows @ assembly.rolling
    rolling[abs(rolling) < 1e-12 * abs(rolling).max(initial=0.0)] = 0.0
    counts = [len(element.rows) for element in assembly.elements]
    return np.where(np.repeat([element.rolls for element in assembly.elements], counts), rolling, 0.0)


def natural_frequencies(system: System) -> np.ndarray:
    """Undamped frequencies (Hz) of the linear reference within the band, ascending."""
    return system.frequencies / (2 * np.pi)


def mesh_mode_frequency(system: System, share: float = 0.1) -> float:
    """Highest frequency (Hz) of a mode that stores at least ``share`` of its strain energy in one mesh; 0 if none."""
    top = 0.0
    for element in system.elements:
        if element.spring != "mesh" or not element.stiffness[0]:
            continue
        stored = element.stiffness[0] * (element.rows[0] @ system.basis) ** 2 / system.frequencies**2
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
        if bearing.inside is not None:
            continue  # a nonlinear element
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
    load = lay.machine.load
    n = len(load.coordinates)
    if n == 0:
        return []
    zero = np.zeros((n, n))
    return [_massive(lay, "load", "load", np.arange(lay.size - n, lay.size), load.mass * np.eye(n), zero, zero)]


def _constant_force(lay: Layout) -> np.ndarray:
    machine = lay.machine
    force = np.zeros(lay.size)
    for shaft in machine.shafts:
        nodes, base = lay.nodes[shaft.name], lay.bases[shaft.name]
        lift = np.tile(np.eye(6)[2], len(nodes))
        force[lay.spans[shaft.name]] -= machine.gravity * base.T @ (shaft_matrices(shaft, nodes)[0] @ lift)
    return force + machine.load.constant_force(lay)
