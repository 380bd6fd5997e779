"""The command line of `gearcase`: its commands, their arguments and their help.

Only the standard library is imported, so that help appears at once.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterable
from typing import NoReturn

from pipelines.cli.command_help import HELP, example_text
from pipelines.cli.dataset_arguments import dataset_arguments
from pipelines.cli.finished_arguments import (
    compare_arguments,
    diagnose_arguments,
    export_arguments,
    json_argument,
    orders_arguments,
    quiet_argument,
    runs_arguments,
)
from pipelines.cli.gear_arguments import gears_arguments, inspect_arguments
from pipelines.cli.housing_arguments import casing_arguments, housing_arguments
from pipelines.cli.study_arguments import (
    converge_arguments,
    detect_arguments,
    scene_arguments,
    starts_arguments,
    tradeoff_arguments,
    verify_arguments,
    work_arguments,
)
from pipelines.io.argument_types import count, days, number, path, positive

PROLOGUE = """\
Simulate the vibration of a gearbox, healthy and damaged, from its geometry to the signals of its sensors.
Finite elements give the stiffness of gears and casing. A multibody model gives the motion and the signals. The
diagnosis compares the signals with those of the same gearbox without the fault, the healthy control.

A SCENE describes the machine. Give the name of a shipped scene (minimal, bench, reducer, rig-missing-tooth, ...), or
the path of your own file, which ends in .toml.
A RUN is a finished simulation. Give its result folder, the name of its scene for the newest result under ./runs, or
the number that `gearcase runs` prints.
"""
EPILOGUE = """\
first steps:
  gearcase run minimal                        simulate the smallest scene; print the path of the report
  gearcase new my.toml --from bench           write a commented scene to change
  gearcase check my.toml                      check it; print ratios, frequencies, forces
  gearcase run my.toml                        write signals, diagnosis and report under ./runs/my

