"""SOURCES_OF_FORCE: all sources of nonlinear forces in a machine, in the order of their rows.

A kind of element is a file of this folder (see `mbd.elements.element`) and a line here. Loads, nonlinear bearings,
couplings and outside forces are objects of the machine that make their elements: a new one of these needs no line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from mbd.elements.element import Element
from mbd.forces import drag, efficiency, film, flank, gyroscopic_plane, sliding
from mbd.parts.assembly import Assembly


def load(assembly: Assembly) -> Iterable[Element]:
    """Load on the drums."""
    load = assembly.machine.load
    return () if load is None else load.elements(assembly.layout)


def bearings(assembly: Assembly) -> Iterator[Element]:
    """Nonlinear bearings."""
    for bearing in assembly.machine.bearings:
        yield from bearing.elements(assembly.layout)


def couplings(assembly: Assembly) -> Iterator[Element]:
    """Nonlinear couplings."""
    for coupling in assembly.machine.shaft_couplings:
        yield from coupling.elements(assembly.layout)


def outside(assembly: Assembly) -> Iterator[Element]:
    """Further forces from outside."""
    for force in assembly.machine.forces:
        yield from force.elements(assembly.layout)


SOURCES_OF_FORCE: dict[str, Callable[[Assembly], Iterable[Element]]] = {
    "flanks": flank.elements,
    "films": film.elements,
    "load": load,
    "bearings": bearings,
    "couplings": couplings,
    "mesh efficiency": efficiency.elements,
    "tooth friction": sliding.elements,
    "brake": drag.brakes,
    "outside forces": outside,
    "bearing drag": drag.bearing_drags,  # needs the linear reference of all kinds above
    "gyroscopic moments": gyroscopic_plane.elements,  # needs the modes with all kinds above
}
