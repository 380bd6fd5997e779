"""What functions of edges are worth: python -m benchmarks.bracket.

An angle bracket of legs of 100 mm, 20 mm thick and 60 mm wide, the end of one leg clamped: one re-entrant edge and the
rim of the clamped face. Its first six natural frequencies with and without the functions (`fem.casing.enrichment`),
over those of smaller elements with them. Displacements are continuous in all cases: every frequency is an upper bound.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from benchmarks.solids import box_mesh
from fem.casing.enrichment.added_unknowns import added_functions
from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.mesh.mesh import CasingMesh
from fem.casing.reduced.lanczos import block_lanczos
from fem.elements.materials import CAST_IRON
from fem.numerics.linear_solver import factorize

LEG, WIDTH, THICKNESS = 0.1, 0.06, 0.02  # m
END = "ground_1"
DIVISIONS, FINEST = (1, 2, 4), 6  # elements through the thickness
MODES = 6


def bracket(
    divided: int = 1, element: str = "hexahedron-20", move: Callable[[np.ndarray], np.ndarray] | None = None
) -> CasingMesh:
    """Hexahedra, so many through the thickness; the edge is at x = z = THICKNESS, the clamped end at x = LEG.

    Parameters
    ----------
    divided, element : number of elements through the thickness, and their kind
    move : places (n, 3) of the nodes, m, to other ones
    """
    counts = tuple(divided * round(side / THICKNESS) for side in (LEG, WIDTH, LEG))
    nodes, elements = box_mesh((LEG, WIDTH, LEG), counts, element=element)
    middle = nodes[elements[:, :8]].mean(axis=1)
    used, flat = np.unique(elements[middle[:, [0, 2]].min(axis=1) < THICKNESS], return_inverse=True)
    places = nodes[used]
    on_end = np.flatnonzero(abs(places[:, 0] - LEG) < 1e-9)
    return finished_mesh(
        RawMesh(
            nodes=places if move is None else move(places),
            elements=flat.reshape(-1, elements.shape[1]),
            node_sets={"end": on_end},
        ),
        lambda surface: ({END: np.flatnonzero(surface.groups["end"])}, {END: np.zeros(3)}),
        name="bracket",
        element=element,
        element_size=THICKNESS / divided,
        remedy="",
    )


def matrices(mesh: CasingMesh, *, functions: bool = True) -> tuple[sp.csr_matrix, sp.csr_matrix, np.ndarray]:
    """Stiffness and mass, and the unknowns that are not clamped."""
    added = added_functions(mesh if functions else replace(mesh, cubic=0), CAST_IRON, held=(END,))
    K, M = added.matrices()
    clamped = (3 * np.unique(mesh.patch(END))[:, None] + np.arange(3)).ravel()
    if not functions:
        n = 3 * len(mesh.nodes)
        K, M = K[:n, :n], M[:n, :n]
    return K, M, np.setdiff1d(np.arange(K.shape[0]), clamped)


def frequencies(mesh: CasingMesh, *, functions: bool = True) -> tuple[np.ndarray, int]:
    """Hz of the lowest modes, and the number of unknowns."""
    K, M, free = matrices(mesh, functions=functions)
    theta, _ = block_lanczos(factorize(K[free][:, free]).solve, M[free][:, free], count=MODES)
    return 1.0 / (2.0 * math.pi * np.sqrt(theta)), len(free)


def main() -> int:
    """Print the errors."""
    exact, unknowns = frequencies(bracket(FINEST))
    print(
        f"{1000 * THICKNESS / FINEST:.3g} mm with functions, {unknowns} unknowns: {exact.round(2)} Hz; over these, in %"
    )
    for divided in DIVISIONS:
        for functions in (False, True):
            found, unknowns = frequencies(bracket(divided), functions=functions)
            words = "with functions" if functions else "without       "
            print(f"{1000 * THICKNESS / divided:4.3g} mm {words} {unknowns:6d}: {(100 * (found / exact - 1)).round(3)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
