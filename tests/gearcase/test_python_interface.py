"""The public door `import gearcase`: its examples run, it prints nothing, it names what hides its packages."""

import doctest
import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from sources import ROOT

import gearcase
from gearcase import shadowed_packages
from pipelines.report.figures import render

MODULES = (
    "campaigns",
    "casings",
    "datasets",
    "errors",
    "machines",
    "pair_laws",
    "progress",
    "recordings",
    "reduction",
    "results",
    "scenes",
    "studies",
)
FAULT = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}
SHORT = {
    "simulation.end_s": 0.05, "drive.times_s": [0.0, 0.02, 0.05], "diagnosis.windows_s": {},
}  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    return gearcase.Scene.from_file("minimal")


@pytest.fixture(scope="module")
def faulty(scene):
    return scene.changed(faults=[FAULT], diagnosis={"gear": "pinion"})


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_the_docstrings_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-S", "-c", "pass"])  # see test_report_contents
    found = doctest.testmod(
        importlib.import_module(f"gearcase.{name}"), optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    )
    assert found.failed == 0


def test_every_function_and_class_of_the_door_has_an_example():
    ours = [getattr(gearcase, name) for name in gearcase.__all__]
    told = [one for one in ours if one.__module__.startswith("gearcase.")]
    assert len(told) == 24
    assert all(">>> import gearcase" in one.__doc__ for one in told)


def test_the_names_for_the_type_checker_are_those_of_the_door():
    text = (ROOT / "gearcase" / "__init__.py").read_text(encoding="utf-8")
    typed = re.findall(r"^    from gearcase\.(\w+) import (\w+) as \2$", text, re.M)
    assert sorted(name for _, name in typed) == gearcase.__all__
    for place, name in typed:
        assert getattr(gearcase, name) is getattr(importlib.import_module(f"gearcase.{place}"), name)
    with pytest.raises(AttributeError, match="no attribute 'wheels'"):
        gearcase.wheels  # noqa: B018


def test_every_name_of_the_door_has_its_row_in_the_guide():
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    assert not [name for name in gearcase.__all__ if f"`{name}" not in text]


def test_the_import_takes_no_library():
    code = "import sys, gearcase; print(sorted({'numpy', 'pydantic', 'xarray', 'pipelines'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_nothing_is_printed_and_progress_is_told(scene, capfd):
    steps = []
    wide = scene.changed({"stages.1.face_width_mm": 13.25})
    gearcase.laws(wide, progress=steps.append)
    gearcase.laws(wide, progress=steps.append)
    assert [(step.name, step.state) for step in steps] == [
        ("law_1", "started"), ("law_1", "built"), ("law_1", "reused"),
    ]  # fmt: skip
    assert capfd.readouterr() == ("", "")


def test_a_scene_from_tables_is_the_scene_from_a_file(scene):
    built = gearcase.Scene.from_dict(scene.to_dict())
    assert built.to_toml() == scene.to_toml()
    assert gearcase.Scene.from_dict({"extends": "minimal", "title": "mine"}).title == "mine"


def test_values_are_given_by_path_or_by_table(scene):
    by_path = scene.changed({"load.container_kg": 80, "stages.1.face_width_mm": 13})
    by_table = scene.changed(load={"container_kg": np.int64(80)}, stages={1: {"face_width_mm": 13}})
    assert by_path.to_toml() == by_table.to_toml()
    assert scene.to_dict()["load"]["container_kg"] == 114.0


def test_a_preset_leaves_what_was_set(scene):
    asked = scene.changed({"simulation.step_us": 7.0}).changed(preset="draft").to_dict()
    assert asked["simulation"]["step_us"] == 7.0
    assert asked["stages"][0]["mesh"]["model"] == "solid"
    with pytest.raises(gearcase.InputError, match="Set one of draft, standard, reference"):
        scene.changed(preset="finest")


def test_what_is_wrong_with_tables_is_an_error_of_the_scene(scene):
    with pytest.raises(gearcase.SceneError, match="Did you mean container_kg"):
        scene.changed(load={"container": 3})
    with pytest.raises(gearcase.SceneError, match="control characters"):
        scene.changed(title="a\x1b[2J")
    with pytest.raises(gearcase.SceneError, match="title"):
        gearcase.Scene.from_dict({})


