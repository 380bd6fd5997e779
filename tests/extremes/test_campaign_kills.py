"""Campaigns that are killed, or find no room: gone on with, they hold what an undisturbed one holds, bit for bit."""

import json
import os
import random
import signal
import subprocess
import sys
import time

import psutil
import pytest

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")]

MOMENTS = 10
PATIENCE = 300.0  # seconds after which something hangs
PLAN = """
scene = "minimal"
scenes = 8
[variables]
speed = { from = 600.0, to = 900.0 }
specimen = { from = 1, to = 50 }
[settings]
simulation.end_s = 0.2
drive.times_s = [0.0, 0.1, 0.2]
drive.speeds_rpm = [0.0, "$speed", "$speed"]
deviations.enabled = true
deviations.seed = "$specimen"
"""


def program(module, *arguments, cwd):
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(sys.path),
        "DASK_DISTRIBUTED__DIAGNOSTICS__NVML": "False",
    }
    command = [sys.executable, "-m", module, *arguments]
    return subprocess.Popen(
        command, cwd=cwd, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def start(folder, *more, out="out"):
    (folder / "plan.toml").write_text(PLAN, encoding="utf-8")
    return program(
        "pipelines.cli.main", "campaign", "plan.toml", "--out", str(out), "--processes", "2", *more, cwd=folder
    )


def finish(process):
    said, _ = process.communicate(timeout=PATIENCE)
    return process.returncode, said


def content(folder):
    """Everything of a data set that must be the same, and nothing else may lie there."""
    files = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if not path.is_file() or name in (".lock", "campaign.json", "README.md", "rows.parquet"):
            continue
        files[name] = path.read_bytes()
        if name.startswith("rows/"):
            row = json.loads(files[name])
            files[name] = json.dumps({key: value for key, value in row.items() if not key.endswith("seconds")})
    return files


def table(folder):
    import pyarrow.parquet as pq

    rows = pq.read_table(folder / "rows.parquet").to_pylist()
    return [{name: value for name, value in row.items() if not name.endswith("seconds")} for row in rows]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    code, said = finish(start(folder))
    assert code == 0, said
    begin = time.monotonic()
    code, said = finish(start(folder, out="again"))
    assert code == 0, said
    assert content(folder / "out") == content(folder / "again")
    return folder / "out", time.monotonic() - begin


def same(folder, undisturbed):
    return content(folder) == content(undisturbed[0]) and table(folder) == table(undisturbed[0])


def wait_until(condition, process=None):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it hangs"
        if process is not None and process.poll() is not None:
            return False
        time.sleep(0.02)
    return True


def moments(undisturbed, seed):
    draw = random.Random(seed)
    return [draw.uniform(0.1, 1.0) * undisturbed[1] for _ in range(MOMENTS)]


def test_a_killed_worker_costs_nothing(undisturbed, tmp_path):
    for number, moment in enumerate(moments(undisturbed, 1)):
        out = tmp_path / str(number)
        process = start(tmp_path, out=out)
        time.sleep(moment)
        children = psutil.Process(process.pid).children() if process.poll() is None else []
        workers = [child for child in children if "spawn_main" in " ".join(child.cmdline())]
        if workers:
            random.Random(number).choice(workers).send_signal(signal.SIGKILL)
        code, said = finish(process)
        assert code == 0, said
        assert same(out, undisturbed), said


def test_a_killed_command_takes_its_workers_along_and_is_gone_on_with(undisturbed, tmp_path):
    for number, moment in enumerate(moments(undisturbed, 2)):
        out = tmp_path / str(number)
        process = start(tmp_path, out=out)
        time.sleep(moment)
        children = psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []
        process.kill()
        process.communicate()
        assert wait_until(lambda children=children: not any(child.is_running() for child in children))
        code, said = finish(start(tmp_path, out=out))
        assert code == 0, said
        assert same(out, undisturbed), said


def scheduler(folder):
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    process = program(
        "distributed.cli.dask_scheduler",
        *("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)),
        cwd=folder,
    )
    wait_until(file.is_file)
    return process, file


def worker(folder, file):
    return program(
        "distributed.cli.dask_worker",
        *("--scheduler-file", str(file), "--nthreads", "1", "--no-dashboard", "--local-directory", str(folder)),
        *("--death-timeout", "60"),
        cwd=folder,
    )


def end(*processes):
    for process in processes:
        children = psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []
        for one in (process, *children):
            one.kill()
        process.wait()
        process.stdout.close()


def test_workers_of_a_scheduler_may_come_and_go(undisturbed, tmp_path):
    board, file = scheduler(tmp_path)
    first = worker(tmp_path, file)
    second = None
    try:
        process = start(tmp_path, "--scheduler", str(file))
        rows = tmp_path / "out" / "rows"
        wait_until(lambda: rows.is_dir() and any(rows.glob("*.json")), process)
        second = worker(tmp_path, file)  # comes late
        wait_until(lambda: len(list(rows.glob("*.json"))) >= 3, process)
        first.terminate()  # leaves
        code, said = finish(process)
        assert code == 0, said
        assert same(tmp_path / "out", undisturbed), said
    finally:
        end(board, first, *([second] if second else []))


def test_a_killed_scheduler_is_said_and_another_one_goes_on(undisturbed, tmp_path):
    for number, moment in enumerate(moments(undisturbed, 3)):
        out = tmp_path / str(number)
        board, file = scheduler(tmp_path)
        hands = [worker(tmp_path, file) for _ in range(2)]
        try:
            process = start(tmp_path, "--scheduler", str(file), out=out)
            time.sleep(moment)
            end(board)
            code, said = finish(process)
            assert code == 0 or "repeat the command" in said or "no scheduler answers" in said, said
        finally:
            end(board, *hands)
        code, said = finish(start(tmp_path, out=out))
        assert code == 0, said
        assert same(out, undisturbed), said


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can mount a small disk")
def test_a_full_disk_is_said_and_with_more_room_it_goes_on(undisturbed, tmp_path):
    needed = sum(len(value) for value in content(undisturbed[0]).values())
    stopped = 0
    for number in range(MOMENTS):
        place = tmp_path / str(number)
        place.mkdir()
        size = int(needed * (0.3 + 0.1 * number))
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(place)], check=False).returncode:
            pytest.skip("tmpfs cannot be mounted here")
        try:
            code, said = finish(start(tmp_path, out=place / "out"))
            stopped += code == 1
            assert code == 0 or ("No space left" in said and "repeat the command" in said), said
            subprocess.run(["mount", "-o", "remount,size=100m", str(place)], check=True)
            code, said = finish(start(tmp_path, out=place / "out"))
            assert code == 0, said
            assert same(place / "out", undisturbed), said
        finally:
            subprocess.run(["umount", str(place)], check=True)
    assert stopped > MOMENTS // 2
