"""Run a scene: ``run("rig-missing-tooth", set={"load.container_kg": 800})`` returns its response as a dataset."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines import results
from pipelines.build import Outcome, run_graph
from pipelines.cache import Cache
from pipelines.code_version import library_versions
from pipelines.scene_file import LoadedScene, control_differences
from pipelines.stages import Graph, Stage, StageRecord
from pipelines.study import Study, diagnosis_settings, plan_study
from pipelines.terminal import shown_progress
from pipelines.trade.presets import load_preset

if TYPE_CHECKING:
    import xarray

    from mbd.trajectory import Trajectory
    from pipelines.scene import Scene

LIBRARIES = ("gearcase", "numpy", "scipy", "numba", "h5py", "xarray", "scikit-fem", "gmsh", "scikit-sparse", "pymetis")


@dataclass(frozen=True, kw_only=True)
class Options:
    """How much is run, and how."""

    out: str | Path | None = None
    with_control: bool = True
    with_report: bool = True  # diagnosis and report; without them only the signals
    both_loads: bool = True
    seeds: int = 0
    processes: int | None = None
    quiet: bool = True


@dataclass(frozen=True, kw_only=True)
class Finished:
    """A run that is written: its folder, the verdict, and what was done."""

    folder: Path
    words: str
    records: tuple[StageRecord, ...]
    ledger: Mapping[str, int]
    left_out: tuple[str, ...]


def run(
    scene: str | Path,
    set: Mapping[str, Any] | Iterable[str] = (),
    *,
    preset: str | None = None,
    out: str | Path | None = None,
    control: bool = True,
    both_loads: bool = True,
    seeds: int = 0,
    processes: int | None = None,
) -> xarray.Dataset:
    """Run a scene with its control, diagnose it, write the result folder, and return the response.

    Parameters
    ----------
    scene : name of a shipped scene, or a path ending in .toml
    set : changed values, ``{"load.container_kg": 800}`` or ``["load.container_kg=800"]``
    preset : "draft", "standard" or "reference": how finely it is computed; `set` counts more
    out : result folder instead of ./runs/<scene>/<timestamp>
    control : run the healthy control, too, and diagnose against it
    both_loads : with a rope, run the equivalent constant torque as well
    seeds : compare this many further seeds of the deviations, and error-free gears
    processes : long stages built side by side, 2 by default

    Returns
    -------
    the content of response.nc; `attrs["folder"]` names the result folder

    Raises
    ------
    SceneError, InputError : the scene cannot be used
    WorkError : a stage failed
    """
    import xarray

    options = Options(out=out, with_control=control, both_loads=both_loads, seeds=seeds, processes=processes)
    finished = run_scene(load_preset(str(scene), set, preset), options)
    with xarray.open_dataset(finished.folder / results.RESPONSE, engine="h5netcdf") as data:
        return data.load().assign_attrs(folder=str(finished.folder))


def run_scene(loaded: LoadedScene, options: Options) -> Finished:
    """Run a loaded scene and write its result folder."""
    study = plan_study(
        loaded,
        with_control=options.with_control,
        both_loads=options.both_loads and options.with_report,
        seeds=options.seeds,
    )
    diagnosing = _diagnose_stage(study) if options.with_report else None
    stages = [*study.graph, *([diagnosing] if diagnosing else [])]
    first = study.cases[0]
    wanted = [name for name in (first.faulty, first.healthy, diagnosing and diagnosing.name) if name]
    final = results.final_folder(loaded.name, options.out)
    with results.result_folder(final) as folder, results.logged_to(folder / "log.jsonl"):
        graph = Graph(stages).needed(wanted)
        with shown_progress(len(graph.stages) + options.with_report, quiet=options.quiet) as observer:
            cache = Cache()
            outcome = run_graph(graph, cache, wanted, observer=observer, processes=options.processes)
            report = None
            if options.with_report:
                stage = _report_stage(loaded, study, diagnosing, outcome)
                whole = run_graph(
                    Graph([*graph, stage]), cache, [stage.name], observer=observer, known=outcome.results, processes=1
                )
                report, outcome = whole.value(stage.name), Outcome({**outcome.results, **whole.results})
        diagnosis = outcome.value(diagnosing.name) if diagnosing else {"words": "", "failure": ""}
        _write(folder, loaded, study, outcome, diagnosing, report)
    if options.out is None:
        results.note_latest(final)
    left_out = tuple(report["left_out"]) if report else ()
    if diagnosis["failure"]:
        left_out = (f"The diagnosis is left out: {diagnosis['failure']}", *left_out)
    return Finished(
        folder=final, words=diagnosis["words"], records=outcome.records, ledger=outcome.ledger(), left_out=left_out
    )


def _diagnose_stage(study: Study) -> Stage | None:
    """All cases against their controls; None without a control, a fault to look for, windows or sensors."""
    from pipelines.building import diagnosing
    from pipelines.signals import labels

    cases, takes, labelled = [], [], []
    for number, case in enumerate(study.cases):
        settings = diagnosis_settings(case.scene)
        if settings is None or case.healthy is None or case.control is None:
            return None
        cases.append(diagnosing.CaseSpec(settings=settings, full=number == 0 or case.label == "torque"))
        takes += [case.faulty, case.healthy]
        labelled += [labels(case.scene), labels(case.control)]
    spec = diagnosing.DiagnosingSpec(cases=tuple(cases), labels=tuple(labelled))
    return Stage(
        name="diagnose",
        kind="diagnose",
        build=diagnosing.build,
        spec=spec,
        takes=tuple(takes),
        libraries=("numpy", "scipy"),
    )


def _report_stage(loaded: LoadedScene, study: Study, diagnosing: Stage | None, outcome: Outcome) -> Stage:
    from pipelines.building import reporting

    laws = tuple(stage.name for stage in study.graph if stage.name.startswith("law_"))
    elastic = "casing mesh" in study.graph.stages
    takes = [*laws, "casing", *(("casing mesh", "casing modes") if elastic else ())]
    takes += diagnosing.takes if diagnosing else (study.cases[0].faulty,)
    names = [loaded.scene.faults[0].kind.replace("-", " ") if loaded.scene.faults else "healthy", "healthy"]
    warnings = () if study.control is None else tuple(control_differences(loaded, study.control))
    spec = reporting.ReportSpec(
        scene=loaded.scene,
        name=loaded.name,
        diagnosing=diagnosing.spec if diagnosing else None,
        laws=len(laws),
        elastic=elastic,
        responses=tuple(names[: 2 if diagnosing else 1]),
        stages=tuple(_cost_row(record) for record in outcome.records),
        ledger=outcome.ledger(),
        provenance=provenance(loaded, outcome),
        failure=outcome.value(diagnosing.name)["failure"] if diagnosing else "",
        warnings=tuple(f"the control differs in more than the fault: {line}" for line in warnings),
    )
    return Stage(
        name="report",
        kind="report",
        build=reporting.build,
        spec=spec,
        takes=tuple(takes),
        libraries=("numpy", "matplotlib", "pyvista"),
    )


def _cost_row(record: StageRecord) -> dict[str, Any]:
    return {"stage": record.name, "seconds": round(record.seconds, 3), "peak MB": round(record.peak_bytes / 1e6)}


def provenance(loaded: LoadedScene, outcome: Outcome) -> dict[str, Any]:
    """Versions, rungs and keys: the same for the same result."""
    scene = loaded.scene
    return {
        "scene": loaded.name,
        "versions": {"python": platform.python_version(), **library_versions(*LIBRARIES)},
        "rungs": {
            "mesh": [stage.mesh.model for stage in scene.stages],
            "casing": scene.casing.model,
            "shafts": scene.shaft_model.model,
            "bearings": scene.bearings.model,
            "load": scene.load.model,
            "integrator": scene.simulation.integrator,
        },
        "threads per process": 1,
        "keys": {record.name: record.key[:32] for record in outcome.records},
    }


def _write(
    folder: Path, loaded: LoadedScene, study: Study, outcome: Outcome, diagnosing: Stage | None, report: Any
) -> None:
    """Fill the result folder."""
    (folder / results.ASKED).write_text(loaded.asked(), encoding="utf-8")
    twin = study.control is not None and not control_differences(loaded, study.control)
    (folder / results.RESOLVED).write_text(loaded.resolved(own_control=twin), encoding="utf-8")
    facts = {
        **provenance(loaded, outcome),
        "ledger": outcome.ledger(),
        "stages": [
            {**_cost_row(record), "reused": record.reused, "ledger": dict(record.ledger)} for record in outcome.records
        ],
    }
    case = study.cases[0]
    for name, stage, scene in (
        (results.RESPONSE, case.faulty, case.scene), (results.CONTROL, case.healthy, case.control)
    ):  # fmt: skip
        if stage is not None and scene is not None:
            _write_response(folder / name, outcome.value(stage), scene, facts)
    if diagnosing is not None:
        found = outcome.value(diagnosing.name)
        for name, content in found["files"].items():
            (folder / name).write_bytes(content)
        if found["words"]:
            (folder / "diagnosis.txt").write_text(found["words"], encoding="utf-8")
    if report is not None:
        (folder / "report.html").write_text(report["page"], encoding="utf-8")
    results.write_json(folder / results.RUN, facts)


def _write_response(path: Path, motion: Trajectory, scene: Scene, facts: Mapping[str, Any]) -> None:
    """The labelled signals with the facts of this run as attributes."""
    from pipelines.response_file import write_response
    from pipelines.signals import labels

    told = {
        "provenance": json.dumps({name: facts[name] for name in ("scene", "versions", "rungs", "keys")}),
        "stages": json.dumps(facts["stages"]),
        "build_ledger": json.dumps(facts["ledger"]),
    }
    write_response(motion, labels(scene) | told, path)
