"""The claims of the rig's study: measures of known signals, verdicts from known samples, cases as they ship."""

import json

import numpy as np
import pytest
import xarray
from synthetic import MESH, WHEEL, response

from pipelines.cli.main import main
from pipelines.scene.load_scene import load_scene
from pipelines.signals.analysis import DiagnosisSettings
from pipelines.studies.verification import claims_output
from pipelines.studies.verification.claims_output import FAILS, HOLDS, OPEN, judge
from pipelines.studies.verification.measures import fault_levels, load_levels
from pipelines.studies.verification.published_claims import (
    CLAIMS,
    ClaimEvidence,
    added_in_lifting,
    lifting_over_lowering,
    over_control,
)
from pipelines.studies.verification.rig import LOADS, LOSSES, SCENES, SENSOR, STRETCHES, cases, scene_of

WINDOWS = {"lifting": (0.5, 2.5), "lowering": (3.0, 5.0)}
SETTINGS = DiagnosisSettings(
    revolution_frequency=WHEEL, mesh_frequency=MESH, windows=WINDOWS, sensor="sensor_3", axis="z", shaft="shaft_2"
)
CARRIER = 0.8  # m/s2 of the mesh line in axis z of sensor 3
HARMONICS = np.array([1, 1 / 2, 1 / 3, 1 / 4])


def measured(**faulty):
    """Levels of a known fault, and of a healthy machine with a modulation of 5 % once per turn."""
    found = response(state="missing-tooth", noise=0.0, **({"runout": 0.0, "depth": 0.4} | faulty))
    healthy = response(state="healthy", noise=0.0, runout=0.05)
    return fault_levels(found, healthy, SETTINGS)


@pytest.fixture(scope="module")
def levels():
    return measured()


def test_sidebands_of_a_known_modulation(levels):
    """A modulation m cos(k phi) of a line A makes two sidebands A m / 2."""
    expected = 20 * np.log10(np.sqrt(2) * np.linalg.norm(0.4 * HARMONICS / 2))
    assert levels["faulty", "lifting"]["modulation_1"] == pytest.approx(expected, abs=0.02)
    assert levels["faulty", "lifting"]["sidebands_1"] == pytest.approx(expected + 20 * np.log10(CARRIER), abs=0.02)
    assert levels["faulty", "lifting"]["modulation_2"] == pytest.approx(expected, abs=0.02)
    healthy = 20 * np.log10(np.sqrt(2) * 0.05 / 2)
    assert levels["healthy", "lowering"]["modulation_1"] == pytest.approx(healthy, abs=0.02)


def test_envelope_of_a_known_modulation(levels):
    expected = 20 * np.log10(CARRIER * 0.4 * np.linalg.norm(HARMONICS))
    assert levels["faulty", "lifting"]["envelope"] == pytest.approx(expected, abs=0.02)
    assert levels["healthy", "lifting"]["envelope"] == pytest.approx(20 * np.log10(CARRIER * 0.05), abs=0.02)


def test_a_modulation_half_as_deep_in_lowering_is_6_dB_clearer_in_lifting():
    found = measured(lowering=0.5)
    for measure in ("modulation_1", "modulation_2", "envelope"):
        clearer = found["faulty", "lifting"][measure] - found["faulty", "lowering"][measure]
        assert clearer == pytest.approx(6.02, abs=0.05)


def test_a_signal_twice_as_large_has_twice_the_peak():
    once, healthy = response(noise=0.0), response(state="healthy", noise=0.0)
    twice = once.assign(acceleration=2 * once.acceleration)
    one, two = (fault_levels(run, healthy, SETTINGS)["faulty", "lifting"] for run in (once, twice))
    assert two["tsa_peak"] - one["tsa_peak"] == pytest.approx(6.0206, abs=1e-3)


def test_the_average_of_a_line_of_the_mesh_has_its_range():
    pure = response(state="healthy", runout=0.0, noise=0.0, load="static-torque")
    time = pure.time.values
    tone = np.where(time < 2.75, 3.0 * np.cos(2 * np.pi * MESH * time), 0.0)
    pure["acceleration"] = xarray.zeros_like(pure.acceleration) + xarray.DataArray(tone, dims="time")
    found = fault_levels(pure, pure, SETTINGS)["healthy", "lifting"]
    assert found["tsa_peak"] == pytest.approx(20 * np.log10(6.0), abs=0.05)


