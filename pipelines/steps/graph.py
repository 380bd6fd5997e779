"""The steps of a machine: which part of it each one reads, and what it takes.

    unmodified_law_i, crack surface -> law_i   one per gear pair; equal pairs share one; law_i alone where flanks are
                                            neither modified nor damaged (a missing tooth is no damage here)
    casing mesh -> casing modes -> casing   as the model of the casing plans them, see `fem.casing.models.stage`
    simulate                                a missing tooth, deviations, drive and load enter here

Plants that are run together (`pipelines.steps.study`) share the steps that do not differ.
"""

from __future__ import annotations

import math

from fem.casing.models.stage import PlannedStage
from fem.contact.models.mesh_model import LawSpec
from mbd.integrators.methods import METHODS
from pipelines.engine.step import Step
from pipelines.machine.flanks_spec import FlanksSpec
from pipelines.machine.plant import Plant
from pipelines.steps import casing

# s to compile what a step runs, by the beginning of its name: any motion, one of coupled slices, a law, casing modes
_MOTION_CODE = {"mbd.integrators.": 8.0, "fem.contact.evaluation.": 4.0}
_COUPLED_CODE = {"fem.contact.evaluation.solver.": 8.0}
_SOLID_CODE = {"fem.elements.nested_condensation.": 3.0}
_NUMERIC = ("numpy", "scipy", "numba")


def plant_steps(machine: Plant) -> list[Step]:
    """The steps of one machine, in order."""
    from pipelines.steps import motion

    casing_steps = [casing_step(stage) for stage in machine.casing.stages(machine.structure)]
    coupled = "solid" in machine.models["mesh"]  # its slices press on each other
    return [
        *_law_steps(machine),
        *casing_steps,
        Step(
            name="simulate",
            kind="simulate",
            build=motion.build,
            spec=motion.MotionSpec(machine=machine.machine, recorded=machine.recorded, motion=machine.motion),
            takes={"body": casing_steps[-1].name, "laws": machine.law_names},
            modules=("mbd.output.simulate", METHODS[machine.motion.integrator][0]),
            libraries=_NUMERIC,
            seconds=_motion_seconds(machine),
            streams=True,
            prepare=motion.precompile,
            prepare_takes=machine.law_names,
            compiles=_MOTION_CODE | (_COUPLED_CODE if coupled else {}),
        ),
    ]


def _motion_seconds(machine: Plant) -> float:
    """Time steps by the slices of all stages, and no less than makes a long motion a process of its own."""
    blocks = sum(math.ceil(spec.mesh.slices / 16) for spec in machine.laws)
    return max(machine.motion.steps * (7e-6 + 20e-6 * blocks), 1.5 * machine.motion.end)


def _law_steps(machine: Plant) -> list[Step]:
    from pipelines.steps import laws

    steps = []
    names = zip(machine.law_names, machine.sound_law_names, strict=True)
    parts = zip(names, machine.laws, machine.flanks, machine.models["mesh"], strict=True)
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


def casing_step(planned: PlannedStage) -> Step:
    """A stage of a casing as a step."""
    stage = planned.stage
    return Step(
        name=planned.name,
        kind=stage.kind,
        build=casing.build,
        spec=stage,
        takes=planned.takes,
        libraries=stage.libraries,
        seconds=planned.seconds,
        enough=stage.enough,
        compiles=stage.compiles,
    )
