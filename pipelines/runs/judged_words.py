"""Diagnosed recordings as text, tables and plain facts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from pipelines.io.text_table import Grid, grid

if TYPE_CHECKING:
    import numpy as np

    from pipelines.runs.judged_recording import JudgedFile
    from pipelines.signals.features.feature_table import FeatureTable


def file_words(found: JudgedFile) -> str:
    """Verdict and speed as text; without healthy recordings the features."""
    from pipelines.diagnosis.impacts import impact_words
    from pipelines.diagnosis.verdict_words import text
    from pipelines.signals.levels import level_grid

    parts = [found.recorded.turning, *(f"Warning: {warning}" for warning in found.recorded.warnings)]
    levels = [f"{level_grid(found.recorded.levels).to_text()}\n"] if found.recorded.levels else []
    if found.verdict is not None:
        answer, _, tables = text(found.verdict).partition("\n\n")
        return "\n\n".join([answer, *parts, tables.rstrip(), *levels])
    parts = [impact_words(found.recorded.table), *parts]
    parts += [features_grid(found.recorded.table).to_text(), *levels]
    return "\n\n".join(parts) + "\n"


def files_grid(names: Sequence[str], found: Sequence[JudgedFile], refused: Iterable[str] = ()) -> Grid:
    """Table of recordings that were judged in the same way: name, speed, level, answer and strongest evidence.

    Parameters
    ----------
    names, found : the recordings
    refused : names of recordings that cannot be judged
    """
    from pipelines.diagnosis.impacts import CLEAR
    from pipelines.diagnosis.verdict_words import STRENGTH, answer, strength
    from pipelines.signals.features.feature_table import WHOLE
    from pipelines.signals.orders.rotation import percent

    rows: list[dict[str, str]] = []
    for name, one in zip(names, found, strict=True):
        table = one.recorded.table
        rms = mean_features(table)[table.lines.index((WHOLE, "rms"))]
        result = ("-", "-", "-")
        if one.verdict is not None:
            first = one.verdict.first
            components = " or ".join([first.component, *one.verdict.candidates])
            result = answer(one.verdict), components, strength(first.evidence)
        elif one.impacts:
            best = one.impacts[0]
            result = "damaged" if best.clear else "-", best.component, f"{best.level:.1f}"
        evidence = f"impacts dB (limit {CLEAR:g})" if one.verdict is None else STRENGTH
        known = {
            "rpm": f"{60 * table.speed[0]:.5g}",
            "known to %": percent(one.recorded.error),
            "rms m/s2": f"{rms:.3g}",
        }
        named = zip(("answer", "strongest evidence", evidence), result, strict=True)
        moment = {} if one.recorded.begin is None else {"begins": f"{one.recorded.begin:%Y-%m-%d %H:%M:%S}"}
        rows.append({"": str(len(rows) + 1), "recording": name, **dict(named), **moment, **known})
    rows += [dict.fromkeys(rows[0], "-") | {"recording": name, "answer": "refused"} for name in refused]
    return grid(f"{len(rows)} recordings", rows)


def file_facts(found: JudgedFile) -> dict[str, Any]:
    """The verdict (None without healthy recordings), and every feature as the mean over the channels."""
    from pipelines.signals.features.definitions import BY_NAME

    table = found.recorded.table
    features = [
        {"component": component, "feature": feature, "unit": BY_NAME[feature].unit, "value": float(value)}
        for (component, feature), value in zip(table.lines, mean_features(table), strict=True)
    ]
    return {
        "recording": found.recorded.name,
        "begin": None if found.recorded.begin is None else found.recorded.begin.isoformat(),
        "turning": found.recorded.turning,
        "speed_rpm": 60 * float(table.speed[0]),
        "speed_uncertainty_percent": 100 * found.recorded.error,
        "warnings": found.recorded.warnings,
        "verdict": found.verdict,
        "impacts": found.impacts,
        "levels": found.recorded.levels,
        "features": features,
        "left_out": table.left_out,
    }


def mean_features(table: FeatureTable) -> np.ndarray:
    """Features (line,) as the geometric mean over the channels."""
    import numpy as np

    return np.exp(np.mean(np.log(np.maximum(table.value, np.finfo(float).tiny)), axis=0))


def features_grid(table: FeatureTable) -> Grid:
    """Table with a row for each component and feature, as the mean over the channels."""
    from pipelines.signals.features.definitions import BY_NAME

    rows = [
        {
            "component": component,
            "feature": BY_NAME[feature].words,
            "value": f"{mean:.3g}",
            "dB": f"{20 * math.log10(mean):.1f}",
        }
        for (component, feature), mean in zip(table.lines, mean_features(table), strict=True)
    ]
    return grid("Features, mean over all channels", rows)
