"""Pictures of a gear pair and of a casing: rendered by a child process, labelled here.

If rendering is not possible, every `render_` function raises `NotRendered` with the reason and the remedy.
"""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem.gears.geometry import GearPair
from fem.processes.child import command, environment
from pipelines.io.errors import InputError
from pipelines.report.figures import render_failures
from pipelines.report.figures.damaged_tooth import DrawnTooth, turned_in
from pipelines.report.figures.gear_frame import placed, rotated
from pipelines.report.figures.tooth_mesh_frames import MeshFrames, MeshView
from pipelines.report.figures.tooth_surfaces import gear_surface, outline, prism_surface, twist, web, without_tooth
from pipelines.report.figures.views import GearPairView, NotRendered, Picture, Teeth

log = logging.getLogger(__name__)

KINDS = ("ground", "bearing", "sensor")
UP = (0.0, 0.0, 1.0)
FROM_FRONT = (-0.55, -1.0, 0.75)  # from the casing to the camera
AXES_PLACES = ("origin", "x", "y", "z")  # reserved names
TIMEOUT = 900.0  # s, for a renderer that hangs; a software renderer on a busy machine takes minutes
RENDERER = "pipelines.report.figures.renderer"


def kind_of(point: str) -> str:
    """Kind of a key point of the casing, one of KINDS; sensors have any name."""
    return next((kind for kind in KINDS if point.startswith(f"{kind}_")), "sensor")


def render_gears(view: GearPairView, size: tuple[int, int] = (1100, 900)) -> Picture:
    """Render the gear pair in three dimensions, the damaged tooth in red; places "pinion", "wheel", "marked"."""
    arrays, places = _gear_arrays(view)
    direction = (0.25, view.seen_from, 0.4)
    return _render("gears", "gear pair", arrays, _in_scene(places, view), size=size, direction=direction, zoom=1.3)[0]


def render_tooth(view: GearPairView, size: tuple[int, int] = (900, 900)) -> Picture:
    """Render the damaged tooth on its gear, enlarged, without the mate; places "origin", "x", "y", "z" at the tooth."""
    arrays, places = _gear_arrays(view)
    assert view.marked is not None, "a view with a damaged tooth"
    gear, tooth = view.marked[0], view.tooth
    mate = "wheel" if gear == "pinion" else "pinion"
    arrays = {name: value for name, value in arrays.items() if not name.startswith(f"{mate}_")}
    arrays["near"] = np.array(True)
    centre, teeth = view.centre(gear), getattr(view.pair, gear).teeth
    radius = float(np.linalg.norm(places["marked"][:2] - [centre, 0.0]))
    half = 0.62 * max(view.pair.face_width, 4 * np.pi * radius / teeth)
    outward, around = turned_in(np.eye(3)[:2], view.marked_angle, 0.0)
    end = view.sense * view.seen_from
    toward = 0.7 * outward + 0.6 * (tooth.flank if tooth is not None else 1) * around + 0.55 * end * np.eye(3)[2]
    direction, up = (tuple(rotated(vector, view.frame).tolist()) for vector in (toward, outward))
    middle = placed(turned_in(np.array([radius, 0.0, 0.0]), view.marked_angle, centre), view.frame)
    named = _directions(middle, 0.2 * half)
    focus = (*middle.tolist(), half)
    return _render("gears", "damaged tooth", arrays, named, size=size, direction=direction, up=up, focus=focus)[0]


def _in_scene(places: Mapping[str, np.ndarray], view: GearPairView) -> dict[str, np.ndarray]:
    return {name: placed(np.asarray(place), view.frame) for name, place in places.items()}


def _directions(origin: np.ndarray, length: float) -> dict[str, np.ndarray]:
    return {"origin": origin} | {axis: origin + length * np.eye(3)[i] for i, axis in enumerate("xyz")}