def test_a_missing_tooth_lowers_the_stiffness_while_it_should_mesh_and_nowhere_else(faulty):
    curve = gearcase.laws(faulty)[0].curve()
    assert {name: curve[name].units for name in curve} == {
        "secant": "N/m", "tangent": "N/m", "transmission_error": "m", "no_load_error": "m",
    }  # fmt: skip
    healthy, missing = (curve.secant.sel(state=state) for state in ("healthy", "faulty"))
    lower = curve.cycle.values[(missing < 0.99 * healthy).values]
    assert lower.size > 10
    assert np.all(np.abs(lower) < 2.0)
    far = np.abs(curve.cycle.values) > 2.0
    assert np.allclose(missing.values[far], healthy.values[far], rtol=1e-9)


def test_a_healthy_pair_has_one_state_over_one_cycle(scene):
    curve = gearcase.laws(scene)[0].curve()
    assert list(curve.state.values) == ["healthy"]
    assert curve.sizes["cycle"] == 200


def test_casing_modes_of_a_rigid_casing_are_those_of_its_body_on_its_mounts(scene):
    found = gearcase.casing(scene)
    whirl = np.linalg.eigvals(np.linalg.solve(found.body.mass, found.body.stiffness))
    assert np.allclose(np.sort(np.sqrt(whirl.real)) / (2 * np.pi), found.frequencies)
    with pytest.raises(gearcase.InputError, match="no finite elements to compare with"):
        gearcase.casing(scene, error_check=True)


def test_run_open_run_and_simulate_give_the_same_signals(scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-S", "-c", "pass"])  # see test_report_contents
    short = scene.changed(SHORT)
    finished = gearcase.run(short)
    again = gearcase.open_run("minimal")
    assert finished.attrs["folder"] == again.attrs["folder"]
    assert (Path(finished.attrs["folder"]) / "report.html").is_file()
    for signals in (again, gearcase.simulate(short)):
        xarray.testing.assert_equal(finished.drop_attrs(), signals.drop_attrs())
    with pytest.raises(gearcase.InputError, match=r"diagnosis\.windows_s"):
        gearcase.diagnose(again)
    with pytest.raises(gearcase.InputError, match="no result folder"):
        gearcase.diagnose(gearcase.simulate(short))


SIGNALS = xarray.Dataset(coords={"time": [0.0, 1.0]})


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: gearcase.judge(3, [], "minimal"), "recording = 3: must be an xarray.Dataset. Give the signals"),
        (lambda: gearcase.judge(xarray.Dataset(), [], "minimal"), "recording: the dataset has no coordinate time."),
        (lambda: gearcase.judge(SIGNALS, 3, "minimal"), "healthy = 3: must be a list of recordings."),
        (lambda: gearcase.judge(SIGNALS, SIGNALS, "minimal"), "healthy: is of type Dataset, and must be a list"),
        (lambda: gearcase.judge(SIGNALS, [SIGNALS, "x"], "minimal"), 'healthy[1] = "x": must be an xarray.Dataset.'),
        (lambda: gearcase.judge(SIGNALS, [], 3), "machine = 3: must be text or a path: a machine file, a scene file"),
        (lambda: gearcase.compare([SIGNALS], "minimal"), "recordings: is of type list, and must be recordings by name"),
        (lambda: gearcase.compare({"a": 1}, "minimal"), 'recordings["a"] = 1: must be an xarray.Dataset.'),
        (lambda: gearcase.spectrum("x"), 'signal = "x": must be an xarray.DataArray. Give one over time'),
        (lambda: gearcase.spectrum(np.ones(9)), "signal: is of type ndarray, and must be an xarray.DataArray."),
        (lambda: gearcase.open_recording(3, "minimal"), "path = 3: must be text or a path: a recording."),
        (lambda: gearcase.open_run(None), "name = None: must be text or a path: a result folder"),
        (lambda: gearcase.error_bars(3), "response = 3: must be an xarray.Dataset."),
        (lambda: gearcase.run(gearcase.Scene.from_file("minimal"), seeds="a"), 'seeds = "a": must be a whole number.'),
        (lambda: gearcase.Scene.from_file(3), "source = 3: must be text or a path: a scene file"),
        (lambda: gearcase.Scene.from_dict("minimal"), 'tables = "minimal": must be the tables of a scene.'),
        (lambda: gearcase.Scene.from_file("minimal").changed("a=1"), 'settings = "a=1": must be a dict or a list.'),
        (lambda: gearcase.check("minimal"), 'scene = "minimal": must be a gearcase.Scene.'),
        (lambda: gearcase.converge(gearcase.Scene.from_file("minimal"), "x"), 'over = "x": must be one of gear-mesh,'),
        (lambda: gearcase.open_dataset(3), "folder = 3: must be text or a path: the folder of a data set."),
        (
            lambda: gearcase.pieces(3),
            "dataset = 3: must be an xarray.Dataset. Give what gearcase.open_dataset returned.",
        ),
        (lambda: gearcase.campaign(3), "plan = 3: must be text or a path: the plan of a campaign."),
    ],
)
def test_an_argument_of_another_type_is_refused_by_its_name(call, words):
    with pytest.raises(gearcase.InputError, match=re.escape(words)):
        call()


