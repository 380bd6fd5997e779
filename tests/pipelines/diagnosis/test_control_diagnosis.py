"""Diagnosis: known modulations are detected, equal runs show nothing, noise buries what it should."""

import csv
import json

import numpy as np
import pytest
import xarray
from synthetic import MESH, RATE, WHEEL, response

from pipelines.diagnosis.control_diagnosis import DiagnosisError, DiagnosisSettings, diagnose
from pipelines.diagnosis.line_words import criterion, directions, lines_grid, markdown, modulation, seeds_grid
from pipelines.diagnosis.result_export import save_diagnoses
from pipelines.signals.analysis import analyse, envelope_band
from pipelines.signals.line_table import LineTable

WINDOWS = {"lifting": (0.5, 2.5), "lowering": (3.0, 5.0)}


def settings(**changes):
    values = {
        "revolution_frequency": WHEEL,
        "mesh_frequency": MESH,
        "windows": WINDOWS,
        "sensor": "sensor_3",
        "rope_mode": {"lifting": 7.9, "lowering": 7.6},
        "shaft": "shaft_2",
    }
    return DiagnosisSettings(**(values | changes))


@pytest.fixture(scope="module")
def clear():
    return diagnose(response(), response("healthy"), settings())


def test_known_modulation_comes_back(clear):
    lifting = clear.lines.where(window="lifting")
    carrier = lifting.where(kind="mesh", mesh_harmonic=1)
    assert carrier.faulty[0] == pytest.approx(np.linalg.norm([0.4, -0.3, 0.8]), rel=1e-3)
    for k in (2, 3, 4):  # the fault alone modulates these orders: sidebands m/2
        pair = lifting.where(mesh_harmonic=1)
        ratio = pair.faulty[np.abs(pair.order) == k] / carrier.faulty[0]
        np.testing.assert_allclose(ratio, 0.4 / k / 2, rtol=0.01)
    envelope = lifting.where(kind="envelope")
    np.testing.assert_allclose(envelope.faulty[1:4] / carrier.faulty[0], 0.4 / np.arange(2, 5), rtol=0.02)
    np.testing.assert_allclose(envelope.frequency, WHEEL * np.arange(1, 6))


def test_lines_of_a_clear_fault_are_detected(clear):
    lifting = clear.lines.where(window="lifting")
    assert len(clear.lines) == 2 * (5 + 2 * 9)
    assert lifting.where(kind="sideband").detected.sum() == 16
    assert lifting.where(kind="envelope").detected.sum() == 4  # run-out masks the first


def test_no_line_of_a_run_that_differs_from_its_control_by_chance_is_detected(clear):
    found = diagnose(response().assign_attrs(repeatable_until_s=1.2), response("healthy"), settings())
    assert clear.lines.detected.any()
    assert not found.lines.detected.any()
    np.testing.assert_array_equal(found.lines.difference, clear.lines.difference)
    assert criterion(found).startswith("No line is marked as detected: the motion is chaotic")


def test_equal_runs_show_nothing():
    healthy = response("healthy")
    found = diagnose(healthy, healthy, settings())
    assert found.lines.of("envelope", "sideband").detected.sum() == 0
    # the noise of the two runs is drawn independently, so equal runs differ in the noise alone
    strong = found.lines.over_floor > 30
    assert np.abs(found.lines.difference[strong]).max() < 1.0


def test_noise_buries_the_fault():
    found = diagnose(response(noise=30.0), response("healthy", noise=30.0), settings())
    assert found.lines.of("envelope", "sideband").detected.sum() <= 1


def test_run_out_hides_the_fault_in_its_own_order():
    masked = diagnose(response(runout=0.5), response("healthy", runout=0.5), settings())
    first = masked.lines.where(window="lifting", kind="sideband", order=1)
    third = masked.lines.where(window="lifting", kind="sideband", order=3)
    assert first.detected.sum() == 0
    assert (first.healthy_over_floor >= 10.0).all()
    assert third.detected.all()


