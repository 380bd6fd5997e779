"""The machine of a recording: five lines of TOML or a scene give its shafts, gears and bearings in orders."""

import math

import numpy as np
import pytest
from measured import signals

from pipelines.io.errors import InputError, SceneError
from pipelines.machine.layout import lay_out
from pipelines.machine.machine_conversion import make_machine
from pipelines.machine.scene_kinematics import kinematics_of, pass_rates
from pipelines.recordings.machine_file import read_machine
from pipelines.recordings.read_recording import read_recording
from pipelines.scene.load_scene import load_scene

FIVE = """\
teeth = [[21, 62], [23, 75]]
speed_rpm = 1480
rate_Hz = 10000
units = "g"
sensors = { gearbox = 1, motor = { x = "channel 2" } }
"""


def machine(tmp_path, text):
    (tmp_path / "bench.toml").write_text(text, encoding="utf-8")
    return read_machine(tmp_path / "bench.toml")


def test_five_lines_are_a_machine_and_read_its_recording(tmp_path):
    found = machine(tmp_path, FIVE)
    ratios = [shaft.ratio for shaft in found.kinematics.shafts]
    assert [shaft.name for shaft in found.kinematics.shafts] == ["shaft_1", "shaft_2", "shaft_3"]
    assert ratios == pytest.approx([1.0, 21 / 62, 21 / 62 * 23 / 75])
    assert found.kinematics.mesh_orders() == pytest.approx({1: 21.0, 2: 21 / 62 * 23})
    assert found.kinematics.frequency == pytest.approx(1480 / 60)
    assert [gear.name for gear in found.kinematics.gears_on("shaft_2")] == ["stage 1 wheel", "stage 2 pinion"]
    np.save(tmp_path / "r.npy", signals())
    with read_recording(tmp_path / "r.npy", found) as recording:
        measured = recording.acceleration
        np.testing.assert_allclose(measured.sel(sensor="gearbox", axis="z"), 9.80665 * signals()[:, 0])
        np.testing.assert_allclose(measured.sel(sensor="motor", axis="x"), 9.80665 * signals()[:, 1])
        assert np.isnan(measured.sel(sensor="gearbox", axis="x")).all()


def test_unknown_teeth_leave_the_orders_of_the_shafts(tmp_path):
    found = machine(tmp_path, "ratios = [1.0, 0.34]\nspeed_rpm = 1480\n").kinematics
    assert [shaft.ratio for shaft in found.shafts] == [1.0, 0.34]
    assert found.gears == ()
    assert found.mesh_orders() == {}
    assert len(machine(tmp_path, "speed_rpm = 1480\n").kinematics.shafts) == 1


def test_a_branched_train_names_its_shafts(tmp_path):
    text = "teeth = [[20, 40], [20, 60], [30, 15]]\nshafts = [[1, 2], [1, 3], [4, 2]]\nspeed_rpm = 600\n"
    ratios = {shaft.name: shaft.ratio for shaft in machine(tmp_path, text).kinematics.shafts}
    assert ratios == pytest.approx({"shaft_1": 1.0, "shaft_2": 0.5, "shaft_3": 1 / 3, "shaft_4": 0.25})


def test_pass_orders_follow_from_the_geometry_or_are_given(tmp_path):
    text = (
        'ratios = [1.0, 0.5]\nspeed_rpm = 1800\nbearings = [{ name = "DE", shaft = 2, elements = 9, '
        "pitch_diameter_mm = 39.04, element_diameter_mm = 7.94 }, "
        '{ name = "FE", BPFO = 3.05, BPFI = 4.95 }]\n'
    )
    drive_end, free_end = machine(tmp_path, text).kinematics.bearings
    assert drive_end.shaft == "shaft_2"
    share = 7.94 / 39.04
    assert drive_end.orders["BPFO"] == pytest.approx(4.5 * (1 - share))
    assert drive_end.orders["BPFO"] + drive_end.orders["BPFI"] == pytest.approx(9.0)
    assert drive_end.orders["FTF"] == pytest.approx(drive_end.orders["BPFO"] / 9)
    assert free_end.orders == {"BPFO": 3.05, "BPFI": 4.95}
    tilted = machine(tmp_path, text.replace("7.94 }", "7.94, contact_angle_deg = 40 }")).kinematics.bearings[0]
    assert tilted.orders["BPFO"] == pytest.approx(4.5 * (1 - share * math.cos(math.radians(40))))


