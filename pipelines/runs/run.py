"""Run a scene with its control, diagnose it, and write the result folder.

The files are written as results come: the signals as soon as all motions are there, so that nothing after them can cost
them, then verdict, diagnosis and report.
"""

from __future__ import annotations

import json
import logging
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from traceback import format_exception
from typing import Any

from mbd.output.trajectory import Trajectory
from pipelines.diagnosis.uncertainty.bar_words import bars_words
from pipelines.engine.build_step import Result
from pipelines.engine.code_version import library_versions
from pipelines.engine.run_graph import Outcome, Work
from pipelines.engine.step import Graph, Step, StepRecord
from pipelines.io.errors import WorkError
from pipelines.io.json_text import json_text
from pipelines.io.user_files import write_whole
from pipelines.machine.machine_model import MachineModel
from pipelines.runs import run_folder
from pipelines.runs.claims import claimed
from pipelines.scene.load_scene import LoadedScene, control_differences
from pipelines.signals.motion_warnings import log_warnings
from pipelines.steps.result_steps import BARS, DIAGNOSIS, REPORT, VERDICT, result_steps
from pipelines.steps.run_plan import RunPlan, plan_run, scene_warnings

_LOG = logging.getLogger(__name__)
_WRITERS = ("h5py", "h5netcdf", "xarray")  # of the signals


@dataclass(frozen=True, kw_only=True)
class FinishedRun:
    """A run that is written: its folder, the verdict, and what was done."""

    folder: Path
    words: str
    records: tuple[StepRecord, ...]
    ledger: Mapping[str, int]
    left_out: tuple[str, ...]


def run_scene(
    loaded: LoadedScene,
    *,
    out: str | Path | None = None,
    with_control: bool = True,
    with_report: bool = True,
    both_loads: bool = True,
    seeds: int = 0,
    baseline: int = 0,
    work: Work | None = None,
) -> FinishedRun:
    """Run a loaded scene and write its result folder: the signals first, so that nothing after them can cost them.

    Parameters
    ----------
    loaded : the scene
    out : folder of the results instead of ./runs/<scene>/<time>
    with_control, both_loads, seeds, baseline : as `plan_run`
    with_report : write diagnosis and report; without them only the signals
    work : how the steps are built

    Raises
    ------
    SceneError, InputError : the scene cannot be used, or `out`
    WorkError : a step failed; where that was the diagnosis or the report, the folder with the signals is named
    """
    work = work or Work()
    plan = plan_run(
        loaded,
        with_control=with_control,
        both_loads=both_loads and with_report,
        seeds=seeds,
        baseline=baseline if with_report else 0,
    )
    graph = Graph([*plan.graph, *(result_steps(loaded, plan) if with_report else [])])
    requested = graph.steps if with_report else plan.motions
    failure: Exception | None = None
    with claimed(loaded.name, out) as claim, run_folder.logged_to(claim.folder / "log.jsonl"):
        for text in scene_warnings(loaded, plan, with_report):
            _LOG.warning("%s", text)
        written = _Files(claim.folder, loaded, plan)
        try:
            work.build(graph, requested, written.add)
        except Exception as error:
            if not written.signals:
                raise
            failure = error
            _LOG.info("after the signals: %r", error, extra={"facts": {"traceback": format_exception(error)}})
    if out is None:
        run_folder.note_latest(claim.final)
    if failure is not None:
        raise _kept(failure, claim.final) from failure
    return FinishedRun(
        folder=claim.final,
        words=written.words,
        records=written.outcome.records,
        ledger=written.outcome.ledger(),
        left_out=tuple(written.left_out),
    )


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


