"""The time that a run still takes: a simulated schedule, learned from stored results, told in plain lines."""

import argparse
import os
import subprocess
import sys

import pytest

from pipelines.cli import run
from pipelines.cli.main import main
from pipelines.engine.build_step import Event, Result
from pipelines.engine.cache import Cache
from pipelines.engine.progress import StepReporter, step_words
from pipelines.engine.remaining import Remaining, Task, expected
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph, Step, StepRecord
from pipelines.io.shown_text import duration
from pipelines.report.figures import render

SCHEDULE = (  # two processes: casing 10 beside laws 2 + 2, then motions 6 beside 6, then the report 3
    Task(name="law_1", takes=(), seconds=2.0, kind="law"),
    Task(name="law_2", takes=(), seconds=2.0, kind="law"),
    Task(name="casing", takes=(), seconds=10.0, kind="casing"),
    Task(name="faulty", takes=("casing", "law_1", "law_2"), seconds=6.0, kind="motion"),
    Task(name="healthy", takes=("casing", "law_1", "law_2"), seconds=6.0, kind="motion"),
    Task(name="report", takes=("faulty", "healthy"), seconds=3.0, kind="report"),
)


def made(spec):
    return {"made": spec}


def record(name, seconds, reused=False):
    facts = {"content": "", "seconds": seconds, "peak_bytes": 0, "ledger": {}, "libraries": {}}
    return StepRecord(name=name, kind=name, key="", reused=reused, **facts)


def test_the_longest_chain_starts_first_and_independent_tasks_run_side_by_side():
    assert Remaining(SCHEDULE, 2).left(0.0) == pytest.approx(10 + 6 + 3)
    assert Remaining(SCHEDULE, 1).left(0.0) == pytest.approx(10 + 4 + 12 + 3)


def test_a_task_at_work_counts_what_it_has_taken():
    remaining = Remaining(SCHEDULE, 2)
    remaining.started("casing", 100.0)
    assert remaining.left(104.0) == pytest.approx(6 + 6 + 3)
    assert remaining.left(120.0) == pytest.approx(0.2 * 20 + 6 + 3)  # overdue


def test_a_slower_machine_lengthens_the_rest():
    remaining = Remaining(SCHEDULE, 2)
    for name in ("law_1", "law_2"):
        remaining.started(name, 0.0)
        remaining.finished(name, 4.0)
    scale = (10 + 8) / (10 + 4)
    assert remaining.left(4.0) == pytest.approx(scale * (10 + 6 + 3))


def test_a_finished_task_tells_more_of_its_kind():
    remaining = Remaining(SCHEDULE, 1)
    remaining.started("law_1", 0.0)
    remaining.finished("law_1", 8.0)
    others = (10 + 3 * 2) / (10 + 2)  # no more than three times its expected time counts for them
    assert remaining.left(8.0) == pytest.approx(8 + others * (10 + 12 + 3))


def test_a_reused_task_says_nothing_about_the_machine():
    remaining = Remaining(SCHEDULE, 2)
    remaining.finished("casing", 50.0)
    assert remaining.left(50.0) == pytest.approx(4 / 2 + 6 + 3)
    assert remaining.count == 5


def test_compiling_comes_before_what_runs_the_code_and_goes_on_beside_other_work():
    code = Task(name="code", takes=("law",), seconds=8.0, compiles=True)
    tasks = [
        Task(name="law", takes=(), seconds=1.0, kind="law"),
        code,
        Task(name="casing", takes=(), seconds=6.0, kind="casing"),
        Task(name="motion", takes=("law", "casing", "code"), seconds=5.0, kind="motion"),
    ]
    remaining = Remaining(tasks, 2)
    assert remaining.count == 3
    assert remaining.left(0.0) == pytest.approx(1 + 8 + 5)
    remaining.started("casing", 0.0)
    remaining.started("law", 0.0)
    remaining.finished("law", 1.0)  # the compiler begins
    remaining.finished("casing", 6.0)
    remaining.started("motion", 6.0)
    assert remaining.left(6.0) == pytest.approx(8 - 5 + 5)
    remaining.advanced("motion", 0.0, 7.0)  # it moves, so all is compiled
    assert remaining.left(7.0) == pytest.approx(5 - 1)
    remaining.advanced("motion", 0.25, 8.0)
    assert remaining.left(9.0) == pytest.approx(3 - 1)  # its own pace


