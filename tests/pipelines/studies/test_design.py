"""Search for flank modifications: evaluated as made, equal to a direct solution, deterministic, limits, messages."""

import html
import json
import sys
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.mesh_cycle import mesh_cycle
from fem.contact.faults.changed_law import modified_law
from fem.gears.modifications import PairModifications
from pipelines.cli.main import main
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph
from pipelines.io.errors import InputError, SceneError, SceneWarning
from pipelines.runs.single_results import build_pairs, scene_graph
from pipelines.scene.load_scene import changed, load_scene
from pipelines.steps import flank_candidates
from pipelines.steps.mesh_response import response_step
from pipelines.studies.design.design_page import toml
from pipelines.studies.design.design_page import words as lines
from pipelines.studies.design.design_study import DesignOptions, design_study
from pipelines.studies.design.search import compromise

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
    law = modified_law(pair.unmodified, pair.pair, designs.task.variables.modifications(designs.values(best)))
    error = LawEvaluator(law).approach_at(60.0 / pair.pair.pinion.base_radius, np.arange(32) / 32)
    assert designs.objectives[best, 0] == pytest.approx(1e6 * np.ptp(error), rel=1e-9)


def test_the_best_helix_slope_cancels_the_misalignment_of_the_axes():
    """Skew axes open the flanks by its component cos(alpha_wt) in the plane of action; a crowning adds to it."""
    skew = 8.0 / np.cos(build_pairs(load_scene("bench"), Work())[0].pair.working_pressure_angle)
    scene = changed(load_scene("bench"), {"stages.1.misalignment.out_of_plane_um": float(skew)})
    vary = ("pinion.helix_slope_um=-16:16:4", "wheel.lead_crowning_um=0:10:5")
    study = design_study(scene, DesignOptions(vary=vary, minimize=("load-factor",)), Work())
    (best,) = study.designs.front
    assert study.designs.values(best) == [-8, 0]


def test_a_search_with_fewer_evaluations_is_deterministic_and_uses_manufacturing_steps():
    pytest.importorskip("pymoo")
    options = {"vary": ("both.tip_relief.amount_um=0:30", "both.tip_relief.length_mm=1:3"), "evaluations": 60}
    first, second = found(**options), found(**options)
    assert len(first.designs.index) <= 144 < 31 * 21
    assert np.array_equal(first.designs.index, second.designs.index)
    amount, length = first.designs.values(first.designs.front[0])
    assert amount == round(amount)
    assert 10 * length == pytest.approx(round(10 * length))


def test_a_single_value_is_fixed():
    study = found(vary=(VARY[0], "both.tip_relief.length_mm=2", "pinion.lead_crowning_um=4:4"))
    designs = study.designs
    assert [designs.values(at) for at in range(6)] == [[amount, 2, 4] for amount in range(0, 24, 4)]
    same = found(vary=(VARY[0], "both.tip_relief.length_mm=2,3", "pinion.lead_crowning_um=0,4")).designs
    assert designs.objectives.tolist() == same.objectives[(same.index[:, 1:] == [0, 1]).all(axis=1)].tolist()
    assert not {"both.tip_relief.length_mm", "pinion.lead_crowning_um"} & set(study.edges("A"))


def test_a_limit_is_met_by_the_whole_front():
    free = found(minimize=("te", "pressure"))
    most = float(np.median(free.designs.objectives[:, 1]))
    limited = found(limits=(f"pressure <= {most}",)).designs
    assert (limited.excess[limited.front] == 0.0).all()
    assert (limited.excess > 0.0).any()


def test_a_limit_that_is_exceeded_between_the_positions_of_the_search_is_stated():
    free = found(minimize=("te", "pressure")).designs
    most = float(free.objectives[free.front[0], 1])
    study = found(limits=(f"pressure <= {most!r}",))
    assert study.rows()[-1]["pressure MPa"] > most
    assert any(line.startswith("Design A exceeds pressure MPa <= ") for line in lines(study))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"vary": ("both.tip_releif.amount_um=0:9",)}, "Did you mean tip_relief"),
        ({"vary": VARY[:1]}, r"start of a relief is missing\. .* --vary both\.tip_relief\.length_mm=2"),
        ({"misalignment": 20e-6}, "misalignment = 20 um: .* Set --samples 20"),
        ({"vary": ("tip_relief=0:10",)}, r"gear is missing\. Start with pinion\., .*both.tip_relief\. Keys are tip_"),
        ({"stage": 2}, "there is no such stage"),
        ({"torques": (-1.0, 40.0)}, "torques = -1.0: must be a number of at least 1e-06"),
        ({"torques": (1e5,)}, r"--torque 100000 N m: stages.1: the line load .* Set at most \d+ N m"),
        ({"seed": -1}, "seed = -1: must be a number of at least 0"),
        ({"minimize": ("presure",)}, "Did you mean pressure"),
        (
            {"vary": ("face_with_mm=18:22",)},
            "nor a value of the stage.*Did you mean face_width_mm",
        ),
        ({"vary": ("face_width_mm=18,18.0",)}, "a value is given twice"),
        ({"limits": ("te < 1",)}, "is not a limit"),
        ({"minimize": ("level-motor",)}, "Did you mean level-motor_side"),
        ({"limits": ("te <= 0",)}, "none of 18 candidates"),
    ],
)
def test_a_wrong_option_is_named(options, words):
    with pytest.raises(InputError, match=words):
        found(**options)


