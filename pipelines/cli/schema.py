"""`gearcase schema`: the JSON schema of scene files, so that an editor completes and checks their keys."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import argument
from pipelines.io.argument_types import path

ARGUMENTS = (argument("--out", metavar="FILE", type=path, help="file to write (default: print the schema)"),)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Print the JSON schema of scene files, with which an editor completes and checks keys and values. Takes a
    second.

    Example
    -------
    gearcase schema --out scene.schema.json
    scene.schema.json
    """
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.io.user_files import writable_file, write_whole
    from pipelines.scene.schema import scene_schema

    text = json_text(scene_schema())
    if options.out is None:
        yield text
        return
    target = writable_file(options.out)
    try:
        write_whole(target, text)
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --out.") from error
    yield str(target)
