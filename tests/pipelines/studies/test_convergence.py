"""The arithmetic of refinement studies, on series whose order and limit are known."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem.casing.uncertainty.frequency_limits import EDGE_ORDER, frequency_limits
from pipelines.cli.command_line import parser
from pipelines.engine.run_graph import Work
from pipelines.scene.load_scene import load_scene
from pipelines.scene.tables.casing import ElasticBase
from pipelines.scene.tables.housing import MatricesHousingTable
from pipelines.studies.trade.convergence import CAUTION, ConvergenceError, study
from pipelines.studies.trade.measured_variants import Measured
from pipelines.studies.trade.probes import Value
from pipelines.studies.trade.refinement import RefinementStudy, modes_of_common_order, refine, unpaired_modes
from pipelines.studies.trade.refinement_axes import AXES, AxisError
from pipelines.studies.trade.refinement_output import (
    CASINGS,
    LABELLED,
    MESH_MODELS,
    convergence_figure,
    not_refined,
    pairing_words,
    tone_and_distance,
    verdict,
)


@given(
    order=st.floats(0.3, 8.0),
    limit=st.floats(-100.0, 100.0),
    factor=st.sampled_from([-1.0, 1.0]),
    ratios=st.tuples(st.floats(1.2, 3.0), st.floats(1.2, 3.0)),
)
def test_a_pure_power_gives_its_order_and_limit(order, limit, factor, ratios):
    h = (1.0, ratios[0], ratios[0] * ratios[1])
    found = study(h, [limit + factor * size**order for size in h])
    assert found.kind == "monotone"
    assert found.order == pytest.approx(order, rel=1e-6)
    assert found.limit == pytest.approx(limit, abs=1e-6 * max(1.0, h[2] ** order))


def test_the_band_holds_the_error_of_every_level_when_a_second_term_disturbs():
    h = (0.25, 0.5, 1.0, 2.0)
    values = [3.0 + 0.1 * size**2 + 0.01 * size**3 for size in h]
    found = study(h, values)
    for value, band in zip(found.values, found.bands, strict=True):
        assert abs(value - 3.0) <= band


def test_the_formal_order_widens_the_band_of_a_lucky_order():
    h = (1.0, 2.0, 4.0)
    values = [1.0 + size**6 for size in h]
    assert study(h, values, formal_order=2.0).bands[0] > 10 * study(h, values).bands[0]


def test_oscillating_and_diverging_values_get_a_cautious_band_and_no_order():
    swing = study((1.0, 2.0, 4.0), (1.0, 1.2, 1.1))
    assert (swing.kind, swing.order) == ("oscillating", None)
    assert swing.bands[0] == pytest.approx(CAUTION * 0.2)
    assert study((1.0, 2.0, 4.0), (1.0, 2.0, 2.5)).kind == "diverging"


def test_what_does_not_change_is_its_own_limit():
    still = study((1.0, 2.0, 4.0), (7.0, 7.0, 8.0))
    assert (still.kind, still.limit, still.bands[0]) == ("unchanged", 7.0, 0.0)


def test_levels_that_say_nothing_are_refused():
    with pytest.raises(ConvergenceError, match="finite"):
        study((1.0, 2.0, 4.0), (1.0, math.nan, 3.0))


def test_a_time_step_study_of_a_scene_finds_the_order_of_the_integrator(tmp_path, monkeypatch):
    monkeypatch.setenv("GEARCASE_CACHE", str(tmp_path))
    short = {"simulation.end_s": 0.2, "diagnosis.windows_s": {"whole": [0.05, 0.2]}}
    loaded = load_scene("minimal", {**short, "simulation.integrator": "trapezoidal", "simulation.step_us": 10.0})
    found = refine(loaded, "step", 3, Work())
    (rms,) = found.quantities.values()
    assert rms.order == pytest.approx(2.0, abs=0.4)
    assert rms.relative_bands[found.in_use] > rms.errors[found.in_use]
    assert "fine enough" in verdict(found, 0.01)
    assert "not shown" in verdict(found, 1e-9)
    axes = convergence_figure("minimal", found).axes[0]
    assert "time step" in axes.get_title(loc="left")
    assert "%" in axes.get_ylabel()


def test_the_tone_of_the_slices_is_the_largest_line_above_the_orders_of_the_mesh():
    cycle = np.arange(256) / 256
    finest = 1.2 * np.cos(2 * np.pi * cycle)
    apart = 0.5 + 0.02 * np.cos(2 * np.pi * cycle) + 0.003 * np.cos(2 * np.pi * 27 * cycle + 1.0)
    tone, distance = tone_and_distance(finest + apart, finest)
    assert tone == pytest.approx(0.003, rel=1e-9)
    assert distance == pytest.approx(np.sqrt((0.02**2 + 0.003**2) / 2), rel=1e-9)


def test_an_axis_that_a_scene_does_not_have_is_refused_with_the_remedy():
    with pytest.raises(AxisError, match=r"casing\.model = 'rigid'.*craig-bampton"):
        refine(load_scene("minimal"), "casing-mesh", 3, Work())


def test_fewer_than_three_levels_are_refused_before_anything_is_computed():
    with pytest.raises(ConvergenceError, match="--levels 2: a convergence study needs 3"):
        refine(load_scene("minimal"), "step", 2, Work())


def test_imported_matrices_have_no_mesh_that_could_be_refined():
    housing = MatricesHousingTable.model_construct(model="matrices")
    casing = ElasticBase.model_construct(housing=housing)
    with pytest.raises(AxisError, match=r"housing\.model = 'matrices'.*Refine the mesh in the program"):
        AXES["casing-mesh"].settings(SimpleNamespace(casing=casing), 1.0)


def test_the_command_offers_the_axes_that_exist():
    (action,) = [a for a in _converge_actions() if a.dest == "over"]
    assert set(action.choices) == set(AXES)


def _converge_actions():
    (commands,) = [a for a in parser()._actions if isinstance(a, argparse._SubParsersAction)]
    return commands.choices["converge"]._actions


def test_a_study_names_what_it_did_not_refine_with_the_size_that_is_known():
    said = not_refined(["plane", "plane"], "rigid", "gear-mesh")
    assert "mesh model plane, too stiff by 2 to 3 %" in said
    assert "slices along the face" in said
    assert "time step" not in said
    assert "casing model rigid, its elasticity is left out" in not_refined(["plane"], "rigid", "step")
    assert "mesh model" not in not_refined(["plane"], "rigid", "casing-mesh")
    alone = not_refined(["plane"], "craig-bampton", "casing-mesh")
    assert "casing model craig-bampton" in alone
    assert "()" not in alone
    assert "other settings" not in alone


def test_every_model_of_a_scene_has_words():
    from fem.casing.models.casing_registry import CASINGS as CASING_MODELS
    from fem.contact.models.mesh_model_registry import MODELS

    assert set(MESH_MODELS) == set(MODELS)
    assert set(CASINGS) == set(CASING_MODELS) - {"matrices"}  # those are chosen by the housing


def level(frequencies, order):
    """A level of a study over casing meshes whose modes stand in another order."""
    x = np.linspace(0.0, 1.0, 40)
    values = [
        Value(name=f"casing mode {n}", unit="Hz", value=frequencies[k], shape=tuple(np.sin((k + 1) * np.pi * x)))
        for n, k in enumerate(order, 1)
    ]
    return Measured(by_probe={"modes": tuple(values)}, seconds={}, peak_bytes=0)


def test_casing_modes_share_an_order_though_they_cross_from_mesh_to_mesh():
    """The errors of edges and of smooth fields together, in the same shares."""
    exact = np.array([300.0, 400.0, 410.0, 600.0])
    sizes = (1 / 1.3, 1.0, 1.3)
    laws = [0.7 * size**EDGE_ORDER + 0.3 * size**4.0 for size in sizes]
    meshes = [exact * (1.0 + 1e-4 * np.array([1.0, 2.0, 1.0, 1.5]) * law) for law in laws]
    levels = [
        level(found, places) for found, places in zip(meshes, ([0, 1, 2, 3], [0, 1, 2, 3], [0, 2, 1, 3]), strict=True)
    ]
    found = modes_of_common_order(sizes, levels, frequency_limits)
    assert list(found) == [f"casing mode {n}" for n in (1, 2, 3, 4)]
    for quantity, limit, mesh in zip(found.values(), exact, np.array(meshes).T, strict=True):
        assert 1.2 < quantity.order < 4.0
        assert quantity.limit - limit == pytest.approx(0.0, abs=1e-3 * (mesh[0] - limit))
        assert quantity.values == pytest.approx(mesh)
        assert (np.array(quantity.bands) > mesh - quantity.limit).all()


def refined(quantities, unpaired=None):
    """A study of the casing mesh over three levels."""
    return RefinementStudy(
        axis="casing-mesh",
        fineness=(1.3, 1.0, 1 / 1.3),
        levels=(),
        quantities=quantities,
        units=dict.fromkeys(quantities, "Hz"),
        unpaired=unpaired or {},
    )


def test_a_level_has_the_same_name_in_table_and_figure():
    found = refined({"casing mode 1": study((1 / 1.3, 1.0, 1.3), (1.0, 1.1, 1.3))})
    names = [label.get_text() for label in convergence_figure("mine", found).axes[0].get_xticklabels()]
    assert names == ["x1.3", "in use", "x0.769"]


def test_modes_without_a_counterpart_are_named_with_their_closest_one():
    """Modes 3 and 4 of the finest level are half one, half the other on the coarsest: neither has a pair of MAC 0.5."""
    exact = np.array([300.0, 400.0, 410.0, 600.0])
    fine, coarse = level(exact, [0, 1, 2, 3]), level(1.01 * exact, [0, 1, 2, 3])
    x = np.linspace(0.0, 1.0, 40)
    third = np.sin(3 * np.pi * x) + 1.2 * np.sin(7 * np.pi * x)
    values = list(coarse.values)
    values[2] = replace(values[2], shape=tuple(third))
    found = unpaired_modes([fine, fine, Measured(by_probe={"modes": tuple(values)}, seconds={}, peak_bytes=0)])
    assert found == {"casing mode 3": pytest.approx(1.0 / (1.0 + 1.2**2), rel=1e-6)}
    one = study((1 / 1.3, 1.0, 1.3), (1.0, 1.1, 1.3))
    words = pairing_words(refined({f"casing mode {n}": one for n in (1, 2, 4)}, found))
    assert "3 of 4 modes have a counterpart on every level. Left out: modes 3 (0.41)." in words
    assert "0.5 or more" in words
    assert pairing_words(refined({"casing mode 1": one})) == "1 of 1 modes have a counterpart on every level."


def test_a_figure_of_many_modes_names_the_worst_and_keeps_its_legend_inside():
    sizes = (1 / 1.3, 1.0, 1.3)
    many = {f"casing mode {n}": study(sizes, [100.0 + 0.01 * n * h**2 for h in sizes]) for n in range(1, 29)}
    figure = convergence_figure("rig", refined(many))
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert [text.split(" (")[0] for text in texts[:LABELLED]] == [f"casing mode {n}" for n in range(29 - LABELLED, 29)]
    assert texts[LABELLED:] == [
        f"{28 - LABELLED} others, with narrower bands",
        "setting in use; dashes: its uncertainty bands",
    ]
    curves = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 3]
    assert len({line.get_color() for line in curves}) == LABELLED + 1
    figure.draw_without_rendering()
    box, whole = legend.get_window_extent(), figure.bbox
    assert box.x0 >= whole.x0
    assert box.x1 <= whole.x1
    assert box.y0 >= whole.y0
