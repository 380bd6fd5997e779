"""`gearcase casing`: the reduced casing of a scene, its check-up, modes, frequency responses and exported files."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from pipelines.cli.command_line import JSON, WORK, argument, scene_and_work
from pipelines.io.argument_types import count, path

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from fem.casing.reduced.casing_modes import CasingModes, NaturalModes
    from fem.casing.reduced.reduced_body import ReducedBody
    from fem.casing.uncertainty.frequency_limits import FrequencyLimits
    from pipelines.runs.single_results import Casing

ARGUMENTS = (
    *WORK,
    argument(
        "--error-check",
        action="store_true",
        help="compare frequencies and responses with the model before reduction; takes about as long as the reduction",
    ),
    argument(
        "--export",
        metavar="FILE",
        type=path,
        action="append",
        default=[],
        help="write the reduced matrices as .h5, .mat, .npz, .mtx, .op4 or .pch, a modal model as .uff, or the "
        "modes on the mesh as .vtu, or a parametric housing as .step; repeatable",
    ),
    argument(
        "--response",
        metavar="POINT",
        nargs="+",
        default=[],
        help="write frequency responses (m/s2/N, CSV and PNG). The first POINT gives place and axis of the force, as "
        "in bearing_1:z; the responses are at the other points (default: at all sensors)",
    ),
    argument(
        "--out",
        metavar="FOLDER",
        type=path,
        help="folder for the frequency responses of --response (default: the working folder)",
    ),
    argument("--modes", metavar="N", type=count, default=20, help="number of modes in the table (default 20)"),
    JSON,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Mesh the casing of a scene and reduce it to its bearing points and modes. Print these points, natural frequencies
    with uncertainty bands, and weight. --response writes frequency responses, --export the matrices or mode shapes.
    Takes seconds to minutes.

    Example
    -------
    gearcase casing minimal
    casing rigid: 6 coordinates, 23 outputs
    ...
      bearing_1  x     0.00  y   -65.00  z     0.00 mm
    ...
    """
    from pipelines.io.errors import InputError, SceneWarning
    from pipelines.io.json_text import json_text
    from pipelines.io.user_files import writable_file, writable_folder
    from pipelines.runs.single_results import build_casing, scene_graph
    from pipelines.steps.casing import casing_warnings
    from pipelines.studies.housings.casing_export import FORMATS, FREE_BODIES, check_package, free_body, write_casing
    from pipelines.studies.housings.responses import checked_names
    from pipelines.studies.housings.superelement import housing_table

    if options.out and not options.response:
        raise InputError("--out is the folder of --response. Add --response, or delete --out.")
    folder = writable_folder(options.out or ".")
    targets = [writable_file(name, "--export", FORMATS) for name in options.export]
    for target in targets:
        check_package(target)
    loaded, work = scene_and_work(options)
    graph, machine = scene_graph(loaded)
    if "casing mesh" not in graph.steps and any(t.suffix == ".vtu" for t in targets):
        raise InputError(
            "--export FILE.vtu: the casing has no mesh. Set casing.model to craig-bampton, and casing.housing to a "
            "shape, a CAD file or a mesh; or export .h5 or .mat."
        )
    if options.response:
        if machine.models["casing"] == "none":
            raise InputError("--response: casing.model = 'none' has no motion. Set casing.model to craig-bampton.")
        bearings = [f"bearing_{number}" for number in range(1, len(machine.bearing_points) + 1)]
        checked_names(options.response, bearings, [sensor.name for sensor in machine.sensors])
    casing = build_casing(loaded, work, error_check=options.error_check)
    if missed := missed_error(casing):
        warnings.warn(missed, SceneWarning, stacklevel=1)
    for words in casing_warnings(casing.body, {sensor.name: sensor.position for sensor in machine.sensors}):
        warnings.warn(words, SceneWarning, stacklevel=1)
    if options.json:
        yield json_text(casing_facts(casing, loaded.name))
    else:
        yield from _texts(casing, options.modes)
    exports = [write_casing(casing, machine.title, target) for target in targets]
    written = [path for files in exports for path in files]
    if options.response:
        folder.mkdir(parents=True, exist_ok=True)
        written += _write_response(casing, options.response, loaded.name, machine.title, folder)
    if options.json:
        sys.stderr.write("".join(f"{path}\n" for path in written))
    else:
        yield from map(str, written)
        for files in exports:
            if files[0].suffix.lower() in FREE_BODIES:
                yield f"\nto import {files[0].name}:"
                yield housing_table(free_body(casing), files, casing.band)


