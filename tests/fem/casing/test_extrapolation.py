"""The stiffness of a casing extrapolated to elements of size zero by coarser meshes."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from types import SimpleNamespace

import coarse as quick
import numpy as np
import pytest
from factored_casing import factored
from housings import angle_casing, short_housing

from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import Sizes
from fem.casing.models.meshing import Meshing
from fem.casing.models.stage import CasingError
from fem.casing.reduced.casing_modes import casing_modes, natural_modes, reduced_body
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.reduction import reduce_body
from fem.casing.uncertainty import extrapolation
from fem.casing.uncertainty.cubic_limits import ORDER
from fem.casing.uncertainty.extrapolation import (
    ExtrapolationError,
    LowestModes,
    limits_from,
    lowest_modes,
    measured_limits,
    quadratic_modes,
    stiffness_factor,
)
from fem.casing.uncertainty.frequency_limits import EDGE_ORDER
from fem.casing.uncertainty.limits_by_element import RATIOS, WALLS_OF_TETRAHEDRA
from fem.casing.uncertainty.pairing import sample_nodes
from fem.casing.uncertainty.target_size import target_factor
from fem.elements.materials import CAST_IRON
from pipelines.engine.run_graph import Work
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.report.figures import render
from pipelines.runs.run import run_scene
from pipelines.scene.load_scene import load_scene
from pipelines.scene.presets import preset_on
from pipelines.steps.machine_steps import machine_steps
from pipelines.steps.reporting import _casing_rows

BAND = 3000.0
COUNT = 12


@pytest.fixture(autouse=True, scope="module")
def few_modes():
    """Three times the number that is compared."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(extrapolation, "MODES", 3 * COUNT)
        yield


def modes_of(size: float, ground: str = "fixed"):
    """Mesh and modes of a short housing with elements of one size (m)."""
    mesh = mesh_housing(short_housing(), sizes=Sizes(element=size, bore=size))
    casing = factored(assembled_casing(mesh, CAST_IRON, ground=ground))
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=1.5 * BAND)
    return mesh, casing_modes(casing, reduction, model="craig-bampton", band_limit=1.5 * BAND)


@pytest.fixture(scope="module")
def coarse():
    return modes_of(0.036)


def larger(mesh_size: float, **more):
    """Lowest modes on the meshes whose elements are RATIOS times as large."""
    sizes = [Sizes(element=mesh_size, bore=mesh_size).times(ratio) for ratio in RATIOS]
    return [
        lowest_modes(assembled_casing(mesh_housing(short_housing(), sizes=one), CAST_IRON, **more), static=False)
        for one in sizes
    ]


def same_shapes(modes, *factors):
    """Modes of the same shapes with other frequencies, as on two more meshes."""
    natural = natural_modes(modes)
    basis = modes.basis[sample_nodes(modes.nodes)]
    shapes = (basis.reshape(-1, basis.shape[2]) @ natural.vectors)[:, :COUNT]
    exact = natural.frequencies[:COUNT]
    return [
        LowestModes(
            frequencies=factor * exact,
            shapes=shapes,
            element_size=ratio * modes.element_size,
            unknowns=modes.unknowns,
            element="tetrahedron-10",
        )
        for ratio, factor in zip(RATIOS, factors, strict=True)
    ]


@pytest.mark.parametrize(("largest", "factor"), [(1.0, 1.0), (0.98, 0.97), (0.92, 0.91)])
def test_a_coarser_mesh_has_slightly_smaller_elements_where_the_mesher_fails(monkeypatch, largest, factor):
    fine = Meshing(housing=short_housing(), sizes=Sizes(element=0.036, bore=0.036), element="tetrahedron-10")
    coarser = next(fine.coarser())

    def failing(housing, sizes, element):
        if sizes.element > largest * coarser.sizes.element * (1 + 1e-9):
            raise MeshError("HXT 3D mesh failed")
        return sizes

    monkeypatch.setattr("fem.casing.mesh.choose_mesher.mesh_geometry", failing)
    assert coarser.build().element == pytest.approx(factor * RATIOS[0] * 0.036)


