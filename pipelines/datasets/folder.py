"""The folder of a campaign. One command at a time uses it, and only the same campaign can continue it.

campaign.json       identity, plan, versions and digest of the samples; compared when a campaign is continued
plan.toml           as given
scene.toml          the scene of the plan with all its defaults, before variables are set
signals.zarr/       signals, see `pipelines.datasets.store`
rows/, rows.parquet one file for each run, and the table made from them, see `pipelines.datasets.rows`
README.md           the card
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import re
import uuid
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from fem.storage.locks import lock_file
from pipelines.datasets.campaign_scenes import SampledScene, group_variables
from pipelines.datasets.plan import Plan
from pipelines.datasets.rows import ROWS
from pipelines.datasets.signal_layout import FACTS, RunLayout, stored_layout
from pipelines.datasets.store import create_store
from pipelines.engine.code_version import code_version, library_versions
from pipelines.io.errors import InputError, WorkError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import writable_folder, write_whole

LOCK = ".lock"
_UNFINISHED = re.compile(r"\.(begun-|[0-9a-f]{32}\.)")  # files of a command that was killed, also of earlier versions
PLAN, SCENE = "plan.toml", "scene.toml"
LIBRARIES = ("numpy", "scipy", "numba", "scikit-fem", "gmsh")


def identity_facts(plan: Plan, sampled: Sequence[SampledScene]) -> dict[str, Any]:
    """Everything that determines the signals of a campaign, in a form that can be compared."""
    sample_digest = hashlib.sha256()
    for sample in sampled:
        sample_digest.update(json.dumps([sample.values, sample.group, sample.split]).encode())
    table = plan.table.model_dump(mode="json", by_alias=True, exclude={"title", "licence"})
    return {
        "plan": table,
        "scene": json.loads(json.dumps(plan.tree)),
        "draws": sample_digest.hexdigest(),
        "code": code_version("pipelines.datasets.job"),
        "versions": library_versions(*LIBRARIES),
    }


@contextlib.contextmanager
def held(folder: str | Path) -> Iterator[Path]:
    """Lock the folder of a campaign for this command.

    Raises
    ------
    InputError : the folder cannot be written, or another command uses it
    """
    place = writable_folder(folder)
    try:
        place.mkdir(parents=True, exist_ok=True)
        lock = open(place / LOCK, "ab")  # noqa: SIM115 - open until the command ends
    except OSError as error:
        raise InputError(f"{shown(place)}: cannot be written ({error.strerror}). Set another --out.") from error
    with lock:
        try:
            mine = lock_file(lock)
        except OSError:
            mine = True  # the file system has no locks
        if not mine:
            raise InputError(
                f"{shown(place)}: another command is working on this campaign. Wait for it, end it, or set another "
                "--out."
            )
        yield place


def find_begun(folder: Path, facts: dict[str, Any]) -> tuple[str, RunLayout] | None:
    """Identity and layout of the campaign that was begun in a folder; None if the folder is empty.

    Raises
    ------
    InputError : the folder holds other files, or a campaign that differs
    """
    path = folder / FACTS
    if not path.is_file():
        others = sorted(name for name in os.listdir(folder) if name != LOCK and not _UNFINISHED.match(name))
        if others and not set(others) <= {"signals.zarr", ROWS, PLAN, SCENE}:
            raise InputError(
                f"{shown(folder)}: holds {shown(others[0])} and is not the folder of a campaign. Set another --out."
            )
        return None
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        begun, layout = stored["facts"], stored_layout(stored["layout"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{shown(path)}: cannot be read ({error}). Set another --out.") from error
    different = [name for name in facts if begun.get(name) != facts[name]]
    if different:
        words = {
            "plan": "another plan",
            "scene": "another scene",
            "draws": "other samples",
            "code": "another version of gearcase",
            "versions": "other versions of its libraries",
        }
        raise InputError(
            f"{shown(folder)}: was begun with {' and '.join(words[name] for name in different)}. Use the same "
            "ones as before, or set another --out."
        )
    return stored["identity"], layout


def begin(
    folder: Path, plan: Plan, scene: str, sampled: Sequence[SampledScene], layout: RunLayout, facts: dict[str, Any]
) -> str:
    """Make the folder of a campaign, with campaign.json last; the identity of the campaign.

    Parameters
    ----------
    folder, plan, sampled, layout : of the campaign
    scene : the scene of the plan as TOML
    facts : those of `identity_facts`
    """
    identity = uuid.uuid4().hex
    with disk_errors(folder):
        (folder / ROWS).mkdir(exist_ok=True)
        (folder / PLAN).write_text(plan.text, encoding="utf-8")
        (folder / SCENE).write_text(scene, encoding="utf-8")
        attributes = {"title": plan.table.title or plan.name, "source": "gearcase campaign"}
        create_store(folder, len(sampled), layout, attributes)
        stored = {
            "identity": identity,
            "name": plan.name,
            "runs": len(sampled),
            "groups by": list(group_variables(plan.table)),
            "facts": facts,
            "layout": {"signals": [vars(one) for one in layout.signals], "names": layout.names}
            | {"samples": layout.samples, "rate": layout.rate},
            "made with": {"python": platform.python_version(), **library_versions("gearcase", "zarr")},
        }
        write_whole(folder / FACTS, json.dumps(stored, indent=1, default=dict))
    return identity


@contextlib.contextmanager
def disk_errors(folder: Path) -> Iterator[None]:
    """Raise an OSError as a WorkError with what to do, as when the disk is full."""
    try:
        yield
    except OSError as error:
        raise WorkError(
            f"{shown(folder)}: cannot be written ({error.strerror or error}). Finished scenes are kept. Free disk "
            "space or "
            "set the permission to write, then repeat the command."
        ) from error
