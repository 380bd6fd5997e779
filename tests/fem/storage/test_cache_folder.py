"""The cache folder: its owner's alone, marked as ours, and nothing in it is removed or believed that is not ours."""

import os
import stat

import pytest

from fem.storage import cache_folder
from fem.storage.cache_folder import UnusableFolder, cache_root, check_private, claim, make_private
from pipelines.cli.main import main
from pipelines.engine import storage
from pipelines.engine.cache import Cache
from pipelines.io.errors import CacheWarning

KEY = "0123456789abcdef" * 4

posix = pytest.mark.skipif(os.name != "posix", reason="owners and modes as POSIX has them")
root_only = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give a folder to another user"
)


def fill(folder):
    (folder / "a.bin").write_bytes(b"content")


def modes(folder):
    return {path: stat.S_IMODE(path.stat().st_mode) for path in (folder, *folder.rglob("*")) if path.is_dir()}


@pytest.fixture
def careless_user():
    """Files are made so that everybody may write in them."""
    before = os.umask(0)
    yield
    os.umask(before)


@posix
def test_every_folder_is_made_for_its_owner_alone(tmp_path, careless_user):
    cache = Cache(tmp_path / "missing" / "root")
    cache.store("law", KEY, fill)
    made = modes(tmp_path / "missing")
    assert {path.name for path in made} == {"missing", "root", "entries", "partial", f"law-{KEY[:32]}"}
    assert set(made.values()) == {0o700}


@posix
def test_an_empty_folder_becomes_private(tmp_path):
    tmp_path.chmod(0o777)
    Cache(tmp_path).store("law", KEY, fill)
    assert modes(tmp_path)[tmp_path] == 0o700


@posix
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777])
@pytest.mark.parametrize("which", [".", "entries", f"entries/law-{KEY[:32]}"])
def test_a_result_that_others_could_have_written_is_not_believed(tmp_path, which, mode):
    cache = Cache(tmp_path / "root")
    entry = cache.store("law", KEY, fill)
    (cache.folder / which).chmod(mode)
    with pytest.warns(CacheWarning, match=rf"mode {mode:o}.*chmod -R go-w"):
        assert cache.find("law", KEY) is None
    assert (entry.folder / "a.bin").is_file()


@posix
@pytest.mark.parametrize("mode", [0o2770, 0o2775, 0o3770])
def test_a_folder_of_a_group_is_refused_with_the_ways_to_share(tmp_path, mode):
    """It stays as it is, even if it is empty; a folder of one user in it is a cache, as the message proposes."""
    group = tmp_path / "group"
    group.mkdir()
    group.chmod(mode)
    ways = rf"shared by a group \(mode {mode:o}\).*chmod \+t {group}.*GEARCASE_CACHE.*{group}/NAME.*docs/cache\.md"
    with pytest.raises(UnusableFolder, match=ways):
        claim(group, make=True)
    assert stat.S_IMODE(group.stat().st_mode) == mode
    group.chmod(mode | stat.S_ISVTX)
    entry = Cache(group / "NAME").store("law", KEY, fill)
    assert Cache(group / "NAME").find("law", KEY) == entry


@posix
@root_only
def test_what_belongs_to_another_user_is_not_believed(tmp_path):
    cache = Cache(tmp_path / "root")
    cache.store("law", KEY, fill)
    os.chown(cache.folder, 4321, 4321)
    with pytest.warns(CacheWarning, match="belongs to another user"):
        assert cache.find("law", KEY) is None
    assert list(cache.entries()) == []


@posix
def test_who_may_have_written_decides_and_root_is_believed(monkeypatch, tmp_path):
    make_private(tmp_path / "own")
    owner = tmp_path.stat().st_uid
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    if owner == 0:
        check_private(tmp_path / "own")
    else:
        with pytest.raises(UnusableFolder, match="belongs to another user"):
            check_private(tmp_path / "own")


@pytest.mark.parametrize("stranger", ["letter.txt", "entries/important", "partial/draft", "CACHEDIR.TAG"])
@pytest.mark.parametrize("action", ["clear", "verify"])
def test_a_folder_of_another_purpose_is_refused(capsys, own_cache, action, stranger):
    path = own_cache / stranger
    path.parent.mkdir(parents=True)
    path.write_text("Signature: 8a477f597d28d172789f06886806bc55\n# This one is another program's.", encoding="utf-8")
    assert main(["cache", action]) == 2
    assert path.name in capsys.readouterr().err
    with pytest.warns(CacheWarning, match="not a file of gearcase"):
        assert Cache().store("law", KEY, fill) is None
    assert [p for p in own_cache.rglob("*") if p.is_file()] == [path]


def test_clear_and_verify_leave_what_carries_no_manifest(tmp_path):
    cache = Cache(tmp_path)
    cache.store("law", KEY, fill)
    strangers = [tmp_path / "letter.txt", *(tmp_path / folder / "diary" / "1.txt" for folder in ("entries", "partial"))]
    strangers += [tmp_path / "entries" / f"law-{'f' * 32}" / "1.txt", tmp_path / "entries" / "app" / "manifest.json"]
    strangers += [tmp_path / "compiled" / "notes.code"]
    for path in strangers:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("not ours", encoding="utf-8")
        os.utime(path.parent, (0, 0))
    assert cache.verify() == (1, [])
    assert cache.clear()[0] == 1
    cache.store("law", KEY, fill)  # sweeps what is old
    assert all(path.is_file() for path in strangers)


def test_a_cache_of_an_older_version_is_taken_over(tmp_path):
    cache = Cache(tmp_path / "root")
    cache.store("law", KEY, fill)
    (cache.folder / "CACHEDIR.TAG").unlink()
    assert Cache(cache.folder).find("law", KEY) is not None
    assert (cache.folder / "CACHEDIR.TAG").read_text(encoding="utf-8").startswith("Signature: 8a477f597d28d172789f068")


def test_the_root_is_absolute_or_absent(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GEARCASE_CACHE", "here")
    assert cache_root() == tmp_path / "here"
    monkeypatch.delenv("GEARCASE_CACHE")
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda *_, **__: "~/.cache/gearcase")
    with pytest.raises(UnusableFolder, match="there is no home folder"):
        claim(cache_root(), make=True)
    assert not any(tmp_path.iterdir())


def test_a_cache_that_cannot_be_used_is_said_once(tmp_path, recwarn):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    for kind in ("law", "casing"):
        assert Cache(tmp_path / "file" / "cache").find(kind, KEY) is None
        assert Cache(tmp_path / "file" / "cache").store(kind, KEY, fill) is None
    assert [str(warned.message).partition(" cannot")[0] for warned in recwarn] == [f"the cache {tmp_path}/file/cache"]


def test_there_is_one_definition_of_the_cache_warning():
    assert CacheWarning is cache_folder.CacheWarning
    assert storage.CONTENTS == "contents.json"
