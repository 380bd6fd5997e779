"""Measures gearcase on the shipped scenes: python -m benchmarks [PART ...].

Every part runs in a process of its own, BLAS on one thread. Writes benchmarks/results/latest.json (each of the other
programs its own file beside it), docs/benchmarks.md and the measured tables of docs/choosing-a-model.md. Parts named
on the command line are measured again, the others are taken over from the last result; a part that needs what another
leaves behind measures that one, too.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks import page
from benchmarks.child import PARTS
from benchmarks.clock import conditions
from fem.processes.child import command, environment

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "latest.json"
NEEDS = {
    "factors": ("mesh",),
    "modes": ("mesh",),
    "static": ("mesh",),
    "loop": ("laws", "mesh", "modes"),
    "models": ("laws", "mesh", "modes", "static"),
    "precision": ("laws", "mesh", "modes"),
}
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
LIMIT = 900  # s for one part
PEERS: dict[str, tuple[str, ...]] = {  # other programs, with the arguments of their measurement
    "calculix_contact": ("--compare",),  # its own figures take hours: python -m benchmarks.peers.calculix_contact
    "modified_pairs": ("--compare",),  # half an hour
    "bridged_spalls": ("--compare",),
    "calculix_frequency": (),
    "exudyn_mesh": (),
    "scipy_mesh": (),
    "ross_stiffness": (),
    "floor": (),
}
PEER_LIMIT = 3600  # s for one of them
KNOWN = (*PARTS, *PEERS)


def main(arguments: list[str] | None = None) -> int:
    """Measure, write, and say on the screen how far it is; 1 if a part was skipped."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Measure gearcase on the shipped scenes.")
    parser.add_argument("part", nargs="*", help=f"all if none is given: {', '.join(KNOWN)}")
    chosen = parser.parse_args(arguments).part
    if unknown := [name for name in chosen if name not in KNOWN]:
        parser.error(f"unknown part {', '.join(unknown)}; known: {', '.join(KNOWN)}")
    wanted = set(chosen or KNOWN)
    wanted |= {need for name in tuple(wanted) for need in NEEDS.get(name, ())}
    old = json.loads(RESULTS.read_text(encoding="utf-8"))["parts"] if RESULTS.exists() else {}
    parts: dict[str, Any] = {}
    start = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="gearcase-benchmarks-") as folder:
        for name in PARTS:
            parts[name] = measured(name, Path(folder)) if name in wanted else old.get(name, {"skipped": "not measured"})
            if name in wanted:
                found = parts[name]
                print(f"{name}: {found.get('skipped') or round(found['part_seconds'], 1)}", flush=True)
    for name in PEERS:
        if name in wanted:
            print(f"{name}: {beside(name)}", flush=True)
    seconds = time.perf_counter() - start
    result = {"conditions": conditions(), "parts": parts}
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    page.write(result, ROOT / "docs")
    print(f"{seconds:.0f} s; see docs/benchmarks.md")
    return int(any("skipped" in parts[name] for name in wanted & PARTS.keys()))


def measured(name: str, folder: Path) -> dict[str, Any]:
    """The result of one part from its own process."""
    run, own = command("benchmarks.child", str(folder), name), environment(**dict.fromkeys(THREADS, "1"))
    try:
        done = subprocess.run(run, cwd=ROOT, env=own, stdout=subprocess.PIPE, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return {"skipped": f"not finished after {LIMIT} s"}
    lines = done.stdout.decode("utf-8").strip().splitlines()
    if done.returncode or not lines:
        return {"skipped": f"its process ended with code {done.returncode}"}
    return json.loads(lines[-1])


def beside(name: str) -> str:
    """Measure a peer, which writes its own result; what it said if it was skipped, else how long it took."""
    run, start = command(f"benchmarks.peers.{name}", *PEERS[name]), time.perf_counter()
    own = environment(**dict.fromkeys(THREADS, "1"))
    try:
        done = subprocess.run(
            run, cwd=ROOT, env=own, stdout=subprocess.PIPE, text=True, timeout=PEER_LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        return f"not finished after {PEER_LIMIT} s"
    if done.returncode:
        return next((line for line in done.stdout.splitlines() if "skipped" in line), f"ended with {done.returncode}")
    return f"{time.perf_counter() - start:.1f}"


if __name__ == "__main__":
    sys.exit(main())
