"""Cache: damage is found and rebuilt, a kill leaves nothing half, a cache that cannot be used is only a warning."""

import hashlib
import json
import os
import random
import threading
from dataclasses import dataclass

import numpy as np
import pytest

from fem.storage.records import Record, array
from pipelines.engine.cache import Cache
from pipelines.engine.storage import StorageError, digest, flat, reader, save_value
from pipelines.io.errors import CacheWarning

KEY = "0123456789abcdef" * 4


@dataclass(frozen=True, eq=False, kw_only=True)
class Curve(Record):
    value: np.ndarray = array("position", units="N")


def fill(folder, size=1000):
    (folder / "a.bin").write_bytes(bytes(range(256)) * (size // 256 + 1))
    (folder / "b.txt").write_text("content", encoding="utf-8")


def files_of(entry):
    return sorted(p for p in entry.folder.rglob("*") if p.is_file())


def test_stored_then_found_with_its_facts(tmp_path):
    cache = Cache(tmp_path)
    assert cache.find("law", KEY) is None
    cache.store("law", KEY, fill, {"seconds": 1.5})
    entry = cache.find("law", KEY)
    assert entry.facts["seconds"] == 1.5
    assert (entry.folder / "b.txt").read_text(encoding="utf-8") == "content"
    assert not any((tmp_path / "partial").iterdir())


def test_names_are_good_on_every_system(tmp_path):
    entry = Cache(tmp_path).store("law", KEY, fill)
    for path in entry.folder.parent.rglob("*"):
        assert not set(path.name) & set('<>:"/\\|?*')
        assert not path.is_symlink()


@pytest.mark.parametrize("damage", ["flip", "truncate", "delete", "grow"])
@pytest.mark.parametrize("which", [0, 1, 2])
def test_a_damaged_entry_is_named_removed_and_built_again(tmp_path, damage, which):
    cache = Cache(tmp_path)
    entry = cache.store("law", KEY, fill, {"seconds": 1.5})
    path = files_of(entry)[which]
    content = bytearray(path.read_bytes())
    if damage == "flip":
        place = random.Random(which).randrange(len(content) * 8)
        content[place // 8] ^= 1 << place % 8
        path.write_bytes(content)
    elif damage == "truncate":
        path.write_bytes(content[: len(content) // 2])
    elif damage == "grow":
        path.write_bytes(content + b" x")
    else:
        path.unlink()
    with pytest.warns(CacheWarning, match=entry.name):
        assert cache.find("law", KEY) is None
    assert cache.store("law", KEY, fill) is not None
    assert cache.find("law", KEY) is not None


def test_a_quick_look_verifies_the_manifest_and_the_sizes_only(tmp_path):
    cache = Cache(tmp_path)
    entry = cache.store("law", KEY, fill)
    (entry.folder / "b.txt").write_text("cOntent", encoding="utf-8")
    assert cache.find("law", KEY, thorough=False) is not None
    with pytest.warns(CacheWarning):
        assert cache.find("law", KEY) is None


def test_every_flipped_bit_of_a_manifest_is_noticed_or_harmless(tmp_path):
    """A flip may hit white space of the JSON text; what is then read must be what was written."""
    cache = Cache(tmp_path)
    entry = cache.store("law", KEY, fill, {"seconds": 1.5, "step": "law_1"})
    path = entry.folder / "manifest.json"
    good = path.read_bytes()
    for place in random.Random(7).sample(range(len(good) * 8), 60):
        bad = bytearray(good)
        bad[place // 8] ^= 1 << place % 8
        path.write_bytes(bad)
        found = list(cache.entries())
        assert not found or found[0].facts == entry.facts


def test_two_writers_of_one_entry_do_not_disturb_each_other(tmp_path):
    start = threading.Barrier(8)
    entries = []

    def write():
        start.wait()
        entries.append(Cache(tmp_path).store("law", KEY, fill))

    threads = [threading.Thread(target=write) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(entry is not None for entry in entries)
    assert Cache(tmp_path).verify() == (1, [])


def test_a_write_that_fails_leaves_nothing(tmp_path):
    def stop(folder):
        fill(folder)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Cache(tmp_path).store("law", KEY, stop)
    assert Cache(tmp_path).find("law", KEY) is None
    assert not any((tmp_path / "partial").iterdir())


def test_a_full_disk_is_a_warning(tmp_path):
    def full(folder):
        raise OSError(28, "No space left on device")

    cache = Cache(tmp_path)
    with pytest.warns(CacheWarning, match=r"No space left.*Free space"):
        assert cache.store("law", KEY, full) is None
    assert cache.store("law", KEY, full) is None  # said once


def test_a_folder_that_cannot_be_made_is_a_warning(tmp_path):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.warns(CacheWarning, match="GEARCASE_CACHE"):
        assert Cache(tmp_path / "file" / "cache").store("law", KEY, fill) is None


def test_what_a_killed_process_left_is_swept_after_a_day(tmp_path):
    left = tmp_path / "partial" / "1-0123456789ab"
    left.mkdir(parents=True)
    os.utime(left, (0, 0))
    Cache(tmp_path).store("law", KEY, fill)
    assert not left.exists()


def test_clear_removes_only_what_is_old_enough_and_ours(tmp_path):
    cache = Cache(tmp_path)
    cache.store("law", KEY, fill)
    (tmp_path / "letter.txt").write_text("not ours", encoding="utf-8")
    old = cache.store("law", KEY[::-1], fill)
    os.utime(old.folder / "manifest.json", (0, 0))
    assert cache.clear(older_than_days=30)[0] == 1
    assert len(list(cache.entries())) == 1
    assert cache.clear()[0] == 1
    assert {p.name for p in tmp_path.iterdir()} == {"letter.txt", "CACHEDIR.TAG"}


def test_verify_counts_and_removes(tmp_path):
    cache = Cache(tmp_path)
    cache.store("law", KEY, fill)
    bad = cache.store("law", KEY[::-1], fill)
    (bad.folder / "a.bin").write_bytes(b"")
    sound, removed = cache.verify()
    assert sound == 1
    assert "a.bin has 0 bytes" in removed[0]


RECORD = {"kind": "record", "type": "fem.contact.law:MeshLaw", "file": "part_1.h5"}


def nested(depth):
    node = {"kind": "plain", "value": 1}
    for _ in range(depth):
        node = {"kind": "list", "items": [node]}
    return json.dumps(node)


FORGED = {
    "a class of another program": {**RECORD, "type": "forged:Program"},
    "a class of the library": {"kind": "dataclass", "type": "subprocess:Popen", "items": {}},
    "a class that ours has imported": {
        "kind": "dataclass",
        "type": "fem.processes.executor:subprocess.Popen",
        "items": {},
    },
    "a function": {"kind": "dataclass", "type": "pipelines.cli.main:main", "items": {}},
    "a class that is no record": {**RECORD, "type": "pipelines.engine.cache:Cache"},
    "a module that is not there": {**RECORD, "type": "pipelines.absent:Record"},
    "no class": {**RECORD, "type": ["fem"]},
    "a file above": {**RECORD, "file": "../part_1.h5"},
    "a file elsewhere": {"kind": "bytes", "file": "/etc/passwd"},
    "a link": {"kind": "bytes", "file": "part_2.bin"},
    "a file that is not there": {"kind": "array", "file": "part_9.npy"},
    "no file": {"kind": "text", "file": 5},
    "other fields": {"kind": "dataclass", "type": "pipelines.io.errors:Problem", "items": {"command": RECORD}},
    "an unknown kind": {"kind": "pickle", "file": "part_1.h5"},
    "no kind": {"items": []},
    "not a table": [1, 2],
    "items of the wrong type": {"kind": "list", "items": {"a": 1}},
    "a plain value that is not": {"kind": "plain", "value": {"a": 1}},
    "depth": nested(300),
    "depth beyond the reader": "[" * 200_000,
    "not JSON": "\0",
}


@pytest.mark.parametrize("contents", FORGED.values(), ids=FORGED)
def test_forged_contents_with_good_checksums_are_damage(tmp_path, monkeypatch, contents):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "forged.py").write_text("raise SystemExit('the forged entry ran a program')", encoding="utf-8")

    def forge(folder):
        (folder / "part_1.h5").write_bytes(b"not a record")
        if contents == FORGED["a link"]:
            (folder / "part_2.bin").symlink_to("/etc/passwd")
        text = contents if isinstance(contents, str) else json.dumps(contents)
        (folder / "contents.json").write_text(text, encoding="utf-8")

    cache = Cache(tmp_path / "cache")
    with pytest.warns(CacheWarning):
        cache.store("law", KEY, forge)
    with pytest.warns(CacheWarning, match=f"law-{KEY[:32]} is damaged"):
        assert cache.find("law", KEY) is None
    assert cache.store("law", KEY, fill) is not None


def manifest_of(entry, change):
    """Write a changed manifest with a good checksum."""
    path = entry.folder / "manifest.json"
    body = json.loads(path.read_text(encoding="utf-8"))["body"]
    change(body)
    total = hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()
    path.write_text(json.dumps({"body": body, "sha256": total}), encoding="utf-8")


FORGED_MANIFESTS = {
    "facts": lambda body: body.update(facts=[1]),
    "files": lambda body: body.update(files=["a.bin"]),
    "file above": lambda body: body["files"].update({"../secret": {"bytes": 0, "sha256": ""}}),
    "file elsewhere": lambda body: body["files"].update({"/etc/passwd": {"bytes": 0, "sha256": ""}}),
    "size": lambda body: body["files"]["a.bin"].update(bytes="many"),
    "checksum": lambda body: body["files"]["a.bin"].update(sha256=1),
    "kind": lambda body: body["facts"].update(kind=5),
    "key": lambda body: body["facts"].update(key={"a": 1}),
    "another key": lambda body: body["facts"].update(key=KEY[::-1]),
    "empty": lambda body: body.clear(),
}


@pytest.mark.parametrize("change", FORGED_MANIFESTS.values(), ids=FORGED_MANIFESTS)
def test_a_forged_manifest_with_a_good_checksum_is_damage(tmp_path, change):
    cache = Cache(tmp_path)
    entry = cache.store("law", KEY, fill)
    manifest_of(entry, change)
    assert list(cache.entries()) == []
    with pytest.warns(CacheWarning, match=f"{entry.name} is damaged"):
        assert cache.find("law", KEY) is None


@pytest.mark.parametrize("text", ["[" * 200_000, "[]", "1", '"a"', "", '{"body": 1, "sha256": 2}', "\udc80"])
def test_a_manifest_of_any_text_is_damage(tmp_path, text):
    cache = Cache(tmp_path)
    entry = cache.store("law", KEY, fill)
    (entry.folder / "manifest.json").write_bytes(text.encode("utf-8", "surrogatepass"))
    assert cache.verify()[1][0].startswith(entry.name)
    assert cache.find("law", KEY) is None


def values():
    import xarray

    data = xarray.Dataset({"a": ("time", [1.0, np.pi])}, coords={"time": [0.0, 0.1]}, attrs={"load": "rope"})
    return {
        "curve": Curve(value=[0.1, 1 / 3]),
        "data": data,
        "array": np.arange(6, dtype=np.int32).reshape(2, 3),
        "page": "ü" * 500,
        "bytes": b"\x00\xff",
        "nested": {"list": [1, 2.5, None, True, "x"], "pair": (1, Curve(value=[2.0]))},
    }


def test_values_come_back_with_the_same_bits(tmp_path):
    save_value(tmp_path, values())
    loaded = reader(tmp_path)()
    assert digest(loaded) == digest(values())
    assert loaded["page"] == "ü" * 500
    assert isinstance(loaded["nested"]["pair"], tuple)
    assert loaded["data"].a.values.tobytes() == values()["data"].a.values.tobytes()


def test_the_digest_sees_every_part():
    original = digest(values())
    changed = [values() for _ in range(3)]
    changed[0]["curve"] = Curve(value=[0.1, np.nextafter(1 / 3, 1)])
    changed[1]["data"].attrs["load"] = "torque"
    changed[2]["nested"]["list"][1] = 2.6
    assert len({original, *map(digest, changed)}) == 4


def test_what_cannot_be_stored_is_refused():
    with pytest.raises(StorageError, match="object"):
        digest({"x": object()})


def test_flat_names_leaves_as_a_user_would():
    tree = {"stages": [{"teeth": 20}, {"teeth": 21}], "times": (0.0, 1.0)}
    assert flat(tree) == {"stages.1.teeth": 20, "stages.2.teeth": 21, "times": [0.0, 1.0]}


def test_one_at_a_time_may_build_a_result(tmp_path):
    cache, key = Cache(tmp_path / "cache"), "ab" * 32
    with cache.alone(key) as first, cache.alone(key) as second, cache.alone("cd" * 32) as other:
        assert (first, second, other) == (True, False, True)
    with cache.alone(key) as again:
        assert again
    assert not list((tmp_path / "cache" / "partial").iterdir())


def test_the_right_to_build_of_a_killed_process_is_free_and_swept(tmp_path):
    cache, key = Cache(tmp_path / "cache"), "ab" * 32
    with cache.alone(key):
        pass
    left = tmp_path / "cache" / "partial" / f"0-{key[:12]}"
    left.touch()
    cache.clear()
    assert not left.exists()
    left.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    left.touch()
    with cache.alone(key) as mine:
        assert mine
