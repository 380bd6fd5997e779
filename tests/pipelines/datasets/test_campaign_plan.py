"""Plans: what is drawn, from which distribution, which scenes stay together, and what is refused."""

import json
from collections import Counter

import numpy as np
import pytest

from pipelines.datasets.campaign_scenes import sampled_scenes, scene_key, scene_of, split_groups
from pipelines.datasets.expressions import Expression, ExpressionError
from pipelines.datasets.plan import load_plan
from pipelines.io.errors import InputError, SceneError

SPEED = 'drive.speeds_rpm = [0.0, "$speed", "$speed"]\n'


def plan(folder, text, name="plan"):
    path = folder / f"{name}.toml"
    path.write_text(f'scene = "minimal"\n{text}', encoding="utf-8")
    return load_plan(path)


def column(found, name):
    return np.array([one.values[name] for one in found])


@pytest.mark.parametrize("design", ["random", "latin-hypercube", "sobol"])
def test_draws_follow_their_distribution(tmp_path, design):
    from scipy import stats  # takes most of a second

    text = f"""design = "{design}"
scenes = 512
[variables]
speed = {{ from = 600.0, to = 900.0 }}
mass = {{ distribution = "lognorm", parameters = {{ s = 0.2, scale = 100.0 }} }}
step = {{ distribution = "norm", parameters = {{ loc = 20.0, scale = 5.0 }}, from = 15.0, to = 30.0 }}
seed = {{ from = 1, to = 4 }}
grade = {{ values = [5, 7], weights = [3.0, 1.0] }}
[settings]
{SPEED}load.container_kg = "$mass"
simulation.step_us = "$step"
deviations.seed = "$seed"
deviations.iso_grade = "$grade"
"""
    found = sampled_scenes(plan(tmp_path, text))
    assert len(found) == 512
    cut = stats.truncnorm(-1.0, 2.0, loc=20.0, scale=5.0)
    for name, law in (("speed", stats.uniform(600, 300)), ("mass", stats.lognorm(0.2, scale=100.0)), ("step", cut)):
        assert stats.kstest(column(found, name), law.cdf).pvalue > 1e-3, name
    counts = np.bincount(column(found, "seed"))[1:]
    assert counts.sum() == 512
    assert abs(counts - 128).max() < 50
    assert abs((column(found, "grade") == 5).mean() - 0.75) < 0.08


def test_a_latin_hypercube_has_one_point_in_every_slice(tmp_path):
    text = (
        f'design = "latin-hypercube"\nscenes = 40\n[variables]\nspeed = {{ from = 0.0, to = 1.0 }}\n[settings]\n{SPEED}'
    )
    slices = np.floor(40 * column(sampled_scenes(plan(tmp_path, text)), "speed")).astype(int)
    assert sorted(slices) == list(range(40))


def test_equal_seeds_draw_equal_scenes_and_others_do_not(tmp_path):
    text = f"scenes = 16\n[variables]\nspeed = {{ from = 600.0, to = 900.0 }}\n[settings]\n{SPEED}"
    first, second, other = (
        sampled_scenes(plan(tmp_path, f"seed = {seed}\n{text}", f"p{i}")) for i, seed in enumerate((3, 3, 4))
    )
    assert first == second
    assert not set(column(first, "speed")) & set(column(other, "speed"))


def test_more_scenes_of_a_sobol_plan_begin_with_the_fewer(tmp_path):
    text = f"[variables]\nspeed = {{ from = 600.0, to = 900.0 }}\n[settings]\n{SPEED}"
    few, many = (column(sampled_scenes(plan(tmp_path, f"scenes = {n}\n{text}", f"p{n}")), "speed") for n in (10, 1500))
    assert np.array_equal(few, many[:10])


CASES = """
[cases.state.healthy]
faults = []
[cases.state.missing]
faults = [{ kind = "missing-tooth", stage = 1, gear = "wheel", tooth = "$tooth" }]
"""


def test_a_grid_leaves_out_what_the_scene_does_not_hang_on(tmp_path):
    text = f"""design = "grid"
[variables]
state = ["healthy", "missing"]
tooth = [3, 4, 5]
speed = {{ from = 600.0, to = 900.0, levels = 3 }}
[settings]
{SPEED}{CASES}"""
    found = sampled_scenes(plan(tmp_path, text))
    healthy = [one for one in found if one.values["state"] == "healthy"]
    assert len(healthy) == 3
    assert {one.values["tooth"] for one in healthy} == {None}
    assert len(found) == 3 + 9
    assert [one.run for one in found] == list(range(12))