class _Files:
    """The files of a run in a folder.

    Parameters
    ----------
    folder : that exists
    loaded, plan : the scene, and what is run of it
    """

    def __init__(self, folder: Path, loaded: LoadedScene, plan: RunPlan) -> None:
        self._folder, self._loaded, self._plan = folder, loaded, plan
        self._results: dict[str, Result] = {}
        self._words: dict[str, str] = {}
        self.signals = False  # whether they are written
        self.left_out: list[str] = []

    @property
    def outcome(self) -> Outcome:
        """What is finished, in the order of the graph."""
        return Outcome(self._results)

    @property
    def words(self) -> str:
        """The texts of verdict and diagnosis."""
        return "\n".join(self._words[name] for name in (VERDICT, DIAGNOSIS) if name in self._words)

    def add(self, step: Step, result: Result) -> None:
        """Write what can be written with one more result."""
        self._results[step.name] = result
        if not self.signals and all(name in self._results for name in self._plan.motions):
            self._write_signals()
            self.signals = True
        writers = {VERDICT: self._write_verdict, DIAGNOSIS: self._write_diagnosis, REPORT: self._write_report}
        if step.name in writers:
            writers[step.name](result.load())
        if {DIAGNOSIS, BARS} <= self._results.keys() and step.name in (DIAGNOSIS, BARS):
            self._write_words()

    def _write_signals(self) -> None:
        """What a diagnosis can be repeated from: the scene, its response and that of its control."""
        loaded, plan, results = self._loaded, self._plan, self._results
        log_warnings(results[name].load() for name in plan.motions)
        if "casing" in results:
            from pipelines.steps.casing import casing_warnings

            positions = {sensor.name: sensor.position for sensor in plan.machine.sensors}
            for words in casing_warnings(results["casing"].load(), positions):
                _LOG.warning("%s", words)
        (self._folder / run_folder.ASKED).write_text(loaded.asked(), encoding="utf-8")
        own_control = plan.control is not None and not control_differences(loaded, plan.control)
        resolved = loaded.resolved(own_control=own_control)
        (self._folder / run_folder.RESOLVED).write_text(resolved, encoding="utf-8")
        needed = plan.graph.needed(plan.motions).steps
        facts = _facts(loaded.name, plan, Outcome({name: results[name] for name in needed}))
        write_whole(self._folder / run_folder.RUN, json_text(facts))
        case = plan.cases[0]
        _write_response(self._folder / run_folder.RESPONSE, results[case.own.step].load(), case.own.machine, facts)
        if (control := case.control) is not None:
            _write_response(self._folder / run_folder.CONTROL, results[control.step].load(), control.machine, facts)

    def _write_verdict(self, found: Mapping[str, Any]) -> None:
        if found["failure"]:
            self.left_out.append(f"The verdict is left out: {found['failure']}")
            return
        self._words[VERDICT] = found["words"]
        write_whole(self._folder / f"{VERDICT}.json", json_text({"cases": found["cases"]}))
        (self._folder / run_folder.VERDICT).write_text(found["words"], encoding="utf-8")

    def _write_diagnosis(self, found: Mapping[str, Any]) -> None:
        for name, content in found["files"].items():
            (self._folder / name).write_bytes(content)
        if found["failure"]:
            self.left_out.append(f"The table of lines is left out: {found['failure']}")

    def _write_words(self) -> None:
        """The lines with their error bars as text."""
        if found := self._results[DIAGNOSIS].load()["words"]:
            self._words[DIAGNOSIS] = f"{found}\n{bars_words(self._results[BARS].load())}"
            (self._folder / "diagnosis.txt").write_text(self._words[DIAGNOSIS], encoding="utf-8")

    def _write_report(self, found: Mapping[str, Any]) -> None:
        from pipelines.report.report import write_report

        facts = _facts(self._loaded.name, self._plan, self.outcome)
        write_report(self._folder / run_folder.REPORT, self._plan.machine.title, found["body"], facts)
        write_whole(self._folder / run_folder.RUN, json_text(facts))
        self.left_out += found["left_out"]


def _facts(name: str, plan: RunPlan, outcome: Outcome) -> dict[str, Any]:
    """Of the steps so far: versions, models and keys, the same for the same result; ledger and cost. `name` of the
    scene."""
    used = {library: version for record in outcome.records for library, version in record.libraries.items()}
    return {
        "scene": name,
        "versions": {"python": platform.python_version(), **library_versions("gearcase", *_WRITERS), **used},
        "models": plan.machine.models,
        "baseline": len(plan.baseline),
        "threads per process": 1,
        "keys": {record.name: record.key[:32] for record in outcome.records},
        "ledger": outcome.ledger(),
        "steps": [
            {
                "step": record.name,
                "seconds": round(record.seconds, 3),
                "peak MB": round(record.peak_bytes / 1e6),
                "reused": record.reused,
                "ledger": dict(record.ledger),
            }
            for record in outcome.records
        ],
    }


def _write_response(path: Path, motion: Trajectory, machine: MachineModel, facts: Mapping[str, Any]) -> None:
    """The labelled signals with the facts of this run as attributes."""
    from pipelines.signals.response_file import write_response

    told = {
        "provenance": json.dumps({name: facts[name] for name in ("scene", "versions", "models", "keys")}),
        "steps": json.dumps(facts["steps"]),
        "build_ledger": json.dumps(facts["ledger"]),
    }
    write_response(motion, {**machine.labels, **told}, path)
