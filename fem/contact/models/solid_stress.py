"""Displacement and von Mises stress of the loaded teeth at one mesh position, on the hexahedra of the model.

The largest stress of each root is found by `pipelines.runs.root_stress.root_stresses`.

The line loads of `fem.contact.wheels.direct_contact` act on the flank rows with the patches of the compliance. Their
half-width is 0.2 m_n at the default refinement: the subsurface stress of the Hertz contact is not resolved. The ring
gives the motion of the cuts, from which the condensed unknowns of each sector are recovered.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.models.solid import PATCH, SECTION, Solid
from fem.contact.wheels.compliance import ContactCompliance
from fem.contact.wheels.ring import FlankCompliance, SectorReduction
from fem.contact.wheels.solid_ring import load_size, node_frames, reduce_prism, sector_prism
from fem.contact.wheels.web_place import axial_ends, web_ends
from fem.elements.materials import Material
from fem.elements.sections import elasticity, gauss_grid, gauss_line, geometry, lagrange, shape_functions
from fem.elements.twisted_hexahedra import slice_means, strain_matrices
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.path import path_points
from fem.gears.sector_mesh import SectorMesh, sector_mesh
from fem.numerics.quadratic_grids import with_middles

_GAUSS = 1 / np.sqrt(3.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class StressField:
    """A few teeth of one gear, in its own frame: axis z, the tooth of pair 0 on +x, loaded flank at y > 0.

    z of the pinion is along zeta, that of the wheel opposite to it. cells (cell, 8) are linear hexahedra in the order
    of VTK.
    """

    pair: np.ndarray  # (tooth,) numbers of the tooth pairs whose teeth these are
    points: np.ndarray  # (tooth, node, 3), m
    cells: np.ndarray  # (cell, 8) nodes of one tooth
    displacement: np.ndarray  # (tooth, node, 3), m
    von_mises: np.ndarray  # (tooth, node), Pa, mean over the elements at a node
    root: np.ndarray  # nodes of one tooth on the fillet of the loaded side, from its middle to the form circle


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadedTeeth:
    """Stress fields of both gears and their contact state, at the mesh cycle `cycle`."""

    cycle: float
    hand: int  # z of the plot is hand * zeta
    pinion: StressField
    wheel: StressField
    pair: np.ndarray  # (pair,) numbers
    xi: np.ndarray  # (pair, slice), base pitches from the pitch point
    face: np.ndarray  # (slice,) zeta, m
    line_load: np.ndarray  # (pair, slice), N/m
    missing: np.ndarray  # bool (gear, pair): pinion, wheel


def stress_field(
    pair: GearPair, model: Solid, record: ContactCompliance, index: int, line_load: np.ndarray
) -> tuple[StressField, StressField]:
    """Fields of pinion and wheel at one mesh position: the teeth of all candidate pairs with their sectors.

    Both gears are solved again with all factors stored; this takes seconds.

    Parameters
    ----------
    pair, model : the gears in mesh and their model
    record : compliances of this pair by this model
    index, line_load : position, and line loads (pair, slice) there in N/m, of
        `fem.contact.wheels.direct_contact.contact_at`
    """
    turns, place = divmod(index, len(record.position))
    numbers = record.pair + turns
    xi = index / len(record.position) - numbers[:, None] + record.cycle_shift
    loads = np.where(np.isfinite(record.gap[place]), line_load * record.slice_width, 0.0)
    points = path_points(pair, xi.ravel(), 0.4 * pair.pinion.normal_module)
    bounds = np.linspace(-pair.face_width / 2, pair.face_width / 2, model.slices + 1)
    along = pair.pinion.hand_sign * (record.flank or 1)
    out = []
    for gear, material, radius, turn in (
        (pair.pinion, pair.pinion_material, points.pinion_radius, 1),
        (pair.wheel, pair.wheel_material, points.wheel_radius, -1),
    ):
        mesh = sector_mesh(gear, SECTION * model.refinement)
        arc = (radius**2 - gear.base_radius**2).clip(0.0) / (2 * gear.base_radius)
        flank = FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={})
        weight, _ = flank.patches(arc, PATCH / model.refinement * gear.normal_module)
        weight = weight.reshape(*loads.shape, -1)
        web = web_ends(gear, turn * along)
        ends = axial_ends(gear.face_width, model.axial_elements(pair), web)
        nodal = np.einsum("ps,psr,sa->pra", loads, weight, slice_means(ends, bounds)[::turn], optimize=True)
        # pair p + n, which follows, has tooth -n of the pinion and n of the wheel, counted towards the loaded flank
        out.append(_gear_field(gear, material, mesh, ends, web, nodal, -turn * numbers, numbers))
    return out[0], out[1]


def _gear_field(
    gear: Gear,
    material: Material,
    mesh: SectorMesh,
    ends: np.ndarray,
    web: tuple[float, float] | None,
    nodal: np.ndarray,
    teeth: np.ndarray,
    numbers: np.ndarray,
) -> StressField:
    """Field of the teeth (tooth,) under nodal forces (tooth, flank row, axial node)."""
    rows = np.flatnonzero(nodal.any(axis=(0, 2)))
    prism = sector_prism(mesh, material.elastic_modulus, material.poisson_ratio, ends, rows, web=web)
    prism.fronts = []
    sector, unknowns = reduce_prism(mesh, prism, rows)
    forces = nodal[:, rows].reshape(len(teeth), -1)
    cuts = cut_motion(sector, forces, teeth)
    seen = (sector.direct @ forces.T + sector.transfer.T @ cuts) / load_size(mesh, rows, nodal.shape[2])[:, None]
    motion = prism.recover(unknowns, np.vstack([seen, cuts]))
    for nodes in (mesh.cut_low, mesh.cut_high):  # tied nodes follow from their functions
        place, node = np.meshgrid(np.arange(nodal.shape[2]), nodes, indexing="ij")
        for component in range(3):
            tied, columns = prism.ties.rows(node.ravel(), place.ravel(), np.full(node.size, component))
            at = (place.ravel() * len(mesh.points) + node.ravel()) * 3 + component
            motion[at] = tied @ motion[prism.size + columns]
    local = motion[: prism.size].reshape(nodal.shape[2], len(mesh.points), 3, len(teeth))
    local = np.einsum("nij,znjt->tzni", node_frames(mesh), local, optimize=True)  # x, y, z of the rotated section
    z = with_middles(ends)
    angle = 2 * np.pi * teeth[:, None] / mesh.teeth + mesh.twist * z
    turn = np.zeros((*angle.shape, 3, 3))
    turn[..., 0, 0] = turn[..., 1, 1] = np.cos(angle)
    turn[..., 1, 0], turn[..., 0, 1], turn[..., 2, 2] = np.sin(angle), -np.sin(angle), 1.0
    flat = np.concatenate(
        [
            np.broadcast_to(mesh.points, (len(z), *mesh.points.shape)),
            np.broadcast_to(z[:, None, None], (len(z), len(mesh.points), 1)),
        ],
        axis=-1,
    )
    return StressField(
        pair=numbers,
        points=np.einsum("tzij,znj->tzni", turn, flat).reshape(len(teeth), -1, 3),
        cells=_cells(mesh, prism.filled),
        displacement=np.einsum("tzij,tznj->tzni", turn, local).reshape(len(teeth), -1, 3),
        von_mises=_von_mises(mesh, material, ends, prism.filled, local).reshape(len(teeth), -1),
        root=np.add.outer(len(mesh.points) * np.arange(len(z)), mesh.flank[mesh.flank_arc < mesh.form_arc]).ravel(),
    )


def cut_motion(sector: SectorReduction, forces: np.ndarray, teeth: np.ndarray) -> np.ndarray:
    """Unknowns (both cuts, tooth) of the sectors `teeth` for simultaneous `forces` (tooth, load) on these teeth."""
    z, half = sector.teeth, sector.stiffness.shape[0] // 2
    low, high = slice(0, half), slice(half, None)
    s, h = sector.stiffness, sector.transfer
    out = np.zeros((2, half, len(teeth)))
    for k in range(z):
        phase = np.exp(2j * np.pi * k / z)
        matrix = s[low, low] + s[high, high] + s[low, high] * phase + s[high, low] / phase
        load = forces.T @ phase ** (-teeth.astype(float))
        answer = np.linalg.solve(matrix, (h[low] + h[high] / phase) @ load)
        for side in range(2):
            out[side] += (answer[:, None] * phase ** (teeth + side).astype(float)).real / z
    return out.reshape(2 * half, -1)


def _cells(mesh: SectorMesh, filled: np.ndarray) -> np.ndarray:
    """Linear hexahedra (cell, 8): four quadrilaterals per section element, a row per layer of nodes.

    filled : bool (section elements, axial elements)
    """
    grid = mesh.elements.reshape(-1, 3, 3)
    quads = np.concatenate(
        [
            np.stack([grid[:, i, j], grid[:, i + 1, j], grid[:, i + 1, j + 1], grid[:, i, j + 1]], 1)
            for i in (0, 1)
            for j in (0, 1)
        ]
    )
    base = np.arange(2 * filled.shape[1])[:, None, None] * len(mesh.points)
    cells = np.concatenate([quads + base, quads + base + len(mesh.points)], axis=2)
    return cells[np.repeat(np.tile(filled.T, 4), 2, axis=0)]


def _von_mises(
    mesh: SectorMesh, material: Material, ends: np.ndarray, filled: np.ndarray, local: np.ndarray
) -> np.ndarray:
    """Von Mises stress (tooth, axial node, section node) of displacements (tooth, axial node, section node, 3).

    Stresses are taken at the two Gauss points of each direction, where they are most accurate (Barlow, 1976, Int. J.
    Num. Meth. Eng. 10, 243-251), extrapolated linearly to the nodes and averaged there.
    """
    places, gradients, _ = geometry(mesh.points, mesh.elements, 2)
    values, _ = shape_functions(gauss_grid(2)[0])
    across, along = strain_matrices(places, gradients, values, mesh.twist)
    hooke = elasticity(material.elastic_modulus, material.poisson_ratio, 6)
    functions, slopes = lagrange(gauss_line(2)[0])
    end = np.array([[1 - s / _GAUSS, 1 + s / _GAUSS] for s in (-1.0, 0.0, 1.0)]) / 2  # Gauss points -> nodes
    to_nodes = np.einsum("ag,bh->abgh", end, end).reshape(9, 4)
    stress = np.zeros((*local.shape[:3], 6))
    hits = np.zeros(local.shape[1:3])
    for k, length in enumerate(np.diff(ends)):
        layers = slice(2 * k, 2 * k + 3)
        values_here = local[:, layers][:, :, mesh.elements].reshape(len(local), 3, len(mesh.elements), 27)
        at_gauss = np.einsum("gz,eqsd,tzed->tgeqs", functions, across, values_here, optimize=True)
        at_gauss += np.einsum("gz,eqsd,tzed->tgeqs", slopes / length, along, values_here, optimize=True)
        nodal = np.einsum("zg,aq,rs,tgeqs->tzear", end, to_nodes, hooke, at_gauss, optimize=True)
        for layer in range(3):
            for tooth in range(len(local)):
                np.add.at(stress[tooth, 2 * k + layer], mesh.elements[filled[:, k]], nodal[tooth, layer][filled[:, k]])
            np.add.at(hits[2 * k + layer], mesh.elements[filled[:, k]], 1.0)
    xx, yy, zz, yz, xz, xy = np.moveaxis(stress / np.maximum(hits, 1.0)[..., None], -1, 0)
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (yz**2 + xz**2 + xy**2))
