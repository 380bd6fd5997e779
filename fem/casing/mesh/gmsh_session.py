"""A session of gmsh: the one module that imports it. What gmsh and OpenCASCADE print goes to the log."""

from __future__ import annotations

import ctypes
import logging
import os
import signal
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fem.casing.mesh.mesh import MeshError

_log = logging.getLogger(__name__)
_lock = threading.Lock()  # gmsh keeps one global model


@contextmanager
def session() -> Iterator[Any]:
    """A fresh gmsh, alone in this process, closed whatever happens; works outside the main thread."""
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
                "Mesh.Algorithm3D": 10,  # HXT: of gmsh's algorithms the one with the best worst element here
                "Mesh.Optimize": 1,
                "Mesh.ElementOrder": 1,
                "Mesh.MeshSizeFromPoints": 0,
                "Mesh.MeshSizeExtendFromBoundary": 0,
                "Mesh.LcIntegrationPrecision": 1e-6,  # of element counts along edges; 1e-9 by default takes 1.4 s here
            }.items():
                gmsh.option.setNumber(option, value)
            gmsh.option.setString("Geometry.OCCTargetUnit", "MM")  # OpenCASCADE keeps the unit of an earlier session
            gmsh.model.add("housing")
            yield gmsh
        except Exception as error:
            if isinstance(error, MeshError | AttributeError | TypeError):  # the last two are faults of ours
                raise
            raise MeshError(
                f"gmsh could not mesh the housing: {error}. Try another element size; `gearcase housing FILE` lists "
                "whether the solids of a file close"
            ) from error
        finally:
            gmsh.finalize()


@contextmanager
def _broken_pipes_kept() -> Iterator[None]:
    """gmsh lets a write to a closed pipe end the process; put back what held before (the main thread alone may)."""
    main = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGPIPE) if main and hasattr(signal, "SIGPIPE") else None
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGPIPE, before)


@contextmanager
def printed_to_log() -> Iterator[None]:
    """What libraries write to standard output by themselves goes to the log, a line of ours tells what is wrong."""
    sys.stdout.flush()
    with tempfile.TemporaryFile() as sink:
        kept = os.dup(1)
        os.dup2(sink.fileno(), 1)
        try:
            yield
        finally:
            if os.name == "posix":
                ctypes.CDLL(None).fflush(None)  # what C++ still holds
            os.dup2(kept, 1)
            os.close(kept)
            sink.seek(0)
            for line in sink.read().decode("utf-8", "replace").splitlines():
                _log.info("library: %s", line)
