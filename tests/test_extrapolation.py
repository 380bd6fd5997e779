"""The stiffness of a casing extrapolated to elements of size zero by a second, coarser mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from housings import small_housing

from fem.casing.meshing.mesher import mesh_housing
from fem.casing.meshing.sizes import Sizes
from fem.casing.reduced.extrapolation import (
    ORDER,
    RATIO,
    ExtrapolationError,
    LowestFrequencies,
    lowest_frequencies,
    stiffness_factor,
)
from fem.casing.reduced.grounded import ground_casing
from fem.casing.reduced.modes import casing_modes, natural_modes, reduced_body
from fem.casing.reduced.reduction import reduce_body
from fem.elements.materials import CAST_IRON
from pipelines.border.errors import SceneError
from pipelines.plant.plant import make_plant
from pipelines.scene.file import load_scene
from pipelines.scene.presets import preset_on
from pipelines.steps.graph import plant_steps

BAND = 1500.0
COUNT = 12


def modes_of(size: float, ground: str = "fixed"):
    """Mesh and modes of a small housing with elements of one size (m)."""
    mesh = mesh_housing(small_housing(), sizes=Sizes(element=size, bore=size))
    casing = ground_casing(mesh, CAST_IRON, ground=ground)
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=1.5 * BAND)
    return mesh, casing_modes(casing, reduction, model="craig-bampton", band_limit=1.5 * BAND)


@pytest.fixture(scope="module")
def coarse():
    return modes_of(0.036)


@pytest.fixture(scope="module")
def half_as_coarse():
    return modes_of(0.018)


def larger(mesh_size: float, **more):
    """Frequencies on the mesh whose elements are RATIO times as large."""
    sizes = Sizes(element=mesh_size, bore=mesh_size).times(RATIO)
    return lowest_frequencies(mesh_housing(small_housing(), sizes=sizes), CAST_IRON, static=False, **more)


def test_an_error_of_the_assumed_order_is_taken_off_completely(coarse):
    _, modes = coarse
    exact = natural_modes(modes, stiffness_factor=1.0).frequencies[:20]
    error = 0.03  # of the frequencies of a mesh, which a mesh of RATIO times the size has RATIO^ORDER times
    fine = replace(modes, stiffness=(1.0 + error) ** 2 * modes.stiffness)
    found = stiffness_factor(fine, LowestFrequencies(frequencies=(1.0 + RATIO**ORDER * error) * exact))
    assert found == pytest.approx((1.0 + error) ** -2, rel=1e-12)


def test_a_coarse_casing_comes_closer_to_one_with_elements_half_as_large(coarse, half_as_coarse):
    """Both extrapolated: closer in frequencies and in the flexibility of the seats, though the seats fix their mesh."""
    (_, one), (_, other) = coarse, half_as_coarse
    factors = stiffness_factor(one, larger(0.036)), stiffness_factor(other, larger(0.018))
    assert factors[0] < factors[1] < 1.0
    raw = [natural_modes(modes).frequencies[:COUNT] for modes in (one, other)]
    better = [
        natural_modes(modes, stiffness_factor=f).frequencies[:COUNT]
        for modes, f in zip((one, other), factors, strict=True)
    ]
    before, after = (abs((a / b).mean() - 1.0) for a, b in (raw, better))
    assert before > 0.02
    assert after < 0.7 * before
    seats = [np.linalg.inv(modes.stiffness).diagonal()[: len(modes.interface_names)] for modes in (one, other)]
    before = abs((seats[0] / seats[1]).mean() - 1.0)
    after = abs((seats[0] / seats[1]).mean() * factors[1] / factors[0] - 1.0)
    assert after < 0.8 * before


def test_mounts_keep_their_stiffness(coarse):
    mesh, _ = coarse
    casing = ground_casing(mesh, CAST_IRON, ground="springs")
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=1.5 * BAND)
    modes = casing_modes(casing, reduction, model="craig-bampton", band_limit=1.5 * BAND)
    soft = ((1e4, 1e4, 1e4),)
    whole, less = (reduced_body(modes, mounts=soft, stiffness_factor=f) for f in (1.0, 0.9))
    assert less.stiffness_factor == 0.9
    bounce = [natural_modes(modes, soft, stiffness_factor=f).frequencies for f in (1.0, 0.9)]
    assert bounce[1][:6] == pytest.approx(bounce[0][:6], rel=1e-4)  # rigid motion on soft mounts
    assert bounce[1][8] == pytest.approx(np.sqrt(0.9) * bounce[0][8], rel=1e-3)  # the casing itself
    springs = modes.springs(soft)
    place = np.arange(len(springs))
    assert np.diag(whole.stiffness)[place] - springs == pytest.approx(
        (np.diag(less.stiffness)[place] - springs) / 0.9, rel=1e-9
    )
    assert 0.8 < stiffness_factor(modes, larger(0.036, ground="springs")) < 1.0  # without its six rigid motions


def test_a_coarser_mesh_that_is_not_stiffer_is_refused(coarse):
    _, modes = coarse
    own = natural_modes(modes).frequencies[:20]
    for frequencies in (0.98 * own, 1.4 * own):
        with pytest.raises(ExtrapolationError, match=r"0 to 25 %.*element_size_mm"):
            stiffness_factor(modes, LowestFrequencies(frequencies=frequencies))


def test_a_second_mesh_is_made_only_where_it_is_asked_for():
    names = {}
    for settings in ({}, {"casing.extrapolated": True}):
        stages = plant_steps(make_plant(load_scene("rig-healthy", settings).scene))
        names[bool(settings)] = [stage.name for stage in stages if "casing" in stage.name]
    assert names[False] == ["casing mesh", "casing modes", "casing"]
    assert names[True] == ["casing mesh", "coarser casing mesh", "coarser casing", "casing modes", "casing"]


def test_linear_elements_cannot_be_extrapolated_and_presets_leave_it_out():
    settings = {"casing.element": "tetrahedron-4", "casing.extrapolated": True}
    with pytest.raises(SceneError, match="its order was measured with tetrahedron-10, not with tetrahedron-4"):
        load_scene("rig-healthy", settings)
    linear = preset_on(load_scene("rig-healthy", {"casing.element": "tetrahedron-4"}), "draft")
    assert linear.scene.casing.element == "tetrahedron-4"
    assert not linear.scene.casing.extrapolated


def test_a_mesh_file_cannot_be_extrapolated():
    settings = {"casing.housing.model": "mesh", "casing.extrapolated": True}
    with pytest.raises(SceneError, match="one element size only"):
        load_scene("rig-step", settings)
