"""A meshed casing with attached points and its ground: matrices and constraint modes for the reduction.

Ground. `fixed` clamps every node under the feet. `springs` leaves the body free: the mean motion (ux, uy, uz) of every
foot becomes an interface, to which mount springs are added later without finite elements. Only the factorisation uses
reference springs D under the feet; the reduced matrices do not contain them.

Attachment of points to their patches: `mean` (RBE3) adds no stiffness. `rigid` (RBE2) makes the patch move as a rigid
body, like a stiff outer ring pressed into its seat: u = E [other unknowns, six per patch], K -> E^T K E.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.casing.enrichment.added_unknowns import KINDS_APART, AddedUnknowns, added_functions
from fem.casing.geometry.dimensions import Sensor
from fem.casing.mesh.mesh import CasingMesh
from fem.casing.parts.bolted_joint import BoltedJoint, joint_stiffness
from fem.casing.parts.casing_choices import FEWEST_MOUNTS, JOINTS, Attachment, Ground, few_feet
from fem.casing.parts.regions import Region, elements_inside
from fem.casing.parts.split_mesh import split_mesh
from fem.casing.reduced.attachment import AXES, AttachmentError, mean_motion_rows, nearest_surface_point
from fem.casing.reduced.halves import Subspace, projected, subspaces_of, together
from fem.casing.reduced.reduced_body import BEARING_AXES
from fem.casing.reduced.reduction import largest_entry
from fem.elements.materials import Material
from fem.elements.solids import mass_properties, rigid_body_modes
from fem.numerics.memory import give_back
from fem.numerics.unknowns import unknowns_of

GROUND_AXES = ("ux", "uy", "uz")


@dataclass(frozen=True, kw_only=True)
class ForcedPoint:
    """A sensor's point loaded by external forces along some of its ``axes`` (ux, uy, uz)."""

    sensor: Sensor
    axes: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class AssembledCasing:
    """Matrices of the unknowns q after clamping and rigid patches, u = E q, and the rows of the interface."""

    mesh: CasingMesh
    material: Material
    ground: Ground
    attachment: Attachment
    subspaces: tuple[Subspace, ...]  # all motions q, or the two halves of a casing with a mirror plane
    expansion: sp.csr_matrix  # E (u, n); u: 3 node + axis, then added unknowns
    K_clamped: sp.csr_matrix  # (clamped, u), rows of the stiffness of the free body
    rigid: np.ndarray  # R (u, 6), unit translations and rotations about the centre of gravity; 0 in added unknowns
    inertial: np.ndarray  # M R (u, 6)
    free_body: Mapping[str, float]  # items of `fem.casing.reduced.checkup.CheckUp` from the matrices of the free body
    clamped: np.ndarray  # of the unknowns; empty on springs
    added: AddedUnknowns
    coordinate_names: tuple[str, ...]  # of the interface, "ground_1:ux", ..., "bearing_1:ux", ...
    rows: sp.csr_matrix  # of the interface (interface, n)
    springs: np.ndarray  # (interface,), reference springs D, N/m; zero except at feet on springs
    parts: Mapping[str, sp.csr_matrix]  # contributions of parts to K_free (n, n), by their names

    @property
    def unknowns(self) -> int:
        """n, number of the unknowns q."""
        return int(self.expansion.shape[1])

    @property
    def K_free(self) -> sp.csr_matrix:
        """Stiffness E^T K E (n, n) without the reference springs; only products with it if the casing is divided."""
        return together([(one.motions, one.K) for one in self.subspaces])

    @property
    def M_free(self) -> sp.csr_matrix:
        """Mass E^T M E (n, n), likewise."""
        return together([(one.motions, one.M) for one in self.subspaces])

    @property
    def mass_properties(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Mass (kg), centre of gravity (3,) in m and inertia tensor (3, 3) about it in kg m2."""
        return mass_properties(self.mesh.nodes, self.mesh.elements, self.material.density)

    @property
    def foot_motions(self) -> np.ndarray:
        """The rigid motions of single feet (u, 6 feet), zero elsewhere."""
        feet = self.mesh.patches("ground_")
        motion = np.zeros((len(self.rigid), 6 * len(feet)))
        for index, name in enumerate(feet):
            unknowns = unknowns_of(np.unique(self.mesh.patch(name)))
            motion[unknowns, 6 * index : 6 * index + 6] = self.rigid[unknowns]
        return motion

    @property
    def loads(self) -> sp.csr_matrix:
        """Forces (n, l) of unit motions of the ground, and last of unit gravity along x, y, z; for the check-up.

        The ground moves six ways at every clamped foot, or three ways under every spring.
        """
        E = self.expansion
        if self.ground == "fixed":
            ground = E.T @ (self.K_clamped.T @ sp.csr_matrix(self.foot_motions[self.clamped]))
        else:
            ground = self.rows.T @ sp.diags_array(self.springs, format="csr")[:, self.springs > 0.0]
        return sp.csr_matrix(sp.hstack([ground, E.T @ self.inertial[:, :3]]))

    def expanded(self, q: np.ndarray) -> np.ndarray:
        """Displacements (3 node, k) of the mesh."""
        return self.expansion[: 3 * len(self.mesh.nodes)] @ q

    @property
    def cubic(self) -> np.ndarray:
        """Whether an unknown q (n,) is a cubic displacement of an element."""
        nodal = np.zeros(self.unknowns - len(self.added.numbers), bool)
        return np.append(nodal, self.added.numbers < KINDS_APART)

    def quadratic(self) -> AssembledCasing:
        """The same casing without the cubic displacements of its elements, which are hierarchical."""
        cubic = self.cubic
        return replace(
            self,
            mesh=replace(self.mesh, cubic=0),
            subspaces=tuple(one.without(cubic) for one in self.subspaces),
            expansion=sp.csr_matrix(self.expansion[:, ~cubic]),
            rows=sp.csr_matrix(self.rows[:, ~cubic]),
            parts={},
        )


def assembled_casing(
    mesh: CasingMesh,
    material: Material,
    *,
    interfaces: Mapping[str, Sequence[str]] | None = None,
    forced: Sequence[ForcedPoint] = (),
    ground: Ground = "fixed",
    attachment: Attachment = "mean",
    regions: Sequence[Region] = (),
    joint: BoltedJoint | None = None,
    divided: bool = False,
) -> AssembledCasing:
    """Assemble a casing, clamp or free the feet, and attach the points.

    Parameters
    ----------
    mesh, material : of the casing
    interfaces : bearing patches that carry loads with the axes they carry; all with `BEARING_AXES` by default
    forced : surface points with external forces, part of the interface
    ground : "fixed" clamps the feet, "springs" leaves them free; reference springs hold them in the factorisation
    attachment : a point has the "mean" motion of its patch, or the patch is "rigid"
    regions : parts of the housing whose stiffness is stored separately
    joint : bolts between two halves; None: one body
    divided : keep only the matrices of both halves if the casing has a mirror plane

    Raises
    ------
    AttachmentError : no ground patch, fewer than `FEWEST_MOUNTS` on springs, an interface that touches the clamped
        nodes, rigid patches that share nodes
    MeshError : unknown patch, an empty region or one that shares elements, a joint that does not fit the mesh
    """
    joined: tuple[np.ndarray, ...] = ()
    bolts = None
    if joint is not None:
        split = split_mesh(mesh, joint.plane)
        mesh, joined, bolts = split.mesh, (split.below, split.above), joint_stiffness(joint, split, material)
    points, clamped_nodes = _supported(mesh, interfaces, ground)
    added = added_functions(
        mesh,
        material,
        held=mesh.patches("ground_") if ground == "fixed" else (),
        rigid=points if attachment == "rigid" else (),
        joined=joined,
    )
    K, M = added.matrices()
    parts = _parts(mesh, regions, added)
    if bolts is not None:
        bolts.resize(K.shape)
        K, parts[JOINTS] = sp.csr_matrix(K + bolts), bolts
    expansion, rows, names = _tied(mesh, points, forced, attachment, clamped_nodes, len(added))
    parts = {name: projected(part, expansion) for name, part in parts.items()}
    give_back()
    reference = material.elastic_modulus * mesh.element_size
    springs = np.array([reference if name.startswith("ground_") else 0.0 for name in names])
    clamped = unknowns_of(clamped_nodes)
    return AssembledCasing(
        mesh=mesh,
        material=material,
        ground=ground,
        attachment=attachment,
        subspaces=subspaces_of(
            added if divided and attachment == "mean" else None,
            K,
            M,
            rows,
            expansion=expansion,
            penalty=springs if ground == "springs" else None,
        ),
        expansion=expansion,
        K_clamped=K[clamped],
        clamped=clamped,
        added=added,
        coordinate_names=names,
        rows=rows,
        springs=springs,
        parts=parts,
        **_of_free_body(mesh, material, K, M),
    )


def _supported(
    mesh: CasingMesh, interfaces: Mapping[str, Sequence[str]] | None, ground: Ground
) -> tuple[dict[str, Sequence[str]], np.ndarray]:
    """Attached patches with the axes of their points, and the clamped nodes; raises as `assembled_casing`."""
    feet = mesh.patches("ground_")
    if not feet:
        raise AttachmentError("casing mesh has no patch ground_1, ...; name at least one foot")
    if ground == "springs" and len(feet) < FEWEST_MOUNTS:
        raise AttachmentError(few_feet(len(feet)))
    points = dict(dict.fromkeys(mesh.patches("bearing_"), BEARING_AXES) if interfaces is None else interfaces)
    held = np.unique(mesh.facets_of(feet))
    for name in points:
        if np.isin(mesh.patch(name), held).any():
            raise AttachmentError(f"{name} shares nodes with a foot; move the foot or the bore")
    if ground == "springs":
        return {**dict.fromkeys(feet, GROUND_AXES), **points}, held[:0]
    return points, held


def _of_free_body(mesh: CasingMesh, material: Material, K: sp.csr_matrix, M: sp.csr_matrix) -> dict[str, Any]:
    """Fields of `AssembledCasing` from the rigid motions of the free body."""
    centre = mass_properties(mesh.nodes, mesh.elements, material.density)[1]
    R = np.zeros((K.shape[0], 6))
    R[: 3 * len(mesh.nodes)] = rigid_body_modes(mesh.nodes, centre)
    grounding = float(abs(K @ R).max() / (largest_entry(K) * abs(R).max()))
    items = {"stiffness_asymmetry": asymmetry(K), "mass_asymmetry": asymmetry(M), "grounding": grounding}
    return {"rigid": R, "inertial": M @ R, "free_body": items}


def asymmetry(matrix: sp.csr_matrix) -> float:
    """Asymmetry from one product with a random sign vector, in which differences do not cancel."""
    signs = np.random.default_rng(0).choice([-1.0, 1.0], matrix.shape[0])
    return float(abs(matrix @ signs - matrix.T @ signs).max(initial=0.0) / largest_entry(matrix))


def _tied(
    mesh: CasingMesh,
    points: Mapping[str, Sequence[str]],
    forced: Sequence[ForcedPoint],
    attachment: Attachment,
    clamped: np.ndarray,
    added: int,
) -> tuple[sp.csr_matrix, sp.csr_matrix, tuple[str, ...]]:
    """E, rows of the interface and their names, with the added unknowns after those of the nodes."""
    expansion, rows = (_rigid_patches if attachment == "rigid" else _mean_patches)(mesh, points, clamped)
    rows = sp.csr_matrix(sp.vstack([rows, *(point_rows(mesh, point) @ expansion for point in forced)]))
    names = [f"{name}:{axis}" for name, axes in points.items() for axis in axes]
    names += [f"{point.sensor.name}:{axis}" for point in forced for axis in point.axes]
    expansion = sp.csr_matrix(sp.block_diag([expansion, sp.eye_array(added)]))
    return expansion, sp.csr_matrix(sp.hstack([rows, sp.csr_matrix((rows.shape[0], added))])), tuple(names)


def _parts(mesh: CasingMesh, regions: Sequence[Region], added: AddedUnknowns) -> dict[str, sp.csr_matrix]:
    """Stiffness (u, u) of the elements of every region by its name."""
    inside = elements_inside(mesh.nodes, mesh.elements, regions)
    return {region.name: added.matrices(chosen)[0] for region, chosen in zip(regions, inside, strict=True)}


def point_rows(mesh: CasingMesh, point: ForcedPoint) -> sp.csr_matrix:
    """Rows (axis, 3 node) of the displacements of a surface point along its axes."""
    corners, weights, _ = nearest_surface_point(mesh.nodes, mesh.facets, np.array(point.sensor.position))
    directions = np.array(point.sensor.axes, float)[[GROUND_AXES.index(axis) for axis in point.axes]]
    rows = np.zeros((len(directions), 3 * len(mesh.nodes)))
    rows[:, unknowns_of(corners)] = (directions[:, None, :] * weights[:, None]).reshape(len(directions), -1)
    return sp.csr_matrix(rows)


def _mean_patches(
    mesh: CasingMesh, points: Mapping[str, Sequence[str]], clamped: np.ndarray
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """E without the clamped nodes; rows of the mean motions."""
    free = unknowns_of(np.setdiff1d(np.arange(len(mesh.nodes)), clamped))
    n = 3 * len(mesh.nodes)
    expansion = sp.csr_matrix((np.ones(len(free)), (free, np.arange(len(free)))), shape=(n, len(free)))
    rows = [
        mean_motion_rows(mesh.nodes, mesh.patch(name), mesh.point(name))[[AXES.index(axis) for axis in axes]]
        for name, axes in points.items()
    ]
    return expansion, sp.csr_matrix(sp.vstack(rows)[:, free] if rows else (0, len(free)))


def _rigid_patches(
    mesh: CasingMesh, points: Mapping[str, Sequence[str]], clamped: np.ndarray
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """E replaces the nodes of every patch by six motions of its point; unit rows of the interface axes."""
    owner = np.full(len(mesh.nodes), -1)
    owner[clamped] = len(points)
    for number, name in enumerate(points):
        nodes = np.unique(mesh.patch(name))
        if (taken := owner[nodes] >= 0).any():
            other = list(points)[int(owner[nodes][taken][0])]
            raise AttachmentError(f"{name} and {other} share nodes and cannot both be rigid; take attachment 'mean'")
        owner[nodes] = number
    free = unknowns_of(np.flatnonzero(owner < 0))
    blocks = [sp.eye_array(3 * len(mesh.nodes), format="csc")[:, free]]
    for number, name in enumerate(points):
        led = np.repeat(owner == number, 3)[:, None]
        blocks.append(sp.csc_array(led * rigid_body_modes(mesh.nodes, mesh.point(name))))
    expansion = sp.csr_matrix(sp.hstack(blocks))
    first = {name: len(free) + 6 * number for number, name in enumerate(points)}
    interface = [first[name] + AXES.index(axis) for name, axes in points.items() for axis in axes]
    return expansion, sp.csr_matrix(sp.eye_array(expansion.shape[1], format="csr")[np.array(interface, int)])
