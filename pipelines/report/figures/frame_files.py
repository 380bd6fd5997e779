"""Figures and frames in files: a picture, a GIF, a page with a slider that needs nothing but itself."""

from __future__ import annotations

import base64
import html
import io
import json
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from pipelines.io.user_files import whole_file


def save_figure(figure: Figure, path: Path, *, dpi: int) -> None:
    """Write a figure in the format of the ending; the file is whole or not there."""
    figure.draw_without_rendering()  # the layout changes the ticks, and their labels then the layout
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=dpi)


def png(figure: Figure, dpi: int = 80) -> bytes:
    """A figure as the bytes of a PNG file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()


def write_gif(frames: Sequence[bytes], path: Path, milliseconds: int) -> None:
    """PNG frames as an endless GIF."""
    from PIL import Image

    images = [Image.open(io.BytesIO(frame)).convert("RGB").quantize(128) for frame in frames]
    with whole_file(path) as partial:
        images[0].save(partial, save_all=True, append_images=images[1:], duration=milliseconds, loop=0)


def film_page(title: str, frames: Sequence[bytes], what: str, labels: Sequence[str], milliseconds: int) -> str:
    """A page that plays PNG frames, stops, and steps by a slider.

    Parameters
    ----------
    title : of the page
    frames : PNG files
    what : the word at the slider
    labels : where each frame stands
    milliseconds : per frame
    """
    title = html.escape(title)
    images = ",".join(f'"{base64.b64encode(frame).decode()}"' for frame in frames)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<style>body{{font:16px sans-serif;margin:1.5em;max-width:1250px}}img{{width:100%}}input{{width:50%}}</style></head>
<body>
<h1 style="font-size:1.2em">{title}</h1>
<p><button id="play">Stop</button>
<label> {html.escape(what)} <input id="place" type="range" min="0" max="{len(frames) - 1}" value="0"></label>
<span id="label"></span></p>
<img id="frame" alt="{title}">
<script>
const frames=[{images}];
const labels={json.dumps(list(labels))};
const image=document.getElementById("frame"),place=document.getElementById("place");
const play=document.getElementById("play"),label=document.getElementById("label");
let timer=null;
function show(){{image.src="data:image/png;base64,"+frames[+place.value];label.textContent=labels[+place.value];}}
function step(){{place.value=(+place.value+1)%frames.length;show();}}
function toggle(){{if(timer){{clearInterval(timer);timer=null;play.textContent="Play";}}
 else{{timer=setInterval(step,{milliseconds});play.textContent="Stop";}}}}
play.onclick=toggle;place.oninput=()=>{{if(timer)toggle();show();}};
show();toggle();
</script></body></html>
"""
