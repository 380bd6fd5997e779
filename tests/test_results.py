"""Result folders: whole or absent, never overwritten, the newest named."""

import json
import logging
import os

import pytest

from pipelines import results
from pipelines.errors import InputError


def test_a_folder_appears_when_everything_is_there(tmp_path):
    final = tmp_path / "runs" / "rig" / "now"
    with results.result_folder(final) as folder:
        (folder / results.RESPONSE).write_text("x", encoding="utf-8")
        assert not final.exists()
    assert [p.name for p in final.iterdir()] == [results.RESPONSE]
    assert [p.name for p in final.parent.iterdir()] == ["now"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_failed_run_leaves_nothing(tmp_path, error):
    def run():
        with results.result_folder(tmp_path / "rig" / "now") as folder:
            (folder / results.RESPONSE).write_text("x", encoding="utf-8")
            raise error

    with pytest.raises(error):
        run()
    assert list((tmp_path / "rig").iterdir()) == []


def test_what_a_killed_run_left_is_swept_but_not_what_a_living_one_writes(tmp_path):
    dead, alive = tmp_path / ".partial-a-999999999", tmp_path / f".partial-b-{os.getpid()}"
    dead.mkdir()
    alive.mkdir()
    with results.result_folder(tmp_path / "now"):
        pass
    assert not dead.exists()
    assert alive.exists()


def test_two_runs_in_one_second_do_not_meet(tmp_path):
    names = set()
    for _ in range(3):
        final = results.final_folder("rig", root=tmp_path)
        final.mkdir(parents=True)
        names.add(final.name)
    assert len(names) == 3
    assert not any(":" in name for name in names)


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "mine").mkdir()
    assert results.final_folder("rig", tmp_path / "mine") == tmp_path / "mine"
    (tmp_path / "mine" / "letter").write_text("x", encoding="utf-8")
    with pytest.raises(InputError, match="nothing is overwritten"):
        results.final_folder("rig", tmp_path / "mine")


def test_a_run_is_found_by_folder_and_by_scene(tmp_path):
    folder = tmp_path / "rig" / "now"
    folder.mkdir(parents=True)
    (folder / results.RESPONSE).write_text("x", encoding="utf-8")
    results.note_latest(folder)
    assert results.find_run("rig", root=tmp_path) == folder
    assert results.find_run(folder) == folder
    assert results.find_run(folder.parent) == folder
    with pytest.raises(InputError, match="gearcase run other"):
        results.find_run("other", root=tmp_path)


def test_the_log_is_lines_of_json(tmp_path):
    with results.logged_to(tmp_path / "log.jsonl"):
        logging.getLogger("fem.test").info("made %d", 3, extra={"facts": {"stage": "law_1"}})
    (line,) = (tmp_path / "log.jsonl").read_text(encoding="utf-8").splitlines()
    assert json.loads(line).items() >= {"message": "made 3", "logger": "fem.test", "stage": "law_1"}.items()
