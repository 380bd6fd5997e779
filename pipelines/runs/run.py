"""Run a scene with its control, diagnose it, and write the result folder."""

from __future__ import annotations

import json
import logging
import platform
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from traceback import format_exception
from typing import TYPE_CHECKING, Any

from pipelines.bars.words import bars_words
from pipelines.border.errors import WorkError
from pipelines.engine.cache import Cache
from pipelines.engine.code_version import library_versions
from pipelines.engine.run_graph import Observer, Outcome, run_graph
from pipelines.engine.step import Graph, Step, StepRecord
from pipelines.engine.working import Work
from pipelines.runs import run_folder
from pipelines.runs.claims import claimed
from pipelines.runs.error_bars import bars_step
from pipelines.runs.judging import feature_steps, judged, verdict_words, write_verdict
from pipelines.scene.file import LoadedScene, control_differences
from pipelines.signals.motion_warnings import log_warnings
from pipelines.steps.pictures import CASING, CURVES, picture_steps
from pipelines.steps.study import Study, plan_study

if TYPE_CHECKING:
    from mbd.output.trajectory import Trajectory
    from pipelines.bars.line_bars import LineBars
    from pipelines.diagnosis.verdict import Verdict
    from pipelines.plant.plant import Plant

_LOG = logging.getLogger(__name__)
WRITERS = ("h5py", "h5netcdf", "xarray")  # of the signals


@dataclass(frozen=True, kw_only=True)
class Options:
    """How much is run, and how."""

    out: str | Path | None = None
    with_control: bool = True
    with_report: bool = True  # diagnosis and report; without them only the signals
    both_loads: bool = True
    seeds: int = 0
    baseline: int = 0  # healthy machines with other deviations, to judge against
    work: Work = field(default_factory=Work)


@dataclass(frozen=True, kw_only=True)
class Finished:
    """A run that is written: its folder, the verdict, and what was done."""

    folder: Path
    words: str
    records: tuple[StepRecord, ...]
    ledger: Mapping[str, int]
    left_out: tuple[str, ...]


def run_scene(loaded: LoadedScene, options: Options) -> Finished:
    """Run a loaded scene and write its result folder: the signals first, so that nothing after them can cost them.

    Raises
    ------
    SceneError, InputError : the scene cannot be used, or `options.out`
    WorkError : a step failed; where that was the diagnosis or the report, the folder with the signals is named
    """
    study = plan_study(
        loaded,
        with_control=options.with_control,
        both_loads=options.both_loads and options.with_report,
        seeds=options.seeds,
        baseline=options.baseline if options.with_report else 0,
    )
    diagnosing = _diagnose_step(study) if options.with_report else None
    first = study.cases[0]
    wanted = study.motions if diagnosing or study.baseline else [n for n in (first.faulty, first.healthy) if n]
    pictures = picture_steps(study.plant, study.graph.steps) if options.with_report else []
    judging = feature_steps(study) if options.with_report else []
    graph = Graph([*study.graph, *pictures, *judging])
    later = [*pictures, *judging, *_later_steps(study, diagnosing)] if options.with_report else []
    failure: Exception | None = None
    told = _Told()
    with (
        claimed(loaded.name, options.out) as claim,
        run_folder.logged_to(claim.folder / "log.jsonl"),
        options.work.observed([*graph.needed(wanted), *later]) as observer,
    ):
        cache = options.work.cache
        outcome = run_graph(
            graph,
            cache,
            wanted,
            observer=observer,
            processes=options.work.processes,
            meanwhile=[step.name for step in (*pictures, *judging)],
        )
        log_warnings(outcome.value(name) for name in study.motions if name in outcome.results)
        _write_signals(claim.folder, loaded, study, outcome)
        try:
            if options.with_report:
                outcome, told = _tell(
                    claim.folder, loaded, study, pictures, judging, diagnosing, outcome, cache, observer
                )
                run_folder.write_json(claim.folder / run_folder.RUN, _facts(loaded.name, study.plant, outcome))
        except Exception as error:
            failure = error
            _LOG.info("after the signals: %r", error, extra={"facts": {"traceback": format_exception(error)}})
    if options.out is None:
        run_folder.note_latest(claim.final)
    if failure is not None:
        raise _kept(failure, claim.final) from failure
    return Finished(
        folder=claim.final,
        words=told.words,
        records=outcome.records,
        ledger=outcome.ledger(),
        left_out=told.left_out,
    )


