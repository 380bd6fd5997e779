"""`gearcase new`: write a commented scene file as a start."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import argument
from pipelines.io.argument_types import path

ARGUMENTS = (
    argument("file", metavar="FILE", type=path, help="scene file to write, ending in .toml; it must not exist"),
    argument(
        "--from",
        metavar="SOURCE",
        type=path,
        dest="source",
        default="bench",
        help="scene to copy, or gear unit in REXS: .rexs, .rexsj or .rexsz (default: bench)",
    ),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Write a commented scene file as a start for your own. The source is a shipped scene, your own scene, or a gear
    unit in REXS. An existing file is never overwritten. Takes seconds.

    Example
    -------
    gearcase new my.toml --from bench
    my.toml written from bench. Change it, then: gearcase check my.toml
    """
    from pipelines.rexs.files import is_rexs

    step = "Change it"
    if is_rexs(options.source):
        from pipelines.rexs.rexs_scene import new_scene_from_rexs

        path, made = new_scene_from_rexs(options.file, options.source)
        yield from map(str, made.notes)
        yield from (f"still to be set: {key}: {words}" for key, words in made.missing.items())
        step = "Set the missing keys" if made.missing else "Check what was assumed, set a housing"
    else:
        from pipelines.scene.new import new_scene

        path = new_scene(options.file, options.source)
    yield f"{path} written from {options.source}. {step}, then: gearcase check {path}"
