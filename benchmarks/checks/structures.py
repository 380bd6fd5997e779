"""Beams, plates and reductions: a published superelement run and the NAFEMS free vibration benchmarks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from benchmarks.checks.record import Check, Values
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.reduction import craig_bampton
from fem.elements.tetrahedra import EDGES, assemble
from fem.numerics.linear_solver import factorize

REDUCTION, ELEMENTS = "Reduction", "Solid elements"
COFE = "MSC Nastran superelement run, published in vtpasquale/NASTRAN_CoFE (cantilever_bar)"
FULL = (349.7288, 2167.324, 6007.803, 11650.23, 19044.54, 28065.27)
TWO_PARTS = {
    0: (359.0738, 2934.100),
    1: (349.7555, 2182.490, 6733.634, 18222.00),
    2: (349.7299, 2168.126, 6011.365, 11851.45, 21809.58, 48160.41),
    3: (349.7289, 2167.436, 6008.068, 11670.88, 19073.61, 28653.90),
}
NAFEMS = "NAFEMS, The Standard NAFEMS Benchmarks, free vibration"
PLATE = {"elastic_modulus": 200e9, "poisson_ratio": 0.3, "density": 8000.0}


def _hertz(stiffness: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Frequencies of the motions that have mass (Hz)."""
    theta = la.eigvalsh(mass, stiffness)[::-1]
    return 1 / (2 * np.pi * np.sqrt(theta[theta > 1e-12 * theta[0]]))


