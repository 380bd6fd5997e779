"""What a changed value touches: nothing is built here, only the inputs of the stages are compared."""

import pytest

from pipelines.engine.storage import digest
from pipelines.io.errors import InputError
from pipelines.machine.checks.design_warnings import design_warnings
from pipelines.machine.machine_conversion import make_drivetrain, make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.steps.run_plan import plan_run


def inputs(scene, *settings, **options):
    plan = plan_run(load_scene(scene, settings), **options)
    return {stage.name: (stage.kind, digest(stage.spec), stage.inputs) for stage in plan.graph}


def touched(scene, *settings):
    """Stages of the scene itself whose own inputs change; what follows from them is a matter of content."""
    before = inputs(scene, with_control=False, both_loads=False)
    after = inputs(scene, *settings, with_control=False, both_loads=False)
    assert before.keys() == after.keys()
    return {name for name in before if before[name] != after[name]}


@pytest.mark.parametrize(
    ("setting", "stages"),
    [
        ("load.container_kg=800", {"simulate"}),
        ("stages.1.face_width_mm=13", {"law_1", "simulate"}),
        ("stages.1.backlash_um=90", {"simulate"}),
        ("stages.2.mesh.slices=9", {"law_2"}),
        ("stages.1.pinion_bore_mm=24", {"law_1", "simulate"}),
        ("sensors.2.position_mm=[1, 150, 28]", {"casing"}),
        ("casing.damping_ratio=0.02", {"casing"}),
        ("casing.band_Hz=4000", {"casing modes", "casing"}),
        ("casing.ground=springs", {"casing modes", "casing"}),
        ("bearings.tilt_stiffness_N_m_per_rad=0", {"casing modes", "simulate"}),
        ("bearings.tilt_stiffness_N_m_per_rad=9e3", {"simulate"}),
        ("casing.frequency_error=0.001", {"casing"}),
        ("casing.damping_ratio=[[0, 0.01], [1000, 0.02]]", {"casing"}),
        ("casing.mounts_N_per_um=[[1, 1, 1]]", set()),
        ("casing.attachment=rigid", {"casing modes"}),
        ("casing.material.density_kg_m3=7300", {"casing modes"}),
        ("casing.housing.wall_thickness_mm=11", {"casing mesh"}),
        ("casing.element_size_mm=25", {"casing mesh"}),
        ("stages.1.direction_deg=1", {"casing mesh", "simulate"}),
        ("deviations.seed=2", {"simulate"}),
        ("faults.1.tooth=5", {"simulate"}),
        ("simulation.step_us=5", {"simulate"}),
        ("diagnosis.noise_m_s2=0.02", set()),
        ("title=another", set()),
        ("diagnosis.axis=x", set()),
    ],
)
def test_a_changed_value_touches_only_the_stages_that_read_it(setting, stages):
    assert touched("rig-missing-tooth", setting) == stages


def test_a_missing_tooth_enters_only_the_simulation():
    healthy = inputs("rig-healthy", with_control=False, both_loads=False)
    faulty = inputs("rig-missing-tooth", with_control=False, both_loads=False)
    assert {name for name in healthy if healthy[name] != faulty[name]} == {"simulate"}


def test_scene_and_control_share_all_but_the_simulation():
    alone = inputs("rig-missing-tooth", with_control=False, both_loads=False)
    together = inputs("rig-missing-tooth", both_loads=False)
    assert together.keys() - alone.keys() == {"healthy simulate"}


def test_the_loads_and_seeds_share_all_but_the_simulation():
    plan = plan_run(load_scene("rig-missing-tooth"), seeds=2)
    assert [case.label for case in plan.cases] == [
        "", "torque", "error-free", "seed 2", "torque error-free", "torque seed 2"
    ]  # fmt: skip
    kinds = [stage.kind for stage in plan.graph]
    assert (kinds.count("law"), kinds.count("casing-modes"), kinds.count("simulate")) == (3, 1, 12)


def test_seeds_without_a_control_are_refused():
    with pytest.raises(InputError, match=r"--seeds: there is no healthy control to compare with\. Set control"):
        plan_run(load_scene("minimal"), seeds=2)


def test_the_torque_beside_the_rope_is_the_shipped_torque_scene():
    plan = plan_run(load_scene("rig-missing-tooth"))
    stages = {name: plan.graph.steps[name].spec for name in ("torque simulate", "torque healthy simulate")}
    for name, shipped in (
        ("torque simulate", "rig-missing-tooth-torque"),
        ("torque healthy simulate", "rig-healthy-torque"),
    ):
        alone = plan_run(load_scene(shipped), with_control=False).graph.steps["simulate"].spec
        assert digest(stages[name]) == digest(alone)


def test_identical_pairs_have_one_key():
    text = load_scene("rig-healthy")
    same = [
        f"stages.2.{key}={getattr(text.scene.stages[0], key)}" for key in ("pinion_teeth", "wheel_teeth", "module_mm")
    ]
    same += ["stages.2.face_width_mm=12", "stages.2.pinion_bore_mm=25", "stages.2.wheel_bore_mm=35"]
    same += ["stages.2.pinion_hand=right", "stages.2.helix_angle_deg=12", "shafts.3.sections.1.diameter_mm=30"]
    found = inputs("rig-healthy", *same, "casing.model=none", "sensors=[]", with_control=False)
    assert found["law_1"][:2] == found["law_2"][:2]


def test_minimal_has_no_finite_elements_of_the_casing():
    assert list(inputs("minimal")) == ["law_1", "casing", "simulate"]


def test_the_diagnosis_looks_at_the_wheel_of_stage_1():
    settings = make_machine(load_scene("rig-missing-tooth").scene).diagnosis
    assert settings.mesh_frequency == pytest.approx(300.0, rel=1e-12)
    assert settings.revolution_frequency == pytest.approx(300 / 55, rel=1e-12)
    assert settings.shaft == "shaft_2"
    assert settings.rope_mode["lifting"] == pytest.approx(12.3, abs=0.1)


def test_a_window_too_short_for_the_diagnosis_is_told_beforehand():
    fault = 'faults=[{kind="missing-tooth", stage=1, gear="wheel", tooth=0}]'
    short = load_scene("minimal", (fault,)).scene
    told = [
        warning
        for warning in design_warnings(short, make_drivetrain(short))
        if "revolutions of the stage 1 wheel" in warning
    ]
    assert len(told) == 1
    assert "4.9" in told[0]
    long = load_scene("rig-missing-tooth").scene
    assert not [text for text in design_warnings(long, make_drivetrain(long)) if "revolutions" in text]
