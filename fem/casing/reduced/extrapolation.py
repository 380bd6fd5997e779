"""Stiffness of a casing extrapolated to elements of size zero, by the natural frequencies on a second, coarser mesh.

Elements of displacement are too stiff. On similar meshes of sizes h and R h a frequency is f = f_0 (1 + c h^p), so

    f_0 / f(h) = 1 - (q - 1) / (R^p - 1),    q = f(R h) / f(h)

The error of thin walls and sharp edges is nearly the same for all modes (its deviation from mode to mode is a fifth of
its mean), and the flexibility of the bearing seats has twice that of the frequencies. One factor, from the mean of q
over the lowest modes, therefore corrects all of the stiffness: K = (f_0 / f)^2 K(h); mass and shapes stay.

p is between 1.1, of a re-entrant right edge (Szabo & Babuska 1991, Finite Element Analysis, section 10.1: r^0.54), and
the 4 of smooth bodies. p = 2 is what the shipped housing shows (walls of 10 mm, seats with 0.4 of the element size),
mean of 20 modes against the value extrapolated from the two finest of the meshes with R = 1.5:

    elements, mm          33      27.5    22      17.6    14.1    11.5
    as computed, %       +4.5     +3.0   +1.9    +1.3    +0.9    +0.6
    extrapolated, %                      -0.1    +0.2    +0.2

Where the bores set the mesh more than the element size does, the two meshes differ by less than R and too little is
taken off, on the safe side: a small housing, 5.0, 1.9, 1.1 % with elements of 36, 18, 12 mm, keeps 1.8, 0.9, 0.5 %.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from threadpoolctl import threadpool_limits

from fem.casing.meshing.mesh import CasingMesh
from fem.casing.reduced.body import MODES_OVER_BAND
from fem.casing.reduced.grounded import Attachment, Ground, ground_casing
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.modes import CasingModes
from fem.casing.reduced.reduction import reduce_body
from fem.elements.materials import Material
from fem.storage.records import Record, array

RATIO = 1.5  # element sizes of the coarser mesh
ORDER = 2.0  # p of a natural frequency
MODES = 12  # lowest natural modes that are compared
_RIGID = 6  # motions of a casing on springs, which stand outside its own stiffness


class ExtrapolationError(ValueError):
    """Two meshes whose frequencies cannot be extrapolated."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LowestFrequencies(Record):
    """Lowest natural frequencies on a coarser mesh."""

    frequencies: np.ndarray = array("mode", units="Hz")


def lowest_frequencies(
    mesh: CasingMesh,
    material: Material,
    *,
    static: bool,
    interfaces: Mapping[str, Sequence[str]] | None = None,
    ground: Ground = "fixed",
    attachment: Attachment = "mean",
) -> LowestFrequencies:
    """The frequencies of a coarser mesh.

    Parameters
    ----------
    mesh, material : of the casing, the mesh with elements `RATIO` times as large
    static : take the matrices condensed to the interface, as the model static has
    interfaces, ground, attachment : those of `ground_casing`

    Raises
    ------
    as `ground_casing` and `reduce_body`
    """
    with threadpool_limits(1):  # the heavy steps run in two halves side by side
        casing = ground_casing(mesh, material, interfaces=interfaces, ground=ground, attachment=attachment)
        if ground == "fixed" and not static:  # definite as it stands: no interface needs to be held
            theta, _ = block_lanczos(casing.interface.factor.solve, casing.M_free, count=MODES)
            return LowestFrequencies(frequencies=1.0 / (2.0 * np.pi * np.sqrt(theta)))
        count = 0 if static else 3 * MODES  # as many as leave no error in the lowest third
        reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=count, enrich=not static)
    return LowestFrequencies(frequencies=_elastic(reduction.stiffness, reduction.mass, ground))


def stiffness_factor(modes: CasingModes, coarser: LowestFrequencies) -> float:
    """Factor of the stiffness of `modes`, by the frequencies of the mesh whose elements are `RATIO` times as large.

    Raises
    ------
    ExtrapolationError : the coarser mesh is not the stiffer one, or by more than an extrapolation can be trusted with
    """
    own = _elastic(modes.stiffness, modes.mass, modes.ground)
    known = int((own <= modes.band_limit / MODES_OVER_BAND).sum()) if modes.band_limit else own.size
    count = min(max(known, 1), own.size, coarser.frequencies.size)
    change = float((coarser.frequencies[:count] / own[:count]).mean()) - 1.0
    if not 0.0 <= change <= 0.25:
        raise ExtrapolationError(
            f"casing: elements {RATIO:g} times as large change the first {count} frequencies by {100 * change:+.2g} % "
            "(0 to 25 % can be extrapolated). Use a smaller casing.element_size_mm, or leave casing.extrapolated out"
        )
    return (1.0 - change / (RATIO**ORDER - 1.0)) ** 2


def _elastic(stiffness: np.ndarray, mass: np.ndarray, ground: Ground | str) -> np.ndarray:
    """Hz (MODES,) or fewer."""
    squares = la.eigvalsh(stiffness, mass)[_RIGID if ground == "springs" else 0 :][:MODES]
    return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)
