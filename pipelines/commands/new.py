"""`gearcase new`: a commented scene file to change."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Write the file and say what to do next."""
    from pipelines.scene.new import new_scene

    path = new_scene(options.file, options.source)
    sys.stdout.write(f"{path} written from {options.source}. Change it, then: gearcase check {path}\n")
    return 0