def test_a_rope_that_makes_all_a_tenth_larger_is_20_dB_apart():
    torque = response(load="static-torque", noise=0.0)
    rope = torque.assign(acceleration=1.1 * torque.acceleration, mesh_force=2.0 * torque.mesh_force)
    found = load_levels(rope, torque, "sensor_3", "z", (0.5, 2.5))
    assert found["difference"] == pytest.approx(-20.0, abs=1e-3)
    assert found["level"] == pytest.approx(20 * np.log10(1.1), abs=1e-3)
    assert found["mesh_force"] == pytest.approx(6.0206, abs=1e-3)


def test_the_standard_error_of_a_known_sample():
    found = judge([3.0, 4.0, 5.0], 0.0)
    assert (found.mean, found.standard_error) == (4.0, pytest.approx(1 / np.sqrt(3)))


@pytest.mark.parametrize(("least", "verdict"), [(1.0, HOLDS), (3.0, OPEN), (7.0, FAILS)])
def test_a_verdict_needs_the_whole_interval(least, verdict):
    """4 +- 4.303 / sqrt(3): from 1.52 to 6.48."""
    assert judge([3.0, 4.0, 5.0], least).verdict == verdict


def test_a_true_claim_without_margin_is_told_wrong_in_few_of_many_trials():
    """A mean just at the limit is called holding or failing in 2.5 % of trials each: Student's 95 % interval."""
    rng = np.random.default_rng(1)
    verdicts = [judge(sample, 0.0).verdict for sample in rng.standard_normal((2000, 5))]
    assert verdicts.count(HOLDS) / 2000 == pytest.approx(0.025, abs=0.011)
    assert verdicts.count(FAILS) / 2000 == pytest.approx(0.025, abs=0.011)


def evidence(**measures):
    """All measures 0 dB with a spread of 0.1 dB; more where they are given as (place, dB)."""
    rng = np.random.default_rng(2)
    names = sorted({claim.measure for claims in CLAIMS.values() for claim in claims})
    seeds = ["1", "2", "3"]
    coords = {
        "losses": list(LOSSES), "load": list(LOADS), "seed": seeds, "state": ["faulty", "healthy"],
        "window": list(WINDOWS), "measure": names,
    }  # fmt: skip
    levels = xarray.DataArray(rng.normal(0, 0.1, [len(v) for v in coords.values()]), coords=coords)
    kinds = {"losses": list(LOSSES), "seed": seeds, "stretch": list(STRETCHES), "measure": names}
    loads = xarray.DataArray(rng.normal(0, 0.1, [len(v) for v in kinds.values()]), coords=kinds)
    for name, (where, value) in measures.items():
        levels.loc[{"measure": name, **where}] += value
    return ClaimEvidence(levels=levels, loads=loads)


def test_over_control_is_faulty_over_healthy_with_the_same_deviations():
    found = over_control(evidence(envelope=({"state": "faulty"}, 12.0)), "envelope")
    assert found.dims == ("losses", "load", "seed")
    np.testing.assert_allclose(found, 12.0, atol=0.5)


def test_lifting_over_lowering_looks_at_the_faulty_machine_alone():
    found = lifting_over_lowering(evidence(envelope=({"state": "healthy", "window": "lifting"}, 12.0)), "envelope")
    np.testing.assert_allclose(found, 0.0, atol=0.5)


def test_what_friction_does_to_both_machines_is_not_what_the_fault_adds():
    told = evidence(sidebands_2=({"losses": "friction", "window": "lifting"}, 12.0))
    np.testing.assert_allclose(added_in_lifting(told, "sidebands_2"), 0.0, atol=0.8)
    np.testing.assert_allclose(lifting_over_lowering(told, "sidebands_2").sel(losses="friction"), 12.0, atol=0.8)


def test_every_claim_is_stated_before_with_its_measure_and_limit():
    text = claims_output.stated()
    for heading, claims in CLAIMS.items():
        assert heading in text
        for claim in claims:
            assert claim.words in text
            assert claim.measure in text


