"""Beams, plates and reductions: a published superelement run and the NAFEMS free vibration benchmarks."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from benchmarks.checks.record import Check, Subject
from benchmarks.solids import box_mesh, unknowns
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.reduction import Reduction, held_interface, reduce_body
from fem.elements.solids import assemble
from fem.numerics.linear_solver import factorize

COFE = "MSC Nastran superelement run, published in vtpasquale/NASTRAN_CoFE (cantilever_bar)"
NAFEMS = "NAFEMS, The Standard NAFEMS Benchmarks, free vibration"
PLATE = {"elastic_modulus": 200e9, "poisson_ratio": 0.3, "density": 8000.0}


def hertz(stiffness: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Frequencies of the motions that have mass (Hz)."""
    theta = la.eigvalsh(mass, stiffness)[::-1]
    return 1 / (2 * np.pi * np.sqrt(theta[theta > 1e-12 * theta[0]]))


def craig_bampton(
    K: sp.spmatrix, M: sp.spmatrix, interface: np.ndarray, n_modes: int, *, enrich: bool = False
) -> Reduction:
    """Craig-Bampton reduction to the degrees of freedom `interface` and the lowest fixed-interface modes.

    Parameters
    ----------
    K, M : sparse (n, n), symmetric, N/m and kg; K may be singular if it is definite with the interface held
    interface : int (b,), unknowns kept as physical coordinates
    n_modes : number of fixed-interface modes, 0 gives Guyan condensation
    enrich : add the inertia correction

    Returns
    -------
    Reduction, with u = T @ [u_b, eta]
    """
    K, interface = sp.csr_matrix(K), np.asarray(interface)
    b = len(interface)
    rows = sp.csr_matrix((np.ones(b), (np.arange(b), interface)), shape=(b, K.shape[0]))
    penalty = np.full(b, abs(K.diagonal()).max())
    held = held_interface(K, rows, penalty=penalty)
    return reduce_body(held, K, M, count=n_modes, enrich=enrich)


