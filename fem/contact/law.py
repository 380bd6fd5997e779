"""MeshLaw: the elastic force of one flank of a gear pair, (c, delta, psi; teeth) -> U, F, M, shares.

The face is divided into slices. In slice s at face coordinate y_s the tooth pair p is at the position xi = c' - p +
shift_s on the path of contact, in mesh cycles, with c' = cycle_sign * c + cycle_offset. Its line load f (N/m) and
approach x (m) obey

    x = C(xi) f + A f (B(xi) - ln f) + sum_q c_|p-q|(xi) fraction_q f_q        (x > 0, else f = 0)
    x = delta + psi y_s - gap(xi) - lead_gap(y_s) - h_p(xi, y_s)

C is the tooth and body compliance, A and B represent the Hertz line contact (`fem.contact.wheels.hertz_terms`), c_n is
the compliance between pair p and pair p + n (tabulated at the xi of the leading pair, that with the smaller p). F = sum
fraction f width, M = sum fraction f width y. U is the strain energy, so F = dU/d delta, M = dU/d psi.

Gaps are means over the slice. Contact starts at its least gap. Until the slice is in full contact, x is less than the
first right-hand side by the term of `fem.contact.part_contact`, so that slicing causes no spurious excitation.

With slices coupled along the face (not by default), x is reduced by

    sqrt(D(xi)) v_p(y) + E_0 F + E_01 (M + F y) + E_1 M y
    v_p - a^2 v_p'' = sqrt(D) fraction f_p,   v_p' = 0 at both ends of the face

D is the compliance of tooth bending that spreads along the face over the length a: an elastic foundation whose
influence decays as exp(-|y - y'|/a) and doubles at a free end, the moment image of Wellauer & Seireg (1960, J. Eng.
Ind. 82). E_0 is the wind-up and E_1 the tilt of the bodies, E_01 their coupling by a helix; they are common to all
pairs.

Shapes along the flank are gaps, positive where material is missing: gap(xi) includes the profiles of both gears and the
gap of the tip edges, lead_gap(y) their leads. The sum of the two is exact for every modification except a twisted
flank. h_p are the contributions of the two teeth of the pair, see `fem.contact.teeth`. A damaged tooth is a variant: a
table over (slice, position) of the compliance and the gap that it adds to its pair. The contributions of pinion and
wheel are added. Variant 0 is the healthy tooth, variant v the table v - 1.

A variant may also have modes m_k, which add compliance between all contacts i = (pair, slice) of the damaged tooth's
pair p and of the pairs p - 1 and p + 1 (`near` 0, 1, 2 means p - 1, p, p + 1; tables at the xi of that pair):

    x_i is reduced by sum_k m_k(i) q_k,   q_k = sum_j m_k(j) fraction_j f_j width_j

which depends on all loads, like a displacement of the bodies (`fem.contact.evaluation.solver`).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.storage.records import Record, array, integer, scalar, text


def _sound(*dims: str, units: str, infinite: bool = False) -> Any:
    """Array field that is 0, or without variants, by default."""
    return dataclasses.field(default=None, metadata=array(*dims, units=units, infinite=infinite).metadata)


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshLaw(Record):
    """Mesh law of one flank: pair compliances on a grid of positions, the same for every slice."""

    model: str = text()
    flank: str = text()  # "drive" | "coast"
    face_coordinate: np.ndarray = array("slice", units="m")  # y_s, 0 at mid face
    slice_width: np.ndarray = array("slice", units="m")  # sums to the face width
    cycle_shift: np.ndarray = array("slice", units="1")  # y_s tan(beta_b) / p_bt with the sign of the hand
    cycle_sign: int = integer()  # +1 drive, -1 coast
    cycle_offset: float = scalar(units="1")
    position_start: float = scalar(units="1")  # first xi of the uniform grid
    position_step: float = scalar(units="1")
    compliance: np.ndarray = array("position", units="m2/N")  # C
    contact_slope: float = scalar(units="m2/N")  # A
    contact_offset: np.ndarray = array("position", units="1")  # B
    neighbour_compliance: np.ndarray = array("neighbour", "position", units="m2/N")  # c_1, c_2, ...
    gap: np.ndarray = array("position", units="m", infinite=True)  # inf: no contact possible
    fraction: np.ndarray = array("position", units="1")  # share of the slice that can be in contact
    base_pitch: float = scalar(units="m")  # transverse base pitch p_bt
    pinion_teeth: int = integer()
    wheel_teeth: int = integer()
    wheel_tooth_offset: int = integer()  # pair p: pinion tooth cycle_sign*p, wheel tooth cycle_sign*p + this
    spread_compliance: np.ndarray = _sound("position", units="m2/N")  # D, of tooth bending that spreads along the face
    spread_length: float = dataclasses.field(default=0.0, metadata=scalar(units="m").metadata)  # a
    body_compliance: float = dataclasses.field(default=0.0, metadata=scalar(units="m/N").metadata)  # E_0
    skew_compliance: float = dataclasses.field(default=0.0, metadata=scalar(units="1/N").metadata)  # E_01
    tilt_compliance: float = dataclasses.field(default=0.0, metadata=scalar(units="1/(N m)").metadata)  # E_1
    lead_coordinate: np.ndarray = _sound("lead_point", units="m")  # from mid face, ascending; default: the slices
    lead_gap: np.ndarray = _sound("lead_point", units="m")  # linear between these points, constant beyond
    pinion_variant_compliance: np.ndarray = _sound("pinion_variant", "slice", "position", units="m2/N")  # >= 0
    pinion_variant_gap: np.ndarray = _sound("pinion_variant", "slice", "position", units="m", infinite=True)
    pinion_variant_modes: np.ndarray = _sound(
        "pinion_variant", "pinion_mode", "near", "slice", "position", units="m(1/2)/N(1/2)"
    )
    wheel_variant_compliance: np.ndarray = _sound("wheel_variant", "slice", "position", units="m2/N")
    wheel_variant_gap: np.ndarray = _sound("wheel_variant", "slice", "position", units="m", infinite=True)
    wheel_variant_modes: np.ndarray = _sound(
        "wheel_variant", "wheel_mode", "near", "slice", "position", units="m(1/2)/N(1/2)"
    )

    def __post_init__(self) -> None:
        slices, positions = np.size(self.face_coordinate), np.size(self.compliance)
        if self.lead_coordinate is None:
            object.__setattr__(self, "lead_coordinate", self.face_coordinate)
        for field in dataclasses.fields(self):
            if field.default is None and getattr(self, field.name) is None:
                shape: dict[str, tuple[int, ...]] = {
                    "lead_gap": np.shape(self.lead_coordinate),
                    "spread_compliance": (positions,),
                }
                if field.name.endswith("_modes"):
                    variants = getattr(self, field.name.replace("modes", "gap"))
                    shape[field.name] = (len(variants), 0, 3, slices, positions)
                object.__setattr__(self, field.name, np.zeros(shape.get(field.name, (0, slices, positions))))
        super().__post_init__()

    @property
    def slice_lead_gap(self) -> np.ndarray:
        """Lead gap (slice,), m, at the centres of the slices."""
        return np.interp(self.face_coordinate, self.lead_coordinate, self.lead_gap)
