"""Unknowns added at singular edges: their functions in a hexahedron, their stiffness and mass.

The displacement in an element at an edge becomes

    u = sum_a N_a u_a + sum_ik N_i(s) R_i phi_ik(xi, eta) b_ik,

N_a the functions of the element (including cubic ones where it has them), N_i the quadratic functions of the three
nodes along the side, R_i the frame at such a node, phi_ik its functions across the edge. As these vanish at all nodes,
u_a remains the displacement there. One unknown b_ik is added for every function of a node on an edge. Where a chain
ends within the body, the functions of its last node continue into the elements beyond it and decay there. If they would
meet elements outside the chain, that node gets no functions.

References: Szabo & Babuska (1991), Finite Element Analysis, section 10.1; Strouboulis, Copps & Babuska (2001), Comput.
Methods Appl. Mech. Eng. 190(32-33), 4081-4193 (handbook functions, found numerically, in finite elements).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.sparse as sp

from fem.casing.enrichment.enrichment_functions import ALONG, profiles
from fem.casing.enrichment.enrichment_integrals import added_entries
from fem.casing.enrichment.graded_functions import GRID, gauss, graded
from fem.casing.enrichment.singular_edges import Fan, chains, continuation
from fem.casing.enrichment.topology import Sector, Topology
from fem.casing.mesh.mesh import CasingMesh
from fem.elements.cubic import CubicFunctions
from fem.elements.cubic_shapes import element_shapes
from fem.elements.materials import Material
from fem.elements.sections import lagrange
from fem.elements.solid_elements import SOLIDS, solid_element
from fem.elements.solids import lame
from fem.numerics.side_by_side import side_by_side


@dataclass(frozen=True, eq=False)
class _Part:
    """The functions of one node on an edge in one element."""

    sector: Sector
    line: int  # 0, 1, 2: the node at s = 0, 1/2, 1
    values: np.ndarray  # (function, 3, k, k)
    frame: np.ndarray  # (3, 3)
    first: int  # number of its first unknown


@dataclass(frozen=True, eq=False)
class EdgeFunctions:
    """The unknowns of all nodes on edges, and the elements in which their functions are not zero."""

    numbers: np.ndarray  # (m,), of each unknown among those at the same position
    places: np.ndarray  # (m, 3), m, see `_between`
    mesh: CasingMesh
    material: Material
    cubic: CubicFunctions | None  # of the same mesh, whose unknowns come before these
    parts: dict[int, list[_Part]]  # by element

    def __len__(self) -> int:
        return len(self.numbers)

    def matrices(self, elements: Collection[int] | None = None) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Rows (m, k + m) of stiffness (N/m) and mass (kg), k other unknowns before these.

        Parameters
        ----------
        elements : numbers of the elements that contribute; all by default
        """
        chosen = self.parts if elements is None else {one: self.parts[one] for one in elements if one in self.parts}
        same: dict[bytes, list[int]] = defaultdict(list)
        for element, own in chosen.items():
            same[_shape_key(self.mesh.nodes[self.mesh.elements[element]], own)].append(element)
        alike = sorted(same.values(), key=lambda members: self._graded_sides(members[0]).tobytes())
        before = 3 * len(self.mesh.nodes) + (0 if self.cubic is None else len(self.cubic))
        rows: list[np.ndarray] = []
        columns: list[np.ndarray] = []
        stiffness: list[np.ndarray] = []
        mass: list[np.ndarray] = []
        first, other = side_by_side(lambda: self._several(alike[::2]), lambda: self._several(alike[1::2]))
        for members, found in zip([*alike[::2], *alike[1::2]], first + other, strict=True):
            K_element, K_own, M_element, M_own = found
            for element in members:
                added = _unknowns(self.parts[element])
                at, sign = self._of_element(element)
                moving = np.flatnonzero(at.ravel() >= 0)
                touched = np.concatenate([at.ravel()[moving], before + added])
                rows.append(np.repeat(added, len(touched)))
                columns.append(np.tile(touched, len(added)))
                for entries, across, among in ((stiffness, K_element, K_own), (mass, M_element, M_own)):
                    coupled = (across * sign).reshape(len(added), -1)[:, moving]
                    entries.append(np.hstack([coupled, among]).ravel())
        shape = (len(self), before + len(self))
        if not rows:
            return sp.csr_matrix(shape), sp.csr_matrix(shape)
        place = (np.concatenate(rows), np.concatenate(columns))
        K = sp.csr_matrix((np.concatenate(stiffness), place), shape=shape)
        return K, sp.csr_matrix((self.material.density * np.concatenate(mass), place), shape=shape)

    def _of_element(self, element: int) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (3, a) of its unknowns along x, y, z, -1 where held, and signs (a,) of its functions."""
        at = 3 * self.mesh.elements[element].astype(np.int64) + np.arange(3)[:, None]
        if self.cubic is None:
            return at, np.ones(at.shape[1])
        one = np.array([element])
        return np.hstack([at, self.cubic.unknowns(one)[0]]), np.append(np.ones(at.shape[1]), self.cubic.signs(one)[0])

    def _several(self, alike: list[list[int]]) -> list[tuple[np.ndarray, ...]]:
        """Results of `added_entries` for the first element of every group; tables are kept for equal graded sides."""
        tables: dict[tuple[int, bytes], np.ndarray] = {}
        return [self._entries(members[0], tables) for members in alike]

    def _graded_sides(self, element: int) -> np.ndarray:
        """Bool (3, 2): the low and high sides of an element along its axes that have functions."""
        ends = np.zeros((3, 2), bool)
        for part in self.parts[element]:
            ends[part.sector.axis(0, 0)] = ends[part.sector.axis(1, 0)] = True
        return ends

    def _entries(self, element: int, known: dict[tuple[int, bytes], np.ndarray]) -> tuple[np.ndarray, ...]:
        own, kind, ends = self.parts[element], self.mesh.element.name, self._graded_sides(element)
        if not all(key[1].startswith(ends.tobytes()) for key in known):
            known.clear()
        points, weights, values, slopes = _rule(kind, ends.tobytes())
        tables, lines, owners = [], [], []
        for number, part in enumerate(own):
            turned = (ends.tobytes(), part.sector.origin.tobytes(), part.sector.axes.tobytes())
            key = (id(part.values), b"".join(turned))
            if key not in known:
                known[key] = _table(part, points)
            tables.append(known[key])
            owners += [number] * len(part.values)
            lines.append(_along(kind, *turned)[part.line])
        found: tuple[np.ndarray, ...] = added_entries(
            self.mesh.nodes[self.mesh.elements[element]],
            values=values,
            slopes=slopes,
            weights=weights,
            tables=np.concatenate(tables),
            lines=np.array(lines),
            owners=np.array(owners),
            axes=np.array([part.sector.axes for part in own]),
            frames=np.array([part.frame for part in own]),
            lame=lame(self.material.elastic_modulus, self.material.poisson_ratio),
        )
        return found


def edge_functions(
    mesh: CasingMesh,
    material: Material,
    *,
    held: Collection[str],
    joined: Sequence[np.ndarray] = (),
    cubic: CubicFunctions | None = None,
) -> EdgeFunctions:
    """Functions at all edges where stresses are singular; none unless the mesh has hexahedra with mid-side nodes.

    Parameters
    ----------
    mesh, material : of the casing
    held : patches whose nodes are clamped
    joined : facets (f, k) at which parts of the mesh touch without sharing nodes
    cubic : of the mesh, added before these
    """
    parts: dict[int, list[_Part]] = defaultdict(list)
    numbers: list[int] = []
    between: dict[int, list[np.ndarray]] = defaultdict(list)  # by the first unknown of a node
    kind = solid_element(mesh.elements)
    if kind.corners != 8 or kind.degree == 1:
        return EdgeFunctions(np.zeros(0, int), np.zeros((0, 3)), mesh, material, cubic, {})
    topology = Topology(mesh.nodes, mesh.elements, mesh.facets, mesh.facet_patch)
    for facets in joined:
        topology.mark(facets, len(mesh.patch_names))
    clamped = np.isin(topology.patch, [mesh.patch_names.index(name) for name in held])
    sections: dict[bytes, list[np.ndarray]] = {}
    for chain in chains(topology, clamped):
        of_chain = profiles(topology, chain, clamped, material.poisson_ratio, sections)
        known: dict[int, tuple[np.ndarray, int]] = {}
        last = len(chain.fans) - 1
        for number, fan in enumerate(chain.fans):
            for line, s in enumerate(ALONG):
                node, values = topology.node(fan.sectors[0], (0.0, 0.0, s)), of_chain[2 * number + line]
                behind: list[Sector | None] | None = []
                if not chain.closed and (number, line) in ((0, 0), (last, 2)):
                    behind = continuation(topology, fan, line // 2, values)
                if behind is None or not len(values[0]):
                    continue
                if node not in known:
                    known[node] = (topology.frame(fan.sectors[0], s), len(numbers))
                    numbers += range(len(values[0]))
                frame, first = known[node]
                between[first].append(_between(topology, node, fan))
                own = [(sector, line, at) for at, sector in enumerate(fan.sectors)]
                own += [(sector, 0, at) for at, sector in enumerate(behind) if sector is not None]
                for sector, place, at in own:
                    parts[sector.element].append(_Part(sector, place, values[at], frame, first))
    of_node = np.array(numbers, int)
    places = np.repeat([np.mean(some, axis=0) for some in between.values()], np.diff([*between, len(of_node)]), axis=0)
    return EdgeFunctions(of_node, places.reshape(-1, 3), mesh, material, cubic, dict(parts))


def _between(topology: Topology, node: int, fan: Fan) -> np.ndarray:
    """Mean of a node, a side and the elements around it: a position that differs for the same node on another edge."""
    side = topology.points(fan.sectors[0], np.array([[0.0], [0.0], [0.5]]))[0]
    corners = topology.elements[[sector.element for sector in fan.sectors], :8]
    middle = topology.nodes[corners].mean(axis=(0, 1))
    return np.asarray((topology.nodes[node] + side + middle) / 3.0)


def _unknowns(own: list[_Part]) -> np.ndarray:
    return np.concatenate([part.first + np.arange(len(part.values)) for part in own])


def _shape_key(nodes: np.ndarray, own: list[_Part]) -> bytes:
    """Key that is equal for elements of the same shape with the same functions."""
    at = nodes - nodes[0]
    size = abs(at).max()
    found = [np.round(at / size, 7) + 0.0, np.round([np.log(size)], 9)]
    for part in own:
        found += [
            np.array([id(part.values), part.line]),
            part.sector.origin,
            part.sector.axes,
            np.round(part.frame, 7) + 0.0,
        ]
    return b"".join(one.tobytes() for one in found)


@lru_cache(maxsize=2)
def _rule(kind: str, ends: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points (3, i, j, k), weights (q,), functions (a, q), slopes (a, 3, q) of an element graded to given sides."""
    lines = []
    for low, high in np.frombuffer(ends, bool).reshape(3, 2):
        cuts = np.concatenate([[0.0, 1.0], *([GRID] if low else []), *([1.0 - GRID] if high else [])])
        lines.append(gauss(np.unique(np.round(cuts, 12))))
    points = np.stack(np.meshgrid(*(x for x, _ in lines), indexing="ij"))
    weights = np.einsum("i,j,k->ijk", *(w for _, w in lines)).ravel()
    values, slopes = element_shapes(SOLIDS[kind], points.reshape(3, -1))
    return points, weights, np.ascontiguousarray(values.T), np.ascontiguousarray(slopes.transpose(1, 2, 0))