def planar_bar(n: int) -> tuple[np.ndarray, np.ndarray]:
    """The planar bar of the run: n slender elements of length 1, lumped translational mass (its own unit system)."""
    element = 2.9e7 * 0.01 * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    stiffness, mass = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros((2 * n + 2, 2 * n + 2))
    for i in range(n):
        stiffness[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += element
        for node in (i, i + 1):
            mass[2 * node, 2 * node] += 7.357e-4 * 0.1 / 2
    return stiffness, mass


def full_bar() -> np.ndarray:
    """Six frequencies of the clamped bar of ten elements."""
    stiffness, mass = planar_bar(10)
    return hertz(stiffness[2:, 2:], mass[2:, 2:])[:6]


def two_part_bar(n_modes: int, count: int) -> np.ndarray:
    """The first `count` frequencies of the same bar in two parts of `n_modes` fixed-interface modes each."""
    stiffness, mass = planar_bar(5)
    clamped = craig_bampton(sp.csr_matrix(stiffness[2:, 2:]), sp.csr_matrix(mass[2:, 2:]), np.array([8, 9]), n_modes)
    free = craig_bampton(sp.csr_matrix(stiffness), sp.csr_matrix(mass), np.array([0, 1]), n_modes)
    # common coordinates: the two interface unknowns, the modes of the first part, those of the second
    size = 2 + 2 * n_modes
    k, m = np.zeros((size, size)), np.zeros((size, size))
    for part, start in ((clamped, 2), (free, 2 + n_modes)):
        place = np.r_[0:2, start : start + n_modes]
        k[np.ix_(place, place)] += part.stiffness
        m[np.ix_(place, place)] += part.mass
    return hertz(k, m)[:count]


def plate_frequencies(
    nodes: np.ndarray, elements: np.ndarray, held: np.ndarray, count: int, shift: float = 0.0
) -> np.ndarray:
    """Lowest frequencies (Hz) with the unknowns `held` fixed; a free body needs a shift (1/s2)."""
    stiffness, mass = assemble(nodes, elements, **PLATE)
    free = np.setdiff1d(np.arange(3 * len(nodes)), held)
    stiffness, mass = stiffness[free][:, free], mass[free][:, free]
    theta, _ = block_lanczos(factorize((stiffness + shift * mass).tocsr(), block=1).solve, mass, count=count)
    return np.sqrt(np.maximum(1 / theta - shift, 0.0)) / (2 * math.pi)


def cantilever_plate(n: int) -> np.ndarray:
    """FV16: six frequencies of the plate held at one edge, n x n cells."""
    nodes, elements = box_mesh((10.0, 10.0, 0.05), (n, n, 1))
    return plate_frequencies(nodes, elements, unknowns(np.flatnonzero(nodes[:, 0] == 0)), 6)


@cache
def free_plate(n: int) -> np.ndarray:
    """FV12: the five elastic frequencies above those of rigid motion."""
    nodes, elements = box_mesh((10.0, 10.0, 0.05), (n, n, 1))
    return plate_frequencies(nodes, elements, np.zeros(0, int), 11, shift=math.pi**2)[6:]


def tapered_membrane(n: int) -> np.ndarray:
    """FV32, held at its wide end, plane stress: no motion of the middle plane along its normal."""
    nodes, elements = box_mesh((10.0, 1.0, 0.05), (n, n // 2, 2))
    nodes[:, 1] = (nodes[:, 1] - 0.5) * (5.0 - 0.4 * nodes[:, 0])
    middle = 3 * np.flatnonzero(np.isclose(nodes[:, 2], 0.025)) + 2
    held = np.union1d(unknowns(np.flatnonzero(nodes[:, 0] == 0)), middle)
    return plate_frequencies(nodes, elements, held, 6)


SUBJECTS = (
    Subject("Reduction", (
        Check("bar of 10 elements, full model, modes 1 to 6", COFE, "Hz",
              (349.7288, 2167.324, 6007.803, 11650.23, 19044.54, 28065.27), 1e-5, full_bar,
              "test_reduction.py::test_full_bar_agrees_with_the_published_run"),
        Check("the same bar in two parts, Guyan condensation", COFE, "Hz",
              (359.0738, 2934.100), 1e-5, lambda: two_part_bar(0, 2),
              "test_reduction.py::test_two_part_bar_agrees_with_the_published_run"),
        Check("the same bar in two parts, Craig-Bampton, 1 mode(s) per part", COFE, "Hz",
              (349.7555, 2182.490, 6733.634, 18222.00), 1e-5, lambda: two_part_bar(1, 4),
              "test_reduction.py::test_two_part_bar_agrees_with_the_published_run"),
        Check("the same bar in two parts, Craig-Bampton, 2 mode(s) per part", COFE, "Hz",
              (349.7299, 2168.126, 6011.365, 11851.45, 21809.58, 48160.41), 1e-5, lambda: two_part_bar(2, 6),
              "test_reduction.py::test_two_part_bar_agrees_with_the_published_run"),
        Check("the same bar in two parts, Craig-Bampton, 3 mode(s) per part", COFE, "Hz",
              (349.7289, 2167.436, 6008.068, 11670.88, 19073.61, 28653.90), 1e-5, lambda: two_part_bar(3, 6),
              "test_reduction.py::test_two_part_bar_agrees_with_the_published_run"),
    )),
    Subject("Solid elements", (
        Check("FV16 thin cantilever plate, modes 1 to 6", NAFEMS, "Hz",
              (0.421, 1.029, 2.582, 3.306, 3.753, 6.555), 1e-2, lambda: cantilever_plate(40),
              "test_reduction.py::test_nafems_fv16_thin_cantilever_plate"),
        Check("FV12 free thin square plate, modes 4 to 8 (closed form)", NAFEMS, "Hz",
              (1.622, 2.360, 2.922, 4.233, 4.233), 1e-2, lambda: free_plate(40),
              "test_reduction.py::test_nafems_free_thin_plate"),
        Check("the same plate", "Barton (1951), J. Appl. Mech. 18, 129-134 (λ² 13.49, 19.79, 24.43, 35.02)", "Hz",
              (1.624, 2.383, 2.942, 4.217, 4.217), 1e-2, lambda: free_plate(40),
              "test_reduction.py::test_nafems_free_thin_plate"),
        Check("FV32 tapered membrane, modes 1 to 6", NAFEMS, "Hz",
              (44.623, 130.03, 162.70, 246.05, 379.90, 391.44), 1e-2, lambda: tapered_membrane(16),
              "test_reduction.py::test_nafems_fv32_tapered_membrane"),
    ), cheap=False),
)  # fmt: skip