def test_weaker_lowering_reads_weaker():
    found = diagnose(response(lowering=0.1), response("healthy"), settings())
    depth = {w: modulation(found.lines.where(window=w), "faulty") for w in WINDOWS}
    assert depth["lifting"] - depth["lowering"] > 6
    assert "higher in lifting" in directions(found)
    more = diagnose(response(lowering=0.1), response("healthy"), settings(windows=WINDOWS | {"end": (3.5, 5.0)}))
    assert directions(more) == directions(found)  # of the first two windows, however many there are
    assert not directions(diagnose(response(), response("healthy"), settings(windows={"lifting": WINDOWS["lifting"]})))


def test_rope_mode_on_a_line_is_named():
    found = diagnose(response(), response("healthy"), settings(rope_mode={"lifting": 2 * WHEEL + 0.5}))
    near = found.lines.where(near_rope=1)
    assert set(np.abs(near.order)) == {2}
    assert set(near.window) == {"lifting"}
    assert found.lines.where(window="lowering").rope_mode.max() == 0


def test_band_rules_do_not_look_at_the_faulty_run(clear):
    rate_band = envelope_band(settings(band="resonance"), [clear.spectra["healthy", "lifting"]], RATE)
    assert rate_band[0] <= 1234.5 <= rate_band[1]
    assert clear.band == (150.0, 450.0)
    given = diagnose(response(), response("healthy"), settings(band=(500.0, 700.0)))
    assert given.band == (500.0, 700.0)
    assert given.lines.where(window="lifting", kind="envelope").detected[:4].all()


def test_noise_of_a_sensor_does_not_depend_on_the_other_sensors(clear):
    alone = [response(state).sel(sensor=["sensor_3"]) for state in ("missing-tooth", "healthy")]
    found = diagnose(*alone, settings())
    np.testing.assert_array_equal(found.lines.faulty, clear.lines.faulty)


def test_without_casing_a_journal_is_diagnosed(clear):
    pair = []
    for state in ("missing-tooth", "healthy"):
        run = response(state)
        journal = run.acceleration.sel(sensor="sensor_3").expand_dims(bearing=run.bearing, axis=1).drop_vars("sensor")
        pair.append(run.drop_vars(["acceleration", "sensor"]).assign(journal_acceleration=journal))
    found = diagnose(*pair, settings(sensor="bearing_3"))
    strong = clear.lines.over_floor > 40
    np.testing.assert_allclose(found.lines.faulty[strong], clear.lines.faulty[strong], rtol=0.02)
    with pytest.raises(DiagnosisError, match=r"is not in this run\. Set a sensor of the run: bearing_1"):
        diagnose(*pair, settings())


def test_another_sensor_and_a_window_of_changing_speed_are_refused():
    faulty = response(duration=3.0)
    short = {"windows": {"lifting": (0.5, 2.5)}}
    healthy = response("healthy", duration=3.0)
    with pytest.raises(DiagnosisError, match="sensor_9"):
        diagnose(faulty, healthy, settings(sensor="sensor_9", **short))
    with pytest.raises(DiagnosisError, match="constant speed"):
        diagnose(faulty, healthy, settings(windows={"ramp": (2.0, 3.0)}))


def test_tables_name_every_line(clear):
    grid = lines_grid(clear, "lifting")
    assert len(grid.rows) == 23
    assert {row[0] for row in grid.rows} >= {"envelope f_r", "envelope 5 f_r", "f_m - 4 f_r", "2 f_m + f_r", "f_m"}
    assert (
        grid.to_markdown().count("detected")
        == len(grid.marked)
        == clear.lines.where(window="lifting").of("envelope", "sideband").detected.sum()
    )
    assert grid.headers[7] == "mark"  # no verdict: that does not depend on single lines
    assert len(grid.to_text().splitlines()) == 26
    assert grid.to_html().count("<tr") == 24


