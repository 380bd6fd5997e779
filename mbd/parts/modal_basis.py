"""Modal coordinates of the linear reference system.

q = Phi p with the undamped modes below a band plus the static responses to every force that can act, orthonormal in
the mass and diagonal in the stiffness: M -> 1, K -> diag(omega^2). Static equilibrium is exact whatever the band.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg

from mbd.parts.part_checks import MachineError

SMALLEST_FREQUENCY = 1e-2  # Hz: below it a coordinate counts as free
INDEPENDENT = 1e-6  # static responses closer to the others than this are dropped
LARGEST_BLUR = 0.5  # Hz: at ten times this value the error of a frequency is 0.5 %


def modal_basis(
    mass: np.ndarray,
    stiffness: np.ndarray,
    forces: np.ndarray,
    band: float,
    names: tuple[str, ...],
    rolling: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Phi (coordinate, mode) and omega (mode,), rad/s, ascending.

    Parameters
    ----------
    mass, stiffness : (coordinate, coordinate), symmetric
    forces : (coordinate, force), patterns whose static response is kept exactly
    band : Hz, modes above it are left out; inf keeps all
    names : (coordinate,), for messages
    rolling : (coordinate,) motion that nothing holds and that is left out: the modes are orthogonal to it in the mass;
        None: everything is held

    Raises
    ------
    MachineError : the mass is not positive definite, a motion has next to no mass, or one has no stiffness
    """
    span = np.eye(len(mass)) if rolling is None else linalg.null_space((mass @ rolling)[None])
    try:
        squares, modes = linalg.eigh(span.T @ stiffness @ span, span.T @ mass @ span)
    except linalg.LinAlgError as error:
        i = int(np.argmin(np.diag(mass)))
        raise MachineError(
            f"mass matrix: not positive definite (smallest diagonal {mass[i, i]:.3g} at {names[i]}). "
            "Check densities and the casing's mass."
        ) from error
    lowest, modes = squares[0], span @ modes
    _check_blur(squares, modes[:, -1], mass, names)
    if lowest < (2 * np.pi * SMALLEST_FREQUENCY) ** 2:
        i = int(np.argmax(abs(modes[:, 0]) * np.sqrt(np.diag(mass))))
        raise MachineError(
            f"stiffness matrix: a motion dominated by {names[i]} has no stiffness (omega^2 = {lowest:.3g}). "
            "Hold it, e.g. by a bearing with axial stiffness or by a second bearing on the shaft."
        )
    keep = squares <= (2 * np.pi * band) ** 2 if np.isfinite(band) else np.ones(len(squares), dtype=bool)
    if keep.all():
        return modes, np.sqrt(squares)
    kept, rest = modes[:, keep], modes[:, ~keep]
    # static responses within the span of the modes left out: K^-1 f = sum phi (phi^T f)/omega^2
    answer = (rest.T @ forces) / squares[~keep][:, None]
    answer = answer / np.maximum(np.linalg.norm(answer, axis=0), np.finfo(float).tiny)
    left, size, _ = np.linalg.svd(answer, full_matrices=False)
    left = left[:, size > INDEPENDENT * size[0]]
    extra_squares, vectors = linalg.eigh(left.T @ (squares[~keep][:, None] * left))
    basis = np.hstack([kept, rest @ left @ vectors])
    return basis, np.sqrt(np.concatenate([squares[keep], extra_squares]))


def _check_blur(squares: np.ndarray, highest: np.ndarray, mass: np.ndarray, names: tuple[str, ...]) -> None:
    """Raise MachineError if a motion has so little mass that round-off of its omega^2 hides others: eps omega_max^2."""
    blur = float(np.sqrt(np.finfo(float).eps * max(squares[-1], 0.0))) / (2 * np.pi)
    if blur > LARGEST_BLUR:
        i = int(np.argmax(abs(highest) * np.sqrt(np.diag(mass))))
        raise MachineError(
            f"mass matrix: a motion dominated by {names[i]} has almost no mass. Its frequency is "
            f"{np.sqrt(squares[-1]) / (2 * np.pi):.3g} Hz, so that round-off hides frequencies below {blur:.3g} Hz "
            f"(limit {LARGEST_BLUR:g} Hz). Raise the density, or make sections and elements longer."
        )
