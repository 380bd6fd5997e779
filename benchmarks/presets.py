"""Part `presets`: the full rig under each preset, cold, and how far its answers are from those of the reference.

Cold: an empty cache, compiled code on disk (a run of its own before compiles it), `gearcase simulate` as a user types
it, from the start of the process to the written signals. Each has a cache of its own, because the scene as written and
`standard` share steps; the errors are read from all of them together.
"""

from __future__ import annotations

import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

from fem.processes.child import command, environment
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import Work
from pipelines.scene.load_scene import LoadedScene, changed, load_scene
from pipelines.scene.presets import PRESETS, preset_settings
from pipelines.studies.trade.measured_variants import Measured, measure
from pipelines.studies.trade.probes import PROBES
from pipelines.studies.trade.tradeoff import differences
from pipelines.studies.trade.tradeoff_output import LEVELS

SCENE, REFERENCE = "rig-missing-tooth", PRESETS[-1]
COMPILED = ("minimal", "--set", "stages.1.mesh.model=solid", "--set", "simulation.end_s=0.05",
            "--set", "diagnosis.windows_s={}")  # fmt: skip
AS_WRITTEN = "as shipped"


def presets(folder: Path) -> list[dict[str, Any]]:
    """Rows of seconds, memory and largest errors; last, the presets with the laws of the reference injected."""
    loaded, cold = load_scene(SCENE), folder / "cold"
    run(folder / "compiled", *COMPILED)
    walls = {}
    for preset in (AS_WRITTEN, *PRESETS):
        own = folder / preset
        walls[preset] = run(own, SCENE, *(() if preset == AS_WRITTEN else ("--preset", preset)))
        shutil.copytree(own / "cache", cold / "cache", dirs_exist_ok=True)
    asked = {preset: preset_settings(loaded.scene, preset) for preset in PRESETS}
    laws = {key: value for key, value in asked[REFERENCE].items() if key.endswith(".mesh")}
    asked |= {f"{preset}, laws of {REFERENCE}": asked[preset] | laws for preset in PRESETS if preset != REFERENCE}
    scenes: dict[str, LoadedScene] = {AS_WRITTEN: loaded}
    scenes |= {name: changed(loaded, settings) for name, settings in asked.items()}
    found = measure(scenes, list(PROBES), Work(cache=Cache(cold / "cache")))
    return [row(name, one, found[REFERENCE], walls.get(name)) for name, one in found.items()]


def run(cache: Path, *arguments: str) -> float:
    """Wall-clock seconds of `gearcase simulate`."""
    out = cache / f"signals {len(list(cache.glob('signals *')))}"
    gearcase = command("pipelines.cli.main", "simulate", *arguments, "--out", str(out), "-q")
    code = cache.parent / "code"  # compiled code is on disk already when the cache is cold
    own = environment(GEARCASE_CACHE=str(cache / "cache"), NUMBA_CACHE_DIR=str(code))
    start = time.perf_counter()
    done = subprocess.run(gearcase, env=own, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"gearcase simulate {' '.join(arguments)} ended with {done.returncode}: {done.stderr}")
    return time.perf_counter() - start


def row(name: str, one: Measured, reference: Measured, wall: float | None) -> dict[str, Any]:
    """Stage seconds, memory and errors of a preset."""
    errors = differences(one, reference)
    return {
        "preset": name,
        "wall_seconds": wall,
        "law_seconds": sum(s for stage, s in one.seconds.items() if "law" in stage),
        "casing_seconds": sum(s for stage, s in one.seconds.items() if "casing" in stage),
        "motion_seconds": one.seconds["simulate"],
        "peak_MB": one.peak_bytes / 1e6,
        "errors": {probe: error for probe, error in errors.items() if probe not in LEVELS},
        "decibels": {probe: error for probe, error in errors.items() if probe in LEVELS},
    }
