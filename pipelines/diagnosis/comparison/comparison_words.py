"""A comparison as text: tables of the recordings and of their features, and remarks on omitted data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.diagnosis.comparison.compared_features import Features
from pipelines.diagnosis.comparison.compared_recording import ComparedRecording
from pipelines.io.text_table import Grid, grid
from pipelines.signals.features.definitions import BY_NAME
from pipelines.signals.features.feature_table import left_out_words
from pipelines.signals.orders.revolutions import HIGHEST

LETTERS = "ABCDEFGHIJ"  # names of the recordings in tables and figures; no more recordings are compared


def recordings_grid(parts: Sequence[ComparedRecording]) -> Grid:
    """Table of all windows of the recordings with their speeds; `parts` before resampling."""
    rows = [
        {
            "": letter,
            "recording": part.name,
            "s": f"{window.start:.4g} to {window.end:.4g}",
            "turns": f"{window.turns:.1f}",
            "rpm": f"{60 * window.frequency:.5g}"
            + (f" (to {100 * part.rotation.error:.1g} %)" if part.rotation.error else ""),
            "f_m Hz": ", ".join(f"{order * window.frequency:.5g}" for order in part.kinematics.mesh_orders().values())
            or "-",
            "samples/s": f"{part.rate:.6g}",
            "speed from": part.rotation.source,
        }
        for letter, part in zip(LETTERS, parts, strict=False)
        for window in part.windows
    ]
    return grid("Recordings, turns and speed of the first shaft", rows)


def features_grid(found: Features) -> Grid:
    """Table with one row for each component and feature: values, and differences from the first recording in dB."""
    letters = LETTERS[: len(found.tables)]
    rows = [
        {
            "component": component,
            "feature": BY_NAME[feature].words,
            "unit": BY_NAME[feature].unit,
            **{letter: _cell(one, ".3g") for letter, one in zip(letters, values, strict=True)},
            **{_over_first(letter): _cell(differences[i], "+.1f") for i, letter in enumerate(letters[1:], 1)},
        }
        for (component, feature), values, differences in zip(
            found.lines, found.value.T, found.difference.T, strict=True
        )
    ]
    return grid(
        "Features in these windows, geometric mean over the common channels; a channel is one axis of a sensor", rows
    )


def features_csv(found: Features) -> str:
    """The table of features as CSV text with nine digits; missing values are empty."""
    import pandas as pd

    letters = LETTERS[: len(found.tables)]
    table = pd.DataFrame(found.lines, columns=["component", "feature"])
    table["unit"] = [BY_NAME[feature].unit for _, feature in found.lines]
    table[list(letters)] = found.value.T
    table[list(map(_over_first, letters[1:]))] = found.difference[1:].T
    return table.to_csv(index=False, float_format="%.9g", lineterminator="\n")


def remarks(recorded: Sequence[ComparedRecording], parts: Sequence[ComparedRecording], found: Features) -> list[str]:
    """Remarks: warnings, changes that made the recordings comparable, and omitted components.

    `recorded` are the original parts, `parts` those with common channels and sampling rate.
    """
    named = list(zip(LETTERS, recorded, strict=False))
    lines = [f"Warning: {letter} {warning}" for letter, part in named for warning in part.warnings]
    if len(parts[0].channels) < max(len(part.channels) for part in recorded):
        alone = [
            f"{letter} {_channels([one for one in part.channels if one not in parts[0].channels])}"
            for letter, part in named
            if len(part.channels) > len(parts[0].channels)
        ]
        lines.append(f"Compared at {_channels(parts[0].channels)}. Not in all recordings: {'; '.join(alone)}.")
    if any(part.time is not other.time for part, other in zip(parts, recorded, strict=True)):
        orders = min(HIGHEST * part.rate / part.windows[0].frequency for part in parts)
        lines.append(
            f"The sampling rates differ. All are compared at the lowest, {parts[0].rate:.6g} samples/s, which contains "
            f"orders up to {orders:.4g} of the first shaft."
        )
    if unlike := [letter for letter, part in named[1:] if _train(part) != _train(recorded[0])]:
        lines.append(f"The machine of {', '.join(unlike)} has other gears or shafts than that of A.")
    for words in filter(None, dict.fromkeys(left_out_words(table.left_out) for table in found.tables)):
        own = zip(LETTERS, found.tables, strict=False)
        letters = [letter for letter, table in own if left_out_words(table.left_out) == words]
        lines.append(f"{', '.join(letters)}: {words}")
    return lines


def _over_first(letter: str) -> str:
    return f"{letter} - A dB"


def _train(part: ComparedRecording) -> tuple[object, ...]:
    """Shafts and numbers of teeth, which determine the orders."""
    gears = tuple((gear.name, gear.shaft, gear.teeth) for gear in part.kinematics.gears)
    return (tuple((shaft.name, round(shaft.ratio, 9)) for shaft in part.kinematics.shafts), gears)


def _channels(channels: Sequence[tuple[str, str]]) -> str:
    return ", ".join(" ".join(channel) for channel in channels)


def _cell(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else "-"
