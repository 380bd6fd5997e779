"""`gearcase gears`: the mesh laws of a scene."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Build the laws and print the stiffness and transmission error of each pair at its load."""
    import numpy as np

    from pipelines.engine.working import Work
    from pipelines.report.contents import grid
    from pipelines.runs.single_results import build_pairs
    from pipelines.scene.presets import load_asked

    rows = []
    for found in build_pairs(load_asked(options), Work(processes=options.processes, quiet=options.quiet)):
        pair, curve = found.pair, found.stiffness()
        rows.append(
            {
                "stage": found.stage,
                "pair": f"{pair.pinion.teeth}/{pair.wheel.teeth}",
                "model": found.drive.model,
                "eps_alpha": pair.transverse_contact_ratio,
                "eps_beta": pair.overlap_ratio,
                "load N": found.force,
                "secant N/um": float(curve.secant.mean()) / 1e6,
                "tangent N/um": float(curve.tangent.mean()) / 1e6,
                "ripple %": 100 * float(np.ptp(curve.secant) / curve.secant.mean()),
                "TE um": float(curve.transmission_error.mean()) * 1e6,
                "TE p-p um": float(np.ptp(curve.transmission_error)) * 1e6,
                "bores mm": f"{pair.pinion.bore_radius * 2000:g}/{pair.wheel.bore_radius * 2000:g}",
            }
        )
    title = "Mesh laws without deviations, along the transverse line of action, compliance counted from the bores"
    sys.stdout.write(grid(title, rows).to_text() + "\n")
    return 0