def test_a_spectrum_keeps_the_other_dimensions_and_refuses_what_is_no_signal():
    time = np.arange(2000) / 1000
    tones = np.stack([np.cos(2 * np.pi * f * time) * a for f, a in ((50, 2.0), (125, 0.5))])
    signal = xarray.DataArray(
        tones, dims=("axis", "time"), coords={"time": time, "axis": ["x", "y"]}, attrs={"units": "N"}
    )
    lines = gearcase.spectrum(signal)
    assert lines.units == "N"
    assert lines.frequency.units == "Hz"
    assert lines.sel(axis="x", frequency=50).item() == pytest.approx(2.0)
    assert lines.sel(axis="y", frequency=125).item() == pytest.approx(0.5)
    for wrong in (signal.isel(time=0), signal.isel(time=slice(3)), signal.isel(time=[0, 1, 2, 5, 9])):
        with pytest.raises(gearcase.InputError, match="spectrum"):
            gearcase.spectrum(wrong)


def write(folder, name):
    """A file of the user's own, or a package, that does nothing."""
    path = folder / (name if name.endswith(".py") else f"{name}/__init__.py")
    path.parent.mkdir(exist_ok=True)
    path.write_text("MINE = True\n", encoding="utf-8")


def python(folder, *words):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pipelines", "meshes.py", "fem", "mbd", "queue.py"])
def test_the_import_names_the_folder_that_hides_a_package(tmp_path, name):
    write(tmp_path, name)
    what = "Python's own module queue" if name == "queue.py" else f"the package {name.removesuffix('.py')} of gearcase"
    (tmp_path / "script.py").write_text("import gearcase\n", encoding="utf-8")
    for words in (("-c", "import gearcase"), ("script.py",)):
        done = python(tmp_path, *words)
        assert done.returncode == 1
        last = done.stderr.strip().splitlines()[-1]
        folder = tmp_path.resolve()
        assert last.startswith(f"ImportError: {folder / name} in the folder {folder} hides {what}")
        assert "start Python in another folder" in last


def test_files_and_packages_named_like_modules_of_python_are_found(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    for name in ("queue.py", "json", "mine.py"):
        write(tmp_path, name)
    found = shadowed_packages._named_like_pythons_own()
    assert found == {"queue": tmp_path / "queue.py", "json": tmp_path / "json" / "__init__.py"}


def test_a_folder_without_init_hides_nothing_or_is_named(tmp_path):
    (tmp_path / "pipelines").mkdir()
    done = python(tmp_path, "-c", "import gearcase; print(gearcase.Scene.from_file('minimal').name)")
    assert done.stdout == "minimal\n" or "hides the package pipelines" in done.stderr


@pytest.mark.slow
def test_a_file_named_like_a_module_that_nobody_needs_is_no_obstacle(tmp_path):
    write(tmp_path, "wave.py")
    done = python(tmp_path, "-c", "import gearcase; print(gearcase.Scene.from_file('minimal').name)")
    assert done.stdout == "minimal\n", done.stderr


@pytest.mark.slow
def test_the_command_works_where_every_package_is_hidden(tmp_path):
    for name in ("pipelines", "meshes.py", "fem", "mbd", "queue.py", "gearcase"):
        write(tmp_path, name)
    command = Path(sys.executable).with_name("gearcase.exe" if os.name == "nt" else "gearcase")
    if not command.exists():
        pytest.skip("gearcase is not installed in this environment")
    done = subprocess.run([command, "gears", "minimal"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "secant" in done.stdout


@pytest.mark.slow
def test_as_a_module_the_command_takes_nothing_from_the_working_folder(tmp_path):
    for name in ("pipelines", "meshes.py", "queue.py"):
        write(tmp_path, name)
    done = python(tmp_path, "-m", "gearcase", "gears", "minimal")
    assert done.returncode == 0, done.stderr
    assert "secant" in done.stdout
