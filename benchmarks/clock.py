"""Seconds and memory: the median of repeated calls, the peak memory of a process, the conditions of a measurement."""

from __future__ import annotations

import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from importlib import metadata
from typing import Any

LIBRARIES = ("gearcase", "numpy", "scipy", "numba", "gmsh", "scikit-fem", "pymetis", "pydantic")
LONG = 8.0  # s; what takes longer is measured once


def timed(work: Callable[[], Any], repeats: int = 3) -> tuple[dict[str, float], Any]:
    """Median wall-clock and processor seconds of `work`, with the number of calls, and the last result.

    A call that takes longer than `LONG` is not repeated.
    """
    wall, processor, result = [], [], None
    for _ in range(repeats):
        start, start_processor = time.perf_counter(), time.process_time()
        result = work()
        wall.append(time.perf_counter() - start)
        processor.append(time.process_time() - start_processor)
        if wall[0] > LONG:
            break
    median = {"seconds": statistics.median(wall), "cpu_seconds": statistics.median(processor), "calls": len(wall)}
    return median, result


def peak_megabytes() -> float:
    """Largest resident memory of this process so far, MB (1e6 bytes)."""
    if sys.platform == "win32":
        import psutil

        return psutil.Process().memory_info().peak_wset / 1e6
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6


def conditions() -> dict[str, Any]:
    """What a reader must know to compare: cores, Python and library versions; nothing that names a machine."""
    versions = {}
    for name in LIBRARIES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            versions[name] = "not installed"
    return {
        "date": time.strftime("%Y-%m-%d"),
        "cores": os.cpu_count(),
        "threads": 1,
        "architecture": platform.machine(),
        "system": platform.system(),
        "python": platform.python_version(),
        "libraries": versions,
    }
