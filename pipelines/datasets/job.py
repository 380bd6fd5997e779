"""Simulation of one scene of a campaign in a worker process, which also writes its signals and its row.

If the worker cannot reach the folder of the campaign, as on a machine without a shared file system, it returns both.
"""

from __future__ import annotations

import functools
import json
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.datasets.campaign_scenes import SampledScene, scene_key, scene_of
from pipelines.datasets.labels import labels
from pipelines.datasets.plan import Plan
from pipelines.datasets.rows import DONE, FAILED, write_row
from pipelines.datasets.signal_layout import FACTS, RunLayout, run_arrays
from pipelines.datasets.store import write_run
from pipelines.datasets.worker_cache import WorkerCache
from pipelines.engine.build_step import one_thread
from pipelines.engine.cache import Cache
from pipelines.io.errors import CacheWarning
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.signals.motion_warnings import motion_warnings
from pipelines.steps.motion import moved


@dataclass(frozen=True, kw_only=True)
class Job:
    """A scene to simulate, with the identity of its campaign and the folder on the machine of the command."""

    plan: Plan
    layout: RunLayout
    folder: Path
    identity: str
    sample: SampledScene


def row_head(job: Job, status: str, reason: str = "") -> dict[str, Any]:
    """The columns of a row that do not depend on the simulation."""
    one = job.sample
    head = {"run": one.run, "key": "", "status": status, "reason": reason, "values": dict(one.values)}
    return head | {"group": one.group, "split": one.split}


def work(job: Job) -> tuple[dict[str, Any], Mapping[str, np.ndarray] | None]:
    """Simulate a scene and write its signals and its row. An error of the scene is written to the row.

    The result is the row, and None or, if this process does not reach the folder, the signals that are to be written.

    Raises
    ------
    OSError : a file cannot be written or read
    """
    begun = time.perf_counter()
    arrays: dict[str, np.ndarray] = {}
    row = row_head(job, DONE)
    try:
        with one_thread(), warnings.catch_warnings():
            warnings.simplefilter("once", CacheWarning)
            found, arrays = _simulated(job)
        row |= found
    except OSError:
        raise
    except Exception as error:
        row = row_head(job, FAILED, _reason(error))
    row["seconds"] = round(time.perf_counter() - begun, 3)
    if not _reaches(job.folder, job.identity):
        return row, arrays
    keep(job.folder, row, arrays)
    return row, None


def keep(folder: Path, row: dict[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Write the signals of a run, if it has any, then its row with their checksums."""
    if arrays:
        row["checksums"] = write_run(folder, row["run"], arrays)
    write_row(folder, row["run"], row)


def _simulated(job: Job) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    loaded = scene_of(job.plan, job.sample.values)
    machine = checked_machine(loaded.scene, loaded.source.shown)
    system = _worker_cache(str(Cache().folder)).system(machine)
    begun = time.perf_counter()
    motion = moved(system, machine.motion)
    loop = time.perf_counter() - begun
    row = {
        "key": scene_key(loaded),
        "labels": labels(machine),
        "quality": {
            "step_error": motion.step_error,
            "repeatable_until_s": motion.diverged_at or float(motion.time[-1]),
            "warnings": "; ".join(motion_warnings(motion)),
        },
        "loop_seconds": round(loop, 3),
    }
    return row, run_arrays(motion, job.layout)


@functools.lru_cache(maxsize=1)
def _worker_cache(folder: str) -> WorkerCache:
    """The worker cache of this process."""
    return WorkerCache(Cache(folder))


def _reaches(folder: Path, identity: str) -> bool:
    """True if this process can read the folder of the campaign."""
    try:
        return json.loads((folder / FACTS).read_text(encoding="utf-8"))["identity"] == identity
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _reason(error: Exception) -> str:
    """The reason why a scene failed, on one line."""
    ours = type(error).__module__.partition(".")[0] in ("fem", "mbd", "pipelines")
    name = "" if ours else f"{type(error).__name__}: "
    return f"{name}{' '.join(str(error).split())}"[:1000]