def _gear_arrays(view: GearPairView) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Surfaces of the gears and of the damaged tooth, and the places of their names."""
    front, places = _front(view), {}
    arrays: dict[str, Any] = {
        "marked_gear": np.array(view.marked[0] if view.marked else ""),
        "marked_missing": np.array(view.missing),
        "frame": view.frame,
    }
    for name, gear in (("pinion", view.pair.pinion), ("wheel", view.pair.wheel)):
        shift, section = np.array([view.centre(name), 0.0, 0.0]), outline(gear, view.zero_angle(name))
        if view.marked and name == view.marked[0]:
            section, tooth = without_tooth(section, gear.teeth, view.marked_angle)
            points, quads = prism_surface(tooth, twist(gear), view.pair.face_width)
            arrays["marked_points"], arrays["marked_quads"] = points + shift, quads
            if view.tooth is not None and not view.tooth.missing:
                arrays |= _tooth_arrays(view.tooth, view.marked_angle, view.centre(name))
            angle = view.marked_angle + twist(gear) * float(front[2])
            middle = np.hypot(*tooth.T).mean() * np.array([np.cos(angle), np.sin(angle), 0.0])
            places["marked"] = middle + front + shift
        points, quads = gear_surface(section, gear.bore_radius, twist(gear), view.pair.face_width, web=web(gear))
        arrays[f"{name}_points"], arrays[f"{name}_quads"] = points + shift, quads
        places[name] = front + shift
    return arrays, places


def _tooth_arrays(tooth: DrawnTooth, angle: float, centre: float) -> dict[str, Any]:
    """Surface of a damaged tooth at its place, its faces of fracture, wear, and cracks."""
    sheets = {f"sheet_{n}": turned_in(sheet, angle, centre) for n, sheet in enumerate(tooth.sheets)}
    lines = {f"crack_{n}": turned_in(line, angle, centre) for n, line in enumerate(tooth.lines)}
    return {
        "marked_points": turned_in(tooth.points, angle, centre),
        "marked_quads": tooth.quads,
        "marked_broken": tooth.broken,
        "marked_depth": tooth.depth,
        **sheets,
        **lines,
    }


def render_casing(
    nodes: np.ndarray, triangles: np.ndarray, points: Mapping[str, np.ndarray], size: tuple[int, int] = (1400, 900)
) -> Picture:
    """Render the casing with its key points; places are the points' names and "origin", "x", "y", "z" for the axes.

    Parameters
    ----------
    nodes, triangles : float (n, 3), m, and int (t, 3), surface of the casing
    points : (3,), m, by name
    size : width and height of the picture, pixels
    """
    arrays: dict[str, Any] = {"nodes": nodes, "triangles": triangles}
    for kind in KINDS:
        chosen = [place for name, place in points.items() if kind_of(name) == kind]
        arrays[f"{kind}_points"] = np.array(chosen, dtype=float).reshape(-1, 3)
    low = nodes.min(axis=0)
    places = {**points, **_directions(low, 0.12 * float(np.linalg.norm(np.ptp(nodes, axis=0))))}
    return _render("casing", "casing", arrays, places, size=size, direction=FROM_FRONT, zoom=1.1)[0]


def render_mode(
    nodes: np.ndarray, triangles: np.ndarray, shape: np.ndarray, frames: int, size: tuple[int, int] = (1100, 750)
) -> list[Picture]:
    """Render a period of a mode; the largest displacement is 8 % of the body's diagonal.

    Parameters
    ----------
    nodes, triangles : float (n, 3), m, and int (t, 3), surface of the body
    shape : (n, 3), the largest length 1
    frames : pictures of the period
    size : width and height of a picture, pixels
    """
    diagonal, low = float(np.linalg.norm(np.ptp(nodes, axis=0))), nodes.min(axis=0)
    arrays = {"nodes": nodes, "triangles": triangles, "shape": shape, "reach": np.array(0.08 * diagonal)}
    arrays["frames"] = np.array(frames)
    places = _directions(low, 0.1 * diagonal)
    return _render("mode", "casing mode", arrays, places, size=size, direction=FROM_FRONT, zoom=1.35, frames=frames)


def render_mesh(
    view: GearPairView, cycles: np.ndarray, frames: MeshFrames, most_load: float, size: tuple[int, int] = (900, 620)
) -> list[Picture]:
    """Render the translucent teeth in mesh at every cycle, with their contact lines; places "origin", "x", "y", "z".

    Parameters
    ----------
    view : the gears
    cycles : (frame,) mesh cycles
    frames : contact lines of every cycle
    most_load : N/m, line load at the end of the colour scale
    size : width and height of a picture, pixels
    """
    arrays, places, focus = _frame_arrays(view, cycles, frames)
    arrays["most_load"] = np.array(most_load)
    return _render(
        "mesh",
        "contact lines",
        arrays,
        places,
        size=size,
        direction=_mesh_direction(view),
        frames=len(cycles),
        focus=focus,
    )


def _frame_arrays(
    view: GearPairView, cycles: np.ndarray, frames: MeshFrames
) -> tuple[dict[str, Any], dict[str, np.ndarray], tuple[float, float, float, float]]:
    half = 0.75 * max(view.pair.face_width, 9 * _module(view.pair) / 2)
    return _mesh_arrays(view, cycles, frames.points, frames.load, half, 0.02)


def _mesh_arrays(
    view: GearPairView, cycles: np.ndarray, points: np.ndarray, load: np.ndarray, half: float, radius: float
) -> tuple[dict[str, Any], dict[str, np.ndarray], tuple[float, float, float, float]]:
    """Gears and contact lines, the named places, and the centre of the picture with half of its height.

    Parameters
    ----------
    view, cycles : the gears, and their positions (frame,)
    points, load : of the contact lines, m and N/m
    half, radius : half of the height of the picture, m, and radius of the contact lines divided by it
    """
    pitch = _module(view.pair) * view.pair.pinion.teeth / 2
    arrays, _ = _gear_arrays(view)
    arrays |= {
        "line_points": points,
        "line_load": load,
        "line_radius": np.array(radius * half),
        "toward": 6 * half * np.array(_mesh_direction(view)) @ view.frame[:3, :3],  # parallel: nothing hides them
        "centre_distance": np.array(view.pair.axis_distance),
        "pinion_turn": 2 * np.pi * cycles / view.pair.pinion.teeth,
        "wheel_turn": -2 * np.pi * cycles / view.pair.wheel.teeth,
    }
    middle = placed(np.array([pitch, 0.0, 0.0]), view.frame)
    return arrays, _directions(middle, 0.2 * half), (*middle.tolist(), half)


def _module(pair: GearPair) -> float:
    """Transverse module of the working pitch circles, m."""
    return 2 * pair.axis_distance / (pair.pinion.teeth + pair.wheel.teeth)


def _front(view: GearPairView) -> np.ndarray:
    """Vector from mid face to the visible end, in the frame of the gears."""
    return np.array([0.0, 0.0, view.sense * view.seen_from * view.pair.face_width / 2])


def _mesh_direction(view: GearPairView) -> tuple[float, float, float]:
    return -0.5, view.seen_from, 0.45


def show_mesh(view: MeshView, image: Path | None = None) -> None:
    """Show the states in a window with a slider for the position, until it is closed; with `image` until it is written.

    Raises
    ------
    InputError : no display, or the window cannot be opened
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError(
            "--screen: there is no display (DISPLAY is not set). Run it on a desktop or over ssh -X, or leave --screen "
            "out: the page mesh_<stage>.html has the same slider."
        )
    arrays: dict[str, Any] = {"cycles": view.cycles}
    for number, state in enumerate(view.states):
        own, _, focus = _frame_arrays(view.of_state(number), view.cycles, state)
        own |= {
            "most_load": np.array(view.most_load),
            "toward": np.zeros(3),
            "curve_cycle": state.curve.cycle,
            "secant": state.curve.secant,
            "share": state.curve.share,
            "curve_pair": state.curve.pair,
        }
        arrays |= {f"{number}_{key}": value for key, value in own.items()}
    with tempfile.TemporaryDirectory(prefix="gearcase-") as folder:
        job: dict[str, Any] = {
            "kind": "screen",
            "images": [] if image is None else [str(image)],
            "size": [1500, 950],
            "title": view.title,
            "load": f"load {view.force:.4g} N, model {view.model}",
            "names": [state.name for state in view.states],
            "marked": ["" if n == 0 or not view.marked else f", {view.marked} red" for n in range(len(view.states))],
            "direction": _mesh_direction(view.of_state(len(view.states) - 1)),
            "up": UP,
            "focus": focus,
        }
        failure = _run_job(Path(folder), job, arrays, timeout=None)
    if failure:
        raise InputError(f"--screen: the window is not opened: {failure}")


