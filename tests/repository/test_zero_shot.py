"""The rule of the zero-shot benchmark is the frozen one and names the part that impacts; its rigs are as published."""

import pandas
import pytest
from sources import ROOT

from benchmarks.zero_shot.rule import COMB, DAMAGED, HASH, STATES, answers, sha256, stored_rule
from pipelines.recordings.machine_file import read_machine

FLOOR = {"outer": 6.0, "inner": 6.0, "element": 6.0, "sidebands": 5.0, "kurtosis": 9.5, "rms": 120.0}


def test_the_frozen_hash_belongs_to_the_rule_that_is_used():
    page = (ROOT / "docs" / "zero-shot.md").read_text(encoding="utf-8")
    assert sha256() == HASH
    assert HASH in page


@pytest.mark.parametrize("part", DAMAGED)
def test_impacts_at_one_pass_order_name_its_part(part):
    high = {part: 30.0} | ({"sidebands": 25.0} if part == "element" else {})
    named = answers(stored_rule(), pandas.DataFrame([FLOOR | high])).iloc[0]
    assert (named["rule part"], named[f"{COMB} part"], named["rule"]) == (part, part, part)


def test_levels_of_noise_are_those_of_a_healthy_bearing():
    named = answers(stored_rule(), pandas.DataFrame([FLOOR])).iloc[0]
    assert (named["rule"], named[COMB]) == (STATES[0], STATES[0])


@pytest.mark.parametrize(
    ("rig", "orders"),
    [
        ("cwru_drive_end", (3.5848, 5.4152, 2.3567)),  # Bearing Data Center: BPFO, BPFI, BSF
        ("cwru_fan_end", (3.0530, 4.9469, 1.9940)),
        ("mfpt", (3.245, 4.755, 2.5549)),  # 81.125, 118.875 and 63.872 Hz at 25 Hz
    ],
)
def test_rigs_have_the_published_pass_orders(rig, orders):
    bearing = read_machine(ROOT / "benchmarks" / "zero_shot" / "rigs" / f"{rig}.toml").kinematics.bearings[0]
    assert [bearing.orders[name] for name in ("BPFO", "BPFI", "BSF")] == pytest.approx(orders, rel=2e-3)
