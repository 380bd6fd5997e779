"""Run a scene with its control, diagnose it, and write the result folder."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from traceback import format_exception

from pipelines.engine.step import Graph, StepRecord
from pipelines.engine.working import Work
from pipelines.io.errors import WorkError
from pipelines.runs import run_folder
from pipelines.runs.claims import claimed
from pipelines.runs.written import Written
from pipelines.scene.file import LoadedScene
from pipelines.steps.results import result_steps
from pipelines.steps.study import plan_study

_LOG = logging.getLogger(__name__)


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
    graph = Graph([*study.graph, *(result_steps(loaded, study) if options.with_report else [])])
    wanted = graph.steps if options.with_report else study.motions
    failure: Exception | None = None
    with claimed(loaded.name, options.out) as claim, run_folder.logged_to(claim.folder / "log.jsonl"):
        written = Written(claim.folder, loaded, study)
        try:
            options.work.build(graph, wanted, written.add)
        except Exception as error:
            if not written.signals:
                raise
            failure = error
            _LOG.info("after the signals: %r", error, extra={"facts": {"traceback": format_exception(error)}})
    if options.out is None:
        run_folder.note_latest(claim.final)
    if failure is not None:
        raise _kept(failure, claim.final) from failure
    return Finished(
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
