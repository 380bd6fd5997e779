"""Users who share one machine: none can plant code or results for another, and each works without a home of its own."""

import os
import shutil
import stat
import subprocess
import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import numba
import numpy
import pytest
from sources import ROOT
from test_packaging import build_wheel

LIBRARIES = sorted({str(Path(module.__file__).parent.parent) for module in (numba, numpy)})
ONE, OTHER = 54321, 54322

PROGRAM = """
import sys
from pathlib import Path
from fem.numerics.compiled import stored
from pipelines.engine.cache import Cache

@stored(__file__)
def twice(x):
    return 2.0 * x

def fill(folder):
    (folder / "value.txt").write_text(sys.argv[1], encoding="utf-8")

KEY = "ab" * 32
cache = Cache()
found = cache.find("law", KEY)
value = found.folder.joinpath("value.txt").read_text(encoding="utf-8") if found else "nothing"
if found is None:
    cache.store("law", KEY, fill)
print(twice(1.5), sum(twice.stats.cache_hits.values()), value)
"""


def run(user, command, cwd, cache, packages):
    """Run a command as a user without a home, whose files everybody could write."""
    names = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "GEARCASE_CACHE")
    environment = {name: value for name, value in os.environ.items() if name not in names}
    environment |= {"HOME": "/nonexistent", **({"GEARCASE_CACHE": str(cache)} if cache else {})}
    environment["PYTHONPATH"] = os.pathsep.join(map(str, (packages, *LIBRARIES)))
    return subprocess.run(
        [str(part) for part in command],
        user=user,
        group=user,
        extra_groups=[],
        umask=0,
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@cache
def interpreter():
    """One that another user can start, of the version for which the libraries were built; None if there is none."""
    if os.name != "posix" or os.geteuid() != 0:
        return None
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    for place in (sys.executable, f"/usr/local/bin/{version}", f"/usr/bin/{version}"):
        try:
            if run(ONE, [place, "-c", "import numba, h5py"], "/", None, ROOT).returncode == 0:
                return place
        except OSError:
            continue
    return None


@pytest.fixture(scope="module", autouse=True)
def another_user():
    """Looked for when a test of this file runs: other users need seconds to import the libraries."""
    if interpreter() is None:
        pytest.skip("only root can act as other users, who must reach an interpreter")


@pytest.fixture
def shared():
    """A folder that everybody can read and write in, like /tmp, with a program in it."""
    folder = Path(tempfile.mkdtemp(prefix="gearcase-shared-"))
    folder.chmod(0o1777)
    (folder / "program.py").write_text(PROGRAM, encoding="utf-8")
    (folder / "program.py").chmod(0o644)
    yield folder
    shutil.rmtree(folder)


def program(user, shared, cache, word):
    done = run(user, [interpreter(), shared / "program.py", word], shared, cache, ROOT)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip(), done.stderr


def test_every_folder_is_the_users_own_and_a_single_file_of_another_user_is_not_run(shared):
    assert program(ONE, shared, shared / "cache", "mine") == ("3.0 0 nothing", "")
    assert program(ONE, shared, shared / "cache", "mine") == ("3.0 1 mine", "")
    made = [shared / "cache", *(path for path in (shared / "cache").rglob("*") if path.is_dir())]
    assert {path.name for path in made} >= {"cache", "entries", "partial", "compiled"}
    assert {(path.stat().st_uid, stat.S_IMODE(path.stat().st_mode)) for path in made} == {(ONE, 0o700)}
    (code,) = (shared / "cache" / "compiled").iterdir()
    os.chown(code, OTHER, OTHER)
    code.chmod(0o644)
    printed, said = program(ONE, shared, shared / "cache", "mine")
    assert printed == "3.0 0 mine"
    assert f"{code} belongs to another user" in said


@pytest.mark.slow
@pytest.mark.parametrize("victim", [OTHER, 0], ids=["another user", "root"])
def test_what_one_user_laid_ready_is_not_used_by_another(shared, victim):
    program(ONE, shared, shared / "cache", "planted")
    for path in (shared / "cache", *(shared / "cache").rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)  # as one who wants it to be read
    for _ in range(2):
        printed, said = program(victim, shared, shared / "cache", "own")
        assert printed == "3.0 0 nothing"
        assert said.count("CacheWarning") == 1
        assert f"belongs to another user (number {ONE})" in said


def test_what_root_laid_ready_is_read_by_all(shared):
    program(0, shared, shared / "cache", "of root")
    for path in (shared / "cache", *(shared / "cache").rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    printed, said = program(ONE, shared, shared / "cache", "own")
    assert printed == "3.0 1 of root"
    assert said == ""


def test_a_user_without_a_home_works_without_a_cache(shared):
    printed, said = program(ONE, shared, None, "own")
    assert printed == "3.0 0 nothing"
    assert said.count("CacheWarning") == 1
    assert "/nonexistent" in said


@pytest.fixture(scope="module")
def installed():
    """The wheel's files, readable by all and writable by none but root."""
    folder = Path(tempfile.mkdtemp(prefix="gearcase-installed-"))
    folder.chmod(0o755)
    with zipfile.ZipFile(build_wheel(folder / "source")) as wheel:
        wheel.extractall(folder / "packages")
    subprocess.run(["chmod", "-R", "a+rX,go-w", str(folder)], check=True)
    yield folder / "packages"
    shutil.rmtree(folder)


@pytest.mark.slow
@pytest.mark.parametrize("cache", ["cache", None])
def test_a_service_account_runs_a_scene_with_a_read_only_installation(installed, shared, cache):
    home = shared / "service"
    home.mkdir()
    os.chown(home, ONE, ONE)
    changes = ("--set", "simulation.end_s=0.05", "--set", "diagnosis.windows_s={}")
    command = [interpreter(), "-P", "-m", "pipelines.cli.main", "simulate", "minimal", *changes, "--quiet"]
    place = cache and home / cache
    done = run(ONE, command, home, place, installed)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("cannot be used") == (0 if cache else 1)
    assert (home / "runs").is_dir()
    if place:
        again = run(ONE, command, home, place, installed)
        assert again.stderr == ""
        assert list((place / "compiled").iterdir())
