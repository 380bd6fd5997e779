"""A gear pair on the meshes of `contact_deck`, condensed to its flanks: contact of any load and any modification.

The elements are those of the CalculiX model (20 nodes, reduced integration, fine and coarse sectors tied by linear
constraints). Each gear is factorised once per mesh position. Its compliance between the flank nodes near the contact
lines then serves all loads and modifications, which CalculiX would compute one by one. Independent of the product:
elements, mesh, contact. The gap without load is the exact one of two involutes.

Pinion and wheel touch in Gauss points of the flanks of the pinion, by a penalty q = kappa * overclosure. q is the
traction along the transverse line of action; the pressure is q / cos(beta_b). Lengths mm, forces N.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from benchmarks.peers.contact_deck import ContactModel
from benchmarks.peers.wheel_mesh import HEXAHEDRON, WheelMesh
from fem.elements.materials import Material
from fem.gears.gear import Gear
from fem.gears.path import edge_gap
from fem.numerics.linear_solver import Factor, factorize

FACE = np.flatnonzero(HEXAHEDRON[:, 1] == 2)  # nodes of the loaded face, and their place on it
PLACE = HEXAHEDRON[FACE][:, [0, 2]] - 1.0  # radial, along the face
POINTS = (4, 3)  # Gauss points of a face, up the flank and along the face
REDUCED = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1], indexing="ij")).reshape(3, 8).T / math.sqrt(3.0)
VOID = 1e-6
Gap = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]  # y, xi, both radii (m) -> m


def shapes(nodes: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Serendipity functions (point, node) and gradients (point, node, axis); nodes at -1, 0, 1 on each axis."""
    value, slope = np.ones((len(points), len(nodes))), np.zeros((len(points), *nodes.shape))
    axes = nodes.shape[1]
    for n, node in enumerate(nodes):
        factor = np.where(node == 0, 1 - points**2, 1 + node * points)
        change = np.where(node == 0, -2 * points, node)
        scale = 1 / 2 ** np.count_nonzero(node)
        rest = (node * points).sum(axis=1) - (axes - 1) if node.all() else 1.0
        value[:, n] = scale * factor.prod(axis=1) * rest
        for k in range(axes):
            others = np.delete(factor, k, axis=1).prod(axis=1)
            slope[:, n, k] = scale * change[:, k] * others * rest
            if node.all():
                slope[:, n, k] += scale * factor.prod(axis=1) * node[k]
    return value, slope


