"""Stage `casing mesh`: solid elements of a housing, coarser meshes for its error, and a mesh for a required error.

It does not depend on sensors.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from fem.casing.models.stage import CasingError, Stage
from fem.storage.ledger import count

if TYPE_CHECKING:
    from fem.casing.mesh.choose_mesher import Geometry
    from fem.casing.mesh.mesh import CasingMesh
    from fem.casing.mesh.sizes import Sizes
    from fem.casing.uncertainty.extrapolation import LowestModes

_SMALLER = (1.0, 0.97, 0.94, 0.91)  # factors of the size of a coarser mesh, tried in turn


@dataclass(frozen=True, kw_only=True)
class Meshing(Stage):
    """A housing without sensors, the edge lengths of its elements and their kind."""

    kind: ClassVar[str] = "casing-mesh"
    libraries: ClassVar[tuple[str, ...]] = ("numpy", "gmsh", "meshio", "scikit-fem")
    housing: Geometry
    sizes: Sizes
    element: str

    def build(self) -> CasingMesh:
        """The mesh."""
        return self.with_sizes(self.sizes)

    def with_sizes(self, sizes: Sizes) -> CasingMesh:
        """The mesh with other edge lengths."""
        from fem.casing.mesh.choose_mesher import mesh_geometry

        mesh = mesh_geometry(self.housing, sizes, self.element)
        count("casing_meshes")  # here, because the mesher may work in its own process
        return mesh

    def coarser(self) -> Iterator[CoarserMeshing]:
        """Stages of meshes with larger elements, for the error estimate of this one."""
        from fem.casing.uncertainty.limits_by_element import RATIOS

        return (CoarserMeshing(**{**vars(self), "sizes": self.sizes.times(ratio)}) for ratio in RATIOS)


@dataclass(frozen=True, kw_only=True)
class CoarserMeshing(Meshing):
    """A coarser mesh for the error estimate of a finer one.

    The mesher fails with single sizes: with 1 of 51 sizes between 15 and 48 mm on a box with bores. If it fails, the
    elements are made smaller; the extrapolation takes their actual size.
    """

    def build(self) -> CasingMesh:
        """The mesh. CasingError if none of the sizes forms a valid mesh."""
        from fem.casing.mesh.mesh import MeshError

        for factor in _SMALLER:
            try:
                return self.with_sizes(self.sizes.times(factor))
            except MeshError as error:
                failed = error
        raise CasingError(
            "casing: its error is estimated with a coarser mesh of "
            f"{1000 * self.sizes.element:.3g} mm or slightly less, which fails: {failed}. Set another "
            "casing.element_size_mm, or casing.extrapolated = false without casing.error (with --set they override a "
            "--preset)"
        ) from failed


@dataclass(frozen=True, kw_only=True)
class SizedMeshing(Meshing):
    """A mesh whose element size follows from the target `error` of the frequencies up to `band` (Hz, 0: of all modes).

    `sizes` are upper limits.
    """

    kind: ClassVar[str] = "casing-asked-mesh"
    error: float
    band: float

    def build(  # type: ignore[override]
        self, *, trial: LowestModes, coarser: Sequence[LowestModes]
    ) -> CasingMesh:
        """The mesh.

        Parameters
        ----------
        trial, coarser : modes on the mesh with the largest sizes, and on the meshes for its error estimate

        Raises
        ------
        CasingError : no size reaches the target error, or the mesh would be too large
        """
        from fem.casing.uncertainty.extrapolation import ExtrapolationError, limits_from
        from fem.casing.uncertainty.frequency_limits import LEAST_MODES
        from fem.casing.uncertainty.target_size import target_factor

        count = int((trial.frequencies <= self.band).sum()) if self.band else len(trial.frequencies)
        inside = slice(max(count, 2 * LEAST_MODES))
        try:
            limits = limits_from(trial.frequencies[inside], trial.shapes[:, inside], trial.element_size, coarser)
            factor = target_factor(limits, self.error, trial, coarser[0])
        except ExtrapolationError as error:
            raise CasingError(str(error)) from error
        return self.with_sizes(self.sizes.times(factor))
