"""Compliance of a gear pair between all tooth pairs and slices along the face, at every mesh position.

The face is divided into slices. Slice s of tooth pair p has the line load f over its width w; its free approach is

    x_i = sum_j C_ij F_j + A f_i (B_i - ln f_i),     F_j = w_j f_j,     i, j = (pair, slice),

with A, B of `fem.contact.wheels.hertz_terms`, measured to the depth d. C follows from the rings in
space: G_ij is the displacement of one patch (an ellipse of half-width w_p across, a slice along the face) by a unit
force on another. The section of that mesh is coarse. Its error is corrected in each slice by that in plane deformation,
where a fine mesh is inexpensive,

    C_ij = G_ij + delta_ij (C_fine(xi_i) - G_coarse(xi_i)) / w_i,

C_fine from the model `plane` with its matched Hertz split, G_coarse from plane deformation of the same coarse section
under the same patches. Both agree for a load that hardly changes along the face, and their difference decreases with
refinement of the section. The sum is therefore exact for such loads and converges for all others. The end faces of the
teeth are free. d is at most a fifth of a module: with a larger one the approach of short slices without the Hertz term
would be negative. d is reduced, and C increased accordingly, until C alone is positive definite.

A gear whose body is symmetric about mid face is invariant under half a turn about the radial axis through a tooth
there, which exchanges the flanks and the ends of the face. One tensor is therefore valid for both flanks, with the face
coordinate zeta = sign * hand * y (sign +1 drive, -1 coast; hand +1 right-hand pinion, -1 left-hand), along which xi
increases. It follows the twist of the pinion and is opposite to that of the wheel. An offset web breaks this symmetry:
along zeta it is at the other end for the other flank, which then needs a separate tensor.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from fem.contact.wheels.hertz_terms import contact_terms
from fem.contact.wheels.plane_section import PlaneSection
from fem.contact.wheels.ring import flank_compliance
from fem.contact.wheels.solid_ring import SolidFlank, solid_flank
from fem.contact.wheels.web_place import axial_ends, even_about_mid_face, web_ends
from fem.elements.materials import Material
from fem.elements.twisted_hexahedra import slice_means
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints, path_points
from fem.gears.sector_mesh import sector_mesh
from fem.storage.ledger import count
from fem.storage.records import Record, array, integer, scalar

_DEPTH = 0.2  # largest depth d, in m_n
_MARGIN = 0.2  # smallest eigenvalue of C, in A / width


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactCompliance(Record):
    """Compliances of a pair over one mesh cycle; see the equations above."""

    hand: int = integer()  # +1 right-hand pinion, -1 left-hand
    flank: int = integer()  # valid for: +1 only drive flank, -1 only coast flank, 0 both
    position: np.ndarray = array("cycle", units="1")  # c' on a uniform grid over [0, 1)
    pair: np.ndarray = array("pair", units="1", dtype=int)  # candidate pairs p; xi = c' - p + cycle_shift
    face: np.ndarray = array("slice", units="m")  # zeta, ascending
    slice_width: np.ndarray = array("slice", units="m")
    cycle_shift: np.ndarray = array("slice", units="1")  # zeta tan(beta_b) / p_bt
    compliance: np.ndarray = array("cycle", "pair", "slice", "pair_too", "slice_too", units="m/N")  # C, 0 if gap = inf
    contact_slope: float = scalar(units="m2/N")  # A
    contact_offset: np.ndarray = array("cycle", "pair", "slice", units="1")  # B
    gap: np.ndarray = array("cycle", "pair", "slice", units="m", infinite=True)  # inf: cannot touch
    depth: float = scalar(units="m")  # d


@dataclass(frozen=True, eq=False, kw_only=True)
class _Contacts:
    """All (cycle, pair, slice) that can touch, as flat lists, with their points on the path of contact."""

    cycle: np.ndarray
    pair: np.ndarray
    slice: np.ndarray
    path: PathPoints


def _contacts(
    pair: GearPair, position: np.ndarray, shift: np.ndarray, plane: PlaneSection
) -> tuple[_Contacts, np.ndarray]:
    """The contacts within the range of the model `plane`, and the candidate pair numbers."""
    known = plane.path(pair)
    finite = np.isfinite(known.gap)
    first, last = known.xi[finite][[0, -1]]
    numbers = np.arange(math.ceil(shift.min() - last), math.floor(position[-1] + shift.max() - first) + 1)
    xi = position[:, None, None] - numbers[:, None] + shift
    cycle, which, place = np.nonzero((xi >= first) & (xi <= last))
    path = path_points(pair, xi[cycle, which, place], 1.001 * float(known.gap[finite].max()))
    return _Contacts(cycle=cycle, pair=which, slice=place, path=path), numbers


@dataclass(frozen=True, eq=False, kw_only=True)
class _Body:
    """One ring: its compliance in space, patch weights of the contacts on the kept rows, and plane self-compliance."""

    flank: SolidFlank
    weight: np.ndarray  # (contact, row)
    plane: np.ndarray  # (contact,) m2/N


def _body(
    gear: Gear,
    turn: int,
    material: Material,
    radius: np.ndarray,
    patch: float,
    refinement: float,
    elements: int,
    reach: int,
) -> _Body:
    web = web_ends(gear, turn)
    ends = axial_ends(gear.face_width, elements, web)
    mesh = sector_mesh(gear, refinement)
    count("gear_meshes")
    young, poisson = material.elastic_modulus, material.poisson_ratio
    flat = flank_compliance(mesh, young, poisson, 1)
    arc = (radius**2 - gear.base_radius**2).clip(0.0) / (2 * gear.base_radius)
    weight, _ = flat.patches(arc, patch)
    rows = np.flatnonzero(weight.any(axis=0))
    return _Body(
        flank=solid_flank(mesh, young, poisson, ends, rows, reach, web=web),
        weight=weight[:, rows],
        plane=np.einsum("pi,ij,pj->p", weight, flat.matrix[0], weight, optimize=True),
    )


def _add_ring(out: np.ndarray, at: _Contacts, body: _Body, turn: int) -> None:
    """Add the compliances of one ring to C; turn = 1 for the pinion, -1 for the wheel, whose face coordinate is -zeta.

    Tooth pair p + n, which follows pair p, is tooth -n of the pinion and tooth n of the wheel, counted towards the
    loaded flank.
    """
    ends, rows = body.flank.ends, len(body.flank.rows)
    means = slice_means(ends, np.linspace(ends[0], ends[-1], out.shape[2] + 1))[::turn]
    starts = np.flatnonzero(np.diff(at.cycle * out.shape[1] + at.pair, prepend=-1))
    groups = {(at.cycle[a], at.pair[a]): slice(a, b) for a, b in zip(starts, [*starts[1:], len(at.cycle)], strict=True)}
    moved = np.empty((len(at.cycle), rows, out.shape[2]))  # rows and slices by a contact
    for apart in range(out.shape[1]):  # pair p for loads on pair q = p - apart; the others by symmetry
        matrix = body.flank.matrix[-turn * apart].reshape(rows, len(means[0]), rows, -1)
        by_slice = np.einsum("sa,rabz,tz->srbt", means, matrix, means, optimize=True)
        for place in range(out.shape[2]):
            here = at.slice == place
            moved[here] = np.tensordot(body.weight[here], by_slice[place], 1)
        for (c, number), p in groups.items():
            q = groups.get((c, number - apart))
            if q is None:
                continue
            block = np.einsum("irj,jr->ij", moved[p][:, :, at.slice[q]], body.weight[q])
            here, there = (number, at.slice[p]), (number - apart, at.slice[q])
            out[c, here[0], here[1][:, None], there[0], there[1]] += block
            if apart:
                out[c, there[0], there[1][:, None], here[0], here[1]] += block.T


def contact_compliance(
    pair: GearPair,
    sign: int,
    *,
    slices: int,
    positions: int,
    section_refinement: float,
    axial_elements: int,
    plane: PlaneSection,
    patch: float,
) -> ContactCompliance:
    """The contact compliance of a gear pair.

    Parameters
    ----------
    pair : the gears in mesh
    sign : +1 drive flank, -1 coast flank; `flank` of the record shows whether it is valid for both
    slices : slices of equal width over the face
    positions : grid points per mesh cycle
    section_refinement : of the section mesh of the rings in space, see `fem.gears.sector_mesh.sector_mesh`
    axial_elements : elements along the face, see `axial_ends`
    plane : the model for C_fine, A, B and the range of tip-edge contact
    patch : half-width of the patches on the coarse section, in m_n
    """
    width, module = pair.face_width / slices, pair.pinion.normal_module
    zeta = (np.arange(slices) + 0.5) * width - pair.face_width / 2
    shift = zeta * math.tan(pair.base_helix_angle) / pair.base_pitch
    position = np.arange(positions) / positions
    at, numbers = _contacts(pair, position, shift, plane)
    along = sign * pair.pinion.hand_sign  # zeta along y
    common = (patch * module, section_refinement, axial_elements, len(numbers) - 1)
    with threadpool_limits(1), ThreadPoolExecutor(2) as pool:  # the rings are independent
        bodies = [
            pool.submit(_body, pair.pinion, along, pair.pinion_material, at.path.pinion_radius, *common),
            pool.submit(_body, pair.wheel, -along, pair.wheel_material, at.path.wheel_radius, *common),
        ]
        pinion, wheel = (body.result() for body in bodies)
    out = np.zeros((positions, len(numbers), slices, len(numbers), slices))
    _add_ring(out, at, pinion, 1)
    _add_ring(out, at, wheel, -1)
    slope, offset = contact_terms(pair, at.path)
    _, fine = plane.own_compliance(pair, at.path, plane.rings(pair, 1))
    out[at.cycle, at.pair, at.slice, at.pair, at.slice] += (fine - pinion.plane - wheel.plane) / width
    gap, offsets = np.full(out.shape[:3], np.inf), np.zeros(out.shape[:3])
    gap[at.cycle, at.pair, at.slice] = at.path.gap
    depth = min(_DEPTH, math.exp((_lowest(out, gap) * width / slope - _MARGIN) / 2))
    out[at.cycle, at.pair, at.slice, at.pair, at.slice] -= 2 * slope * math.log(depth) / width
    offsets[at.cycle, at.pair, at.slice] = offset + 2 * math.log(depth)
    return ContactCompliance(
        hand=pair.pinion.hand_sign,
        flank=0 if even_about_mid_face(pair) else sign,
        position=position,
        pair=numbers,
        face=zeta,
        slice_width=np.full(slices, width),
        cycle_shift=shift,
        compliance=out,
        contact_slope=slope,
        contact_offset=offsets,
        gap=gap,
        depth=depth * module,
    )


def _lowest(compliance: np.ndarray, gap: np.ndarray) -> float:
    """Smallest eigenvalue (m/N) over all positions, for the possible contacts."""
    size = gap[0].size
    loaded = np.isfinite(gap).reshape(len(gap), size)
    matrix = compliance.reshape(len(gap), size, size)
    return min(float(np.linalg.eigvalsh(c[np.ix_(m, m)])[0]) for c, m in zip(matrix, loaded, strict=True))