def render_stress(
    view: GearPairView, cycle: float, teeth: Teeth, most: float, root: np.ndarray, size: tuple[int, int] = (1000, 620)
) -> Picture:
    """Render loaded teeth coloured by von Mises stress; places "pinion", "wheel", "root", "origin", "x", "y", "z".

    Parameters
    ----------
    view : the gears
    cycle : mesh cycle
    teeth : the loaded teeth with their stress
    most : Pa, stress at the end of the colour scale
    root : (3,) place of the largest root stress, as the points of the teeth
    size : width and height of the picture, pixels
    """
    module = _module(view.pair)
    half, pitch = 0.56 * max(view.pair.face_width, 9 * module), module * view.pair.pinion.teeth / 2
    arrays, places, focus = _mesh_arrays(view, np.array([cycle]), teeth.line_points, teeth.line_load, half, 0.011)
    arrays |= {"points": teeth.points, "cells": teeth.cells, "von_mises": teeth.von_mises, "most": np.array(most)}
    sides = (("pinion", -1), ("wheel", 1))
    named = {name: np.array([pitch + side * 3.2 * module, 0.0, 0.0]) + _front(view) for name, side in sides}
    places |= _in_scene(named | {"root": root}, view)
    return _render("stress", "stress", arrays, places, size=size, direction=_mesh_direction(view), focus=focus)[0]


