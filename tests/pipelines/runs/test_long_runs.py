"""Long runs: memory does not grow with the length of a run, and its signals are stored once."""

import tracemalloc
import warnings

import numpy as np
import pytest
import xarray
from coarse import coarse, diagnosable
from mbd_rigs import no_casing, train
from synthetic import RATE

from fem.storage.large_array_file import StoredArray
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.channels import channel_names
from mbd.system.system import assemble
from pipelines.cli.main import main
from pipelines.diagnosis.result_export import export
from pipelines.engine.build_step import build_here
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph
from pipelines.io.errors import CacheWarning
from pipelines.machine.machine_conversion import make_machine
from pipelines.runs import run_folder
from pipelines.runs.run import run_scene
from pipelines.scene.load_scene import load_scene
from pipelines.signals.labelled_signals import LabelledSignal
from pipelines.signals.response import make_response
from pipelines.signals.response_file import write_response
from pipelines.signals.spectrum import cut, whole_revolutions
from pipelines.steps.machine_steps import machine_steps

RATE_OUT = 20e3  # Hz


@pytest.fixture(scope="module")
def machine():
    rig = train(2, model="torsion", speed=20.0, stage={"tau": 1e-5})
    return assemble(rig, no_casing(), channel_names(rig))


def peak(work):
    """Bytes of memory that the work takes at most, on top of what was there."""
    work()  # what is imported, compiled or kept once does not count
    tracemalloc.start()
    work()
    found = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return found


def test_the_values_in_a_file_are_those_in_memory(machine, tmp_path):
    settings = MotionSettings(end=0.05, step=2e-5)
    held, kept = simulate(machine, settings), simulate(machine, settings, file=tmp_path / "values.npy")
    assert isinstance(kept.values, StoredArray)
    assert np.asarray(kept.values).tobytes() == held.values.tobytes()
    assert kept.digest() == held.digest()
    np.testing.assert_array_equal(kept.channel("stage_1:drive_force"), held.channel("stage_1:drive_force"))
    assert held.motors == ("motor_1", "motor_2")


@pytest.mark.slow
def test_memory_does_not_grow_by_the_signals_of_a_longer_motion(machine, tmp_path):
    ends = (0.5, 1.5)
    peaks = [
        peak(
            lambda end=end: simulate(
                machine, MotionSettings(end=end, output_rate=RATE_OUT), file=tmp_path / "values.npy"
            )
        )
        for end in ends
    ]
    added = (ends[1] - ends[0]) * RATE_OUT
    signals = 8 * len(machine.channels.names) * added
    print(f"{(peaks[1] - peaks[0]) / added:.1f} bytes for a sample of {signals / added:.0f}")
    assert (
        peaks[1] - peaks[0] < 80 * added < signals / 3
    )  # the times grow, and up to a limit the blocks that are computed at once


def long_motion(tmp_path, samples):
    """A motion of noise whose values lie in a file."""
    loaded = load_scene("minimal", coarse("minimal"))
    trajectory = motion(loaded, Cache(tmp_path / f"cache {samples}"))
    values = StoredArray.create(tmp_path / f"{samples}.npy", (len(trajectory.channel_names), samples))
    for first in range(0, samples, 10_000):
        block = np.random.default_rng(first).standard_normal((len(values), min(10_000, samples - first)))
        values[:, first : first + block.shape[1]] = block
    return trajectory.replaced(values=values, time=np.arange(samples) / RATE)


def motion(loaded, cache):
    outcome = run_graph(Graph(machine_steps(make_machine(loaded.scene))), cache, ["simulate"], processes=1)
    return outcome.value("simulate")


@pytest.mark.slow
@pytest.mark.parametrize("form", ["nc", "csv"])
def test_memory_does_not_grow_by_the_signals_that_are_written(tmp_path, form):
    writers = {
        "nc": lambda run: write_response(run, {}, tmp_path / "response.nc"),
        "csv": lambda run: export(make_response(run, {}), tmp_path / "response.csv", "csv"),
    }
    sizes = {"nc": (40_000, 200_000), "csv": (20_000, 50_000)}[form]
    runs = [long_motion(tmp_path, samples) for samples in sizes]
    peaks = [peak(lambda run=run: writers[form](run)) for run in runs]
    signals = [8 * int(np.prod(run.values.shape)) for run in runs]
    print(f"{peaks[0] / 1e6:.1f} and {peaks[1] / 1e6:.1f} MB for {signals[0] / 1e6:.1f} and {signals[1] / 1e6:.1f} MB")
    assert peaks[1] - peaks[0] < 0.15 * (signals[1] - signals[0])


def test_a_long_window_is_resampled_piece_by_piece():
    samples = 100_000
    segment = whole_revolutions((0.0, samples / RATE), RATE, 5.4321)
    assert segment.resampled
    signal = np.random.default_rng(1).standard_normal(samples)
    assert peak(lambda: cut(signal, RATE, segment)) < 50e6


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    """The folder of a run of `minimal` and its cache."""
    folder = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GEARCASE_CACHE", str(folder / "cache"))
        loaded = load_scene("minimal", coarse("minimal", end=0.4))
        run_scene(loaded, out=folder / "out", with_control=False, with_report=False)
        yield folder / "out", Cache(), motion(loaded, Cache())


