"""`gearcase casing`: the reduced casing of a scene, its check-up, its modes, its error, its files."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fem.casing.reduced.modes import CasingModes, NaturalModes
    from pipelines.engine.run_graph import Outcome
    from pipelines.plant.plant import Plant

_STATIC_BAND = 1000.0  # Hz, to which the rung static is compared and exported


def main(options: argparse.Namespace) -> int:
    """Build the casing; print check-up, modes and error (elastic rungs) and the coordinates; write the files asked."""
    from pipelines.border.errors import InputError
    from pipelines.engine.cache import Cache
    from pipelines.engine.progress import shown_progress
    from pipelines.engine.run_graph import run_graph
    from pipelines.engine.step import Graph
    from pipelines.runs.casing_export import checked_target
    from pipelines.scene.presets import load_asked
    from pipelines.steps.graph import casing_error_stage
    from pipelines.steps.study import plan_study

    targets = [checked_target(name) for name in options.export]
    loaded = load_asked(options)
    study = plan_study(loaded, with_control=False, both_loads=False)
    graph, plant = study.graph, study.plant
    elastic = "casing modes" in graph.stages
    if not elastic and (options.error_check or any(t.suffix == ".vtu" for t in targets)):
        raise InputError(f"a {plant.rungs['casing']} casing has no full model; choose casing.model craig-bampton")
    wanted = ["casing", *(["casing mesh", "casing modes"] if elastic else [])]
    if options.error_check:
        graph = Graph([*graph, casing_error_stage(graph, _band(plant))])
        wanted.append("casing error")
    with shown_progress(len(graph.needed(wanted).stages), quiet=options.quiet) as observer:
        outcome = run_graph(graph, Cache(), wanted, observer=observer, processes=options.processes)
    body = outcome.value("casing")
    natural = None
    if elastic:
        from fem.casing.reduced.modes import natural_modes

        modes, check = outcome.value("casing modes")
        limit = None if modes.band_limit == 0.0 else 1.5 * _band(plant)
        factor = body.stiffness_factor
        natural = natural_modes(modes, graph.stages["casing"].spec.mounts, limit=limit, stiffness_factor=factor)
        extrapolated = f"stiffness times {factor:.4f}, extrapolated to elements of size zero\n" if factor != 1.0 else ""
        sys.stdout.write(f"{describe(modes)}\n{extrapolated}{check.report(0)}\n{mode_table(natural, options.modes)}\n")
    if options.error_check:
        sys.stdout.write(f"{outcome.value('casing error').report()}\n")
    sys.stdout.write(f"casing {body.model}: {len(body.coordinate_names)} coordinates, {len(body.row_names)} rows\n")
    for name, (x, y, z) in zip(body.point_names, body.point_positions * 1000, strict=True):
        sys.stdout.write(f"  {name:10} x {x:8.2f}  y {y:8.2f}  z {z:8.2f} mm\n")
    for record in outcome.records:
        if "casing" in record.name:
            reused = ", taken from the cache" if record.reused else ""
            sys.stdout.write(f"  {record.name:19} {record.seconds:7.1f} s {record.peak_bytes / 1e6:6.0f} MB{reused}\n")
    for target in targets:
        _write(target, outcome, plant, natural)
        sys.stdout.write(f"{target}\n")
    return 0


def describe(modes: CasingModes) -> str:
    """Size, solver, ground and coupling, and how it is known that no mode is missed."""
    text = f"{modes.unknowns} unknowns, solver {modes.solver}, ground {modes.ground}, attachment {modes.attachment}"
    fixed = modes.mode_set.n_fixed
    if not modes.band_limit:
        return text
    sure = f"the law of inertia counts {modes.counted}" if modes.counted >= 0 else "not counted by the law of inertia"
    return f"{text}\n{fixed} fixed-interface modes to {modes.band_limit:g} Hz ({sure}), {len(modes.mass)} coordinates"


def mode_table(natural: NaturalModes, count: int) -> str:
    """Natural frequencies with effective masses in percent of mass and inertia."""
    from pipelines.border.grid import Grid

    share = 100.0 * natural.effective_mass / natural.total
    headers = ("mode", "Hz", "x %", "y %", "z %", "about x %", "about y %", "about z %")
    rows = [
        (str(i + 1), f"{natural.frequencies[i]:.2f}", *(f"{v:.2f}" for v in share[i]))
        for i in range(min(count, len(share)))
    ]
    rows.append(("all", f"{len(share)} modes", *(f"{v:.2f}" for v in share.sum(axis=0))))
    return Grid(title="Natural modes in the ground, effective mass", headers=headers, rows=tuple(rows)).to_text()


def _band(plant: Plant) -> float:
    return getattr(plant.casing, "band", 0.0) or _STATIC_BAND


def _write(target: Path, outcome: Outcome, plant: Plant, natural: NaturalModes | None) -> None:
    from pipelines.border.errors import InputError
    from pipelines.runs import casing_export

    body = outcome.value("casing")
    try:
        if target.suffix == ".h5":
            body.save(target)
        elif target.suffix == ".mat":
            casing_export.write_mat(body, target)
        elif target.suffix == ".uff":
            casing_export.write_uff(body, target, title=plant.title, band=_band(plant))
        elif natural is not None:
            mesh, modes = outcome.value("casing mesh"), outcome.value("casing modes")[0]
            casing_export.write_vtu(mesh, modes, natural, target, band=_band(plant))
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --export.") from error
