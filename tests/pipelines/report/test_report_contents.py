"""What the report of a run shows, in order: headings, figures and captions; and which pictures a setting changes."""

import re
import sys

import numpy as np
import pytest

from fem.gears.modifications import active_roll
from pipelines.engine.run_graph import Work
from pipelines.engine.storage import digest
from pipelines.machine.machine_conversion import make_machine
from pipelines.report.figures import render
from pipelines.runs import run_folder
from pipelines.runs.checked_scene import check_scene
from pipelines.runs.run import run_scene
from pipelines.scene.load_scene import load_scene
from pipelines.steps.pictures import picture_steps
from pipelines.steps.reporting import gear_rows

RENDERER = """
import json, sys
from PIL import Image
job = json.load(open(sys.argv[1]))
for image in job["images"]:
    Image.new("RGB", job["size"], "grey").save(image)
json.dump({name: [300.0 + 9 * i, 200.0] for i, name in enumerate(job["places"])}, open(job["pixels"], "w"))
"""
SHORT = {"simulation.end_s": 0.6, "diagnosis.windows_s": {"steady": [0.1, 0.6]}, "diagnosis.gear": "pinion"}
FAULTY = {
    **SHORT,
    "control": "without-faults",
    "faults": [{"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 3}],
    "casing.housing.pad_diameter_mm": 20.0,  # a casing with pads is meshed
    "casing.housing.pad_height_mm": 3.0,
    "casing.element_size_mm": 20.0,
}
BENCH = [
    "# One stage, rigid casing, constant torque",
    "figure: Time-synchronous average of the acceleration at sensor_3, z over 6 revolutions of shaft 1 in the "
    "window steady, without the mesh orders (residual signal).",
    "figure: Envelope spectrum of sensor_3 (z) in the window steady. Marked: harmonics of the revolution "
    "frequency fr = 15.0000 Hz. A damaged tooth raises them.",
    "# Signals and spectra",
    "figure: Acceleration at the sensor without sensor noise: the whole run (left) and 0.1 s of it (right).",
    "figure: Spectrum in the window steady: one-sided peak amplitudes over 6 revolutions of the shaft with fr (0.4 s, "
    "the longest part with whole numbers of revolutions and samples), Hann window, with sensor noise.",
    "# Levels",
    "# What was run",
    "# Gears",
    "figure: Gear pair and secant mesh stiffness from bore to bore. One mesh cycle is the motion by one base pitch.",
    "# Casing",
    "# Speed",
    "figure: Speeds of the motors and the first shaft. Shaded: the windows of the diagnosis.",
    "# Energy balance",
    "# Cost",
    "# Provenance",
]
DAMAGED = [
    "# One stage, rigid casing, constant torque",
    "figure: Time-synchronous average of the acceleration at sensor_3, z over 6 revolutions of shaft 1 in the "
    "window steady, without the mesh orders (residual signal). Below: this run minus the healthy "
    "run, the effect of the fault alone. Shaded: the engagement of tooth 3, which is damaged in the scene and at "
    "which the impact begins. Teeth are numbered from 0.",
    "figure: Envelope spectrum of sensor_3 (z) in the window steady. Marked: harmonics of the revolution "
    "frequency fr = 15.0000 Hz. A damaged tooth raises them.",
    "# Signals and spectra",
    "figure: Acceleration at the sensor without sensor noise: the whole run (left) and 0.1 s of it (right).",
    "figure: Steady, constant torque, deviations of seed 1: one-sided peak amplitudes over 6 revolutions "
    "of the shaft of the damaged gear (0.4 s, the longest part with whole numbers of revolutions and samples), Hann "
    "window, sensor noise 0.01 m/s² rms.",
    "# How it was decided",
    "# Levels",
    "# Healthy and faulty",
    "figure: Steady, constant torque, deviations of seed 1: healthy and faulty run. Triangles: "
    "detected lines. Yellow bar next to a line: range of its level for uncertain damping.",
    "# Error bars",
    "figure: Error bars in the window steady: change of the level of a line by uncertain damping. Lines that are not "
    "clearly over their floor are left out.",
    "# All lines",
    "# What was run",
    "# Gears",
    "figure: Gear pair and secant mesh stiffness from bore to bore. One mesh cycle is the motion by one base pitch.",
    "# Casing",
    "figure: The casing with its feet (yellow), bearings (red) and sensors (green).",
    "# Speed",
    "figure: Speeds of the motors and the first shaft. Shaded: the windows of the diagnosis.",
    "# Energy balance",
    "# Cost",
    "# Provenance",
]


def listed(folder, settings, monkeypatch):
    """The lines of a report: "# heading" and "figure: caption"."""
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-c", RENDERER])
    finished = run_scene(load_scene("minimal", settings), out=folder, work=Work(quiet=True, processes=1))
    page = (finished.folder / run_folder.REPORT).read_text(encoding="utf-8")
    found = re.finditer(r"<h[12]>(.*?)</h|<figure[^>]*>.*?<svg.*?<figcaption>(.*?)</figcaption>", page, re.DOTALL)
    return [f"# {one[1]}" if one[1] else f"figure: {re.sub('<[^>]*>', '', one[2])}" for one in found]


def test_a_bench_shows_its_signals_and_its_machine(tmp_path, monkeypatch):
    assert listed(tmp_path / "run", SHORT, monkeypatch) == BENCH


def test_a_faulty_machine_is_shown_beside_its_control(tmp_path, monkeypatch):
    assert listed(tmp_path / "run", FAULTY, monkeypatch) == DAMAGED


def test_a_sensor_that_is_not_on_the_casing_is_named_once_in_the_log_and_in_the_report(tmp_path, monkeypatch, caplog):
    """15 mm before the wall: it measures at the nearest point of the mesh."""
    settings = {"simulation.end_s": 0.1, "diagnosis.windows_s": {}, "casing.element_size_mm": 40.0}
    listed(
        tmp_path / "run",
        {**settings, "casing.model": "static", "sensors.1.position_mm": [76.7, -95.0, 35.5]},
        monkeypatch,
    )
    page = (tmp_path / "run" / run_folder.REPORT).read_text(encoding="utf-8")
    for text in (page, caplog.text):
        (distance,) = re.findall(r"sensor_3 measures at the nearest point of the casing, ([\d.]+) mm from", text)
        assert float(distance) == pytest.approx(15, abs=0.5)


def test_a_run_warns_as_check_does(tmp_path, caplog):
    """The scene minimal has the model iso. The line load is a quarter, its fourth root 0.71 of the shipped one."""
    settings = {"simulation.end_s": 0.1, "diagnosis.windows_s": {}, "load.container_kg": 28.0}
    assert not check_scene(load_scene("minimal")).warnings
    loaded = load_scene("minimal", settings)
    warnings = check_scene(loaded).warnings
    assert any("the model iso reduces the stiffness by 3" in text for text in warnings)
    run_scene(loaded, out=tmp_path / "run", with_report=False, work=Work(quiet=True, processes=1))
    logged = [record.getMessage() for record in caplog.records]
    assert [text for text in warnings if text in logged] == list(warnings)


def root_start(machine):
    """A radius (m) near the root of the active profile of the wheel of stage 1."""
    pair = machine.layout.pairs[0]
    return np.hypot(pair.wheel.base_radius, active_roll(pair, "wheel")[0] + 0.3e-3)


def test_the_table_of_gears_states_the_modifications_of_the_scene_whatever_the_sense_of_the_law():
    """The face coordinate of a law may run along -y; the ends and slopes of the table are those of the scene."""
    pinion = {"tip_relief": {"amount_um": 11.0, "length_mm": 1.5}, "helix_slope_um": 4.0,
              "end_relief_plus_y": {"amount_um": 6.0, "length_mm": 2.0, "shape": "parabolic"}}  # fmt: skip
    words = "tip relief 11 um over 1.5 mm, linear; end relief plus y 6 um over 2 mm, parabolic; helix slope 4 um"
    senses = set()
    for scene in ("minimal", "rig-healthy"):
        settings = {f"stages.{n}.pinion": pinion for n in range(1, len(load_scene(scene).scene.stages) + 1)}
        machine = make_machine(load_scene(scene, settings).scene)
        senses |= set(machine.layout.pinion_senses)
        rows = gear_rows(machine)
        by_diameter = {"stages.1.wheel.root_relief": {"amount_um": 5.0, "diameter_mm": 2e3 * root_start(machine)}}
        changed_plant = make_machine(load_scene(scene, by_diameter).scene)
        assert gear_rows(changed_plant)[1]["flank modifications"].startswith("root relief 5 um from diameter ")
        assert {row["flank modifications"] for row in rows if row["gear"] == "pinion"} == {words}
        assert {row["flank modifications"] for row in rows if row["gear"] == "wheel"} == {"none"}
    assert senses == {1, -1}


def changed(**settings):
    """Names of the steps of pictures that other settings of the faulty scene change."""
    machines = [make_machine(load_scene("minimal", {**FAULTY, **more}).scene) for more in ({}, settings)]
    own, other = (
        {step.name: digest(step.spec) for step in picture_steps(machine, ["casing mesh"])} for machine in machines
    )
    return {name for name in own if own[name] != other[name]}


def test_pictures_are_drawn_again_for_what_they_show_alone():
    assert changed(**{"load.container_kg": 90.0}) == {"stiffness curves"}
    assert changed(**{"diagnosis.noise_m_s2": 0.1, "deviations.seed": 7, "simulation.end_s": 0.7}) == set()
    assert changed(**{"sensors.1.position_mm": [70.0, -80.0, 35.5]}) == {"casing picture"}
    assert changed(faults=[{**FAULTY["faults"][0], "tooth": 4}]) == {"gear picture", "stiffness curves"}