def _bar(n: int) -> tuple[np.ndarray, np.ndarray]:
    """The planar bar of the run: n slender elements of length 1, lumped translational mass (its own unit system)."""
    element = 2.9e7 * 0.01 * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    stiffness, mass = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros((2 * n + 2, 2 * n + 2))
    for i in range(n):
        stiffness[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += element
        for node in (i, i + 1):
            mass[2 * node, 2 * node] += 7.357e-4 * 0.1 / 2
    return stiffness, mass


def _full_bar() -> Values:
    stiffness, mass = _bar(10)
    return [float(f) for f in _hertz(stiffness[2:, 2:], mass[2:, 2:])[:6]]


def _two_parts(n_modes: int) -> Callable[[], Values]:
    def compute() -> Values:
        stiffness, mass = _bar(5)
        clamped = craig_bampton(
            sp.csr_matrix(stiffness[2:, 2:]), sp.csr_matrix(mass[2:, 2:]), np.array([8, 9]), n_modes
        )
        free = craig_bampton(sp.csr_matrix(stiffness), sp.csr_matrix(mass), np.array([0, 1]), n_modes)
        size = 2 + 2 * n_modes
        k, m = np.zeros((size, size)), np.zeros((size, size))
        for part, start in ((clamped, 2), (free, 2 + n_modes)):
            place = np.r_[0:2, start : start + n_modes]
            k[np.ix_(place, place)] += part.stiffness
            m[np.ix_(place, place)] += part.mass
        return [float(f) for f in _hertz(k, m)[: len(TWO_PARTS[n_modes])]]

    return compute


def block(size: tuple[float, float, float], divisions: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and ten-node tetrahedra (e, 10) of a box from the origin, six to a cell (Kuhn's cut)."""
    counts = np.array(divisions) + 1
    axes = [np.linspace(0.0, length, count) for length, count in zip(size, counts, strict=True)]
    corners = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    index, parts = np.arange(counts.prod()).reshape(counts), []
    for order in itertools.permutations(range(3)):
        steps = np.vstack([np.zeros(3, int), np.cumsum(np.eye(3, dtype=int)[list(order)], axis=0)])
        if la.det(steps[1:]) < 0:
            steps[[1, 2]] = steps[[2, 1]]
        parts.append(np.column_stack([_shifted(index, step, divisions) for step in steps]))
    tetrahedra = np.vstack(parts)
    inverted = la.det(corners[tetrahedra[:, 1:]] - corners[tetrahedra[:, :1]]) < 0
    tetrahedra[inverted] = tetrahedra[inverted][:, [1, 0, 2, 3]]
    pairs, number = np.unique(np.sort(tetrahedra[:, EDGES].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    return (
        np.vstack([corners, corners[pairs].mean(axis=1)]),
        np.hstack([tetrahedra, len(corners) + number.reshape(-1, 6)]),
    )


def _shifted(index: np.ndarray, step: np.ndarray, divisions: tuple[int, int, int]) -> np.ndarray:
    return index[tuple(slice(s, s + d) for s, d in zip(step, divisions, strict=True))].ravel()


def _frequencies(
    nodes: np.ndarray, elements: np.ndarray, held: np.ndarray, count: int, shift: float = 0.0
) -> np.ndarray:
    """Lowest frequencies (Hz) with the unknowns `held` fixed; a free body needs a shift (1/s2)."""
    stiffness, mass = assemble(nodes, elements, **PLATE)
    free = np.setdiff1d(np.arange(3 * len(nodes)), held)
    stiffness, mass = stiffness[free][:, free], mass[free][:, free]
    theta, _ = block_lanczos(factorize((stiffness + shift * mass).tocsr(), block=1).solve, mass, count=count)
    return np.sqrt(np.maximum(1 / theta - shift, 0.0)) / (2 * math.pi)


def _unknowns(nodes: np.ndarray) -> np.ndarray:
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _cantilever_plate() -> Values:
    nodes, elements = block((10.0, 10.0, 0.05), (40, 40, 1))
    return [float(f) for f in _frequencies(nodes, elements, _unknowns(np.flatnonzero(nodes[:, 0] == 0)), 6)]


@cache
def _free_plate() -> Values:
    nodes, elements = block((10.0, 10.0, 0.05), (40, 40, 1))
    found = _frequencies(nodes, elements, np.zeros(0, int), 11, shift=math.pi**2)
    return [float(f) for f in found[6:]]


def _tapered_membrane() -> Values:
    nodes, elements = block((10.0, 1.0, 0.05), (16, 8, 2))
    nodes[:, 1] = (nodes[:, 1] - 0.5) * (5.0 - 0.4 * nodes[:, 0])
    middle = 3 * np.flatnonzero(np.isclose(nodes[:, 2], 0.025)) + 2
    held = np.union1d(_unknowns(np.flatnonzero(nodes[:, 0] == 0)), middle)
    return [float(f) for f in _frequencies(nodes, elements, held, 6)]


def checks() -> Iterator[Check]:
    """All rows of this subject."""
    yield Check(
        subject=REDUCTION,
        quantity="bar of 10 elements, full model, modes 1 to 6",
        source=COFE,
        unit="Hz",
        reference=FULL,
        gate=1e-5,
        compute=_full_bar,
        test="test_reduction.py::test_full_bar_agrees_with_the_published_run",
    )
    for n_modes, values in TWO_PARTS.items():
        kept = "Guyan condensation" if n_modes == 0 else f"Craig-Bampton, {n_modes} mode(s) per part"
        yield Check(
            subject=REDUCTION,
            quantity=f"the same bar in two parts, {kept}",
            source=COFE,
            unit="Hz",
            reference=values,
            gate=1e-5,
            compute=_two_parts(n_modes),
            test="test_reduction.py::test_two_part_bar_agrees_with_the_published_run",
        )
    for source, quantity, values, compute, test in (
        (
            NAFEMS,
            "FV16 thin cantilever plate, modes 1 to 6",
            (0.421, 1.029, 2.582, 3.306, 3.753, 6.555),
            _cantilever_plate,
            "test_nafems_fv16_thin_cantilever_plate",
        ),
        (
            NAFEMS,
            "FV12 free thin square plate, modes 4 to 8 (closed form)",
            (1.622, 2.360, 2.922, 4.233, 4.233),
            _free_plate,
            "test_nafems_free_thin_plate",
        ),
        (
            "Barton (1951), J. Appl. Mech. 18, 129-134 (λ² 13.49, 19.79, 24.43, 35.02)",
            "the same plate",
            (1.624, 2.383, 2.942, 4.217, 4.217),
            _free_plate,
            "test_nafems_free_thin_plate",
        ),
        (
            NAFEMS,
            "FV32 tapered membrane, modes 1 to 6",
            (44.623, 130.03, 162.70, 246.05, 379.90, 391.44),
            _tapered_membrane,
            "test_nafems_fv32_tapered_membrane",
        ),
    ):
        yield Check(
            subject=ELEMENTS,
            quantity=quantity,
            source=source,
            unit="Hz",
            reference=values,
            gate=1e-2,
            compute=compute,
            test=f"test_reduction.py::{test}",
            cheap=False,
        )
