"""Reduction of an imported body to points: RBE2 and RBE3 attachments to lists of nodes, then Craig-Bampton.

With attachment `mean` (RBE3), a point has the rigid motion that fits the translations of its nodes best (least squares
with equal weights), [t, r] = (sum R^T R)^-1 sum R^T u. With `rigid` (RBE2), the nodes move rigidly with the point. A
single node with rotations is the point itself. The ground clamps nodes, or springs hold points.

Reference: MSC Nastran Linear Static Analysis User's Guide, elements RBE2 and RBE3.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.casing.imported.imported_body import ImportedBody, MatrixError
from fem.casing.imported.matrix_checks import rigid_motion
from fem.casing.parts.casing_choices import Attachment
from fem.casing.reduced.attachment import AXES
from fem.casing.reduced.reduction import Interface, Reduction, held_interface, reduce_body

_WELL = 1e10  # largest condition number of the inertia of a point's nodes


@dataclass(frozen=True, kw_only=True)
class Point:
    """A point of a body: its nodes, its position (m; None: the mean of the nodes), and the axes that carry loads."""

    nodes: tuple[int, ...]
    place: tuple[float, float, float] | None = None
    axes: tuple[str, ...] = AXES
    coupling: Attachment = "mean"


@dataclass(frozen=True, eq=False)
class ReducedImportedBody:
    """A reduced imported body: interface rows on the remaining equations q, and u = E q for all equations."""

    body: ImportedBody
    reduction: Reduction
    coordinate_names: tuple[str, ...]  # of the interface
    places: Mapping[str, np.ndarray]  # (3,) m, of the points
    expansion: sp.csr_matrix  # E (n, q)
    springs: np.ndarray  # (interface,) N/m, auxiliary springs for the factorisation
    interface: Interface  # factorised


def reduce_imported_body(
    body: ImportedBody,
    points: Mapping[str, Point],
    *,
    held: Sequence[int] = (),
    sprung: Sequence[str] = (),
    band: float | None,
) -> ReducedImportedBody:
    """Reduce an imported body to its points and all fixed-interface modes up to `band`.

    Parameters
    ----------
    body : with positions of its nodes
    points : by name; they form the interface
    held : numbers of nodes that are clamped to the ground
    sprung : names of points with auxiliary springs for the factorisation; with `held` they must hold the body
    band : Hz; None: static condensation, no modes

    Raises
    ------
    ForeignError : unknown nodes or axes, a point whose nodes do not define its rotation, nodes used twice
    SingularMatrixError : the body is not held
    """
    clamped = np.isin(body.node, np.asarray(held, int)) & (body.axis >= 0)
    for number in held:
        body.place(number)
    expansion, names, rows, places = _coupled(body, points, clamped)
    K, M = (sp.csr_matrix(expansion.T @ A @ expansion) for A in (body.stiffness, body.mass))
    reference = float(np.median(abs(K.diagonal())[K.diagonal() > 0]))
    springs = np.array([reference if name.split(":")[0] in sprung else 0.0 for name in names])
    interface = held_interface(K, rows, penalty=springs if springs.any() else None)
    if band is None:
        reduction = reduce_body(interface, K, M, count=0, enrich=False)
    else:
        reduction = reduce_body(interface, K, M, highest=band)
    return ReducedImportedBody(body, reduction, tuple(names), places, expansion, springs, interface)


def _coupled(
    body: ImportedBody, points: Mapping[str, Point], clamped: np.ndarray
) -> tuple[sp.csr_matrix, list[str], sp.csr_matrix, dict[str, np.ndarray]]:
    """E without clamped equations and with rigid nodes replaced by their points; rows of the interface."""
    taken, places, rigid = clamped.copy(), {}, {}
    for name, point in points.items():
        located = np.array([body.place(number) for number in point.nodes])
        if not len(located):
            raise MatrixError(f"{name} has no nodes; name at least one")
        if not np.isfinite(located).all():
            raise MatrixError(f"{name}: the places of its nodes are not known; give a file of nodes")
        if unknown := [axis for axis in point.axes if axis not in AXES]:
            raise MatrixError(f"{name}: axes has {unknown[0]!r}; choose among {', '.join(AXES)}")
        places[name] = located.mean(axis=0) if point.place is None else np.array(point.place)
        own = np.isin(body.node, point.nodes) & (body.axis >= 0)
        if (own & clamped).any():
            raise MatrixError(f"{name} shares nodes with the ground; choose others for one of the two")
        if point.coupling == "rigid":
            if (own & taken).any():
                raise MatrixError(f"{name} shares nodes with another rigid point; take the mean motion for one of them")
            taken |= own
            rigid[name] = own
    free = np.flatnonzero(~taken)
    led = (sp.csc_array(own[:, None] * rigid_motion(body, places[name])) for name, own in rigid.items())
    expansion = sp.csr_matrix(sp.hstack([sp.eye_array(len(taken), format="csc")[:, free], *led]))
    first = {name: len(free) + 6 * number for number, name in enumerate(rigid)}
    names, rows = [], []
    for name, point in points.items():
        wanted = [AXES.index(axis) for axis in point.axes]
        names += [f"{name}:{AXES[axis]}" for axis in wanted]
        if name in first:
            rows.append(sp.eye_array(expansion.shape[1], format="csr")[[first[name] + axis for axis in wanted]])
        else:
            rows.append(sp.csr_matrix(_mean_rows(body, name, point, places[name])[wanted] @ expansion))
    return expansion, names, sp.csr_matrix(sp.vstack(rows) if rows else (0, expansion.shape[1])), places


def _mean_rows(body: ImportedBody, name: str, point: Point, place: np.ndarray) -> sp.csr_matrix:
    """Rows (6, n) of the mean motion of the nodes of a point."""
    own = np.isin(body.node, point.nodes) & (body.axis >= 0)
    if len(point.nodes) > 1:
        own &= body.axis < 3
    members = np.flatnonzero(own)
    motion = rigid_motion(body, place)[members]
    gram = motion.T @ motion
    wanted = [AXES.index(axis) for axis in point.axes]
    if len(point.nodes) == 1:  # its own motion; axes that it lacks carry no load
        known = sorted({int(axis) for axis in body.axis[members]})
        if missing := [AXES[axis] for axis in wanted if axis not in known]:
            raise MatrixError(
                f"{name}: node {point.nodes[0]} has no {', '.join(missing)}; name more nodes, or fewer axes"
            )
        rows = np.zeros((6, len(members)))
        rows[body.axis[members], np.arange(len(members))] = 1.0
    else:
        size = math.sqrt(max(float(np.trace(gram[3:, 3:]) / gram[0, 0]), 1e-300))
        scale = np.array([1.0, 1.0, 1.0, size, size, size])
        if not np.linalg.cond(gram / np.outer(scale, scale)) < _WELL:
            raise MatrixError(f"{name}: its {len(point.nodes)} nodes lie on a line and define no rotation; name others")
        rows = np.linalg.solve(gram, motion.T)
    at = np.repeat(np.arange(6), len(members)), np.tile(members, 6)
    return sp.csr_matrix((rows.ravel(), at), shape=(6, len(body.node)))
