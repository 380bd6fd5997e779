"""The typical population: only parts that a scene has, medians of the scene, keys of the plan first."""

import numpy as np
import pytest

from benchmarks.feature_table import POPULATION, population_page
from pipelines.datasets.plan import load_plan, stored_plan
from pipelines.datasets.scenes import sampled_scenes, scene_of
from pipelines.datasets.typical_spread import SPREADS

HEAD = 'scene = "bench"\nscenes = 200\nspread = "typical"\ndesign = "latin-hypercube"\n[variables]\n'


def plan(tmp_path, settings="faults = []\n", head=HEAD):
    (tmp_path / "plan.toml").write_text(f"{head}[settings]\n{settings}", encoding="utf-8")
    return load_plan(tmp_path / "plan.toml")


def scenes(loaded):
    return [scene_of(loaded, one.values).scene for one in sampled_scenes(loaded)]


def test_machines_differ_in_gears_bearings_casing_and_load_around_the_scene(tmp_path):
    found = scenes(plan(tmp_path))
    assert len({one.deviations.seed for one in found}) > 195
    assert {one.deviations.iso_grade for one in found} == {3, 4, 5}
    for values, middle, deviation in (
        ([one.bearings.radial_stiffness_N_per_um for one in found], 100.0, 0.3),
        ([one.casing.damping_ratio for one in found], 0.01, 0.5),
    ):
        assert np.median(values) == pytest.approx(middle, rel=0.02)
        assert np.log(values).std() == pytest.approx(deviation, rel=0.05)
    assert np.std([one.load.torque_N_m for one in found]) == pytest.approx(5.0, rel=0.05)
    ratios = {round(one.bearings.axial_stiffness_N_per_um / one.bearings.radial_stiffness_N_per_um, 9) for one in found}
    assert ratios == {0.4}  # one variable: a stiffer bearing is stiffer in all directions
    assert not any(one.faults for one in found)


def test_rolling_bearings_slip_so_that_lines_of_spalls_are_broad(tmp_path):
    text = 'extends = "bench"\nbearings = { model = "hertz", designation = "6206" }\n'
    (tmp_path / "hertz.toml").write_text(text, encoding="utf-8")
    on_hertz = plan(tmp_path, head=HEAD.replace('"bench"', '"hertz.toml"'))
    slips = [one.bearings.cage_slip for one in scenes(on_hertz)]
    assert min(slips) >= 0.005
    assert max(slips) <= 0.02
    assert np.ptp(slips) > 0.014


def test_a_key_of_the_plan_is_not_varied_and_one_of_the_scene_that_is_missing_neither(tmp_path):
    fixed = plan(tmp_path, "faults = []\ndeviations.iso_grade = 6\nload.torque_N_m = 80.0\n")
    assert {(one.deviations.iso_grade, one.load.torque_N_m) for one in scenes(fixed)} == {(6, 80.0)}
    assert not {"spread_grade", "spread_load", "spread_slip", "spread_mounts"} & fixed.table.variables.keys()


def test_the_stored_plan_gives_the_same_machines(tmp_path):
    loaded = plan(tmp_path)
    stored = stored_plan(
        {"name": "plan", "facts": {"plan": loaded.table.model_dump(mode="json", by_alias=True), "scene": loaded.tree}}
    )
    assert [one.values for one in sampled_scenes(stored)] == [one.values for one in sampled_scenes(loaded)]


def test_a_misspelled_population_is_refused(tmp_path):
    with pytest.raises(ValueError, match="spread"):
        plan(tmp_path, head=HEAD.replace("typical", "typcal"))


def test_the_page_has_the_table_of_all_properties():
    page = POPULATION.read_text(encoding="utf-8")
    assert page == population_page(page), "run: python -m benchmarks.feature_table"
    assert all(one.source in page for one in SPREADS)
