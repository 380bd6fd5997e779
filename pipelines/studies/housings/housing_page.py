"""A page on which a housing from a file can be turned, with the numbers of its bores: one file, nothing else needed."""

from __future__ import annotations

import base64
import html
import json
from importlib.resources import files

import numpy as np

from fem.casing.recognition.housing_contents import GeometryContents

MOST_LABELS = 200
_STEPS = 65535  # of a coordinate along the longest side, in two bytes
MOST_TRIANGLES = 125_000  # 3 MB of a page
_CELLS = 2000  # of the finest grid along the longest side


def housing_page(contents: GeometryContents, seats: dict[int, str], text: str) -> str:
    """The HTML.

    Parameters
    ----------
    contents : what the file holds
    seats : name of the bearing by number of the bore
    text : the listing, below the picture
    """
    points, triangles = thinned(contents.points, contents.triangles)
    low, step = 1000 * contents.box[0], 1000 * float(np.ptp(contents.box, axis=0).max()) / _STEPS
    corners = np.rint((1000 * points[triangles] - low) / step).astype("<u2")
    labels = [
        {
            "text": f"{bore.number}: {seats[bore.number]}" if bore.number in seats else str(bore.number),
            "seat": bore.number in seats,
            "place": np.round(1000 * bore.centre, 4).tolist(),
        }
        for bore in contents.bores[:MOST_LABELS]
    ]
    box = np.round(1000 * contents.box, 4).tolist()
    script = files("pipelines.report").joinpath("assets", "turn.js").read_text(encoding="utf-8")
    encoded = base64.b64encode(corners.tobytes()).decode()
    data = json.dumps({"box": box, "step": step, "labels": labels, "corners": encoded})
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{html.escape(contents.name)}</title>
<style>body{{font:14px sans-serif;margin:1em}}#view{{position:relative;width:100%;height:70vh;overflow:hidden;
border:1px solid #ccc}}canvas{{width:100%;height:100%;display:block;cursor:grab}}.bore{{position:absolute;
transform:translate(-50%,-50%);color:#1f4e79;font-weight:bold;pointer-events:none;text-shadow:0 0 3px #fff}}
.seat{{color:#c0392b}}</style></head><body>
<h1 style="font-size:1.2em">{html.escape(contents.name)}: bores by number</h1>
<p>Drag to turn, wheel to zoom. Millimetres, in the frame of the file.</p>
<div id="view"><canvas></canvas></div>
<pre>{html.escape(text)}</pre>
<script id="data" type="application/json">{data}</script>
<script>{script}</script>
</body></html>
"""


def thinned(points: np.ndarray, triangles: np.ndarray, most: int = MOST_TRIANGLES) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles to look at, `most` triangles at most, small ones between merged points left out.

    Points are merged in the cells of a grid, the finest of a series that leaves few enough triangles with three
    different points. Nothing is computed with them.

    Parameters
    ----------
    points : (n, 3)
    triangles : int (t, 3), into the points
    most : triangles

    References
    ----------
    Rossignac & Borrel (1993), Multi-resolution 3D approximations for rendering complex scenes.
    """
    cells = _CELLS
    low, side = points.min(axis=0), float(np.ptp(points, axis=0).max())
    found = points, triangles
    while len(found[1]) > most:
        cell = np.floor((points - low) / side * cells).astype(np.int64)
        _, first, number = np.unique(cell, axis=0, return_index=True, return_inverse=True)
        merged = number.ravel()[triangles]
        whole = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
        once = np.unique(np.sort(whole, axis=1), axis=0, return_index=True)[1]
        found = points[first], whole[np.sort(once)]
        cells = 3 * cells // 4
    return found
