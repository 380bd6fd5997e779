"""`gearcase completion`: the script by which a shell completes commands, options and file names."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import argument, parser

SHELLS = ("bash", "zsh", "tcsh")  # that shtab supports
ARGUMENTS = (argument("shell", metavar="SHELL", choices=SHELLS, help=f"shell: {', '.join(SHELLS)}"),)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Print the script by which a shell completes commands, options and file names. For bash, write it to
    ~/.local/share/bash-completion/completions/gearcase; for zsh, to a file _gearcase in a folder of `fpath`.

    Example
    -------
    gearcase completion bash
    ...
    _shtab_gearcase_runs_subparsers=(list open compare clean)
    ...
    """
    import shtab

    top = parser()
    _complete_files(top, shtab.FILE)
    yield shtab.complete(top, shell=options.shell) + "\n"


def _complete_files(parser: argparse.ArgumentParser, files: object) -> None:
    """Mark the arguments that are file names, in all commands below a parser, so that the shell completes them."""
    from pipelines.io.argument_types import path

    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                _complete_files(below, files)
        elif action.type is path:
            setattr(action, "complete", files)  # noqa: B010 - an attribute that shtab reads, not one of argparse
