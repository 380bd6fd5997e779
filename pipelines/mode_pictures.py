"""Moving pictures of a casing's natural mode: a still, a GIF and a page that needs nothing but itself."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipelines.pictures import LeftOut, Picture, render_mode

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRAMES = 16  # of one period
_MILLISECONDS = 70  # per frame


@dataclass(frozen=True, eq=False, kw_only=True)
class ModeView:
    """A mode to be shown: surface of the body at rest and displacements of length at most 1."""

    title: str  # of the body
    number: int  # from 1
    frequency: float  # Hz
    nodes: np.ndarray  # (n, 3), m
    facets: np.ndarray  # (f, 6), corners, then mid-sides 01 12 20
    shape: np.ndarray  # (n, 3)


def write_mode(view: ModeView, folder: Path) -> list[Path] | LeftOut:
    """casing_mode_<n>.png, .gif and .html in a folder; the reason if they cannot be rendered."""
    triangles = view.facets[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    used, place = np.unique(triangles, return_inverse=True)
    pictures = render_mode(view.nodes[used], place.reshape(-1, 3), view.shape[used], FRAMES)
    if isinstance(pictures, LeftOut):
        return pictures
    size = np.ptp(view.nodes, axis=0)
    frames = [_png(mode_figure(view, picture, size)) for picture in pictures]
    stem = folder / f"casing_mode_{view.number}"
    still, film, page = (stem.with_suffix(ending) for ending in (".png", ".gif", ".html"))
    still.write_bytes(frames[FRAMES // 4])  # the largest deflection
    _write_gif(frames, film)
    page.write_text(mode_page(view, frames), encoding="utf-8")
    return [still, film, page]


def mode_figure(view: ModeView, picture: Picture, size: np.ndarray) -> Figure:
    """One frame with title, axes and colour scale."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    from pipelines.callouts import draw_axes, show
    from pipelines.plots import new_figure

    figure = new_figure(6.2, 9.5)
    axes = figure.subplots()
    _, right, _, bottom = show(axes, picture, whole=True)
    draw_axes(axes, picture, (0.92 * right, 0.95 * bottom))
    figure.suptitle(f"{view.title}\nmode {view.number}: {view.frequency:.1f} Hz")
    length, width, height = (1000 * v for v in size)
    axes.text(
        0.0,
        0.0,
        f"body {length:.0f} x {width:.0f} x {height:.0f} mm (x, y, z); deflection exaggerated",
        transform=axes.transAxes,
        fontsize=9,
        va="bottom",
    )
    bar = figure.colorbar(ScalarMappable(Normalize(0.0, 1.0), cmap="viridis"), ax=axes, shrink=0.7, pad=0.01)
    bar.set_label("amplitude of displacement over its largest")
    return figure


def mode_page(view: ModeView, frames: Sequence[bytes]) -> str:
    """A page that plays the frames, stops, and steps through the phase."""
    title = html.escape(f"{view.title}: mode {view.number}, {view.frequency:.1f} Hz")
    images = ",".join(f'"{base64.b64encode(frame).decode()}"' for frame in frames)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<style>body{{font:16px sans-serif;margin:1.5em;max-width:1000px}}img{{width:100%}}</style></head><body>
<h1 style="font-size:1.2em">{title}</h1>
<img id="frame" alt="{title}">
<p><button id="play">Stop</button>
<label> phase <input id="phase" type="range" min="0" max="{len(frames) - 1}" value="0"></label>
<span id="degrees"></span></p>
<script>
const frames=[{images}];
const image=document.getElementById("frame"),phase=document.getElementById("phase");
const play=document.getElementById("play"),degrees=document.getElementById("degrees");
let timer=null;
function show(){{image.src="data:image/png;base64,"+frames[+phase.value];
 degrees.textContent=Math.round(360*phase.value/frames.length)+"\u00b0";}}
function step(){{phase.value=(+phase.value+1)%frames.length;show();}}
function toggle(){{if(timer){{clearInterval(timer);timer=null;play.textContent="Play";}}
 else{{timer=setInterval(step,{_MILLISECONDS});play.textContent="Stop";}}}}
play.onclick=toggle;phase.oninput=()=>{{if(timer)toggle();show();}};
show();toggle();
</script></body></html>
"""


def _png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=80)
    return buffer.getvalue()


def _write_gif(frames: Sequence[bytes], path: Path) -> None:
    from PIL import Image

    images = [Image.open(io.BytesIO(frame)).convert("RGB").quantize(128) for frame in frames]
    images[0].save(path, save_all=True, append_images=images[1:], duration=_MILLISECONDS, loop=0)
