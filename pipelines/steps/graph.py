"""The stages of a scene: which part of it each one reads, and what it takes.

    sound_law_i -> law_i                    one per gear pair; equal pairs share one; law_i alone where the flanks are
                                            neither modified nor damaged (a missing tooth is no damage here)
    casing mesh -> casing modes -> casing   finite elements only for the rungs static and craig-bampton
    simulate                                a missing tooth, deviations, drive and load enter here

Scenes that are run together (`pipelines.steps.study`) share the stages that do not differ.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from fem.casing.geometry.housing import Housing
from fem.casing.reduced.body import MODES_OVER_BAND
from mbd.parts.bearings import BEARING_AXES
from pipelines.engine.step import Graph, Stage
from pipelines.plant.casing_sizes import element_sizes
from pipelines.plant.checks.validity import checked_layout
from pipelines.plant.facts import bearing_points
from pipelines.plant.flanks import common_wear, damaged_teeth
from pipelines.plant.layout import Layout
from pipelines.plant.machine import bearing_specs
from pipelines.scene.scene import Scene
from pipelines.scene.tables.analysis import DiagnosisTable
from pipelines.scene.tables.base import MaterialTable
from pipelines.scene.tables.casing import (
    CraigBamptonCasingTable,
    ElasticBase,
    NoCasingTable,
    RigidCasingTable,
    SensorTable,
)
from pipelines.scene.tables.gears import IsoMesh
from pipelines.scene.tables.housing import HousingTable

if TYPE_CHECKING:
    from pipelines.steps.casing_modes import CasingModesSpec

_NUMERIC = ("numpy", "scipy", "numba")
_ZERO = (0.0, 0.0, 0.0)
_SOME_CASING = RigidCasingTable(  # stands for any casing where only its presence counts
    housing=HousingTable(
        length_mm=1,
        width_mm=1,
        height_mm=1,
        wall_thickness_mm=1,
        left_end_mm=0,
        shaft_height_mm=1,
        bore_diameters_mm=(1,),
        boss_diameters_mm=(1,),
        boss_length_mm=1,
    ),
    material=MaterialTable(elastic_modulus_GPa=1, poisson_ratio=0, density_kg_m3=1),
)


def scene_stages(scene: Scene, source: str) -> list[Stage]:
    """The stages of one scene, in order."""
    from pipelines.steps import motion

    layout = checked_layout(scene, source)
    laws = _law_stages(scene, layout)
    casing = _casing_stages(scene, layout, source)
    takes = tuple(law.name for law in laws if law.name.startswith("law_"))
    return [
        *laws,
        *casing,
        Stage(
            name="simulate",
            kind="simulate",
            build=motion.build,
            spec=motion.MotionSpec(scene=motion_scene(scene)),
            takes=(casing[-1].name, *takes),
            modules=("mbd.simulate",),
            libraries=_NUMERIC,
            seconds=1.5 * scene.simulation.end_s,
            streams=True,
        ),
    ]


def _law_stages(scene: Scene, layout: Layout) -> list[Stage]:
    from pipelines.plant.mesh_models import mesh_models
    from pipelines.steps import laws, modified_laws

    stages = []
    for number, (pair, mesh) in enumerate(zip(layout.pairs, mesh_models(scene, layout), strict=True), 1):
        unloaded = replace(pair, backlash_allowance=0.0)
        added = modified_laws.FlanksSpec(
            pair=unloaded,
            modifications=layout.modifications[number - 1],
            pinion_damage=tuple(damaged_teeth(scene, number, "pinion").values()),
            wheel_damage=tuple(damaged_teeth(scene, number, "wheel").values()),
            pinion_wear=common_wear(scene, number, "pinion"),
            wheel_wear=common_wear(scene, number, "wheel"),
        )
        stages.append(
            Stage(
                name=f"law_{number}" if added.empty else f"sound_law_{number}",
                kind="law",
                build=laws.build,
                spec=laws.LawSpec(pair=unloaded, mesh=mesh),
                modules=(type(mesh).__module__,),
                libraries=("numpy", "scipy"),
                seconds=mesh.seconds,
            )
        )
        if not added.empty:
            stages.append(
                Stage(
                    name=f"law_{number}",
                    kind="flanks",
                    build=modified_laws.build,
                    spec=added,
                    takes=(f"sound_law_{number}",),
                    modules=tuple(sorted({type(fault).__module__ for fault in added.faults})),
                    libraries=("numpy", "scipy"),
                )
            )
    return stages


def _casing_stages(scene: Scene, layout: Layout, source: str) -> list[Stage]:
    from pipelines.plant.housing import housing
    from pipelines.plant.layout import material
    from pipelines.steps import casing_body as body

    table = scene.casing
    if isinstance(table, NoCasingTable):
        points = {f"bearing_{n}": point for n, point in enumerate(bearing_points(scene, layout), 1)}
        return [Stage(name="casing", kind="casing", build=body.build_ground, spec=body.GroundSpec(points=points))]
    box, iron = housing(scene, table.housing, layout, source), material("casing", table.material)
    if isinstance(table, RigidCasingTable) and isinstance(box, Housing) and box.plain:
        rigid = body.RigidSpec(
            housing=box,
            material=iron,
            mount_stiffness=table.mount_stiffness_N_per_um * 1e6,
            damping_ratio=table.damping_ratio,
        )
        return [Stage(name="casing", kind="casing", build=body.build_rigid, spec=rigid)]
    from pipelines.steps import casing_mesh, casing_modes

    mesh = Stage(
        name="casing mesh",
        kind="casing-mesh",
        build=casing_mesh.build,
        spec=casing_mesh.CasingMeshSpec(
            housing=replace(box, sensors=()), sizes=element_sizes(table, box, iron, source)
        ),
        libraries=("numpy", "gmsh", "meshio"),
        seconds=8.0,
    )
    if isinstance(table, RigidCasingTable):
        meshed = body.RigidMeshSpec(
            density=iron.density,
            sensors=box.sensors,
            mount_stiffness=table.mount_stiffness_N_per_um * 1e6,
            damping_ratio=table.damping_ratio,
        )
        takes = ("casing mesh",)
        return [mesh, Stage(name="casing", kind="casing", build=body.build_rigid_mesh, spec=meshed, takes=takes)]
    band = table.band_Hz if isinstance(table, CraigBamptonCasingTable) else 0.0
    reduced = casing_modes.CasingModesSpec(
        material=iron,
        model=table.model,
        band=band,
        ground=table.ground,
        coupling=table.coupling,
        interfaces=loaded_axes(scene),
    )
    coarser = _coarser_stages(mesh, reduced) if table.extrapolated else []
    return [
        mesh,
        *coarser,
        Stage(
            name="casing modes",
            kind="casing-modes",
            build=casing_modes.build,
            spec=reduced,
            takes=("casing mesh",),
            libraries=("numpy", "scipy", "pymetis"),
            seconds=30.0,
            enough="band" if band else "",
        ),
        Stage(
            name="casing",
            kind="casing",
            build=body.build_elastic,
            spec=body.ElasticSpec(
                sensors=box.sensors,
                damping=table.damping_ratio,
                mounts=casing_mounts(scene),
                limit=MODES_OVER_BAND * band if band else None,
                frequency_error=getattr(table, "frequency_error", None),
            ),
            takes=("casing modes", *(stage.name for stage in coarser[1:])),
        ),
    ]


def _coarser_stages(mesh: Stage, reduced: CasingModesSpec) -> list[Stage]:
    """A second mesh with larger elements, and its lowest frequencies."""
    from fem.casing.reduced.extrapolation import RATIO
    from pipelines.steps import coarser_casing

    spec = replace(mesh.spec, sizes=mesh.spec.sizes.times(RATIO))
    return [
        replace(mesh, name="coarser casing mesh", spec=spec, seconds=mesh.seconds / 2),
        Stage(
            name="coarser casing",
            kind="casing-coarser",
            build=coarser_casing.build,
            spec=replace(reduced, band=0.0),
            takes=("coarser casing mesh",),
            libraries=("numpy", "scipy", "pymetis"),
            seconds=8.0,
        ),
    ]


def casing_error_stage(graph: Graph, band: float) -> Stage:
    """The comparison of a scene's elastic casing with its full model up to a band (Hz)."""
    from pipelines.steps import casing_error

    body = graph.stages["casing"].spec
    return Stage(
        name="casing error",
        kind="casing-error",
        build=casing_error.build,
        spec=casing_error.CasingErrorSpec(
            modes=graph.stages["casing modes"].spec,
            band=band,
            sensors=body.sensors,
            damping=body.damping,
            mounts=body.mounts,
        ),
        takes=("casing mesh", "casing modes", "casing"),
        libraries=("numpy", "scipy", "pymetis"),
        seconds=40.0,
    )


