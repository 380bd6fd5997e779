"""A crack in space as a few modes of added compliance, which represent it in a mesh law for all loads.

L is the Cholesky factor of the stiffness that resists the opening (`fem.contact.wheels.crack_surface`). The added
compliance between loads i, j is a_i . a_j, a = L^-1 F. Few directions u_k of the opening contribute nearly all of it:
the leading eigenvectors of the sum of a a^T over all loads, that is tooth pairs before, on and after the cracked tooth,
slices and positions. These fixed directions give the modes

    m_k(i) = u_k . a_i,    added displacement at i = sum_k m_k(i) sum_j m_k(j) F_j,

which are positive semidefinite, smooth in the position, and a lower bound of the added compliance.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.slice_frame import law_points
from fem.contact.wheels.crack_surface import CrackSurface, load_weights, opened
from fem.elements.twisted_hexahedra import slice_means
from fem.gears.geometry import GearPair

MODES = 5


def crack_modes(
    law: MeshLaw,
    pair: GearPair,
    gear: str,
    depth_at: Callable[[np.ndarray], np.ndarray],
    reach: tuple[float, float],
    surface: CrackSurface,
) -> np.ndarray:
    """Modes (mode, near, slice, position), (m/N)^(1/2), of a tooth of "pinion" or "wheel", see `fem.contact.law`.

    Parameters
    ----------
    law : of the flank of the crack mouth
    pair, gear : the gears in mesh, and the cracked one
    depth_at, reach : depth (m) of the crack at face coordinates (n,), and both ends (m) of the cracked part of the face
    surface : of that gear at the angle of the crack
    """
    from scipy.linalg import solve_triangular

    # the coordinate of the surface follows the twist of its gear: it is zeta for the pinion, -zeta for the wheel
    sense = law.cycle_sign * pair.pinion.hand_sign * (1 if gear == "pinion" else -1)
    low, high = sorted(sense * y for y in reach)
    open_, factor = opened(surface, lambda place: depth_at(sense * place), (low, high))
    bounds = np.append(law.face_coordinate - law.slice_width / 2, law.face_coordinate[-1] + law.slice_width[-1] / 2)
    means = slice_means(surface.ends, np.sort(sense * bounds))[::sense]
    points, own = law_points(law, pair), getattr(pair, gear)
    radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
    weights = load_weights(surface, (radius**2 - own.base_radius**2).clip(0.0) / (2 * own.base_radius))
    # pair p + n, which follows, has tooth -n of the pinion and n of the wheel, counted towards the loaded flank
    force = surface.force[:: -1 if gear == "pinion" else 1][..., open_]
    held = solve_triangular(factor, force.reshape(-1, len(open_)).T, lower=True).reshape(len(open_), *force.shape[:3])
    loaded = weights[np.isfinite(law.gap)]
    seen = np.einsum("onra,rt,ab->ontb", held, _root(loaded.T @ loaded), _root(means.T @ means), optimize=True)
    seen = seen.reshape(len(open_), -1)
    kept = np.linalg.svd(seen, full_matrices=False)[0][:, :MODES]
    modes = np.einsum("ok,onra,xr,sa->knsx", kept, held, weights, means, optimize=True)
    out = np.zeros((MODES, *modes.shape[1:]))
    out[: len(modes)] = modes
    return out


def _root(matrix: np.ndarray) -> np.ndarray:
    """R with R R^T = matrix, positive semidefinite."""
    size, direction = np.linalg.eigh(matrix)
    return direction * np.sqrt(size.clip(0.0))