Help for one command: gearcase COMMAND --help
"""


SHELLS = ("bash", "zsh", "tcsh")  # that can be completed


class Parser(argparse.ArgumentParser):
    """Prints what is wrong with an argument, escaped and cut to a bounded length."""

    def error(self, message: str) -> NoReturn:
        """Usage and the message on standard error; exit code 2."""
        from pipelines.io.shown import shown

        head, tail = message[:_MESSAGE_END], message[_MESSAGE_END:]
        if len(tail) > _MESSAGE_END:
            tail = f"...{tail[-_MESSAGE_END:]}"
        self.print_usage(sys.stderr)
        help_of = f"{self.prog} COMMAND" if self.prog == "gearcase" else self.prog
        hint = f"{_nearest(message, self._option_string_actions)}Help: {help_of} --help"
        self.exit(2, f"{self.prog}: error: {shown(head)}{shown(tail)}".rstrip(".") + f". {hint}\n")


def command_parser(top: argparse.ArgumentParser, command: str | None) -> argparse.ArgumentParser:
    """The parser of a command, or the given one without a command."""
    choices = (action.choices for action in top._actions if isinstance(action, argparse._SubParsersAction))
    return top if command is None else next(choices)[command]


def _nearest(message: str, options: Iterable[str]) -> str:
    """What was probably meant by a word that is not among the choices or options, as a sentence, or ""."""
    from pipelines.io.shown import nearest_name

    choice = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
    option = re.search(r"unrecognized arguments: (--[\w-]+)", message)
    name = ""
    if choice is not None:
        name = nearest_name(choice[1], re.findall(r"[\w-]+", choice[2]))
    elif option is not None:
        name = nearest_name(option[1], [one for one in options if one.startswith("--")])
    return f"Did you mean {name}? " if name else ""


_MESSAGE_END = 180  # characters at the front and at the end of a message on arguments: choices stand at its end


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Keeps the line breaks of examples; a little wider than the default."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=30, width=110)


def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    top = Parser(prog="gearcase", description=PROLOGUE, epilog=EPILOGUE, formatter_class=Formatter, allow_abbrev=False)
    top.add_argument("--version", action="store_true", help="print the version and exit")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for name, words, example, arguments in COMMANDS:
        sub = commands.add_parser(
            name,
            help=words,
            description=HELP[name].text,
            epilog=example_text(example, HELP[name]),
            formatter_class=Formatter,
            allow_abbrev=False,
        )
        arguments(sub)
        sub.add_argument(
            "-v", "--verbose", action="store_true", help="log each step, and print the traceback of an error"
        )
    return top


def _check(sub: argparse.ArgumentParser) -> None:
    scene_arguments(sub)
    json_argument(sub)


def _out(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--out", metavar="FOLDER", type=path, help="result folder (default: ./runs/<scene>/<timestamp>)")


def _new(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("file", metavar="FILE", type=path, help="scene file to write, ending in .toml; it must not exist")
    sub.add_argument(
        "--from",
        metavar="SOURCE",
        type=path,
        dest="source",
        default="bench",
        help="scene to copy, or gear unit in REXS: .rexs, .rexsj or .rexsz (default: bench)",
    )


def _run(sub: argparse.ArgumentParser) -> None:
    work_arguments(sub)
    _out(sub)
    sub.add_argument(
        "--no-control",
        action="store_true",
        help="do not simulate the healthy control; there is no diagnosis without it",
    )
    sub.add_argument(
        "--one-load",
        action="store_true",
        help="do not simulate a hanging load again with the equivalent constant torque",
    )
    sub.add_argument(
        "--seeds",
        metavar="N",
        type=count,
        default=0,
        help="simulate also with the seeds 1 to N of the gear deviations, and with gears without deviations (default: "
        "only the seed of the scene)",
    )
    sub.add_argument(
        "--baseline",
        metavar="N",
        type=count,
        default=0,
        help="simulate also N healthy machines with other gear deviations, and compare the machine with them; p-values "
        "need 5 or more (default 0)",
    )


def _modes(sub: argparse.ArgumentParser) -> None:
    work_arguments(sub)
    sub.add_argument("--up-to", metavar="HZ", type=positive, default=10e3, help="highest frequency, Hz (default 10000)")
    sub.add_argument(
        "--cycle",
        metavar="C",
        type=number,
        help="position of stage 1 in its mesh cycle, 0 to 1 (default: that at the start of the simulation)",
    )
    sub.add_argument(
        "--speed",
        type=number,
        default=0.0,
        metavar="RPM",
        help="motor speed for losses and gyroscopic moments, rpm (default 0)",
    )
    json_argument(sub)


def _simulate(sub: argparse.ArgumentParser) -> None:
    work_arguments(sub)
    _out(sub)


def _cache(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "action",
        choices=("info", "verify", "clear"),
        nargs="?",
        default="info",
        help="info: sizes by kind of step; verify: check and remove damaged entries; clear: remove (default info)",
    )
    sub.add_argument(
        "--older-than",
        metavar="DAYS",
        type=days,
        default=0.0,
        help="with clear: remove only entries that were not used for this number of days (default 0: all)",
    )


def _schema(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--out", metavar="FILE", type=path, help="file to write (default: print the schema)")


def _completion(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("shell", metavar="SHELL", choices=SHELLS, help=f"shell: {', '.join(SHELLS)}")
    sub.set_defaults(whole_parser=parser)  # what is completed


def _campaign(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("plan", metavar="PLAN", type=path, help="plan of the campaign, a file that ends in .toml")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="folder of the data set (default: ./campaigns/<plan>)")
    sub.add_argument(
        "--dry-run", action="store_true", help="print number of runs, time and disk space, and simulate nothing"
    )
    sub.add_argument(
        "--processes", type=count, metavar="N", help="scenes simulated at the same time (default: number of cores)"
    )
    where = sub.add_mutually_exclusive_group()
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="address of a running Dask scheduler, or its scheduler file"
    )
    where.add_argument("--cluster", action="store_true", help="start a local Dask scheduler with a dashboard")
    sub.add_argument("--retry-failed", action="store_true", help="simulate failed runs again")
    quiet_argument(sub)


COMMANDS = (  # in the order a user needs them: name, of the module too; one line; example; arguments
    ("new", "write a commented scene file to change", "gearcase new my.toml --from bench", _new),
    (
        "check",
        "check a scene file; print its ratios, frequencies, forces and cost",
        "gearcase check rig-missing-tooth",
        _check,
    ),
    ("run", "simulate, compare with a healthy control, diagnose and report", "gearcase run bench", _run),
    ("simulate", "simulate the machine and write its signals only", "gearcase simulate minimal", _simulate),
    (
        "runs",
        "list finished runs; open, compare or remove them",
        "gearcase runs clean --keep 1",
        runs_arguments,
    ),
    (
        "diagnose",
        "find the damaged component in a recording or a finished run",
        "gearcase diagnose bench",
        diagnose_arguments,
    ),
    (
        "compare",
        "compare features and spectra of recordings",
        "gearcase compare bench@0.5:0.9 bench@0.9:1.3",
        compare_arguments,
    ),
    ("orders", "analyse a run-up by orders of a shaft", "gearcase orders reducer", orders_arguments),
    (
        "export",
        "write the signals of a run as CSV, MATLAB or UFF file",
        "gearcase export minimal --to mat",
        export_arguments,
    ),
    (
        "gears",
        "compute mesh stiffness, transmission error and load sharing of each pair",
        "gearcase gears pair --torque 50 100 --plot te.png",
        gears_arguments,
    ),
    (
        "inspect",
        "write pictures of gears in mesh and of the casing",
        "gearcase inspect minimal --position 0",
        inspect_arguments,
    ),
    (
        "housing",
        "read a housing file and propose its bearing seats",
        "gearcase housing rig-housing.step --scene rig-healthy",
        housing_arguments,
    ),
    (
        "casing",
        "mesh and reduce the casing: natural frequencies, responses, matrices",
        "gearcase casing minimal",
        casing_arguments,
    ),
    ("modes", "print the natural frequencies of the whole machine", "gearcase modes minimal", _modes),
    (
        "converge",
        "refine one setting and estimate the discretisation error",
        "gearcase converge minimal --over step",
        converge_arguments,
    ),
    (
        "tradeoff",
        "measure time and accuracy of every model and setting",
        "gearcase tradeoff minimal --error 2%",
        tradeoff_arguments,
    ),
    (
        "starts",
        "repeat a simulation from other initial states; print mean and spread",
        "gearcase starts minimal --starts 8",
        starts_arguments,
    ),
    (
        "detect",
        "estimate the probability of detection over damage size and noise",
        "gearcase detect bench --over faults.1.depth_mm=0.5:3:0.5 --dry-run",
        detect_arguments,
    ),
    (
        "campaign",
        "simulate the scenes of a plan as a labelled data set",
        "gearcase campaign plan.toml --dry-run",
        _campaign,
    ),
    (
        "dataset",
        "summarise, check or export a data set; compute its features",
        "gearcase dataset info campaigns/plan",
        dataset_arguments,
    ),
    (
        "verify",
        "check the claims of a published study against simulations",
        "gearcase verify rig --out claims",
        verify_arguments,
    ),
    (
        "explain",
        "print which steps a run would compute or reuse, and why",
        "gearcase explain bench",
        scene_arguments,
    ),
    ("schema", "print the JSON schema of scenes, for editors", "gearcase schema --out scene.schema.json", _schema),
    ("completion", "print the script that completes commands in a shell", "gearcase completion bash", _completion),
    ("cache", "show, verify or clear the cache of computed steps", "gearcase cache info", _cache),
)