def loaded_axes(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Axes along which every bearing loads the casing; an axis without stiffness needs no interface."""
    return {
        spec.name: tuple(axis for axis, k in zip(BEARING_AXES, spec.stiffness, strict=True) if k > 0.0)
        for spec in bearing_specs(scene)
    }


def casing_mounts(scene: Scene) -> tuple[tuple[float, float, float], ...] | None:
    """Stiffness of the feet of an elastic casing in N/m, None on fixed ground."""
    table = scene.casing
    if not isinstance(table, ElasticBase) or table.ground == "fixed":
        return None
    return tuple((x * 1e6, y * 1e6, z * 1e6) for x, y, z in table.mounts_N_per_um)


def motion_scene(scene: Scene) -> Scene:
    """The scene with everything blanked that the motion does not read itself (laws and casing come as results)."""
    stages = tuple(stage.model_copy(update={"mesh": IsoMesh()}) for stage in scene.stages)
    sensors = tuple(SensorTable(name=sensor.name, position_mm=_ZERO) for sensor in scene.sensors)
    casing = scene.casing if isinstance(scene.casing, NoCasingTable) else _SOME_CASING
    changes = {"title": "", "stages": stages, "sensors": sensors, "casing": casing, "control": None}
    return scene.model_copy(update={**changes, "diagnosis": DiagnosisTable()})
