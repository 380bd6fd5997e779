"""Why a picture could not be rendered, as far as it is known, and what helps: words for the user."""

from __future__ import annotations

import re
import signal
import sys

PACKAGES = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libOSMesa": "libosmesa6",
    "libXrender.so.1": "libxrender1",
    "libX11.so.6": "libx11-6",
    "libXcursor.so.1": "libxcursor1",
    "libXft.so.2": "libxft2",
    "libfontconfig.so.1": "libfontconfig1",
    "libgomp.so.1": "libgomp1",
}
ALL_PACKAGES = "libegl1 (or libosmesa6) libgl1 libxrender1"
NEEDED_MB = 1500  # address space of a renderer with a small picture: 1500 MB were enough, 1200 MB were not
_OUT_OF_MEMORY = ("MemoryError", "bad_alloc", "Cannot allocate memory", "failed to map segment", "Unable to allocate")
_MISSING = re.compile(r"No module named '(\w+)")
_AGAIN = "Nothing else is affected; run again."


def again_or_graphics() -> str:
    """What helps without a message of the renderer: libraries for rendering if there are none, else another run."""
    return _AGAIN if graphics_found() else _install()


def ended(code: int, stderr: str) -> str:
    """The renderer ended with an exit code other than 0, or by a signal (negative)."""
    if code < 0:
        return _signalled(-code)
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    what = f"the renderer failed ({lines[-1] if lines else f'exit status {code}'})"
    if any(words in stderr for words in _OUT_OF_MEMORY):
        return f"{what}. {_more_memory()}"
    packages = [package for library, package in PACKAGES.items() if library in stderr]
    if packages:
        return f"{what}. {_install(*packages)}"
    if missing := _MISSING.search(stderr):
        return (
            f"pictures in three dimensions need {missing[1]}, which is not installed. Everything else works without; "
            f"for them: python -m pip install {missing[1]}"
        )
    return f"{what}. {_AGAIN}"


def _signalled(number: int) -> str:
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = f"signal {number}"
    what = f"off-screen rendering ended with {name}"
    if name == "SIGKILL":
        return f"{what}: it was killed, which the system does when memory runs out. {_more_memory()}"
    if name not in ("SIGSEGV", "SIGABRT", "SIGBUS"):
        return f"{what}. {_AGAIN}"
    limit = memory_limit()
    if limit is not None and limit < 2 * NEEDED_MB:
        return f"{what} under a memory limit of {limit:.0f} MB. {_more_memory()}"
    if not graphics_found():
        return f"{what}, which happens without EGL and OSMesa; neither is found here. {_install()}"
    return f"{what}; EGL or OSMesa is installed, the cause is not known. {_AGAIN}"


def graphics_found() -> bool:
    """True if a library for off-screen rendering is installed, or if this system keeps them elsewhere."""
    from ctypes.util import find_library

    return not sys.platform.startswith("linux") or bool(find_library("EGL") or find_library("OSMesa"))


def memory_limit() -> float | None:
    """Limit of the address space or the data of a process (ulimit -v, -d) in MB; None without one."""
    if sys.platform == "win32":
        return None
    import resource

    limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA)]
    return min((limit / 2**20 for limit in limits if limit != resource.RLIM_INFINITY), default=None)


def _more_memory() -> str:
    return f"It needs {NEEDED_MB} MB of address space and more: raise the limit (ulimit -v; of a container, of a job)."


def _install(*packages: str) -> str:
    return f"On Debian and Ubuntu install {' '.join(packages) or ALL_PACKAGES} with apt-get install."
