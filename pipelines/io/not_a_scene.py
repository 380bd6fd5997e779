"""Refusal of a TOML file that is no scene (machine file of a recording, plan of a campaign), with its command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipelines.io.errors import InputError

SCENE_KEYS = ("stages", "extends")  # a file with one of these is a scene
MACHINE_KEYS = ("teeth", "ratios", "speed_rpm", "rate_Hz", "tachometer")
_PLAN_KEYS = ("scene", "variables", "settings", "cases")


def refuse_other_file(tree: Mapping[str, Any], name: str) -> None:
    """Name the kind of a file that is no scene, and the command that reads it.

    Parameters
    ----------
    tree : of the file
    name : of the file, for the message

    Raises
    ------
    InputError : the file is a machine file, or the plan of a campaign
    """
    if any(key in tree for key in SCENE_KEYS):
        return
    if any(key in tree for key in MACHINE_KEYS):
        raise InputError(
            f"{name}: this is a machine file, and a scene is needed. Give the machine file to: gearcase diagnose "
            f"RECORD --machine {name}. For a scene: gearcase new FILE.toml"
        )
    if any(key in tree for key in _PLAN_KEYS):
        raise InputError(
            f"{name}: this is the plan of a campaign, and a scene is needed. Give the plan to: gearcase campaign {name}"
        )
