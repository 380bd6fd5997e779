"""Pictures of a gear pair and of a casing: rendered by a child process, labelled here.

Where rendering is not possible a picture is left out with the reason and the remedy, and the caller goes on.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.mesh_frames import MeshFrames
from pipelines.solids import gear_surface, prism_surface, without_tooth

log = logging.getLogger(__name__)

KINDS = ("ground", "bearing", "sensor")
TIMEOUT = 120.0  # s
RENDERER = ("-P", "-m", "pipelines.view")
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


@dataclass(frozen=True, eq=False, kw_only=True)
class GearPairView:
    """Two gears in the transverse section at mid face, each about its own centre, turned as they mesh.

    The wheel's centre lies at (centre_distance, 0) from the pinion's. Outlines float (n, 2), counter-clockwise, m,
    with all teeth; twists rad per m of face width. `missing_gear` "pinion" | "wheel" | "" and `missing_angle` (rad,
    polar angle of the middle of the tooth about its own centre) take one tooth off; `missing_name` names it.
    """

    pinion_outline: np.ndarray
    wheel_outline: np.ndarray
    pinion_teeth: int
    wheel_teeth: int
    pinion_bore: float
    wheel_bore: float
    pinion_twist: float
    wheel_twist: float
    face_width: float
    centre_distance: float
    missing_gear: str = ""
    missing_angle: float = 0.0
    missing_name: str = "missing tooth"


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingView:
    """Surface of a casing, nodes float (n, 3) m, triangles int (m, 3), and its key points name -> (3,) m."""

    nodes: np.ndarray
    triangles: np.ndarray
    points: Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False, kw_only=True)
class Picture:
    """A rendered picture: image (rows, columns, 3) in 0..255, and the pixel (column, row) of every named place."""

    image: np.ndarray
    places: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A picture that could not be made: what is missing and what to install."""

    reason: str


def render_gears(view: GearPairView, size: tuple[int, int] = (1100, 900)) -> Picture | LeftOut:
    """The gear pair in three dimensions, the missing tooth in red; places "pinion", "wheel", "gone"."""
    arrays, places = _gear_arrays(view)
    return _single(_render("gears", "gear pair", arrays, places, size, (0.25, -0.4, 1.0), (0.0, 1.0, 0.0), 1.3))


def _gear_arrays(view: GearPairView) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Surfaces of the gears and of the tooth that is gone, and where their names stand."""
    shifts = {"pinion": np.zeros(3), "wheel": np.array([view.centre_distance, 0.0, 0.0])}
    teeth = {"pinion": view.pinion_teeth, "wheel": view.wheel_teeth}
    outlines = {"pinion": view.pinion_outline, "wheel": view.wheel_outline}
    twists = {"pinion": view.pinion_twist, "wheel": view.wheel_twist}
    bores = {"pinion": view.pinion_bore, "wheel": view.wheel_bore}
    front = np.array([0.0, 0.0, view.face_width / 2])
    arrays: dict[str, Any] = {}
    places = {}
    for gear, outline in outlines.items():
        if gear == view.missing_gear:
            outline, tooth = without_tooth(outline, teeth[gear], view.missing_angle)
            points, quads = prism_surface(tooth, twists[gear], view.face_width)
            arrays["gone_points"], arrays["gone_quads"] = points + shifts[gear], quads
            angle = view.missing_angle + twists[gear] * view.face_width / 2
            middle = np.hypot(*tooth.T).mean() * np.array([np.cos(angle), np.sin(angle), 0.0])
            places["gone"] = middle + front + shifts[gear]
        points, quads = gear_surface(outline, bores[gear], twists[gear], view.face_width)
        arrays[f"{gear}_points"], arrays[f"{gear}_quads"] = points + shifts[gear], quads
        places[gear] = front + shifts[gear]
    return arrays, places


def render_casing(view: CasingView, size: tuple[int, int] = (1400, 900)) -> Picture | LeftOut:
    """The casing with its key points; places are the points' names and "origin", "x", "y", "z" for the axes."""
    arrays: dict[str, Any] = {
        "nodes": np.asarray(view.nodes, dtype=float),
        "triangles": np.asarray(view.triangles, dtype=int),
    }
    for kind in KINDS:
        chosen = [np.asarray(place, dtype=float) for name, place in view.points.items() if name.startswith(kind)]
        arrays[f"{kind}_points"] = np.array(chosen).reshape(-1, 3)
    low = arrays["nodes"].min(axis=0)
    length = 0.12 * float(np.linalg.norm(np.ptp(arrays["nodes"], axis=0)))
    places = {name: np.asarray(place, dtype=float) for name, place in view.points.items()}
    places |= {"origin": low} | {axis: low + length * np.eye(3)[i] for i, axis in enumerate("xyz")}
    return _single(_render("casing", "casing", arrays, places, size, (-0.55, -1.0, 0.75), (0.0, 0.0, 1.0), 1.1))


