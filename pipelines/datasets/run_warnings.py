"""Warnings of the runs of a data set, counted by kind: how many runs, by how much, and which setting removes them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pipelines.datasets.folder import SCENE
from pipelines.datasets.variables_grid import sets
from pipelines.io.errors import SceneError
from pipelines.scene.load_scene import load_scene
from pipelines.scene.scene import Scene
from pipelines.signals.motion_warnings import KINDS, LARGEST_STEP_ERROR, needed_step_us

_STEP = "simulation.step_us"
_AGAIN = "Simulate again with another --out."


def run_warnings(
    folder: Path, facts: Mapping[str, Any], kinds: Sequence[str], step_errors: Sequence[float]
) -> tuple[str, ...]:
    """One text per kind of warning that a run has, with the count, the cause and the remedy.

    Parameters
    ----------
    folder, facts : of the data set, and what its campaign.json holds
    kinds : (runs that are done,) kinds of warning of each run, separated by "; "
    step_errors : (runs that are done,) error of the accelerations by the time step, share of their rms
    """
    having = {kind: [run for run, text in enumerate(kinds) if kind in text.split("; ")] for kind in KINDS}
    total = len(kinds)
    found = []
    if runs := having["step"]:
        errors = [100 * step_errors[run] for run in runs]
        found.append(
            f"{len(runs)} of {total} runs: the time step is too long. The error of the accelerations is "
            f"{_span(min(errors), max(errors))} % of their rms, limit {100 * LARGEST_STEP_ERROR:g} %. "
            f"{_shorter_step(folder, facts, max(errors) / 100)} {_AGAIN}"
        )
    if runs := having["repeat"]:
        found.append(
            f"{len(runs)} of {total} runs: the motion cannot be repeated sample by sample after repeatable_until_s, as "
            "gears rattle. Use levels and spectra of these runs, not waveforms, or leave them out by the column "
            "warnings. To avoid them, increase the load in the plan."
        )
    if runs := having["energy"]:
        found.append(
            f"{len(runs)} of {total} runs: the energy balance does not close. Set a smaller {_STEP}, or a larger "
            f"simulation.band_Hz, under [settings] of the plan. {_AGAIN}"
        )
    return tuple(found)


def _span(low: float, high: float) -> str:
    least, most = f"{low:.2g}", f"{high:.2g}"
    return least if least == most else f"{least} to {most}"


def _shorter_step(folder: Path, facts: Mapping[str, Any], worst: float) -> str:
    """The setting of the time step with which the worst run keeps the limit."""
    plan, rate = facts["facts"]["plan"], facts["layout"]["rate"]
    scene = stored_scene(folder)
    if scene is None or any(_STEP in sets(plan, name) for name in plan["variables"]):
        return f"Set a smaller {_STEP} under [settings] of the plan."
    every = max(1, math.ceil(1e6 / (rate * scene.simulation.step_us) - 1e-9))
    step = needed_step_us(worst, 1.0 / (rate * every), rate)
    return f"Set {_STEP} = {step} under [settings] of the plan (`detect`: --set {_STEP}={step})."


def stored_scene(folder: Path) -> Scene | None:
    """The scene of a data set; None where it cannot be read, as that of another version."""
    try:
        return load_scene(folder / SCENE).scene
    except SceneError:
        return None