def test_the_scene_holds_the_values_of_its_draw(tmp_path):
    text = f"""scenes = 8
[variables]
state = ["healthy", "missing"]
tooth = {{ from = 0, to = 9 }}
speed = {{ from = 600.0, to = 900.0 }}
[settings]
drive.speeds_rpm = [0.0, "$speed", "$0.5 * speed + 100"]{CASES}"""
    made = plan(tmp_path, text)
    for one in sampled_scenes(made):
        scene = scene_of(made, one.values).scene
        speed = one.values["speed"]
        assert scene.drive.speeds_rpm == (0.0, speed, 0.5 * speed + 100)
        assert [fault.tooth for fault in scene.faults] == ([] if one.values["tooth"] is None else [one.values["tooth"]])
        assert scene.control is None


@pytest.mark.slow
def test_constraints_hold_in_every_scene(tmp_path):
    text = f"""scenes = 64
constraints = ["speed * mass < 6e4", "speed > 650 or mass < 80"]
[variables]
speed = {{ from = 600.0, to = 900.0 }}
mass = {{ from = 50.0, to = 114.0 }}
[settings]
{SPEED}load.container_kg = "$mass"
"""
    for values in (one.values for one in sampled_scenes(plan(tmp_path, text))):
        assert values["speed"] * values["mass"] < 6e4
        assert values["speed"] > 650 or values["mass"] < 80
    with pytest.raises(InputError, match="Narrow the ranges of the variables"):
        sampled_scenes(plan(tmp_path, text.replace("6e4", "1.0")))


def test_scenes_of_one_specimen_are_never_on_both_sides_of_the_split(tmp_path):
    text = f"""scenes = 200
[variables]
speed = {{ from = 600.0, to = 900.0 }}
specimen = {{ from = 1, to = 20 }}
[settings]
{SPEED}deviations.seed = "$specimen"
[split]
test = 0.25
validation = 0.15
"""
    found = sampled_scenes(plan(tmp_path, text))
    sides = {}
    for one in found:
        sides.setdefault(one.values["specimen"], set()).add(one.split)
    assert all(len(parts) == 1 for parts in sides.values())
    counts = {part: sum(parts == {part} for parts in sides.values()) for part in ("train", "test", "validation")}
    assert counts == {"train": 12, "test": 5, "validation": 3}


def test_a_seed_by_case_keeps_the_scenes_of_its_case_together(tmp_path):
    cases = "".join(f"[cases.unit.{name}]\ndeviations.seed = {seed}\n" for seed, name in enumerate("ABCD", 1))
    text = f"""scenes = 20
[variables]
speed = {{ from = 600.0, to = 900.0 }}
unit = ["A", "B", "C", "D"]
[settings]
{SPEED}
{cases}
[split]
test = 0.25
"""
    found = sampled_scenes(plan(tmp_path, text))
    assert len({(one.values["unit"], one.split) for one in found}) == 4


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_every_label_has_its_share_of_every_part_of_the_split(tmp_path, seed):
    """About a third of the scenes are healthy; by chance alone a part of 4 has none of them in a fifth of all plans."""
    text = f"""scenes = 40
seed = {seed}
[variables]
state = {{ values = ["healthy", "missing"], weights = [1.0, 2.0] }}
speed = {{ from = 600.0, to = 900.0 }}
tooth = {{ from = 0, to = 9 }}
[settings]
{SPEED}{CASES}
[split]
test = 0.3
validation = 0.1
"""
    found = sampled_scenes(plan(tmp_path, text))
    assert Counter(one.split for one in found) == {"train": 24, "test": 12, "validation": 4}
    count = Counter(one.values["state"] for one in found)
    for part, share in (("test", 0.3), ("validation", 0.1)):
        inside = Counter(one.values["state"] for one in found if one.split == part)
        assert all(abs(inside[state] - share * count[state]) < 1.0 for state in count)
    assert [one.split for one in found] == [one.split for one in sampled_scenes(plan(tmp_path, text, "again"))]


def test_labels_have_their_share_also_where_groups_stay_together(tmp_path):
    """60 scenes of 10 gears, each with both labels in other numbers: 3 gears for testing, 18 scenes."""
    text = f"""scenes = 60
design = "random"
[variables]
state = ["healthy", "missing"]
specimen = {{ from = 1, to = 10 }}
tooth = {{ from = 0, to = 9 }}
[settings]
deviations.seed = "$specimen"{CASES}"""
    found = sampled_scenes(plan(tmp_path, text))
    test = [one for one in found if one.split == "test"]
    assert len({one.group for one in test}) == 3
    assert not {one.group for one in test} & {one.group for one in found if one.split == "train"}
    for state, count in Counter(one.values["state"] for one in found).items():
        assert sum(one.values["state"] == state for one in test) == pytest.approx(0.3 * count, abs=2.5)


