"""Scenes with gear details, modifications and faults: signs, variants, stages, refusals and warnings."""

import numpy as np
import pytest

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.faults.chipped_tooth import ChippedTooth
from fem.contact.faults.cracked_tooth import CrackedTooth
from fem.contact.faults.worn_tooth import WornTooth
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.checks.design_warnings import design_warnings
from pipelines.machine.layout import lay_out
from pipelines.machine.machine_conversion import make_drivetrain, make_machine
from pipelines.machine.tooth_terms import clearances, mesh_faults
from pipelines.scene.load_scene import load_scene
from pipelines.steps.machine_steps import machine_steps

DETAILS = """
extends = "minimal"
[deviations]
include = ["pitch", "profile", "helix"]
[[faults]]
kind = "cracked-tooth"
stage = 1
gear = "wheel"
tooth = 3
depth_mm = 1.2
extent_mm = 5.0
end = "-y"
[[faults]]
kind = "worn-tooth"
stage = 1
gear = "wheel"
tooth = 3
depth_um = 4.0
[[faults]]
kind = "chipped-tooth"
stage = 1
gear = "pinion"
tooth = 7
extent_mm = 4.0
depth_mm = 2.0
[[faults]]
kind = "worn-tooth"
stage = 1
gear = "pinion"
depth_um = 3.0
place = "pitch"
width_mm = 2.0
"""


@pytest.fixture
def detailed(tmp_path):
    path = tmp_path / "detailed.toml"
    path.write_text(DETAILS, encoding="utf-8")
    return load_scene(path).scene


def minimal(*settings):
    return load_scene("minimal", settings).scene


def test_details_of_both_gears_reach_the_geometry():
    scene = minimal(
        "stages.1.pinion.thickness_allowance_um=-40",
        "stages.1.wheel.tip_chamfer_mm=0.1",
        "stages.1.wheel.rim_thickness_mm=5",
        "stages.1.wheel.web_thickness_mm=4",
        "stages.1.pinion.rack_addendum=1.1",
        "stages.1.centre_distance_mm=76.75",
    )
    pair = lay_out(scene).pairs[0]
    assert pair.axis_distance == 0.07675
    assert lay_out(scene).axes[1][0] == pytest.approx(0.07675)
    assert pair.pinion.thickness_allowance == -40e-6
    assert pair.wheel.tip_chamfer == 1e-4
    assert (pair.wheel.rim_thickness, pair.wheel.web_thickness) == (5e-3, 4e-3)
    assert (pair.pinion.rack.addendum, pair.wheel.rack.addendum) == (1.1, 1.0)
    assert pair.backlash_allowance == 0.0 < pair.backlash


@pytest.mark.parametrize(
    ("settings", "backlash"),
    [((), 80e-6), (("stages.1.backlash_um=50",), 50e-6), (("stages.1.centre_distance_mm=76.75",
      "stages.1.backlash_um=90"), 90e-6)],
)  # fmt: skip
def test_a_given_backlash_is_the_whole_of_it(settings, backlash):
    assert lay_out(minimal(*settings)).pairs[0].backlash == pytest.approx(backlash, rel=1e-9)


def test_less_backlash_than_the_centre_distance_leaves_is_refused():
    with pytest.raises(SceneError, match="is less than the"):
        lay_out(minimal("stages.1.centre_distance_mm=76.9", "stages.1.backlash_um=10"))


def test_ends_of_the_face_turn_with_the_lifting_sense():
    """The law's y follows the rotation of the driving gear: +y on shaft 1, -y on shaft 2."""
    keys = ("end_relief_plus_y.amount_um=5", "end_relief_plus_y.length_mm=2", "helix_slope_um=3")
    settings = [f"stages.{n}.wheel.{key}" for n in (1, 2) for key in keys]
    settings += [f"stages.{n}.misalignment.out_of_plane_um=6" for n in (1, 2)]
    layout = lay_out(load_scene("rig-healthy", settings).scene)
    first, second = layout.modifications[:2]
    assert first.wheel.end_relief_high.amount == second.wheel.end_relief_low.amount == 5e-6
    assert first.wheel.end_relief_low is second.wheel.end_relief_high is None
    assert (first.wheel.helix_slope, second.wheel.helix_slope) == (3e-6, -3e-6)
    assert first.misalignment.out_of_plane == pytest.approx(6e-6 / 12e-3)
    assert second.misalignment.out_of_plane == pytest.approx(-6e-6 / 18e-3)
    assert layout.modifications[2].none


