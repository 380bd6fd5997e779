"""Model `iso`: tooth stiffness after ISO 6336-1:2019, clause 9, method B, uniform along the contact lines.

Single stiffness (N/(m m), per metre of face width and metre along the transverse line of action)

    c' = C_M C_R C_B cos(beta) / q' * E / E_St,   q' = C1 + C2/z_n1 + C3/z_n2 + C4 x1 + C5 x1/z_n1 + C6 x2 + C7 x2/z_n2
                                                      + C8 x1^2 + C9 x2^2    (mm um / N)

below a line load F_t K_A / b of 100 N/mm times (F_t K_A / b / 100)^0.25; mean over a pitch c_gamma_alpha =
c' (0.75 eps_alpha + 0.25); c_gamma_beta = 0.85 c_gamma_alpha for load distribution. The standard measures the
deflection as arc of the base circle, so F_bt = c_gamma_alpha b delta with F and delta of a MeshLaw, without the factor
cos(beta_b).

In the law each metre of face width on the path of contact has the stiffness c_gamma_alpha / eps_alpha. On average
eps_alpha pairs are in contact, so the mean is exact and the shape is that of the contact line length. The standard has
no tip-edge contact. Here its gap is at least `edge_onset`: below that approach the closed form is unchanged, and the
contact continues if a tooth is missing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.models.mesh_model import MeshModel
from fem.contact.slice_frame import FLANKS, ModelError, flank_frame, window_fraction
from fem.contact.wheels.plane_section import EDGE_GAP
from fem.elements.materials import STEEL
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications
from fem.gears.path import bridging_window, path_points, slice_fraction

COEFFICIENTS = (0.04723, 0.15551, 0.25791, -0.00635, -0.11654, -0.00193, -0.24188, 0.00529, 0.00182)
MEAN_FACTOR = 0.8  # C_M: correction of the theoretical stiffness by measurements
LOW_LINE_LOAD = 100e3  # N/m; below it the stiffness decreases with the load
LEAST_LOAD_FACTOR = 0.9  # a lower one is a warning; a smaller reduction is within the deviation from `plane`, 10 %
MAX_HELIX = math.radians(30.0)
_PER_MM_UM = 1e9  # N/(mm um) in N/m2


@dataclass(frozen=True, kw_only=True)
class IsoStiffness:
    """c', c_gamma_alpha, c_gamma_beta in N/m2 (N/(mm um) times 1e9) along the transverse line of action."""

    single: float
    mean: float
    mean_for_distribution: float


def blank_factor(web_ratio: float, rim_ratio: float) -> float:
    """C_R = 1 + ln(b_s/b) / (5 exp(s_R / (5 m_n))); b_s/b is taken within [0.2, 1.2], s_R/m_n at least 1.

    A solid disc (b_s = b) has C_R = 1. For gears of different design use the mean of their factors.
    """
    return 1.0 + math.log(min(max(web_ratio, 0.2), 1.2)) / (5.0 * math.exp(max(rim_ratio, 1.0) / 5.0))


def gear_blank(gear: Gear) -> float:
    """C_R of one gear from its rim and web; 1 for a solid body."""
    return 1.0 if gear.rim_thickness is None else blank_factor(gear.web_ratio, gear.rim_thickness / gear.normal_module)


def rack_factor(gear: Gear) -> float:
    """C_B = [1 + 0.5 (1.2 - h_fP/m_n)] [1 - 0.02 (20 - alpha_Pn in degrees)]."""
    rack = gear.rack
    return (1.0 + 0.5 * (1.2 - rack.dedendum)) * (1.0 - 0.02 * (20.0 - math.degrees(rack.pressure_angle)))


