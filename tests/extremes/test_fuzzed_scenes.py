"""Two thousand broken scenes: each gives one clear message, or is valid and runs to a finite answer. None hangs."""

from __future__ import annotations

import copy
import random
import signal
import time
from contextlib import contextmanager

import pytest
from scenes import mutated, shipped_tree, simulated, unexplained

from pipelines.io.errors import InputError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.scene.load_scene import LoadedScene, Source, validate
from pipelines.scene.merge import Merged
from pipelines.scene.scene import Scene

SECONDS = 10.0  # for one scene, refused or moved
SHORT = 0.004  # s of motion of those that are valid
PARTS, SCENES_PER_PART = 8, 260
OURS = ("fem.", "mbd.", "pipelines.")


class TooLongError(BaseException):
    """A scene is not done after its seconds; no `except Exception` of the product takes it for a failure of its own."""


@contextmanager
def limited(seconds: float):
    """Interrupt what takes longer."""

    def stop(*_):
        raise TooLongError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def outcome(tree, cache) -> str:
    """ "refused" or "moved"; anything else is an exception."""
    try:
        scene, merged = validate(Merged(tree), Scene, "fuzzed")
        checked_machine(scene, "fuzzed")
    except InputError as error:
        return said("refused", error)
    if scene.casing.model not in ("none", "rigid") or any(stage.mesh.model != "iso" for stage in scene.stages):
        return "valid"  # finite elements have extremes of their own
    step = scene.simulation.step_us * 1e-6
    sample = 1.0 / scene.simulation.output_rate_Hz
    end = min(scene.simulation.end_s, max(min(max(SHORT, 20 * step), 2000 * step), sample))
    short = scene.simulation.model_copy(update={"end_s": end})
    diagnosis = scene.diagnosis.model_copy(update={"windows_s": {}})
    scene = scene.model_copy(update={"simulation": short, "diagnosis": diagnosis})
    loaded = LoadedScene("fuzzed", Source("fuzzed", "", None, "fuzzed"), {}, merged, scene)
    try:
        trajectory = simulated(loaded, cache)
    except (ValueError, RuntimeError) as error:
        if not type(error).__module__.startswith(OURS):
            raise
        return said("refused while moving", error)
    assert [line for line in unexplained(trajectory) if "finite" in line] == []
    return "moved"


def said(kind: str, error: Exception) -> str:
    """The kind, if the error says something."""
    assert len(str(error)) > 20, f"{kind}: {error!r}"
    return kind


def fuzz(name: str, seed: int, count: int, cache) -> dict[str, int]:
    draw, base = random.Random(f"{name} {seed}"), shipped_tree(name)
    counts: dict[str, int] = {}
    outcome(copy.deepcopy(base), cache)  # compiles what is not yet on disk, which takes longer than a scene may
    for _ in range(count):
        tree, done = mutated(base, draw)
        begin = time.monotonic()
        try:
            with limited(SECONDS):
                kind = outcome(tree, cache)
        except TooLongError:
            raise AssertionError(f"not done after {SECONDS} s: {done}") from None
        except Exception as error:
            raise AssertionError(f"{done}: {type(error).__name__}: {error}") from error
        counts[kind] = counts.get(kind, 0) + 1
        assert time.monotonic() - begin < SECONDS + 1
    return counts


@pytest.mark.parametrize("name", ["minimal", "rig-missing-tooth"])
def test_a_broken_scene_is_refused_in_words(name, tmp_path):
    counts = fuzz(name, 0, 100, tmp_path)
    assert counts.get("refused", 0) > 30


@pytest.mark.slow
@pytest.mark.parametrize("part", range(1, PARTS + 1))
def test_thousands_of_broken_scenes(part, tmp_path):
    counts = fuzz("minimal" if part % 4 else "rig-missing-tooth", part, SCENES_PER_PART, tmp_path)
    print(f"part {part}: {sum(counts.values())} scenes: {counts}")
    assert sum(counts.values()) == SCENES_PER_PART
    assert counts.get("refused", 0) > SCENES_PER_PART // 4
