"""The check of a data set finds every kind of damage and names the run; a sound one passes, a growing one too."""

import json
import shutil

import numpy as np
import pyarrow.parquet as pq
import pytest
from datasets import PLAN, make_dataset, signals

from pipelines.cli.main import main
from pipelines.datasets.campaign_scenes import group_words
from pipelines.datasets.dataset_check import check_dataset
from pipelines.datasets.rows import TABLE, read_row, row_path, write_row, write_table
from pipelines.datasets.store import SIGNALS, chunk_path, write_run
from pipelines.datasets.summary import stretches, summarised
from pipelines.datasets.variables_grid import varied_grid


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("check") / "sound", failed=(4,))


@pytest.fixture
def folder(sound, tmp_path):
    return shutil.copytree(sound, tmp_path / "copy")


def changed(folder, run, **changes):
    write_row(folder, run, read_row(folder, run) | changes)
    write_table(folder)


def test_a_sound_data_set_passes(sound, capsys):
    assert main(["dataset", "check", str(sound)]) == 0
    assert capsys.readouterr().out == "8 rows of 8 runs checked: 0 errors, 0 warnings\n"


def test_a_growing_data_set_passes_with_notes(tmp_path):
    folder = make_dataset(tmp_path / "growing", left_out=(2, 5))
    write_run(folder, 5, signals(5, 900.0))
    found = check_dataset(folder)
    assert not found.wrong
    assert found.rows == 6
    assert any("1 run without a row, but with signals (5)" in note for note in found.notes)
    assert any(TABLE in note for note in found.notes)


def another_signal(folder):
    write_run(folder, 2, signals(3, 900.0))


def no_chunk(folder):
    chunk_path(folder, "shaft_angle", 2, 2).unlink()


def damaged_chunk(folder):
    path = chunk_path(folder, "acceleration", 2, 3)
    path.write_bytes(path.read_bytes()[:-40])


def not_a_number(folder):
    values = signals(2, 900.0)
    values["acceleration"][0, 0, 7] = np.nan
    changed(folder, 2, checksums=write_run(folder, 2, values))


def another_label(folder):
    row = read_row(folder, 2)
    other = "healthy" if row["labels"]["label"] != "healthy" else "missing-tooth"
    changed(folder, 2, labels=row["labels"] | {"label": other})


def another_value(folder):
    changed(folder, 2, values=read_row(folder, 2)["values"] | {"speed_rpm": 777.0})


def another_split(folder):
    changed(folder, 2, split="test" if read_row(folder, 2)["split"] == "train" else "train")


def damaged_row(folder):
    row_path(folder, 2).write_text('{"run": 2, ', encoding="utf-8")


def incomplete_row(folder):
    changed(folder, 2, checksums=None)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (another_signal, "acceleration was changed after it was written"),
        (no_chunk, "shaft_angle is not stored"),
        (damaged_chunk, "acceleration of run 2 cannot be read"),
        (not_a_number, "acceleration has 1 NaN or infinite values"),
        (another_label, "its label is"),
        (another_value, "its values differ from those of the plan"),
        (another_split, "its split differ from those of the plan"),
        (damaged_row, "the row cannot be read"),
        (incomplete_row, "its row is incomplete"),
    ],
)
def test_damage_is_found_with_its_run_and_remedy(folder, capsys, damage, said):
    damage(folder)
    assert main(["dataset", "check", str(folder)]) == 1
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("error: run 2:")]
    assert any(said in line and "Delete" in line for line in lines), lines
    assert {line.split(":")[1] for line in lines} == {" run 2"}


def test_a_row_that_the_plan_does_not_have_is_found(folder):
    write_row(folder, 8, read_row(folder, 1) | {"run": 8})
    assert any(text.startswith("run 8: the plan has only 8 runs") for text in check_dataset(folder).wrong)


def test_one_scene_in_two_parts_of_the_split_leaks_and_must_have_one_signal(folder):
    first = next(r for r in range(1, 8) if read_row(folder, r)["split"] != read_row(folder, 0)["split"] and r != 4)
    changed(folder, first, key=read_row(folder, 0)["key"])
    found = check_dataset(folder)
    assert any("the split leaks" in text for text in found.wrong)
    assert any("has other signals" in text for text in found.wrong)
    assert found.notes == ["1 run with the scene of another run (same key), which random samples may give"]


