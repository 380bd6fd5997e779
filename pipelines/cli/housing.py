"""`gearcase housing`: the solids and bores of a housing file, the bearing seats, and the block for a scene."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.cli.command_line import argument
from pipelines.io.argument_types import count, path, positive

if TYPE_CHECKING:
    from fem.casing.recognition.housing_contents import GeometryContents
    from fem.casing.recognition.shaft_fit import ShaftFit


_LENGTHS = ("m", "cm", "mm", "um", "inch")
_SYSTEMS = ("kg-m-s", "t-mm-s", "kg-mm-ms", "kg-mm-s", "lbf-in-s")
ARGUMENTS = (
    argument(
        "file",
        metavar="FILE",
        type=path,
        help="CAD file (STEP, BREP, IGES, STL), mesh, or matrices (.op4 .pch .mtx .sti .npz .h5)",
    ),
    argument(
        "--scene",
        metavar="SCENE",
        type=path,
        help="choose the bores for the bearings of this scene, and write the table [casing.housing] for it",
    ),
    argument(
        "--unit",
        metavar="UNIT",
        choices=(*_LENGTHS, *_SYSTEMS),
        help=f"unit of FILE. CAD file or mesh: {', '.join(_LENGTHS)} (default: the unit that the file declares, else "
        f"mm). Matrices: units of mass, length and time, as {', '.join(_SYSTEMS)} (default {_SYSTEMS[0]}); lbf-in-s "
        "has the unit of force instead of mass",
    ),
    argument(
        "--solids",
        metavar="N",
        type=count,
        nargs="+",
        default=[],
        help="numbers of the solids whose bores may be chosen (default: all)",
    ),
    argument("--out", metavar="FOLDER", type=path, help="result folder (default: ./<file>-housing)"),
)
_MATRICES = (
    argument("--mass", metavar="FILE", type=path, help="mass matrix, if FILE holds the stiffness matrix only"),
    argument(
        "--nodes",
        metavar="FILE",
        type=path,
        help="file with the node coordinates: rows of number, x, y, z; GRID cards of Nastran; *NODE of Abaqus",
    ),
    argument(
        "--equations",
        metavar="FILE",
        type=path,
        help="file with the order of the equations: rows of node and axis (1 to 6; 0: modal); .mapping of Ansys; EXTRN "
        "cards of Nastran",
    ),
    argument(
        "--keep",
        metavar="NODE",
        type=count,
        nargs="+",
        default=[],
        help="reduce the matrices to these nodes, and write the reduced matrices",
    ),
    argument("--hold", metavar="NODE", type=count, nargs="+", default=[], help="nodes that are fixed to the ground"),
    argument(
        "--band",
        metavar="HZ",
        type=positive,
        default=2000.0,
        help="upper frequency of the reduced matrices, Hz (default 2000)",
    ),
)
GROUPS = {"matrices of another program": _MATRICES}


def main(options: argparse.Namespace) -> Iterator[str]:
    """Read a housing from a CAD file, a mesh, or stiffness and mass matrices. Print its solids and bores, or a check of
    the matrices. Write a picture and an HTML page of the solids and bores. With --scene, choose the bores that hold
    the bearings (bearing seats), and write them to housing.toml. Takes seconds.

    Example
    -------
    gearcase housing rig-housing.step --scene rig-healthy
    ...
    bore  solid  diameter mm  length mm         middle mm     axis  arc deg
    ----  -----  -----------  ---------  ----------------  -------  -------
       1      1      95.0000     30.000  315.686, -135, 0  0, 1, 0      360
    ...
    rig-housing-housing/housing.toml
    ...
    """
    from fem.casing.imported.matrix_files import SUFFIXES
    from pipelines.io.errors import InputError
    from pipelines.scene.shipped_files import find_file

    path = find_file(options.file)
    matrices = path.suffix.lower() in SUFFIXES
    if options.unit not in (None, *(units := _SYSTEMS if matrices else _LENGTHS)):
        kind = "matrices have units of mass, length and time" if matrices else "a CAD file or mesh has a unit of length"
        raise InputError(f"--unit {options.unit}: {kind}. Give one of {', '.join(units)}.")
    return (_matrices if matrices else _geometry)(path, options)


def _geometry(path: Path, options: argparse.Namespace) -> Iterator[str]:
    from pipelines.io.user_files import writable_folder, write_whole
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.studies.housings.bore_picture import housing_picture
    from pipelines.studies.housings.file_listing import fitted, listing
    from pipelines.studies.housings.housing_page import housing_page

    folder = writable_folder(options.out or f"{path.stem}-housing")
    contents, fit, block, words = _contents_of(path, options)
    text = "\n".join([*listing(contents), *words, *([fitted(fit)] if fit is not None else [])])
    yield text
    seats = {} if fit is None else {seat.bore.number: seat.bearing for seat in fit.seats}
    folder.mkdir(parents=True, exist_ok=True)
    picture, page = folder / f"{path.stem}.png", folder / f"{path.stem}.html"
    save_figure(housing_picture(contents, seats), picture, dpi=110)
    write_whole(page, housing_page(contents, seats, f"{text}\n\n{block}"))
    if block:
        write_whole(folder / "housing.toml", block)
        yield f"\n{block}\n{folder / 'housing.toml'}"
    yield f"{picture}\n{page}"


def _matrices(path: Path, options: argparse.Namespace) -> Iterator[str]:
    """Print the checks of stiffness and mass matrices; if points are to be kept, write the reduced body to a file."""
    from fem.casing.imported.matrix_checks import check_matrices
    from fem.casing.imported.matrix_files import MatrixFiles, read_body
    from pipelines.io.errors import SceneWarning
    from pipelines.io.user_files import writable_folder

    body = read_body(
        MatrixFiles(
            stiffness=str(path),
            mass=options.mass,
            nodes=options.nodes,
            equations=options.equations,
            system=options.unit or _SYSTEMS[0],
        )
    )
    for words in body.notes:
        warnings.warn(words, SceneWarning, stacklevel=1)
    yield check_matrices(body).report()
    from pipelines.studies.housings.imported_reduction import held_text, reduced_text, write_reduced

    if options.hold:
        yield held_text(body, options.hold)
    if not options.keep:
        return
    folder = writable_folder(options.out or f"{path.stem}-housing")
    target = folder / f"{path.stem}-reduced.h5"
    reduced = write_reduced(body, options.keep, options.hold, options.band, target)
    yield f"{reduced_text(body, reduced, options.band)}\n{target}"


def _contents_of(path: Path, options: argparse.Namespace) -> tuple[GeometryContents, ShaftFit | None, str, list[str]]:
    """Contents of the file (of the chosen solids), fit of the shafts of the scene, block, and remarks."""
    from fem.casing.recognition.read_geometry import geometry_contents
    from pipelines.io.errors import InputError

    contents = geometry_contents(path, options.unit)
    if options.solids:
        known = {solid.number for solid in contents.solids}
        if unknown := set(options.solids) - known:
            raise InputError(
                f"--solids {min(unknown)}: the file has no solid of this number. The highest is {len(known)}."
            )
    if options.scene is None:
        return (
            contents,
            None,
            "",
            ["To propose bearing seats and write the block [casing.housing], add --scene SCENE"],
        )
    from pipelines.scene.load_scene import load_scene
    from pipelines.studies.housings.housing_block import housing_block
    from pipelines.studies.housings.seats import fitting_units, shaft_places

    loaded = load_scene(options.scene)
    shafts = shaft_places(loaded.scene, loaded.source.shown)
    held = replace(contents, bores=tuple(b for b in contents.bores if b.solid in options.solids or not options.solids))
    fits = fitting_units(held, shafts)
    if not fits:
        return contents, None, "", [no_fit(held, shafts)]
    words = [f"units of length in which bores match the shafts of the scene: {', '.join(fits)}"]
    if contents.unit not in fits:
        best = next(iter(fits))
        if contents.declared:
            words.append(f"the file declares {contents.declared}; but its bores match in {best}; export it in {best}")
            return contents, None, "", words
        contents = geometry_contents(path, best)
    fit = fits[contents.unit]
    return contents, fit, housing_block(contents, path.name, path.suffix.lower(), fit, loaded.scene), words


def no_fit(contents: GeometryContents, shafts: tuple) -> str:
    """Message why no seats are proposed, with the centre distances of the scene."""
    import numpy as np

    centres = [1000 * float(np.hypot(b.x - a.x, b.z - a.z)) for a, b in zip(shafts, shafts[1:], strict=False)]
    distances = ", ".join(f"{one:.4g}" for one in centres) or "none"
    return (
        f"no bores match the shafts of the scene (centre distances {distances} mm; diameters above that of the shaft, "
        f"{1000 * min(s.diameter for s in shafts):.4g} mm). Correct gears or shafts of the scene, or set --unit"
    )
