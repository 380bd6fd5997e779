"""Compliance of one slice of a tooth pair in the transverse section, by finite elements of the whole toothed rings.

The elements of one tooth are made in `fem.gears.sector_mesh`.

All quantities are transverse, per slice and unit face width. A ring model gives the displacement G_ij along the flank
normal at position i by a load at position j, both spread over an elliptical patch of half-width w and averaged with the
same weight (so G is symmetric and finite). It includes the local deformation of a patch w. A Hertz contact has the
half-width a instead, and its approach is that at the centre, not the mean. On a half plane in plane strain an
elliptical pressure of resultant f gives

    u(x) = u(0) - K f x^2 / a^2,   K = 2 (1 - nu^2) / (pi E),   mean u = u(0) - K f / 4,   du(0) / d ln a = -K f,

so that each body approaches by f (G_ii + K (1/4 + ln(w/a))). With a^2 = 4 f R / (pi E*), 1/E* = sum (1 - nu^2)/E and
A = 1/(pi E*) the sum over both bodies (A and B in `fem.contact.wheels.hertz_terms`) is

    x = C f + A f (B - ln f),   C = G_ii + G_ii' + 2 A ln(w/d),   B = 1/2 + ln(d^2 pi E* / (4 R)).

The depth d divides the same approach between the two terms; with d = m_n, a < d at any permissible load.

Helical teeth: the rings are helical bodies (`fem.elements.sections`), so that a tooth bends and twists in its oblique
direction. The force normal to the flank is f / cos(beta_b) per unit face width, f per unit length of contact line, and
the normal approach is x cos(beta_b); the normal radius is R / cos(beta_b). Hence R above is replaced by R /
cos(beta_b), and A = 1/(pi E* cos(beta_b)).

Hertz (1881); Johnson (1985), Contact Mechanics, sections 2.5 and 4.2; Weber & Banaschek (1953) for the division of the
approach.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.contact.slice_frame import ModelError
from fem.contact.wheels.hertz_terms import contact_terms
from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints, bridging_window, path_points
from fem.options import check_options, option
from fem.storage.ledger import count

if TYPE_CHECKING:
    from fem.contact.wheels.ring import FlankCompliance

EDGE_GAP = 0.05  # m_n: largest no-load gap for tip-edge contact; must exceed the largest delta
POSITIONS: Any = {"ge": 16, "le": 1024, "text": "mesh positions per base pitch at which stiffness is tabulated"}


@dataclass(frozen=True, kw_only=True)
class PlaneSection:
    """Finite elements of both toothed rings in the transverse section.

    Parameters
    ----------
    refinement : divides all element sizes (1: 0.05 m_n along the flank)
    patch : half-width of the pressure patches in m_n; the result does not depend on it (below 0.2 %)
    positions : grid points per base pitch
    """

    refinement: float = option(1.0, ge=0.5, le=8, text="factor that divides all element sizes of the tooth sector")
    patch: float = 0.08
    positions: int = option(64, **POSITIONS)

    def __post_init__(self) -> None:
        check_options(self, ModelError)

    def path(self, pair: GearPair) -> PathPoints:
        """The path of contact on a uniform grid over its `bridging_window`."""
        largest, first, last = bridging_window(pair, EDGE_GAP * pair.pinion.normal_module)
        grid = np.arange(math.floor(first * self.positions), math.ceil(last * self.positions) + 1) / self.positions
        return path_points(pair, grid, largest)

    def tables(self, pair: GearPair, path: PathPoints) -> dict[str, Any]:
        """Compliances of one slice at the positions of `path`."""
        reach = max(1, math.ceil((len(path.xi) - 1) / self.positions) - 1)
        rings = self.rings(pair, reach)
        weights, own = self.own_compliance(pair, path, rings)
        between = np.zeros((reach, len(path.xi)))
        here = np.arange(len(path.xi))
        for n in range(1, reach + 1):
            behind = np.clip(here - n * self.positions, 0, None)
            # the loaded flank is the leading one of a pinion tooth and the trailing one of a wheel tooth: the following
            # pair p + n has tooth -n of the pinion and tooth +n of the wheel, counted towards the loaded flank
            for weight, ring, tooth in zip(weights, rings, (-n, n), strict=True):
                between[n - 1] += np.einsum("pi,ij,pj->p", weight[behind], ring.matrix[tooth], weight)
        slope, offset = contact_terms(pair, path)
        return {
            "compliance": own,
            "neighbour_compliance": between,
            "contact_slope": slope,
            "contact_offset": offset,
        }

    def own_compliance(
        self, pair: GearPair, path: PathPoints, rings: tuple[FlankCompliance, FlankCompliance]
    ) -> tuple[list[np.ndarray], np.ndarray]:
        """Patch weights (position, node) of pinion and wheel, and C (position,) in m2/N, at any positions."""
        depth = pair.pinion.normal_module
        cosine = math.cos(pair.base_helix_angle)
        gears, materials = (pair.pinion, pair.wheel), (pair.pinion_material, pair.wheel_material)
        radii = (path.pinion_radius, path.wheel_radius)
        weights, own = [], np.zeros(len(path.xi))
        for ring, gear, material, radius in zip(rings, gears, materials, radii, strict=True):
            arc = (radius**2 - gear.base_radius**2).clip(0.0) / (2 * gear.base_radius)
            weight, used = ring.patches(arc, self.patch * depth)
            own += np.einsum("pi,ij,pj->p", weight, ring.matrix[0], weight, optimize=True)
            own += 2 / (math.pi * material.plane_strain_modulus * cosine) * np.log(used / depth)
            weights.append(weight)
        return weights, own

    def rings(self, pair: GearPair, reach: int) -> tuple[FlankCompliance, FlankCompliance]:
        """Flank compliances of pinion and wheel."""
        from threadpoolctl import threadpool_limits

        from fem.contact.wheels.ring import flank_compliance
        from fem.gears.sector_mesh import sector_mesh

        out = []
        with threadpool_limits(1):  # small matrices: more threads only add waiting time
            for gear, material in ((pair.pinion, pair.pinion_material), (pair.wheel, pair.wheel_material)):
                mesh = sector_mesh(gear, self.refinement)
                count("gear_meshes")
                out.append(flank_compliance(mesh, material.elastic_modulus, material.poisson_ratio, reach))
        return out[0], out[1]
