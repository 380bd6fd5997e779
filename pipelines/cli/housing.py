"""`gearcase housing`: what a file of a housing holds, which bores are seats of shafts, and the block for a scene."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fem.casing.recognition.contents import Contents
    from fem.casing.recognition.shaft_fit import ShaftFit


def main(options: argparse.Namespace) -> int:
    """Print the listing, the seats and the block; write the picture, the page and the block."""
    from fem.casing.imported.files import SUFFIXES
    from pipelines.scene.shipped_files import find_file

    path = find_file(options.file)
    if path.suffix.lower() in SUFFIXES:
        return _matrices(path, options)
    return _geometry(path, options)


def _geometry(path: Path, options: argparse.Namespace) -> int:
    from pipelines.io.user_files import writable_folder, write_whole
    from pipelines.report.figures.film import save_figure
    from pipelines.studies.housings.listing import fitted, listing
    from pipelines.studies.housings.page import housing_page
    from pipelines.studies.housings.picture import housing_picture

    folder = writable_folder(options.out or f"{path.stem}-housing")
    contents, fit, block, words = _surveyed(path, options)
    text = "\n".join([*listing(contents), *words, *([fitted(fit)] if fit is not None else [])])
    sys.stdout.write(f"{text}\n")
    seats = {} if fit is None else {seat.bore.number: seat.bearing for seat in fit.seats}
    folder.mkdir(parents=True, exist_ok=True)
    picture, page = folder / f"{path.stem}.png", folder / f"{path.stem}.html"
    save_figure(housing_picture(contents, seats), picture, dpi=110)
    write_whole(page, housing_page(contents, seats, f"{text}\n\n{block}"))
    if block:
        write_whole(folder / "housing.toml", block)
        sys.stdout.write(f"\n{block}\n{folder / 'housing.toml'}\n")
    sys.stdout.write(f"{picture}\n{page}\n")
    return 0


def _matrices(path: Path, options: argparse.Namespace) -> int:
    """The check-up of matrices; with points, the reduced body in a file."""
    from fem.casing.imported.checks import check_foreign
    from fem.casing.imported.files import MatrixFiles, read_body
    from pipelines.io.user_files import writable_folder

    body = read_body(
        MatrixFiles(
            stiffness=str(path),
            mass=options.mass,
            nodes=options.nodes,
            equations=options.equations,
            system=options.units,
        )
    )
    check = check_foreign(body)
    sys.stdout.write(f"{check.report()}\n")
    from pipelines.studies.housings.reduced_matrices import held_text, reduced_text, write_reduced

    if options.hold:
        sys.stdout.write(f"{held_text(body, options.hold)}\n")
    if not options.keep:
        return 0
    folder = writable_folder(options.out or f"{path.stem}-housing")
    target = folder / f"{path.stem}-reduced.h5"
    reduced = write_reduced(body, options.keep, options.hold, options.band, target)
    sys.stdout.write(f"{reduced_text(body, reduced, options.band)}\n{target}\n")
    return 0


def _surveyed(path: Path, options: argparse.Namespace) -> tuple[Contents, ShaftFit | None, str, list[str]]:
    """What the file holds (of the solids asked), where the scene's shafts fit, the block, and remarks."""
    from fem.casing.recognition.read import survey
    from pipelines.io.errors import InputError

    contents = survey(path, options.unit)
    if options.solids:
        known = {solid.number for solid in contents.solids}
        if unknown := set(options.solids) - known:
            raise InputError(
                f"--solids {min(unknown)}: the file has {len(known)} solids. Give numbers from 1 to {len(known)}."
            )
    if options.scene is None:
        return (
            contents,
            None,
            "",
            ["To propose bearing seats and write the block [casing.housing], add --scene SCENE"],
        )
    from pipelines.scene.file import load_scene
    from pipelines.studies.housings.block import housing_block
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
        contents = survey(path, best)
    fit = fits[contents.unit]
    return contents, fit, housing_block(contents, path.name, path.suffix.lower(), fit, loaded.scene), words


def no_fit(contents: Contents, shafts: tuple) -> str:
    """Why no seats are proposed: the centre distances of the scene, and the nearest ones of the bores."""
    import numpy as np

    wanted = [1000 * float(np.hypot(b.x - a.x, b.z - a.z)) for a, b in zip(shafts, shafts[1:], strict=False)]
    distances = ", ".join(f"{one:.4g}" for one in wanted) or "none"
    return (
        f"no bores match the shafts of the scene (centre distances {distances} mm; diameters above that of the shaft, "
        f"{1000 * min(s.diameter for s in shafts):.4g} mm). Correct gears or shafts of the scene, or set --unit"
    )
