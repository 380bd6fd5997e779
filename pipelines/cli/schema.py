"""`gearcase schema`: the JSON schema of scene files, so that an editor completes and checks their keys."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Print the schema, or write it to a file."""
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.io.user_files import writable_file, write_whole
    from pipelines.scene.schema import scene_schema

    text = json_text(scene_schema())
    if options.out is None:
        sys.stdout.write(text)
        return 0
    target = writable_file(options.out)
    try:
        write_whole(target, text)
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --out.") from error
    sys.stdout.write(f"{target}\n")
    return 0
