"""Sessions of gmsh; no other module imports it. The output of gmsh and OpenCASCADE goes to the log."""

from __future__ import annotations

import ctypes
import logging
import os
import signal
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from fem.casing.mesh.mesh import MeshError

_log = logging.getLogger(__name__)
_lock = threading.Lock()  # gmsh keeps one global model


@contextmanager
def session() -> Iterator[Any]:
    """A new gmsh session, the only one in this process, always closed; works outside the main thread."""
    import gmsh

    with _lock, printed_to_log():
        with _broken_pipes_kept():
            gmsh.initialize(["gearcase", "-v", "0"], readConfigFiles=False, interruptible=False)
        try:
            for option, value in {
                "General.Terminal": 0,
                "General.NumThreads": 1,
                "Mesh.MaxNumThreads3D": 1,
                "Mesh.RandomSeed": 1,
                "Mesh.Algorithm": 6,
                "Mesh.Algorithm3D": 10,  # HXT: its worst element is the best of gmsh's algorithms here
                "Mesh.Optimize": 1,
                "Mesh.ElementOrder": 1,
                "Mesh.MeshSizeFromPoints": 0,
                "Mesh.MeshSizeExtendFromBoundary": 0,
                "Mesh.LcIntegrationPrecision": 1e-6,  # of element counts along edges; the default 1e-9 is slow
            }.items():
                gmsh.option.setNumber(option, value)
            gmsh.option.setString("Geometry.OCCTargetUnit", "MM")  # otherwise that of an earlier session is kept
            gmsh.model.add("housing")
            yield gmsh
        except Exception as error:
            if isinstance(error, MeshError | AttributeError | TypeError):  # the last two are errors in this code
                raise
            raise MeshError(
                f"gmsh could not mesh the housing: {error}. Try another element size; `gearcase housing FILE` lists "
                "whether the solids of a file close"
            ) from error
        finally:
            gmsh.finalize()


def numbered_nodes(gmsh: Any) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 3) in mm of the nodes of the current mesh, and the row of every node by its tag."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, np.int64)
    row[tags] = np.arange(len(tags))
    return coordinates.reshape(-1, 3), row


def face_triangles(gmsh: Any, faces: Iterable[int], row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (t, 3) of the linear triangles on some faces, as rows of `numbered_nodes`, and the face (t,) of each."""
    parts = [(tag, row[corners.reshape(-1, 3)]) for tag in faces for corners in gmsh.model.mesh.getElements(2, tag)[2]]
    face = np.repeat(np.array([tag for tag, _ in parts], int), [len(own) for _, own in parts] or 0)
    return np.vstack([np.zeros((0, 3), np.int64), *(own for _, own in parts)]), face


@contextmanager
def _broken_pipes_kept() -> Iterator[None]:
    """Restore the handling of closed pipes, which gmsh sets to end the process (main thread only)."""
    main = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGPIPE) if main and hasattr(signal, "SIGPIPE") else None
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGPIPE, before)


@contextmanager
def printed_to_log() -> Iterator[None]:
    """Redirect what libraries print to standard output into the log; messages to users are raised as errors instead."""
    sys.stdout.flush()
    with tempfile.TemporaryFile() as sink:
        kept = os.dup(1)
        os.dup2(sink.fileno(), 1)
        try:
            yield
        finally:
            if os.name == "posix":
                ctypes.CDLL(None).fflush(None)  # buffers of C++
            os.dup2(kept, 1)
            os.close(kept)
            sink.seek(0)
            for line in sink.read().decode("utf-8", "replace").splitlines():
                _log.info("library: %s", line)