def _strains(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Strain matrices (element, point, 6, 60) at the reduced points, and weights (element, point)."""
    gradient = shapes(HEXAHEDRON - 1.0, REDUCED)[1]
    jacobian = np.einsum("qna,end->eqad", gradient, nodes)
    slope = np.linalg.solve(jacobian, np.broadcast_to(gradient.swapaxes(1, 2), (*jacobian.shape[:2], 3, 20)))
    out = np.zeros((*jacobian.shape[:2], 6, 20, 3))
    for row, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
        out[:, :, row, :, i] += slope[:, :, j]
        if i != j:
            out[:, :, row, :, j] += slope[:, :, i]
    return out.reshape(*jacobian.shape[:2], 6, 60), np.linalg.det(jacobian)


def _hooke(material: Material) -> np.ndarray:
    """Stiffness (6, 6), MPa."""
    young, poisson = material.elastic_modulus / 1e6, material.poisson_ratio
    shear = young / (2 * (1 + poisson))
    out = np.diag([2 * shear] * 3 + [shear] * 3)
    out[:3, :3] += 2 * shear * poisson / (1 - 2 * poisson)
    return out


@dataclass(frozen=True, eq=False)
class Body:
    """One gear with its bore held."""

    gear: Gear
    material: Material
    mesh: WheelMesh
    twist: float  # rad/mm
    fillet: int  # rows of elements
    tie: sparse.csc_matrix  # all unknowns from the free ones
    factor: Factor

    @staticmethod
    def of(
        gear: Gear, material: Material, mesh: WheelMesh, twist: float, fillet: int, void: np.ndarray | tuple = ()
    ) -> Body:
        """Assemble and factorise; the elements `void` are left with VOID of their stiffness."""
        filling = np.ones(len(mesh.elements))
        filling[list(void)] = VOID
        size, hooke = 3 * len(mesh.nodes), _hooke(material)
        matrix = sparse.csc_matrix((size, size))
        for which in np.array_split(np.arange(len(filling)), max(1, len(filling) // 700)):
            part = mesh.elements[which]
            strain, weight = _strains(mesh.nodes[part])
            stress = np.einsum("rs,eqsk->eqrk", hooke, strain) * (weight * filling[which, None])[..., None, None]
            local = np.einsum("eqrk,eqrl->ekl", strain, stress, optimize=True)
            unknown = (3 * part[:, :, None] + np.arange(3)).reshape(len(part), 60)
            where = np.broadcast_to(unknown[:, :, None], local.shape), np.broadcast_to(unknown[:, None], local.shape)
            matrix += sparse.coo_matrix((local.ravel(), (where[0].ravel(), where[1].ravel())), (size, size)).tocsc()
        tied = np.array([d for d, _, _ in mesh.constraints], dtype=int)
        weights = sparse.identity(len(mesh.nodes), format="lil")
        weights[tied, tied] = 0.0
        for node, nodes, share in mesh.constraints:
            weights[node, nodes] = share
        free = np.setdiff1d(np.arange(len(mesh.nodes)), np.append(tied, mesh.bore))
        tie = sparse.kron(weights.tocsc()[:, free], sparse.identity(3), format="csc")
        return Body(gear, material, mesh, twist, fillet, tie, factorize((tie.T @ matrix @ tie).tocsc()))

    def normals(self, nodes: np.ndarray) -> np.ndarray:
        """Outward normals (node, 3) of the loaded flank; their transverse part has the length 1."""
        x, y = self.mesh.nodes[nodes, :2].T
        out = np.arctan2(y, x) + np.arcsin(np.minimum(1e3 * self.gear.base_radius / np.hypot(x, y), 1.0))
        out = np.array([np.cos(out), np.sin(out)])
        return np.array([*out, -self.twist * (x * out[1] - y * out[0])]).T

    def loads(self, nodes: np.ndarray) -> sparse.csc_matrix:
        """Forces (free unknown, node) of unit transverse size into the flank."""
        where = (3 * nodes[:, None] + np.arange(3)).ravel(), np.repeat(np.arange(len(nodes)), 3)
        force = sparse.csc_matrix((-self.normals(nodes).ravel(), where), (self.tie.shape[0], len(nodes)))
        return (self.tie.T @ force).tocsc()

    def compliance(self, nodes: np.ndarray) -> np.ndarray:
        """Motion against the normal by forces against it, (node, node), mm/N."""
        loads, out = self.loads(nodes), []
        for first in range(0, len(nodes), 128):
            out.append(loads.T @ self.factor.solve(loads[:, first : first + 128].toarray()))
        return np.hstack(out)

    def root_stress(self, nodes: np.ndarray, force: np.ndarray, highest: float, across: int, faces: int) -> np.ndarray:
        """Largest von Mises stress (MPa) of the loaded fillets below the radius `highest` (mm), by pair number.

        Parameters
        ----------
        nodes, force : (node,) N into the flank
        across, faces : columns and elements along the face of a fine tooth
        """
        motion = (self.tie @ self.factor.solve(self.loads(nodes) @ force)).reshape(-1, 3)
        hooke, out = _hooke(self.material), []
        to_nodes = ((1 + 3 * (HEXAHEDRON[FACE] - 1.0)[:, None] * REDUCED) / 2).prod(axis=2)  # linear from there
        for flank in self.mesh.flanks.values():
            rows = flank[0] - across * faces * np.arange(1, self.fillet + 1)
            elements = self.mesh.elements[(rows[:, None] + np.arange(faces)).ravel()]
            strain, _ = _strains(self.mesh.nodes[elements])
            stress = np.einsum("rs,eqsk,ek->eqr", hooke, strain, motion[elements].reshape(-1, 60), optimize=True)
            nodal = np.einsum("nq,eqr->enr", to_nodes, stress)
            used, place = np.unique(elements[:, FACE], return_inverse=True)
            s = np.zeros((len(used), 6))
            np.add.at(s, place.ravel(), nodal.reshape(-1, 6))
            s /= np.bincount(place.ravel())[:, None]
            a, b, c = s[:, 0] - s[:, 1], s[:, 1] - s[:, 2], s[:, 2] - s[:, 0]
            mises = np.sqrt((a**2 + b**2 + c**2) / 2 + 3 * (s[:, 3:] ** 2).sum(axis=1))
            out.append(mises[np.hypot(*self.mesh.nodes[used, :2].T) < highest].max())
        return np.array(out)


@dataclass(frozen=True, eq=False)
class _Grid:
    """The loaded flank of one tooth near the contact line: faces in rows and along the face."""

    nodes: np.ndarray  # (row, station, 8)
    arc: np.ndarray  # (row end, station end), mm from the base circle
    z: np.ndarray  # (station end,)

    @staticmethod
    def of(body: Body, number: int, faces: int, reach: Callable[[np.ndarray], np.ndarray]) -> _Grid:
        """Rows of which `reach` (row end, station end) arcs is true somewhere."""
        nodes = body.mesh.elements[body.mesh.flanks[number].reshape(-1, faces)][..., FACE]
        x, y, z = np.moveaxis(body.mesh.nodes[nodes], -1, 0)
        base = 1e3 * body.gear.base_radius
        arcs = (x**2 + y**2 - base**2) / (2 * base)
        low, high = (np.flatnonzero((PLACE[:, 0] == end) & (np.abs(PLACE[:, 1]) == 1)) for end in (-1, 1))
        order = [sorted(one, key=lambda n: PLACE[n, 1]) for one in (low, high)]
        ends = [np.concatenate([arcs[:, :, o[0]], arcs[:, -1:, o[1]]], axis=1) for o in order]
        arc = np.vstack([ends[0], ends[1][-1:]])
        kept = np.flatnonzero(reach(arc).any(axis=1))
        kept = np.arange(max(kept[0] - 1, 0), min(kept[-1] + 1, len(nodes)))
        stations = np.append(z[0, :, order[0][0]], z[0, -1, order[0][1]])
        return _Grid(nodes[kept], arc[kept[0] : kept[-1] + 2], stations)

    def place(self, z: np.ndarray, arc: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Nodes (point, 8), their functions (point, 8), and which points lie on the grid."""
        station = np.clip(np.searchsorted(self.z, z, side="right") - 1, 0, len(self.z) - 2)
        t = (z - self.z[station]) / (self.z[station + 1] - self.z[station])
        ends = self.arc[:, station] * (1 - t) + self.arc[:, station + 1] * t
        row = (ends <= arc).sum(axis=0) - 1
        on = (row >= 0) & (row < len(self.nodes))
        row = np.clip(row, 0, len(self.nodes) - 1)
        low, high = (np.take_along_axis(ends, r[None], 0)[0] for r in (row, row + 1))
        local = np.column_stack([2 * (arc - low) / (high - low) - 1, 2 * t - 1])
        return self.nodes[row, station], shapes(PLACE, local)[0], on


@dataclass(frozen=True, eq=False, kw_only=True)
class Contact:
    """A solved state: approach (mm), traction (point,) along the line of action, and nodal forces of both gears."""

    delta: float
    traction: np.ndarray
    force: tuple[np.ndarray, np.ndarray]


class FlankContact:
    """Both gears of a `ContactModel` at its mesh position, condensed to the flanks within `reach` (m) of contact.

    void : elements of the pinion that are broken out
    """

    def __init__(self, model: ContactModel, reach: float, void: np.ndarray | tuple = ()):
        pair, self.model = model.pair, model
        lead = math.tan(pair.base_helix_angle) * pair.pinion.hand_sign
        gears = (pair.pinion, pair.wheel)
        materials = (pair.pinion_material, pair.wheel_material)
        self.bodies = [
            Body.of(gear, material, mesh, 1e-3 * sign * lead / gear.base_radius, model.fine.fillet, broken)
            for gear, material, mesh, sign, broken in zip(
                gears, materials, model.wheels, (1, -1), (void, ()), strict=True
            )
        ]
        points: list[list[np.ndarray]] = [[] for _ in range(10)]
        for number in sorted(self.bodies[0].mesh.flanks.keys() & self.bodies[1].mesh.flanks.keys()):
            for column, found in zip(points, self._points(number, reach), strict=True):
                column.append(found)
        (self.y, self.xi, r1, r2, self.area, self.line_weight, *rest) = (np.concatenate(p) for p in points)
        self.radius = np.array([r1, r2])
        nodes, values = rest[:2], rest[2:]
        self.nodes, self.map, self.compliance = [], [], []
        for body, node, value in zip(self.bodies, nodes, values, strict=True):
            used, place = np.unique(node, return_inverse=True)
            where = np.repeat(np.arange(len(node)), 8), place.ravel()
            self.nodes.append(used)
            self.map.append(sparse.csr_matrix((value.ravel(), where), (len(node), len(used))))
            self.compliance.append(body.compliance(used))
        gap = edge_gap(pair, "pinion", self.xi, self.radius[0])
        self.gap = 1e3 * np.where(np.isfinite(gap), gap, 1.0)

    def _points(self, number: int, reach: float) -> tuple[np.ndarray, ...]:
        """y, xi, radii (m), transverse area (mm2), nodes and functions of both gears, of the Gauss points of a pair."""
        pair, faces = self.model.pair, self.model.fine.face
        grids = []
        for body in self.bodies:
            base, sign = body.gear.base_radius, 1 if body is self.bodies[0] else -1

            def near(arc, base=base, sign=sign, faces=faces):
                y = np.linspace(-0.5, 0.5, faces + 1) * pair.face_width
                xi = self.model.position(number, y)
                roll = base * math.tan(pair.working_pressure_angle) + sign * pair.base_pitch * xi
                middle = np.clip(1e3 * np.maximum(roll, 0.0) ** 2 / (2 * base), arc.min(0), arc.max(0))
                return np.abs(arc - middle) <= 1e3 * reach

            grids.append(_Grid.of(body, number, faces, near))
        up, w_up = np.polynomial.legendre.leggauss(POINTS[0])
        along, w_along = np.polynomial.legendre.leggauss(POINTS[1])
        local = np.array(np.meshgrid(up, along, indexing="ij")).reshape(2, -1).T
        weight = np.outer(w_up, w_along).ravel()
        value, slope = shapes(PLACE, local)
        own = grids[0].nodes.reshape(-1, 8)
        corner = self.bodies[0].mesh.nodes[own]
        place = np.einsum("qn,end->eqd", value, corner).reshape(-1, 3)
        edges = np.einsum("qna,end->eqad", slope, corner)
        area = np.linalg.norm(np.cross(edges[:, :, 0], edges[:, :, 1]), axis=2) * weight
        z, base = place[:, 2], 1e3 * self.bodies[0].gear.base_radius
        xi = self.model.position(number, z / 1e3)
        # the radius from the lattice: the quadratic face is off the involute by more than the gaps that matter
        nodes = np.repeat(own, len(local), axis=0)
        arcs = ((self.bodies[0].mesh.nodes[own][..., :2] ** 2).sum(axis=2) - base**2) / (2 * base)
        arc = np.einsum("qn,en->eq", value, arcs).ravel()
        radius = np.sqrt(base**2 + 2 * base * arc)
        mate = self.mate_radius(self.model, xi, radius)
        arc2 = (mate**2 - (1e3 * self.bodies[1].gear.base_radius) ** 2) / (2e3 * self.bodies[1].gear.base_radius)
        mate_nodes, mate_value, on = grids[1].place(z, arc2)
        on &= mate <= 1e3 * pair.wheel.tip_radius
        return tuple(
            column[on]
            for column in (
                z / 1e3,
                xi,
                radius / 1e3,
                mate / 1e3,
                area.ravel() * math.cos(pair.base_helix_angle),
                (np.linalg.norm(edges[:, :, 0, :2], axis=2) * np.repeat(w_up, POINTS[1])).ravel(),
                nodes,
                mate_nodes,
                np.tile(value, (len(own), 1)),
                mate_value,
            )
        )

    @staticmethod
    def mate_radius(model: ContactModel, xi: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Radius (mm) on the wheel of the points of the pinion at this radius (mm)."""
        pair = model.pair
        l1, _ = pair.roll_lengths(xi)
        base, alpha = pair.pinion.base_radius, pair.working_pressure_angle
        roll = np.sqrt(np.maximum((radius / 1e3) ** 2 - base**2, 0.0)) / base
        angle = -alpha + l1 / base - (roll - np.arctan(roll))
        x, y = radius * np.cos(angle) - 1e3 * pair.axis_distance, radius * np.sin(angle)
        return np.hypot(x, y)

    def solve(self, force: float, extra: Gap | None = None) -> Contact:
        """The state at a force (N) on the line of action, with an additional gap (m) of y, xi and both radii."""
        gap = self.gap + (1e3 * extra(self.y, self.xi, *self.radius) if extra else 0.0)
        kappa, near = self.model.penalty, np.flatnonzero(gap < gap.min() + 0.15)
        size = [len(n) for n in self.nodes]
        both = sparse.hstack(self.map, format="csr")[near]
        used = np.flatnonzero(np.diff(both.tocsc().indptr))
        both = both[:, used].toarray()
        compliance = np.zeros((sum(size), sum(size)))
        compliance[: size[0], : size[0]], compliance[size[0] :, size[0] :] = self.compliance
        compliance = compliance[np.ix_(used, used)]
        area, near_gap = kappa * self.area[near], gap[near]
        state = np.append(np.zeros(len(used)), gap.min() + 2e-3)
        for turn in range(200):
            over = state[-1] - near_gap - both @ state[:-1]
            on = over > 0
            moved = np.flatnonzero(both[on].any(axis=0))  # the nodes of points in contact; the others follow from them
            active = both[np.ix_(on, moved)]
            weighted = active.T * area[on]
            own = compliance[np.ix_(moved, moved)]
            total, moment = weighted.sum(axis=1), weighted @ near_gap[on]
            system = np.block(
                [
                    [np.eye(len(moved)) + own @ (weighted @ active), -(own @ total)[:, None]],
                    [-total[None], np.array([[area[on].sum()]])],
                ]
            )
            right = np.append(-own @ moment, force + area[on] @ near_gap[on])
            found = np.linalg.solve(system, right)
            forces = total * found[-1] - moment - weighted @ (active @ found[:-1])
            change = np.append(compliance[:, moved] @ forces, found[-1]) - state
            state = state + change * (1.0 if turn < 12 else 0.5)  # the set of points in contact may alternate
            if np.abs(change).max() < 1e-9 * abs(state[-1]):
                break
        else:
            raise RuntimeError("contact has not settled")
        over, delta = state[-1] - near_gap - both @ state[:-1], state[-1]
        traction = np.zeros(len(gap))
        traction[near] = kappa * np.maximum(over, 0.0)
        nodal = [m.T @ (traction * self.area) for m in self.map]
        return Contact(delta=float(delta), traction=traction, force=(nodal[0], nodal[1]))
