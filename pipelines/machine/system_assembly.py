"""Assembly of the multibody model: the machine from its parts and mesh laws, and the system of machine and casing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fem.contact.deviating_teeth import deviating_law
from fem.contact.law import MeshLaw
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.machine import Machine
from pipelines.machine.machine_parts import GearMesh, MachineParts, Recorded
from pipelines.machine.tooth_terms import clearances

if TYPE_CHECKING:
    from fem.casing.reduced.reduced_body import ReducedBody
    from mbd.system.system import System

Laws = tuple[MeshLaw, MeshLaw]  # of drive and coast flank


def assemble_machine(parts: MachineParts, laws: Sequence[Laws]) -> Machine:
    """The multibody machine without its casing.

    Raises
    ------
    MachineError : parts that do not fit together
    """
    return parts.geared(tuple(_mesh(mesh, *flanks) for mesh, flanks in zip(parts.meshes, laws, strict=True)))


def assemble_system(machine: Machine, body: ReducedBody, recorded: Recorded, band: float | None = None) -> System:
    """The machine in its casing.

    Parameters
    ----------
    machine, body : the machine and its reduced casing
    recorded : recorded channels
    band : Hz, modes above it are omitted; by default that of `mbd`
    """
    from mbd.system.system import DEFAULT_BAND, assemble

    return assemble(machine, body, recorded.channels(machine), DEFAULT_BAND if band is None else band)


def _mesh(mesh: GearMesh, drive: MeshLaw, coast: MeshLaw) -> MeshSpec:
    pair = mesh.pair
    laws, terms = {"drive": drive, "coast": coast}, clearances(pair, mesh.pinion, mesh.wheel)
    for gear, teeth in (("pinion", mesh.pinion), ("wheel", mesh.wheel)):
        if teeth.prescribed is not None:
            for flank in laws:
                own = f"{flank}_clearance_{gear}"
                laws[flank], terms[own] = deviating_law(laws[flank], pair, gear, terms[own], teeth.prescribed)
    return mesh.meshing(
        base_radius_driving=pair.pinion.base_radius,
        base_radius_driven=pair.wheel.base_radius,
        pressure_angle=pair.working_pressure_angle,
        base_helix_angle=pair.base_helix_angle,
        backlash=pair.backlash,
        drive=laws["drive"],
        coast=laws["coast"],
        **terms,
    )
