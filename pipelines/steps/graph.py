"""The steps of a plant: which part of it each one reads, and what it takes.

    healthy_law_i, crack surface -> law_i     one per gear pair; equal pairs share one; law_i alone where the flanks are
                                            neither modified nor damaged (a missing tooth is no damage here)
    casing mesh -> casing modes -> casing   finite elements only for the models static and craig-bampton
    simulate                                a missing tooth, deviations, drive and load enter here

Plants that are run together (`pipelines.steps.study`) share the steps that do not differ.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from fem.elements.solid_elements import SOLIDS
from mbd.integrators.methods import METHODS
from mbd.parts.bearings import BEARING_AXES, BearingSpec
from pipelines.engine.step import Graph, Step
from pipelines.plant.casing import ElasticPart, MatricesPart, RigidBox, RigidMeshed
from pipelines.plant.plant import Plant

if TYPE_CHECKING:
    from fem.casing.reduced.grounded import ForcedPoint
    from fem.contact.models.mesh_model import LawSpec
    from pipelines.plant.flanks_spec import FlanksSpec
    from pipelines.steps.casing_modes import CasingModesSpec

TRIAL = "trial casing"  # step with the modes that the size of elements is predicted from
COARSER = ("coarser casing", "coarsest casing")  # steps with the modes that a casing is extrapolated from, or the first
QUADRATIC = "quadratic casing"  # the one with the modes that a casing of cubic elements is
# s to compile what a step runs, by the beginning of its name: any motion, one of coupled slices, a law, casing modes
_MOTION_CODE = {"mbd.integrators.": 8.0, "fem.contact.evaluation.": 4.0}
_COUPLED_CODE = {"fem.contact.evaluation.coupled_face.": 10.0}
_SOLID_CODE = {"fem.elements.nested_condensation.": 3.0}
_CASING_CODE = {"fem.numerics.multifrontal.": 5.0}
_NUMERIC = ("numpy", "scipy", "numba")


def extrapolated_from(steps: Container[str]) -> tuple[str, ...]:
    """Those of the names that are steps whose modes a casing is extrapolated from; none if it is not."""
    return tuple(name for name in (*COARSER, QUADRATIC) if name in steps)


def plant_steps(plant: Plant) -> list[Step]:
    """The steps of one plant, in order."""
    from pipelines.steps import motion

    casing = _casing_steps(plant)
    coupled = "solid" in plant.models["mesh"]  # its slices press on each other
    return [
        *_law_steps(plant),
        *casing,
        Step(
            name="simulate",
            kind="simulate",
            build=motion.build,
            spec=motion.MotionSpec(machine=plant.machine, recorded=plant.recorded, motion=plant.motion),
            takes={"body": casing[-1].name, "laws": plant.law_names},
            modules=("mbd.simulate", METHODS[plant.motion.integrator][0]),
            libraries=_NUMERIC,
            seconds=_motion_seconds(plant),
            streams=True,
            ahead=motion.compiled_ahead,
            ahead_takes=plant.law_names,
            compiles=_MOTION_CODE | (_COUPLED_CODE if coupled else {}),
        ),
    ]


def _motion_seconds(plant: Plant) -> float:
    """Time steps by the slices of all stages, and no less than makes a long motion a process of its own."""
    blocks = sum(math.ceil(spec.mesh.slices / 16) for spec in plant.laws)
    return max(plant.motion.steps * (7e-6 + 20e-6 * blocks), 1.5 * plant.motion.end)


def _law_steps(plant: Plant) -> list[Step]:
    from pipelines.steps import laws

    steps = []
    names = zip(plant.law_names, plant.sound_law_names, strict=True)
    parts = zip(names, plant.laws, plant.flanks, plant.models["mesh"], strict=True)
    for (name, sound), spec, added, model in parts:
        steps.append(
            Step(
                name=sound,
                kind="law",
                build=laws.build,
                spec=spec,
                libraries=spec.mesh.libraries,
                seconds=spec.mesh.seconds,
                compiles=_SOLID_CODE if model == "solid" else {},
            )
        )
        if not added.empty:
            surfaces = _surface_steps(name, spec, added)
            steps += surfaces
            steps.append(
                Step(
                    name=name,
                    kind="flanks",
                    build=laws.build_modified,
                    spec=added,
                    takes={"sound": sound, "surfaces": tuple(step.name for step in surfaces)},
                    libraries=("numpy", "scipy"),
                )
            )
    return steps


def _surface_steps(law: str, spec: LawSpec, added: FlanksSpec) -> list[Step]:
    """The surfaces on which teeth of a pair crack in space, if its model knows them."""
    from fem.contact.wheels.crack_surface import crack_surface

    specs = {place: spec.mesh.crack_surface(spec.pair, *place) for place in added.surfaces}
    return [
        Step(
            name=f"crack surface of {law}, {gear}, {math.degrees(angle):.4g} deg",
            kind="crack-surface",
            build=crack_surface,
            spec=surface,
            libraries=("numpy", "scipy", "scikit-fem"),
            seconds=6.0,
        )
        for (gear, angle), surface in specs.items()
        if surface is not None
    ]


def _casing_steps(plant: Plant) -> list[Step]:
    from pipelines.steps import casing_body as body

    part = plant.casing
    if part is None:
        points = {f"bearing_{number}": point for number, point in enumerate(plant.bearing_points, 1)}
        return [Step(name="casing", kind="casing", build=body.build_ground, spec=body.GroundSpec(points=points))]
    if isinstance(part, RigidBox):
        rigid = body.RigidSpec(
            housing=part.geometry,
            material=part.material,
            mount_stiffness=part.mount_stiffness,
            damping_ratio=part.damping,
        )
        return [Step(name="casing", kind="casing", build=body.build_rigid, spec=rigid)]
    if isinstance(part, MatricesPart):
        from pipelines.steps import casing_modes

        loaded = replace(part.model, interfaces=loaded_axes(plant.machine.bearings), forced=forced_points(plant))
        return [
            Step(
                name="casing modes",
                kind="casing-matrices",
                build=casing_modes.build_foreign,
                spec=casing_modes.ForeignCasingSpec(housing=replace(part.geometry, sensors=()), model=loaded),
                libraries=("numpy", "scipy", "pyyeti"),
                seconds=10.0,
            ),
            _elastic_step(plant, part, ()),
        ]
    from pipelines.steps import casing_mesh, casing_modes

    mesh = Step(
        name="casing mesh",
        kind="casing-mesh",
        build=casing_mesh.build,
        spec=casing_mesh.CasingMeshSpec(
            housing=replace(part.geometry, sensors=()), sizes=part.sizes, element=part.element
        ),
        libraries=("numpy", "gmsh", "meshio", "scikit-fem"),
        seconds=8.0,
    )
    if isinstance(part, RigidMeshed):
        meshed = body.RigidMeshSpec(
            density=part.material.density,
            sensors=plant.sensors,
            mount_stiffness=part.mount_stiffness,
            damping_ratio=part.damping,
        )
        takes = {"mesh": "casing mesh"}
        return [mesh, Step(name="casing", kind="casing", build=body.build_rigid_mesh, spec=meshed, takes=takes)]
    interfaces = loaded_axes(plant.machine.bearings)
    model = replace(part.model, interfaces=interfaces, forced=forced_points(plant))
    reduced = casing_modes.CasingModesSpec(material=part.material, model=model)
    cubic = SOLIDS[part.element].degree == 3
    coarser = [] if cubic or not part.extrapolated else _coarser_steps(mesh, reduced, interfaces)
    larger = extrapolated_from([step.name for step in coarser])
    lower = [_modes_on(mesh, QUADRATIC, reduced, interfaces, quadratic=True)] if cubic and part.extrapolated else []
    return [
        *([mesh] if part.error is None else []),
        *coarser,
        *([] if part.error is None else _asked_steps(mesh, reduced, interfaces, part.error, larger)),
        *lower,
        Step(
            name="casing modes",
            kind="casing-modes",
            build=casing_modes.build,
            spec=reduced,
            takes={"mesh": "casing mesh"},
            libraries=("numpy", "scipy", "pymetis", "scikit-fem"),
            seconds=10.0,
            compiles=_CASING_CODE,
            enough="model.band" if part.model.limit else "",
        ),
        _elastic_step(plant, part, extrapolated_from([step.name for step in (*coarser, *lower)])),
    ]


def _elastic_step(plant: Plant, part: ElasticPart | MatricesPart, coarser: Sequence[str]) -> Step:
    """What follows the modes of a casing, and of coarser ones if there are any."""
    from pipelines.steps import casing_body as body

    return Step(
        name="casing",
        kind="casing",
        build=body.build_elastic,
        spec=body.ElasticSpec(
            sensors=plant.sensors,
            damping=part.damping,
            loss_factors=part.loss_factors,
            mounts=part.mounts,
            limit=part.model.limit,
            frequency_error=part.frequency_error,
        ),
        takes={"modes": "casing modes", "coarser": tuple(coarser)},
    )


def _coarser_steps(mesh: Step, reduced: CasingModesSpec, interfaces: Mapping[str, tuple[str, ...]]) -> list[Step]:
    """Meshes with larger elements, and their lowest modes."""
    from fem.casing.mesh_error.extrapolation import coarser_sizes
    from pipelines.steps import casing_mesh

    steps: list[Step] = []
    for name, sizes in zip(COARSER, coarser_sizes(mesh.spec.sizes), strict=True):
        larger, ratio = replace(mesh.spec, sizes=sizes), sizes.element / mesh.spec.sizes.element
        seconds = mesh.seconds / ratio**2
        coarser = replace(mesh, name=f"{name} mesh", build=casing_mesh.build_coarser, spec=larger, seconds=seconds)
        steps += [coarser, _modes_on(coarser, name, reduced, interfaces)]
    return steps


def _asked_steps(
    mesh: Step,
    reduced: CasingModesSpec,
    interfaces: Mapping[str, tuple[str, ...]],
    error: float,
    coarser: Sequence[str],
) -> list[Step]:
    """The mesh with the largest elements, its lowest modes, and the mesh whose size follows from them.

    Without `coarser` steps it follows from quadratic displacements on the first mesh.
    """
    from fem.casing.reduced.body import MODES_OVER_BAND
    from pipelines.steps import casing_mesh

    limit = reduced.model.limit
    asked = casing_mesh.AskedMeshSpec(
        housing=mesh.spec.housing,
        sizes=mesh.spec.sizes,
        element=mesh.spec.element,
        error=error,
        band=0.0 if limit is None else limit / MODES_OVER_BAND,
    )
    trial, lower = replace(mesh, name=f"{TRIAL} mesh"), f"{QUADRATIC}, trial"
    takes = {"trial": TRIAL, "coarser": tuple(coarser) or (lower,)}
    return [
        trial,
        _modes_on(trial, TRIAL, reduced, interfaces),
        *([] if coarser else [_modes_on(trial, lower, reduced, interfaces, quadratic=True)]),
        replace(mesh, kind="casing-asked-mesh", build=casing_mesh.build_asked, spec=asked, takes=takes),
    ]


def _modes_on(
    mesh: Step,
    name: str,
    reduced: CasingModesSpec,
    interfaces: Mapping[str, tuple[str, ...]],
    *,
    quadratic: bool = False,
) -> Step:
    """The lowest modes on a mesh."""
    from pipelines.steps import coarser_casing

    return Step(
        name=name,
        kind="casing-coarser",
        build=coarser_casing.build,
        spec=coarser_casing.CoarserSpec(
            material=reduced.material,
            static=reduced.model.limit is None,
            interfaces=interfaces,
            ground=reduced.model.ground,
            attachment=reduced.model.attachment,
            joint=reduced.model.joint,
            quadratic=quadratic,
        ),
        takes={"mesh": mesh.name},
        libraries=("numpy", "scipy", "pymetis", "scikit-fem"),
        seconds=0.9 * mesh.seconds,
    )


def casing_error_step(graph: Graph, band: float) -> Step:
    """The comparison of a scene's elastic casing with its full model up to a band (Hz)."""
    from pipelines.steps import casing_error

    body = graph.steps["casing"].spec
    return Step(
        name="casing error",
        kind="casing-error",
        build=casing_error.build,
        spec=casing_error.CasingErrorSpec(
            modes=graph.steps["casing modes"].spec,
            band=band,
            sensors=body.sensors,
            damping=body.damping,
            loss_factors=body.loss_factors,
            mounts=body.mounts,
        ),
        takes={"mesh": "casing mesh", "modes": "casing modes", "body": "casing"},
        libraries=("numpy", "scipy", "pymetis", "scikit-fem"),
        seconds=40.0,
    )


def forced_points(plant: Plant) -> tuple[ForcedPoint, ...]:
    """Sensors that bear outside forces, with the axes along which they do."""
    pulled = {row for force in plant.machine.forces for row in force.casing_rows}
    if not pulled:
        return ()
    from fem.casing.reduced.grounded import GROUND_AXES, ForcedPoint

    points = ((s, tuple(axis for axis in GROUND_AXES if f"{s.name}:{axis}" in pulled)) for s in plant.sensors)
    return tuple(ForcedPoint(sensor=sensor, axes=axes) for sensor, axes in points if axes)


def loaded_axes(bearings: Iterable[BearingSpec]) -> dict[str, tuple[str, ...]]:
    """Axes along which every bearing loads the casing; an axis without stiffness needs no interface."""
    return {
        spec.name: tuple(axis for axis, k in zip(BEARING_AXES, spec.stiffness, strict=True) if k > 0.0)
        for spec in bearings
    }
