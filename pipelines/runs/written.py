"""The folder of a run, written as its results come: the signals as soon as all motions are there, so that nothing
after them can cost them, then verdict, diagnosis and report."""

from __future__ import annotations

import dataclasses
import json
import logging
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.diagnosis.uncertainty.words import bars_words
from pipelines.engine.build_step import Result
from pipelines.engine.code_version import library_versions
from pipelines.engine.run_graph import Observer, Outcome
from pipelines.engine.step import Step
from pipelines.report.contents import RunCost
from pipelines.report.report import write_report
from pipelines.runs import run_folder
from pipelines.runs.single_results import misread_sensors
from pipelines.scene.file import LoadedScene, control_differences
from pipelines.signals.motion_warnings import log_warnings
from pipelines.steps.results import BARS, DIAGNOSIS, REPORT, VERDICT
from pipelines.steps.study import Study

if TYPE_CHECKING:
    from mbd.output.trajectory import Trajectory
    from pipelines.machine.plant import Plant

_LOG = logging.getLogger(__name__)
WRITERS = ("h5py", "h5netcdf", "xarray")  # of the signals


class Written:
    """An observer of a run that writes what is finished into a folder.

    Parameters
    ----------
    folder : that exists
    loaded, study : the scene, and what is run of it
    observer : of the same run, which every event is passed to
    """

    def __init__(self, folder: Path, loaded: LoadedScene, study: Study, observer: Observer) -> None:
        self._folder, self._loaded, self._study, self._observer = folder, loaded, study, observer
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
        """The texts of diagnosis and verdict; the verdict first where it compares with other machines."""
        order = (VERDICT, DIAGNOSIS) if self._study.baseline else (DIAGNOSIS, VERDICT)
        return "\n".join(self._words[name] for name in order if name in self._words)

    def started(self, step: Step) -> None:
        """Pass on."""
        self._observer.started(step)

    def advanced(self, step: Step, share: float) -> None:
        """Pass on."""
        self._observer.advanced(step, share)

    def finished(self, step: Step, result: Result) -> None:
        """Pass on, then write what can be written now."""
        self._observer.finished(step, result)
        self._results[step.name] = result
        if not self.signals and all(name in self._results for name in self._study.motions):
            self._write_signals()
            self.signals = True
        if step.name == VERDICT:
            self._write_verdict(result.load())
        elif step.name == DIAGNOSIS:
            self._write_diagnosis(result.load())
        elif step.name == REPORT:
            self._write_report(result.load())
        if {DIAGNOSIS, BARS} <= self._results.keys() and step.name in (DIAGNOSIS, BARS):
            self._write_words()

    def _write_signals(self) -> None:
        """What a diagnosis can be repeated from: the scene, its response and that of its control."""
        loaded, study, results = self._loaded, self._study, self._results
        log_warnings(results[name].load() for name in study.motions)
        if "casing" in results:
            positions = {sensor.name: sensor.position for sensor in study.plant.sensors}
            for words in misread_sensors(results["casing"].load(), positions):
                _LOG.warning("%s", words)
        (self._folder / run_folder.ASKED).write_text(loaded.asked(), encoding="utf-8")
        own_control = study.control is not None and not control_differences(loaded, study.control)
        resolved = loaded.resolved(own_control=own_control)
        (self._folder / run_folder.RESOLVED).write_text(resolved, encoding="utf-8")
        needed = study.graph.needed(study.motions).steps
        facts = run_facts(loaded.name, study.plant, Outcome({name: results[name] for name in needed}))
        run_folder.write_json(self._folder / run_folder.RUN, facts)
        case = study.cases[0]
        _write_response(self._folder / run_folder.RESPONSE, results[case.faulty].load(), case.plant, facts)
        if case.healthy is not None and case.control is not None:
            _write_response(self._folder / run_folder.CONTROL, results[case.healthy].load(), case.control, facts)

    def _write_verdict(self, found: Mapping[str, Any]) -> None:
        if found["failure"]:
            self.left_out.append(f"The ranking of components is left out: {found['failure']}")
            return
        self._words[VERDICT] = found["words"]
        run_folder.write_json(self._folder / f"{VERDICT}.json", dataclasses.asdict(found["verdict"]))
        (self._folder / f"{VERDICT}.txt").write_text(found["words"], encoding="utf-8")

    def _write_diagnosis(self, found: Mapping[str, Any]) -> None:
        for name, content in found["files"].items():
            (self._folder / name).write_bytes(content)
        if found["failure"]:
            self.left_out.append(f"The diagnosis is left out: {found['failure']}")

    def _write_words(self) -> None:
        """The diagnosis with its error bars as text."""
        if found := self._results[DIAGNOSIS].load()["words"]:
            self._words[DIAGNOSIS] = f"{found}\n{bars_words(self._results[BARS].load())}"
            (self._folder / "diagnosis.txt").write_text(self._words[DIAGNOSIS], encoding="utf-8")

    def _write_report(self, found: Mapping[str, Any]) -> None:
        plant, outcome = self._study.plant, self.outcome
        rows = [_cost_row(record) for record in outcome.records]
        told = provenance(self._loaded.name, plant, outcome)
        cost = RunCost(steps=rows, ledger=outcome.ledger(), provenance=told)
        write_report(self._folder / run_folder.REPORT, plant.title, found["body"], cost)
        run_folder.write_json(self._folder / run_folder.RUN, run_facts(self._loaded.name, plant, outcome))
        self.left_out += found["left_out"]


def provenance(name: str, plant: Plant, outcome: Outcome) -> dict[str, Any]:
    """Versions of the libraries, models and keys: the same for the same result; `name` of the scene."""
    used = {library: version for record in outcome.records for library, version in record.libraries.items()}
    return {
        "scene": name,
        "versions": {"python": platform.python_version(), **library_versions("gearcase", *WRITERS), **used},
        "models": plant.models,
        "threads per process": 1,
        "keys": {record.name: record.key[:32] for record in outcome.records},
    }


def run_facts(name: str, plant: Plant, outcome: Outcome) -> dict[str, Any]:
    """Provenance, ledger and cost of the steps so far; `name` of the scene."""
    return {
        **provenance(name, plant, outcome),
        "ledger": outcome.ledger(),
        "steps": [
            {**_cost_row(record), "reused": record.reused, "ledger": dict(record.ledger)} for record in outcome.records
        ],
    }


def _cost_row(record: Any) -> dict[str, Any]:
    return {"step": record.name, "seconds": round(record.seconds, 3), "peak MB": round(record.peak_bytes / 1e6)}


def _write_response(path: Path, motion: Trajectory, plant: Plant, facts: Mapping[str, Any]) -> None:
    """The labelled signals with the facts of this run as attributes."""
    from pipelines.signals.response_file import write_response

    told = {
        "provenance": json.dumps({name: facts[name] for name in ("scene", "versions", "models", "keys")}),
        "steps": json.dumps(facts["steps"]),
        "build_ledger": json.dumps(facts["ledger"]),
    }
    write_response(motion, {**plant.labels, **told}, path)
