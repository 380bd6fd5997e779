"""A scene is converted in one place to the machine model; what follows it knows neither scenes nor their units."""

import ast

import pytest
from sources import ROOT, nodes

from fem.contact.faults.missing_tooth import MissingTooth
from pipelines.engine.code_version import reachable
from pipelines.engine.storage import class_modules, digest
from pipelines.io.errors import SceneError
from pipelines.machine.checks.collisions import RevolvedBody
from pipelines.machine.machine_conversion import make_drivetrain, make_machine
from pipelines.machine.scene_flanks import Fault, first_tooth_fault
from pipelines.scene.load_scene import load_scene
from pipelines.steps.machine_steps import machine_steps

BEHIND = ("engine", "report", "runs", "signals", "steps", "studies", "cli")  # rooms behind the machine model
UNITS = ("_mm", "_um", "_GPa", "_per_um", "_deg", "_rpm", "_us", "_kg", "_s", "_Hz", "_m", "_kg_m3", "_kg_m2")


def motion(**settings):
    return machine_steps(make_machine(load_scene("minimal", settings).scene))[-1]


def files_behind():
    return [path for room in BEHIND for path in sorted((ROOT / "pipelines" / room).rglob("*.py"))]


def scene_values(node):
    return [n.attr for n in ast.walk(node) if isinstance(n, ast.Attribute) and n.attr.endswith(UNITS)]


def converted(nodes):
    """Values with a unit in their name that are multiplied or divided by a number, or turned into radians."""
    for node in nodes:
        number = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div)
        number = number and any(isinstance(side, ast.Constant | ast.UnaryOp) for side in (node.left, node.right))
        angle = isinstance(node, ast.Call) and ast.unparse(node.func).endswith("radians")
        if number or angle:
            yield from scene_values(node)


@pytest.mark.parametrize("line", ["1e6 * table.mount_N_per_um", "math.radians(t.a_deg)", "s.step_us / 1_000_000"])
def test_a_conversion_is_recognised(line):
    assert list(converted(ast.walk(ast.parse(line))))


def test_no_unit_of_a_scene_is_converted_behind_the_machine_model():
    found = {path.relative_to(ROOT): list(converted(nodes(path))) for path in files_behind()}
    assert len(found) > 100
    wrong = [f"{path}: {', '.join(values)}" for path, values in found.items() if values]
    assert not wrong, "\n".join(wrong)


def test_behind_the_machine_model_only_what_makes_other_scenes_names_the_class():
    naming = {
        f"{path.parent.name}/{path.name}"
        for path in files_behind()
        if any(isinstance(node, ast.ImportFrom) and node.module == "pipelines.scene.scene" for node in nodes(path))
    }
    assert naming == {
        "steps/run_plan.py",
        "trade/refinement_axes.py",
        "trade/tradeoff_choices.py",
        "detect/detection_campaign.py",
        "housings/housing_block.py",
        "housings/seats.py",
    }


@pytest.mark.parametrize("step", ["flanks", "stress", "casing", "motion"])
def test_a_result_hangs_on_no_code_that_reads_scenes(step):
    found = reachable(f"pipelines.steps.{step}")
    assert [name for name in found if name.startswith(("pipelines.scene", "pipelines.machine.machine_model"))] == []


def test_a_motion_hangs_on_the_code_of_the_load_and_bearings_it_has():
    def modules(name, **settings):
        return class_modules(machine_steps(make_machine(load_scene(name, settings).scene))[-1].spec)

    hertz = {"bearings": {"model": "hertz", "designation": "6205"}}
    assert "mbd.forces.rolling_bearing" in modules("minimal", **hertz)
    assert "mbd.forces.rope" in modules("rig-healthy")
    assert not {"mbd.forces.rolling_bearing", "mbd.forces.rope"} & modules("minimal")


@pytest.mark.parametrize(
    "settings",
    [
        {"title": "another"},
        {"casing.housing.wall_thickness_mm": 12.0},
        {"casing.material.density_kg_m3": 7000.0},
        {"casing.mount_stiffness_N_per_um": 100.0},
        {"sensors.1.position_mm": [70.0, -80.0, 35.5]},
        {"stages.1.mesh": {"model": "energy"}},
        {"diagnosis.noise_m_s2": 0.1},
    ],
    ids=lambda settings: next(iter(settings)),
)
def test_the_motion_shares_its_spec_where_only_laws_casing_or_words_differ(settings):
    assert digest(motion(**settings).spec) == digest(motion().spec)


@pytest.mark.parametrize("settings", [{"deviations.include": []}, {"load.container_kg": 80.0}, {"sensors": []}])
def test_the_motion_has_a_spec_of_its_own_where_the_machine_or_its_channels_differ(settings):
    assert digest(motion(**settings).spec) != digest(motion().spec)


def test_a_diagnosis_can_be_repeated_where_the_file_of_the_housing_is_gone():
    scene = load_scene("rig-step").scene
    gone = scene.casing.housing.model_copy(update={"file": "gone.step"})
    scene = scene.model_copy(update={"casing": scene.casing.model_copy(update={"housing": gone})})
    assert make_drivetrain(scene).diagnosis.mesh_frequency == pytest.approx(300.0)
    with pytest.raises(SceneError, match=r"gone\.step"):
        make_machine(scene)


def test_a_missing_tooth_is_shown_before_other_damage():
    def fault(kind, tooth, stage=1):
        return Fault(stage=stage, gear="wheel", tooth=tooth, kind=kind, damage=MissingTooth())

    worn, cracked, chipped = fault("worn-tooth", None), fault("cracked-tooth", 3), fault("chipped-tooth", 9)
    missing = fault("missing-tooth", 7)
    assert first_tooth_fault([worn, cracked, missing, fault("missing-tooth", 8)], 1) == missing
    assert first_tooth_fault([worn, cracked, chipped], 1) == cracked
    assert first_tooth_fault([worn, fault("missing-tooth", 7, stage=2)], 1) is None


def test_gears_that_touch_with_their_faces_do_not_overlap():
    def gear(start, end):
        return RevolvedBody(name="tip circle", path="stages.1", shaft=0, radius=0.05, start=start, end=end)

    assert gear(0.0, 0.02).overlaps(gear(0.01, 0.03))
    assert not gear(0.0, 0.02).overlaps(gear(0.02, 0.04))
    assert not gear(0.02, 0.04).overlaps(gear(0.0, 0.02))
