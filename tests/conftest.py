"""One cache folder for the whole test run, so that a stage is built once however many tests need it."""

import gc
import os

import pytest

from fem.processes.child import collect_rarely


def pytest_configure(config):
    """Set GEARCASE_CACHE before any test; processes of pytest-xdist share the folder of their parent.

    Compiled code outlives the test run, in the folder that pytest keeps: to compile it takes minutes.
    """
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    if hasattr(config, "workerinput"):
        return
    import tempfile

    if config.pluginmanager.hasplugin("cacheprovider"):
        os.environ.setdefault("NUMBA_CACHE_DIR", str(config.cache.mkdir("compiled")))
    folder = tempfile.mkdtemp(prefix="gearcase-test-cache-")
    config.stash[_FOLDER] = folder
    config.stash[_BEFORE] = os.environ.get("GEARCASE_CACHE")
    os.environ["GEARCASE_CACHE"] = folder


def pytest_unconfigure(config):
    """Remove the folder."""
    if _FOLDER not in config.stash:
        return
    import shutil

    shutil.rmtree(config.stash[_FOLDER], ignore_errors=True)
    if config.stash[_BEFORE] is None:
        os.environ.pop("GEARCASE_CACHE", None)
    else:
        os.environ["GEARCASE_CACHE"] = config.stash[_BEFORE]


_FOLDER = pytest.StashKey[str]()
_BEFORE = pytest.StashKey[str | None]()


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Leave the imported modules out of the search for garbage, which otherwise takes a fifth of the collection.

    The tests search as rarely as the commands do: the searches take one part in 25 of their time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
        collect_rarely()


def pytest_terminal_summary(terminalreporter, config):
    """Say how to repeat the order of the tests, which is another one in each run."""
    seed = config.getoption("randomly_seed", None)
    if seed is not None and config.pluginmanager.hasplugin("randomly"):
        terminalreporter.write_line(f"Random order of the tests; repeat it with --randomly-seed={seed}")


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    """An empty cache of this test alone."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("GEARCASE_CACHE", str(folder))
    return folder


@pytest.fixture(scope="session", autouse=True)
def single_blas_thread():
    """One thread for products of matrices: a plugin of pytest loads NumPy before the environment can say so.

    Two threads that wait for a processor that others use take up to ten times the processor time.
    """
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield
