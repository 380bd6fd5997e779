"""Steps of a machine, with the part of the machine that each one reads and its inputs.

    unmodified_law_i, crack surface -> law_i   one for each gear pair, shared by equal pairs; only law_i if the flanks
                                            are neither modified nor damaged (a missing tooth is not damage here)
    casing mesh -> casing modes -> casing   as planned by the model of the casing, see `fem.casing.models.stage`
    simulate                                with missing teeth, deviations, drive and load

Machines that are simulated together (`pipelines.steps.run_plan`) share equal steps.
"""

from __future__ import annotations

import math

from fem.casing.models.stage import PlannedStage
from fem.contact.models.mesh_model import LawSpec
from mbd.integrators.methods import METHODS
from pipelines.engine.step import Step
from pipelines.machine.flanks_spec import FlanksSpec
from pipelines.machine.machine_model import MachineModel
from pipelines.steps import casing

# s to compile code by prefix of its name: of any motion, of one with coupled slices, of a law, of casing modes
_MOTION_CODE = {"mbd.integrators.": 8.0, "fem.contact.evaluation.": 4.0}
_COUPLED_CODE = {"fem.contact.evaluation.solver.": 8.0}
_SOLID_CODE = {"fem.elements.nested_condensation.": 3.0}
_NUMERIC = ("numpy", "scipy", "numba")


def machine_steps(machine: MachineModel) -> list[Step]:
    """The steps of a machine in order."""
    from pipelines.steps import motion

    casing_steps = [casing_step(stage) for stage in machine.casing.stages(machine.structure)]
    coupled = "solid" in machine.models["mesh"]  # the model couples the slices
    blocks = sum(math.ceil(spec.mesh.slices / 16) for spec in machine.laws)
    return [
        *_law_steps(machine),
        *casing_steps,
        Step(
            name="simulate",
            kind="simulate",
            build=motion.build,
            spec=motion.MotionSpec(machine=machine.parts, recorded=machine.recorded, motion=machine.motion),
            takes={"body": casing_steps[-1].name, "laws": machine.law_names},
            modules=("mbd.output.simulate", METHODS[machine.motion.integrator][0]),
            libraries=_NUMERIC,
            seconds=max(
                machine.motion.steps * (7e-6 + 20e-6 * blocks), 1.5 * machine.motion.end
            ),  # long motions in a child
            streams=True,
            prepare=motion.precompile,
            prepare_takes=machine.law_names,
            compiles=_MOTION_CODE | (_COUPLED_CODE if coupled else {}),
        ),
    ]


def _law_steps(machine: MachineModel) -> list[Step]:
    from pipelines.steps import flanks

    steps = []
    names = zip(machine.law_names, machine.healthy_law_names, strict=True)
    parts = zip(names, machine.laws, machine.flanks, machine.models["mesh"], strict=True)
    for (name, unmodified), spec, added, model in parts:
        steps.append(
            Step(
                name=unmodified,
                kind="law",
                build=LawSpec.laws,
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
                    build=flanks.build_modified,
                    spec=added,
                    takes={"unmodified": unmodified, "surfaces": tuple(step.name for step in surfaces)},
                    libraries=("numpy", "scipy"),
                )
            )
    return steps


def _surface_steps(law: str, spec: LawSpec, added: FlanksSpec) -> list[Step]:
    """Steps of the crack surfaces of the teeth of a pair, if its model computes them."""
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
    """The step of a stage of a casing."""
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