def render_mode(
    nodes: np.ndarray, triangles: np.ndarray, shape: np.ndarray, frames: int, size: tuple[int, int] = (1100, 750)
) -> list[Picture] | LeftOut:
    """A period of a mode in `frames` pictures; the largest displacement is drawn as 8 % of the body's diagonal."""
    diagonal, low = float(np.linalg.norm(np.ptp(nodes, axis=0))), nodes.min(axis=0)
    arrays = {"nodes": nodes, "triangles": triangles, "shape": shape, "reach": np.array(0.08 * diagonal)}
    arrays["frames"] = np.array(frames)
    places = {"origin": low} | {axis: low + 0.1 * diagonal * np.eye(3)[i] for i, axis in enumerate("xyz")}
    return _render(
        "mode", "casing mode", arrays, places, size, (-0.55, -1.0, 0.75), (0.0, 0.0, 1.0), 1.35, frames=frames
    )


def render_mesh(
    view: GearPairView, cycles: np.ndarray, frames: MeshFrames, most_load: float, size: tuple[int, int] = (900, 620)
) -> list[Picture] | LeftOut:
    """The teeth in mesh at every cycle, seen through, with their contact lines; places "mesh", "x", "y", "z"."""
    pitch = view.centre_distance * view.pinion_teeth / (view.pinion_teeth + view.wheel_teeth)
    half = 0.75 * max(view.face_width, 9 * pitch / view.pinion_teeth)
    arrays, _ = _gear_arrays(view)
    if view.missing_gear:
        arrays["marked_points"], arrays["marked_quads"] = arrays.pop("gone_points"), arrays.pop("gone_quads")
        arrays["marked_gear"] = np.array(view.missing_gear)
    arrays |= {
        "line_points": frames.points,
        "line_load": frames.load,
        "most_load": np.array(most_load),
        "line_radius": np.array(0.02 * half),
        "centre_distance": np.array(view.centre_distance),
        "pinion_turn": 2 * np.pi * cycles / view.pinion_teeth,
        "wheel_turn": -2 * np.pi * cycles / view.wheel_teeth,
    }
    places = {"mesh": np.array([pitch, 0.0, 0.0])}
    places |= {axis: places["mesh"] + 0.2 * half * np.eye(3)[i] for i, axis in enumerate("xyz")}
    return _render(
        "mesh", "contact lines", arrays, places, size, (-0.55, -0.35, 1.0), (0.0, 1.0, 0.0), 1.0,
        frames=len(cycles), focus=(pitch, 0.0, 0.0, half),
    )  # fmt: skip


def _render(
    kind: str,
    name: str,
    arrays: dict[str, Any],
    places: Mapping[str, np.ndarray],
    size: tuple[int, int],
    direction: tuple[float, float, float],
    up: tuple[float, float, float],
    zoom: float,
    frames: int = 1,
    focus: tuple[float, float, float, float] | None = None,
) -> list[Picture] | LeftOut:
    with tempfile.TemporaryDirectory(prefix="gearcase-") as folder:
        job: dict[str, Any] = {
            "kind": kind,
            "arrays": str(Path(folder) / "arrays.npz"),
            "images": [str(Path(folder) / f"picture_{number}.png") for number in range(frames)],
            "pixels": str(Path(folder) / "pixels.json"),
            "size": list(size),
            "direction": list(direction),
            "up": list(up),
            "zoom": zoom,
            "focus": focus,
            "places": {key: [float(v) for v in place] for key, place in places.items()},
        }
        np.savez(job["arrays"], **arrays)
        job_path = Path(folder) / "job.json"
        job_path.write_text(json.dumps(job), encoding="utf-8")
        failure = _run_child(job_path)
        if failure is None and not all(Path(file).exists() for file in (*job["images"], job["pixels"])):
            failure = "the renderer wrote no picture"
        if failure is not None:
            reason = f"The picture of the {name} is left out: {failure}. {_remedy(failure)}"
            log.warning("%s", reason)
            return LeftOut(reason=reason)
        pixels = json.loads(Path(job["pixels"]).read_text("utf-8"))
        return [Picture(image=_read_image(file), places=pixels) for file in job["images"]]


def _single(pictures: list[Picture] | LeftOut) -> Picture | LeftOut:
    return pictures if isinstance(pictures, LeftOut) else pictures[0]


def _run_child(job: Path) -> str | None:
    """Start the renderer; None if it ended well, else what happened."""
    package_home = str(Path(__file__).resolve().parent.parent)
    path = os.pathsep.join(filter(None, [package_home, os.environ.get("PYTHONPATH", "")]))
    try:
        done = subprocess.run(
            [sys.executable, *RENDERER, str(job)],
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            encoding="utf-8",
            errors="replace",
            timeout=TIMEOUT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"rendering took more than {TIMEOUT:g} s"
    if done.returncode == 0:
        return None
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        return f"off-screen rendering ended with {name}, which happens without EGL and OSMesa"
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    return f"the renderer failed ({lines[-1].strip() if lines else f'exit status {done.returncode}'})"


def _remedy(failure: str) -> str:
    if "took more" in failure:
        return "A software renderer on a busy machine can be this slow; run again."
    found = [package for library, package in PACKAGES.items() if library in failure]
    wanted = " ".join(found) if found else ALL_PACKAGES
    return f"On Debian and Ubuntu install {wanted} with apt-get install."


def _read_image(path: str) -> np.ndarray:
    from matplotlib.image import imread

    return np.rint(imread(path)[..., :3] * 255).astype(np.uint8)