def test_response_nc_is_the_motion_within_the_stated_rounding(short_run):
    folder, _, trajectory = short_run
    with xarray.open_dataset(folder / run_folder.RESPONSE, engine="h5netcdf") as data:
        data.load()
    exact = {
        name: trajectory.channel(name)
        for name in ("sensor_3:az", "mesh_1:drive_force", "bearing_3:fx", "motor_1:torque", "shaft_2:angle")
    }
    found = {
        "sensor_3:az": data.acceleration.sel(sensor="sensor_3", axis="z"),
        "mesh_1:drive_force": data.mesh_force.sel(stage=1),
        "bearing_3:fx": data.bearing_force.sel(bearing="bearing_3", axis="x"),
        "motor_1:torque": data.motor_torque.sel(motor="motor_1"),
        "shaft_2:angle": data.shaft_angle.sel(shaft="shaft_2"),
    }
    for name, signal in found.items():
        rounding = 2.0**-24 if signal.dtype == np.float32 else 0.0
        assert (abs(signal.values - exact[name]) <= rounding * abs(exact[name])).all(), name
    assert data.acceleration.dtype == np.float32
    assert "2^-24" in data.acceleration.attrs["storage"]
    assert data.shaft_angle.dtype == data.time.dtype == np.float64
    assert "storage" not in data.shaft_angle.attrs


def test_the_response_that_is_diagnosed_is_the_one_in_the_file(short_run):
    folder, _, trajectory = short_run
    view = make_response(trajectory, {})
    with xarray.open_dataset(folder / run_folder.RESPONSE, engine="h5netcdf") as data:
        assert set(view.variables) == set(data.variables)
        for name, variable in view.variables.items():
            assert variable.dtype == data[name].dtype or variable.dtype.kind in "UO"
            np.testing.assert_array_equal(variable.values, data[name].values)
        piece = {"time": slice(0.1, 0.2), "axis": ["z", "x"]}
        np.testing.assert_array_equal(view.acceleration.sel(piece), data.acceleration.sel(piece))
        np.testing.assert_array_equal(view.bearing_force[7, 1:3, 2], data.bearing_force[7, 1:3, 2])


def test_only_what_is_not_differenced_is_rounded():
    sizes = {"m/s2": 4, "N": 4, "N m": 4, "rad": 8, "rad/s": 8, "m": 8, "s": 8}
    for units, size in sizes.items():
        assert LabelledSignal(name="x", dims=(), rows=np.array(0), units=units, text="").dtype.itemsize == size


def test_the_signals_of_a_run_are_stored_once(short_run):
    folder, cache, trajectory = short_run
    signals = np.asarray(trajectory.values).nbytes
    stored = sum(entry.bytes for entry in cache.entries())
    assert signals < stored < 1.3 * signals
    assert (folder / run_folder.RESPONSE).stat().st_size < 0.75 * signals
    assert not list((cache.folder / "partial").iterdir())


def simulate_stage(loaded):
    graph = Graph(machine_steps(make_machine(loaded.scene)))
    stage = graph.steps["simulate"]
    upstream = run_graph(graph, Cache(), stage.inputs, processes=1).results
    return stage, stage.key({name: upstream[name].record.content for name in stage.inputs}), upstream


def test_a_disk_that_fills_during_the_motion_costs_the_cache_alone(own_cache, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    stage, key, upstream = simulate_stage(load_scene("minimal", coarse("minimal")))
    stored = build_here(stage, key, upstream, Cache())
    monkeypatch.setattr(StoredArray, "__setitem__", full)
    with pytest.warns(CacheWarning, match="No space left"):
        held = build_here(stage, key, upstream, Cache())
    assert isinstance(held.load().values, np.ndarray)
    assert held.record.content == stored.record.content
    assert held.record.ledger == stored.record.ledger


def test_a_motion_that_cannot_be_kept_is_in_memory(own_cache, tmp_path, monkeypatch):
    stage, key, upstream = simulate_stage(load_scene("minimal", coarse("minimal")))
    upstream = {name: upstream[name] for name in stage.inputs}
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.warns(CacheWarning):
        held = build_here(stage, key, upstream, Cache(tmp_path / "file" / "cache"))
    assert isinstance(held.load().values, np.ndarray)
    monkeypatch.setattr("pipelines.engine.cache.write_manifest", lambda *_: (_ for _ in ()).throw(OSError(28, "full")))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CacheWarning)
        again = build_here(stage, key, upstream, Cache())
    assert isinstance(again.load().values, np.ndarray)
    assert again.record.content == held.record.content
    assert not list((own_cache / "partial").iterdir())


def test_a_motion_that_fails_leaves_nothing_half(own_cache, monkeypatch):
    stage, key, upstream = simulate_stage(load_scene("minimal", coarse("minimal")))

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(StoredArray, "__setitem__", stopped)
    with pytest.raises(KeyboardInterrupt):
        build_here(stage, key, upstream, Cache())
    assert not list((own_cache / "partial").iterdir())
    assert next(Cache().entries("simulate"), None) is None


@pytest.mark.slow
def test_diagnose_prints_the_lines_of_the_run(own_cache, tmp_path, capsys):
    settings = {name: value for name, value in diagnosable("rig-missing-tooth").items() if "casing" not in name}
    settings |= {"casing.model": "rigid", "casing.mount_stiffness_N_per_um": 200.0}
    loaded = load_scene("rig-missing-tooth", settings)
    finished = run_scene(loaded, out=tmp_path / "out", both_loads=False)
    assert main(["diagnose", str(finished.folder)]) == 0
    assert (finished.folder / "diagnosis.txt").read_text(encoding="utf-8") in capsys.readouterr().out


def test_the_file_and_the_motion_are_exported_alike(short_run, tmp_path):
    folder, _, trajectory = short_run
    with xarray.open_dataset(folder / run_folder.RESPONSE, engine="h5netcdf") as data:
        export(data, tmp_path / "file.csv", "csv")
    export(make_response(trajectory, {}), tmp_path / "motion.csv", "csv")
    assert (tmp_path / "file.csv").read_bytes() == (tmp_path / "motion.csv").read_bytes()
