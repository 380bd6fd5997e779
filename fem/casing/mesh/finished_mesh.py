"""Completion of every casing mesh: conversion to the requested element, check of quality, surface, patches.

scikit-fem numbers the nodes and facets. Named groups of the mesh (physical groups, node sets, faces of the geometry)
are transferred by the corners of their facets.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.casing.mesh.quality import checked_quality
from fem.casing.mesh.sizes import mean_edge
from fem.casing.mesh.surface import Surface
from fem.elements.facets import corner_triangles, outer_facets
from fem.elements.solid_elements import SOLIDS, converted, curved, solid_element, solid_mesh
from fem.numerics.connected_parts import connected_parts
from fem.numerics.message_places import in_mm

_log = logging.getLogger(__name__)

Found = tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]  # triangles (indices) and point (3,) by patch


@dataclass(frozen=True, eq=False, kw_only=True)
class RawMesh:
    """Solid elements (e, k) as generated or read, and groups by name: corners (f, 3 or 4) or nodes (n,)."""

    nodes: np.ndarray  # (n, 3)
    elements: np.ndarray
    facets: Mapping[str, np.ndarray] = field(default_factory=dict)
    node_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    divided: str = ""  # text: elements of a file that were divided into these


def finished_mesh(
    raw: RawMesh,
    find_patches: Callable[[Surface], Found],
    *,
    name: str,
    element: str,
    element_size: float | None,
    remedy: str,
) -> CasingMesh:
    """The record of a mesh, checked and converted to the requested element.

    Parameters
    ----------
    raw : nodes in the frame of the scene, m
    find_patches : finds the triangles of the surface and the reference point of every key point
    name : of the mesh, in messages
    element : one of `fem.elements.solid_elements.SOLIDS`, of the same shape
    element_size : m, as requested; None: the mean edge length
    remedy : remedy for a bad element, in messages

    Raises
    ------
    MeshError : another shape, a bad element (with its position), unconnected parts, two patches that share facets
    """
    nodes, elements = converted(raw.nodes, raw.elements, SOLIDS[element])
    quality = checked_quality(nodes, elements, remedy)
    _check_connected(name, nodes, elements)
    facets = outer_facets(nodes, elements)
    triangles = corner_triangles(facets)
    each = triangles.shape[1]
    groups = {title: np.repeat(inside, each) for title, inside in _facet_groups(raw, facets).items()}
    patches, points = find_patches(Surface(nodes, triangles.reshape(-1, 3), groups))
    owner = np.full(len(facets), -1)
    for index, (patch, chosen) in enumerate(patches.items()):
        members = np.unique(chosen // each)
        if (taken := owner[members] >= 0).any():
            other = list(patches)[int(owner[members][taken][0])]
            raise MeshError(f"{name}: {patch} and {other} share {int(taken.sum())} facets; move one of them")
        owner[members] = index
    _log.info("casing mesh: %d nodes, %d elements (%s)", len(nodes), len(elements), element)
    return CasingMesh(
        nodes=nodes,
        elements=elements,
        facets=facets,
        facet_patch=owner,
        patch_names=tuple(patches),
        patch_points=np.array([points[patch] for patch in patches]),
        element_size=mean_edge(nodes, elements) if element_size is None else element_size,
        quality=quality,
        curved=int(curved(nodes, elements).any()),
        cubic=int(SOLIDS[element].degree == 3),
    )


def _check_connected(name: str, nodes: np.ndarray, elements: np.ndarray) -> None:
    """MeshError if parts of the mesh share no face: a shared edge or vertex acts as a hinge."""
    corners = elements[:, : solid_element(elements).corners]
    mesh = solid_mesh(np.zeros((corners.max() + 1, 3)), corners)
    inner = mesh.f2t[:, mesh.f2t[1] >= 0]
    label = connected_parts(len(corners), inner[0], inner[1])
    parts, sizes = np.unique(label, return_counts=True)
    if len(parts) == 1:
        return
    loose = label == parts[sizes.argmin()]
    shared = np.intersect1d(corners[loose], corners[~loose])
    if len(shared):
        raise MeshError(
            f"{name}: {int(loose.sum())} of {len(elements)} elements share only an edge or a vertex with the others, "
            f"around {in_mm(nodes[shared].mean(axis=0))}, as on a hinge. Let the parts touch with a face, "
            "or leave one out"
        )
    raise MeshError(
        f"{name} falls into {len(parts)} unconnected parts; the smallest has {sizes.min()} of {len(elements)} "
        f"elements around {in_mm(nodes[corners[loose]].mean(axis=(0, 1)))}. Merge coincident nodes, or "
        "remove the loose part"
    )


def _facet_groups(raw: RawMesh, facets: np.ndarray) -> dict[str, np.ndarray]:
    """Groups of a mesh as bool (f,) over the outer facets, whose corners are sorted by node number."""
    kind = solid_element(raw.elements)
    number = np.full(len(raw.nodes), -1, np.int64)
    kept = np.unique(raw.elements[:, : kind.corners])
    number[kept] = np.arange(len(kept))
    corners = np.sort(facets[:, : 3 if kind.corners == 4 else 4], axis=1)
    found = {name: np.asarray(np.isin(corners, number[items]).all(axis=1)) for name, items in raw.node_sets.items()}
    place = {tuple(corner): index for index, corner in enumerate(corners.tolist())} if raw.facets else {}
    for name, items in raw.facets.items():
        found[name] = np.zeros(len(corners), bool)
        wanted = (tuple(corner) for corner in np.sort(number[items], axis=1).tolist())
        found[name][[place[corner] for corner in wanted if corner in place]] = True
    return found
