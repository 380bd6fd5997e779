"""Step `casing mesh`: solid elements of the housing. Sensors do not enter here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.casing.meshing.mesh import CasingMesh, MeshError
from fem.casing.meshing.sizes import Sizes
from fem.casing.meshing.source import Geometry, mesh_geometry
from pipelines.border.errors import WorkError

if TYPE_CHECKING:
    from fem.casing.mesh_error.extrapolation import LowestModes


@dataclass(frozen=True, kw_only=True)
class CasingMeshSpec:
    """A housing without sensors, the wanted edge lengths of the elements and their kind."""

    housing: Geometry
    sizes: Sizes
    element: str


@dataclass(frozen=True, kw_only=True)
class AskedMeshSpec:
    """As `CasingMeshSpec` with the largest lengths; the error of the frequencies up to `band` (Hz, 0: of all modes)."""

    housing: Geometry
    sizes: Sizes
    element: str
    error: float
    band: float


def build(spec: CasingMeshSpec) -> CasingMesh:
    """The mesh."""
    return mesh_geometry(spec.housing, spec.sizes, spec.element)


def build_coarser(spec: CasingMeshSpec) -> CasingMesh:
    """A mesh that the errors of a finer one are measured by.

    Raises
    ------
    WorkError : elements as large as that make no sound mesh
    """
    try:
        return mesh_geometry(spec.housing, spec.sizes, spec.element)
    except MeshError as error:
        raise WorkError(
            f"casing: its error is estimated with a coarser mesh of {1000 * spec.sizes.element:.3g} mm, which fails: "
            f"{error}. Set a smaller casing.element_size_mm, or remove casing.extrapolated and "
            "casing.error from the scene"
        ) from error


def build_asked(spec: AskedMeshSpec, *, trial: LowestModes, coarser: Sequence[LowestModes]) -> CasingMesh:
    """The mesh whose size was predicted to have the error.

    Raises
    ------
    WorkError : no size has it, or the mesh would be too large
    """
    from fem.casing.mesh_error.extrapolation import ExtrapolationError, limits_from
    from fem.casing.mesh_error.frequency_limits import LEAST_MODES
    from fem.casing.mesh_error.wanted_size import wanted_factor

    count = int((trial.frequencies <= spec.band).sum()) if spec.band else len(trial.frequencies)
    inside = slice(max(count, 2 * LEAST_MODES))
    try:
        limits = limits_from(trial.frequencies[inside], trial.shapes[:, inside], trial.element_size, coarser)
        factor = wanted_factor(limits, spec.error, trial, coarser[0])
    except ExtrapolationError as error:
        raise WorkError(str(error)) from error
    return mesh_geometry(spec.housing, spec.sizes.times(factor), spec.element)
