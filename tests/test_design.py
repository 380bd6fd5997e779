"""Search for flank modifications: evaluated as made, equal to a direct solution, deterministic, limits, messages."""

import numpy as np
import pytest

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.faults.changed_law import modified_law
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError, SceneError
from pipelines.runs.single_results import build_pairs
from pipelines.scene.file import load_scene
from pipelines.studies.design.study import DesignOptions, design_study

VARY = ("both.tip_relief.amount_um=0:20:4", "both.tip_relief.length_mm=1:3:1")


def found(**options):
    return design_study(load_scene("bench"), DesignOptions(**({"vary": VARY} | options)), Work())


def test_the_best_relief_of_all_combinations_has_the_transmission_error_of_a_direct_solution():
    study = found(torques=(60.0,))
    designs = study.designs
    assert len(designs.index) == 6 * 3
    best = designs.objectives[:, 0].argmin()
    assert designs.front.tolist() == [best]
    pair = build_pairs(load_scene("bench"), Work())[0]
    law = modified_law(pair.unmodified, pair.pair, study.modifications[-1])
    error = LawEvaluator(law).approach_at(60.0 / pair.pair.pinion.base_radius, np.arange(32) / 32)
    assert designs.objectives[best, 0] == pytest.approx(1e6 * np.ptp(error), rel=1e-9)


def test_a_search_with_fewer_evaluations_is_deterministic_and_uses_manufacturing_steps():
    pytest.importorskip("pymoo")
    options = {"vary": ("both.tip_relief.amount_um=0:30", "both.tip_relief.length_mm=1:3"), "evaluations": 60}
    first, second = found(**options), found(**options)
    assert len(first.designs.index) <= 144 < 31 * 21
    assert np.array_equal(first.designs.index, second.designs.index)
    amount, length = first.designs.values(first.designs.compromise)
    assert amount == round(amount)
    assert 10 * length == pytest.approx(round(10 * length))


def test_a_limit_is_met_by_the_whole_front():
    free = found(minimize=("te", "pressure"))
    most = float(np.median(free.designs.objectives[:, 1]))
    limited = found(limits=(f"pressure <= {most}",)).designs
    assert (limited.excess[limited.front] == 0.0).all()
    assert (limited.excess > 0.0).any()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"vary": ("both.tip_releif.amount_um=0:9",)}, "Did you mean tip_relief"),
        ({"vary": ("both.lead_crowning_um=5:5",)}, "one value only"),
        ({"vary": ()}, "nothing is varied"),
        ({"stage": 2}, "the scene has 1 stages"),
        ({"minimize": ("presure",)}, "Did you mean pressure"),
        ({"limits": ("te < 1",)}, "is not a limit"),
        ({"limits": ("te <= 0",)}, "none of 18 candidates"),
    ],
)
def test_a_wrong_option_is_named(options, words):
    with pytest.raises(InputError, match=words):
        found(**options)


def test_a_value_outside_its_range_is_a_problem_of_the_scene():
    with pytest.raises(SceneError, match="amount_um"):
        found(vary=("both.tip_relief.amount_um=0:5000:100", VARY[1]))