@lru_cache(maxsize=16)
def _along(kind: str, ends: bytes, origin: bytes, axes: bytes) -> np.ndarray:
    """The functions along the edge of a sector and their derivatives (3, 2, q) at the points of `_rule`."""
    points = _rule(kind, ends)[0].reshape(3, -1)
    s = np.frombuffer(axes).reshape(3, 3)[:, 2] @ (points - np.frombuffer(origin)[:, None])
    return np.stack(lagrange(s)).transpose(2, 0, 1)


def _table(part: _Part, points: np.ndarray) -> np.ndarray:
    """Functions, derivatives by xi and eta (function, 3, 3, q) at reference points (3, i, j, k), constant along s."""
    axis, _ = part.sector.axis(2, 0)
    across = points.take(0, axis=1 + axis)
    xi, eta = part.sector.axes[:, :2].T @ (across.reshape(3, -1) - part.sector.origin[:, None])
    (x, dx), (y, dy) = graded(xi), graded(eta)
    by_x, by_dx = (np.tensordot(part.values, one, axes=((2,), (1,))) for one in (x, dx))  # (function, 3, y, q)
    pairs = ((by_x, y), (by_dx, y), (by_x, dy))
    table = np.stack([np.einsum("fcyq,qy->fcq", one, other) for one, other in pairs], axis=1)
    table = np.expand_dims(table.reshape(*table.shape[:3], *across.shape[1:]), 3 + axis)
    return np.broadcast_to(table, (*table.shape[:3], *points.shape[1:])).reshape(*table.shape[:3], -1)
