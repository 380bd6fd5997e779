"""Usual tip reliefs, orders of the transmission error, and the one Hertz pressure of `gears` and `inspect`."""

import math

import numpy as np
import pytest

import gearcase
from fem.contact.evaluation.mesh_cycle import order_amplitudes
from fem.gears.modifications import (
    FlankModifications,
    PairModifications,
    Relief,
    active_roll,
    profile_gap,
    relief_lengths,
)
from fem.gears.path import path_points
from pipelines.machine.layout import lay_out
from pipelines.runs.gear_curves import MeshState, gear_curves, gear_rows, transmission_errors
from pipelines.scene.load_scene import load_scene

SPUR = {"stages.1.pinion_teeth": 23, "stages.1.wheel_teeth": 57, "stages.1.module_mm": 3.0,
        "stages.1.face_width_mm": 25.0, "stages.1.mesh.slices": 1}  # fmt: skip
HIGH = {"stages.1.rack_addendum": 1.35, "stages.1.rack_dedendum": 1.6, "stages.1.pinion_teeth": 50,
        "stages.1.rack_tip_radius": 0.2}  # fmt: skip  # eps_alpha = 2.3


def searched(settings, *, force, **options):
    """The default search at one force."""
    scene = gearcase.Scene.from_file("pair").changed(SPUR | settings)
    radius = lay_out(scene.loaded.scene).pairs[0].pinion.base_radius
    return gearcase.design(scene, torques=[force * radius], **options)


def pair(**changes):
    return gearcase.laws(gearcase.Scene.from_file("pair").changed(SPUR | changes))[0]


@pytest.mark.parametrize(("settings", "pairs"), [({}, 1), ({"stages.1.helix_angle_deg": 10.0}, 1), (HIGH, 2)])
def test_the_shortest_reliefs_leave_whole_base_pitches_unmodified(settings, pairs):
    gears = lay_out(load_scene("pair", SPUR | settings).scene).pairs[0]
    low, high = active_roll(gears, "pinion")
    assert high - low - 2 * relief_lengths(gears)[0] == pytest.approx(pairs * gears.base_pitch, rel=1e-9)


def test_the_lengths_of_a_textbook_pair():
    """20/40 teeth, 20 degrees, eps_alpha = 1.636 and p_b = 2.952 modules in tables of textbooks."""
    settings = {"stages.1.pinion_teeth": 20, "stages.1.wheel_teeth": 40, "stages.1.module_mm": 1.0}
    short, long = relief_lengths(lay_out(load_scene("pair", settings).scene).pairs[0])
    assert short == pytest.approx(0.636 * 2.952e-3 / 2, rel=2e-3)
    assert long == pytest.approx(1.636 * 2.952e-3 / 2, rel=2e-3)


def test_reliefs_beyond_half_of_the_path_repeat_shorter_ones():
    """Gaps of overlapping linear reliefs are those of shorter reliefs of the same slope, and a constant.

    Near the start of a relief the flanks touch beside the contact point of involutes; there they differ by 0.1 %.
    """
    gears = lay_out(load_scene("pair", SPUR).scene).pairs[0]
    points = path_points(gears, np.linspace(gears.xi_start, gears.xi_end, 101))
    half = relief_lengths(gears)[1]

    def gap(length):
        relief = FlankModifications(tip_relief=Relief(amount=20e-6 * length / half, length=length))
        return profile_gap(gears, PairModifications(pinion=relief, wheel=relief), points)

    assert np.ptp(gap(1.2 * half) - gap(0.8 * half)) < 2e-8
    assert np.ptp(gap(half) - gap(0.8 * half)) > 1e-6


def test_the_search_takes_teeth_with_two_or_three_pairs_in_contact():
    none, best = searched(HIGH, force=1000.0).rows()
    assert best["te um"] < 0.5 * none["te um"]


def test_the_largest_amount_is_the_deflection_of_one_tooth_pair():
    """C_eff = F / (b c') with c' = 15.09 N/(mm um) of a separate finite-element program at the pitch point, 50 N/mm."""
    settings = {
        "stages.1.pinion_teeth": 20, "stages.1.wheel_teeth": 55, "stages.1.module_mm": 2.0,
        "stages.1.face_width_mm": 30.0, "stages.1.pinion_bore_mm": 35.0 / 1.4, "stages.1.wheel_bore_mm": 105.0 / 1.4,
    }  # fmt: skip
    amounts, lengths = searched(settings, force=1500.0).designs.task.variables.given
    at_pitch_point = 1500.0 / 30.0 / 15.09
    assert amounts.values == (0, 1, 2, 3, math.ceil(1.06 * at_pitch_point))
    short, long = relief_lengths(lay_out(load_scene("pair", SPUR | settings).scene).pairs[0])
    assert lengths.values[0] == pytest.approx(1e3 * short, abs=0.1)
    assert lengths.values[-1] == pytest.approx(1e3 * long, abs=0.1)


