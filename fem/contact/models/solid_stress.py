"""Stress of loaded teeth on the hexahedra of the model: fields at one mesh position, and root stresses of any load.

`stress_field` gives displacement and von Mises stress of whole teeth at one position. `root_stress` gives the stress of
the fillets by unit forces on the flanks, so that a load distribution of any mesh law costs one product.

The line loads of `fem.contact.wheels.direct_contact` act on the flank rows with the patches of the compliance. Their
half-width is 0.2 m_n at the default refinement: the subsurface stress of the Hertz contact is not resolved. The ring
gives the motion of the cuts, from which the condensed unknowns of each sector are recovered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.models.solid import PATCH, SECTION, Solid
from fem.contact.wheels.compliance import ContactCompliance
from fem.contact.wheels.ring import FlankCompliance, SectorReduction, ring_motion
from fem.contact.wheels.solid_ring import load_size, node_frames, reduce_prism, sector_prism
from fem.contact.wheels.web_place import axial_ends, web_ends
from fem.elements.materials import Material
from fem.elements.nested_condensation import Prism
from fem.elements.sections import elasticity, gauss_grid, gauss_line, geometry, lagrange, shape_functions
from fem.elements.twisted_hexahedra import slice_means, strain_matrices
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.path import path_points
from fem.gears.sector_mesh import SectorMesh, sector_mesh
from fem.numerics.quadratic_grids import with_middles

SMOOTHED = 0.3  # m_n from a contact line, where the stress contains the smoothed contact pressure
SMALLEST = 1e-5  # of the largest singular value: distributions of forces with less effect on the fillets are left out
ROOT_LAYERS = (0.08, 1.5)  # of the body, see `sector_mesh`: as thin as the rows of the fillet above them
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


@dataclass(frozen=True, eq=False, kw_only=True)
class RootStress:
    """Stresses on the fillet of the loaded side of one gear by nodal forces on its flanks.

    Places within 0.3 m_n of a loaded contact in their section are left out, see `SMOOTHED`.
    """

    turn: int  # z of the gear is turn * y of the law
    ends: np.ndarray  # m, z of the axial element ends
    xi: np.ndarray  # (position,) uniform grid on the path of contact
    weight: np.ndarray  # (position, row), nodal forces of unit sum
    distance: np.ndarray  # (position, place), m_n, of the contact from the places on the fillet
    shapes: np.ndarray  # (shape, row and axial node), orthonormal distributions of nodal forces
    stress: np.ndarray  # (shape, pair apart, place, axial node, 3), 1/m2, by them, of `_LoadedSector.surface_stress`

    @property
    def face(self) -> np.ndarray:
        """The y (axial node,) of the law, m."""
        return self.turn * with_middles(self.ends)

    def of(self, law: MeshLaw, cycle: np.ndarray, pairs: np.ndarray, loads: np.ndarray) -> np.ndarray:
        """Largest von Mises stress (position, pair, axial node), Pa, of the fillet of each tooth pair.

        Parameters
        ----------
        law : of the drive flank
        cycle : (position,) mesh cycles
        pairs, loads : (position, pair) successive numbers, and (position, pair, slice) line loads, N/m
        """
        xi = np.clip(cycle[:, None, None] - pairs[..., None] + law.cycle_shift, *self.xi[[0, -1]])
        place = (xi - self.xi[0]) / (self.xi[1] - self.xi[0])
        cell = np.minimum(place.astype(int), len(self.xi) - 2)
        part = (place - cell)[..., None]
        weight, distance = ((1 - part) * one[cell] + part * one[cell + 1] for one in (self.weight, self.distance))
        bounds = np.append(0.0, law.slice_width.cumsum()) - law.slice_width.sum() / 2
        means = slice_means(self.ends, bounds)[:: self.turn]
        shapes = self.shapes.reshape(-1, weight.shape[-1], means.shape[1])
        forces = np.einsum("cps,cpsr,sa,kra->cpk", loads * law.slice_width, weight, means, shapes, optimize=True)
        single = np.tensordot(forces, self.stress, 1)
        total, reach = np.zeros_like(single[:, :, 0]), single.shape[2] // 2
        most = min(reach, pairs.shape[1] - 1)
        for apart in range(-most, most + 1):  # of tooth pair p by the load of p - apart
            seen, by = (slice(max(sign * apart, 0), pairs.shape[1] - max(-sign * apart, 0)) for sign in (1, -1))
            total[:, seen] += single[:, by, apart + reach]
        near = (loads[..., None] > 0.0) & (distance < SMOOTHED)
        smoothed = np.einsum("cpsk,sa->cpka", near, means != 0.0)
        return np.where(smoothed, 0.0, _surface_von_mises(total)).max(axis=2)


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
    out = []
    for gear, material, radius, turn in (
        (pair.pinion, pair.pinion_material, points.pinion_radius, 1),
        (pair.wheel, pair.wheel_material, points.wheel_radius, -1),
    ):
        sector = _LoadedSector.of(pair, model, gear, material, turn, radius, record.flank or 1)
        weight = sector.weight[:, sector.rows].reshape(*loads.shape, -1)
        nodal = np.einsum("ps,psr,sa->pra", loads, weight, slice_means(sector.ends, bounds)[::turn], optimize=True)
        # pair p + n, which follows, has tooth -n of the pinion and n of the wheel, counted towards the loaded flank
        out.append(_gear_field(sector, nodal, -turn * numbers, numbers))
    return out[0], out[1]


def root_stress(pair: GearPair, model: Solid) -> tuple[RootStress, RootStress]:
    """Stresses on the fillets of pinion and wheel by the forces on their flanks, on the mesh of `stress_field`.

    Each gear is solved once for unit forces on all nodes of the loaded flank. This takes seconds.
    """
    path = model.plane.path(pair)
    reach = math.ceil(np.ptp(path.xi) + pair.overlap_ratio) - 1
    out = []
    for gear, material, radius, turn in (
        (pair.pinion, pair.pinion_material, path.pinion_radius, 1),
        (pair.wheel, pair.wheel_material, path.wheel_radius, -1),
    ):
        sector = _LoadedSector.of(pair, model, gear, material, turn, radius)
        mesh, side = sector.mesh, sector.mesh.fillet[2:-1]
        contact = np.stack([np.interp(sector.arc, mesh.flank_arc, one) for one in mesh.points[mesh.flank].T], axis=1)
        found = {}
        for tooth, cuts in ring_motion(sector.reduction, reach).items():
            seen = sector.reduction.transfer.T @ cuts + (sector.reduction.direct if tooth == 0 else 0.0)
            found[-turn * tooth] = sector.surface_stress(sector.motion(seen, cuts)).swapaxes(1, 2)
        by_node = np.stack([found[apart] for apart in range(-reach, reach + 1)], axis=1)
        shapes, size, stress = np.linalg.svd(by_node.reshape(len(by_node), -1), full_matrices=False)
        kept = size > SMALLEST * size[0]
        out.append(
            RootStress(
                turn=turn * pair.pinion.hand_sign,
                ends=sector.ends,
                xi=path.xi,
                weight=sector.weight[:, sector.rows],
                distance=np.linalg.norm(contact[:, None] - mesh.points[side], axis=2) / gear.normal_module,
                shapes=shapes[:, kept].T,
                stress=(size[:, None] * stress)[kept].reshape(-1, *by_node.shape[1:]),
            )
        )
    return out[0], out[1]


@dataclass(frozen=True, eq=False, kw_only=True)
class _LoadedSector:
    """The sector of one tooth, condensed to the rows of its flank that contacts load and to its cuts."""

    mesh: SectorMesh
    material: Material
    ends: np.ndarray  # of the axial elements
    arc: np.ndarray  # (contact,) m, along the involute from its base circle
    weight: np.ndarray  # (contact, flank row), nodal forces of unit sum
    rows: np.ndarray  # that are loaded
    prism: Prism
    reduction: SectorReduction
    unknowns: np.ndarray

    @staticmethod
    def of(
        pair: GearPair, model: Solid, gear: Gear, material: Material, turn: int, radius: np.ndarray, flank: int = 1
    ) -> _LoadedSector:
        """Condense the sector; `radius` (contact,) m, `turn` 1 of the pinion and -1 of the wheel."""
        mesh = sector_mesh(gear, SECTION * model.refinement, layers=ROOT_LAYERS)
        arc = (radius**2 - gear.base_radius**2).clip(0.0) / (2 * gear.base_radius)
        patches = FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={}).patches
        weight, _ = patches(arc, PATCH / model.refinement * gear.normal_module)
        rows = np.flatnonzero(weight.any(axis=0))
        web = web_ends(gear, turn * pair.pinion.hand_sign * flank)
        ends = axial_ends(gear.face_width, model.axial_elements(pair), web)
        prism = sector_prism(mesh, material.elastic_modulus, material.poisson_ratio, ends, rows, web=web)
        prism.fronts = []
        reduction, unknowns = reduce_prism(mesh, prism, rows)
        return _LoadedSector(
            mesh=mesh,
            material=material,
            ends=ends,
            arc=arc,
            weight=weight,
            rows=rows,
            prism=prism,
            reduction=reduction,
            unknowns=unknowns,
        )

    def motion(self, seen: np.ndarray, cuts: np.ndarray) -> np.ndarray:
        """Displacement (column, axial node, section node, 3) in x, y, z of the rotated section.

        Parameters
        ----------
        seen, cuts : (load, column) displacement along the loads, and (both cuts, column)
        """
        mesh, prism, layers = self.mesh, self.prism, 2 * len(self.ends) - 1
        size = load_size(mesh, self.rows, layers)[:, None]
        motion = prism.recover(self.unknowns, np.vstack([seen / size, cuts]))
        for nodes in (mesh.cut_low, mesh.cut_high):  # tied nodes follow from their functions
            place, node = np.meshgrid(np.arange(layers), nodes, indexing="ij")
            for component in range(3):
                tied, columns = prism.ties.rows(node.ravel(), place.ravel(), np.full(node.size, component))
                at = (place.ravel() * len(mesh.points) + node.ravel()) * 3 + component
                motion[at] = tied @ motion[prism.size + columns]
        local = motion[: prism.size].reshape(layers, len(mesh.points), 3, -1)
        return np.einsum("nij,znjt->tzni", node_frames(mesh), local, optimize=True)

    def surface_stress(self, local: np.ndarray) -> np.ndarray:
        """Stress (column, axial node, place, 3) of the fillet surface: along the section, across it, and shear.

        A surface without traction is in plane stress, so that its displacement alone gives the stress. An extrapolation
        of stresses along its normal, in which they fall within a fraction of the fillet radius, is thus not needed.
        Gradients are taken at the two Gauss points of each edge, where they are most accurate (Barlow, 1976, Int. J.
        Num. Meth. Eng. 10, 243-251), extrapolated linearly along the surface to the nodes and averaged there.

        Parameters
        ----------
        local : (column, axial node, section node, 3) m, of `motion`
        """
        mesh = self.mesh
        values, slopes, to_nodes = _line(len(mesh.fillet) // 2)
        place, tangent = values @ mesh.points[mesh.fillet], slopes @ mesh.points[mesh.fillet]
        length = np.linalg.norm(tangent, axis=1)[:, None]
        first = np.pad(tangent / length, ((0, 0), (0, 1)))
        helix = np.column_stack([mesh.twist * place @ [[0, 1], [-1, 0]], np.ones(len(place))])
        along = (helix * first).sum(axis=1)[:, None]
        size = np.linalg.norm(helix - along * first, axis=1)[:, None]
        second = (helix - along * first) / size

        def terms(functions: np.ndarray, vector: np.ndarray) -> np.ndarray:
            return functions[:, :, None] * vector[:, None]

        d_first, axial = slopes / length, values / size
        d_second, turn = -along / size * d_first, mesh.twist * np.array([[0, -1, 0], [1, 0, 0], [0, 0, 0]])
        shear = terms(d_first, second) + terms(d_second, first) + terms(axial, first @ turn)
        strain = [  # both strains and the shear, of axial functions and of their derivatives
            [terms(d_first, first), terms(d_second, second) + terms(axial, second @ turn), shear],
            [np.zeros(shear.shape), terms(axial, second), terms(axial, first)],
        ]
        nu = self.material.poisson_ratio
        hooke = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) * self.material.elastic_modulus / (1 - nu**2)
        section = np.einsum("nq,rs,asqid->anrid", to_nodes[2:-1], hooke, strain, optimize=True)
        values, slopes, to_nodes = _line(len(self.ends) - 1)
        face = to_nodes @ np.array([values, slopes / np.repeat(np.diff(self.ends), 2)[:, None]])
        return np.asarray(np.einsum("azy,anrid,tyid->tznr", face, section, local[:, :, mesh.fillet], optimize=True))

    def stress(self, local: np.ndarray) -> np.ndarray:
        """Stress (column, axial node, section node, 6) of displacements, mean over the elements at a node.

        Stresses are taken at the two Gauss points of each direction, extrapolated linearly to the nodes and averaged
        there. `surface_stress` is more accurate at the fillet.

        Parameters
        ----------
        local : (column, axial node, section node, 3) m, of `motion`
        """
        mesh, filled, elements = self.mesh, self.prism.filled, self.mesh.elements
        places, gradients, _ = geometry(mesh.points, elements, 2)
        values, _ = shape_functions(gauss_grid(2)[0])
        across, along = strain_matrices(places, gradients, values, mesh.twist)
        hooke = elasticity(self.material.elastic_modulus, self.material.poisson_ratio, 6)
        functions, slopes, end = _line(1)
        to_nodes = np.einsum("ag,bh->abgh", end, end).reshape(9, 4)
        stress = np.zeros((*local.shape[:3], 6))
        hits = np.zeros(local.shape[1:3])
        for k, length in enumerate(np.diff(self.ends)):
            values_here = local[:, 2 * k : 2 * k + 3, elements].reshape(len(local), 3, len(elements), 27)
            at_gauss = np.einsum("gz,eqsd,tzed->tgeqs", functions, across, values_here, optimize=True)
            at_gauss += np.einsum("gz,eqsd,tzed->tgeqs", slopes / length, along, values_here, optimize=True)
            nodal = np.einsum("zg,aq,rs,tgeqs->zeatr", end, to_nodes, hooke, at_gauss, optimize=True)
            own = elements[filled[:, k]]
            for layer in range(3):
                np.add.at(stress[:, 2 * k + layer].swapaxes(0, 1), own, nodal[layer, filled[:, k]])
                np.add.at(hits[2 * k + layer], own, 1.0)
        return stress / np.maximum(hits, 1.0)[..., None]


def _line(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quadratic functions of `count` elements at their two Gauss points (point, node), their slopes, and nodal means.

    The last (node, point) extrapolate linearly from the Gauss points of an element; slopes are those of a unit element.
    """
    one = [*lagrange(gauss_line(2)[0]), np.array([[1 - s / _GAUSS, 1 + s / _GAUSS] for s in (-1.0, 0.0, 1.0)]).T / 2]
    values, slopes, ends = np.zeros((3, 2 * count, 2 * count + 1))
    for k in range(count):
        for whole, part in zip((values, slopes, ends), one, strict=True):
            whole[2 * k : 2 * k + 2, 2 * k : 2 * k + 3] += part
    return values, slopes, ends.T / ends.sum(axis=0)[:, None]


