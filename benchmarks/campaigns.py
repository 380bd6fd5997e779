"""Part `campaign`: scenes per hour of a campaign beside those of the bare time loop, on all cores.

The bare loop (`benchmarks.bare_loop`) is the motion of the plan's first scene again and again in as many processes as
there are cores: from equilibrium to trajectory, with nothing read, checked, assembled or written. It is measured before
and after the campaign, because the speed of a machine drifts. A campaign is timed from when every process has done two
scenes, so that its start (processes, libraries, laws) does not count.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from fem.processes.child import command, environment

ROOT = Path(__file__).resolve().parent.parent
SCENES = {"bench": (48, 2.0, ""), "rig-missing-tooth": (14, 5.0, 'preset = "standard"\n')}
PLAN = """scene = "{scene}"
scenes = {count}
{preset}
[variables]
speed_rpm = {{ from = 600.0, to = 900.0 }}
specimen = {{ from = 1, to = 1000 }}
[settings]
simulation.end_s = {end}
drive.times_s = [0.0, 0.5, {end}]
drive.speeds_rpm = [0.0, "$speed_rpm", "$speed_rpm"]
deviations.enabled = true
deviations.seed = "$specimen"
"""


def campaign(folder: Path) -> list[dict[str, Any]]:
    """Scenes per hour of campaigns and of the bare loop."""
    return [_measured(folder, name, *given) for name, given in SCENES.items()]


def _measured(folder: Path, name: str, count: int, end: float, preset: str) -> dict[str, Any]:
    path, out = folder / f"{name}-plan.toml", folder / f"{name}-campaign"
    path.write_text(PLAN.format(scene=name, count=count, end=end, preset=preset), encoding="utf-8")
    cores = os.cpu_count() or 1
    before = bare(path, max(2, count // cores // 2))
    gearcase = [sys.executable, "-m", "pipelines.cli.main", "campaign", str(path), "--out", str(out), "-q"]
    done = subprocess.run(gearcase, cwd=ROOT, env=environment(), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"gearcase campaign ended with {done.returncode}: {done.stderr}")
    after = bare(path, max(2, count // cores // 2))
    ends = sorted(row.stat().st_mtime for row in (out / "rows").iterdir())
    first = 2 * cores
    steady = 3600.0 * (count - first) / (ends[-1] - ends[first - 1])
    files = [file for file in out.rglob("*") if file.is_file()]
    return {
        "scene": name,
        "scenes": count,
        "motion_s": end,
        "processes": cores,
        "per_hour": steady,
        "loop_before": before,
        "loop_after": after,
        "share": 2.0 * steady / (before + after),
        "megabytes_per_scene": sum(file.stat().st_size for file in files) / count / 1e6,
    }


def bare(path: Path, repeats: int) -> float:
    """Motions per hour of the first scene of a plan, `repeats` in each process, the slowest process counting."""
    run = command("benchmarks.bare_loop", str(path), str(repeats))
    processes = [
        subprocess.Popen(run, cwd=ROOT, env=environment(), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for _ in range(os.cpu_count() or 1)
    ]
    for process in processes:
        assert process.stdout is not None
        if process.stdout.readline() != "ready\n":
            raise RuntimeError("a bare loop ended before it began")
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    seconds = [float(process.communicate()[0]) for process in processes]
    return 3600.0 * len(processes) * repeats / max(seconds)