@dataclass(frozen=True, kw_only=True)
class Iso(MeshModel):
    """Mesh stiffness by ISO 6336-1: mean by formula, variation by contact line length; it takes milliseconds.

    slices: number over the face; blank_factor C_R, None: the mean for the rims and webs of both gears (a web offset is
    ignored); line_load F_t K_A / b (N/m) or None for a load in the linear range; edge_onset (m_n): least approach with
    tip-edge contact.

    Valid for steel-like pairs of elastic teeth with eps_alpha >= 1.2, beta <= 30 deg, -0.5 <= x1 + x2 <= 2.
    """

    model: Literal["iso"] = "iso"
    blank_factor: float | None = None
    line_load: float | None = None
    edge_onset: float = 0.01

    def stiffness(self, pair: GearPair) -> IsoStiffness:
        """c', c_gamma_alpha and c_gamma_beta of the pair.

        Raises
        ------
        ModelError : the pair is outside the range of the standard's fit
        """
        p, w = pair.pinion, pair.wheel
        shift = p.profile_shift + w.profile_shift
        for bad, what in (
            (
                pair.transverse_contact_ratio < 1.2,
                f"the contact ratio {pair.transverse_contact_ratio:.4g} is below the limit 1.2",
            ),
            (
                p.helix_angle > MAX_HELIX,
                f"the helix angle {math.degrees(p.helix_angle):.4g} deg is above the limit 30 deg",
            ),
            (not -0.5 <= shift <= 2.0, f"the sum of profile shifts {shift:.4g} is outside the range -0.5 to 2"),
        ):
            if bad:
                raise ModelError(
                    f"iso, {pair.label}: {what} of ISO 6336-1 method B. Set mesh.model = 'plane' for this pair"
                )
        x1, x2 = p.profile_shift, w.profile_shift
        z1, z2 = p.virtual_teeth, w.virtual_teeth
        terms = (1.0, 1 / z1, 1 / z2, x1, x1 / z1, x2, x2 / z2, x1**2, x2**2)
        flexibility = sum(c * t for c, t in zip(COEFFICIENTS, terms, strict=True))
        body = 0.5 * (gear_blank(p) + gear_blank(w)) if self.blank_factor is None else self.blank_factor
        e1, e2 = pair.pinion_material.elastic_modulus, pair.wheel_material.elastic_modulus
        elastic = 2.0 * e1 * e2 / (e1 + e2) / STEEL.elastic_modulus
        rack = 0.5 * (rack_factor(p) + rack_factor(w))
        single = MEAN_FACTOR * body * rack * math.cos(p.helix_angle) * elastic / flexibility * _PER_MM_UM
        single *= self.load_factor
        mean = single * (0.75 * pair.transverse_contact_ratio + 0.25)
        return IsoStiffness(single=single, mean=mean, mean_for_distribution=0.85 * mean)

    @property
    def load_factor(self) -> float:
        """Factor of c' at the line load, 1 from 100 N/mm."""
        return 1.0 if self.line_load is None else min(1.0, (self.line_load / LOW_LINE_LOAD) ** 0.25)

    def laws(self, pair: GearPair) -> tuple[MeshLaw, MeshLaw]:
        """The laws of drive and coast flank; mean of dF/d delta over a pitch = c_gamma_alpha b."""
        step, ramp = _grid_step(pair.transverse_contact_ratio, pair.overlap_ratio / self.slices)
        largest, first, last = bridging_window(pair, EDGE_GAP * pair.pinion.normal_module)
        below = math.ceil((pair.xi_start - first) / step) + 2
        above = math.ceil((last - pair.xi_start) / step) + 2
        xi = pair.xi_start + step * np.arange(-below, above + 1)
        gap, fraction = self._contact(pair, xi, step, ramp, largest)
        mean = self.stiffness(pair).mean
        drive, coast = (
            MeshLaw(
                model=self.model,
                **flank_frame(pair, flank, self.slices),
                position_start=xi[0],
                position_step=step,
                compliance=np.full(xi.size, pair.transverse_contact_ratio / mean),
                contact_slope=0.0,
                contact_offset=np.zeros(xi.size),
                neighbour_compliance=np.zeros((0, xi.size)),
                gap=gap,
                fraction=fraction,
            )
            for flank in FLANKS
        )
        return drive, coast

    def warnings(self, modifications: PairModifications) -> Iterator[str]:
        """Warnings: large low-load reduction; relief, as its effect on load sharing is not modelled."""
        if self.load_factor < LEAST_LOAD_FACTOR:
            yield (
                f"the line load of {(self.line_load or 0) / 1000:.1f} N/mm is low: the model iso reduces the stiffness "
                f"by {100 * (1 - self.load_factor):.0f} % after ISO 6336-1. Increase the load, or set mesh.model = "
                '"plane" or "solid"'
            )
        if modifications.pinion.tip_relief or modifications.wheel.tip_relief:
            yield (
                'the model iso does not model the effect of tip relief on load sharing. Set mesh.model = "plane" or '
                '"solid"'
            )

    def _contact(
        self, pair: GearPair, xi: np.ndarray, step: float, ramp: float, largest: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Gap and fraction: the path of contact with its ramps, and tip-edge contact beyond it."""
        start, end = pair.xi_start, pair.xi_end
        edge_gap = np.maximum(path_points(pair, xi, largest).gap, self.edge_onset * pair.pinion.normal_module)
        reach = ramp / 2 + 0.5 * step
        on_path = (xi > start - reach) & (xi < end + reach)
        fraction = slice_fraction(xi, start, end, ramp) if ramp > 0.0 else np.ones(xi.size)
        # after a ramp tip-edge contact begins beyond one empty point, so that no cell mixes it with the path
        beside = (xi > start - reach - step) & (xi < end + reach + step) if ramp > 0.0 else on_path
        gap = np.where(on_path, 0.0, edge_gap)
        return gap, np.where(beside, fraction, 1.0) * window_fraction(gap)


def _grid_step(contact_ratio: float, ramp: float) -> tuple[float, float]:
    """Grid step and ramp width, with grid points at both path ends and at the ends of the ramps.

    The step is eps_alpha / N with N from 300 to 600 such that the ramp is nearest to an even number of steps; the ramp
    is then made exactly that (its width changes by at most about 1 %, its centre is unchanged). For a ramp below two
    steps, as for spur gears, N is 1200 without ramp: the gap increases from 0 to the onset in the first cell beyond the
    path.
    """
    numbers = np.arange(300, 601)
    half = np.round(ramp / 2 / contact_ratio * numbers)
    if half.min() < 1.0:
        return contact_ratio / 1200.0, 0.0
    error = np.abs(2.0 * half * contact_ratio / numbers - ramp)
    best = int(np.argmin(error))
    step = contact_ratio / float(numbers[best])
    return step, 2.0 * float(half[best]) * step
