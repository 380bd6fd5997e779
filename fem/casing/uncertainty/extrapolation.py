"""Stiffness of a casing extrapolated to zero element size (Richardson), from its natural modes on coarser meshes.

Displacement elements are too stiff. The lowest modes on coarser meshes, with elements 1.3 and 1.7 times as large, are
paired by their shapes. They give the extrapolated frequency and uncertainty band of every mode
(`fem.casing.uncertainty.limits_by_element`). For cubic elements the modes of quadratic ones on the same mesh are used
(`fem.casing.uncertainty.cubic_limits`). The formula is in `fem.casing.uncertainty.frequency_limits`.

The error of thin walls and sharp edges is nearly the same for all modes. One factor, from the mean relative difference
m of frequencies and extrapolated frequencies, therefore corrects all of the stiffness: K = (1 - m)^2 K(h); mass and
shapes are unchanged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from threadpoolctl import threadpool_limits

from fem.casing.parts.casing_choices import Ground
from fem.casing.reduced.casing_modes import CasingModes
from fem.casing.reduced.grounded import AssembledCasing
from fem.casing.reduced.halves import lowest, reduced_and_counted
from fem.casing.reduced.reduced_body import MODES_OVER_BAND
from fem.casing.reduced.reduction import Reduction
from fem.casing.reduced.undamped_modes import undamped_modes
from fem.casing.uncertainty.cubic_limits import cubic_limits
from fem.casing.uncertainty.frequency_limits import LEAST_MODES, FrequencyLimits, LimitError
from fem.casing.uncertainty.limits_by_element import extrapolation_of
from fem.casing.uncertainty.pairing import counterparts, sample_nodes
from fem.elements.solid_elements import SOLIDS
from fem.numerics.unknowns import unknowns_of
from fem.storage.records import Record, array, integer, scalar, text

MODES = 60  # lowest natural modes that are compared
LARGEST = 0.25  # largest change of a frequency between meshes for extrapolation
_GUARD = 12  # additional modes in the iteration: the last ones of a block converge least
RIGID_MOTIONS = 6  # motions of a casing on springs, independent of its stiffness


class ExtrapolationError(ValueError):
    """The frequencies of the meshes cannot be extrapolated."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LowestModes(Record):
    """Lowest natural modes on one mesh, at the nodes of `pairing.sample_nodes`."""

    frequencies: np.ndarray = array("mode", units="Hz")
    shapes: np.ndarray = array("sample", "mode", units="1")  # displacements along x, y, z of every node
    element_size: float = scalar(units="m")
    unknowns: int = integer()
    element: str = text()  # of `fem.elements.solid_elements.SOLIDS`


def lowest_modes(assembled: AssembledCasing, *, static: bool) -> LowestModes:
    """The lowest modes of a casing on a coarser mesh, or on the same one without cubic displacements.

    Parameters
    ----------
    assembled : the casing
    static : use the matrices condensed to the interface, as in the model `static`

    Raises
    ------
    as `reduced_and_counted`
    """
    ground = assembled.ground
    with threadpool_limits(1):  # the expensive steps run in two parallel halves
        if ground == "fixed" and not static:  # definite: no interface needs to be held
            theta, phi = lowest(assembled.subspaces, MODES)
            frequencies = 1.0 / (2.0 * np.pi * np.sqrt(theta))
        else:
            count = 0 if static else 2 * MODES  # enough for a negligible error in the lowest half
            loads = np.zeros((assembled.unknowns, 0))
            reduction, _ = reduced_and_counted(assembled.subspaces, loads, highest=None, count=count)
            frequencies, vectors = _elastic(reduction.stiffness, reduction.mass, ground)
            phi = reduction.expanded(vectors)
    return _sampled(assembled, frequencies, phi)


def quadratic_modes(
    quadratic: AssembledCasing, cubic: np.ndarray, reduction: Reduction, *, static: bool
) -> LowestModes:
    """The modes of a casing without the cubic displacements of its elements, from those with them.

    The latter, X with omega, are so close that one inverse iteration is sufficient,

        Y = (K + B^T D B)^-1 (M X omega^2 + B^T D B X),

    followed by Rayleigh's method in the span of Y (Bathe 2014, Finite Element Procedures, section 11.6). On the shipped
    hoist the error of the frequencies is 3e-6, for differences to those of X of 2e-3 to 6e-3.

    Parameters
    ----------
    quadratic : the casing without cubic displacements
    cubic : bool (n,), its unknowns with them that are cubic displacements
    reduction : of the casing with them
    static : as in `lowest_modes`

    Raises
    ------
    as `reduced_and_counted`
    """
    if static:
        return lowest_modes(quadratic, static=True)
    squares, vectors = (
        some[..., : RIGID_MOTIONS + MODES + _GUARD] for some in la.eigh(reduction.stiffness, reduction.mass)
    )
    X = reduction.expanded(vectors)[~cubic]
    M, B, D = quadratic.M_free, quadratic.rows, quadratic.springs[:, None]
    loads = M @ (X * squares) + B.T @ (D * (B @ X))
    Y = reduced_and_counted(quadratic.subspaces, loads, highest=None)[0].loaded
    K_small = Y.T @ loads - (B @ Y).T @ (D * (B @ Y))
    frequencies, small = _elastic(0.5 * (K_small + K_small.T), Y.T @ (M @ Y), quadratic.ground)
    return _sampled(quadratic, frequencies, Y @ small)