@pytest.mark.parametrize(("sizes", "expected"), [((32, 43, 25), (3, 4, 3)), ((1, 1, 8), (0, 0, 1))])
def test_groups_of_one_scene_are_apportioned_by_largest_remainders(tmp_path, sizes, expected):
    """Hamilton's method: a tenth of 32, 43 and 25 is 3.2, 4.3 and 2.5; the largest remainder is 0.5."""
    cases = [(name,) for name, size in zip("abc", sizes, strict=False) for _ in range(size)]
    settings = "[variables]\nspeed = { from = 600.0, to = 900.0 }\n[settings]\n" + SPEED
    made = plan(tmp_path, f"scenes = 4\n[split]\ntest = 0.1\n{settings}")
    parts = split_groups(made.table, [str(n) for n in range(len(cases))], cases)
    inside = Counter(case for n, (case,) in enumerate(cases) if parts[str(n)] == "test")
    assert tuple(inside[name] for name in "abc"[: len(sizes)]) == expected


def test_a_key_tells_scenes_apart_and_nothing_else(tmp_path):
    text = f"scenes = 4\n[variables]\nspeed = {{ from = 600.0, to = 900.0 }}\n[settings]\n{SPEED}"
    one, other = plan(tmp_path, text, "one"), plan(tmp_path, f'title = "Another name"\n{text}', "other")
    keys = [[scene_key(scene_of(made, row.values)) for row in sampled_scenes(made)] for made in (one, other)]
    assert keys[0] == keys[1]
    assert len(set(keys[0])) == 4


REFUSED = {
    "design = 'sobl'": "Did you mean",
    "scenes = 4\n[variables]\nx = { from = 1.0, to = 2.0 }": "'x' is not used",
    "scenes = 4\n[variables]\nx = { from = 2.0, to = 1.0 }\n": "less than from",
    "scenes = 4\n[variables]\nx = { distribution = 'poisson' }\n": "not a continuous distribution",
    "scenes = 4\n[variables]\nx = { distribution = 'norm', parameters = { wide = 1.0 } }\n": "does not accept",
    "scenes = 4\n[variables]\nx = [1, 'a']\n": "mixed",
    "scenes = 4\n[variables]\nlabel = [1, 2]\n": "column of every data set",
    "scenes = 4\n[settings]\nload.container_kg = '$x'\n": "'x' is not a variable",
    "scenes = 4\n[settings]\nload.container_kg = '$open(1)'\n": "not allowed",
    "scenes = 4\n[variables]\nx = [0.1, 0.2]\n[settings]\nsimulation.end_s = '$x'\n": "equal in all scenes",
    "scenes = 4\n[variables]\nx = [0.1, 0.2]\n[settings]\ndiagnosis.noise_m_s2 = '$x'\n": "stored signals",
    "scenes = 4\ndesign = 'grid'\n": "delete the key",
    "design = 'grid'\n[variables]\nx = { from = 1.0, to = 2.0 }\n[settings]\nload.container_kg = '$x'\n": "levels",
    "design = 'sobol'\n": "set the number of scenes",
    "scenes = 4\n[variables]\ns = ['a', 'b']\n[cases.s.a]\n": "b has no settings",
    "scenes = 4\n[variables]\ns = ['a']\n[cases.s.a]\n[cases.s.c]\n": "not a value of s",
    "scenes = 4\n[split]\nby = ['x']\n": "'x' is not a variable",
    "scenes = 4\n[split]\ntest = 0.6\nvalidation = 0.5\n": "reduce them below 1",
    "scenes = 4\nconstraints = ['1 <']\n": "not a valid expression",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_makes_no_campaign_is_refused_in_words(tmp_path, text):
    with pytest.raises(SceneError, match=REFUSED[text]):
        plan(tmp_path, text)


@pytest.mark.parametrize(
    "text", ["__import__('os')", "a.b", "[1, 2]", "(lambda: 1)()", "f'{a}'", "a if a else 1", "x" * 501]
)
def test_expressions_understand_arithmetic_alone(text):
    with pytest.raises(ExpressionError):
        Expression(text)


@pytest.mark.parametrize("text", ["1 / 0", "9 ** 9 ** 9", "'a' * 9", "unknown + 1", "log(0 - 1)", "max()"])
def test_an_expression_without_a_value_says_so(text):
    with pytest.raises(ExpressionError):
        Expression(text).value({"a": 1.0})


def test_expressions_have_the_values_of_python():
    values = {"a": 3.0, "b": 2, "c": "x"}
    for text in (
        "a * b - 1",
        "-a ** b",
        "a // b + a % b",
        "1 < b < a",
        "c == 'x' and not a < b",
        "min(a, b) + sqrt(4)",
    ):
        names = {"min": min, "sqrt": np.sqrt}
        assert Expression(text).value(values) == eval(text, names, values)


def test_rows_of_a_plan_can_be_written_as_json(tmp_path):
    text = f"scenes = 3\n[variables]\nspeed = {{ from = 600.0, to = 900.0 }}\n[settings]\n{SPEED}"
    assert json.dumps([one.values for one in sampled_scenes(plan(tmp_path, text))])
