"""Faults of the machine under a run: afterwards the results equal those of an undisturbed run, bit for bit."""

from __future__ import annotations

import os
import random
import subprocess
import time
import warnings

import pytest
from machine import SHORT, bits, start, whole_results
from time_limit import HANGING

import gearcase

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="signals and limits as POSIX has them"),
]


@pytest.mark.parametrize("limit", [0, 3000, 40_000])
def test_a_full_disk_is_said_and_nothing_half_is_left(undisturbed, tmp_path, limit):
    process = start(tmp_path, limit=limit)
    _, err = process.communicate(timeout=HANGING)
    assert process.returncode == 1
    assert "Traceback" not in err
    assert "File too large" in err
    assert "space" in err
    assert whole_results(tmp_path) == {}
    process = start(tmp_path)
    _, err = process.communicate(timeout=HANGING)
    assert process.returncode == 0, err
    assert set(whole_results(tmp_path).values()) == {undisturbed[0]}


def test_two_runs_at_once_on_one_cache(undisturbed, tmp_path):
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        folder.mkdir()
    processes = [start(folder, cache=tmp_path / "cache") for folder in folders]
    for process, folder in zip(processes, folders, strict=True):
        _, err = process.communicate(timeout=HANGING)
        assert process.returncode == 0, err
        assert "damaged" not in err
        assert set(whole_results(folder).values()) == {undisturbed[0]}


@pytest.fixture
def runner(tmp_path, own_cache):
    """Run the same in this process; warnings about the cache are let through."""

    def go() -> str:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = gearcase.Scene.from_file("minimal").changed(SHORT)
            data = gearcase.run(scene, control=False, processes=1, out=tmp_path / f"out-{time.monotonic_ns()}")
        return bits(data)

    return go


def test_every_file_of_the_cache_cut_or_flipped_in_turn(undisturbed, own_cache, runner):
    assert runner() == undisturbed[0]
    draw, damaged = random.Random(1), 0
    for path in sorted(p.relative_to(own_cache) for p in (own_cache / "entries").rglob("*") if p.is_file()):
        for harm in ("cut", "flip"):
            content = bytearray((own_cache / path).read_bytes())
            if harm == "cut":
                content = content[: draw.randrange(len(content))] if content else content
            elif content:
                content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
            (own_cache / path).write_bytes(content)
            assert runner() == undisturbed[0], f"{path} after a {harm}"
            damaged += 1
    print(f"{damaged} damages of cache files")
    assert damaged >= 16


def test_a_clock_that_goes_back(undisturbed, own_cache, runner, monkeypatch):
    assert runner() == undisturbed[0]
    real = time.time
    for back in (3600.0, 400 * 86400.0):
        monkeypatch.setattr(time, "time", lambda back=back: real() - back)
        assert runner() == undisturbed[0]
    ahead = real() + 400 * 86400.0
    for path in own_cache.rglob("*"):
        os.utime(path, (ahead, ahead))
    monkeypatch.setattr(time, "time", real)
    assert runner() == undisturbed[0]


def test_a_cache_that_cannot_be_written_is_only_a_warning(undisturbed, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way", encoding="utf-8")
    process = start(tmp_path, cache=blocked / "cache")
    _, err = process.communicate(timeout=HANGING)
    assert process.returncode == 0, err
    assert "warning" in err
    assert set(whole_results(tmp_path).values()) == {undisturbed[0]}


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can mount a small or locked disk"
)
def test_a_small_and_a_read_only_disk_under_the_cache(undisturbed, tmp_path):
    place = tmp_path / "disk"
    place.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=96k", "tmpfs", str(place)], check=False).returncode:
        pytest.skip("tmpfs cannot be mounted here")
    try:
        for option in (None, "remount,ro"):
            if option:
                subprocess.run(["mount", "-o", option, str(place)], check=True)
            process = start(tmp_path, cache=place / "cache")
            _, err = process.communicate(timeout=HANGING)
            assert process.returncode == 0, err
            assert "warning" in err
        assert set(whole_results(tmp_path).values()) == {undisturbed[0]}
    finally:
        subprocess.run(["umount", str(place)], check=True)
