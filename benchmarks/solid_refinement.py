"""Mesh refinement of the rung `solid`: `python -m benchmarks.solid_refinement [OUTPUT.json [PLOT.png]]`.

Three levels refine section, face and patches by the same factor 5/3, with slices in proportion; the default is the
middle one. Mean of the secant stiffness and peak-to-peak of the transmission error at 100 N/mm are held against the
value extrapolated from the levels: Richardson with the observed order, no more than 4 and no less than 1, the order of
the slices at the ends of the contact lines, which is also taken where the differences do not shrink yet.
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path

import numpy as np

from fem.contact.solid import Solid
from fem.contact.solid_contact import solve
from fem.gears.geometry import Gear, GearPair

CASES = ((0.0, 12e-3), (12.0, 12e-3), (15.0, 30e-3))  # beta in degrees, b in m
LEVELS = ((0.6, 13), (1.0, 21), (5 / 3, 35))  # refinement, slices
LINE_LOAD = 100e3  # N/m


def pair_of(beta: float, face: float) -> GearPair:
    """z 20/55, m_n 2 mm, bores at r_f / 1.4."""

    def gear(teeth: int, hand: str) -> Gear:
        root = (teeth / math.cos(beta) / 2 - 1.25) * 2e-3
        return Gear(
            teeth=teeth, normal_module=2e-3, helix_angle=beta, face_width=face, hand=hand, bore_radius=root / 1.4
        )

    return GearPair(pinion=gear(20, "right"), wheel=gear(55, "left"))


def extrapolated(values: list[float]) -> tuple[float, float]:
    """Limit and order from three levels refined by the same factor; order nan where they change direction.

    The limit is then the last value plus the last difference, away from the middle one.
    """
    coarse, middle, fine = values
    ratio = LEVELS[2][0] / LEVELS[1][0]
    first, second = middle - coarse, fine - middle
    if first * second <= 0:
        return fine + second, math.nan
    order = min(max(math.log(first / second) / math.log(ratio), 1.0), 4.0)
    return fine + second / (ratio**order - 1), order


def study() -> list[dict]:
    """One entry per case: levels, values, limits and the error of the default."""
    out = []
    for beta, face in CASES:
        means, peaks, seconds = [], [], []
        for refinement, slices in LEVELS:
            start = time.process_time()
            record = Solid(n_slices=slices, refinement=refinement).compliance(pair_of(math.radians(beta), face))
            state = solve(record, force=LINE_LOAD * face)
            seconds.append(time.process_time() - start)
            means.append(float((state.force / state.approach).mean()))
            peaks.append(float(np.ptp(state.approach)))
        (mean, mean_order), (peak, peak_order) = extrapolated(means), extrapolated(peaks)
        out.append(
            {
                "helix_deg": beta,
                "face_mm": face * 1e3,
                "levels": [list(level) for level in LEVELS],
                "mean_N_per_m": means,
                "peak_to_peak_m": peaks,
                "cpu_s": seconds,
                "mean_limit": mean,
                "mean_order": mean_order,
                "peak_limit": peak,
                "peak_order": peak_order,
                "mean_error": means[1] / mean - 1,
                "peak_error_m": peaks[1] - peak,
            }
        )
    return out


def plot(entries: list[dict], path: Path) -> None:
    """Error of every level against the limit, in the mean and in the peak-to-peak."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4), layout="constrained")
    mean, peak = figure.subplots(1, 2)
    for entry in entries:
        levels = [level[0] for level in entry["levels"]]
        label = f"beta {entry['helix_deg']:g} deg, b {entry['face_mm']:g} mm"
        mean.loglog(levels, [100 * abs(v / entry["mean_limit"] - 1) for v in entry["mean_N_per_m"]], "o-", label=label)
        peak.loglog(
            levels, [100 * abs(v / entry["peak_limit"] - 1) for v in entry["peak_to_peak_m"]], "o-", label=label
        )
    for axis, title, limit in ((mean, "Mean secant stiffness", 1.0), (peak, "Transmission error, peak-to-peak", 5.0)):
        axis.axhline(limit, color="0.5", linestyle="--", label=f"{limit:g} %")
        axis.set(xlabel="refinement (1: default)", ylabel="difference from the extrapolated value, %", title=title)
        axis.legend(fontsize=8)
    figure.suptitle("Rung solid, z 20/55, m_n 2 mm, 100 N/mm")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)


def main(arguments: list[str]) -> None:
    """Run the study; write JSON and plot."""
    target = Path(arguments[0]) if arguments else Path("benchmarks/results/solid-refinement.json")
    picture = Path(arguments[1]) if len(arguments) > 1 else Path("docs/images/solid-refinement.png")
    entries = study()
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(entries, indent=1), encoding="utf-8")
    plot(entries, picture)
    for entry in entries:
        sys.stdout.write(
            f"beta {entry['helix_deg']:g} b {entry['face_mm']:g}: mean {entry['mean_error']:+.3%} of the limit "
            f"{entry['mean_limit'] / 1e6:.2f} N/um, e peak-to-peak {1e6 * entry['peak_error_m']:+.4f} um of "
            f"{1e6 * entry['peak_limit']:.4f} um\n"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
