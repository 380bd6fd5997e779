"""Order of convergence of every solid element, in strain energy and in frequency, in straight and in curved bodies.

Elements of degree p have errors of order h^p in the strains; energies and frequencies, which are quadratic in them, of
order h^(2p) (Strang & Fix (1973), An Analysis of the Finite Element Method, chapters 1.6, 4.4 and 6.3).

Both bodies are one layer of cells deep, as deep as a cell is long, and held there in plane strain.

Straight: a plate between smooth walls (free to slide along them), with its exact mode of shear

    u = (sin(pi x) cos(pi y), -cos(pi x) sin(pi y), 0),   omega^2 = 2 pi^2 mu / rho.

Curved: the quarter of a thick ring in plane strain, nodes on the true circles. Under inner pressure its displacement is
Lame's u_r = A r + B / r; its breathing mode is u_r = C J_1(k r) + D Y_1(k r), k = omega sqrt(rho / (lambda + 2 mu)).
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh
from scipy.special import jv, jvp, yv, yvp

from benchmarks.solids import box_mesh, facets_on
from fem.elements.facets import surface_weights
from fem.elements.solid_elements import SOLIDS, solid_mesh
from fem.elements.solids import assemble, lame
from fem.numerics.linear_solver import factorize

MODULUS, POISSON = 1.0, 0.3
LAMBDA, MU = lame(MODULUS, POISSON)
INNER, OUTER = 1.0, 2.0
FINENESS = {1: (16, 24), 2: (8, 12)}  # cells along a side of the body, by the degree of the element


def matrices(nodes, elements):
    return assemble(nodes, elements, elastic_modulus=MODULUS, poisson_ratio=POISSON, density=1.0)


def plate(n, element):
    """Nodes, elements, and the unknowns that smooth walls leave free."""
    nodes, elements = box_mesh((1.0, 1.0, 1.0 / n), (n, n, 1), element=element)
    return nodes, elements, np.flatnonzero(((nodes > 1e-9) & (nodes < [1.0 - 1e-9, 1.0 - 1e-9, 0.0])).ravel())


def ring(n, element):
    """The quarter ring with n cells along the radius; symmetry holds two of its sides, plane strain two more."""
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (n, 2 * n, 1), element=element)
    radius, angle = INNER + (OUTER - INNER) * nodes[:, 0], math.pi / 2 * nodes[:, 1]
    free = np.column_stack([nodes[:, 1] < 1.0 - 1e-9, nodes[:, 1] > 1e-9, np.zeros(len(nodes), bool)]).ravel()
    places = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), nodes[:, 2] / n])
    return places, elements, np.flatnonzero(free)


def plate_energy_error(n, element):
    """Under the inertia of the mode at its own frequency the plate takes its shape: energy omega^2 int u^2 / 2."""
    nodes, elements, free = plate(n, element)
    K, _ = matrices(nodes, elements)
    library, square = SOLIDS[element].library, 2.0 * math.pi**2 * MU
    from skfem import Basis

    basis = Basis(solid_mesh(nodes, elements), library, intorder=6)
    x, y, _ = basis.global_coordinates()
    u = np.stack([np.sin(np.pi * x) * np.cos(np.pi * y), -np.cos(np.pi * x) * np.sin(np.pi * y)])
    load = np.zeros((len(nodes), 3))
    for number, (function,) in enumerate(basis.basis):
        np.add.at(load[:, :2], elements[:, number], square * (np.asarray(function) * u * basis.dx).sum(axis=2).T)
    load = load.ravel()[free]
    energy = 0.5 * load @ factorize(K[free][:, free], block=1).solve(load)
    return 1.0 - energy / (0.25 * square / n)


def ring_energy_error(n, element):
    """Work of a unit pressure in the bore: pi / 4 INNER u_r(INNER) by depth."""
    nodes, elements, free = ring(n, element)
    K, _ = matrices(nodes, elements)
    facets = facets_on(nodes, elements, np.hypot(nodes[:, 0], nodes[:, 1]) < INNER + 1e-9)
    values, places, area = surface_weights(nodes, facets)
    outwards = places[..., :2] / np.linalg.norm(places[..., :2], axis=2, keepdims=True)
    load = np.zeros((len(nodes), 3))
    np.add.at(load[:, :2], facets, np.einsum("fq,qa,fqd->fad", area, values, outwards))
    load = load.ravel()[free]
    energy = 0.5 * load @ factorize(K[free][:, free], block=1).solve(load)
    growth = INNER**2 / (OUTER**2 - INNER**2)
    radial = growth / (2.0 * (LAMBDA + MU)) * INNER + growth * OUTER**2 / (2.0 * MU) / INNER
    return 1.0 - energy / (math.pi / 4.0 * INNER * radial / n)


def plate_frequency_error(n, element):
    nodes, elements, free = plate(n, element)
    K, M = (matrix[free][:, free] for matrix in matrices(nodes, elements))
    exact = 2.0 * math.pi**2 * MU
    lowest = eigsh(K, 1, M, sigma=0.5 * exact, return_eigenvectors=False)[0]
    return math.sqrt(lowest / exact) - 1.0


def breathing():
    """omega^2 of the ring's breathing mode, free at both radii: (lambda + 2 mu) u' + lambda u / r = 0."""

    def stresses(k, r):
        return [
            (LAMBDA + 2.0 * MU) * k * slope(1, k * r) + LAMBDA * value(1, k * r) / r
            for value, slope in ((jv, jvp), (yv, yvp))
        ]

    def free(k):
        return np.linalg.det([stresses(k, INNER), stresses(k, OUTER)])

    return brentq(free, 0.4, 1.0, xtol=1e-14) ** 2 * (LAMBDA + 2.0 * MU)


def ring_frequency_error(n, element):
    nodes, elements, free = ring(n, element)
    K, M = (matrix[free][:, free] for matrix in matrices(nodes, elements))
    exact = breathing()
    squares, shapes_found = eigsh(K, 4, M, sigma=1.01 * exact)
    radial = (nodes * [1.0, 1.0, 0.0]).ravel()[free]
    own = int(((shapes_found.T @ (M @ radial)) ** 2).argmax())
    return math.sqrt(squares[own] / exact) - 1.0


BODIES = {
    "energy of a plate": plate_energy_error,
    "energy of a ring": ring_energy_error,
    "frequency of a plate": plate_frequency_error,
    "frequency of a ring": ring_frequency_error,
}


def observed_order(body, element, fineness):
    coarse, fine = (abs(BODIES[body](n, element)) for n in fineness)
    return math.log(coarse / fine) / math.log(fineness[1] / fineness[0])


@pytest.mark.parametrize("element", ["tetrahedron-4", "tetrahedron-10", "hexahedron-20", "hexahedron-27"])
@pytest.mark.parametrize("body", BODIES)
def test_errors_fall_with_twice_the_degree_of_the_element(body, element):
    order = observed_order(body, element, FINENESS[SOLIDS[element].degree])
    assert order == pytest.approx(SOLIDS[element].frequency_order, abs=0.15)
