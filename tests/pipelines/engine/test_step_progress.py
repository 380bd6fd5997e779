"""How far a long step is: told from inside it, from another process too, and shown as the time left."""

import io
import time
from pathlib import Path

import pytest
from rich.console import Console
from rich.progress import Progress
from time_limit import HANGING

import gearcase
from fem.processes.executor import listening, tell_share
from pipelines.engine.build_step import Event
from pipelines.engine.cache import Cache
from pipelines.engine.progress import StepReporter, reported_count
from pipelines.engine.remaining import Remaining, Task
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph, Step
from pipelines.steps.machine_steps import machine_steps


def go_on(seconds):
    for quarter in range(1, 5):
        tell_share(quarter / 4)
        time.sleep(seconds / 4)
    return {"seconds": seconds}


def go_on_when_heard(folder):
    """Go on from each share once the listener has made the file that is named after it."""
    for quarter in range(1, 4):
        tell_share(quarter / 4)
        end = time.monotonic() + HANGING
        while not (Path(folder) / str(quarter / 4)).exists() and time.monotonic() < end:
            time.sleep(0.01)
    return {"heard": 3}


def graph(count, seconds):
    return Graph(
        Step(name=f"s{n}", kind="long", build=go_on, spec=seconds + n / 1000, seconds=9.0) for n in range(count)
    )


class Heard:
    def __init__(self):
        self.shares = {}

    def __call__(self, event):
        if event.share is not None:
            self.shares.setdefault(event.step.name, []).append(event.share)


def test_a_step_tells_its_share(tmp_path):
    heard = Heard()
    run_graph(graph(1, 0.0), Cache(tmp_path), ["s0"], on_event=heard)
    assert heard.shares == {"s0": [0.25, 0.5, 0.75, 1.0]}


class Answering(Heard):
    def __call__(self, event):
        super().__call__(event)
        if event.share is not None:
            (Path(event.step.spec) / str(event.share)).touch()


def test_steps_in_other_processes_tell_theirs(tmp_path):
    folders = {name: tmp_path / name for name in ("s0", "s1")}
    for folder in folders.values():
        folder.mkdir()
    steps = [
        Step(name=name, kind="long", build=go_on_when_heard, spec=str(folder), seconds=9.0)
        for name, folder in folders.items()
    ]
    heard = Answering()
    run_graph(Graph(steps), Cache(tmp_path / "cache"), list(folders), on_event=heard, processes=2)
    for shares in heard.shares.values():
        assert shares == [0.25, 0.5, 0.75]
    assert heard.shares.keys() == folders.keys()


def test_without_a_listener_nothing_happens():
    told = []
    with listening(told.append):
        tell_share(0.5)
    tell_share(0.75)
    assert told == [0.5]


def test_the_time_loop_tells_its_share(tmp_path):
    scene = gearcase.Scene.from_file("minimal").changed({"simulation.end_s": 0.5, "diagnosis.windows_s": {}})
    heard = Heard()
    run_graph(Graph(machine_steps(gearcase.check(scene).machine)), Cache(tmp_path), ["simulate"], on_event=heard)
    shares = heard.shares["simulate"]
    assert shares == sorted(shares)
    assert len(shares) > 1
    assert shares[-1] == 1.0


def test_the_time_left_follows_from_the_pace_since_the_first_share():
    remaining = Remaining([Task(name="s0", takes=(), seconds=9.0)], 1)
    remaining.advanced("s0", 0.1, 100.0)
    assert remaining.pace("s0") is None  # what came before, compiling say, is not repeated
    remaining.advanced("s0", 0.3, 104.0)
    assert remaining.pace("s0") == pytest.approx(14.0)
    remaining.advanced("s0", 1.0, 118.0)
    assert remaining.pace("s0") == 0.0


def test_the_bar_shows_the_share_and_the_time_left():
    console = Console(file=io.StringIO(), force_terminal=True, width=120)
    with Progress(console=console) as progress:
        remaining, (step,) = Remaining([Task(name="s0", takes=(), seconds=9.0)], 1), graph(1, 0.0)
        now = [0.0]
        report = StepReporter(remaining, bar=progress, clock=lambda: now[0])
        report(Event(step))
        now[0] = 10.0
        report(Event(step, 0.25))
        assert progress.tasks[0].description == "s0 25 %"
        now[0] = 12.0
        report(Event(step, 0.5))
        assert progress.tasks[0].description == "s0 50 %, 4 s left"


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_count_is_a_bar_at_a_terminal_with_lines_above_it(monkeypatch):
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setattr("sys.stderr", terminal := Terminal())
    with reported_count("scenes", quiet=False) as report:
        report(1, 4)
        time.sleep(0.3)  # the bar is drawn ten times a second
        report.line("scene 2 failed: no oil")
        report(2, 4, 1)
    assert "1/4" in terminal.getvalue()
    assert "2/4" in terminal.getvalue()
    assert "scene 2 failed: no oil" in terminal.getvalue()
    assert "scenes, 1 failed" in terminal.getvalue()
    assert " left" in terminal.getvalue()


@pytest.mark.parametrize("quiet", [False, True])
def test_a_count_is_lines_in_a_pipe_and_nothing_if_quiet(quiet, monkeypatch):
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("sys.stderr", pipe := io.StringIO())
    with reported_count("runs", quiet=quiet) as report:
        report.line("4 runs")
        now[0] = 110.0
        report(1, 4)  # not again so soon
        now[0] = 140.0
        report(2, 4)
    assert pipe.getvalue() == ("" if quiet else "4 runs\n2 of 4 runs, about 40 s left\n")