def test_a_coarser_mesh_that_no_size_gives_is_refused_with_keys_that_override_a_preset(monkeypatch):
    def failing(housing, sizes, element):
        raise MeshError("HXT 3D mesh failed")

    fine = Meshing(housing=short_housing(), sizes=Sizes(element=0.036), element="tetrahedron-10")
    monkeypatch.setattr("fem.casing.mesh.choose_mesher.mesh_geometry", failing)
    with pytest.raises(CasingError, match=r"46.8 mm.*HXT 3D mesh failed.*casing.extrapolated = false.*--set"):
        next(fine.coarser()).build()


@pytest.mark.parametrize("share", [0.2, 0.6, 0.95])
def test_an_error_of_edges_and_of_smooth_fields_is_taken_off(coarse, share):
    _, modes = coarse
    error = 0.01  # of the frequencies of a mesh
    fine = replace(modes, stiffness=(1.0 + error) ** 2 * modes.stiffness)
    laws = [share * ratio**EDGE_ORDER + (1.0 - share) * ratio**4.0 for ratio in RATIOS]
    limits = measured_limits(fine, same_shapes(modes, *(1.0 + error * law for law in laws)))
    walls = sum(WALLS_OF_TETRAHEDRA[2]) / 2
    assert stiffness_factor(limits) == pytest.approx((1 / (1.0 + error) - walls) ** 2, rel=1e-3)


def test_a_coarse_casing_comes_closer_to_its_limit(hexahedra):
    """That of hexahedra, made in another way, lies in the bands.

    Not so the flexibility of its seats, whose elements follow the bores: they are finer than the walls already.
    """
    _, modes = modes_of(0.026)
    limits = measured_limits(modes, larger(0.026))
    other = limits_of(*hexahedra, count=len(limits.limits))
    factor = stiffness_factor(limits)
    before, after = (
        abs((natural_modes(modes, stiffness_factor=f).frequencies[: len(other.limits)] / other.limits).mean() - 1.0)
        for f in (1.0, factor)
    )
    assert before > 0.02
    assert after < 0.7 * before
    assert (abs(limits.limits - other.limits) < limits.bands + other.bands).all()


def test_mounts_keep_their_stiffness(coarse):
    mesh, _ = coarse
    casing = factored(assembled_casing(mesh, CAST_IRON, ground="springs"))
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
    limits = measured_limits(modes, larger(0.036, ground="springs"))
    assert 0.8 < stiffness_factor(limits) < 1.0
    assert limits.frequencies[0] > 100.0  # without its six rigid motions


def test_coarser_meshes_that_are_not_stiffer_are_refused(coarse):
    _, modes = coarse
    for factors in ((0.99, 0.98), (1.2, 1.4)):
        with pytest.raises(ExtrapolationError, match=r"0 to 25 %.*element_size_mm"):
            measured_limits(modes, same_shapes(modes, *factors))


def test_the_report_lists_frequencies_with_the_root_of_the_stiffness_factor():
    modes = SimpleNamespace(unknowns=300, solver="Lanczos", band_limit=3000.0)
    checkup = SimpleNamespace(frequencies=np.array([500.0]), mass=1.0, item_names=())
    body = SimpleNamespace(model="craig-bampton", coordinate_names=(), stiffness_factor=0.81)
    rows = {row["property"]: row["value"] for row in _casing_rows(body, (modes, checkup))}
    assert rows["first natural frequencies on its feet, Hz"] == "450.0"
    assert rows["casing.band_Hz, above which modes are missing"] == "2000"


