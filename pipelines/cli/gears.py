"""`gearcase gears`: the mesh laws of a scene."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from pipelines.cli.command_line import JSON, WORK, argument, scene_and_work
from pipelines.io.argument_types import path, picture, positive, tilt

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from pipelines.engine.run_graph import Work
    from pipelines.runs.gear_curves import MeshState
    from pipelines.scene.load_scene import LoadedScene
    from pipelines.steps.pair_curves import PairLaws

ARGUMENTS = (
    *WORK,
    argument(
        "--torque",
        metavar="N_M",
        type=positive,
        nargs="+",
        help="torques on the pinion of each pair, N m, as in --torque 50 100 200 (default: that of the scene, or of "
        "100 N/mm if it has no load)",
    ),
    argument(
        "--tilt",
        metavar="UM",
        type=tilt,
        default=0.0,
        help="misalignment of the flanks over the face width: a number in um (positive: closer at the +y end), "
        "balanced (the load is centred on the face) or machine (as in the loaded machine; without --torque); default "
        "0. The misalignment of the scene is always added",
    ),
    argument(
        "--out",
        metavar="FILE",
        type=path,
        help="write the curves to this file, .csv or .nc: a row for each state (healthy, or with a damaged tooth) and "
        "position in mesh cycles. At position 0 a tooth, in damaged states the damaged one, makes contact at the pitch "
        "point. Columns: secant and tangent stiffness; transmission error under load and without load; tilt; for each "
        "tooth pair (+0: this tooth, +1: the next) its share of the load and largest Hertz pressure",
    ),
    argument(
        "--plot",
        metavar="FILE",
        type=picture,
        help="plot the transmission error over the mesh cycle, and its orders, to this file: .png, .svg or .pdf. "
        "Curves: with modifications, without them, and while damaged teeth are in mesh",
    ),
    argument(
        "--map",
        metavar="FILE",
        type=path,
        nargs="+",
        default=(),
        help="write results of healthy pairs to these files, .png, .svg, .pdf or .nc. Over the torque: "
        "transmission error and its mesh orders. Along the face: pressure, line load (K_H beta), root stress (model "
        "`solid`, about 9 s for each pair) and contact pattern",
    ),
    JSON,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Compute the mesh stiffness, transmission error and load sharing of every gear pair, healthy and faulty, from the
    first to the last contact of one tooth. --plot plots the transmission error, --out writes the curves; `gearcase
    design` searches for reliefs and crownings. Takes seconds, and up to a minute for each pair with the mesh model
    `solid`.

    Example
    -------
    gearcase gears pair --torque 50 100 --plot te.png
    ...
    stage  torque N m  flanks      order 1 um  order 2 um  order 3 um  order 4 um  order 5 um
    -----  ----------  ----------  ----------  ----------  ----------  ----------  ----------
        1          50  unmodified      0.9229      0.6531      0.4129      0.1859    0.009963
    ...
    te.png
    """
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.io.text_table import grid
    from pipelines.io.user_files import writable_file
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.report.figures.plots import transmission_error_figure
    from pipelines.runs.gear_curves import (
        FORMATS,
        gear_curves,
        gear_rows,
        machine_states,
        transmission_errors,
        write_curves,
    )
    from pipelines.runs.load_map import FORMATS as MAP_FORMATS
    from pipelines.runs.single_results import build_pairs

    target = None if options.out is None else writable_file(options.out, endings=FORMATS)
    picture = None if options.plot is None else writable_file(options.plot)
    maps = [writable_file(one, "--map", MAP_FORMATS) for one in options.map]
    if maps and isinstance(options.tilt, str):
        raise InputError(f"--map: --tilt {options.tilt} depends on the torque. Give the tilt in um, or delete --map.")
    if options.tilt == "machine" and options.torque is not None:
        raise InputError(
            "--tilt machine takes the torque of the loaded machine. Delete --torque, or give the tilt in um."
        )
    loaded, work = scene_and_work(options)
    pairs = build_pairs(loaded, work)
    if options.tilt == "machine":
        cases = list(zip(pairs, machine_states(loaded, work), strict=True))
    else:
        cases = [(pair, state) for pair in pairs for state in _states(pair, options)]
    curves = gear_curves(*zip(*cases, strict=True))
    rows = gear_rows(pairs, curves)
    errors = [] if picture is None else [transmission_errors(pair, state) for pair, state in cases]
    orders = [row for error in errors for row in error.rows()]
    if target is not None:
        write_curves(curves, target)
    if picture is not None:
        save_figure(transmission_error_figure(loaded.scene.title, errors), picture, dpi=115)
    roots, written = _write_maps(loaded, pairs, options, maps, work) if maps else ([], [])
    if options.json:
        found = {"pairs": rows, "orders": orders, "root_stress": roots, "notes": _notes(cases)}
        yield json_text(found | {"curves": target, "plot": picture, "maps": written})
        return
    title = (
        "Drive flanks without deviations, along the transverse line of action, with the compliance of the gear bodies"
    )
    yield grid(title, rows).to_text()
    if orders:
        yield grid("Transmission error of the healthy pair, amplitudes of its orders", orders).to_text()
    if roots:
        yield grid("Largest root stress of the healthy pair, von Mises", roots).to_text()
    yield from _notes(cases)
    yield from (str(path) for path in (target, picture, *written) if path is not None)