def _sampled(casing: AssembledCasing, frequencies: np.ndarray, vectors: np.ndarray) -> LowestModes:
    unknowns = unknowns_of(sample_nodes(casing.mesh.nodes))
    return LowestModes(
        frequencies=frequencies,
        shapes=casing.expanded(vectors)[unknowns],
        element_size=casing.mesh.element_size,
        unknowns=casing.unknowns,
        element=casing.mesh.element.name,
    )


def measured_limits(modes: CasingModes, coarser: Sequence[LowestModes]) -> FrequencyLimits:
    """Extrapolated frequencies and bands of the lowest natural modes of a casing, without rigid motions on springs.

    Parameters
    ----------
    modes : of the finest mesh
    coarser : modes on meshes of elements `RATIOS` times as large, in this order, or those of quadratic elements
        on the same mesh

    Raises
    ------
    ExtrapolationError : a coarser mesh is not stiffer, or the change exceeds `LARGEST`
    """
    frequencies, vectors = _elastic(modes.stiffness, modes.mass, modes.ground)
    if modes.band_limit:
        known = max(2 * LEAST_MODES, int((frequencies <= modes.band_limit / MODES_OVER_BAND).sum()))
        frequencies, vectors = frequencies[:known], vectors[:, :known]
    basis = modes.basis[sample_nodes(modes.nodes)].astype(float)
    return limits_from(frequencies, basis.reshape(-1, basis.shape[2]) @ vectors, modes.element_size, coarser)


def limits_from(
    frequencies: np.ndarray, shapes: np.ndarray, element_size: float, coarser: Sequence[LowestModes]
) -> FrequencyLimits:
    """`measured_limits` from given frequencies and shapes.

    Parameters
    ----------
    frequencies, shapes : (mode,) Hz and (k, mode) on the finest mesh
    element_size : of that mesh, m
    coarser : those of `measured_limits`

    Raises
    ------
    as `measured_limits`
    """
    rows = [frequencies]
    for other in coarser:
        number = counterparts(shapes, other.shapes)
        rows.append(np.where(number < 0, np.nan, other.frequencies[number]))
    ratios = [other.element_size / element_size for other in coarser]
    same_mesh = ratios == [1.0]
    try:
        if same_mesh:
            limits = cubic_limits(*rows, corners=SOLIDS[coarser[0].element].corners)
        else:
            limits = extrapolation_of(coarser[0].element)((1.0, *ratios), np.array(rows))
    except LimitError as error:
        raise ExtrapolationError(f"casing: {error}; or set casing.extrapolated = false") from error
    changes = np.nanmean(np.array(rows[1:]) / frequencies, axis=1) - 1.0
    largest = int(changes.argmax())
    if not 0.0 <= changes[largest] <= LARGEST:
        others = "quadratic elements" if same_mesh else f"elements {ratios[largest]:.3g} times as large"
        raise ExtrapolationError(
            f"casing: {others} change the first {len(frequencies)} frequencies by "
            f"{100 * changes[largest]:+.2g} % (0 to {100 * LARGEST:g} % can be extrapolated). Use a smaller "
            "casing.element_size_mm, or set casing.extrapolated = false"
        )
    return limits


def stiffness_factor(limits: FrequencyLimits) -> float:
    """Factor of the stiffness that removes the mean difference of frequencies and extrapolated frequencies."""
    return (1.0 - limits.correction) ** 2


def _elastic(stiffness: np.ndarray, mass: np.ndarray, ground: Ground | str) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,) in Hz and vectors (coordinate, m) of the lowest `MODES` elastic modes, or of all."""
    first = RIGID_MOTIONS if ground == "springs" else 0
    frequencies, vectors = undamped_modes(stiffness, mass)
    return frequencies[first : first + MODES], vectors[:, first : first + MODES]
