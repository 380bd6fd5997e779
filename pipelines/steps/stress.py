"""Steps `compliance` and `stress`: 3-D contact, and the stress at one position.

Both use the model `solid`, whatever the model of the mesh law. Missing teeth, modifications, wear and chips change the
contact. A crack does not, because the finite elements are those of undamaged teeth.
"""

from __future__ import annotations

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.models.solid import Solid
from fem.contact.models.solid_stress import LoadedTeeth, stress_field
from fem.contact.slice_frame import law_points
from fem.contact.teeth import checked_terms
from fem.contact.wheels.compliance import ContactCompliance
from fem.contact.wheels.direct_contact import contact_at
from fem.gears.geometry import GearPair
from fem.gears.modifications import lead_gap, profile_gap
from pipelines.machine.flanks_spec import FlanksSpec


def build_compliance(pair: GearPair, model: Solid) -> ContactCompliance:
    """The compliances between all possible contact points."""
    return model.compliance(pair)


def build(
    flanks: FlanksSpec,
    model: Solid,
    index: int,
    force: float,
    pinion_terms: np.ndarray,
    wheel_terms: np.ndarray,
    *,
    record: ContactCompliance,
    laws: tuple[MeshLaw, MeshLaw],
) -> LoadedTeeth:
    """Contact at the force, then displacement and stress of the teeth of all pairs in mesh or near it.

    Parameters
    ----------
    flanks, model : pair and modifications, and the model
    index, force : position, index / model.positions, and force (N)
    pinion_terms, wheel_terms : (tooth,) or (tooth, 6), terms of the teeth
    record, laws : compliances of the pair, and its laws

    Raises
    ------
    ModelError : no tooth can carry the force
    """
    law, pair = laws[0], flanks.pair
    turns, place = divmod(index, len(record.position))
    numbers = record.pair + turns
    xi = index / len(record.position) - numbers[:, None] + record.cycle_shift
    teeth = (numbers % law.pinion_teeth, (numbers + law.wheel_tooth_offset) % law.wheel_teeth)
    terms = (
        checked_terms("pinion", law.pinion_teeth, pinion_terms)[teeth[0]],
        checked_terms("wheel", law.wheel_teeth, wheel_terms)[teeth[1]],
    )
    extra = np.where(np.isfinite(record.gap[place]), _gaps(flanks, law, record, xi, terms), 0.0)
    _, line_load = contact_at(record, index, force, extra)
    pinion, wheel = stress_field(pair, model, record, index, line_load)
    return LoadedTeeth(
        cycle=index / len(record.position),
        hand=record.hand,
        pinion=pinion,
        wheel=wheel,
        pair=numbers,
        xi=xi,
        face=record.face,
        line_load=line_load,
        missing=np.array([np.isinf(of_gear[:, 0]) for of_gear in terms]),
    )


def _gaps(
    spec: FlanksSpec, law: MeshLaw, record: ContactCompliance, xi: np.ndarray, terms: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Gaps (pair, slice) by modifications and terms of the teeth, m."""
    y = record.hand * record.face
    grid = law.position_start + law.position_step * np.arange(law.compliance.size)
    shape = profile_gap(spec.pair, spec.modifications, law_points(law, spec.pair))
    for gear, common in (("pinion", spec.pinion_wear), ("wheel", spec.wheel_wear)):
        for fault in common:
            shape = shape + fault.gap(law, spec.pair, gear)
    total = np.interp(xi, grid, shape) + lead_gap(spec.pair, spec.modifications, "drive", y)
    slices = np.abs(law.face_coordinate[:, None] - y).argmin(axis=0)
    places = np.clip(np.rint((xi - grid[0]) / law.position_step).astype(int), 0, grid.size - 1)
    for tables, of_gear in zip((law.pinion_variant_gap, law.wheel_variant_gap), terms, strict=True):
        total = total + of_gear[:, :1]
        for number in np.flatnonzero(of_gear[:, 5]):
            total[number] += tables[int(of_gear[number, 5]) - 1, slices, places[number]]
    return total