def test_a_level_needs_a_sensor():
    with pytest.raises(InputError, match=r"level: no sensor is at a known speed. Set \[\[sensors\]\]"):
        design_study(load_scene("pair"), DesignOptions(minimize=("level",)), Work())


def test_a_model_without_the_effect_of_modifications_is_refused():
    iso = changed(load_scene("bench"), {"stages.1.mesh.model": "iso"})
    with pytest.raises(InputError, match='model = "iso": this model does not contain'):
        design_study(iso, DesignOptions(), Work())


def test_a_value_outside_its_range_is_a_problem_of_the_scene():
    with pytest.raises(SceneError, match="amount_um"):
        found(vary=("both.tip_relief.amount_um=0:5000:100", VARY[1]))


def test_the_printed_settings_give_the_printed_transmission_error_with_gearcase_gears(capsys):
    vary = [word for text in VARY for word in ("--vary", text)]
    assert main(["design", "bench", *vary, "--torque", "60"]) == 0
    out = capsys.readouterr().out
    least = next(line for line in out.splitlines() if line.startswith("A ")).split()[1]
    assert "Design A is at the edge of the range of both.tip_relief.length_mm. Extend the range with --vary." in out
    settings = next(line for line in out.splitlines() if line.startswith("--set")).split()
    assert main(["gears", "bench", *settings, "--torque", "60", "--json"]) == 0
    (healthy,) = (row for row in json.loads(capsys.readouterr().out)["pairs"] if row["state"] == "healthy")
    assert healthy["TE p-p um"] == pytest.approx(float(least), rel=0.01)


def test_the_default_lengths_contain_the_best_one_of_a_helical_pair():
    study = found(vary=())
    far = found(vary=("both.tip_relief.amount_um=0:6:1", "both.tip_relief.length_mm=1:9:0.2"))
    assert study.edges("A") == []
    assert study.designs.objectives.min() < 1.05 * far.designs.objectives.min()


@pytest.mark.parametrize("start", ["length_mm=0.1,0.2", "diameter_mm=53.0,53.2"])
def test_the_start_of_a_relief_without_amount_is_not_at_an_edge(start):
    """Short reliefs increase the transmission error of this pair."""
    study = found(vary=("pinion.tip_relief.amount_um=0,40", f"pinion.tip_relief.{start}"))
    assert study.rows()[-1]["pinion.tip_relief.amount_um"] == 0
    assert study.edges("A") == []


