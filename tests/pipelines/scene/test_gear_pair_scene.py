"""The shipped scene `pair`: the data of two gears are enough for stiffness, modifications and faults."""

import json
import re

import numpy as np
import pytest
from matplotlib.figure import Figure

import gearcase
from pipelines.cli.main import main
from pipelines.io.errors import SceneError
from pipelines.machine.checks.design_warnings import design_warnings
from pipelines.machine.layout import lay_out
from pipelines.machine.machine_conversion import make_drivetrain
from pipelines.runs import inspect_gears
from pipelines.runs.checked_scene import check_scene
from pipelines.scene.load_scene import load_scene
from pipelines.steps.run_plan import plan_run

OWN = """extends = "pair"
faults = [{ kind = "cracked-tooth", stage = 1, gear = "wheel", tooth = 10, depth_mm = 2.0 }]
[stages.1]
pinion_teeth = 23
wheel_teeth = 57
module_mm = 3.0
face_width_mm = 25.0
mesh = { model = "plane", slices = 1 }
"""


def stage(**values):
    return load_scene("pair", {f"stages.1.{key}": value for key, value in values.items()})


@pytest.mark.parametrize("module", [0.5, 3.0, 30.0])
@pytest.mark.parametrize("beta", [0.0, 20.0])
@pytest.mark.parametrize("teeth", [(17, 300), (300, 17), (40, 41), (300, 300)])
def test_gears_of_any_size_need_nothing_else(module, beta, teeth):
    pinion, wheel = teeth
    found = check_scene(
        stage(module_mm=module, helix_angle_deg=beta, pinion_teeth=pinion, wheel_teeth=wheel, face_width_mm=8 * module)
    )
    gears = found.machine.layout.pairs[0]
    assert gears.wheel.bore_radius == pytest.approx(gears.wheel.root_radius / 2)
    assert found.facts.stages[0].shown_force == pytest.approx(100e3 * 0.008 * module)


@pytest.mark.parametrize("wheel", [25, 300])
def test_eight_teeth_mesh_with_a_profile_shift(wheel):
    check_scene(stage(pinion_teeth=8, pinion_profile_shift=0.5, wheel_teeth=wheel))


def test_a_bore_that_is_given_stays():
    gears = lay_out(stage(pinion_bore_mm=31.0).scene).pairs[0]
    assert gears.pinion.bore_radius == 0.0155


def test_a_bore_in_the_root_is_refused_by_its_key_in_millimetres():
    with pytest.raises(SceneError) as refused:
        lay_out(stage(pinion_teeth=20, pinion_bore_mm=60.0).scene)
    said = str(refused.value)
    assert "pinion_bore_mm = 60 reaches the root circle, diameter 35 mm" in said
    assert " m " not in said


def test_a_crack_that_is_too_deep_is_refused_in_millimetres():
    loaded = load_scene("pair", {"faults": [{"kind": "chipped-tooth", "stage": 1, "gear": "wheel", "tooth": 1,
                                             "depth_mm": 9.0, "extent_mm": 5.0}]})  # fmt: skip
    with pytest.raises(SceneError, match=r"depth_mm = 9 is more than the tooth height. Set at most 4.5"):
        check_scene(loaded)


