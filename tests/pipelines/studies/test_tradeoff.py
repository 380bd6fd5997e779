"""The trade of a scene: errors are against the reference, the front is what nothing beats, presets change fineness."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace

import pytest

from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError, SceneError
from pipelines.scene import presets
from pipelines.scene.load_scene import load_scene
from pipelines.scene.presets import LEVELS, PRESETS, load_requested, preset_on, replaced
from pipelines.studies.trade import tradeoff
from pipelines.studies.trade import tradeoff_choices as choices_module
from pipelines.studies.trade.measured_variants import Measured, step_costs
from pipelines.studies.trade.probes import DECIBEL, Value
from pipelines.studies.trade.tradeoff import differences, trade
from pipelines.studies.trade.tradeoff_choices import choices
from pipelines.studies.trade.tradeoff_output import answers, trade_figure, trade_table

SHORT = {
    "simulation.end_s": 0.15,
    "diagnosis.windows_s": {"whole": [0.05, 0.15]},
    "faults": [],
}


STEPS_US = {"draft": 60.0, "standard": 50.0, "reference": 20.0}  # none of those that are tried one by one, but 50
COARSE = {
    preset: replace(level, refinement=0.6, slices=9, step_us=STEPS_US[preset]) for preset, level in LEVELS.items()
}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """All kinds of choices on coarse laws; the motion of generalised-alpha is said to take years."""

    def said(*arguments, **options):
        return step_costs(*arguments, **options) | {"generalised-alpha": 1e6}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(presets, "LEVELS", COARSE)
        patch.setattr(choices_module, "MESHES", {"iso": {"model": "iso"}, "plane": {"model": "plane", "slices": 9}})
        patch.setattr(tradeoff, "step_costs", said)
        return trade(load_scene("minimal", SHORT), Work(cache=Cache(tmp_path_factory.mktemp("cache")), processes=1))


def test_a_machine_without_load_is_refused_before_computing():
    with pytest.raises(InputError, match=r"pair: .* need a load\. Set one, such as --set load\.torque_N_m=50\."):
        trade(load_scene("pair"), None)


@pytest.mark.slow
def test_the_reference_has_no_error_and_stands_on_the_front(found):
    first = found.priced[0]
    assert (first.choice.name, first.error, first.dominated) == ("preset: reference", 0.0, False)
    assert all(error == 0.0 for error in first.errors.values())


@pytest.mark.slow
def test_a_coarser_step_errs_more(found):
    steps = {p.choice.label: p for p in found.priced if p.choice.effect == "step"}
    assert 0.0 < steps["33.4 us"].error < steps["100 us"].error


@pytest.mark.slow
def test_what_is_sure_to_be_beaten_is_not_run_and_named(found):
    assert list(found.refused) == ["integrator: generalised-alpha"]
    assert any("generalised-alpha is left out" in line for line in answers(found, 0.02, 1.0))


@pytest.mark.slow
def test_nothing_beats_what_is_on_the_front(found):
    for one in found.front:
        assert not any(p.seconds < one.seconds and p.error < one.error for p in found.priced)
    for one in found.priced:
        if one.dominated and not math.isnan(one.error):
            assert any(p.seconds <= one.seconds and p.error <= one.error for p in found.front)


def test_a_choice_with_truer_lines_of_the_fault_is_not_beaten_by_a_truer_rms():
    cheap, true = (22.0, 0.19, 5.9), (29.0, 0.22, 0.9)
    assert not tradeoff._beaten(true, [cheap])
    assert not tradeoff._beaten(cheap, [true])
    assert tradeoff._beaten(true, [(29.0, 0.21, 0.9)])
    assert not tradeoff._beaten(true, [true])
    assert tradeoff._beaten((22.0, math.nan, 0.0), [true])


def test_values_are_compared_by_ratio_and_levels_by_difference():
    def measured(force, level):
        values = Value(name="force", unit="N", value=force), Value(name="level", unit=DECIBEL, value=level)
        return Measured(by_probe={value.name: (value,) for value in values}, seconds={}, peak_bytes=0)

    errors = differences(measured(210.0, -37.0), measured(200.0, -40.0))
    assert errors == {"force": pytest.approx(0.05), "level": pytest.approx(3.0)}


@pytest.mark.slow
def test_the_answers_name_the_cheapest_and_the_most_accurate(found):
    cheap, exact = found.cheapest(0.02), found.most_accurate(1e6)
    assert cheap.error <= 0.02
    assert exact.choice.name == "preset: reference"
    words = answers(found, 0.02, 1e-9)
    assert cheap.choice.name in words[0]
    assert "No choice takes" in words[1]


@pytest.mark.slow
def test_the_plot_names_its_axes_every_choice_and_the_front(found):
    axes = trade_figure(found).axes[0]
    assert "minimal" in axes.get_title(loc="left")
    assert axes.get_xlabel().endswith("s")
    assert "%" in axes.get_ylabel()
    written = [text.get_text() for text in axes.texts]
    shown = [p for p in found.priced if not math.isnan(p.error)]
    assert len(written) == len(shown)
    assert all(any(p.choice.label in text for text in written) for p in shown)
    assert any("front" in text.get_text() for text in axes.get_legend().get_texts())
    assert len(trade_table(found).rows) == len(found.priced)


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_changes_only_how_finely_a_scene_is_computed(preset):
    plain, fine = load_scene("rig-missing-tooth").scene, preset_on(load_scene("rig-missing-tooth"), preset).scene
    for part in ("faults", "drive", "load", "shafts", "bearings", "deviations", "sensors"):
        assert getattr(plain, part) == getattr(fine, part)
    assert plain.casing.housing == fine.casing.housing


def test_a_band_in_a_file_of_the_user_overrides_the_preset(tmp_path, capsys):
    """Of shipped scenes and of defaults a preset reduces the band, as its figures were measured."""
    mine, variant, plain = (tmp_path / f"{name}.toml" for name in ("mine", "variant", "plain"))
    mine.write_text('extends = "rig-healthy"\ncasing = { band_Hz = 3000.0 }\nsimulation = { step_us = 30.0 }\n')
    variant.write_text('extends = "mine.toml"\ntitle = "variant"\n')
    plain.write_text('extends = "rig-healthy"\ntitle = "plain"\n')
    shipped = load_scene("rig-healthy").scene.casing.band_Hz
    for path, band in ((mine, 3000.0), (variant, 3000.0), (plain, 0.7 * shipped)):
        found = preset_on(load_scene(path), "standard").scene
        assert (found.casing.band_Hz, found.simulation.step_us) == (pytest.approx(band), 50.0)
    found = preset_on(load_scene(mine, ["casing.band_Hz=1000"]), "standard").scene
    assert found.casing.band_Hz == 1000.0
    load_requested(argparse.Namespace(scene=str(mine), settings=[], preset="standard", quiet=False))
    said = capsys.readouterr().err
    assert "simulation.step_us 30 -> 50" in said
    assert "band_Hz" not in said
    load_requested(argparse.Namespace(scene=str(plain), settings=[], preset="standard", quiet=False))
    assert f"casing.band_Hz {shipped:g} -> {0.7 * shipped:g}" in capsys.readouterr().err


def test_a_preset_names_the_defaults_that_it_replaces():
    """The element is a default of the scene, which the file does not state."""
    scene = load_scene("minimal", {"casing.model": "craig-bampton"})
    assert "casing.element tetrahedron-10 -> hexahedron-32" in replaced(scene, preset_on(scene, "draft"))


def test_a_setting_counts_more_than_the_preset():
    asked = preset_on(load_scene("rig-healthy", ["simulation.step_us=7"]), "draft").scene
    assert asked.simulation.step_us == 7
    assert asked.casing.band_Hz < load_scene("rig-healthy").scene.casing.band_Hz


def test_every_choice_of_the_rig_is_a_valid_scene_or_says_why_not():
    from pipelines.scene.load_scene import changed

    loaded = load_scene("rig-missing-tooth")
    refused = []
    for choice in choices(loaded.scene):
        try:
            changed(loaded, choice.settings)
        except SceneError as error:
            refused.append((choice.name, str(error)))
    assert refused == []
