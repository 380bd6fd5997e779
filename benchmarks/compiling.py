"""What compiling adds to the first run of all: python -m benchmarks.compiling.

`minimal` runs in a process of its own with an empty cache, and again with nothing but the compiled code kept. Processor
seconds, so that other work on the machine counts little.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

PLACES = 10  # functions that are listed


def measured(out: str) -> None:
    """Run the scene into a folder; print its seconds, and those of every function that is kept on disk."""
    from numba.core import event

    from pipelines.runs.run import Options, run_scene
    from pipelines.scene.file import load_scene

    started: dict[Any, float] = {}
    seconds: dict[str, float] = {}

    class Compiling(event.Listener):
        def on_start(self, event: Any) -> None:
            started[event.data["dispatcher"]] = time.process_time()

        def on_end(self, event: Any) -> None:
            made = event.data["dispatcher"]
            if type(made._cache).__name__ == "_Stored":
                seconds[made.py_func.__qualname__.rpartition("_")[0]] = time.process_time() - started[made]

    with event.install_listener("numba:compile", Compiling()):
        run_scene(load_scene("minimal"), Options(out=out))
    print(f"{time.process_time():7.1f} s in all, {sum(seconds.values()):.1f} s compiling")
    for name, spent in sorted(seconds.items(), key=lambda one: -one[1])[:PLACES]:
        print(f"{spent:7.1f} s {name}")


def main() -> None:
    """Cold, then with compiled code."""
    with tempfile.TemporaryDirectory() as folder:
        cache = Path(folder) / "cache"
        environment = {**os.environ, "GEARCASE_CACHE": str(cache)}
        environment.pop("NUMBA_CACHE_DIR", None)
        for name in ("empty cache", "compiled code kept"):
            shutil.rmtree(cache / "entries", ignore_errors=True)
            print(name, flush=True)
            run = [sys.executable, "-m", __spec__.name, str(Path(folder) / name)]
            subprocess.run(run, env=environment, check=True)


if __name__ == "__main__":
    measured(sys.argv[1]) if sys.argv[1:] else main()
