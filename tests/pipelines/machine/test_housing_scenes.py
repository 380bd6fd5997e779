"""Housings of scenes: what the keys become, files beside a scene, sizes from the band, refusals with the path."""

import shutil
from importlib import resources

import numpy as np
import pytest

from fem.casing.geometry.housing import Housing
from fem.casing.geometry.locators import ByGroup
from fem.casing.mesh.imported_housing import ImportedHousing, content_hash
from fem.casing.mesh.sizes import bending_wavelength
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.steps.machine_steps import casing_step, machine_steps

FEATURES = {
    "casing.housing.side_wall_thickness_mm": 12.0,
    "casing.housing.foot_pitch_mm": 70.0,
    "casing.housing.foot_overhang_mm": 25.0,
    "casing.housing.flange": {"width_mm": 15.0, "height_mm": 16.0, "split_plane_mm": 55.0},
    "casing.housing.ribs": {"thickness_mm": 8.0, "height_mm": 10.0, "per_boss": 1},
    "casing.housing.inner_fillet_mm": 5.0,
}


def made(name, settings=()):
    scene = load_scene(name, settings).scene
    return make_machine(scene).structure.housing


def stages(name, settings=()):
    loaded = load_scene(name, settings)
    return {stage.name: stage for stage in machine_steps(make_machine(loaded.scene, loaded.source.shown))}


def test_a_scene_without_the_new_keys_has_a_plain_housing():
    box = made("rig-healthy")
    assert isinstance(box, Housing)
    assert box.plain
    assert len(box.feet.x) == 3


def test_the_keys_of_the_parametric_housing():
    box = made("minimal", FEATURES)
    assert not box.plain
    assert (box.wall("side"), box.wall("end")) == (0.012, 0.010)
    assert box.flange.split == 0.055
    assert box.fillets.inner == 0.005
    gaps = np.diff(box.feet.x)
    assert len(box.feet.x) == 4  # 194 mm between the outer feet: three gaps of at most 70 mm
    assert gaps.max() <= 0.070
    assert np.ptp(gaps) < 1e-12


def test_the_rigid_model_takes_the_mesh_of_a_housing_that_is_no_plain_box():
    assert "casing mesh" not in stages("minimal")
    assert stages("minimal", FEATURES)["casing"].takes == {"mesh": "casing mesh"}


def test_element_size_from_the_bending_wavelength():
    size = {
        n: stages("rig-healthy", {"casing.elements_per_wavelength": n})["casing mesh"].spec.sizes.element
        for n in (3, 8)
    }
    scene = load_scene("rig-healthy").scene
    wave = bending_wavelength(scene.casing.material.made(name="casing"), 0.010, scene.casing.band_Hz)
    assert size[3] == 0.028  # no larger than casing.element_size_mm
    assert size[8] == pytest.approx(wave / 8)
    wave = bending_wavelength(scene.casing.material.made(name="casing"), 0.008, 2000.0)  # its cover
    found = stages("rig-step", {"casing.elements_per_wavelength": 8})["casing mesh"].spec.sizes.element
    assert found == pytest.approx(wave / 8)


