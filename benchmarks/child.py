"""Runs one part of the benchmark in a process of its own: python -m benchmarks.child FOLDER PART.

Prints one line of JSON: rows, seconds and peak memory, or the reason why the part was skipped.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

PARTS = {
    "laws": ("benchmarks.gears", "laws"),
    "evaluation": ("benchmarks.gears", "evaluation"),
    "mesh": ("benchmarks.casing", "mesh"),
    "factors": ("benchmarks.casing", "factors"),
    "modes": ("benchmarks.casing", "modes"),
    "static": ("benchmarks.casing", "static"),
    "loop": ("benchmarks.motion", "loop"),
    "models": ("benchmarks.motion", "models"),
    "precision": ("benchmarks.motion", "precision"),
    "presets": ("benchmarks.presets", "presets"),
    "campaign": ("benchmarks.campaigns", "campaign"),
    "lockstep": ("benchmarks.lockstep", "lockstep"),
}


def measure(name: str, folder: Path) -> dict[str, Any]:
    """Rows of a part with the seconds and the peak memory of the process, or `skipped` with the reason."""
    import importlib

    from threadpoolctl import threadpool_limits

    from benchmarks.clock import peak_megabytes

    module, function = PARTS[name]
    start = time.perf_counter()
    try:
        work = getattr(importlib.import_module(module), function)
        with threadpool_limits(1):
            rows = work(folder)
    except (ImportError, OSError, RuntimeError, ValueError) as error:
        return {"skipped": f"{type(error).__name__}: {error}"}
    return {"rows": rows, "part_seconds": time.perf_counter() - start, "peak_MB": peak_megabytes()}


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[2], Path(sys.argv[1]))))
