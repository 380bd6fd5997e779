"""`gearcase gears`: the mesh laws of a scene."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Build the laws and print the stiffness and transmission error of each pair at its load."""
    import numpy as np

    from fem.contact.evaluation.curves import stiffness_curve
    from pipelines.engine.cache import Cache
    from pipelines.engine.progress import shown_progress
    from pipelines.engine.run_graph import run_graph
    from pipelines.report.contents import grid
    from pipelines.scene.presets import load_asked
    from pipelines.steps.study import plan_study

    loaded = load_asked(options)
    study = plan_study(loaded, with_control=False, both_loads=False)
    wanted, plant = study.plant.law_names, study.plant
    with shown_progress(len(wanted), quiet=options.quiet) as observer:
        outcome = run_graph(study.graph, Cache(), wanted, observer=observer, processes=options.processes)
    rows = []
    for number, (name, pair, facts) in enumerate(zip(wanted, plant.layout.pairs, plant.facts.stages, strict=True), 1):
        law = outcome.value(name)[0]
        load = facts.shown_force
        curve = stiffness_curve(law, load)
        rows.append(
            {
                "stage": number,
                "pair": f"{pair.pinion.teeth}/{pair.wheel.teeth}",
                "model": law.model,
                "eps_alpha": pair.transverse_contact_ratio,
                "eps_beta": pair.overlap_ratio,
                "load N": load,
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
