"""Tooth terms of a gear pair in a machine: deviations and faults of the teeth of both gears."""

from __future__ import annotations

import numpy as np

from fem.contact.teeth import tooth_terms
from fem.gears.deviations import sample_pitch_deviations
from fem.gears.flank_deviations import sample_flank_deviations
from fem.gears.geometry import GearPair
from fem.gears.prescribed import single_tooth_terms
from pipelines.machine.machine_parts import GearMesh, GearTeeth


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