def _texts(casing: Casing, count: int) -> Iterator[str]:
    """What is printed, paragraph by paragraph."""
    body = casing.body
    if casing.modes is not None and casing.natural is not None and casing.checkup is not None:
        yield describe(casing.modes)
        if casing.mesh is not None:
            asked = (
                ""
                if casing.requested_error is None
                else f", chosen for casing.error = {100 * casing.requested_error:.3g} %"
            )
            yield f"element size {1000 * casing.mesh.element_size:.3g} mm{asked}"
        yield casing.checkup.report()
        yield casing_mode_table(casing.natural, count, casing.bands)
        if casing.modes.band_limit and (casing.natural.frequencies[:count] > casing.band).any():
            yield f"Modes above casing.band_Hz = {casing.band:g} Hz are approximate, and some may be missing."
        if count < (total := len(casing.natural.frequencies)):
            yield f"Modes 1 to {count} of {total}. To print more, set --modes."
        if casing.limits is None and casing.mesh is not None:
            yield "no uncertainty bands: set casing.extrapolated = true, or use --preset standard"
        if casing.limits is not None:
            yield band_words(casing.limits, body.stiffness_factor, casing.bands / casing.frequencies)
            if bool((casing.frequencies[casing.bands > 0.0] > casing.band).any()):
                yield reduction_words(casing.modes.band_limit > 0.0, casing.band)
        if casing.natural.part_names:
            yield part_table(casing.natural, modal_ratios(body), count)
    if casing.joint:
        yield f"joint: {casing.joint}"
    if casing.mesh is not None and casing.mesh.divided:
        yield (
            f"{casing.mesh.divided} of the file were divided into {len(casing.mesh.elements)} tetrahedra between the "
            "same nodes"
        )
    if casing.mesh is not None and casing.mesh.straightened:
        yield (
            f"{casing.mesh.straightened} of {len(casing.mesh.elements)} curved elements of the file were folded or "
            "nearly so. These, and elements that share their mid-side nodes, were made less curved"
        )
    if casing.error is not None:
        yield casing.error.report()
    yield f"casing {body.model}: {len(body.coordinate_names)} coordinates, {len(body.row_names)} outputs"
    for name, (x, y, z) in zip(body.point_names, (1000 * body.point_positions).round(2) + 0.0, strict=True):
        yield f"  {name:10} x {x:8.2f}  y {y:8.2f}  z {z:8.2f} mm"
    if body.feet:
        yield weight_lines(body)
    for record in casing.records:
        reused = ", taken from the cache" if record.reused else ""
        yield f"  {record.name:19} {record.seconds:7.1f} s {record.peak_bytes / 1e6:6.0f} MB{reused}"


def _write_response(casing: Casing, names: list[str], scene: str, title: str, folder: Path) -> list[Path]:
    """Table and plot of the accelerances."""
    from pathlib import Path

    from pipelines.io.user_files import whole_file, writable_file
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.studies.housings.responses import accelerance, accelerance_figure, damping_words, table_lines

    words = damping_words(modal_ratios(casing.body), casing.frequencies, casing.band)
    found = accelerance(casing.body, names, casing.band, words)
    stem = f"response-{scene}-{found.force.replace(':', '-')}"
    table, plot = (writable_file(str(folder / f"{stem}{ending}"), "--response") for ending in (".csv", ".png"))
    with whole_file(table) as partial, Path(partial).open("w", encoding="utf-8") as file:
        file.writelines(table_lines(found, title))
    save_figure(accelerance_figure(found, title), plot, dpi=110)
    return [table, plot]


def casing_facts(casing: Casing, scene: str) -> dict[str, Any]:
    """Frequencies with their bands, effective masses, damping, element size and points; SI.

    `frequency_Hz` are those of the reduced casing. Where the stiffness is extrapolated, `extrapolation` holds the
    elastic modes as they are on the mesh, each extrapolated to zero element size, and the band of that.
    """
    body, natural, limits = casing.body, casing.natural, casing.limits
    return {
        "scene": scene,
        "units": "SI",
        "model": body.model,
        "coordinates": body.coordinate_names,
        "rows": body.row_names,
        "points": dict(zip(body.point_names, body.point_positions, strict=True)),
        "band_Hz": casing.band,
        "frequency_Hz": casing.frequencies,
        "frequency_band_Hz": casing.bands,
        "damping_ratio": modal_ratios(body),
        "effective_mass": None if natural is None else natural.effective_mass,
        "element_size": None if casing.mesh is None else casing.mesh.element_size,
        "stiffness_factor": body.stiffness_factor,
        "extrapolation": None
        if limits is None
        else {
            "mesh_frequency_Hz": limits.frequencies,
            "extrapolated_frequency_Hz": limits.limits,
            "extrapolated_band_Hz": limits.bands,
            "order": limits.orders,
        },
    }


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
    seats = f"; the bearing seats sink by {min(sunk):.3g} to {max(sunk):.3g} um" if sunk else ""
    return f"own weight {up.sum():.4g} N: {feet} N{seats}\n"


