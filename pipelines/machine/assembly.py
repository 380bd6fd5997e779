"""The machine of a plant, put together of its parts and the mesh laws; with the casing, the system that moves."""

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
    """Everything the multibody run needs but the casing. `MachineError` names what does not fit."""
    return Machine(
        shafts=parts.shafts,
        bearings=parts.bearings,
        meshes=tuple(_mesh(mesh, *flanks) for mesh, flanks in zip(parts.meshes, laws, strict=True)),
        couplings=parts.motors,
        input_shaft=parts.driven,
        profile=parts.drive,
        load=parts.load,
        shaft_couplings=parts.couplings,
        forces=parts.forces,
        losses=parts.losses,
        brake=parts.brake,
        gyroscopic=parts.gyroscopic,
        probes=parts.probes,
    )


def assemble_system(machine: Machine, body: ReducedBody, recorded: Recorded, band: float | None = None) -> System:
    """The machine in its casing.

    Parameters
    ----------
    machine, body : the machine and its reduced casing
    recorded : the channels
    band : Hz, modes above it are left out; by default that of `mbd`
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
    return MeshSpec(
        name=mesh.name,
        driving=mesh.driving,
        driven=mesh.driven,
        y=mesh.y,
        base_radius_driving=pair.pinion.base_radius,
        base_radius_driven=pair.wheel.base_radius,
        pressure_angle=pair.working_pressure_angle,
        base_helix_angle=pair.base_helix_angle,
        backlash=pair.backlash,
        damping_time=mesh.damping_time,
        drive=laws["drive"],
        coast=laws["coast"],
        drive_clearance_pinion=terms["drive_clearance_pinion"],
        drive_clearance_wheel=terms["drive_clearance_wheel"],
        coast_clearance_pinion=terms["coast_clearance_pinion"],
        coast_clearance_wheel=terms["coast_clearance_wheel"],
        cycle_at_start=mesh.cycle_at_start,
        film=mesh.film,
    )


def clearances(pair: GearPair, pinion: GearTeeth, wheel: GearTeeth) -> dict[str, np.ndarray]:
    """What the teeth of a pair bring to its laws, by flank and gear: deviations, missing and damaged teeth.

    Clearances (tooth,) in m where that is all, else tooth terms (tooth, 6), see `fem.contact.teeth`.
    """
    found: dict[str, np.ndarray] = {}
    for name, gear, teeth in (("pinion", pair.pinion, pinion), ("wheel", pair.wheel, wheel)):
        given = teeth.deviations
        flanks = {"drive": np.zeros(gear.teeth), "coast": np.zeros(gear.teeth)}
        if given is not None and "pitch" in given.include:
            pitch = sample_pitch_deviations(gear, given.grade, given.seed)
            flanks = {"drive": pitch.drive, "coast": pitch.coast}
        faulty = fault_terms(gear.teeth, teeth)
        shapes = {}
        if given is not None and ("profile" in given.include or "helix" in given.include):
            wanted = {key: key in given.include for key in ("profile", "helix")}
            shapes = sample_flank_deviations(pair, name, given.grade, given.seed, **wanted)
        for flank, clearance in flanks.items():
            terms = clearance + (faulty if faulty.ndim == 1 else faulty[:, 0])
            if flank in shapes:
                shape = shapes[flank]
                terms = tooth_terms(gear.teeth, **(vars(shape) | {"clearance": terms + shape.clearance}))
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
    """The faults of a gear with `count` teeth without its deviations, on either flank.

    Clearances (tooth,), +inf at missing teeth, or tooth terms (tooth, 6) where teeth are damaged otherwise.
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
