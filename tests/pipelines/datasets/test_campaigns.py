"""Campaigns: every scene once, with true labels and the same bits however and wherever it is simulated."""

import contextlib
import errno
import json
import re
import shutil

import numpy as np
import pytest
from serial_executor import InOrder

import pipelines.datasets.job as job_module
from pipelines.datasets.campaign import run_campaign
from pipelines.datasets.campaign_scenes import sampled_scenes, scene_of
from pipelines.datasets.estimate import estimate
from pipelines.datasets.folder import find_begun, held, identity_facts
from pipelines.datasets.job import Job, work
from pipelines.datasets.labels import labels
from pipelines.datasets.plan import load_plan
from pipelines.datasets.rows import numbers, read_row, read_rows, row_path, write_row
from pipelines.datasets.store import SIGNALS, read_run
from pipelines.datasets.workers import Workers
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph
from pipelines.io.errors import InputError, SceneError, WorkError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.machine_conversion import make_machine
from pipelines.signals.response import make_response
from pipelines.steps.machine_steps import machine_steps
from pipelines.steps.motion import moved

PLAN = """
scene = "minimal"
scenes = 6
[variables]
speed = { from = 600.0, to = 900.0 }
specimen = { from = 1, to = 50 }
state = ["healthy", "missing", "worn"]
tooth = { from = 0, to = 9 }
depth = { from = 5.0, to = 20.0 }
[settings]
simulation.end_s = 0.02
drive.times_s = [0.0, 0.01, 0.02]
drive.speeds_rpm = [0.0, "$speed", "$speed"]
deviations.enabled = true
deviations.seed = "$specimen"
[cases.state.healthy]
faults = []
[cases.state.missing]
faults = [{ kind = "missing-tooth", stage = 1, gear = "wheel", tooth = "$tooth" }]
[cases.state.worn]
faults = [{ kind = "worn-tooth", stage = 1, gear = "pinion", tooth = "$tooth", depth_um = "$depth" }]
"""
SIGNALS_STORED = ("acceleration", "shaft_angle", "motor_speed", "motor_torque")


class Elsewhere(InOrder):
    """Does it as a machine does that does not see the folder of the campaign."""

    def submit(self, function, job, /):
        away = Job(
            plan=job.plan, layout=job.layout, folder=job.folder / "away", identity=job.identity, sample=job.sample
        )
        return super().submit(function, away)


@contextlib.contextmanager
def hands(executor=InOrder, count=1):
    yield Workers(executor=executor(), count=lambda: count)


def load(folder, text=PLAN, name="plan"):
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return load_plan(path)


def run(folder, text=PLAN, out="out", executor=InOrder, **options):
    return run_campaign(load(folder, text), folder / out, hands(executor), Work(), **options)


