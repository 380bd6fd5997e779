"""Assembly of the multibody model: the machine from its parts and mesh laws, and the system of machine and casing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fem.contact.deviating_teeth import deviating_law
from fem.contact.law import MeshLaw
from fem.contact.teeth import tooth_terms
from fem.gears.deviations import sample_pitch_deviations
from fem.gears.flank_deviations import sample_flank_deviations
from fem.gears.geometry import GearPair
from fem.gears.prescribed import single_tooth_terms
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.machine import Machine
from pipelines.machine.parts import GearMesh, GearTeeth, MachineParts, Recorded

if TYPE_CHECKING:
    from fem.casing.reduced.body import ReducedBody
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


def clearances(pair: GearPair, pinion: GearTeeth, wheel: GearTeeth) -> dict[str, np.ndarray]:
    """Deviations, missing and damaged teeth of a pair by flank and gear: "drive_clearance_pinion" ...

    Each value holds the clearances (tooth,) in m, or tooth terms (tooth, 6) if clearances are not sufficient, see
    `fem.contact.teeth`.
    """
    found: dict[str, np.ndarray] = {}
    for name, gear, teeth in (("pinion", pair.pinion, pinion), ("wheel", pair.wheel, wheel)):
        given = teeth.deviations
        flanks = {"drive": np.zeros(gear.teeth), "coast": np.zeros(gear.teeth)}
        if given is not None and "pitch" in given.include:
            flanks = sample_pitch_deviations(gear, given.grade, given.seed)
        faulty = fault_terms(gear.teeth, teeth)
        shapes = {}
        if given is not None and ("profile" in given.include or "helix" in given.include):
            included = {key: key in given.include for key in ("profile", "helix")}
            shapes = sample_flank_deviations(pair, name, given.grade, given.seed, **included)
        for flank, clearance in flanks.items():
            terms = clearance + (faulty if faulty.ndim == 1 else faulty[:, 0])
            if flank in shapes:
                shape = shapes[flank]
                terms = tooth_terms(gear.teeth, **(shape | {"clearance": terms + shape["clearance"]}))
            if teeth.prescribed is not None and teeth.prescribed.teeth:
                offset, slope = single_tooth_terms(pair, name, flank, teeth.prescribed)
                terms = terms if terms.ndim == 2 else tooth_terms(gear.teeth, clearance=terms)
                terms[:, 0] += offset
                terms[:, 1] += slope
            if faulty.ndim == 2:
                terms = terms if terms.ndim == 2 else tooth_terms(gear.teeth, clearance=terms)
                terms[:, -1] = faulty[:, -1]
            found[f"{flank}_clearance_{name}"] = terms
    return found


def fault_terms(count: int, teeth: GearTeeth) -> np.ndarray:
    """The faults of a gear with `count` teeth, without its deviations; the same for both flanks.

    The result holds clearances (tooth,) in m, +inf for missing teeth, or tooth terms (tooth, 6) if teeth are damaged.
    """
    clearance, variant = np.zeros(count), np.zeros(count)
    for tooth, more in teeth.clearances:
        clearance[tooth] += more
    if not teeth.damaged:
        return clearance
    variant[list(teeth.damaged)] = 1 + np.arange(len(teeth.damaged))
    return tooth_terms(count, clearance=clearance, variant=variant)


def mesh_faults(mesh: GearMesh) -> tuple[np.ndarray, np.ndarray]:
    """The faults of pinion and wheel without their deviations, see `fault_terms`."""
    pair = mesh.pair
    return fault_terms(pair.pinion.teeth, mesh.pinion), fault_terms(pair.wheel.teeth, mesh.wheel)