def _states(found: PairLaws, options: argparse.Namespace) -> list[MeshState]:
    """The pair at its torques, or at the force of the scene."""
    from pipelines.io.errors import InputError
    from pipelines.machine.checks.strength import LARGEST_GIVE, refuse_overload
    from pipelines.runs.gear_curves import MeshState

    most = 1e6 * LARGEST_GIVE * found.pair.pinion.normal_module
    if options.tilt != "balanced" and abs(options.tilt) > most:
        raise InputError(
            f"--tilt {options.tilt:g} um: is more than {LARGEST_GIVE:g} modules of stage {found.stage} ({most:g} um), "
            f"where linear elasticity does not hold. Set -{most:g} to {most:g} um."
        )
    tilt = None if options.tilt == "balanced" else found.sense * options.tilt * 1e-6 / found.pair.face_width
    radius = found.pair.pinion.base_radius
    for torque in options.torque or ():
        refuse_overload(found.stage, found.pair, torque)
    forces = [found.force] if options.torque is None else [torque / radius for torque in options.torque]
    return [MeshState(force=force, tilt=tilt) for force in forces]


def _write_maps(
    loaded: LoadedScene, pairs: Sequence[PairLaws], options: argparse.Namespace, files: Sequence[Path], work: Work
) -> tuple[list[dict[str, Any]], list[Path]]:
    """Write the files of --map; with several stages each file name ends in the number of its stage.

    Returns
    -------
    rows with the largest root stresses for each stage, state and torque; the files
    """
    from pipelines.engine.step import Graph
    from pipelines.runs.gear_curves import MeshState, tilt_words
    from pipelines.runs.load_map import TORQUE_SHARES, load_map, root_rows, write_load_map
    from pipelines.runs.root_stress import root_step
    from pipelines.runs.single_results import scene_graph

    machine = scene_graph(loaded)[1]
    steps = [root_step(machine, pair.stage) for pair in pairs]
    outcome = work.build(Graph(steps), [step.name for step in steps])
    rows: list[dict[str, Any]] = []
    written: list[Path] = []
    for found, step in zip(pairs, steps, strict=True):
        laws = {"unmodified": found.unmodified} | ({"modified": found.healthy} if found.modified else {})
        given = found.force * found.pair.pinion.base_radius
        torques = options.torque or [share * given for share in TORQUE_SHARES]
        tilt = found.sense * options.tilt * 1e-6 / found.pair.face_width
        made = load_map(found.pair, laws, torques, outcome.value(step.name), sense=found.sense, tilt=tilt)
        rows += root_rows(found.stage, made, torques)
        words = tilt_words(found, MeshState(force=found.force, tilt=tilt))
        title = f"{loaded.scene.title}: stage {found.stage}, model {found.drive.model}, {words}"
        for file in files:
            named = file.with_stem(f"{file.stem}_{found.stage}") if len(pairs) > 1 else file
            written.append(write_load_map(title, made, named))
    return rows, written


def _notes(cases: Sequence[tuple[PairLaws, MeshState]]) -> list[str]:
    """What the table was made with, and how the columns are meant."""
    from pipelines.runs.gear_curves import tilt_words

    lines = []
    for stage in dict.fromkeys(pair.stage for pair, _ in cases):
        own = [(pair, state) for pair, state in cases if pair.stage == stage]
        pair, gears = own[0][0], own[0][0].pair
        lines.append(
            f"stage {stage}: model {pair.drive.model}, contact ratio {gears.transverse_contact_ratio:.4g}, "
            f"overlap ratio {gears.overlap_ratio:.4g}, bores {2000 * gears.pinion.bore_radius:g}/"
            f"{2000 * gears.wheel.bore_radius:g} mm, {tilt_words(*own[0])}"
        )
    lines.append(
        "Range of the values: from the first to the last contact of one tooth pair; if a tooth is damaged, of the pair "
        "with this tooth. secant, tangent, TE: means. secant: load over deflection since first touch; a relief lowers "
        "it. tangent: stiffness for small vibrations about the load. least: smallest secant stiffness. at: its "
        "position, in mesh cycles from the pitch point. TE p-p: peak-to-peak. share: largest load share. pressure: "
        "largest Hertz pressure on the active flanks of this pair and its neighbours."
    )
    return lines