@pytest.mark.parametrize("helix", [0.0, 12.0])
def test_the_best_relief_in_a_scene_has_the_transmission_error_and_the_pressure_of_its_design(helix):
    """The full deflection of a helical pair would leave more transmission error than no relief with a short length."""
    settings = {"stages.1.helix_angle_deg": helix, "stages.1.mesh.slices": 15 if helix else 1}
    study = searched(settings, force=6000.0, limits=["pressure <= 5000"])
    none, best = study.rows()
    assert best["te um"] < 0.35 * none["te um"]
    relieved = pair(**settings, **study.settings("A"))
    state = MeshState(force=6000.0, tilt=0.0)
    rows = gear_rows([relieved], gear_curves([relieved], [state]))
    for design, row in zip((none, best), rows, strict=True):
        assert design["te um"] == pytest.approx(row["TE p-p um"], rel=0.01)
        assert design["pressure MPa"] == pytest.approx(row["pressure MPa"], rel=0.02)


def test_other_modifications_of_the_scene_stay_with_the_searched_reliefs():
    crowned = {"stages.1.pinion.profile_crowning_um": 8.0}
    relieved = crowned | {"stages.1.pinion.tip_relief": {"amount_um": 5.0, "length_mm": 3.0}}
    found = [searched(settings, force=6000.0).designs.objectives for settings in (crowned, relieved, {})]
    assert np.array_equal(found[0], found[1])
    assert not np.isclose(found[0], found[2]).any()


def test_a_relief_lowers_the_secant_stiffness_and_hardly_the_tangent_stiffness():
    relief = {f"stages.1.{gear}.tip_relief": {"amount_um": 6.0, "length_mm": 6.0} for gear in ("pinion", "wheel")}
    pairs = [pair(), pair(**relief)]
    none, relieved = (gear_rows([one], gear_curves([one], [MeshState(force=6000.0, tilt=0.0)]))[-1] for one in pairs)
    assert relieved["secant N/um"] < 0.95 * none["secant N/um"]
    assert relieved["tangent N/um"] == pytest.approx(none["tangent N/um"], rel=0.03)


def test_amounts_end_at_the_limit_of_their_key():
    """Above 0.1 modules (0.3 mm) no relief can be set; plastic gears deflect more."""
    study = searched({"gear_material.elastic_modulus_GPa": 3.0}, force=4000.0)
    assert study.designs.task.variables.given[0].values[-1] == 296


def test_one_load_beyond_the_table_of_the_law_has_one_warning(caplog):
    found, state = pair(), MeshState(force=3e5, tilt=0.0)
    gear_curves([found], [state])
    transmission_errors(found, state)
    assert len({record.getMessage() for record in caplog.records}) == 1


def test_orders_are_the_amplitudes_of_the_waves():
    c = np.arange(256) / 256
    error = 5.0 + 2.0 * np.cos(2 * np.pi * c + 0.4) + 0.5 * np.sin(6 * np.pi * c)
    assert order_amplitudes(error) == pytest.approx([2.0, 0.0, 0.5, 0, 0, 0, 0, 0], abs=1e-12)


def test_a_pair_without_modifications_has_one_curve_and_no_row_for_it():
    found = pair()
    assert not found.modified
    assert found.unmodified is not None
    assert [row["flanks"] for row in transmission_errors(found, MeshState(force=1000.0, tilt=0.0)).rows()] == [
        "unmodified"
    ]
    misaligned = pair(**{"stages.1.misalignment.out_of_plane_um": 5.0, "stages.1.mesh.slices": 3})
    assert not misaligned.modified


@pytest.mark.parametrize("teeth", [23, 17])
def test_gears_and_inspect_give_one_hertz_pressure(teeth):
    """At high load tips of 17 teeth touch beyond the active flank, where no Hertz pressure is counted."""
    found = pair(**{"stages.1.pinion_teeth": teeth})
    state = MeshState(force=20000.0, tilt=0.0)
    curves = gear_curves([found], [state])
    (row,) = gear_rows([found], curves)
    pattern = found.pattern(force=state.force)
    assert row["pressure MPa"] == pytest.approx(float(pattern.max()) / 1e6, rel=1e-12)
    active = found.pair.xi_start, found.pair.xi_end
    outside = (curves.position < active[0]) | (curves.position > active[1])
    own = curves.pressure.sel(pair=0)[0]
    assert float(own[outside.values].max()) == 0.0
    assert float(own.max()) == pytest.approx(float(pattern.max()), rel=0.12)