def _later_steps(study: Study, diagnosing: Step | None) -> list[Step]:
    """What follows the motions, for the time that it takes."""
    judging = [diagnosing, bars_step(study)] if diagnosing else []
    return [*judging, _planned_report(study, diagnosing)]


@dataclass(frozen=True, kw_only=True)
class _Told:
    """What diagnosis and report say on the terminal."""

    words: str = ""
    left_out: tuple[str, ...] = ()


def _tell(
    folder: Path,
    loaded: LoadedScene,
    study: Study,
    pictures: list[Step],
    judging: list[Step],
    diagnosing: Step | None,
    signals: Outcome,
    cache: Cache,
    observer: Observer,
) -> tuple[Outcome, _Told]:
    """Diagnosis and report of finished signals, each written as soon as it is there."""
    outcome, words, left_out = signals, "", []
    bars: LineBars | str = ""
    verdict = None
    if judging:
        outcome = _with_steps([*study.graph, *judging], judging, outcome, cache, observer)
        verdict, failure = judged(study, judging, outcome)
        left_out += [f"The ranking of components is left out: {failure}"] if failure else []
    if verdict is not None:
        words = verdict_words(verdict, study.plant, exact=not study.baseline)
        write_verdict(folder, verdict, words)
    if diagnosing is not None:
        outcome = _with_steps([*study.graph, *judging, diagnosing], [diagnosing], outcome, cache, observer)
        found = outcome.value(diagnosing.name)
        for name, content in found["files"].items():
            (folder / name).write_bytes(content)
        if found["words"]:
            outcome = _with_steps(
                [*study.graph, *judging, (step := bars_step(study))], [step], outcome, cache, observer
            )
            bars = outcome.value(step.name)
            told = f"{found['words']}\n{bars_words(bars)}"
            (folder / "diagnosis.txt").write_text(told, encoding="utf-8")
            words = f"{words}\n{told}" if study.baseline else f"{told}\n{words}"
        if found["failure"]:
            left_out.append(f"The diagnosis is left out: {found['failure']}")
    outcome = _with_steps([*study.graph, *pictures], pictures, outcome, cache, observer)
    step = _report_step(loaded, study, diagnosing, outcome, verdict, bars)
    known = [*study.graph, *pictures, *judging, *([diagnosing] if diagnosing else []), step]
    outcome = _with_steps(known, [step], outcome, cache, observer)
    report = outcome.value(step.name)
    (folder / run_folder.REPORT).write_text(report["page"], encoding="utf-8")
    return outcome, _Told(words=words, left_out=(*left_out, *report["left_out"]))


def _with_steps(
    known: Iterable[Step], steps: Iterable[Step], outcome: Outcome, cache: Cache, observer: Observer
) -> Outcome:
    """The outcome with more of the known steps, built here on what is at hand."""
    wanted = [step.name for step in steps]
    more = run_graph(Graph(known), cache, wanted, observer=observer, known=outcome.results, processes=1)
    return Outcome({**outcome.results, **more.results})


def _kept(failure: Exception, folder: Path) -> WorkError:
    """What failed after the signals were written, and where these are."""
    name = "" if isinstance(failure, WorkError) else f"{type(failure).__name__}: "
    again = ""
    if (folder / run_folder.CONTROL).is_file() and not (folder / "diagnosis.txt").is_file():
        again = f" Correct the cause, then: gearcase diagnose {folder}"
    error = WorkError(f"{name}{failure}\nThe signals are kept in {folder}.{again}")
    for note in getattr(failure, "__notes__", ()):
        error.add_note(note)
    return error


def _diagnose_step(study: Study) -> Step | None:
    """All cases against their controls; None without a control, a fault to look for, windows or sensors."""
    from pipelines.steps import diagnosing

    cases, takes, labelled = [], [], []
    for number, case in enumerate(study.cases):
        settings = case.plant.diagnosis
        if settings is None or case.healthy is None or case.control is None:
            return None
        cases.append(diagnosing.CaseSpec(settings=settings, full=number == 0 or case.label == "torque"))
        takes += [case.faulty, case.healthy]
        labelled += [case.plant.labels, case.control.labels]
    spec = diagnosing.DiagnosingSpec(cases=tuple(cases), labels=tuple(labelled))
    return Step(
        name="diagnose",
        kind="diagnose",
        build=diagnosing.build,
        spec=spec,
        takes=tuple(takes),
        libraries=("numpy", "scipy"),
    )


