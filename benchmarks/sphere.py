"""Order of convergence of casing frequencies on a smooth body: python -m benchmarks.sphere.

An octant of a hollow sphere, meshed by ten-node tetrahedra whose mid-side nodes lie on the sphere, on rollers along its
planes of symmetry. Its breathing mode is known exactly: u(r) = A j1(k r) + B y1(k r), k = omega / c_L, with free
surfaces (lambda + 2 mu) u' + 2 lambda u / r = 0 at both radii.

In theory the error of a frequency falls with h^4: quadratic elements have an error of h^2 in the strains, the Rayleigh
quotient squares it, and the isoparametric boundary is as good (Strang & Fix (1973), chapters 4.4 and 6.3). A real
housing does not reach this order: at its re-entrant edges the strains are singular.
"""

from __future__ import annotations

import math
import sys

import numpy as np
from scipy.optimize import brentq

from fem.casing.reduced.lanczos import block_lanczos
from fem.elements.solid_elements import SOLIDS, converted
from fem.elements.solids import assemble, lame
from fem.numerics.linear_solver import factorize

INNER, OUTER = 0.6, 1.0  # m
STEEL = {"elastic_modulus": 2.0e11, "poisson_ratio": 0.3, "density": 7800.0}
DIVISIONS = (2, 4, 6, 8)


def exact_frequency() -> float:
    """Hz, of the breathing mode."""
    lam, mu = lame(STEEL["elastic_modulus"], STEEL["poisson_ratio"])
    speed = math.sqrt((lam + 2.0 * mu) / STEEL["density"])

    def stress(k: float, r: float) -> tuple[float, float]:
        s, c, x = math.sin(k * r), math.cos(k * r), k * r
        j, y = s / x**2 - c / x, -c / x**2 - s / x
        dj, dy = k * (s / x - 2.0 * j / x), k * (-c / x - 2.0 * y / x)
        return (lam + 2.0 * mu) * dj + 2.0 * lam * j / r, (lam + 2.0 * mu) * dy + 2.0 * lam * y / r

    def free(k: float) -> float:
        (a, b), (c, d) = stress(k, INNER), stress(k, OUTER)
        return (a * d - b * c) / (lam + 2.0 * mu) ** 2

    k = np.linspace(0.5, 4.0, 200)
    change = int(np.flatnonzero(np.diff(np.sign([free(v) for v in k])))[0])
    return brentq(free, k[change], k[change + 1], xtol=1e-14) * speed / (2.0 * math.pi)


def octant(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (node, 3) and elements (element, 10) with n edges along each arc and n / 2 layers."""
    layers = max(1, round(n / 2))
    corner = {}
    flat = []
    for i in range(n + 1):
        for j in range(n + 1 - i):
            corner[i, j] = len(flat)
            flat.append((i, j))
    places = np.array([(*p, layer) for layer in range(layers + 1) for p in flat], float)
    size = len(flat)
    triangles = [(corner[i, j], corner[i + 1, j], corner[i, j + 1]) for i in range(n) for j in range(n - i)]
    triangles += [
        (corner[i + 1, j], corner[i + 1, j + 1], corner[i, j + 1]) for i in range(n - 1) for j in range(n - 1 - i)
    ]
    tets = []
    for layer in range(layers):
        for triangle in triangles:
            a, b, c = sorted(triangle)  # one order for all prisms, so that neighbours cut their walls alike
            low, high = layer * size, (layer + 1) * size
            tets += [(a + low, b + low, c + low, c + high), (a + low, b + low, c + high, b + high)]
            tets += [(a + low, b + high, c + high, a + high)]
    corners = np.array(tets)
    edges = _on_sphere(places, n, layers)[corners]
    inward = np.linalg.det(edges[:, 1:] - edges[:, :1]) < 0.0
    corners[inward] = corners[inward][:, [0, 2, 1, 3]]
    parameters, elements = converted(places, corners, SOLIDS["tetrahedron-10"])
    return _on_sphere(parameters, n, layers), elements


def _on_sphere(parameters: np.ndarray, n: int, layers: int) -> np.ndarray:
    """Places (k, 3) of the parameters (i, j, layer)."""
    i, j, layer = parameters.T
    direction = np.column_stack([i, j, n - i - j])
    return direction * ((INNER + (OUTER - INNER) * layer / layers) / np.linalg.norm(direction, axis=1))[:, None]


def frequency(n: int) -> tuple[float, int]:
    """Hz of the breathing mode with n edges along an arc, and the number of unknowns."""
    nodes, elements = octant(n)
    K, M = assemble(nodes, elements, **STEEL)
    free = np.flatnonzero(abs(nodes).ravel() > 1e-12)  # on x = 0 the motion along x is held, and so on
    K, M = K[free][:, free], M[free][:, free]
    theta, phi = block_lanczos(factorize(K, block=1).solve, M, count=12)
    radial = (nodes / np.linalg.norm(nodes, axis=1)[:, None]).ravel()[free]
    share = (phi.T @ (M @ radial)) ** 2  # the breathing mode moves all nodes along the radius
    return 1.0 / (2.0 * math.pi * math.sqrt(theta[int(share.argmax())])), len(free)


def main() -> int:
    """Print the errors and the order that they show; 1 if it is below 3."""
    exact = exact_frequency()
    found = [(n, *frequency(n)) for n in DIVISIONS]
    errors = [hertz / exact - 1.0 for _, hertz, _ in found]
    print(f"breathing mode of a hollow sphere, exact {exact:.4f} Hz")
    for (n, hertz, unknowns), error in zip(found, errors, strict=True):
        print(f"  {n} edges per arc, {unknowns:6d} unknowns: {hertz:.4f} Hz, error {error:.2e}")
    order = math.log(errors[-2] / errors[-1]) / math.log(DIVISIONS[-1] / DIVISIONS[-2])
    print(f"observed order {order:.2f} (theory 4)")
    return int(order < 3.0)


if __name__ == "__main__":
    sys.exit(main())