@pytest.mark.slow
def test_the_toml_of_the_page_makes_the_recommended_design(tmp_path):
    page = tmp_path / "design.html"
    assert main(["design", "bench", "--vary", VARY[0], "--vary", VARY[1], "--out", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    block = html.unescape(text.partition("<pre>")[2].partition("</pre>")[0])
    (tmp_path / "quiet.toml").write_text(f'extends = "bench"\n\n{block}\n', encoding="utf-8")
    study = found()
    scene = changed(load_scene("bench"), study.settings(study.recommended))
    assert load_scene(tmp_path / "quiet.toml").scene.stages == scene.scene.stages
    assert text.count("<svg") == 2


@pytest.mark.slow
def test_the_root_stress_of_a_design_is_that_of_its_map():
    study = found(vary=("both.lead_crowning_um=0:10:10",), minimize=("root-stress", "te"), torques=(60.0,))
    rows = {row["design"]: row for row in study.rows()}
    design = study.load_map("A").sel(state="design A", torque=60.0)
    assert float(design.root_stress.max()) / 1e6 == pytest.approx(rows["A"]["root-stress MPa"], rel=0.01)
    assert float(design.peak_to_peak) * 1e6 == pytest.approx(rows["A"]["te um"], rel=0.01)


def test_a_compromise_is_offered_only_if_it_beats_the_unmodified_pair_in_every_objective():
    assert set(found(minimize=("te", "te1")).best()) == {"te um", "te1 um", "compromise"}
    assert "compromise" not in found(minimize=("te", "pressure")).best()  # every relief raises the pressure


def test_the_compromise_is_the_nearest_of_the_designs_that_beat_the_unmodified_pair():
    """A design nearer to the best of both does not beat it."""
    values = np.array([[1.0, 9.0], [3.0, 5.5], [6.0, 4.0], [9.0, 1.0]])
    assert compromise(values, np.array([10.0, 10.0])) == 1
    assert compromise(values, np.array([10.0, 5.0])) == 2
    assert compromise(values, np.array([10.0, 1.0])) is None


RIGID = {"casing.model": "rigid"}


def test_the_level_of_the_linearised_machine_is_that_of_the_time_loop():
    """At the orders of the mesh frequency; without the moment of the tooth forces it would be up to 10 dB too low."""
    vary = ("both.tip_relief.amount_um=10,30", "both.tip_relief.length_mm=2,3", "both.lead_crowning_um=0,8")
    study = design_study(
        changed(load_scene("bench"), RIGID), DesignOptions(vary=vary, minimize=("level-motor_side",)), Work()
    )
    for row in study.levels:
        linearised, simulated = (row[f"level-motor_side {name} m/s2"] for name in ("linearised", "time loop"))
        assert linearised == pytest.approx(simulated, rel=0.03)
    variables = study.designs.task.variables
    scene = study.evaluate.scene
    strong = {str(one): (scene, variables.modifications(one)) for one in ([10, 2.0, 0], [30, 3.0, 8])}
    linearised = study.evaluate.results(list(strong.values()), at_scene=True, positions=64).levels[:, 0, 0]
    assert linearised == pytest.approx(study.evaluate.simulated_levels(strong, Work()), rel=0.05)


def test_linearisations_of_two_machines_with_other_flanks_give_the_same_level():
    levels = []
    for relief in (0.0, 30.0):
        both = {f"stages.1.{gear}.tip_relief": {"amount_um": relief, "length_mm": 3.0} for gear in ("pinion", "wheel")}
        scene = changed(load_scene("bench"), RIGID | both | {"faults": [], "deviations.enabled": False})
        graph, machine = scene_graph(scene)
        step = response_step(machine, graph.steps["simulate"], 1, "law_1")
        response = Work().build(Graph([*graph, step]), [step.name]).value(step.name)
        pair = build_pairs(scene, Work())[0]
        cycle = mesh_cycle(pair.pair, LawEvaluator(pair.unmodified), np.array([1000.0]), 0.0, 32)
        levels.append((response.stiffness[0, 0], response.levels(cycle, 1000.0)))
    assert abs(levels[0][0] / levels[1][0] - 1) > 0.1
    assert levels[0][1] == pytest.approx(levels[1][1], rel=1e-3)  # their mesh damping differs a little


def test_gears_of_other_values_keep_centre_distance_and_backlash_and_each_law_is_computed_once(own_cache):
    vary = ("helix_angle_deg=8,10", "both.lead_crowning_um=0,2,4", "pinion_profile_shift=0,0.1")
    study = found(vary=vary, torques=(60.0,))
    assert len(study.designs.index) == 12
    assert len(list(Cache(own_cache).entries("law"))) == 1 + 4
    given = build_pairs(load_scene("bench"), Work())[0].pair
    for at in (0, 7, 11):
        values = study.designs.values(at)
        scene = changed(load_scene("bench"), study.designs.task.variables.settings(values))
        pair = build_pairs(scene, Work())[0]
        assert pair.pair.pinion.helix_angle == pytest.approx(np.radians(values[0]))
        assert pair.pair.axis_distance == pytest.approx(given.axis_distance, abs=1e-9)
        assert scene_graph(scene)[1].layout.pairs[0].backlash == pytest.approx(80e-6, abs=1e-8)
        error = LawEvaluator(pair.healthy).approach_at(60.0 / pair.pair.pinion.base_radius, np.arange(32) / 32)
        assert study.designs.objectives[at, 0] == pytest.approx(1e6 * np.ptp(error), rel=1e-9)
    tables = tomllib.loads(toml(study.settings("A")))["stages"]["1"]
    assert tables["wheel_profile_shift"] == study.settings("A")["stages.1.wheel_profile_shift"]
    assert "lead_crowning_um" in tables["pinion"]


def test_numbers_of_teeth_with_another_ratio_have_no_law_and_those_that_do_not_fit_are_counted():
    options = {"vary": ("pinion_teeth=24:26", "wheel_teeth=30,61,62,63"), "minimize": ("te", "ratio-error")}
    with pytest.warns(
        SceneWarning, match="(?s)4 sets of values of the stage are no gear pairs of this machine.*wheel_prof"
    ):
        study = found(**options, limits=("ratio-error <= 2",))
    teeth = sorted(tuple(study.designs.values(at)) for at in range(len(study.designs.index)))
    assert teeth == [(25, 61), (25, 62)]  # the tips of 63 teeth would cut into the roots of the pinion
    errors = {row["design"]: row["ratio-error %"] for row in study.rows()}
    assert errors["unmodified"] == 0.0
    assert max(errors.values()) <= 2.0
    with pytest.raises(InputError, match="no numbers of teeth meet the limit of ratio-error"):
        found(vary=("pinion_teeth=24,26",), limits=("ratio-error <= 1",))


@pytest.mark.slow
def test_designs_with_less_transmission_error_but_no_lower_level_are_named():
    study = found(minimize=("te", "level"))
    loud, quiet = (
        {"design": name, "te um": 0.1, "level change dB": change} for name, change in (("A", 1.0), ("B", -1.0))
    )
    given = replace(study, levels=({"design": "unmodified", "te um": 0.2, "level change dB": 0.0}, loud, quiet))
    assert "Less transmission error than the unmodified pair, but a level at least as high: A." in lines(given)


def test_an_interrupted_search_continues_and_a_repeated_one_computes_nothing(monkeypatch, own_cache):
    vary, solved, solve = (
        ("both.tip_relief.amount_um=1:60", "both.tip_relief.length_mm=2,3"),
        [],
        flank_candidates.mesh_cycle,
    )

    def counted(*arguments):
        if len(solved) == 100:
            raise KeyboardInterrupt
        solved.append(arguments)
        return solve(*arguments)

    monkeypatch.setattr(flank_candidates, "mesh_cycle", counted)
    with pytest.raises(KeyboardInterrupt):
        found(vary=vary)
    solved[:] = []  # two batches of 48 were complete
    study = found(vary=vary)
    assert len(solved) == 120 - 2 * 48 + 1 + len(study.names)  # 1: the unmodified pair as in the search
    solved[:] = []
    assert np.array_equal(found(vary=vary).designs.objectives, study.designs.objectives)
    assert not solved


def test_a_robust_design_has_the_least_quantile_for_new_deviations_and_misalignments():
    vary = (*VARY, "both.lead_crowning_um=0,5,10")
    nominal_and_robust = found(vary=vary), found(vary=vary, samples=20, misalignment=10e-6)
    designs = [one.designs for one in nominal_and_robust]
    best = [one.task.variables.modifications(one.values(one.front[0])) for one in designs]
    conditions = replace(designs[1].task.conditions, samples=tuple(range(1001, 1051)))
    pair = build_pairs(load_scene("bench"), Work())[0]
    results = flank_candidates.build(conditions, [PairModifications(), *best], laws=(pair.unmodified, pair.unmodified))
    unmodified, nominal, robust = np.quantile(results.peak_to_peak[:, 1:].mean(axis=2), 0.9, axis=1)
    assert robust < 0.9 * nominal < nominal < unmodified


def test_samples_without_kinds_of_deviations_are_those_of_the_misalignment_alone():
    """Without one they are the nominal pair."""
    plain = changed(load_scene("bench"), {"deviations.include": []})
    options = {"vary": VARY, "minimize": ("te:worst", "te:nominal"), "samples": 3}
    aligned, tilted = (
        design_study(plain, DesignOptions(**options, misalignment=most), Work()) for most in (0.0, 20e-6)
    )
    worst, nominal = aligned.designs.objectives.T
    assert worst.tolist() == nominal.tolist()
    assert (tilted.designs.objectives[:, 0] > nominal).any()
    assert "Repeat the search with --set stages.1.mesh.model=solid" in " ".join(lines(tilted))
    assert "Deviations: 3 pairs from seed 1, misalignment up to 20 um." in " ".join(lines(tilted))


def test_without_pymoo_all_combinations_are_evaluated_and_a_larger_search_names_the_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymoo.algorithms.moo.nsga2", None)
    assert len(found().designs.index) == 18
    with pytest.raises(InputError, match=r"pip install 'gearcase\[design\]'"):
        found(evaluations=17)