def test_a_table_that_differs_from_the_rows_is_found(folder):
    table = pq.read_table(folder / TABLE)
    column = table.schema.get_field_index("speed_rpm")
    values = table.column(column).to_pylist()
    values[3] += 1.0
    pq.write_table(table.set_column(column, "speed_rpm", [values]), folder / TABLE)
    assert [text.split(". ")[0] for text in check_dataset(folder).wrong] == [
        "rows.parquet: speed_rpm of run 3 differ from its row"
    ]
    pq.write_table(table.slice(1, 6), folder / TABLE)
    assert [text.split(". ")[0] for text in check_dataset(folder).wrong] == ["rows.parquet: the runs 0, 7 are missing"]
    (folder / TABLE).write_bytes(b"PAR1")
    assert "cannot be read" in check_dataset(folder).wrong[0]


def test_info_counts_what_is_there(folder, capsys):
    row_path(folder, 6).unlink()
    assert main(["dataset", "info", str(folder)]) == 0
    text = capsys.readouterr().out
    assert "8: 6 done, 1 failed, 1 not done; without a row: 6" in text
    assert "uniform from 600 to 1500" in text
    assert "one of healthy, missing" in text
    assert "groups of equal seed" in text
    assert group_words(()).endswith("all with the same pair of gears (deviations.seed is constant)")
    found = summarised(folder)
    assert sum(found.labels.values()) == sum(found.splits.values()) == 6
    assert found.bytes > 5 * 6 * 4000 * 4 * 0.1


def test_info_of_a_folder_without_rows(tmp_path, capsys):
    folder = make_dataset(tmp_path / "empty", left_out=range(8))
    assert main(["dataset", "info", str(folder)]) == 0
    assert "8 not done" in capsys.readouterr().out
    assert main(["dataset", "info", str(tmp_path)]) == 2


def test_every_way_to_vary_has_its_words(tmp_path):
    plan = PLAN.replace(
        "seed = { from = 1, to = 6 }",
        "seed = { from = 1, to = 6 }\n"
        'iron = { distribution = "norm", parameters = { loc = 110.0, scale = 5.0 }, from = 100.0 }',
    ).replace('["healthy", "missing"]', '{ values = ["healthy", "missing"], weights = [1.0, 3.0] }')
    plan = plan.replace("simulation.end_s", 'casing.material.elastic_modulus_GPa = "$iron"\nsimulation.end_s')
    text = summarised(make_dataset(tmp_path / "ways", plan)).to_text()
    assert "norm of scipy.stats (loc 110, scale 5), only from 100" in text
    assert "one of healthy (25 %), missing (75 %)" in text
    assert max(len(line) for line in text.splitlines()) <= 100


def test_keys_of_many_bearings_that_a_variable_sets_are_one():
    bearings = {str(number): {"cage_slip": "$slip"} for number in range(1, 5)}
    shafts = {str(number): {"bearings": bearings} for number in range(1, 5)}
    variable = {"from": 0.0, "to": 1.0}
    plan = {"variables": {"slip": variable}, "cases": {}, "settings": {"shafts": shafts, "stages": {"1": {"a": "$z"}}}}
    assert varied_grid(plan, {}).rows[0][2] == "shafts.*.bearings.*.cage_slip"
    assert varied_grid(plan | {"variables": {"z": variable}}, {}).rows[0][2] == "stages.1.a"


def test_stretches_of_runs():
    assert stretches((1, 2, 3, 7, 9, 10)) == "1-3, 7, 9-10"
    assert stretches(tuple(range(0, 100, 2))).endswith("18 ...")


def test_the_facts_of_another_version_are_refused_with_the_remedy(folder, capsys):
    path = folder / "campaign.json"
    facts = json.loads(path.read_text(encoding="utf-8"))
    facts["facts"]["plan"]["design"] = "spiral"
    path.write_text(json.dumps(facts), encoding="utf-8")
    assert main(["dataset", "check", str(folder)]) == 2
    assert "Another version of gearcase" in capsys.readouterr().err
    assert (folder / SIGNALS).is_dir()