def _gear_field(sector: _LoadedSector, nodal: np.ndarray, teeth: np.ndarray, numbers: np.ndarray) -> StressField:
    """Field of the teeth (tooth,) under nodal forces (tooth, loaded row, axial node)."""
    mesh, reduction = sector.mesh, sector.reduction
    forces = nodal.reshape(len(teeth), -1)
    by_load = ring_motion(reduction, int(np.ptp(teeth)))
    cuts = np.stack([sum(by_load[n - m] @ f for m, f in zip(teeth, forces, strict=True)) for n in teeth], axis=1)
    local = sector.motion(reduction.direct @ forces.T + reduction.transfer.T @ cuts, cuts)
    z = with_middles(sector.ends)
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
    von_mises = _von_mises(sector.stress(local))
    von_mises[:, :, mesh.fillet[2:-1]] = _surface_von_mises(sector.surface_stress(local))
    return StressField(
        pair=numbers,
        points=np.einsum("tzij,znj->tzni", turn, flat).reshape(len(teeth), -1, 3),
        cells=_cells(mesh, sector.prism.filled),
        displacement=np.einsum("tzij,tznj->tzni", turn, local).reshape(len(teeth), -1, 3),
        von_mises=von_mises.reshape(len(teeth), -1),
        root=np.add.outer(len(mesh.points) * np.arange(len(z)), mesh.fillet[2:-1]).ravel(),
    )


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


def _von_mises(stress: np.ndarray) -> np.ndarray:
    """Von Mises stress (...) of stresses (..., 6)."""
    xx, yy, zz, yz, xz, xy = np.moveaxis(stress, -1, 0)
    return np.asarray(np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (yz**2 + xz**2 + xy**2)))


def _surface_von_mises(stress: np.ndarray) -> np.ndarray:
    """Von Mises stress (...) of plane stresses (..., 3)."""
    one, two, shear = np.moveaxis(stress, -1, 0)
    return np.asarray(np.sqrt(one**2 - one * two + two**2 + 3 * shear**2))
