"""Two thousand hostile commands, in this process: exit code 0 or 2, a short printable answer, within 10 s."""

from __future__ import annotations

import os
import random
import time

import pytest
from hostile import hostile_command, unusable_command
from test_fuzzed_scenes import SECONDS, TooLongError, limited

from pipelines.cli.main import main

PARTS, COMMANDS_PER_PART = 8, 250
MOVED = 100  # usable scenes that are simulated
pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes, devices and timers of a POSIX system")


def answer(capsys, arguments, done) -> int:
    """The exit code of a command after the test of what it says."""
    try:
        with limited(SECONDS):
            code = main(arguments)
    except SystemExit as end:
        code = end.code
    except TooLongError:
        raise AssertionError(f"no answer within {SECONDS} s: {done}") from None
    out, err = capsys.readouterr()
    assert code in (0, 2), f"{done}: exit code {code}: {err[:2000]}"
    assert "should not happen" not in err, f"{done}: {err[:2000]}"
    assert all(c in "\n" or c.isprintable() or ord(c) > 0xA0 for c in out + err), f"{done}: {err[:2000]!r}"
    if code == 2:
        assert out == "", done
        assert 20 < len(err) < 20_000, f"{done}: {err[:2000]}"
        assert len(err.splitlines()) <= 20, f"{done}: {err[:2000]}"
    return code


def fuzz(capsys, folder, seed, count) -> tuple[list[int], float]:
    """The exit codes of drawn commands, and the seconds of the slowest."""
    draw, codes, slowest = random.Random(f"commands {seed}"), [], 0.0
    with limited(600):
        main(["check", "rig-step"])  # compiles what is not yet on disk
    capsys.readouterr()
    for _ in range(count):
        arguments, done = hostile_command(draw, folder)
        start = time.monotonic()
        codes.append(answer(capsys, arguments, done))
        slowest = max(slowest, time.monotonic() - start)
    return codes, slowest


@pytest.mark.slow
def test_a_hostile_command_is_answered_in_words(capsys, tmp_path):
    codes, _ = fuzz(capsys, tmp_path, 0, 120)
    assert codes.count(2) > 60


@pytest.mark.slow
@pytest.mark.parametrize("part", range(1, PARTS + 1))
def test_thousands_of_hostile_commands(capsys, part, tmp_path):
    codes, slowest = fuzz(capsys, tmp_path, part, COMMANDS_PER_PART)
    with capsys.disabled():
        print(f"part {part}: {codes.count(0)} accepted, {codes.count(2)} refused, slowest {slowest:.2f} s")
    assert codes.count(2) > COMMANDS_PER_PART // 2


@pytest.mark.slow
def test_what_check_accepts_is_simulated_or_refused(capsys, tmp_path, monkeypatch):
    """Values that look right one by one: where check says yes, the run must not fail; it may take long."""
    monkeypatch.chdir(tmp_path)
    draw, failed, moved, long = random.Random("unusable"), [], 0, 0
    while moved < MOVED:
        arguments, done = unusable_command(draw, tmp_path)
        if answer(capsys, arguments, done) == 2:
            continue
        moved += 1
        try:
            with limited(20):
                code = main(["simulate", *arguments[1:], "--quiet", "--processes", "1", "--out", f"run-{moved}"])
        except TooLongError:
            code, long = 0, long + 1
        err = capsys.readouterr().err
        if code not in (0, 2):
            failed.append(f"{done}: {err[:300]}")
    assert failed == []
    assert long < MOVED // 4
