"""The folder of a campaign: made once, held by one command at a time, and gone on with only by the same campaign.

campaign.json       identity, plan, versions, what was drawn and how; a campaign that goes on compares it
plan.toml           as given
scene.toml          the scene of the plan with all its defaults, before anything is varied
signals.zarr/       signals, see `pipelines.datasets.store`
rows/, rows.parquet one file per run, and the table made of them, see `pipelines.datasets.rows`
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
from pipelines.datasets.layout import FACTS, RunLayout, stored_layout
from pipelines.datasets.plan import Plan
from pipelines.datasets.rows import ROWS
from pipelines.datasets.scenes import Draw, group_variables
from pipelines.datasets.store import create_store
from pipelines.engine.code_version import code_version, library_versions
from pipelines.io.errors import InputError, WorkError
from pipelines.io.shown import shown
from pipelines.io.user_files import writable_folder, write_whole

LOCK = ".lock"
_UNFINISHED = re.compile(r"\.(begun-|[0-9a-f]{32}\.)")  # what a command that was killed leaves, also an earlier one
PLAN, SCENE = "plan.toml", "scene.toml"
LIBRARIES = ("numpy", "scipy", "numba", "scikit-fem", "gmsh")


def identity_facts(plan: Plan, draws: Sequence[Draw]) -> dict[str, Any]:
    """Everything that the signals of a campaign hang on, in a form that can be compared."""
    draw_digest = hashlib.sha256()
    for draw in draws:
        draw_digest.update(json.dumps([draw.values, draw.group, draw.split]).encode())
    table = plan.table.model_dump(mode="json", by_alias=True, exclude={"title", "licence"})
    return {
        "plan": table,
        "scene": json.loads(json.dumps(plan.tree)),
        "draws": draw_digest.hexdigest(),
        "code": code_version("pipelines.datasets.job"),
        "versions": library_versions(*LIBRARIES),
    }


@contextlib.contextmanager
def held(folder: str | Path) -> Iterator[Path]:
    """The folder of a campaign for this command alone.

    Raises
    ------
    InputError : it cannot be written, or another command works on it
    """
    place = writable_folder(folder)
    try:
        place.mkdir(parents=True, exist_ok=True)
        lock = open(place / LOCK, "ab")  # noqa: SIM115 - held until the command ends
    except OSError as error:
        raise InputError(f"{shown(place)}: cannot be written ({error.strerror}). Set another --out.") from error
    with lock:
        try:
            mine = lock_file(lock)
        except OSError:
            mine = True  # a file system without locks
        if not mine:
            raise InputError(
                f"{shown(place)}: another command is working on this campaign. Wait for it, end it, or set another "
                "--out."
            )
        yield place


def find_begun(folder: Path, facts: dict[str, Any]) -> tuple[str, RunLayout] | None:
    """Identity and layout of the campaign that was begun here; None in an empty folder.

    Raises
    ------
    InputError : the folder holds something else, or a campaign that differs
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
        told = json.loads(path.read_text(encoding="utf-8"))
        begun, layout = told["facts"], stored_layout(told["layout"])
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
            f"{shown(folder)}: was begun with {' and '.join(words[name] for name in different)}. Use what it was begun "
            "with, or set another --out."
        )
    return told["identity"], layout


def begin(folder: Path, plan: Plan, scene: str, draws: Sequence[Draw], layout: RunLayout, facts: dict[str, Any]) -> str:
    """Make the folder of a campaign, its facts last; the identity.

    Parameters
    ----------
    folder, plan, draws, layout, facts : what the campaign is
    scene : its scene as text
    """
    identity = uuid.uuid4().hex
    with stored_or_said(folder):
        (folder / ROWS).mkdir(exist_ok=True)
        (folder / PLAN).write_text(plan.text, encoding="utf-8")
        (folder / SCENE).write_text(scene, encoding="utf-8")
        attributes = {"title": plan.table.title or plan.name, "source": "gearcase campaign"}
        create_store(folder, len(draws), layout, attributes)
        told = {
            "identity": identity,
            "name": plan.name,
            "runs": len(draws),
            "groups by": list(group_variables(plan.table)),
            "facts": facts,
            "layout": {"signals": [vars(one) for one in layout.signals], "names": layout.names}
            | {"samples": layout.samples, "rate": layout.rate},
            "made with": {"python": platform.python_version(), **library_versions("gearcase", "zarr")},
        }
        write_whole(folder / FACTS, json.dumps(told, indent=1, default=dict))
    return identity


@contextlib.contextmanager
def stored_or_said(folder: Path) -> Iterator[None]:
    """WorkError where the disk takes no more."""
    try:
        yield
    except OSError as error:
        raise WorkError(
            f"{shown(folder)}: cannot be written ({error.strerror or error}). Finished scenes are kept. Free disk "
            "space or "
            "set the permission to write, then repeat the command."
        ) from error
