"""Result folders: safe names, the newest one of a scene, the log."""

import json
import logging
from concurrent.futures import ThreadPoolExecutor

import pytest

from pipelines.io.errors import InputError
from pipelines.runs import run_folder


def test_a_run_is_found_by_folder_and_by_scene(tmp_path):
    folder = tmp_path / "rig" / "now"
    folder.mkdir(parents=True)
    (folder / run_folder.RESPONSE).write_text("x", encoding="utf-8")
    run_folder.note_latest(folder)
    assert run_folder.find_run("rig", root=tmp_path) == folder
    assert run_folder.find_run(folder) == folder
    assert run_folder.find_run(folder.parent) == folder
    with pytest.raises(InputError, match="gearcase runs"):
        run_folder.find_run("other", root=tmp_path)


def test_the_newest_result_can_be_noted_by_many_at_once(tmp_path):
    folders = [tmp_path / str(number) for number in range(16)]
    with ThreadPoolExecutor(16) as pool:
        list(pool.map(run_folder.note_latest, folders * 4))
    assert (tmp_path / run_folder.LATEST).read_text(encoding="utf-8").strip() in {folder.name for folder in folders}
    assert [path.name for path in tmp_path.iterdir()] == [run_folder.LATEST]


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("rig", "rig"),
        ("Wägezelle 2", "Wägezelle 2"),
        (".rig", "rig"),
        ("rig. .", "rig"),
        ("motor: a/b\\c", "motor_ a_b_c"),
        ("rig\x1b[2J", "rig_[2J"),
        ("rig\udcff", "rig_"),
        ("console", "console"),
    ],
)
def test_a_scene_name_is_one_visible_folder_on_every_system(name, folder):
    assert run_folder.folder_name(name) == folder


@pytest.mark.parametrize("name", ["", ".", "..", ". .", "CON", "nul", "com1", "Lpt9.v2", "aux .x", "COM\u00b2"])
def test_a_name_that_no_folder_can_have_is_refused(name):
    with pytest.raises(InputError, match="Rename the file"):
        run_folder.folder_name(name)


@pytest.mark.parametrize("name", ["..", ".", "CON"])
def test_a_scene_file_with_such_a_name_is_refused_by_every_command(tmp_path, monkeypatch, capsys, name):
    from pipelines.cli.main import main

    (tmp_path / "below").mkdir()
    monkeypatch.chdir(tmp_path / "below")
    (tmp_path / "below" / f"{name}.toml").write_text('extends = "minimal"\n', encoding="utf-8")
    assert main(["check", f"{name}.toml"]) == 2
    assert "Rename the file" in capsys.readouterr().err


def test_a_run_is_found_by_the_path_of_its_scene_file(tmp_path):
    folder = tmp_path / "my_scene" / "now"
    folder.mkdir(parents=True)
    (folder / run_folder.RESPONSE).write_text("x", encoding="utf-8")
    run_folder.note_latest(folder)
    assert run_folder.find_run("scenes/my:scene.toml", root=tmp_path) == folder


def test_the_log_is_lines_of_json(tmp_path):
    with run_folder.logged_to(tmp_path / "log.jsonl"):
        logging.getLogger("fem.test").info("made %d", 3, extra={"facts": {"stage": "law_1"}})
    (line,) = (tmp_path / "log.jsonl").read_text(encoding="utf-8").splitlines()
    assert json.loads(line).items() >= {"message": "made 3", "logger": "fem.test", "stage": "law_1"}.items()


def test_a_full_disk_ends_the_log_and_not_the_work(tmp_path, caplog):
    class Full:
        def write(self, _):
            raise OSError(28, "No space left on device")

        def flush(self):
            raise OSError(28, "No space left on device")

        def close(self):
            pass

    logger = logging.getLogger("pipelines")
    with run_folder.logged_to(tmp_path / "log.jsonl"):
        handler = next(h for h in logger.handlers if isinstance(h, run_folder.JsonLines))
        handler.stream.close()
        handler.stream = Full()
        logger.info("made")
    assert "is incomplete" in caplog.text
