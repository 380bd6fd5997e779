"""Three-dimensional pictures: the one module that imports pyvista, run as a child process.

Off-screen rendering without EGL or OSMesa ends in a segmentation fault, not in an exception, so the caller
(pipelines.pictures) starts ``python -m pipelines.view job.json`` and outlives it. The job names a file of arrays and
the picture to write; beside the picture a JSON file gives the pixel position of every named point, for labels.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyvista

COLOURS = {"ground": "#f2c200", "bearing": "#c8281e", "sensor": "#2e9e44"}
PINION, WHEEL, GONE = "#8fa9bf", "#c9b28a", "#d62718"
FEATURE_ANGLE = 30.0


def main(job_path: str) -> None:
    """Render one job."""
    job = json.loads(Path(job_path).read_text(encoding="utf-8"))
    with np.load(job["arrays"]) as stored:
        arrays = {name: stored[name] for name in stored.files}
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=job["size"])
    plotter.set_background("white")
    moving = {"gears": draw_gears, "casing": draw_casing, "mode": draw_mode}[job["kind"]](plotter, arrays)
    look_at(plotter, job["direction"], job["up"], job["zoom"])
    plotter.enable_anti_aliasing("ssaa")
    for number, image in enumerate(job["images"]):
        if moving is not None:
            mesh, rest, shape = moving
            mesh.points = rest + shape * np.sin(2 * np.pi * number / len(job["images"]))
        plotter.screenshot(image)
    pixels = {name: pixel(plotter, place) for name, place in job["places"].items()}
    Path(job["pixels"]).write_text(json.dumps(pixels), encoding="utf-8")


def draw_gears(plotter: Any, arrays: dict[str, np.ndarray]) -> None:
    """Pinion, wheel and, if there, the tooth that is gone."""
    for part, colour, opacity in (("pinion", PINION, 1.0), ("wheel", WHEEL, 1.0), ("gone", GONE, 0.6)):
        if f"{part}_points" not in arrays:
            continue
        mesh = surface(arrays[f"{part}_points"], arrays[f"{part}_quads"])
        plotter.add_mesh(mesh, color=colour, opacity=opacity, smooth_shading=False, specular=0.2)
        edges = mesh.extract_feature_edges(FEATURE_ANGLE, boundary_edges=False, manifold_edges=False)
        if edges.n_cells:
            plotter.add_mesh(edges, color="#303030" if part != "gone" else GONE, line_width=1.0)


def draw_casing(plotter: Any, arrays: dict[str, np.ndarray]) -> None:
    """Translucent walls with their edges, and the key points as spheres in the colour of their kind."""
    mesh = surface(arrays["nodes"], arrays["triangles"])
    plotter.add_mesh(mesh, color="#b9c2cc", opacity=0.28, smooth_shading=False)
    edges = mesh.extract_feature_edges(FEATURE_ANGLE, boundary_edges=False, manifold_edges=False)
    if edges.n_cells:
        plotter.add_mesh(edges, color="#4a5560", line_width=1.2)
    radius = 0.011 * float(np.linalg.norm(np.ptp(arrays["nodes"], axis=0)))
    for kind, colour in COLOURS.items():
        for centre in arrays[f"{kind}_points"]:
            plotter.add_mesh(pyvista.Sphere(radius=radius, center=centre), color=colour, ambient=0.35)


def draw_mode(plotter: Any, arrays: dict[str, np.ndarray]) -> tuple[pyvista.PolyData, np.ndarray, np.ndarray]:
    """A body coloured by the amplitude of its displacement, its edges at rest behind it; surface, place and shape."""
    triangles = arrays["triangles"]
    cells = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    mesh = pyvista.PolyData(arrays["nodes"].copy(), cells)
    mesh["amplitude"] = np.linalg.norm(arrays["shape"], axis=1)
    edges = mesh.extract_feature_edges(FEATURE_ANGLE, boundary_edges=False, manifold_edges=False)
    if edges.n_cells:
        plotter.add_mesh(edges.copy(), color="#9aa4ad", line_width=1.0)
    plotter.add_mesh(mesh, scalars="amplitude", cmap="viridis", clim=(0.0, 1.0), show_scalar_bar=False)
    reach = float(arrays["reach"])
    low, high = arrays["nodes"].min(axis=0) - reach, arrays["nodes"].max(axis=0) + reach
    plotter.add_mesh(pyvista.Box((low[0], high[0], low[1], high[1], low[2], high[2])), opacity=0.0)  # keeps the view
    return mesh, arrays["nodes"], reach * arrays["shape"]


def surface(points: np.ndarray, faces: np.ndarray) -> pyvista.PolyData:
    """A surface of faces with a fixed number of corners, double points merged."""
    cells = np.column_stack([np.full(len(faces), faces.shape[1]), faces]).ravel()
    return pyvista.PolyData(points, cells).triangulate().clean()


def look_at(plotter: Any, direction: list[float], up: list[float], zoom: float) -> None:
    """Parallel projection from a direction, everything in the picture."""
    plotter.enable_parallel_projection()
    plotter.view_vector(direction, viewup=up)
    plotter.camera.zoom(zoom)


def pixel(plotter: Any, place: list[float]) -> list[float]:
    """Column and row of a point in the picture, row 0 at the top."""
    renderer = plotter.renderer
    renderer.SetWorldPoint(*place, 1.0)
    renderer.WorldToDisplay()
    column, row, _ = renderer.GetDisplayPoint()
    return [column, plotter.window_size[1] - row]


if __name__ == "__main__":
    main(sys.argv[1])