def test_stored_results_of_a_kind_tell_how_long_one_takes(tmp_path):
    cache = Cache(tmp_path)

    def one(number, seconds):
        return Step(name="a", kind="made", build=made, spec=number, seconds=seconds)

    assert [task.seconds for task in expected([one(1, 4.0)], cache)] == [4.0]
    run_graph(Graph([one(1, 4.0)]), cache, ["a"])
    assert expected([one(1, 4.0)], cache) == []
    (entry,) = cache.entries("made")
    (task,) = expected([one(2, 8.0)], cache)
    assert task.seconds == pytest.approx(8.0 * entry.facts["seconds"] / 4.0)


def test_code_that_is_not_compiled_is_a_task(tmp_path):
    step = Step(name="a", kind="made", build=made, spec=1, seconds=2.0, compiles={"some.loop.": 7.0})
    code, task = expected([step], Cache(tmp_path))
    assert (code.seconds, code.compiles, task.takes) == (7.0, True, (code.name,))


def test_lines_for_a_pipe():
    now, written = [100.0], []
    remaining = Remaining(SCHEDULE, 2)
    report = StepReporter(remaining, write=written.append, clock=lambda: now[0])
    steps = {task.name: Step(name=task.name, kind=task.name, build=made, seconds=task.seconds) for task in SCHEDULE}
    report(Event(steps["casing"]))
    report(Event(steps["law_1"]))
    now[0] = 102.0
    report(Event(steps["law_1"], result=Result(record("law_1", 2.0), None)))
    report(Event(steps["law_2"], result=Result(record("law_2", 2.0, reused=True), None)))
    report(Event(steps["casing"], 0.2))  # not again so soon
    now[0] = 113.0
    report(Event(steps["casing"], 0.9))
    assert "".join(written).splitlines() == [
        "6 steps to compute, about 19 s",
        "   0 s  casing: started; about 19 s left",
        "   2 s  mesh law of stage 1: 2.0 s; about 17 s left",
        "  13 s  casing: 90 %; about 11 s left",
    ]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("simulate", "motion of the machine"),
        ("features healthy simulate", "features of the healthy machine"),
        ("torque healthy simulate", "motion of the healthy machine (load as a torque)"),
        ("torque seed 3 simulate", "motion of the machine (load as a torque, deviations of seed 3)"),
        ("features healthy seed 12 simulate", "features of the healthy machine (deviations of seed 12)"),
        ("error-free healthy simulate", "motion of the healthy machine (no deviations)"),
        ("casing modes", "casing modes"),
        ("law_2", "mesh law of stage 2"),
        ("unmodified_law_1", "mesh law of stage 1 without faults and modifications"),
        ("diagnose", "diagnosis"),
        ("preset: reference: simulate", "preset: reference: motion of the machine"),
    ],
)
def test_motions_and_their_features_are_named_in_words(name, words):
    assert step_words(name) == words


def test_lengths_of_time_in_words():
    assert [duration(s) for s in (0, 0.2, 40.4, 150, 9000)] == ["0 s", "1 s", "40 s", "2 minutes", "2.5 hours"]


def test_in_a_pipe_a_run_writes_no_control_characters(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "pipelines.cli.main", "run", "minimal", "--set", "simulation.end_s=0.06",
         "--set", "diagnosis.windows_s={}", "--out", str(tmp_path / "out")],
        capture_output=True, check=False, env={**os.environ, "FORCE_COLOR": "", "TERM": "xterm-256color"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode()
    for stream in (done.stdout, done.stderr):
        assert not [byte for byte in stream if byte < 0x20 and byte != 0x0A]
    first, second, *lines = done.stderr.decode().splitlines()
    assert first == "gearcase run minimal"
    assert "to compute, about " in second
    assert any(" motion of the machine: " in line for line in lines)
    said = done.stdout.decode().splitlines()
    assert f"report: {tmp_path / 'out' / 'report.html'}" in said
    assert said[said.index("next:") + 1].strip() == f"gearcase runs open {tmp_path / 'out'}"
    assert said[said.index("next:") + 3].strip() == "gearcase new my.toml --from minimal"


def test_a_quiet_run_writes_nothing_to_standard_error(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-S", "-c", "pass"])  # see test_report_contents
    settings = ("--set", "simulation.end_s=0.07", "--set", "diagnosis.windows_s={}")
    assert main(["run", "minimal", "-q", *settings, "--out", str(tmp_path / "out")]) == 0
    assert capfd.readouterr().err == ""


def test_the_next_commands_name_the_program_as_it_was_typed_where_path_does_not_hold_it(monkeypatch):
    monkeypatch.setattr(sys, "argv", [".venv/bin/gearcase", "run", "minimal"])
    monkeypatch.setenv("PATH", os.devnull)
    (command, _), _ = run._next(argparse.Namespace(scene="minimal", out=None))
    assert command == ".venv/bin/gearcase runs open minimal"
