"""`gearcase new`: a commented scene file to change."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Write the file and say what to do next; of a gear unit in REXS also what it does not take as it is."""
    from pipelines.rexs.files import is_rexs

    return _from_rexs(options) if is_rexs(options.source) else _from_scene(options)


def _from_scene(options: argparse.Namespace) -> int:
    from pipelines.scene.new import new_scene

    path = new_scene(options.file, options.source)
    sys.stdout.write(f"{path} written from {options.source}. Change it, then: gearcase check {path}\n")
    return 0


def _from_rexs(options: argparse.Namespace) -> int:
    from pipelines.rexs.new import new_scene_from_rexs

    made = new_scene_from_rexs(options.file, options.source)
    sys.stdout.write("".join(f"{note}\n" for note in made.notes))
    sys.stdout.write("".join(f"still to be set: {path}: {words}\n" for path, words in made.missing.items()))
    step = "Set the missing keys" if made.missing else "Check what was assumed, set a housing"
    sys.stdout.write(f"{made.path} written from {options.source}. {step}, then: gearcase check {made.path}\n")
    return 0
