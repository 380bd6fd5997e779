"""Renderer of three-dimensional pictures: the only module that imports pyvista, run as a child process.

Off-screen rendering without EGL or OSMesa ends in a segmentation fault, not in an exception; in a child process
of the caller (pipelines.report.figures.render) it does no harm. ``job.json`` names a file of arrays and the picture to
write; a JSON file next to the picture gives the pixel position of every named point, for labels.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyvista

from pipelines.report.figures.colours import (
    CONTACT,
    CRACK,
    DAMAGED,
    FAULTY,
    GONE,
    HEALTHY,
    LOAD_COLOURS,
    PAIR_COLOURS,
    PINION,
    POINTS,
    STRESS_COLOURS,
    WEAR_COLOURS,
    WHEEL,
)

FEATURE_ANGLE = 30.0
SHARP = {"boundary_edges": False, "manifold_edges": False, "non_manifold_edges": False}


def main(job_path: str) -> None:
    """Render one job, or show it in a window."""
    job = json.loads(Path(job_path).read_text(encoding="utf-8"))
    with np.load(job["arrays"]) as stored:
        arrays = {name: stored[name] for name in stored.files}
    if job["kind"] == "screen":
        show_screen(job, arrays)
        return
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=job["size"])
    plotter.set_background("white")
    draw: dict[str, Callable[..., Callable[[int], None] | None]] = {
        "gears": draw_gears,
        "casing": draw_casing,
        "mode": draw_mode,
        "mesh": draw_mesh,
        "stress": draw_stress,
    }
    moving = draw[job["kind"]](plotter, arrays)
    _look_at(plotter, job["direction"], job["up"], job["zoom"], job["focus"])
    # an animation has many frames: smoothing them takes a fraction of the time of larger frames
    plotter.enable_anti_aliasing("ssaa" if len(job["images"]) == 1 else "fxaa")
    for number, image in enumerate(job["images"]):
        if moving is not None:
            moving(number)
            plotter.render()
        plotter.screenshot(image)
    pixels = {name: pixel(plotter, place) for name, place in job["places"].items()}
    Path(job["pixels"]).write_text(json.dumps(pixels), encoding="utf-8")


class Placed:
    """A plotter that moves objects from the frame of the gears to their place in the scene."""

    def __init__(self, plotter: Any, frame: np.ndarray) -> None:
        self.plotter = plotter
        self.frame = frame

    def add_mesh(self, mesh: Any, **how: Any) -> Any:
        """Add a mesh; returns its actor."""
        actor = self.plotter.add_mesh(mesh, **how)
        actor.user_matrix = self.frame
        return actor


def draw_gears(plotter: Any, arrays: dict[str, np.ndarray]) -> None:
    """Draw the gears with given arrays, and the damaged tooth."""
    opacity = 0.35 if "sheet_0" in arrays and "near" in arrays else 1.0  # a crack is inside
    _draw_pair(Placed(plotter, arrays["frame"]), arrays, opacity, 0.45 if arrays["marked_missing"] else 1.0)


def _draw_pair(there: Placed, arrays: dict[str, np.ndarray], opacity: float, marked: float) -> dict[str, list[Any]]:
    """Draw the gears that are given, and the damaged tooth; their actors by gear."""
    actors = {}
    for part, colour in (("pinion", PINION), ("wheel", WHEEL)):
        if f"{part}_points" in arrays:
            mesh = surface(arrays[f"{part}_points"], arrays[f"{part}_quads"])
            actors[part] = [there.add_mesh(mesh, color=colour, opacity=opacity, specular=0.2)]
            actors[part] += _draw_edges(there, mesh, "#404040", 1.2)
    if "marked_points" in arrays:
        actors[str(arrays["marked_gear"])] += draw_tooth(there, arrays, marked)
    return actors


def _draw_edges(plotter: Any, mesh: Any, colour: str, width: float) -> list[Any]:
    """Draw the sharp edges of a mesh."""
    edges = mesh.extract_feature_edges(FEATURE_ANGLE, **SHARP)
    return [plotter.add_mesh(edges, color=colour, line_width=width)] if edges.n_cells else []


def draw_tooth(plotter: Any, arrays: dict[str, np.ndarray], opacity: float) -> list[Any]:
    """Draw the damaged tooth: all red if its shape is unknown, else its shape with faces of fracture and cracks in red
    and wear by colour; returns its actors."""
    points, quads = arrays["marked_points"], arrays["marked_quads"]
    if "marked_broken" not in arrays:
        tooth = surface(points, quads)
        found = [plotter.add_mesh(tooth, color=GONE, opacity=opacity, smooth_shading=False, ambient=0.35)]
        return [*found, *_draw_edges(plotter, tooth, GONE, 1.0)]
    torn = arrays["marked_broken"]
    whole = opacity * (0.35 if "sheet_0" in arrays and "near" in arrays else 1.0)
    intact = surface(points, quads[~torn])
    worn, ends = arrays["marked_depth"], quads[:, 0] == quads[:, 1]
    if worn.any():
        intact = surface(points, quads[~torn & ~ends], {"depth": worn})
        found = [plotter.add_mesh(surface(points, quads[ends]), color=DAMAGED, opacity=whole),
                 plotter.add_mesh(intact, scalars="depth", cmap=WEAR_COLOURS, clim=(0.0, float(worn.max())),
                                  show_scalar_bar=False, opacity=whole, ambient=0.45)]  # fmt: skip
    else:
        found = [plotter.add_mesh(intact, color=DAMAGED, opacity=whole, ambient=0.2)]
    found += _draw_edges(plotter, surface(points, quads), GONE, 2.0)
    if torn.any():
        found.append(plotter.add_mesh(surface(points, quads[torn]), color=GONE, opacity=max(opacity, 0.8), ambient=0.3))
    for name, sheet in arrays.items():
        if name.startswith("sheet_"):
            grid = pyvista.StructuredGrid(*np.moveaxis(sheet[:, :, None], -1, 0))
            found.append(plotter.add_mesh(grid.extract_surface(algorithm="dataset_surface"), color=GONE, ambient=0.5))
        elif name.startswith("crack_"):
            found.append(plotter.add_mesh(pyvista.lines_from_points(sheet), color=CRACK, line_width=8.0))
    return found


def draw_casing(plotter: Any, arrays: dict[str, np.ndarray]) -> None:
    """Draw translucent walls with their edges, and the key points as spheres in the colour of their kind."""
    mesh = surface(arrays["nodes"], arrays["triangles"])
    plotter.add_mesh(mesh, color="#b9c2cc", opacity=0.28, smooth_shading=False)
    _draw_edges(plotter, mesh, "#4a5560", 1.2)
    radius = 0.011 * float(np.linalg.norm(np.ptp(arrays["nodes"], axis=0)))
    for kind, colour in POINTS.items():
        for centre in arrays[f"{kind}_points"]:
            plotter.add_mesh(pyvista.Sphere(radius=radius, center=centre), color=colour, ambient=0.35)


def draw_mode(plotter: Any, arrays: dict[str, np.ndarray]) -> Callable[[int], None]:
    """Draw a body coloured by the amplitude of its displacement, with its edges at rest behind it."""
    mesh = pyvista.PolyData.from_regular_faces(arrays["nodes"].copy(), arrays["triangles"])
    mesh["amplitude"] = np.linalg.norm(arrays["shape"], axis=1)
    _draw_edges(plotter, mesh, "#9aa4ad", 1.0)
    plotter.add_mesh(mesh, scalars="amplitude", cmap="viridis", clim=(0.0, 1.0), ambient=0.5, show_scalar_bar=False)
    reach = float(arrays["reach"])
    low, high = arrays["nodes"].min(axis=0) - reach, arrays["nodes"].max(axis=0) + reach
    plotter.add_mesh(pyvista.Box((low[0], high[0], low[1], high[1], low[2], high[2])), opacity=0.0)  # fixed view
    count = int(arrays["frames"])

    def move(number: int) -> None:
        swing = reach * np.sin(2 * np.pi * number / count)
        np.copyto(mesh.points, arrays["nodes"] + swing * arrays["shape"])
        mesh.GetPoints().Modified()

    return move


def draw_mesh(plotter: Any, arrays: dict[str, np.ndarray]) -> Callable[[int], None]:
    """Draw two translucent gears, the damaged tooth in red, and the contact lines coloured by their load (N/m)."""
    frame = arrays["frame"]
    there = Placed(plotter, frame)
    actors = _draw_pair(there, arrays, 0.3, 0.22 if arrays["marked_missing"] else 0.4)
    most, thickness = float(arrays["most_load"]), float(arrays["line_radius"])
    wheel_axis = float(arrays["centre_distance"])
    name = f"lines {len(plotter.actors)}"  # unique to this state

    def move(number: int) -> None:
        for gear, centre in (("pinion", 0.0), ("wheel", wheel_axis)):
            for actor in actors[gear]:
                actor.user_matrix = frame @ turned(float(arrays[f"{gear}_turn"][number]), centre)
        lines = contact_lines(arrays["line_points"][number], arrays["line_load"][number], thickness)
        plotter.remove_actor([name, f"{name} rim"], render=False)
        if lines is not None:
            rim = contact_lines(arrays["line_points"][number], arrays["line_load"][number], 1.45 * thickness)
            assert rim is not None  # exists with the lines
            rim.translate(0.9 * arrays["toward"], inplace=True)
            there.add_mesh(rim, name=f"{name} rim", color=CONTACT, ambient=1.0, diffuse=0.0, reset_camera=False)
            lines.translate(arrays["toward"], inplace=True)
            there.add_mesh(
                lines, name=name, scalars="load", cmap=LOAD_COLOURS, clim=(0.0, most), show_scalar_bar=False,
                ambient=1.0, diffuse=0.0, reset_camera=False,
            )  # fmt: skip

    move(0)
    return move


def draw_stress(plotter: Any, arrays: dict[str, np.ndarray]) -> None:
    """Draw hexahedra of loaded teeth coloured by von Mises stress (Pa), their contact lines, and the damaged tooth in
    red.

    The lines are moved by "toward", in parallel projection towards the viewer, so that nothing hides them.
    """
    plotter = Placed(plotter, arrays["frame"])
    grid = pyvista.UnstructuredGrid({pyvista.CellType.HEXAHEDRON: arrays["cells"]}, arrays["points"])
    grid["stress"] = arrays["von_mises"]
    skin = grid.clean(tolerance=1e-6).extract_surface(algorithm="dataset_surface")
    plotter.add_mesh(skin, scalars="stress", cmap=STRESS_COLOURS, clim=(0.0, float(arrays["most"])),
                     show_scalar_bar=False, ambient=0.45, diffuse=0.6)  # fmt: skip
    _draw_edges(plotter, skin, "#202020", 1.0)
    lines = contact_lines(arrays["line_points"], arrays["line_load"], float(arrays["line_radius"]))
    if lines is not None:
        lines.translate(arrays["toward"], inplace=True)
        plotter.add_mesh(lines, color=CONTACT, ambient=1.0, diffuse=0.0)
    if "marked_points" in arrays:
        gear = str(arrays["marked_gear"])
        centre = 0.0 if gear == "pinion" else float(arrays["centre_distance"])
        turn = turned(float(arrays[f"{gear}_turn"][0]), centre)
        outline = surface(arrays["marked_points"], arrays["marked_quads"])
        if arrays["marked_missing"]:
            plotter.add_mesh(outline.transform(turn, inplace=False), color=GONE, opacity=0.35)
        edges = outline.extract_feature_edges(FEATURE_ANGLE, **SHARP)
        cracks = [pyvista.lines_from_points(line) for name, line in arrays.items() if name.startswith("crack_")]
        for drawn, width in ((edges, 3.0), *((line, 6.0) for line in cracks)):
            drawn.transform(turn, inplace=True).translate(0.01 * arrays["toward"], inplace=True)
            plotter.add_mesh(drawn, color=GONE, line_width=width)


def show_screen(job: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    """Show a window: the states of the teeth above one another, their stiffness and load share, and a slider.

    With `images` in the job the window takes a picture at the last position and closes.
    """
    names = job["names"]
    plotter: Any = pyvista.Plotter(shape=(2, 2), window_size=job["size"], title=job["title"])
    plotter.set_background("white", all_renderers=True)
    moves = []
    for row in range(len(names)):
        plotter.subplot(row, 0)
        own = {key.removeprefix(f"{row}_"): value for key, value in arrays.items() if key.startswith(f"{row}_")}
        moves.append(draw_mesh(plotter, own))
        _look_at(plotter, job["direction"], job["up"], 1.0, job["focus"])
        plotter.add_axes(color="black")
        scale = pyvista.LookupTable(LOAD_COLOURS, scalar_range=(0.0, float(own["most_load"]) / 1000))
        bar = pyvista.PolyData(np.zeros((1, 3)))
        unseen = plotter.add_mesh(bar, opacity=0.0, reset_camera=False)
        unseen.mapper.lookup_table = scale
        plotter.add_scalar_bar(
            "line load, N/mm" + row * " ", mapper=unseen.mapper, color="black", vertical=True, n_labels=4,
            position_x=0.84, position_y=0.2, height=0.6, title_font_size=13, label_font_size=12, fmt="%.0f",
        )  # fmt: skip
    markers = [_draw_curves(plotter, row, arrays, names) for row in range(2)]
    cycles = arrays["cycles"]

    def to(cycle: float) -> None:
        number = int(np.abs(cycles - cycle).argmin())
        for row, move in enumerate(moves):
            plotter.subplot(row, 0)
            move(number)
            words = f"{names[row]}: pinion blue, wheel brown{job['marked'][row]}\n"
            words += f"mesh cycle {cycles[number]:.3f}, {job['load']}"
            plotter.add_text(words, name=f"words {row}", font_size=9, color="black")
        for marker, top in markers:
            marker.update([cycles[number], cycles[number]], [0.0, top])

    plotter.subplot(len(names) - 1, 0)
    plotter.add_slider_widget(
        to, (float(cycles[0]), float(cycles[-1])), value=float(cycles[len(cycles) // 2]), title="mesh cycle",
        pointa=(0.1, 0.1), pointb=(0.8, 0.1), color="black", interaction_event="always", fmt="%.2f",
    )  # fmt: skip
    if not job["images"]:
        plotter.show()
        return
    plotter.show(auto_close=False, interactive=False)
    to(float(cycles[-1]))
    plotter.render()
    plotter.screenshot(job["images"][0])
    plotter.close()


def _draw_curves(plotter: Any, row: int, arrays: dict[str, np.ndarray], names: list[str]) -> tuple[Any, float]:
    """Draw the chart of a row: mesh stiffness of all states, or load shares of the last; the position's line and
    height."""
    plotter.subplot(row, 1)
    chart = pyvista.Chart2D()
    chart.x_label = "mesh cycle"
    if row == 0:
        chart.title, chart.y_label = "Mesh stiffness (secant)", "stiffness, N/um"
        top = 1.05 * max(float(arrays[f"{n}_secant"].max()) for n in range(len(names))) / 1e6
        for n, name in enumerate(names):
            chart.line(
                arrays[f"{n}_curve_cycle"],
                arrays[f"{n}_secant"] / 1e6,
                color=(HEALTHY, FAULTY)[n],
                width=2.5,
                label=name,
            )
    else:
        last = len(names) - 1
        chart.title, chart.y_label, top = f"Load share of the tooth pairs, {names[last]}", "share, %", 105.0
        for number, share in zip(arrays[f"{last}_curve_pair"], arrays[f"{last}_share"].T, strict=True):
            colour = PAIR_COLOURS[int(number) % len(PAIR_COLOURS)]
            chart.line(arrays[f"{last}_curve_cycle"], 100 * share, color=colour, width=2.0, label=f"pair {number}")
    chart.y_range = [0.0, top]
    chart.legend_visible = True
    middle = float(arrays["cycles"][len(arrays["cycles"]) // 2])
    marker = chart.line([middle, middle], [0.0, top], color="black", width=1.5, style="--", label="position")
    plotter.add_chart(chart)
    return marker, top


def turned(angle: float, centre: float) -> np.ndarray:
    """Rotation about the axis along z through (centre, 0) as a 4 x 4 matrix."""
    return np.asarray(pyvista.Transform().rotate_z(np.degrees(angle), point=(centre, 0.0, 0.0)).matrix)


def contact_lines(points: np.ndarray, load: np.ndarray, radius: float) -> pyvista.PolyData | None:
    """Tubes between neighbouring loaded slices of each pair (pair, slice); None without contact."""
    both = np.isfinite(load[:, :-1]) & np.isfinite(load[:, 1:])
    pair, piece = np.nonzero(both)
    if pair.size == 0:
        return None
    ends = np.stack([points[pair, piece], points[pair, piece + 1]], axis=1).reshape(-1, 3)
    lines = pyvista.line_segments_from_points(ends)
    lines["load"] = np.stack([load[pair, piece], load[pair, piece + 1]], axis=1).ravel()
    return lines.tube(radius=radius, n_sides=10)


def surface(points: np.ndarray, faces: np.ndarray, values: dict[str, np.ndarray] | None = None) -> pyvista.PolyData:
    """Surface of faces with a fixed number of corners and values at the points, duplicate points merged."""
    made = pyvista.PolyData.from_regular_faces(points, faces)
    for name, of_points in (values or {}).items():
        made[name] = of_points
    return made.triangulate().clean()


def _look_at(plotter: Any, direction: list[float], up: list[float], zoom: float, focus: list[float] | None) -> None:
    """Parallel projection from a direction: everything in the picture, or [x, y, z, half height] around a point."""
    plotter.enable_parallel_projection()
    plotter.view_vector(direction, viewup=up)
    plotter.camera.zoom(zoom)
    if focus is not None:
        camera, place = plotter.camera, np.array(focus[:3])
        away = np.array(camera.position) - np.array(camera.focal_point)
        camera.focal_point, camera.position = tuple(place), tuple(place + away)
        camera.parallel_scale = focus[3]
        plotter.renderer.ResetCameraClippingRange()


def pixel(plotter: Any, place: list[float]) -> list[float]:
    """Column and row of a point in the picture, row 0 at the top."""
    renderer = plotter.renderer
    renderer.SetWorldPoint(*place, 1.0)
    renderer.WorldToDisplay()
    column, row, _ = renderer.GetDisplayPoint()
    return [column, plotter.window_size[1] - row]


if __name__ == "__main__":
    main(sys.argv[1])
