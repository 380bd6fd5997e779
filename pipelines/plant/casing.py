"""The casing of a scene, in SI: its housing, how it is meshed, what holds it, how it is reduced."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem.casing.geometry.housing import Housing
from fem.casing.meshing.sizes import Sizes, bending_wavelength
from fem.casing.meshing.source import Geometry
from fem.casing.models.registry import elastic_casing
from fem.elements.materials import Material
from pipelines.border.errors import Problem, SceneError
from pipelines.plant.bearings import bearing_points
from pipelines.plant.housing import housing
from pipelines.plant.layout import Layout, material
from pipelines.plant.units import si_options
from pipelines.scene.scene import Scene
from pipelines.scene.tables.casing import (
    CraigBamptonCasingTable,
    ElasticBase,
    FlexibleBase,
    NoCasingTable,
    RigidCasingTable,
    StaticCasingTable,
    percent,
)
from pipelines.scene.tables.housing import ImportedTable, MatricesHousingTable

if TYPE_CHECKING:
    from fem.casing.foreign.casing import ForeignHousing
    from fem.casing.models.elastic_casing import ElasticCasing
    from fem.casing.reduced.damping import DampingRatio

_NOT_REDUCED = ("model", "frequency_error", "elements_per_wavelength")  # keys of a model's table: of its body, its mesh


@dataclass(frozen=True, kw_only=True)
class RigidBox:
    """A plain box as a rigid casing on its mounts (N/m each); formulas give its mass."""

    geometry: Housing
    material: Material
    mount_stiffness: float
    damping: DampingRatio


@dataclass(frozen=True, kw_only=True)
class RigidMeshed:
    """A rigid casing on its mounts (N/m each) whose mass comes from a mesh of it."""

    geometry: Geometry
    material: Material
    sizes: Sizes
    element: str
    mount_stiffness: float
    damping: DampingRatio


@dataclass(frozen=True, kw_only=True)
class ElasticPart:
    """A casing of finite elements, reduced by its `model`.

    `loss_factors` of the parts that have their own; `mounts` in N/m, a row for all feet or one per foot, None on fixed
    ground. `error`: median band of the frequencies that the mesh is made for, None where its size is given.
    """

    model: ElasticCasing
    geometry: Geometry
    material: Material
    sizes: Sizes
    element: str
    damping: DampingRatio
    loss_factors: Mapping[str, float]
    mounts: tuple[tuple[float, float, float], ...] | None
    frequency_error: float | None
    extrapolated: bool
    error: float | None


@dataclass(frozen=True, kw_only=True)
class MatricesPart:
    """A casing of matrices of another program, reduced by its `model`; `mounts` as those of `ElasticPart`."""

    model: ElasticCasing
    geometry: ForeignHousing
    damping: DampingRatio
    loss_factors: Mapping[str, float]
    mounts: tuple[tuple[float, float, float], ...] | None
    frequency_error: float | None


CasingPart = RigidBox | RigidMeshed | ElasticPart | MatricesPart


def casing(scene: Scene, layout: Layout, source: str) -> CasingPart | None:
    """The casing with its sensors; None where the bearings stand on the ground. SceneError if it does not fit."""
    table = scene.casing
    if isinstance(table, NoCasingTable):
        return None
    if isinstance(table.housing, MatricesHousingTable):
        assert not isinstance(table, RigidCasingTable), "its table refuses matrices"
        return _of_matrices(table, table.housing, scene, layout, source)
    box = housing(table.housing, scene.sensors, layout, bearing_points(scene.shafts, layout), source)
    iron = material("casing", table.material)
    if isinstance(table, RigidCasingTable):
        mount = table.mount_stiffness_N_per_um * 1e6
        if isinstance(box, Housing) and box.plain:
            return RigidBox(geometry=box, material=iron, mount_stiffness=mount, damping=table.damping_ratio)
        sizes = element_sizes(table, box, iron, source)
        return RigidMeshed(
            geometry=box,
            material=iron,
            sizes=sizes,
            element=table.element,
            mount_stiffness=mount,
            damping=table.damping_ratio,
        )
    from pipelines.plant.casing_parts.damped import loss_factors, regions  # late, like all that only elastic ones need
    from pipelines.plant.casing_parts.joint import bolted_joint

    return ElasticPart(
        model=elastic_casing(
            table.model,
            ground=table.ground,
            attachment=table.attachment,
            regions=regions(table, box),
            joint=bolted_joint(table.housing.joint, box, source),
            **_options(table),
        ),
        geometry=box,
        material=iron,
        sizes=element_sizes(table, box, iron, source),
        element=table.element,
        damping=table.damping_ratio,
        loss_factors=loss_factors(table),
        mounts=_mounts(table),
        frequency_error=getattr(table, "frequency_error", None),
        extrapolated=table.extrapolated or table.error is not None,
        error=None if table.error is None else percent(table.error),
    )


def _mounts(table: ElasticBase) -> tuple[tuple[float, float, float], ...] | None:
    if table.ground == "fixed":
        return None
    return tuple((x * 1e6, y * 1e6, z * 1e6) for x, y, z in table.mounts_N_per_um)


def _of_matrices(
    table: StaticCasingTable | CraigBamptonCasingTable,
    matrices: MatricesHousingTable,
    scene: Scene,
    layout: Layout,
    source: str,
) -> MatricesPart:
    from pipelines.plant.casing_parts.damped import loss_factors
    from pipelines.plant.foreign_housing import foreign_housing

    return MatricesPart(
        model=elastic_casing(table.model, ground=table.ground, attachment=table.attachment, **_options(table)),
        geometry=foreign_housing(matrices, scene.sensors, bearing_points(scene.shafts, layout), source),
        damping=table.damping_ratio,
        loss_factors=loss_factors(table),
        mounts=_mounts(table),
        frequency_error=getattr(table, "frequency_error", None),
    )


def _options(table: ElasticBase) -> dict[str, Any]:
    """The options that a casing model has of its own; what is no option of the reduction is read elsewhere."""
    return {key: value for key, value in si_options(table, without=ElasticBase).items() if key not in _NOT_REDUCED}


def element_sizes(table: FlexibleBase, box: Geometry, iron: Material, source: str) -> Sizes:
    """Element sizes of a casing; at most a share of the bending wavelength of its thinnest wall where that is asked.

    Parameters
    ----------
    table, box, iron : the table of the casing, its housing and its material
    source : of the scene, for messages

    Raises
    ------
    SceneError : the share is asked for, but the thickness of the wall is not known
    """
    size = table.element_size_mm / 1000
    if isinstance(table, CraigBamptonCasingTable) and table.elements_per_wavelength is not None:
        if isinstance(box, Housing):
            wall = box.thinnest_wall
        elif isinstance(table.housing, ImportedTable) and table.housing.wall_thickness_mm is not None:
            wall = table.housing.wall_thickness_mm / 1000
        else:
            problem = "is needed for casing.elements_per_wavelength of a housing from a file"
            raise SceneError(
                source,
                [Problem("casing.housing.wall_thickness_mm", problem, "Set the thickness of its thinnest wall.")],
            )
        size = min(size, bending_wavelength(iron, wall, table.band_Hz) / table.elements_per_wavelength)
    local = (table.bore_element_size_mm, table.foot_element_size_mm)
    bore, foot = (None if one is None else one / 1000 for one in local)
    return Sizes(element=size, bore=bore, foot=foot)
