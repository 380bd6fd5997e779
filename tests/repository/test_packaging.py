"""The wheel: everything is in it, and it works in another environment, started from another folder."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest
from lowest_versions import lowest_versions
from sources import ROOT

EXTRAS = ("CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md")
PACKAGES = ("fem", "mbd", "pipelines", "meshes", "gearcase")


def run(*command, **options):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def build_wheel(copy):
    """Built from a copy, so that nothing is left in the source tree; with the build tools of this environment."""
    copy.mkdir(exist_ok=True)
    for name in ("pyproject.toml", "MANIFEST.in", "README.md", "LICENSE", *EXTRAS):
        shutil.copy(ROOT / name, copy / name)
    for name in PACKAGES:
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    options = ("--no-deps", "--no-build-isolation", "--no-index", "--quiet")
    run(sys.executable, "-m", "pip", "wheel", *options, "--wheel-dir", copy / "dist", copy)
    (built,) = (copy / "dist").glob("gearcase-*.whl")
    return built


def install(wheel, folder):
    """Command and interpreter of a new environment that holds the wheel alone and sees the libraries of this one."""
    run(sys.executable, "-m", "venv", "--without-pip", folder)
    bin_folder = folder / ("Scripts" if os.name == "nt" else "bin")
    python = bin_folder / Path(sys.executable).name
    run(sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", "--quiet", wheel)
    site = run(python, "-c", "import sysconfig; print(sysconfig.get_paths()['purelib'])").strip()
    libraries = {sysconfig.get_paths()[kind] for kind in ("purelib", "platlib")}
    (Path(site) / "libraries.pth").write_text("\n".join(sorted(libraries)) + "\n", encoding="utf-8")
    return bin_folder / ("gearcase.exe" if os.name == "nt" else "gearcase"), python


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build_wheel(tmp_path_factory.mktemp("source"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    return install(wheel, tmp_path_factory.mktemp("environment"))


def elsewhere(**changes):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return environment | changes


def test_every_module_scene_and_mesh_is_in_the_wheel(wheel):
    inside = set(zipfile.ZipFile(wheel).namelist())
    patterns = ("*.py", "py.typed", "*.toml", "*.msh", "*.step")
    wanted = {
        p.relative_to(ROOT).as_posix() for package in PACKAGES for q in patterns for p in (ROOT / package).rglob(q)
    }
    assert wanted <= inside
    assert not [name for name in inside if name.startswith(("tests", "benchmarks"))]
    assert any(name.endswith("licenses/LICENSE") for name in inside)
    assert {f"{package}/py.typed" for package in PACKAGES} <= inside


def test_every_list_of_our_packages_is_the_same():
    from fem.processes import child
    from gearcase import shadowed_packages
    from pipelines.engine import code_version

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    packed = {name.removesuffix("*") for name in project["setuptools"]["packages"]["find"]["include"]}
    assert packed == set(PACKAGES) == set(project["setuptools"]["package-data"])
    assert packed == set(project["ruff"]["lint"]["isort"]["known-first-party"])
    assert packed == {*project["mypy"]["packages"], "meshes"}
    assert (
        set(shadowed_packages.PACKAGES)
        == set(child.PACKAGES)
        == packed - {"gearcase"}
        == {*code_version.OWN_PACKAGES, "meshes"}
    )


@pytest.mark.slow
def test_a_type_checker_reads_the_first_page_outside_the_checkout(installed, tmp_path):
    """Strictly, against the installed wheel: names, arguments and results of the door have types."""
    steps = (ROOT / "docs" / "first-steps.md").read_text(encoding="utf-8")
    (page,) = re.findall(r"^```python\n(.*?)^```", steps, re.M | re.S)
    wrong = page + "\nscene.changed(3)\ngearcase.laws(scene, procceses=2)\nlines.nothing_like_this_exists + 1\n"
    for name, text in (("page.py", page), ("wrong.py", wrong)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    words = ["-m", "mypy", "--strict", "--python-executable", installed[1], "--cache-dir", tmp_path / "cache"]
    run(sys.executable, *words, "page.py", cwd=tmp_path, env=elsewhere())
    told = subprocess.run(
        [sys.executable, *map(str, words), "wrong.py"], cwd=tmp_path, env=elsewhere(), capture_output=True, text=True,
        check=False,
    ).stdout  # fmt: skip
    assert 'Argument 1 to "changed" of "Scene" has incompatible type "int"' in told
    assert 'Unexpected keyword argument "procceses" for "laws"' in told


def test_requirements_have_a_lowest_version_and_none_has_a_highest():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    assert len(lowest_versions()) == len(wanted)
    assert [text for text in wanted if "<" in text] == []


@pytest.mark.slow
def test_the_source_archive_makes_the_same_wheel(wheel, tmp_path):
    """A wheel is built from the archive alone, in a folder outside the checkout."""
    options = ("--no-isolation", "--skip-dependency-check", "--outdir", tmp_path)
    run(sys.executable, "-m", "build", "--sdist", *options, wheel.parents[1], cwd=tmp_path)
    (archive,) = tmp_path.glob("gearcase-*.tar.gz")
    shutil.unpack_archive(archive, tmp_path, filter="data")
    (source,) = (path for path in tmp_path.iterdir() if path.is_dir())
    run(sys.executable, "-m", "build", "--wheel", *options, source, cwd=tmp_path)
    (built,) = tmp_path.glob("*.whl")
    names = [set(zipfile.ZipFile(one).namelist()) for one in (wheel, built)]
    assert names[0] == names[1]
    assert (source / "CITATION.cff").is_file()


@pytest.mark.slow
def test_the_installed_command_works_from_another_folder(installed, tmp_path):
    command, python = installed
    where = run(python, "-c", "import pipelines; print(pipelines.__file__)", cwd=tmp_path, env=elsewhere())
    assert not Path(where.strip()).is_relative_to(ROOT)
    assert "20/55" in run(command, "check", "minimal", cwd=tmp_path, env=elsewhere())
    run(command, "new", "my.toml", "--from", "minimal", cwd=tmp_path, env=elsewhere())
    out = run(command, "run", "my.toml", "--quiet", cwd=tmp_path, env=elsewhere())
    report = Path(next(line for line in out.splitlines() if line.startswith("report: ")).removeprefix("report: "))
    assert (tmp_path / report).is_file()


@pytest.mark.slow
def test_the_installed_command_builds_everything_itself(installed, tmp_path):
    out = run(installed[0], "run", "minimal", cwd=tmp_path, env=elsewhere(GEARCASE_CACHE=str(tmp_path / "cache")))
    assert " 0 reused" in out
