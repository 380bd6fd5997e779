"""Small data sets made by hand: a plan's folder with signals that are known exactly, without any simulation."""

from pathlib import Path

import numpy as np

from pipelines.datasets.campaign_scenes import sampled_scenes, scene_key, scene_of
from pipelines.datasets.folder import begin, identity_facts
from pipelines.datasets.labels import labels
from pipelines.datasets.plan import load_plan
from pipelines.datasets.rows import DONE, FAILED, write_row, write_table
from pipelines.datasets.signal_layout import RunLayout, SignalLayout
from pipelines.datasets.store import write_run
from pipelines.machine.checks.checked_machine import checked_machine

RATE, SAMPLES = 5000.0, 4000
TEETH = (20, 55)  # of the scene
SENSORS = ("sensor_3", "sensor_4")
PLAN = """
title = "Known signals"
scene = "minimal"
scenes = 8
seed = 5

[variables]
speed_rpm = { from = 600.0, to = 1500.0 }
seed = { from = 1, to = 6 }
state = ["healthy", "missing"]

[settings]
drive.speeds_rpm = [0.0, "$speed_rpm", "$speed_rpm"]
drive.times_s = [0.0, 0.05, 1.0]
simulation.end_s = 0.8
deviations.seed = "$seed"

[cases.state.healthy]
faults = []
[cases.state.missing]
faults = [{ kind = "missing-tooth", stage = 1, gear = "pinion", tooth = 3 }]
"""


def layout():
    """Two sensors and the angles of two shafts."""
    units = {"units": "m/s2", "long_name": "acceleration"}
    return RunLayout(
        signals=(
            SignalLayout(
                name="acceleration",
                dims=("sensor", "axis", "time"),
                shape=(2, 3, SAMPLES),
                dtype="<f4",
                attributes=units,
            ),
            SignalLayout(
                name="shaft_angle", dims=("shaft", "time"), shape=(2, SAMPLES), dtype="<f8", attributes={"units": "rad"}
            ),
        ),
        names={"sensor": SENSORS, "axis": ("x", "y", "z"), "shaft": ("shaft_1", "shaft_2")},
        samples=SAMPLES,
        rate=RATE,
    )


def signals(run, speed_rpm):
    """Accelerations: 2 cos(20 phi) + 0.5 cos(21 phi) with phi of shaft 1, times the number of the channel from 1."""
    time = np.arange(SAMPLES) / RATE
    phi = 2 * np.pi * speed_rpm / 60 * time
    one = 2.0 * np.cos(TEETH[0] * phi) + 0.5 * np.cos((TEETH[0] + 1) * phi) + 0.01 * run
    acceleration = np.arange(1, 7).reshape(2, 3, 1) * one
    return {"acceleration": acceleration.astype("<f4"), "shaft_angle": np.stack([phi, -phi * TEETH[0] / TEETH[1]])}


def make_dataset(folder, plan=PLAN, left_out=(), failed=()):
    """The data set of a plan; runs that are `left_out` are not there yet."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder.parent / f"{folder.name}.toml"
    file.write_text(plan, encoding="utf-8")
    loaded = load_plan(file)
    sampled = sampled_scenes(loaded)
    scene = scene_of(loaded, sampled[0].values).resolved()
    begin(folder, loaded, scene, sampled, layout(), identity_facts(loaded, sampled))
    for sample in sampled:
        if sample.run not in left_out:
            make_run(folder, loaded, sample, failed=sample.run in failed)
    if not left_out:
        write_table(folder)
    return folder


def make_run(folder, plan, sample, *, failed=False):
    """One run with its row."""
    row = {"run": sample.run, "key": "", "status": FAILED, "reason": "it broke", "values": dict(sample.values)}
    row |= {"group": sample.group, "split": sample.split, "seconds": 1.0}
    if not failed:
        scene = scene_of(plan, sample.values)
        row |= {"key": scene_key(scene), "status": DONE, "reason": ""}
        row["labels"] = labels(checked_machine(scene.scene, scene.source.shown))
        row["quality"] = {"step_error": 1e-3 * (1 + sample.run), "repeatable_until_s": 0.8 - 1 / RATE, "warnings": ""}
        row["loop_seconds"] = 0.5
        row["checksums"] = write_run(folder, sample.run, signals(sample.run, sample.values.get("speed_rpm", 900.0)))
    write_row(folder, sample.run, row)
