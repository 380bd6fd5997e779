"""Nine-node elements: patch test, rigid motions, convergence rates, and helical elasticity against plane strain."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve

from fem.elements.sections import (
    ElementError,
    elasticity,
    gauss_grid,
    geometry,
    shape_functions,
    stiffness,
    strain_operator,
)

YOUNG, POISSON = 206e9, 0.3


def square(n, distortion=0.0, curved=0.0):
    """Unit square of n x n elements with moved inner corners (straight edges) or a smoothly curved inside."""
    x, y = np.meshgrid(np.linspace(0, 1, 2 * n + 1), np.linspace(0, 1, 2 * n + 1), indexing="ij")
    points = np.stack([x, y], axis=-1)
    rng = np.random.default_rng(7)
    corners = points[::2, ::2].copy()
    corners[1:-1, 1:-1] += distortion / n * rng.uniform(-1, 1, corners[1:-1, 1:-1].shape)
    points[::2, ::2] = corners
    points[1::2, ::2] = (corners[1:] + corners[:-1]) / 2
    points[:, 1::2] = (points[:, 2::2] + points[:, :-2:2]) / 2
    bubble = np.sin(np.pi * points[..., 0]) * np.sin(np.pi * points[..., 1])
    points = points + curved * bubble[..., None] * np.array([1.0, -0.7])
    nodes = np.arange(points[..., 0].size).reshape(points.shape[:2])
    edge = np.zeros(nodes.shape, dtype=bool)
    edge[[0, -1]] = edge[:, [0, -1]] = True
    elements = np.lib.stride_tricks.sliding_window_view(nodes, (3, 3))[::2, ::2].reshape(-1, 9)
    return points.reshape(-1, 2), elements, edge.ravel()


def solved(points, elements, held, motion, load=None, twist=0.0):
    """Displacement (nodes, components) with `motion` prescribed at the nodes `held`."""
    matrix = stiffness(points, elements, YOUNG, POISSON, twist)
    fixed = np.repeat(held, motion.shape[1])
    u = np.where(fixed, motion.ravel(), 0.0)
    right = -(matrix @ u) if load is None else load - matrix @ u
    u[~fixed] = spsolve(matrix[~fixed][:, ~fixed], right[~fixed])
    return u.reshape(motion.shape)


@pytest.mark.parametrize("curved", [0.0, 0.08])
def test_constant_strain_is_exact_on_a_distorted_mesh(curved):
    points, elements, edge = square(4, distortion=0.25, curved=curved)
    motion = points @ np.array([[1e-3, 4e-4], [-2e-4, 7e-4]]) + 3e-4
    u = solved(points, elements, edge, motion)
    assert abs(u - motion).max() < 1e-13 * abs(motion).max() * 100


def test_exactly_three_rigid_motions_need_no_force():
    points, elements, _ = square(2, distortion=0.2, curved=0.05)
    matrix = stiffness(points, elements, YOUNG, POISSON).toarray()
    assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
    values = np.linalg.eigvalsh(matrix)
    assert abs(values[:3]).max() < 1e-10 * values[-1]
    assert values[3] > 1e-5 * values[-1]


def test_helical_rigid_motions_need_no_force():
    """A helical body is free to turn about and to move along its axis, and nothing else."""
    points, elements, _ = square(2, distortion=0.2)
    matrix = stiffness(points, elements, YOUNG, POISSON, twist=0.8).toarray()
    rotation = np.column_stack([-points[:, 1], points[:, 0], 0 * points[:, 0]]).ravel()
    along = np.tile([0.0, 0.0, 1.0], len(points))
    assert abs(matrix @ rotation).max() < 1e-12 * abs(matrix).max()
    assert abs(matrix @ along).max() < 1e-12 * abs(matrix).max()
    values = np.linalg.eigvalsh(matrix)
    assert values[1] < 1e-10 * values[-1] < values[2]


def test_helical_strains_are_those_of_the_body_in_space():
    """Strains of the turning displacement field u(x, z) = R(k z) u0(R(-k z) x) by finite differences in space."""
    twist, place = 3.0, np.array([0.31, 0.47])
    points = np.stack(np.meshgrid([0.2, 0.35, 0.5], [0.3, 0.45, 0.6], indexing="ij"), axis=-1).reshape(-1, 2)
    nodal = np.random.default_rng(3).normal(size=(9, 3))
    low, high = points[0], points[-1]

    def displacement(position):
        c, s = np.cos(twist * position[2]), np.sin(twist * position[2])
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        section = turn.T[:2, :2] @ position[:2]
        local = (section - low) / (high - low)
        return turn @ (shape_functions(local[None])[0][0] @ nodal)

    step = 1e-6
    gradient = np.empty((3, 3))  # d u_i / d x_j
    for j in range(3):
        move = step * np.eye(3)[j]
        gradient[:, j] = (
            (displacement(np.append(place, 0.0) + move) - displacement(np.append(place, 0.0) - move)) / 2 / step
        )
    expected = [
        gradient[0, 0],
        gradient[1, 1],
        gradient[2, 2],
        gradient[1, 2] + gradient[2, 1],
        gradient[0, 2] + gradient[2, 0],
        gradient[0, 1] + gradient[1, 0],
    ]
    local = (place - low) / (high - low)
    values, slopes = shape_functions(local[None])
    gradients = slopes / (high - low)
    operator = strain_operator(place[None, None], gradients[None], values, twist)[0, 0]
    assert operator @ nodal.ravel() == pytest.approx(expected, rel=1e-6, abs=1e-6)


class TestManufacturedSolution:
    """u = (sin(pi x) sinh(y), x^2 cos(2 y)) on the unit square with a curved inside, displacements held at its border.

    The body force is -div sigma; quadratic elements must show the rates 3 (L2) and 2 (H1) in the displacement, that is
    3 and 2 in h; plane strain.
    """

    @staticmethod
    def exact(x, y):
        u = np.stack([np.sin(np.pi * x) * np.sinh(y), x**2 * np.cos(2 * y)], axis=-1)
        du = np.stack(
            [
                np.stack([np.pi * np.cos(np.pi * x) * np.sinh(y), np.sin(np.pi * x) * np.cosh(y)], axis=-1),
                np.stack([2 * x * np.cos(2 * y), -2 * x**2 * np.sin(2 * y)], axis=-1),
            ],
            axis=-2,
        )  # du[..., i, j] = d u_i / d x_j
        return u, du

    @staticmethod
    def body_force(x, y):
        shear = YOUNG / 2 / (1 + POISSON)
        lame = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
        laplace_u = (1 - np.pi**2) * np.sin(np.pi * x) * np.sinh(y)
        laplace_v = 2 * np.cos(2 * y) - 4 * x**2 * np.cos(2 * y)
        # div u = pi cos(pi x) sinh(y) - 2 x^2 sin(2 y)
        div_x = -(np.pi**2) * np.sin(np.pi * x) * np.sinh(y) - 4 * x * np.sin(2 * y)
        div_y = np.pi * np.cos(np.pi * x) * np.cosh(y) - 4 * x**2 * np.cos(2 * y)
        return -np.stack(
            [shear * laplace_u + (lame + shear) * div_x, shear * laplace_v + (lame + shear) * div_y], axis=-1
        )

    def errors(self, n):
        points, elements, edge = square(n, curved=0.06)
        places, gradients, weight = geometry(points, elements, order=5)
        values, _ = shape_functions(gauss_grid(5)[0])
        force = np.einsum("eq,qa,eqi->eai", weight, values, self.body_force(places[..., 0], places[..., 1]))
        load = np.zeros(points.shape)
        np.add.at(load, elements, force)
        u = solved(points, elements, edge, self.exact(*points.T)[0], load.ravel())
        exact, slope = self.exact(places[..., 0], places[..., 1])
        found = np.einsum("qa,eai->eqi", values, u[elements])
        found_slope = np.einsum("eqaj,eai->eqij", gradients, u[elements])
        return (
            np.sqrt((weight[..., None] * (found - exact) ** 2).sum()),
            np.sqrt((weight[..., None, None] * (found_slope - slope) ** 2).sum()),
        )

    def test_rates(self):
        sizes = [4, 8, 16]
        error = np.array([self.errors(n) for n in sizes])
        rates = -np.polyfit(np.log(sizes), np.log(error), 1)[0]
        assert rates[0] == pytest.approx(3.0, abs=0.15)
        assert rates[1] == pytest.approx(2.0, abs=0.15)


def test_plane_strain_hooke_is_the_section_of_hooke_in_space():
    space, plane = elasticity(YOUNG, POISSON, 6), elasticity(YOUNG, POISSON, 3)
    keep = [0, 1, 5]
    assert np.allclose(space[np.ix_(keep, keep)], plane, rtol=1e-14)


def test_a_helix_without_twist_is_plane_strain():
    points, elements, edge = square(3, distortion=0.2)
    motion = np.random.default_rng(1).normal(size=(len(points), 3))
    motion[:, 2] = 0.0
    flat = solved(points, elements, edge, motion[:, :2])
    nearly = solved(points, elements, edge, motion, twist=1e-7)
    assert abs(nearly[:, :2] - flat).max() < 1e-6
    assert abs(nearly[:, 2]).max() < 1e-5


def test_an_inverted_element_is_named():
    points, elements, _ = square(2)
    broken = points.copy()
    broken[elements[3, 4]] += 5.0
    with pytest.raises(ElementError, match="element 3"):
        stiffness(broken, elements, YOUNG, POISSON)


def test_the_matrix_is_sparse_and_finite():
    points, elements, _ = square(3)
    matrix = stiffness(points, elements, YOUNG, POISSON)
    assert sparse.issparse(matrix)
    assert np.isfinite(matrix.data).all()