def _report_step(
    loaded: LoadedScene,
    study: Study,
    diagnosing: Step | None,
    outcome: Outcome,
    verdict: Verdict | None,
    bars: LineBars | str,
) -> Step:
    from pipelines.plant.checks.design_warnings import design_warnings
    from pipelines.steps import reporting

    plant, planned = study.plant, _planned_report(study, diagnosing)
    kinds = [*(fault.kind for fault in plant.faults), *("bearing-spall" for _ in plant.spalls)]
    kinds += [*(fault.kind for fault in plant.shaft_faults), "healthy"]
    names = [kinds[0].replace("-", " "), "healthy"]
    unlike = [] if study.control is None else control_differences(loaded, study.control)
    spec = reporting.ReportSpec(
        plant=plant,
        name=loaded.name,
        diagnosing=diagnosing.spec if diagnosing else None,
        meshed=CASING in planned.takes,
        elastic="casing modes" in planned.takes,
        responses=tuple(names[: 2 if diagnosing else 1]),
        steps=tuple(_cost_row(record) for record in outcome.records),
        ledger=outcome.ledger(),
        provenance=provenance(loaded.name, plant, outcome),
        failure=outcome.value(diagnosing.name)["failure"] if diagnosing else "",
        verdict=verdict,
        bars=bars,
        baseline=bool(study.baseline),
        warnings=(
            *design_warnings(loaded.scene, plant.layout),
            *(f"the control differs in more than the fault: {line}" for line in unlike),
        ),
    )
    return replace(planned, spec=spec)


def _planned_report(study: Study, diagnosing: Step | None) -> Step:
    """The step without its spec, which follows from the results of others."""
    from pipelines.steps import reporting

    meshed, elastic = (name in study.graph.steps for name in ("casing mesh", "casing modes"))
    casing = [*([CASING] if meshed else []), "casing", *(["casing modes"] if elastic else [])]
    motions = diagnosing.takes if diagnosing else (study.cases[0].faulty,)
    return Step(
        name="report",
        kind="report",
        build=reporting.build,
        takes=(CURVES, *casing, *motions),
        reads={"casing modes": reporting.casing_summary},
        libraries=("numpy", "matplotlib"),
        seconds=1.5,
    )


def _cost_row(record: StepRecord) -> dict[str, Any]:
    return {"step": record.name, "seconds": round(record.seconds, 3), "peak MB": round(record.peak_bytes / 1e6)}


def provenance(name: str, plant: Plant, outcome: Outcome) -> dict[str, Any]:
    """Versions of what the steps say they use, models and keys: the same for the same result; `name` of the scene."""
    used = {library: version for record in outcome.records for library, version in record.libraries.items()}
    return {
        "scene": name,
        "versions": {"python": platform.python_version(), **library_versions("gearcase", *WRITERS), **used},
        "models": plant.models,
        "threads per process": 1,
        "keys": {record.name: record.key[:32] for record in outcome.records},
    }


def _write_signals(folder: Path, loaded: LoadedScene, study: Study, outcome: Outcome) -> None:
    """What a diagnosis can be repeated from: the scene, its response and that of its control."""
    (folder / run_folder.ASKED).write_text(loaded.asked(), encoding="utf-8")
    own_control = study.control is not None and not control_differences(loaded, study.control)
    (folder / run_folder.RESOLVED).write_text(loaded.resolved(own_control=own_control), encoding="utf-8")
    facts = _facts(loaded.name, study.plant, outcome)
    run_folder.write_json(folder / run_folder.RUN, facts)
    case = study.cases[0]
    _write_response(folder / run_folder.RESPONSE, outcome.value(case.faulty), case.plant, facts)
    if case.healthy is not None and case.control is not None:
        _write_response(folder / run_folder.CONTROL, outcome.value(case.healthy), case.control, facts)


def _facts(name: str, plant: Plant, outcome: Outcome) -> dict[str, Any]:
    """Provenance, ledger and cost of the steps so far."""
    return {
        **provenance(name, plant, outcome),
        "ledger": outcome.ledger(),
        "steps": [
            {**_cost_row(record), "reused": record.reused, "ledger": dict(record.ledger)} for record in outcome.records
        ],
    }


def _write_response(path: Path, motion: Trajectory, plant: Plant, facts: Mapping[str, Any]) -> None:
    """The labelled signals with the facts of this run as attributes."""
    from pipelines.signals.response_file import write_response

    told = {
        "provenance": json.dumps({name: facts[name] for name in ("scene", "versions", "models", "keys")}),
        "steps": json.dumps(facts["steps"]),
        "build_ledger": json.dumps(facts["ledger"]),
    }
    write_response(motion, {**plant.labels, **told}, path)
