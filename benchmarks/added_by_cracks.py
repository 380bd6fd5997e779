"""What cracks add to the deflection of a tooth: model `solid` beside the stored tetrahedra of `cracked_teeth`."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
from scipy.linalg import cho_solve

from benchmarks.cracked_teeth import CASES, case_gear, places
from fem.contact.faults.cracked_tooth import CrackedTooth
from fem.contact.wheels.crack_surface import CrackSurface, CrackSurfaceSpec, crack_surface, load_weights, opened
from fem.elements.materials import STEEL
from fem.elements.twisted_hexahedra import slice_means

RESULTS = Path(__file__).resolve().parent / "results" / "cracked-teeth.json"
ON_CRACKED_HALF = slice(1, None, 2)  # of the six places


def added(found: CrackSurface, crack: CrackedTooth, where: list[tuple[float, float, float]]) -> np.ndarray:
    """Added compliance (place, place), m/N, between loads at arc lengths over parts of the face."""
    face = float(found.ends[-1] - found.ends[0])
    open_, factor = opened(found, lambda z: crack.depth_at(z, face), crack.reach(face))
    weights = load_weights(found, np.array([arc for arc, _, _ in where]))
    means = np.concatenate([slice_means(found.ends, np.array(ends)) for _, *ends in where])
    force = np.einsum("rag,pr,pa->gp", found.force[1], weights, means)[open_]
    return force.T @ cho_solve((factor, True), force)


@cache
def by_surface(name: str) -> np.ndarray:
    """Added compliance (6, 6) of a case, m/N, as model `solid` takes it."""
    gear, crack = case_gear(name), CASES[name]["crack"]
    spec = CrackSurfaceSpec(
        gear=gear, material=STEEL, angle=crack.angle, face_width=gear.face_width, refinement=0.7, axial_elements=6
    )
    tooth = CrackedTooth(depth=crack.depth, far_depth=crack.far_depth, extent=crack.extent, angle=crack.angle)
    return added(crack_surface(spec), tooth, places(gear))


def reference(name: str) -> np.ndarray:
    """Added compliance (6, 6) of the two stored meshes of a case, extrapolated to size 0, m/N.

    Displacements go with the square root of the distance from the front, so the energy that opens the crack, and with
    it the added compliance, converges with the first power of the size of the elements there, whatever their order
    (Babuska & Suri 1994, SIAM Review 36(4), 578-632).
    """
    coarse, fine = json.loads(RESULTS.read_text(encoding="utf-8"))[name]["meshes"]
    by_coarse, by_fine = (np.array(mesh["added_m_per_N"]) for mesh in (coarse, fine))
    return by_fine + (by_fine - by_coarse) * fine["size_mn"] / (coarse["size_mn"] - fine["size_mn"])


def seen(matrix: np.ndarray) -> list[float]:
    """nm/N: under an even load, seen as the mean of the six places, and at the places on the cracked half alone."""
    return (1e9 * np.array([matrix.mean(), *np.diag(matrix)[ON_CRACKED_HALF]])).tolist()
