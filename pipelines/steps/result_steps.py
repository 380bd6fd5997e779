"""The steps that follow the motions of a run: features, verdict, diagnosis, error bars, pictures and the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipelines.engine.step import Graph, Step
from pipelines.steps import diagnosing, features, reporting, verdict
from pipelines.steps import error_bars as bars
from pipelines.steps.pictures import CASING, CURVES, picture_steps

if TYPE_CHECKING:
    from pipelines.scene.load_scene import LoadedScene
    from pipelines.steps.run_plan import RunPlan

_NUMERIC = ("numpy", "scipy")
_FEATURES = 1.4e-6  # s per recorded value and sample of noise, next to another process
VERDICT, DIAGNOSIS, BARS, SECTIONS, REPORT = "verdict", "diagnose", "error bars", "report sections", "report"


def result_steps(loaded: LoadedScene, plan: RunPlan) -> list[Step]:
    """All of them that apply to the run of a loaded scene, in order."""
    steps = [*picture_steps(plan.machine, plan.graph.steps), *verdict_steps(plan)]
    compared = diagnosis_step(plan)
    steps += [compared, bars_step(plan)] if compared else []
    return [*steps, *_report_steps(loaded, plan, {step.name: step for step in [*plan.graph, *steps]})]


def verdict_steps(plan: RunPlan) -> list[Step]:
    """Features of the motions and of the healthy ones, then the verdict; none without a healthy motion.

    With a baseline the scene's own motion is compared with it, else every case with its control.
    """
    from pipelines.diagnosis.control_diagnosis import deviation_name
    from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_P
    from pipelines.diagnosis.simulated_features import FeatureSettings
    from pipelines.machine.scene_kinematics import kinematics_of

    machine, exact = plan.machine, not plan.baseline
    cases = plan.cases if exact else plan.cases[:1]
    healthy = [*plan.baseline]
    if exact:  # a scene without faults is its own control
        healthy = [one.control for one in cases if one.control is not None and one.control.step != one.own.step]
    if not healthy or not machine.monitored.possible:
        return []
    kinematics = kinematics_of(machine.layout, machine.rolling)
    settings = FeatureSettings(kinematics=kinematics, windows=machine.monitored.windows)
    made = {
        one.step: Step(
            name=f"features {one.step}",
            kind="features",
            build=features.build,
            spec={"settings": settings, "labels": one.machine.labels, "samples": samples},
            takes={"motion": one.step},
            libraries=_NUMERIC,
            modules=("pipelines.diagnosis.simulated_features", "pipelines.signals.response"),
            seconds=_FEATURES * samples * len(one.machine.sensors) * one.machine.motion.n_samples,
        )
        for one, samples in [
            *((case.own, 1) for case in cases),
            *((motion, FEWEST_FOR_P if exact else 1) for motion in healthy),
        ]
    }
    spec = {
        "kinematics": kinematics,
        "damages": verdict.known_damages(machine),
        "cases": tuple((str(one.own.machine.labels["load"]), deviation_name(one.own.machine.labels)) for one in cases),
        "exact": exact,
    }
    takes = {
        "own": tuple(made[case.own.step].name for case in cases),
        "healthy": tuple(made[motion.step].name for motion in healthy),
    }
    judging = Step(name=VERDICT, kind="verdict", build=verdict.build, spec=spec, takes=takes, libraries=_NUMERIC)
    return [*made.values(), judging]


def diagnosis_step(plan: RunPlan) -> Step | None:
    """All cases against their controls; None without a control, a fault to look for, windows or sensors."""
    cases, motions, labels = [], [], []
    for number, case in enumerate(plan.cases):
        settings = case.own.machine.diagnosis
        if settings is None or case.control is None:
            return None
        cases.append(diagnosing.CaseSpec(settings=settings, full=number == 0 or case.label == "torque"))
        motions += [case.own.step, case.control.step]
        labels += [case.own.machine.labels, case.control.machine.labels]
    return Step(
        name=DIAGNOSIS,
        kind="diagnose",
        build=diagnosing.build,
        spec={"cases": tuple(cases), "labels": tuple(labels)},
        takes={"motions": tuple(motions)},
        libraries=_NUMERIC,
    )


def bars_step(plan: RunPlan) -> Step:
    """The error bars of the lines of the first case of a run that has a control."""
    case, laws = plan.cases[0], plan.machine.law_names
    assert case.control is not None, "a diagnosis has one"
    return Step(
        name=BARS,
        kind="error-bars",
        build=bars.build,
        spec={"machine": case.own.machine, "healthy": case.control.machine},
        takes={"motion": case.own.step, "control": case.control.step, "laws": laws, **casing_taken(plan.graph)},
        libraries=_NUMERIC,
        seconds=1.5,  # short, so that it is built in parallel with the motions of other cases
    )


def casing_taken(graph: Graph) -> dict[str, str | tuple[str, ...]]:
    """What error bars take of the casing: the reduced body, and modes of its meshes if it is extrapolated."""
    coarser = tuple(graph.steps["casing"].takes.get("coarser", ()))
    return {"body": "casing", **({"modes": "casing modes", "coarser": coarser} if coarser else {})}


def _report_steps(loaded: LoadedScene, plan: RunPlan, known: dict[str, Step]) -> list[Step]:
    """The sections of the report that do not depend on the verdict, and the report."""
    from pipelines.steps.run_plan import scene_warnings

    machine, compared = plan.machine, known.get(DIAGNOSIS)
    kinds = [*(fault.kind for fault in machine.faults), *("bearing-spall" for _ in machine.spalls)]
    kinds += [*(fault.kind for fault in machine.shaft_faults), "healthy"]
    optional = {"casing": CASING, "modes": "casing modes", "diagnosis": DIAGNOSIS, "error_bars": BARS}
    spec = reporting.ReportSpec(
        machine=machine,
        responses=(kinds[0].replace("-", " "), "healthy")[: 2 if compared else 1],
        **(compared.spec if compared else {"cases": (), "labels": (machine.labels,)}),
    )
    motions = compared.takes["motions"] if compared else (plan.cases[0].own.step,)
    sections = Step(
        name=SECTIONS,
        kind="report-sections",
        build=reporting.sections,
        spec={"spec": spec, "warnings": scene_warnings(loaded, plan)},
        takes={
            "motions": motions,
            "curves": CURVES,
            "body": "casing",
            **{key: name for key, name in optional.items() if name in known},
        },
        libraries=("numpy", "matplotlib"),
        seconds=1.2,
    )
    optional = {"diagnosis": DIAGNOSIS, "verdict": VERDICT}
    report = Step(
        name=REPORT,
        kind="report",
        build=reporting.build,
        spec={"spec": spec},
        takes={
            "motions": motions,
            "sections": SECTIONS,
            **{key: name for key, name in optional.items() if name in known},
        },
        libraries=("numpy", "matplotlib"),
        seconds=0.3,
    )
    return [sections, report]
