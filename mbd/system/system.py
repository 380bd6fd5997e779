"""System: the assembled machine as M q'' + C q' + K q = f + B^T lambda, with its linear reference and its rows.

q is measured in the frame that rolls with the train (see `mbd.parts.coordinate_layout`): total motion = R phi_m(t) + q.
Rolling strains no spring, so K R = 0 except for the couplings, whose motors also roll; only the inertia
force -M R phi_m'' remains. f is the constant load (gravity, static torque). The matrices contain a linear reference of
every mesh (mean stiffness at the nominal load) and of every other nonlinear element; lambda is the difference to the
real forces (see `mbd.elements.element`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from fem.casing.reduced.reduced_body import ReducedBody
from mbd.elements.element import Element
from mbd.elements.element_table import ElementTable, element_table
from mbd.elements.linear_part import Part
from mbd.forces import drag, efficiency, film, flank, gyroscopic_plane, sliding
from mbd.parts.channels import ChannelRows, channel_names, channel_rows
from mbd.parts.coordinate_layout import Layout, layout
from mbd.parts.linear_reference import Assembly
from mbd.parts.machine import Machine
from mbd.parts.part_checks import MachineError
from mbd.system.rolling_frame import RollingFrame, rolling_frame

DEFAULT_BAND = 20e3  # Hz
ROLLS_FREELY = 1e-6  # force by rolling divided by the largest possible with the matrix: round-off


def _of_components(assembly: Assembly) -> Iterable[Element]:
    """What loads, bearings, couplings and outside forces bring themselves."""
    return (one for component in assembly.machine.components for one in component.elements(assembly.layout))


SOURCES_OF_FORCE: tuple[Callable[[Assembly], Iterable[Element]], ...] = (  # in the order of their rows
    flank.elements,
    film.elements,
    _of_components,
    efficiency.elements,
    sliding.elements,
    drag.brakes,
    drag.bearing_drags,  # needs the linear reference of all above
    gyroscopic_plane.elements,  # needs the modes with all above
)


@dataclass(frozen=True, eq=False, kw_only=True)
class System:
    """Matrices, elements and channels that the integrators use. Shapes: n coordinates, m forces, r modes; SI."""

    layout: Layout
    parts: tuple[Part, ...]
    mass: np.ndarray  # (n, n)
    damping: np.ndarray  # (n, n), with the references
    stiffness: np.ndarray  # (n, n), with the references
    rolling: np.ndarray  # R (n,)
    constant_force: np.ndarray  # f (n,)
    holding_force: np.ndarray  # (n,) acts until t = 0 only
    motor_torque: np.ndarray  # (2, n) on q and q': of all motors referred to the speed of the first, lifting positive
    elements: tuple[Element, ...]  # all nonlinear forces, in the order of their rows
    rows: np.ndarray  # B (m, n) of all elements
    row_names: tuple[str, ...]
    rolls: np.ndarray  # (m,) motion of the row per motor angle, 0 for elements whose forces do no work on it
    observed: np.ndarray  # (k, n) rows that elements observe without a force on them
    table: ElementTable  # the elements for compiled code
    gyroscopic: np.ndarray  # G (n, n) per motor speed; empty if left out
    channels: ChannelRows
    frame: RollingFrame  # motion of the frame of q
    basis: np.ndarray  # Phi (n, r): q = Phi p, mass-orthonormal
    frequencies: np.ndarray  # omega (r,), rad/s

    @property
    def machine(self) -> Machine:
        """The machine from which the system was assembled."""
        return self.layout.machine

    def at(self, name: str) -> slice:
        """Rows of the element called ``name``."""
        i = [element.name for element in self.elements].index(name)
        return slice(int(self.table.row[i]), int(self.table.row[i + 1]))

    def element(self, name: str) -> Element:
        """The element called ``name``."""
        return next(element for element in self.elements if element.name == name)

    def observed_by(self, name: str, motion: np.ndarray) -> np.ndarray:
        """Rows observed by the element called ``name``, from displacements (row + observed,) of `all_rows`."""
        i = [element.name for element in self.elements].index(name)
        first, end = self.table.seen[i] + len(self.rows)
        return motion[first:end]

    @property
    def contacts(self) -> dict[str, tuple[Element, ...]]:
        """Sides of every contact that holds the train, by its name."""
        found: dict[str, tuple[Element, ...]] = {}
        for element in self.elements:
            if element.contact is not None:
                found[element.contact.name] = (*found.get(element.contact.name, ()), element)
        return found

    @property
    def all_rows(self) -> np.ndarray:
        """Force rows, then observed rows."""
        return np.vstack([self.rows, self.observed])


def assemble(
    machine: Machine, casing: ReducedBody, channels: tuple[str, ...] | None = None, band: float = DEFAULT_BAND
) -> System:
    """Assemble the machine in its casing.

    Parameters
    ----------
    machine, casing : the parts
    channels : names from `mbd.parts.channels`; None: all but sensors
    band : Hz, modes above it contribute only by their static response; inf: all modes

    Raises
    ------
    MachineError : contradictory parts, unknown channels, a motion without stiffness, an indefinite mass
    """
    lay = layout(machine, casing)
    parts = tuple(part for component in lay.components for part in component.parts(lay))
    assembly = Assembly(lay, parts, band)
    _check_rolling(parts, assembly.rolling)
    for elements in SOURCES_OF_FORCE:
        assembly.add(elements(assembly))
    rows, (basis, frequencies) = assembly.rows, assembly.modes
    table, observed = element_table(assembly.elements, lay.size)
    names = channel_names(machine) if channels is None else tuple(channels)
    return System(
        layout=lay,
        parts=parts,
        mass=assembly.mass,
        damping=assembly.damping,
        stiffness=assembly.stiffness,
        rolling=assembly.rolling,
        constant_force=assembly.constant_force,
        holding_force=sum((component.holding_force(lay) for component in lay.components), np.zeros(lay.size)),
        motor_torque=_motor_torque(parts, lay.size),
        elements=tuple(assembly.elements),
        rows=rows,
        row_names=tuple(f"{element.name}:{word}" for element in assembly.elements for word in element.row_names),
        rolls=_rolls(assembly),
        observed=observed,
        table=table,
        gyroscopic=assembly.gyroscopic if machine.gyroscopic else np.zeros((0, 0)),
        channels=channel_rows(names, lay, assembly.elements),
        frame=rolling_frame(
            machine.free, assembly.mass, assembly.rolling, assembly.constant_force, rows, assembly.elements
        ),
        basis=basis,
        frequencies=frequencies,
    )


def _rolls(assembly: Assembly) -> np.ndarray:
    rolling = assembly.rows @ assembly.rolling
    rolling[abs(rolling) < 1e-12 * abs(rolling).max(initial=0.0)] = 0.0
    counts = [len(element.rows) for element in assembly.elements]
    return np.where(np.repeat([element.rolls for element in assembly.elements], counts), rolling, 0.0)


def _check_rolling(parts: tuple[Part, ...], rolling: np.ndarray) -> None:
    """Raise MachineError if rolling strains a part that does not define how its far ends turn."""
    for part in parts:
        own = rolling[part.index]
        force, size = part.stiffness @ own, abs(part.stiffness) @ abs(own)
        if not len(part.driven) and abs(force).max(initial=0.0) > ROLLS_FREELY * size.max(initial=0.0):
            raise MachineError(
                f"{part.name}: the rolling of the train strains it by {abs(force).max():.3g} N m per radian of the "
                "motor, which no constant matrix describes. State the motion of its far ends (``driven``) if they turn "
                "with the motors, else make it a nonlinear element."
            )


def _motor_torque(parts: tuple[Part, ...], size: int) -> np.ndarray:
    """Rows (2, n): -driven^T (K u + C u') of the parts whose far ends the motors turn."""
    rows = np.zeros((2, size))
    for part in parts:
        if len(part.driven):
            for row, matrix in zip(rows, ("stiffness", "damping"), strict=True):
                row -= part.driven @ part.own(matrix) @ part.rows(size)
    return rows


def natural_frequencies(system: System) -> np.ndarray:
    """Undamped frequencies (Hz) of the linear reference within the band, ascending."""
    return system.frequencies / (2 * np.pi)