def test_faults_become_variants_clearances_and_common_wear(detailed):
    machine = make_machine(detailed)
    (flanks,), (mesh,) = machine.flanks, machine.parts.meshes
    assert flanks.wheel_damage == (
        (
            CrackedTooth(depth=1.2e-3, angle=np.radians(70.0), extent=5e-3, end="-y"),
            WornTooth(depth=4.0 / 1_000_000),
        ),
    )
    assert flanks.pinion_damage == ((ChippedTooth(extent=4e-3, depth=2e-3),),)
    assert flanks.pinion_wear == (WornTooth(depth=3.0 / 1_000_000, place="pitch", width=2e-3),)
    assert (mesh.pinion.damaged, mesh.wheel.damaged) == ((7,), (3,))
    assert np.flatnonzero(mesh_faults(mesh)[1][:, -1]).tolist() == [3]
    teeth = clearances(mesh.pair, mesh.pinion, mesh.wheel)
    assert teeth["coast_clearance_pinion"].shape == (20, 6)
    assert teeth["drive_clearance_pinion"][7, -1] == 1
    assert np.ptp(teeth["drive_clearance_wheel"][:, 3]) > 1e-6  # helix slopes
    assert [fault.name for fault in machine.faults][2:] == ["chipped-tooth 7", "worn-tooth, all teeth"]


def test_pitch_deviations_stay_when_profile_and_helix_join(detailed):
    plain, mesh = (make_machine(scene).parts.meshes[0] for scene in (minimal(), detailed))
    pair = mesh.pair
    alone = clearances(pair, plain.pinion, plain.wheel)["drive_clearance_wheel"]
    assert alone.shape == (55,)
    joined = clearances(pair, mesh.pinion, mesh.wheel)["drive_clearance_wheel"]
    middle = (pair.xi_start + pair.xi_end) / 2
    assert joined[:, 0] + joined[:, 1] * middle + joined[:, 2] * middle**2 == pytest.approx(alone, abs=1e-15)


def test_only_what_is_there_adds_a_stage(detailed, tmp_path):
    assert [s.name for s in machine_steps(make_machine(minimal())) if "law" in s.name] == ["law_1"]
    machine = make_machine(detailed)
    graph = Graph(machine_steps(machine))
    assert list(graph.steps)[:2] == ["unmodified_law_1", "law_1"]
    sound, law = (
        run_graph(graph, Cache(tmp_path / "cache"), ["unmodified_law_1", "law_1"]).value(name)[0]
        for name in ("unmodified_law_1", "law_1")
    )
    assert (law.pinion_variant_gap.shape[0], law.wheel_variant_gap.shape[0]) == (1, 1)
    assert (law.wheel_variant_compliance > 0).any()
    reached = np.isfinite(sound.gap)
    assert (law.gap[reached] - sound.gap[reached]).max() == pytest.approx(3e-6, rel=1e-3)
    cycle = np.linspace(2.0, 4.0, 21)
    _, wheel = mesh_faults(machine.parts.meshes[0])
    soft = LawEvaluator(law).evaluate(cycle, 8e-6, 0.0, None, wheel).force
    assert (soft < LawEvaluator(law).evaluate(cycle, 8e-6).force + 1e-9).all()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("stages.1.pinion.tip_relief.amount_um=5",), "either length_mm or diameter_mm. Set one"),
        (("stages.1.pinion.tip_relief.amount_um=5", "stages.1.pinion.tip_relief.length_mm=30"), "active profile"),
        (("stages.1.pinion.rim_thickness_mm=2",), r"1\.2 modules"),
        (("deviations.include=[\"profile\"]", "stages.1.face_width_mm=3"), "4 to 1200 mm"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_with_its_place(settings, message):
    with pytest.raises(SceneError, match=message):
        checked_machine(minimal(*settings), "minimal")


def test_a_crack_through_the_tooth_is_refused_with_its_place(tmp_path):
    path = tmp_path / "deep.toml"
    path.write_text(DETAILS.replace("depth_mm = 1.2", "depth_mm = 3.9"), encoding="utf-8")
    with pytest.raises(SceneError, match=r"faults\.1.*tooth root thickness"):
        checked_machine(load_scene(path).scene, "deep")


def test_warnings_of_a_designer():
    scene = minimal("stages.1.pinion_teeth=12", "stages.1.pinion_bore_mm=14", "stages.1.mesh.slices=5")
    undercut = design_warnings(scene, make_drivetrain(scene))
    assert any("undercut" in text and "eps_alpha" in text for text in undercut)
    faulty = load_scene("rig-missing-tooth", ("deviations.iso_grade=9", "faults.1.kind=missing-tooth")).scene
    assert any("may hide the fault" in text for text in design_warnings(faulty, make_drivetrain(faulty)))
    shipped = load_scene("rig-missing-tooth").scene
    assert not any("may hide the fault" in text for text in design_warnings(shipped, make_drivetrain(shipped)))
