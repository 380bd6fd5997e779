"""The bare time loop of the first scene of a plan: python -m benchmarks.bare_loop PLAN REPEATS.

Says "ready" when the machine is assembled and the loop compiled, waits for a line, and prints the seconds.
"""

from __future__ import annotations

import sys
import time

from pipelines.datasets.campaign_scenes import sampled_scenes, scene_of
from pipelines.datasets.plan import load_plan
from pipelines.datasets.worker_cache import WorkerCache
from pipelines.engine.build_step import one_thread
from pipelines.engine.run_graph import Work
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.steps.motion import moved


def main() -> None:
    """Assemble, wait, move."""
    plan = load_plan(sys.argv[1])
    machine = checked_machine(scene_of(plan, sampled_scenes(plan)[0].values).scene, "scene")
    with one_thread():
        system = WorkerCache(Work().cache).system(machine)
        moved(system, machine.motion)
        print("ready", flush=True)
        sys.stdin.readline()
        start = time.perf_counter()
        for _ in range(int(sys.argv[2])):
            moved(system, machine.motion)
        print(time.perf_counter() - start, flush=True)


if __name__ == "__main__":
    main()
