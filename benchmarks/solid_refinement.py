"""Refinement of the model `solid`: `python -m benchmarks.solid_refinement [OUTPUT.json [PLOT.png]]`.

Three levels along each of two axes: the mesh (sizes of section, face and patches together) with the default slices, and
the slices of the contact lines with the default mesh. Mean of the secant stiffness and peak-to-peak of the transmission
error at 100 N/mm are held against the value extrapolated along each axis: Richardson with the observed order, no more
than 4 and no less than 1, that of the slices at the ends of the contact lines, which is also taken where the
differences do not shrink yet. The error of the default is the sum over both axes.
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.gear_pairs import thick_rimmed_pair
from benchmarks.solid_contact import solve
from fem.contact.models.solid import Solid

CASES = ((0.0, 12e-3), (12.0, 12e-3), (15.0, 30e-3))  # beta in degrees, b in m
DEFAULT = (1.0, 31)  # refinement, slices
RATIO = 5 / 3
AXES = {"mesh": ((0.6, 31), DEFAULT, (RATIO, 31)), "slices": (DEFAULT, (1.0, 51), (1.0, 85))}
LINE_LOAD = 100e3  # N/m
QUANTITIES = {"mean": "mean_N_per_m", "peak_to_peak": "peak_to_peak_m"}


def extrapolated(values: list[float]) -> tuple[float, float]:
    """Limit and order from three levels refined by RATIO; order nan where they change direction.

    The limit is then the last value plus the last difference, away from the middle one.
    """
    first, second = values[1] - values[0], values[2] - values[1]
    if first * second <= 0:
        return values[2] + second, math.nan
    order = min(max(math.log(first / second) / math.log(RATIO), 1.0), 4.0)
    return values[2] + second / (RATIO**order - 1), order


def level(beta: float, face: float, refinement: float, slices: int) -> dict[str, float]:
    """Both quantities of one pair at one level, and the seconds of processor time."""
    start = time.process_time()
    record = Solid(slices=slices, refinement=refinement).compliance(thick_rimmed_pair(beta, 1000 * face))
    state = solve(record, force=LINE_LOAD * face)
    return {
        "mean_N_per_m": float((state.force / state.approach).mean()),
        "peak_to_peak_m": float(np.ptp(state.approach)),
        "cpu_s": time.process_time() - start,
    }


def study() -> list[dict[str, Any]]:
    """One entry per case: the levels of each axis with their values, limit and order, and the errors of the default."""
    out = []
    for beta, face in CASES:
        found = {key: level(beta, face, *key) for key in sorted({key for keys in AXES.values() for key in keys})}
        entry: dict[str, Any] = {"helix_deg": beta, "face_mm": face * 1e3, "axes": {}}
        for axis, keys in AXES.items():
            data: dict[str, Any] = {
                "levels": [list(key) for key in keys],
                "cpu_s": [found[key]["cpu_s"] for key in keys],
            }
            for quantity, name in QUANTITIES.items():
                values = [found[key][name] for key in keys]
                limit, order = extrapolated(values)
                data |= {name: values, f"{quantity}_limit": limit, f"{quantity}_order": order}
            entry["axes"][axis] = data
        for quantity, name in QUANTITIES.items():
            default = found[DEFAULT][name]
            entry[f"{quantity}_error"] = sum(default - axis[f"{quantity}_limit"] for axis in entry["axes"].values())
            entry[f"{quantity}_share"] = entry[f"{quantity}_error"] / (default - entry[f"{quantity}_error"])
        out.append(entry)
    return out


def plot(entries: list[dict[str, Any]], path: Path) -> None:
    """Difference of every level from the limit of its axis, for both quantities."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 7.5), layout="constrained")
    panels = figure.subplots(2, 2)
    labels = {"mesh": "refinement of the mesh (1: default)", "slices": "slices along the face (31: default)"}
    titles = {"mean": ("Mean secant stiffness", 1.0), "peak_to_peak": ("Transmission error, peak-to-peak", 5.0)}
    for row, quantity in zip(panels, QUANTITIES, strict=True):
        for panel, axis in zip(row, AXES, strict=True):
            for entry in entries:
                data = entry["axes"][axis]
                places = [key[0] if axis == "mesh" else key[1] for key in data["levels"]]
                limit = data[f"{quantity}_limit"]
                error = [100 * abs(value / limit - 1) for value in data[QUANTITIES[quantity]]]
                panel.loglog(places, error, "o-", label=f"β {entry['helix_deg']:g}°, b {entry['face_mm']:g} mm")
            title, wanted = titles[quantity]
            panel.axhline(wanted, color="0.5", linestyle="--", label=f"{wanted:g} %")
            panel.set(xlabel=labels[axis], ylabel="deviation from the extrapolated value, %", title=title)
            panel.set_xticks(places, [f"{place:.3g}" for place in places])
            panel.minorticks_off()
            panel.legend(fontsize=8)
    figure.suptitle("Model solid: z 20/55, m_n 2 mm, 100 N/mm")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main(arguments: list[str]) -> None:
    """Run the study; write JSON and plot."""
    target = Path(arguments[0]) if arguments else Path("benchmarks/results/solid-refinement.json")
    picture = Path(arguments[1]) if len(arguments) > 1 else Path("docs/images/solid-refinement.png")
    entries = study()
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    plot(entries, picture)
    for entry in entries:
        changes = [
            f"{axis} {quantity}"
            for axis, data in entry["axes"].items()
            for quantity in QUANTITIES
            if math.isnan(data[f"{quantity}_order"])
        ]
        sys.stdout.write(
            f"beta {entry['helix_deg']:g} b {entry['face_mm']:g}: error of the default {entry['mean_share']:+.3%} "
            f"in the mean, {1e6 * entry['peak_to_peak_error']:+.4f} um ({entry['peak_to_peak_share']:+.2%}) in e "
            "peak-to-peak; "
            f"{'not monotone: ' + ', '.join(changes) if changes else 'monotone along both axes'}\n"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