def test_more_meshes_are_made_only_where_they_are_asked_for():
    def names(**settings):
        stages = machine_steps(
            make_machine(load_scene("rig-healthy", {f"casing.{k}": v for k, v in settings.items()}).scene)
        )
        return [stage.name for stage in stages if "casing" in stage.name]

    two = ["coarser casing mesh", "coarser casing", "coarsest casing mesh", "coarsest casing"]
    assert names(extrapolated=False) == ["casing mesh", "casing modes", "casing"]
    assert names(extrapolated=True, element="tetrahedron-10") == ["casing mesh", *two, "casing modes", "casing"]
    for cubic in ("hexahedron-32", "tetrahedron-20"):
        assert names(extrapolated=True, element=cubic) == ["casing mesh", "casing modes", "quadratic casing", "casing"]


def test_elements_whose_error_is_not_told_cannot_be_extrapolated_and_presets_leave_it_out():
    for element, other in (("tetrahedron-4", "tetrahedron-10"), ("hexahedron-20", "hexahedron-32")):
        for key, value in (("extrapolated", True), ("error", "1%")):
            with pytest.raises(
                SceneError, match=f'{key}: .*error of {element} is not estimated. Set element = "{other}'
            ):
                load_scene(
                    "rig-healthy", {"casing.extrapolated": False, "casing.element": element, f"casing.{key}": value}
                )
    settings = {"casing.element": "tetrahedron-4", "casing.extrapolated": False}
    linear = preset_on(load_scene("rig-healthy", settings), "draft")
    assert linear.scene.casing.element == "tetrahedron-4"
    assert not linear.scene.casing.extrapolated


def test_a_mesh_file_is_extrapolated_by_cubic_tetrahedra_alone():
    settings = {"casing.housing.model": "mesh", "casing.extrapolated": True}
    with pytest.raises(SceneError, match=r'one element size only, .* Set element = "tetrahedron-20'):
        load_scene("rig-step", settings)
    assert load_scene("rig-step", settings | {"casing.element": "tetrahedron-20"}).scene.casing.extrapolated


def both_degrees(size: float, element: str) -> list[LowestModes]:
    """Modes of a short housing by cubic and by quadratic displacements on one mesh."""
    cubic = assembled_casing(mesh_geometry(short_housing(), Sizes(element=size), element), CAST_IRON)
    return [lowest_modes(one, static=False) for one in (cubic, cubic.quadratic())]


@pytest.fixture(scope="module")
def hexahedra():
    return both_degrees(0.03, "hexahedron-32")


@pytest.fixture(scope="module")
def tetrahedra():
    return both_degrees(0.045, "tetrahedron-20")


def limits_of(trial, *coarser, count=COUNT):
    return limits_from(trial.frequencies[:count], trial.shapes[:, :count], trial.element_size, coarser)


def test_what_is_taken_off_hexahedra_is_little_and_their_bands_hold_smaller_ones(hexahedra):
    fine, quadratic = hexahedra
    assert 1.4 < fine.unknowns / quadratic.unknowns < 1.8
    limits = limits_of(*hexahedra)
    assert 0.0 < limits.correction < 0.004
    assert limits.median_band_at(1.0) < 0.0025
    smaller = limits_of(*both_degrees(0.024, "hexahedron-32"))
    apart = abs(limits.limits / smaller.limits - 1.0)
    assert (apart <= (limits.bands + smaller.bands) / smaller.limits).all()


def test_what_is_taken_off_tetrahedra_follows_from_quadratic_ones_on_their_mesh(tetrahedra, hexahedra):
    """Hexahedra that follow the stresses at edges, extrapolated, stand for the limit."""
    limits, other = limits_of(*tetrahedra), limits_of(*hexahedra)
    apart = abs(limits.limits / other.limits - 1.0)
    assert (apart <= (limits.bands + other.bands) / other.limits).mean() > 0.9
    assert np.median(apart) < 0.5 * np.median(tetrahedra[0].frequencies[:COUNT] / other.limits - 1.0)


