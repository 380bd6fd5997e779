"""Bodies whose stiffness and mass another program assembled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.casing.imported.reduce_at_points import Point as Point
from fem.storage import shown_html
from gearcase.errors import InputError


@dataclass(frozen=True, eq=False)
class ReducedMatrices:
    """A reduced body: SI, physical coordinates "<point>:<axis>" first, then "mode_1", ... and "inertia_1", ...

    >>> import gearcase
    >>> sorted(gearcase.ReducedMatrices.__dataclass_fields__)
    ['basis', 'coordinate_names', 'mass', 'report', 'stiffness']
    """

    stiffness: np.ndarray  # (coordinate, coordinate)
    mass: np.ndarray
    basis: np.ndarray  # (equation, coordinate): motion of the whole body, of equations that have stiffness or mass
    coordinate_names: tuple[str, ...]
    report: str  # the check-up of the matrices

    def __repr__(self) -> str:
        return f"<ReducedMatrices: {len(self.mass)} coordinates, from {len(self.basis)} equations>"

    def _repr_html_(self) -> str:
        """The coordinates with their stiffness and mass, for a notebook."""
        rows = zip(self.coordinate_names, self.stiffness.diagonal(), self.mass.diagonal(), strict=True)
        return shown_html.table(
            f"Reduced from {len(self.basis)} equations", ("coordinate", "K ii, SI", "M ii, SI"), rows
        )


def reduce(
    stiffness: sp.spmatrix,
    mass: sp.spmatrix,
    points: Mapping[str, Point],
    *,
    nodes: np.ndarray,
    equations: np.ndarray | None = None,
    units: str = "kg-m-s",
    held: Sequence[int] = (),
    band: float,
) -> ReducedMatrices:
    """Reduce a body to points by Craig-Bampton; RBE2 and RBE3 are made from the nodes of each point.

    The example has two masses of 1 kg in springs of 1000 N/m, one after the other, on a node that is held.

    Parameters
    ----------
    stiffness, mass : (n, n), symmetric or one triangle, of the free body
    points : by name: their nodes, place (m), axes that carry loads (of ux uy uz rx ry rz), coupling "mean" (RBE3) or
        "rigid" (RBE2)
    nodes : (k, 4) number and place, or (k, 3), numbered from 1; in the unit of length of the matrices
    equations : (n, 2) node and axis (1 to 6, 0 for a modal coordinate); by default three or six per node
    units : "kg-m-s", "t-mm-s", "kg-mm-ms", "kg-mm-s" or "lbf-in-s"
    held : numbers of nodes that the ground holds; without any, springs under the points hold it while it is factorised
    band : Hz, to which fixed-interface modes are kept

    Raises
    ------
    InputError : matrices, nodes or points that do not fit together, or a body that is not held

    >>> import gearcase
    >>> import numpy as np
    >>> import scipy.sparse as sp
    >>> chain = 1000.0 * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    >>> body = gearcase.reduce(
    ...     sp.csr_matrix(np.kron(chain, np.eye(3))),
    ...     sp.identity(9),
    ...     {"end": gearcase.Point(nodes=(3,), axes=("ux", "uy", "uz"))},
    ...     nodes=np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]),
    ...     held=(1,),
    ...     band=100.0,
    ... )
    >>> body.coordinate_names
    ('end:ux', 'end:uy', 'end:uz', 'mode_1', 'mode_2', 'mode_3')
    """
    from fem.casing.imported.imported_body import MatrixError, imported_body
    from fem.casing.imported.matrix_checks import check_matrices
    from fem.casing.imported.reduce_at_points import reduce_imported_body
    from fem.casing.reduced.reduction import ReductionError
    from fem.numerics.linear_solver import SingularMatrixError

    for name, point in points.items():
        if not isinstance(point, Point):
            raise InputError(f'points["{name}"] = {point!r}: must be a gearcase.Point. Give its nodes and its place.')
    try:
        body = imported_body("matrices", stiffness, mass, equations=equations, nodes=nodes, system=units)
        made = reduce_imported_body(body, points, held=held, sprung=() if held else tuple(points), band=band)
    except (MatrixError, ReductionError, SingularMatrixError) as error:
        raise InputError(str(error)) from error
    reduction = made.reduction
    modes, all_modes = reduction.n_fixed, len(reduction.frequencies)
    names = [f"mode_{i + 1}" for i in range(modes)] + [f"inertia_{i + 1}" for i in range(all_modes - modes)]
    return ReducedMatrices(
        stiffness=reduction.stiffness,
        mass=reduction.mass,
        basis=made.expansion @ reduction.basis,
        coordinate_names=(*made.coordinate_names, *names),
        report=check_matrices(body).report(),
    )
