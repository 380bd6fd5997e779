"""Interactive charts within the page, without external files: data in compact form, displayed by uPlot.

Signals are 16-bit numbers with a scale (every sample of the verdict's channel: 32-bit floats), spectra the logarithm of
their amplitudes in steps of 1/2000 of a decade, 0.06 % of the value. Figures of the class "static" replace them
without scripts, and on paper.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from pipelines.report import page
from pipelines.report.chart_data import ChartChannel, ChartView, Trace
from pipelines.report.figures.colours import FAULTY, HEALTHY

LEVELS = 32_767  # of a 16-bit number
STEP = 1 / 2_000  # of a decade
LEAST = 1e-15  # m/s2, in place of an amplitude of zero


def charts(
    runs: Sequence[str],
    shown: Sequence[ChartView],
    found: Iterable[ChartChannel],
    windows: Mapping[str, tuple[float, float]],
) -> str:
    """HTML element with the charts, their data, style and scripts.

    Parameters
    ----------
    runs : names of the runs, the healthy ones beginning with "healthy"
    shown : the charts
    found : their data, by channel
    windows : of the diagnosis, (start, end) in s, shaded in the signal
    """
    data = {
        "runs": [{"name": name, "colour": HEALTHY if name.startswith("healthy") else FAULTY} for name in runs],
        "windows": [[name, *span] for name, span in windows.items()],
        "views": [vars(view) for view in shown],
        "channels": [
            {
                "name": channel.name,
                "note": channel.note,
                "traces": [
                    [_packed(trace, view.logarithmic, channel.exact) for trace in traces]
                    for view, traces in zip(shown, channel.traces, strict=True)
                ],
            }
            for channel in found
        ],
    }
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    licence = page.asset("uPlot-LICENSE.txt")
    return (
        f'<style>{page.asset("uPlot.min.css")}</style><div id="zoom"></div>\n'
        f'<script type="application/json" id="zoom-data">{text}</script>\n'
        f"<script>/*\n{licence}*/\n{page.asset('uPlot.iife.min.js')}</script>\n<script>{page.asset('zoom.js')}</script>"
    )


def _packed(trace: Trace, logarithmic: bool, exact: bool) -> dict[str, Any]:
    """A trace as base64 of little-endian numbers, with their type and scale."""
    if logarithmic:
        numbers, scale = np.rint(np.log10(np.maximum(trace.values, LEAST)) / STEP).astype("<i2"), STEP
    elif exact:
        numbers, scale = trace.values.astype("<f4"), 1.0
    else:
        scale = float(np.abs(trace.values).max()) / LEVELS or 1.0
        numbers = np.rint(trace.values / scale).astype("<i2")
    kind = "f4" if numbers.dtype.kind == "f" else "i2"
    data = base64.b64encode(numbers.tobytes()).decode("ascii")
    return {"start": trace.start, "step": trace.step, "scale": scale, "kind": kind, "data": data}