def _render(
    kind: str,
    name: str,
    arrays: dict[str, Any],
    places: Mapping[str, np.ndarray],
    *,
    size: tuple[int, int],
    direction: tuple[float, float, float],
    up: tuple[float, float, float] = UP,
    zoom: float = 1.0,
    frames: int = 1,
    focus: tuple[float, float, float, float] | None = None,
) -> list[Picture]:
    with tempfile.TemporaryDirectory(prefix="gearcase-") as folder:
        job: dict[str, Any] = {
            "kind": kind,
            "images": [str(Path(folder) / f"picture_{number}.png") for number in range(frames)],
            "pixels": str(Path(folder) / "pixels.json"),
            "size": list(size),
            "direction": list(direction),
            "up": list(up),
            "zoom": zoom,
            "focus": focus,
            "places": {key: [float(v) for v in place] for key, place in places.items()},
        }
        failure = _run_job(Path(folder), job, arrays, TIMEOUT)
        if not failure and not all(Path(file).exists() for file in (*job["images"], job["pixels"])):
            failure = f"the renderer wrote no picture. {render_failures.again_or_graphics()}"
        if failure:
            reason = f"The picture of the {name} is left out: {failure}"
            log.warning("%s", reason)
            raise NotRendered(reason)
        from matplotlib.image import imread

        pixels = json.loads(Path(job["pixels"]).read_text("utf-8"))
        return [
            Picture(image=np.rint(imread(file)[..., :3] * 255).astype(np.uint8), places=pixels)
            for file in job["images"]
        ]


def _run_job(folder: Path, job: Mapping[str, Any], arrays: Mapping[str, Any], timeout: float | None) -> str:
    """Write a job with its arrays into a folder and run it; "" on success, else the failure and what helps."""
    np.savez(folder / "arrays.npz", **arrays)
    path = folder / "job.json"
    path.write_text(json.dumps({**job, "arrays": str(folder / "arrays.npz")}), encoding="utf-8")
    try:
        done = subprocess.run(
            [*command(RENDERER), str(path)],
            env=environment(),
            capture_output=True,
            text=True,
            encoding="utf-8",
            errors="replace",
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        return (
            f"rendering took more than {error.timeout:g} s. A software renderer on a busy machine can be this slow; "
            "run again."
        )
    return render_failures.ended(done.returncode, done.stderr) if done.returncode else ""