def content(folder):
    """Everything in a data set that must not depend on how it came about."""
    rows = [{k: v for k, v in row.items() if not k.endswith("seconds")} for row in read_rows(folder)]
    arrays = {name: [read_run(folder, row["run"], name).tobytes() for row in rows] for name in SIGNALS_STORED}
    files = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())
    return rows, arrays, files


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A campaign that nobody disturbed."""
    folder = tmp_path_factory.mktemp("whole")
    finished = run(folder)
    assert (finished.runs, finished.simulated, finished.failed) == (6, 6, 0)
    return folder / "out"


def test_signals_are_those_of_the_scene_run_alone(whole, tmp_path):
    plan = load(tmp_path)
    for one in sampled_scenes(plan)[:2]:
        loaded = scene_of(plan, one.values)
        machine = checked_machine(loaded.scene, "scene")
        outcome = Work().build(Graph(machine_steps(machine)), ["simulate"])
        response = make_response(outcome.value("simulate"), machine.labels)
        for name in SIGNALS_STORED:
            alone = np.moveaxis(response[name].to_numpy(), 0, -1)
            assert np.array_equal(read_run(whole, one.run, name), alone), name


def test_labels_are_those_of_the_scene(whole, tmp_path):
    plan = load(tmp_path)
    kinds = {"healthy": "healthy", "missing": "missing-tooth", "worn": "worn-tooth"}
    for one in sampled_scenes(plan):
        row, scene = read_row(whole, one.run), scene_of(plan, one.values).scene
        assert row["values"] == one.values
        assert row["labels"] == labels(make_machine(scene))
        assert row["labels"]["label"] == kinds[one.values["state"]]
        assert row["labels"]["severity"] == one.values["depth"]  # None where nothing is worn
        faults = json.loads(row["labels"]["faults"])
        assert [fault["tooth"] for fault in faults] == ([] if one.values["tooth"] is None else [one.values["tooth"]])


SHAFT_FAULTS = {
    "unbalance": "shaft = 1, position_mm = 0.0, unbalance_g_mm = '$size'",
    "bent-shaft": "shaft = 2, position_mm = 0.0, bow_um = '$size', straight_at_mm = [-30.0, 30.0]",
}


@pytest.mark.parametrize("kind", SHAFT_FAULTS)
def test_faults_of_shafts_are_labelled_with_their_size(tmp_path, kind):
    force = f"forces = [{{ model = '{kind}', {SHAFT_FAULTS[kind]} }}]"
    varied = "[variables]\nsize = { from = 5.0, to = 50.0 }"
    plan = load(tmp_path, f'scene = "minimal"\nscenes = 3\n{varied}\n[settings]\n{force}\n')
    for one in sampled_scenes(plan):
        found = labels(make_machine(scene_of(plan, one.values).scene))
        assert (found["label"], found["severity"]) == (kind, one.values["size"])
        assert "shaft" in found["places"]


def test_the_estimate_names_the_scenes_without_load(tmp_path):
    varied = "[variables]\nmass = [0.0, 50.0]"
    text = f'scene = "minimal"\ndesign = "grid"\n{varied}\n[settings]\nload.container_kg = "$mass"\n'
    plan = load(tmp_path, text)
    found = estimate(plan, sampled_scenes(plan)).text
    assert re.search("doubtful +1; the first: load.* without load the teeth lose contact", found)


@pytest.mark.parametrize(
    ("fault", "key"),
    [
        ("kind = 'spalled-tooth', height_mm = '$size', length_mm = 5.0, depth_um = 200.0", "height_mm"),
        ("kind = 'chipped-tooth', depth_mm = '$size', extent_mm = 5.0", "depth_mm"),
        ("kind = 'worn-tooth', depth_um = '$size'", "depth_um"),
    ],
)
def test_the_severity_of_a_tooth_fault_is_the_size_that_determines_its_effect(tmp_path, fault, key):
    faults = f"faults = [{{ stage = 1, gear = 'pinion', tooth = 3, {fault} }}]"
    varied = "[variables]\nsize = { from = 0.5, to = 1.5 }"
    plan = load(tmp_path, f'scene = "minimal"\nscenes = 2\n{varied}\n[settings]\n{faults}\n')
    for one in sampled_scenes(plan):
        found = labels(make_machine(scene_of(plan, one.values).scene))
        assert (found["severity"], found["severity_key"]) == (one.values["size"], key)


def test_a_machine_without_the_folder_sends_the_same_bits(whole, tmp_path):
    run(tmp_path, executor=Elsewhere)
    assert content(tmp_path / "out") == content(whole)


def test_what_a_process_did_before_changes_no_bit(whole, tmp_path):
    """Any number of workers means any order: here the last scene comes first."""
    plan = load(tmp_path)
    again = tmp_path / "out"
    shutil.copytree(whole, again)
    sampled = sampled_scenes(plan)
    identity, layout = find_begun(again, identity_facts(plan, sampled))
    for one in reversed(sampled):
        row_path(again, one.run).unlink()
        work(Job(plan=plan, layout=layout, folder=again, identity=identity, sample=one))
    assert content(again) == content(whole)


def test_a_campaign_goes_on_where_it_was_stopped(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "out")
    out = tmp_path / "out"
    row_path(out, 2).unlink()  # killed after the signals, before the row
    row_path(out, 4).unlink()  # killed while it wrote the signals
    (out / SIGNALS / "acceleration" / "c.4.0.0.0").write_bytes(b"half a chunk")
    (out / SIGNALS / "acceleration" / "c.4.0.0.0123.partial").write_bytes(b"")
    (out / "rows" / ".4-0123456789ab.partial").write_text("{", encoding="utf-8")
    finished = run(tmp_path)
    assert finished.simulated == 2
    assert content(out) == content(whole)


def test_a_finished_campaign_has_nothing_to_do(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "out")
    assert run(tmp_path).simulated == 0
    assert content(tmp_path / "out") == content(whole)


def test_a_scene_that_cannot_be_run_is_a_row_with_its_reason(tmp_path):
    text = PLAN.replace("tooth = { from = 0, to = 9 }", "tooth = [0, 1, 999]")
    finished = run(tmp_path, text)
    rows = list(read_rows(tmp_path / "out"))
    bad = [row for row in rows if row["values"]["tooth"] == 999]
    assert finished.failed == len(bad) > 0
    assert len(rows) == 6 > len(bad)
    for row in rows:
        assert (row["status"] == "failed") == (row in bad)
        assert ("tooth" in row["reason"]) == (row in bad)
    assert run(tmp_path, text).simulated == 0
    assert run(tmp_path, text, retry=True).simulated == len(bad)


def test_a_plan_whose_first_scenes_all_fail_is_refused_before_anything_is_made(tmp_path):
    text = PLAN.replace("tooth = { from = 0, to = 9 }", "tooth = [999]").replace('"healthy", ', "")
    with pytest.raises(SceneError, match="tooth"):
        run(tmp_path, text.replace("[cases.state.healthy]\nfaults = []\n", ""))
    assert not (tmp_path / "out" / "campaign.json").exists()


def test_a_run_that_fits_no_memory_is_refused_before_anything_is_built(tmp_path):
    text = 'scene = "minimal"\nscenes = 1\n[settings]\nsimulation.end_s = 1000.0\nsimulation.output_rate_Hz = 10000.0\n'
    with pytest.raises(InputError, match=r"in memory, limit 1 GB"):
        run(tmp_path, text)


def test_a_scene_that_records_something_else_fails_alone(tmp_path):
    text = PLAN.replace('state = ["healthy", "missing", "worn"]', 'state = ["healthy", "one"]')
    text = text[: text.index("[cases.state.missing]")].replace("tooth = { from = 0, to = 9 }\n", "")
    text = text.replace("depth = { from = 5.0, to = 20.0 }\n", "") + "[cases.state.one]\ndrive.motors = 1\n"
    run(tmp_path, text)
    for row in read_rows(tmp_path / "out"):
        first = read_row(tmp_path / "out", 0)["values"]["state"]
        assert (row["status"] == "done") == (row["values"]["state"] == first)
        assert row["status"] == "done" or "motor" in row["reason"]


def test_a_full_disk_stops_the_campaign_and_costs_nothing(whole, tmp_path, monkeypatch):
    calls = []
    real = job_module.write_run

    def full(folder, number, arrays):
        calls.append(number)
        if len(calls) > 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(folder, number, arrays)

    monkeypatch.setattr(job_module, "write_run", full)
    with pytest.raises(WorkError, match="No space left"):
        run(tmp_path)
    assert len(numbers(tmp_path / "out")) == 3
    monkeypatch.setattr(job_module, "write_run", real)
    assert run(tmp_path).simulated == 3
    assert content(tmp_path / "out") == content(whole)


def test_two_commands_do_not_work_on_one_campaign(tmp_path):
    with held(tmp_path / "out"), pytest.raises(InputError, match="another command"):
        run(tmp_path)


@pytest.mark.parametrize("change", [("scenes = 6", "scenes = 7"), ("600.0", "610.0"), ('"minimal"', '"bench"')])
def test_a_folder_belongs_to_one_campaign(whole, tmp_path, change):
    shutil.copytree(whole, tmp_path / "out")
    with pytest.raises((InputError, SceneError), match=r"was begun with|lead to|tooth"):
        run(tmp_path, PLAN.replace(*change))
    assert content(tmp_path / "out") == content(whole)


def test_a_folder_with_other_things_is_not_taken(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"thesis\.tex"):
        run(tmp_path)


def test_the_table_holds_what_the_rows_hold(whole):
    import pyarrow.parquet as pq

    table = pq.read_table(whole / "rows.parquet").to_pylist()
    rows = list(read_rows(whole))
    assert [one["run"] for one in table] == [row["run"] for row in rows]
    for one, row in zip(table, rows, strict=True):
        for name, value in {**row["values"], **row["labels"], **row["quality"]}.items():
            assert one[name] == value, name


def test_a_damaged_row_is_named(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "out")
    row_path(tmp_path / "out", 1).write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match=r"000001\.json.*Delete the file"):
        run(tmp_path)


def test_numbers_that_are_none_do_not_enter_a_row(tmp_path):
    (tmp_path / "rows").mkdir()
    with pytest.raises(ValueError, match="JSON"):
        write_row(tmp_path, 0, {"run": 0, "value": float("nan")})
    assert not numbers(tmp_path)
    assert not list((tmp_path / "rows").iterdir())


def test_one_assembly_serves_scenes_with_equal_machines(monkeypatch, tmp_path):
    from pipelines.datasets import worker_cache as module

    made = []
    real = module.assembled
    monkeypatch.setattr(module, "assembled", lambda *given, **taken: made.append(1) or real(*given, **taken))
    kept = module.WorkerCache(Work().cache)
    plan = load(tmp_path)
    scene = scene_of(plan, sampled_scenes(plan)[0].values).scene
    machine = checked_machine(scene, "scene")
    first, second = (moved(kept.system(machine), machine.motion).values for _ in range(2))
    assert np.array_equal(first, second)
    assert len(made) == 1
