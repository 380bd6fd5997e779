"""Runs of `minimal` in processes of their own, to be disturbed: killed, cut short, without room for their files."""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import xarray
from time_limit import HANGING

from pipelines.engine.storage import digest
from pipelines.runs.run_folder import CONTROL, RESPONSE

SHORT = {"simulation.end_s": 0.05, "diagnosis.windows_s": {}}
ARGUMENTS = [part for name, value in SHORT.items() for part in ("--set", f"{name}={value}")]
KILLS_PER_CACHE = 10
PROVENANCE = ("provenance", "steps", "build_ledger", "folder")


def bits(data: xarray.Dataset) -> str:
    """Digest of a response without what tells when and by whom it was made."""
    data.attrs = {name: value for name, value in data.attrs.items() if name not in PROVENANCE}
    return digest(data.load())


def whole_results(folder: Path) -> dict[str, str]:
    """Digest of every result under ``folder`` that looks whole, by its name."""
    found = {}
    for place in sorted((folder / "runs" / "minimal").glob("[!.]*/")):
        for name in (RESPONSE, CONTROL):
            if (place / name).exists():
                with xarray.open_dataset(place / name, engine="h5netcdf") as data:
                    found[f"{place.name}/{name}"] = bits(data)
    return found


def start(folder: Path, *, limit: int | None = None, cache: Path | None = None) -> subprocess.Popen:
    """``gearcase run minimal`` in its own process; ``limit`` is the largest file it may write, as a full disk is."""
    environment = {
        **os.environ,
        "GEARCASE_CACHE": str(cache or folder / "cache"),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    command = [sys.executable, "-m", "pipelines.cli.main", "run", "minimal", "--no-control", *ARGUMENTS]
    tight = None if limit is None else (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    return subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=tight,
    )


def kill(folder: Path, undisturbed: tuple[str, float], *, between: tuple[float, float], kills: int, seed: int) -> int:
    """Kill runs at random moments and look at what is left after every tenth; how many were at work when killed.

    `between` are parts of the seconds of an undisturbed run.
    """
    wanted, seconds = undisturbed
    draw = random.Random(seed)
    at_work = 0
    for _ in range(kills // KILLS_PER_CACHE):
        shutil.rmtree(folder / "cache", ignore_errors=True)
        for moment in sorted(draw.uniform(*between) * seconds for _ in range(KILLS_PER_CACHE)):
            process = start(folder)
            time.sleep(moment)
            at_work += process.poll() is None
            process.send_signal(signal.SIGKILL)
            process.communicate(timeout=HANGING)
        assert set(whole_results(folder).values()) <= {wanted}, "half a result looks whole"
        process = start(folder)
        _, err = process.communicate(timeout=HANGING)
        assert process.returncode == 0, err
        assert "damaged" not in err
        assert set(whole_results(folder).values()) == {wanted}
    print(f"{kills} kills, {at_work} of them while the run was at work")
    return at_work
