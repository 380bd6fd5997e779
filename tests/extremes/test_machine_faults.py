"""Faults of the machine under a run: afterwards the results equal those of an undisturbed run, bit for bit."""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import pytest
import xarray

from pipelines.payload import digest
from pipelines.results import CONTROL, RESPONSE
from pipelines.runs import run

SHORT = {"simulation.end_s": 0.05, "diagnosis.windows_s": {}}
ARGUMENTS = [part for name, value in SHORT.items() for part in ("--set", f"{name}={value}")]
KILLS, KILLS_PER_CACHE = 100, 10
PROVENANCE = ("provenance", "stages", "build_ledger", "folder")

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and limits as POSIX has them")


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
    command = [sys.executable, "-m", "pipelines.cli", "run", "minimal", "--no-control", *ARGUMENTS]
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


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> tuple[str, float]:
    """Digest of an undisturbed run, and its seconds once the compiled code is stored."""
    seconds, found = 0.0, set()
    for _ in range(2):
        folder = tmp_path_factory.mktemp("undisturbed")
        begin = time.perf_counter()
        process = start(folder)
        _, err = process.communicate()
        assert process.returncode == 0, err
        seconds = time.perf_counter() - begin
        found |= set(whole_results(folder).values())
    assert len(found) == 1
    return found.pop(), seconds


@pytest.mark.slow
def test_kill_9_at_a_hundred_moments(undisturbed, tmp_path):
    wanted, seconds = undisturbed
    draw = random.Random(9)
    kills = half_done = 0
    for _ in range(KILLS // KILLS_PER_CACHE):
        shutil.rmtree(tmp_path / "cache", ignore_errors=True)
        for moment in sorted(draw.uniform(0.02, 1.0) * seconds for _ in range(KILLS_PER_CACHE)):
            process = start(tmp_path)
            time.sleep(moment)
            half_done += process.poll() is None
            process.send_signal(signal.SIGKILL)
            process.communicate(timeout=60)
            kills += 1
        assert set(whole_results(tmp_path).values()) <= {wanted}, "half a result looks whole"
        process = start(tmp_path)
        _, err = process.communicate(timeout=120)
        assert process.returncode == 0, err
        assert "damaged" not in err
        assert set(whole_results(tmp_path).values()) == {wanted}
    print(f"{kills} kills, {half_done} of them while the run was at work")
    assert kills == KILLS
    assert half_done > KILLS // 2


@pytest.mark.parametrize("limit", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in (3000, 40_000))])
def test_a_full_disk_is_said_and_nothing_half_is_left(undisturbed, tmp_path, limit):
    process = start(tmp_path, limit=limit)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 1
    assert "Traceback" not in err
    assert "File too large" in err
    assert "space" in err
    assert whole_results(tmp_path) == {}
    process = start(tmp_path)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert set(whole_results(tmp_path).values()) == {undisturbed[0]}


@pytest.mark.slow
def test_two_runs_at_once_on_one_cache(undisturbed, tmp_path):
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        folder.mkdir()
    processes = [start(folder, cache=tmp_path / "cache") for folder in folders]
    for process, folder in zip(processes, folders, strict=True):
        _, err = process.communicate(timeout=240)
        assert process.returncode == 0, err
        assert "damaged" not in err
        assert set(whole_results(folder).values()) == {undisturbed[0]}


@pytest.fixture
def runner(tmp_path, own_cache):
    """Run the same in this process; warnings about the cache are let through."""

    def go() -> str:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            data = run("minimal", SHORT, control=False, processes=1, out=tmp_path / f"out-{time.monotonic_ns()}")
        return bits(data)

    return go


@pytest.mark.slow
def test_every_file_of_the_cache_cut_or_flipped_in_turn(undisturbed, own_cache, runner):
    assert runner() == undisturbed[0]
    draw, damaged = random.Random(1), 0
    for path in sorted(p.relative_to(own_cache) for p in own_cache.rglob("*") if p.is_file()):
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
    _, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert "warning" in err
    assert set(whole_results(tmp_path).values()) == {undisturbed[0]}


@pytest.mark.slow
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
            _, err = process.communicate(timeout=120)
            assert process.returncode == 0, err
            assert "warning" in err
        assert set(whole_results(tmp_path).values()) == {undisturbed[0]}
    finally:
        subprocess.run(["umount", str(place)], check=True)