def test_lines_of_several_seeds_are_side_by_side():
    free = diagnose(
        response(deviations="off", runout=0.0), response("healthy", deviations="off", runout=0.0), settings()
    )
    seeds = [
        diagnose(response(seed=s, runout=0.1 * s), response("healthy", seed=s, runout=0.1 * s), settings())
        for s in (1, 2)
    ]
    torque = diagnose(response(load="static-torque"), response("healthy", load="static-torque"), settings(rope_mode={}))
    differences = seeds_grid([*seeds, free, torque], "rope", "lifting")
    assert differences.headers == ("line", "Hz", "error-free", "seed 1", "seed 2", "detected in")
    row = next(row for row in differences.rows if row[0] == "f_m + 2 f_r")
    assert all(cell.endswith("●") for cell in row[2:5])
    assert row[5] == "3"


def test_one_run_alone_is_analysed_like_the_control_of_a_pair(clear):
    alone = analyse(response("healthy"), settings())
    np.testing.assert_array_equal(alone.spectra["lifting"].amplitude, clear.spectra["healthy", "lifting"].amplitude)
    np.testing.assert_array_equal(
        alone.envelopes["lowering"].amplitude, clear.envelopes["healthy", "lowering"].amplitude
    )


def test_markdown_explains_the_marks_first(clear):
    text = markdown([clear])
    assert text.startswith("A line is marked as detected if it is at least 6 dB over")
    assert "equal within 1 dB" in text
    assert text.count("| line | Hz |") == 2


def test_saved_lines_come_back(clear, tmp_path):
    nc, table, summary = save_diagnoses(tmp_path, [clear, clear])
    back = LineTable.load(nc)
    np.testing.assert_array_equal(back.difference, np.tile(clear.lines.difference, 2))
    assert back.label == clear.lines.label * 2
    with xarray.open_dataset(nc, engine="h5netcdf") as dataset:
        assert dataset.faulty.attrs["units"] == "m s-2"
    rows = list(csv.reader(table.read_text(encoding="utf-8").splitlines()))
    assert "difference [dB]" in rows[0]
    assert len(rows) == 1 + 2 * 46
    content = json.loads(summary.read_text(encoding="utf-8"))
    assert content["cases"][0]["segments"]["lifting"]["samples"] == 16_500
    assert content["lines"][0]["label"] == "f_r"


def test_the_stage_names_error_free_gears_and_seeds_apart():
    from pipelines.steps.diagnosing import CaseSpec, diagnoses

    cases = [CaseSpec(settings=settings(), full=True)] * 2
    runs = [response(state, deviations=on) for on in ("off", "on") for state in ("missing-tooth", "healthy")]
    error_free, seeded = diagnoses(cases, runs)
    assert error_free.deviations == "off"
    assert seeded.deviations.startswith("seed ")


def test_lines_of_rolling_bearings_are_read_beside_the_others_and_count_for_nothing(clear):
    """4.31 f_r lies between two bins; a line in the bin of the mean or over half the sampling rate cannot be read."""
    given = {"bearing_3 BPFO": 4.31 * WHEEL, "bearing_3 FTF": 0.04, "bearing_3 BPFI": RATE}
    found = diagnose(response(), response("healthy"), settings(bearings=given))
    lines = found.lines.where(kind="bearing")
    assert lines.label == ("bearing_3 BPFO",) * 2
    resolution = found.envelopes["faulty", "lifting"].resolution
    assert np.abs(lines.frequency - 4.31 * WHEEL).max() <= resolution / 2
    at = round(4.31 * WHEEL / resolution)
    assert lines.faulty[0] == found.envelopes["faulty", "lifting"].amplitude[at]
    assert (
        found.lines.of("envelope", "sideband").detected.sum() == clear.lines.of("envelope", "sideband").detected.sum()
    )
    assert [row[0] for row in lines_grid(found, "lifting").rows].count("envelope bearing_3 BPFO") == 1


def test_a_rope_mode_on_the_line_of_a_bearing_is_seen_there_alone():
    given = {"bearing_3 FTF": 0.4 * WHEEL}
    changes = {"bearings": given, "rope_mode": {"lifting": 0.4 * WHEEL}, "windows": {"lifting": (0.5, 2.5)}}
    found = diagnose(response(), response("healthy"), settings(**changes))
    assert found.lines.where(near_rope=1).label == ("bearing_3 FTF",)