def test_the_shipped_step_file_is_found_and_placed_by_the_shafts():
    box = made("rig-step")
    assert isinstance(box, ImportedHousing)
    assert [seat.name for seat in box.seats] == [f"bearing_{n}" for n in range(1, 9)]
    assert box.seats[4].shaft_point[0] == pytest.approx(0.18274, abs=1e-5)
    assert len(box.sensors) == 9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("rig-healthy", {}),
        ("rig-step", {}),
        ("rig-step", {"casing.ground": "springs", "casing.mounts_N_per_um": [[100.0, 100.0, 200.0]]}),
        ("minimal", {"casing.model": "craig-bampton", "casing.element_size_mm": 20.0, "casing.band_Hz": 5000.0}),
    ],
    ids=["rig", "step", "step on springs", "minimal"],
)
def test_every_shipped_housing_passes_the_check_up_and_keeps_its_error(name, settings, tmp_path):
    """With the default reduction: frequencies to 0.1 %, responses of every pair to 6 % in every third octave."""
    loaded = load_scene(name, settings)
    machine = make_machine(loaded.scene, loaded.source.shown)
    check = machine.casing.error_check(machine.structure, loaded.scene.casing.band_Hz)
    graph = Graph([*machine_steps(machine), casing_step(check)])
    outcome = run_graph(graph, Cache(tmp_path), ["casing modes", "casing error"], processes=1)
    modes, check, *_ = outcome.value("casing modes")
    assert check.failures == ()
    assert modes.counted == modes.mode_set.n_fixed > 20
    error = outcome.value("casing error")
    assert len(error.full_frequencies) > 10
    assert abs(error.frequency_errors).max() < 1e-3
    assert error.response_errors.max() < 0.06


def test_a_file_lies_beside_its_scene(tmp_path):
    shutil.copy(str(resources.files("meshes") / "rig-housing.step"), tmp_path / "mine.step")
    scene = tmp_path / "my.toml"
    scene.write_text('extends = "rig-step"\n[casing.housing]\nfile = "mine.step"\n', encoding="utf-8")
    assert made(scene).path == str((tmp_path / "mine.step").resolve())
    scene.write_text('extends = "rig-step"\n[casing.housing]\nfile = "rig-housng.step"\n', encoding="utf-8")
    with pytest.raises(SceneError, match=r"no such file\. Did you mean rig-housing\.step"):
        made(scene)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["casing.housing.unit=ft"], "unit.*must be one of"),
        (["casing.housing.bearings=[{name='bearing_1', group='B1'}]"], "no seat for bearing_2, bearing_3, "),
        (["casing.housing.bearings.1.name=bearing_9"], "there is no bearing bearing_9"),
        (["casing.housing.bearings.1.name=bearing_2"], "bearing_2 occurs 2 times"),
        (["casing.housing.bearings.1={name='bearing_1', through_mm=[0.0, -135.0, 0.0]}"], "by through_mm. Set"),
        (["casing.housing.grounds=[{normal=[0, 0, 1]}]"], "is located by normal. Set point_mm, or box_mm"),
        (["casing.housing.axes=[[1, 0, 0], [0.5, 1, 0], [0, 0, 1]]"], "not orthogonal"),
        (["casing.housing.length_mm=600"], "length_mm"),
        (["sensors.1.axes=[[1, 0, 0], [1, 1, 0], [0, 0, 1]]"], "sensors.1: axes = .* they are not orthogonal"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_with_its_path(settings, message):
    with pytest.raises(SceneError, match=message):
        stages("rig-step", settings)


def test_a_mesh_file_and_its_groups_by_keys(tmp_path):
    file = tmp_path / "housing.inp"
    file.write_text("", encoding="utf-8")
    bearings = [{"name": f"bearing_{n}", "group": f"SEAT_{n}"} for n in range(1, 9)]
    table = {"model": "mesh", "file": str(file), "upgrade": True, "grounds": [{"group": "FEET"}], "bearings": bearings}
    box = made("rig-step", {f"casing.housing.{key}": value for key, value in table.items()})
    assert box.upgrade
    assert box.grounds == (ByGroup(group="FEET"),)


def test_axes_of_a_sensor_get_unit_length():
    sensor = made("rig-step", ["sensors.1.axes=[[0, 2, 0], [-3, 0, 0], [0, 0, 1]]"]).sensors[0]
    assert sensor.axes == ((0, 1, 0), (-1, 0, 0), (0, 0, 1))


def test_every_shipped_file_is_listed_with_its_hash():
    folder = resources.files("meshes")
    page = (folder / "README.md").read_text(encoding="utf-8")
    shipped = [p for p in folder.iterdir() if p.name.endswith((".step", ".msh"))]
    assert shipped
    assert all(p.name in page and content_hash(p) in page for p in shipped)