@pytest.mark.parametrize("ground", ["fixed", "springs"])
def test_one_inverse_iteration_from_the_cubic_modes_finds_the_quadratic_ones(ground):
    mesh = angle_casing("hexahedron-32")
    cubic = assembled_casing(mesh, CAST_IRON, ground=ground)
    casing = factored(cubic)
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=60000.0)
    found = quadratic_modes(cubic.quadratic(), cubic.cubic, reduction, static=False)
    exact = lowest_modes(assembled_casing(replace(mesh, cubic=0), CAST_IRON, ground=ground), static=False)
    assert found.frequencies[:COUNT] == pytest.approx(exact.frequencies[:COUNT], rel=1e-5)
    norms = (np.linalg.norm(one.shapes[:, :COUNT], axis=0) for one in (found, exact))
    alike = np.abs(np.einsum("ij,ij->j", found.shapes[:, :COUNT], exact.shapes[:, :COUNT])) / np.prod([*norms], axis=0)
    assert alike.min() > 0.999


@pytest.mark.parametrize("modes", ["tetrahedra", "hexahedra"])
def test_the_size_for_an_error_is_the_one_whose_band_is_predicted_to_have_it(modes, request):
    found = request.getfixturevalue(modes)
    limits = limits_of(*found)
    assert target_factor(limits, 1.01 * limits.median_band_at(1.0), *found) == 1.0
    less = 0.5 * limits.median_band_at(1.0)
    factor = target_factor(limits, less, *found)
    assert limits.median_band_at(factor) <= less < limits.median_band_at(factor + 0.02)
    assert factor == pytest.approx(0.5 ** (1.0 / ORDER), abs=0.02)


def test_an_error_that_no_mesh_or_no_computer_has_is_refused(hexahedra):
    limits = limits_of(*hexahedra)
    with pytest.raises(ExtrapolationError, match=r"casing.error: smaller elements do not reach 0.001 %"):
        target_factor(limits, 1e-5, *hexahedra)
    many = replace(hexahedra[0], unknowns=300_000)
    with pytest.raises(ExtrapolationError, match=r"unknowns \(limit 400,000.*Set [0-9.]+ %, the error") as refused:
        target_factor(limits, 0.5 * limits.median_band_at(1.0), many, hexahedra[1])
    allowed = float(re.search(r"Set ([0-9.]+) %", str(refused.value))[1]) / 100
    assert target_factor(limits, allowed, many, hexahedra[1]) < 1.0


def test_an_error_asked_for_makes_a_trial_and_says_what_it_takes():
    machine = make_machine(load_scene("rig-healthy", {"casing.error": "0.2%"}).scene)
    names = [stage.name for stage in machine_steps(machine) if "casing" in stage.name]
    trial = ["trial casing mesh", "trial casing", "quadratic casing, trial"]
    assert names == [*trial, "casing mesh", "casing modes", "quadratic casing", "casing"]
    machine = make_machine(load_scene("rig-step", {"casing.element": "tetrahedron-10", "casing.error": "2%"}).scene)
    names = [stage.name for stage in machine_steps(machine) if "casing" in stage.name]
    assert names[-5:] == ["trial casing mesh", "trial casing", "casing mesh", "casing modes", "casing"]
    for text in ("0%", "9%", "fine"):
        with pytest.raises(SceneError, match="error"):
            load_scene("rig-healthy", {"casing.error": text})


def test_a_run_with_an_extrapolated_casing_writes_its_factor_into_the_report(tmp_path, monkeypatch):
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-c", "pass"])  # pictures are tested elsewhere
    settings = quick.coarse("bench", end=0.02) | {"casing.element": "hexahedron-32", "casing.extrapolated": True}
    scene = load_scene("bench", settings)
    finished = run_scene(scene, out=tmp_path / "out", with_control=False, work=Work(processes=1))
    assert "factor on the casing stiffness" in (finished.folder / "report.html").read_text(encoding="utf-8")