def test_gears_takes_torques_and_writes_its_plot(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text(OWN, encoding="utf-8")
    relief = "stages.1.pinion.tip_relief={amount_um=10.0,length_mm=3.0}"
    command = ["gears", "own.toml", "--torque", "50", "100", "--set", relief, "--plot", "te.svg", "--quiet", "--json"]
    assert main(command) == 0
    found = json.loads(capsys.readouterr().out)
    radius = 3.0e-3 * 23 / 2 * 0.9396926207859084  # r_b = m z cos(20 deg) / 2
    assert [(row["state"], row["torque N m"]) for row in found["pairs"]] == [
        (state, torque)
        for torque in (50.0, 100.0)
        for state in ("healthy, unmodified", "healthy", "cracked tooth 10 of the wheel")
    ]
    assert all(row["load N"] == pytest.approx(row["torque N m"] / radius) for row in found["pairs"])
    assert [(row["torque N m"], row["flanks"]) for row in found["orders"]] == [
        (50.0, "unmodified"), (50.0, "modified"), (100.0, "unmodified"), (100.0, "modified"),
    ]  # fmt: skip
    assert found["plot"].endswith("te.svg")
    assert (tmp_path / "te.svg").read_text(encoding="utf-8").startswith("<?xml")
    assert main([*command[:5], "--tilt", "machine"]) == 2
    assert "Delete --torque" in capsys.readouterr().err


def test_a_shaft_thicker_than_the_bores_on_it_is_warned_of():
    def warned(**settings):
        scene = load_scene("bench", settings).scene
        return [text for text in design_warnings(scene, make_drivetrain(scene)) if "the bore of" in text]

    balls = {"model": "hertz", "designation": "6208"}
    assert warned(bearings=balls) == []
    found = warned(bearings=balls | {"designation": "6206"})
    assert len(found) == 2
    assert found[0].startswith("shafts.2.sections.1.diameter_mm = 40: the bore of bearing 1 on it, 6206, is 30 mm")
    (found,) = warned(**{"stages.1.pinion_bore_mm": 25.0})
    assert found.startswith("shafts.1.sections.1.diameter_mm = 30: the bore of the gear on it is 25 mm")
    assert found.endswith("set stages.1.pinion_bore_mm = 30")


def test_rigid_bearings_leave_the_gears_parallel(capsys):
    values = ("load.torque_N_m=1000", "stages.1.helix_angle_deg=20", "stages.1.mesh.slices=11")
    settings = [word for value in values for word in ("--set", value)]
    assert main(["gears", "pair", "--tilt", "machine", "--json", "--quiet", *settings]) == 0
    tilt = re.search(r"tilt (\S+) um", json.loads(capsys.readouterr().out)["notes"][0])
    assert abs(float(tilt[1])) < 0.01


def test_the_pattern_of_a_missing_tooth_is_that_of_its_neighbours(tmp_path, monkeypatch):
    fault = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 24}
    (laws,) = gearcase.laws(gearcase.Scene.from_dict({"extends": "pair", "faults": [fault]}))
    seen = []
    monkeypatch.setattr(inspect_gears, "pattern_figure", lambda *given, **_: seen.append(given) or Figure())
    machine = plan_run(load_scene("pair", {"faults": [fault]}), with_control=False, both_loads=False).machine
    inspect_gears.InspectedStage(machine=machine, laws=laws).write_pattern(tmp_path / "pattern.png")
    ((title, patterns),) = seen
    assert title.endswith("neighbours of the missing tooth 24 of the pinion")
    healthy, before, after = patterns
    assert before.name.startswith("tooth 23,")
    assert after.name.startswith("tooth 0,")
    assert np.nanmean(before.pressure) > 1.05 * np.nanmean(healthy.pressure)
    assert np.nanmax(after.pressure) > 1.3 * np.nanmax(healthy.pressure)


def test_the_stress_of_a_stage_with_a_crack_says_where_the_crack_is_not(tmp_path, capsys):
    fault = 'faults=[{kind="cracked-tooth", stage=1, gear="wheel", tooth=0, depth_mm=1.0}]'
    coarse = 'stages.1.mesh={model="solid", slices=3, refinement=0.6, positions=8}'
    command = ["inspect", "pair", "--set", fault, "--set", coarse, "--position", "0", "--quiet", "--processes", "1"]
    assert main([*command, "--mesh", str(tmp_path / "teeth.vtu")]) == 0
    out, err = capsys.readouterr()
    assert out == f"{tmp_path / 'teeth.vtu'}\n"
    assert "warning: stage 1: the crack is not in the finite elements: the stress is that of an uncracked tooth" in err
    assert "--mesh FILE.inp" in err
    assert main([*command, "--json"]) == 2
    assert "--json prints root stresses. Add --stress" in capsys.readouterr().err
