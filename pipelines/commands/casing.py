"""`gearcase casing`: the reduced casing of a scene, its check-up, its modes, its error, its files."""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from fem.casing.mesh_error.frequency_limits import FrequencyLimits
    from fem.casing.reduced.body import ReducedBody
    from fem.casing.reduced.modes import CasingModes, NaturalModes


def main(options: argparse.Namespace) -> int:
    """Build the casing; print check-up, modes and error (elastic models) and the coordinates; write the files asked."""
    from pipelines.border.errors import InputError
    from pipelines.engine.working import Work
    from pipelines.runs.casing_export import checked_target, write_casing
    from pipelines.runs.single_results import build_casing, no_full_model, scene_graph
    from pipelines.scene.presets import load_asked

    targets = [checked_target(name) for name in options.export]
    loaded = load_asked(options)
    graph, plant = scene_graph(loaded)
    if "casing mesh" not in graph.steps and any(t.suffix == ".vtu" for t in targets):
        raise InputError(no_full_model(plant))
    work = Work(processes=options.processes, quiet=options.quiet)
    casing = build_casing(loaded, work, error_check=options.error_check)
    body = casing.body
    if casing.modes is not None and casing.natural is not None and casing.checkup is not None:
        factor = body.stiffness_factor
        extrapolated = f"stiffness times {factor:.4f}, extrapolated to elements of size zero\n" if factor != 1.0 else ""
        table = mode_table(casing.natural, options.modes)
        sys.stdout.write(f"{describe(casing.modes)}\n{extrapolated}{casing.checkup.report(0)}\n{table}\n")
        if casing.natural.part_names:
            sys.stdout.write(f"{part_table(casing.natural, modal_ratios(body), options.modes)}\n")
        if casing.limits is not None:
            sys.stdout.write(f"{limit_table(casing.limits, options.modes)}\n")
    if casing.joint:
        sys.stdout.write(f"joint: {casing.joint}\n")
    if casing.mesh is not None and casing.mesh.divided:
        sys.stdout.write(
            f"{casing.mesh.divided} of the file were divided into {len(casing.mesh.elements)} tetrahedra between the "
            "same nodes\n"
        )
    if casing.mesh is not None and casing.mesh.straightened:
        sys.stdout.write(
            f"{casing.mesh.straightened} of {len(casing.mesh.elements)} curved elements of the file were folded or "
            "nearly so and have lost curvature, with those that share their mid-side nodes\n"
        )
    if casing.error is not None:
        sys.stdout.write(f"{casing.error.report()}\n")
    sys.stdout.write(f"casing {body.model}: {len(body.coordinate_names)} coordinates, {len(body.row_names)} rows\n")
    for name, (x, y, z) in zip(body.point_names, body.point_positions * 1000, strict=True):
        sys.stdout.write(f"  {name:10} x {x:8.2f}  y {y:8.2f}  z {z:8.2f} mm\n")
    if body.feet:
        sys.stdout.write(weight_lines(body))
    for record in casing.records:
        reused = ", taken from the cache" if record.reused else ""
        sys.stdout.write(f"  {record.name:19} {record.seconds:7.1f} s {record.peak_bytes / 1e6:6.0f} MB{reused}\n")
    for target in targets:
        write_casing(casing, plant.title, target)
        sys.stdout.write(f"{target}\n")
    return 0


def weight_lines(body: ReducedBody) -> str:
    """What the feet carry and how far the bearing seats sink under the weight of the casing alone."""
    import numpy as np

    from mbd.parts.machine import STANDARD_GRAVITY

    moved = np.linalg.solve(body.stiffness, body.own_weight(STANDARD_GRAVITY))
    up = body.foot_forces(moved, STANDARD_GRAVITY)[:, 2]
    feet = ", ".join(f"{name} {force:.4g}" for name, force in zip(body.feet, up, strict=True))
    sunk = [
        -1e6 * float(body.row(name) @ moved)
        for name in body.row_names
        if name.startswith("bearing_") and name.endswith(":uz")
    ]
    seats = f"; its bearing seats sink by {min(sunk):.3g} to {max(sunk):.3g} um" if sunk else ""
    return f"own weight {up.sum():.4g} N: {feet} N{seats}\n"


def limit_table(limits: FrequencyLimits, count: int) -> str:
    """Limits of the natural frequencies at elements of size zero, with their bands; rigid motions are left out."""
    import numpy as np

    from pipelines.border.grid import Grid

    alone = bool(np.isfinite(limits.orders).any())  # orders are told by meshes of three sizes only
    rows = [
        (str(i + 1), f"{f:.2f}", f"{limit:.2f}", f"{band:.2f}", f"{100 * band / limit:.2f}", *([_order(order)] * alone))
        for i, (f, limit, band, order) in enumerate(
            zip(limits.frequencies, limits.limits, limits.bands, limits.orders, strict=True)
        )
    ]
    what = f"three sizes, common order {limits.order:.2f}" if alone else "cubic and quadratic displacements on one mesh"
    title = (
        f"Elements of size zero, from {what}; bands of {len(rows)} modes: "
        f"{100 * limits.median_band:.2f} % in the median, {100 * limits.widest_band:.2f} % at most"
    )
    headers = ("mode", "Hz on its mesh", "limit, Hz", "+- Hz", "+- %", *(["order alone"] * alone))
    return Grid(title=title, headers=headers, rows=tuple(rows[:count])).to_text()


def _order(order: float) -> str:
    return "not monotone" if math.isnan(order) else f"{order:.1f}"


def modal_ratios(body: ReducedBody) -> np.ndarray:
    """Damping ratio (mode,) of every natural mode of a reduced casing."""
    import numpy as np
    from scipy.linalg import eigh

    squares, shapes = eigh(body.stiffness, body.mass)
    damping = np.einsum("ik,ij,jk->k", shapes, body.damping, shapes, optimize=True)
    return np.asarray(0.5 * damping / np.sqrt(np.maximum(squares, np.finfo(float).tiny)))


def part_table(natural: NaturalModes, ratios: np.ndarray, count: int) -> str:
    """Damping of the natural modes, and what parts of the casing store of their strain energy."""
    from pipelines.border.grid import Grid

    shares = 100.0 * natural.shares.T
    headers = ("mode", "Hz", "damping %", *(f"{name} %" for name in natural.part_names), "rest %")
    rows = [
        (str(i + 1), f"{natural.frequencies[i]:.2f}", f"{100 * ratios[i]:.3g}", *(f"{v:.2f}" for v in share),
         f"{100.0 - share.sum():.2f}")
        for i, share in enumerate(shares[: min(count, len(ratios))])
    ]  # fmt: skip
    return Grid(title="Damping ratio, strain energy by part", headers=headers, rows=tuple(rows)).to_text()


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