def band_words(limits: FrequencyLimits, factor: float, relative: np.ndarray) -> str:
    """Where the uncertainty bands of the frequencies come from, and where the other frequencies are."""
    import numpy as np

    by_sizes = bool(np.isfinite(limits.orders).any())  # meshes of one size give no order
    how = f"three element sizes, common order {limits.order:.2f}" if by_sizes else "cubic and quadratic elements"
    lacking = (
        "\n-: no band. Modes that move mainly on the mount springs have none, because the springs determine most of "
        "their frequency. The highest modes are not extrapolated: raise casing.band_Hz for their bands."
    )
    return (
        f"Hz: with the stiffness multiplied by {factor:.4f}, a factor extrapolated to zero element size from {how}.\n"
        f"+-: uncertainty band, {100 * np.nanmedian(relative):.2f} % in the median, "
        f"{100 * np.nanmax(relative):.2f} % at most.\n"
        "--json also prints the frequencies without extrapolation, and those extrapolated mode by mode."
        f"{lacking if np.isnan(relative).any() else ''}"
    )


def reduction_words(to_band: bool, band: float) -> str:
    """What uncertainty bands leave out: with modes up to a band (Hz) those beyond it, else all inner dynamics."""
    if to_band:
        return (
            f"Modes above casing.band_Hz = {band:g} Hz also have an error of modal truncation, which +- leaves out. "
            "To reduce it, raise casing.band_Hz."
        )
    return (
        "Static condensation also causes an error, which +- leaves out. --error-check computes it up to "
        f'{band:g} Hz. To reduce it, set casing.model = "craig-bampton".'
    )


def missed_error(casing: Casing) -> str:
    """That the frequencies miss the requested error, and what to do; "" if they do not, or none was requested."""
    import numpy as np

    if casing.requested_error is None:
        return ""
    median = float(np.nanmedian(casing.bands / casing.frequencies))
    if median <= casing.requested_error:
        return ""
    by_sizes = casing.limits is not None and bool(np.isfinite(casing.limits.orders).any())
    other = 'casing.element = "tetrahedron-20", or ' if by_sizes else ""
    return (
        f"casing.error = {100 * casing.requested_error:.3g} % is not reached: half of the natural frequencies have "
        f"uncertainty bands above {100 * median:.3g} %. Set {other}a smaller casing.error for smaller elements."
    )


def modal_ratios(body: ReducedBody) -> np.ndarray:
    """Damping ratio (mode,) of every natural mode of a reduced casing."""
    import numpy as np
    from scipy.linalg import eigh

    squares, shapes = eigh(body.stiffness, body.mass)
    damping = np.einsum("ik,ij,jk->k", shapes, body.damping, shapes, optimize=True)
    return np.asarray(0.5 * damping / np.sqrt(np.maximum(squares, np.finfo(float).tiny)))


def part_table(natural: NaturalModes, ratios: np.ndarray, count: int) -> str:
    """Damping of the natural modes, and what parts of the casing store of their strain energy."""
    from pipelines.io.text_table import grid

    shares = 100.0 * natural.shares.T
    rows = [
        {
            "mode": i + 1,
            "Hz": f"{natural.frequencies[i]:.2f}",
            "damping %": f"{100 * ratios[i]:.3g}",
            **{f"{name} %": f"{v:.2f}" for name, v in zip(natural.part_names, share, strict=True)},
            "rest %": f"{100.0 - share.sum():.2f}",
        }
        for i, share in enumerate(shares[: min(count, len(ratios))])
    ]
    return grid("Damping ratio, strain energy by part", rows).to_text()


def describe(modes: CasingModes) -> str:
    """Size, solver, ground and coupling, and how it is known that no mode is missed."""
    text = f"{modes.unknowns} unknowns, solver {modes.solver}, ground {modes.ground}, attachment {modes.attachment}"
    fixed = modes.mode_set.n_fixed
    if not modes.band_limit:
        return text
    sure = f"Sturm-sequence count {modes.counted}" if modes.counted >= 0 else "without a Sturm-sequence count"
    return f"{text}\n{fixed} fixed-interface modes to {modes.band_limit:g} Hz ({sure}), {len(modes.mass)} coordinates"


def casing_mode_table(natural: NaturalModes, count: int, bands: np.ndarray | None = None) -> str:
    """Natural frequencies, their uncertainty bands where known, effective masses in percent of mass and inertia."""
    import numpy as np

    from pipelines.io.text_table import Grid

    share = 100.0 * natural.effective_mass / natural.total
    known = bands is not None and bool(np.isfinite(bands).any())
    widths = [[f"{band:.2f}" if np.isfinite(band) else "-"] for band in bands] if bands is not None and known else []
    rows = [
        (str(i + 1), f"{natural.frequencies[i]:.2f}", *(widths[i] if known else ()), *(f"{v:.2f}" for v in share[i]))
        for i in range(min(count, len(share)))
    ]
    rows.append(("all", f"{len(share)} modes", *([""] * known), *(f"{v:.2f}" for v in share.sum(axis=0))))
    headers = ("mode", "Hz", *(["+- Hz"] * known), "x %", "y %", "z %", "about x %", "about y %", "about z %")
    return Grid(
        title="Natural modes of the casing on its ground, effective mass", headers=headers, rows=tuple(rows)
    ).to_text()