def test_a_tachometer_takes_the_place_of_the_speed(tmp_path):
    text = 'teeth = [[21, 62]]\ntachometer = { channel = "key", shaft = 2, pulses_per_turn = 8 }\n'
    found = machine(tmp_path, text)
    assert found.kinematics.frequency is None
    assert found.table.tachometer.shaft == 2
    assert found.table.tachometer.pulses_per_turn == 8.0
    assert found.table.tachometer.level is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("teeth = [[21, 62]]\n", "speed_rpm is missing. Set the speed of the first shaft, a tachometer, or speed"),
        ("speed_rmp = 1480\n", "Did you mean speed_rpm?"),
        ("speed_rpm = 0\n", "speed_rpm = 0: must be greater than 0"),
        ('speed_rpm = "fast"\n', "must be a number"),
        ("speed_rpm = 9\nteeth = [[21]]\n", "teeth.1 = [21]: has too few values"),
        ("speed_rpm = 9\nteeth = [[21, 2]]\n", "teeth.1.2 = 2: must be at least 3"),
        ("speed_rpm = 9\nteeth = [[21, 62]]\nratios = [1.0, 0.5]\n", "teeth and ratios are both given"),
        ("speed_rpm = 9\nratios = [0.5, 1.0]\n", "ratios: the first is 0.5 and must be 1"),
        ("speed_rpm = 9\nteeth = [[21, 62]]\nshafts = [[1, 2], [2, 3]]\n", "shafts has 2 pairs of numbers"),
        ("speed_rpm = 9\nteeth = [[21, 62]]\nshafts = [[2, 3]]\n", "no pair connects shafts 2 and 3 to shaft 1"),
        ("speed_rpm = 9\nteeth = [[21, 62]]\nshafts = [[1, 3]]\n", "shaft 2 is in no pair"),
        (
            "speed_rpm = 9\nteeth = [[20, 40], [20, 50]]\nshafts = [[1, 2], [1, 2]]\n",
            "teeth.2: gives shaft 2 a speed of 0.4",
        ),
        ('speed_rpm = 9\nunits = "furlong"\n', "must be one of m/s2, mm/s2, g, mg, V, mV. Correct it"),
        ('speed_rpm = 9\nunits = "V"\n', "sensitivity_mV_g is missing"),
        ("speed_rpm = 9\nsensors = { a = 0 }\n", "a must be the name of a channel in quotes, or its number"),
        ("speed_rpm = 9\nsensors = { a = true }\n", "a must be the name of a channel in quotes, or its number"),
        ("speed_rpm = 9\nsensors = { a = { u = 1 } }\n", "a has the axis u; allowed are x, y, z"),
        ("speed_rpm = 9\ntime = true\n", "time: must be the name of a channel in quotes, or its number"),
        ('speed_rpm = 9\nsensors = "a"\n', "must be a table of names and channels"),
        ("tachometer = { channel = 1, shaft = 2 }\n", "tachometer.shaft: there is no shaft 2, allowed are 1 to 1"),
        ("tachometer = { chanel = 1 }\n", "is not a key of [tachometer]. Did you mean channel?"),
        ('speed_rpm = 9\nbearings = [{ name = "b", shaft = 3, BPFO = 3 }]\n', "there is no shaft 3"),
        ('speed_rpm = 9\nbearings = [{ name = "b" }]\n', "give either elements, pitch_diameter_mm"),
        (
            'speed_rpm = 9\nbearings = [{ name = "b", elements = 9 }]\n',
            "pitch_diameter_mm, element_diameter_mm is missing",
        ),
        (
            'speed_rpm = 9\nbearings = [{ name = "b", elements = 9, pitch_diameter_mm = 10, '
            "element_diameter_mm = 9 }]\n",
            "at most 3.420",
        ),
    ],
)
def test_what_is_wrong_is_said_with_path_value_and_remedy(text, said, tmp_path):
    with pytest.raises(SceneError, match="problem") as error:
        machine(tmp_path, text)
    assert said in str(error.value)


def test_a_file_that_is_missing_or_no_toml_is_refused(tmp_path):
    machine(tmp_path, FIVE)
    with pytest.raises(InputError, match=r"Did you mean bench\.toml"):
        read_machine(tmp_path / "benhc.toml")
    with pytest.raises(InputError, match="not valid TOML"):
        machine(tmp_path, "speed_rpm = = 3")


@pytest.mark.parametrize("name", ["bench", "rig-missing-tooth"])
def test_a_scene_is_a_machine_with_the_names_of_its_runs(name, tmp_path):
    scene = load_scene(name).scene
    layout = lay_out(scene)
    found = read_machine(name).kinematics
    assert [shaft.name for shaft in found.shafts] == [f"shaft_{i + 1}" for i in range(len(scene.shafts))]
    assert found.shafts[0].ratio == 1.0
    assert found.frequency == pytest.approx(layout.turns * layout.shaft_ratios[0])
    teeth = [(stage.pinion_teeth, stage.wheel_teeth) for stage in scene.stages]
    assert [gear.teeth for gear in found.gears] == [number for pair in teeth for number in pair]
    for stage, (pinion, wheel) in enumerate(teeth, 1):  # both gears of a pair pass as many teeth
        driving, driven = (gear for gear in found.gears if gear.stage == stage)
        orders = [found.shaft(gear.shaft).ratio * gear.teeth for gear in (driving, driven)]
        assert orders == pytest.approx([found.mesh_orders()[stage]] * 2)
        assert (driving.teeth, driven.teeth) == (pinion, wheel)
    (tmp_path / "own.toml").write_text(f'extends = "{name}"\n', encoding="utf-8")
    assert read_machine(tmp_path / "own.toml").kinematics == found


def test_pass_orders_of_a_scene_are_its_pass_rates_over_the_speed():
    rolling = {"model": "hertz", "kind": "ball", "elements": 9, "element_diameter_mm": 7.0, "pitch_diameter_mm": 35.0}
    loaded = load_scene("bench", {"bearings": rolling})
    machine = make_machine(loaded.scene)
    found = kinematics_of(machine.layout, machine.rolling)
    assert [bearing.name for bearing in found.bearings] == [bearing.name for bearing in machine.rolling]
    for bearing, scene in zip(found.bearings, machine.rolling, strict=True):
        speed = found.frequency * found.shaft(bearing.shaft).ratio
        rates = {label: order * speed for label, order in bearing.orders.items()}
        assert rates == pytest.approx(pass_rates(machine.layout, scene))
