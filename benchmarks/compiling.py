"""Which functions the first run of a scene compiles, over all its processes: python -m benchmarks.compiling [SCENE].

The command runs with an empty cache. Meanwhile the folder of compiled code is watched: the lock of a function is there
as long as a process compiles it, and every time it is compiled its file is written anew. Seconds are wall time, beside
whatever the run does at the same time.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

from fem.processes.child import command

_LOOK_SECONDS = 0.01
_LOCK, _CODE = ".lock", ".code"


def compiled_by(run: list[str], cache: Path) -> dict[str, tuple[int, float]]:
    """How often, and in how many seconds, a command that uses an empty cache compiled each function."""
    environment = {**os.environ, "GEARCASE_CACHE": str(cache)}
    environment.pop("NUMBA_CACHE_DIR", None)
    files: dict[str, set[int]] = defaultdict(set)  # numbers of the files seen under a name
    locked: dict[str, list[float]] = {}  # first and last look that saw the lock
    child = subprocess.Popen(run, env=environment, stdout=subprocess.DEVNULL)
    while child.poll() is None:
        for entry in os.scandir(cache / "compiled") if (cache / "compiled").is_dir() else ():
            name = entry.name
            if name.endswith(_LOCK):
                now = time.perf_counter()
                locked.setdefault(name.removesuffix(_LOCK), [now, now])[1] = now
            elif name.endswith(_CODE):
                files[name].add(entry.inode())
        time.sleep(_LOOK_SECONDS)
    if child.returncode:
        raise SystemExit(f"the run ended with code {child.returncode}")
    seconds = {name: last - first for name, (first, last) in locked.items()}
    return {name: (len(numbers), seconds.get(name, 0.0)) for name, numbers in files.items()}


def main(scene: str) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        run = command("gearcase", "run", scene, "-q", "--out", str(Path(folder) / "run"))
        found = compiled_by(run, Path(folder) / "cache")
    rows = sorted(found.items(), key=lambda one: -one[1][1])
    for name, (number, seconds) in rows:
        print(f"{seconds:7.2f} s, {number} x  {name.rpartition('_')[0]}")
    times = sum(number for _, (number, _) in rows)
    print(f"{sum(seconds for _, (_, seconds) in rows):7.2f} s  {len(rows)} functions, compiled {times} times")
    used = os.times()
    print(f"{used.children_user + used.children_system:7.2f} s  processor time of the run, over all its processes")


if __name__ == "__main__":
    main(sys.argv[1] if sys.argv[1:] else "rig-missing-tooth")
