"""Reduction of imported matrices at the command line: retained nodes, file of the result, and its frequency errors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fem.casing.imported.imported_body import ImportedBody
from fem.casing.imported.matrix_checks import frequency_lines, lowest_frequencies
from fem.casing.reduced.reduction import Reduction
from pipelines.io.errors import InputError
from pipelines.io.user_files import whole_file


def write_reduced(
    body: ImportedBody, keep: Sequence[int], hold: Sequence[int], band: float, target: Path
) -> tuple[Reduction, np.ndarray]:
    """Reduce matrices to all equations of given nodes and the fixed-interface modes up to a band; write them as HDF5.

    The file can be imported as a casing.

    Parameters
    ----------
    body : the imported matrices
    keep, hold : numbers of the nodes that are kept as coordinates, and of those that are fixed to the ground
    band : Hz
    target : file of stiffness, mass, nodes and equations, SI

    Returns
    -------
    The reduction, and the free equations (n,) of the body

    Raises
    ------
    InputError : unknown nodes, or a body that can still move if these nodes are held
    """
    import scipy.sparse as sp

    from fem.casing.reduced.reduced_body import MODES_OVER_BAND
    from fem.casing.reduced.reduction import ReductionError, held_interface, reduce_body
    from fem.numerics.linear_solver import SingularMatrixError

    for number in (*keep, *hold):
        body.place(number)
    free = np.flatnonzero(~(np.isin(body.node, hold) & (body.axis >= 0)))
    kept = np.flatnonzero(np.isin(body.node[free], keep) & (body.axis[free] >= 0))
    K, M = body.stiffness[free][:, free], body.mass[free][:, free]
    rows = sp.csr_matrix((np.ones(len(kept)), (np.arange(len(kept)), kept)), shape=(len(kept), len(free)))
    penalty = np.maximum(K.diagonal()[kept], 1e-6 * K.diagonal().max())
    try:
        interface = held_interface(K, rows, penalty=penalty)
        reduction = reduce_body(interface, K, M, highest=MODES_OVER_BAND * band)
    except (ReductionError, SingularMatrixError) as error:
        raise InputError(
            f"{body.name}: keeping nodes {list(keep)} does not hold the body ({error}). Keep more nodes, or hold some."
        ) from error
    modal = len(reduction.frequencies)
    equations = np.vstack(
        [np.column_stack([body.node[free][kept], body.axis[free][kept] + 1]), np.zeros((modal, 2), int)]
    )
    chosen = np.isin(body.numbers, keep)
    _write(target, reduction, equations, np.column_stack([body.numbers[chosen], body.places[chosen]]))
    return reduction, free


def _write(target: Path, reduction: Reduction, equations: np.ndarray, nodes: np.ndarray) -> None:
    import h5py

    target.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(target) as partial, h5py.File(partial, "w") as file:
        file["stiffness"], file["mass"] = reduction.stiffness, reduction.mass
        file["equations"] = equations
        if np.isfinite(nodes).all():
            file["nodes"] = nodes
        file.attrs["units"] = "kg-m-s"


def held_text(body: ImportedBody, hold: Sequence[int], count: int = 20) -> str:
    """Text of the lowest natural frequencies with given nodes fixed, for comparison with other programs.

    Raises
    ------
    ForeignError : unknown nodes
    """
    for number in hold:
        body.place(number)
    free = np.flatnonzero(~(np.isin(body.node, hold) & (body.axis >= 0)))
    found, _ = lowest_frequencies(body.stiffness[free][:, free], body.mass[free][:, free], count)
    return "\n".join([f"  with the nodes {', '.join(map(str, hold))} held, Hz:", *frequency_lines(found)])


def reduced_text(body: ImportedBody, made: tuple[Reduction, np.ndarray], band: float) -> str:
    """Text with the number of coordinates, and the largest error of the natural frequencies in the band."""
    import scipy.sparse as sp

    reduction, free = made
    b, modes = reduction.constraint.shape[1], reduction.n_fixed
    whole, _ = lowest_frequencies(body.stiffness[free][:, free], body.mass[free][:, free], 60)
    small, _ = lowest_frequencies(sp.csr_matrix(reduction.stiffness), sp.csr_matrix(reduction.mass), 60)
    inside = (whole[: len(small)] <= band) & (whole[: len(small)] > 1e-3 * whole.max(initial=1e-300))
    count = int(inside.sum())
    errors = small[: len(inside)][inside] / whole[: len(inside)][inside] - 1.0
    worst = f", largest error {abs(errors).max():.1e}" if count else ""
    return (
        f"reduced to {b} coordinates of nodes, {modes} fixed-interface modes to 1.5 x {band:g} Hz and "
        f"{len(reduction.frequencies) - modes} inertia corrections; "
        f"{count} frequencies of the whole body in the band{worst}"
    )