def test_a_table_says_what_holds_where_and_why_the_rest_does_not(tmp_path):
    """3 dB at 2 f_m with friction alone: that claim holds there, and its reason is told for the lossless machine."""
    told = evidence(modulation_2=({"losses": "friction", "window": "lifting", "state": "faulty"}, 3.0))
    found = claims_output.verdicts(told)
    (direction,) = (
        judged
        for heading, judged in found.items()
        if heading.endswith("faulty machine") and heading.startswith("Lifting")
    )
    by_words = {claim.measure: by_condition for claim, by_condition in direction}
    verdicts = {name: one.verdict for name, one in by_words["modulation_2"].items()}
    assert verdicts == {
        "rope, no losses": FAILS, "constant torque, no losses": FAILS,
        "rope, friction": HOLDS, "constant torque, friction": HOLDS,
    }  # fmt: skip
    assert any("lifting reversed in time" in reason for reason in claims_output.reasons(found).values())
    text, data = claims_output.write(tmp_path / "claims", told, found, {"preset": "standard", "seeds": 3})
    assert "| +3." in text.read_text(encoding="utf-8")
    stored = json.loads(data.read_text(encoding="utf-8"))
    assert stored["seeds"] == 3
    assert xarray.DataArray.from_dict(stored["levels"]).equals(told.levels)


def test_the_reason_of_a_claim_that_holds_everywhere_is_not_told():
    found = claims_output.verdicts(evidence())
    assert not any(one.verdict == HOLDS for claim, one in _flat(found) if claim.measure == "level")
    (steady,) = next(claim.reasons for claims in CLAIMS.values() for claim in claims if claim.measure == "level")
    assert any(steady in reason for reason in claims_output.reasons(found).values())
    firm = judge([9.0, 9.1, 9.2], 0.0)
    held = {
        heading: [(claim, dict.fromkeys(by_condition, firm)) for claim, by_condition in judged]
        for heading, judged in found.items()
    }
    assert not any(claims_output.reasons(held).values())


def _flat(found):
    rows = [row for judged in found.values() for row in judged]
    return [(claim, one) for claim, by_condition in rows for one in by_condition.values()]


def test_eight_cases_for_each_seed():
    every = list(cases(5))
    assert len(every) == len(set(every)) == 40
    assert {(case.state, case.load, case.losses) for case in every if case.seed == 1} == {
        (state, load, losses) for state, load in SCENES for losses in LOSSES
    }


@pytest.mark.parametrize("case", list(cases(1)), ids=lambda case: case.name)
def test_a_case_is_the_shipped_scene_but_for_seed_friction_and_the_recorded_sensor(case):
    shipped = load_scene(SCENES[case.state, case.load]).scene
    ours = scene_of(case, "standard").scene
    left_out = {"sensors", "losses", "deviations", "stages", "casing", "simulation"}  # the last three: of the preset
    assert ours.model_dump(exclude=left_out) == shipped.model_dump(exclude=left_out)
    assert [one.model_dump() for one in ours.sensors] == [
        one.model_dump() for one in shipped.sensors if one.name == SENSOR["name"]
    ]
    assert ours.simulation.end_s == shipped.simulation.end_s
    for windows in (STRETCHES["steady"],):
        assert windows == tuple(map(tuple, shipped.diagnosis.windows_s.values()))


@pytest.mark.slow
def test_the_claims_are_put_to_the_test(tmp_path, capsys):
    """Sixteen simulations; what physics says whatever the deviations are."""
    assert main(["verify", "rig", "--seeds", "2", "--quiet", "--out", str(tmp_path / "out")]) == 0
    assert "undecided" in capsys.readouterr().out
    stored = json.loads((tmp_path / "out" / "claims.json").read_text(encoding="utf-8"))
    levels, loads = (xarray.DataArray.from_dict(stored[name]) for name in ("levels", "loads"))
    assert np.isfinite(levels).all()
    assert np.isfinite(loads).all()
    added = levels.sel(state="faulty") - levels.sel(state="healthy")
    assert (added.sel(measure="envelope_1_to_2_kHz").mean(["seed", "window"]) > 10.0).all()
    direction = levels.sel(window="lifting") - levels.sel(window="lowering")
    mesh_line = (direction.sel(measure="sidebands_2") - direction.sel(measure="modulation_2")).mean("seed")
    assert (abs(mesh_line.sel(losses="none")) < 1.0).all()  # lowering is lifting run backwards
    assert (mesh_line.sel(losses="friction") < -10.0).all()  # friction adds in one direction, healthy or not
    steady, start = (loads.sel(measure="mesh_force", stretch=stretch) for stretch in ("steady", "start"))
    assert (abs(steady) < 0.5).all()
    assert (start > 1.0).all()  # the rope accelerates the container
