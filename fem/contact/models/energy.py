"""Model `energy`: the potential-energy method of the literature, for slices with the exact tooth profile.

A tooth is a cantilever of varying section, clamped where its fillet meets the root circle. A force f per unit face
width along the line of action at the height u_c and the half thickness y_c, inclined by alpha to the normal of the
tooth axis, causes bending, shear and axial energy with the compliances

    C_b = int (cos(alpha) (u_c - u) - y_c sin(alpha))^2 / (E I) du,    I = 2 y^3 / 3,
    C_s = int 1.2 cos(alpha)^2 / (G A) du,   C_a = int sin(alpha)^2 / (E A) du,   A = 2 y,

and rotates the body under the tooth (fillet foundation, fitted on an elastic ring of bore r_f / h by Sainsot et al.),

    C_f = cos(alpha)^2 / E (L (u_f/s_f)^2 + M u_f/s_f + P (1 + Q tan(alpha)^2)),

u_f from the root circle to where the line of action crosses the tooth axis, s_f = 2 r_f theta_f the arc of the
root. The contact is linear, C_h = 2/pi sum (1 - nu^2)/E (Yang & Lin). The compliance of a pair is the sum over both
gears, per unit face width. Helical gears are divided into slices whose transverse sections act as spur gears, with C_h
/ cos(beta_b) as in model `plane`.

Known bias, measured in tests: neighbouring teeth are uncoupled, each with a separate foundation, so that the body is
too stiff in double contact. The root circle is the clamping line although the fillet deforms with it. The contact does
not stiffen with load. Teeth bend in plane stress. Slices are independent, without axial bending. Root cracks are also
those of the method: `fem.contact.faults.cracked_beam`.

Weber & Banaschek (1953); Yang & Lin (1987), J. Mech. Trans. Autom. Des. 109(2), 189-196; Tian (2004), thesis,
University of Alberta; Sainsot, Velex & Duverger (2004), J. Mech. Des. 126(4), 748-752.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.models.mesh_model import MeshModel
from fem.contact.slice_frame import FLANKS, ModelError, flank_frame, window_fraction
from fem.contact.wheels.cantilever import beam_contour, cantilever
from fem.contact.wheels.plane_section import EDGE_GAP, POSITIONS
from fem.elements.materials import Material
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.path import contact_window, path_points
from fem.gears.profile import flank_at_roll
from fem.options import option

logger = logging.getLogger(__name__)

# A / theta^2 + B h^2 + C h / theta + D / theta + E h + F, rows L, M, P, Q: Sainsot et al. (2004), table 1
FOUNDATION = np.array(
    [
        (-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045),
        (60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086),
        (-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236),
        (-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904),
    ]
)
BORE_RANGE = (1.4, 7.0)  # r_f / r_bore of the fit
ROOT_RANGE = (0.01, 0.12)  # theta_f of the fit, rad


@dataclass(frozen=True, eq=False, kw_only=True)
class ToothParts:
    """Compliances (position,) of one tooth along the line of action per unit face width, m2/N."""

    bending: np.ndarray
    shear: np.ndarray
    axial: np.ndarray
    foundation: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """Their sum."""
        return self.bending + self.shear + self.axial + self.foundation


def foundation_factors(bore_ratio: float, root_angle: float) -> np.ndarray:
    """Factors L, M, P, Q (4,) for h = r_f / r_bore and theta_f, half the angle of the tooth at its root (rad)."""
    h, theta = bore_ratio, root_angle
    factors: np.ndarray = FOUNDATION @ np.array([theta**-2, h**2, h / theta, 1.0 / theta, h, 1.0])
    return factors


def tooth_parts(gear: Gear, material: Material, roll: np.ndarray) -> ToothParts:
    """Compliances of one tooth loaded at the roll lengths `roll` (position,) in m.

    Raises
    ------
    ModelError : a gear with a web, or a fit of the body without positive compliance
    """
    if gear.rim_thickness is not None:
        raise ModelError(
            f"model energy, gear z={gear.teeth}: the model has solid gear bodies only. Set mesh.model = 'plane' for a "
            "web"
        )
    contour = beam_contour(gear)
    root_angle, ratio = math.atan2(contour[1][0], contour[0][0]), gear.root_radius / gear.bore_radius
    inside = BORE_RANGE[0] <= ratio <= BORE_RANGE[1] and ROOT_RANGE[0] <= root_angle <= ROOT_RANGE[1]
    if not inside:
        logger.warning(
            "model energy, gear z=%d: the body is outside the range of its fit: r_f/r_bore %.3f (range %g to %g), "
            "theta_f %.4f rad (range %g to %g); model plane has no such limit",
            gear.teeth, ratio, *BORE_RANGE, root_angle, *ROOT_RANGE,
        )  # fmt: skip
    factors = foundation_factors(ratio, root_angle)
    root_arc = 2.0 * gear.root_radius * root_angle
    place, _, normal = flank_at_roll(gear, roll)
    young, shear = material.elastic_modulus, material.shear_modulus
    rows = []
    for (y_load, u_load), (across, up) in zip(place, normal, strict=True):
        alpha = math.atan2(up, across)
        below = contour[0] < u_load
        u = np.append(contour[0][below], u_load)
        y = np.append(contour[1][below], y_load)
        lever = (u_load - y_load * math.tan(alpha) - gear.root_radius) / root_arc
        body = factors[0] * lever**2 + factors[1] * lever + factors[2] * (1.0 + factors[3] * math.tan(alpha) ** 2)
        rows.append(
            (*cantilever(u, y, u_load, y_load, alpha, young, shear), float(math.cos(alpha) ** 2 / young * body))
        )
    bending, shearing, axial, foundation = np.array(rows).T
    if foundation.min() <= 0.0:
        raise ModelError(
            f"model energy, gear z={gear.teeth}: the fitted body has no positive compliance at r_f/r_bore {ratio:.3f} "
            f"and theta_f {root_angle:.4f} rad; set mesh.model = 'plane' for this gear"
        )
    return ToothParts(bending=bending, shear=shearing, axial=axial, foundation=foundation)


@dataclass(frozen=True, kw_only=True)
class Energy(MeshModel):
    """Mesh stiffness by the potential-energy method, for comparison with literature; it takes milliseconds.

    slices: number over the face; positions: grid points per base pitch.
    """

    model: Literal["energy"] = "energy"
    positions: int = option(64, **POSITIONS)

    def pair_compliance(self, pair: GearPair, pinion_radius: np.ndarray, wheel_radius: np.ndarray) -> np.ndarray:
        """Compliance (position,) of a single pair per unit face width (m2/N) at the contact radii (m)."""
        pinion, wheel = (
            tooth_parts(gear, material, np.sqrt(np.maximum(radius**2 - gear.base_radius**2, 0.0))).total
            for gear, material, radius in (
                (pair.pinion, pair.pinion_material, pinion_radius),
                (pair.wheel, pair.wheel_material, wheel_radius),
            )
        )
        moduli = (pair.pinion_material.plane_strain_modulus, pair.wheel_material.plane_strain_modulus)
        hertz = 2.0 / math.pi * sum(1.0 / modulus for modulus in moduli)
        return np.asarray(pinion + wheel + hertz / math.cos(pair.base_helix_angle))

    def laws(self, pair: GearPair) -> tuple[MeshLaw, MeshLaw]:
        """The laws of drive and coast flank, with common tables."""
        largest = EDGE_GAP * pair.pinion.normal_module
        first, last = contact_window(pair, largest)
        grid = np.arange(math.floor(first * self.positions), math.ceil(last * self.positions) + 1) / self.positions
        path = path_points(pair, grid, largest)
        compliance = self.pair_compliance(pair, path.pinion_radius, path.wheel_radius)
        drive, coast = (
            MeshLaw(
                model=self.model,
                **flank_frame(pair, flank, self.slices),
                position_start=float(grid[0]),
                position_step=1.0 / self.positions,
                compliance=compliance,
                contact_slope=0.0,
                contact_offset=np.zeros(grid.size),
                neighbour_compliance=np.zeros((0, grid.size)),
                gap=path.gap,
                fraction=window_fraction(path.gap),
            )
            for flank in FLANKS
        )
        return drive, coast
