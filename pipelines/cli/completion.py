"""`gearcase completion`: the script that lets a shell complete commands, options and files."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Print the script for a shell.

    In bash: ``gearcase completion bash > ~/.local/share/bash-completion/completions/gearcase``; in zsh: into a file
    ``_gearcase`` of a folder of ``fpath``.
    """
    import shtab

    top = options.whole_parser()
    _complete_files(top, shtab.FILE)
    sys.stdout.write(shtab.complete(top, shell=options.shell) + "\n")
    return 0


def _complete_files(parser: argparse.ArgumentParser, files: object) -> None:
    """Say of every argument that names a file that it does, in all commands below."""
    from pipelines.io.argument_types import path

    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                _complete_files(below, files)
        elif action.type is path:
            setattr(action, "complete", files)  # noqa: B010 - an attribute of shtab's, not of argparse
