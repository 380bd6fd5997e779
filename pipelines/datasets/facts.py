"""campaign.json: what a data set is and how it was made, written when its campaign begins."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pipelines.datasets.layout import RunLayout, SignalLayout
from pipelines.io.errors import InputError
from pipelines.io.shown import shown

FACTS = "campaign.json"


def read_facts(folder: str | Path) -> dict[str, Any]:
    """What campaign.json holds.

    Raises
    ------
    InputError : this is no folder of a campaign
    """
    path = Path(folder) / FACTS
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        told["identity"], told["runs"], told["facts"]["plan"], stored_layout(told["layout"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        reason = f"it has no {FACTS}" if isinstance(error, FileNotFoundError) else shown(str(error))
        raise InputError(
            f"{shown(folder)}: not the folder of a data set ({reason}). Give the folder that `gearcase campaign` wrote."
        ) from error
    return told


def stored_layout(told: dict[str, Any]) -> RunLayout:
    """The layout in campaign.json. KeyError, TypeError if it is none."""
    signals = tuple(
        SignalLayout(
            name=one["name"],
            dims=tuple(one["dims"]),
            shape=tuple(one["shape"]),
            dtype=one["dtype"],
            attributes=one["attributes"],
        )
        for one in told["signals"]
    )
    names = {name: tuple(values) for name, values in told["names"].items()}
    return RunLayout(signals=signals, names=names, samples=told["samples"], rate=told["rate"])
