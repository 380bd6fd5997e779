"""The command line of `gearcase`: the list of its commands, their parser, and the arguments that several have.

A command is the module of its name with a table `ARGUMENTS` and a function `main`. The docstring of `main` is the text
of the help, and its section "Example" shows a command line with the main lines of what it prints (others as ``...``).
A command such as `runs` also has a table `ACTIONS`. A module is imported for its command alone, and imports nothing
heavy itself before it runs, so that help appears at once.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import re
import sys
import textwrap
from collections.abc import Container, Generator, Iterable
from types import ModuleType
from typing import TYPE_CHECKING, Any, NoReturn

from pipelines.io.argument_types import count, from_zero, path
from pipelines.scene.presets import PRESETS

if TYPE_CHECKING:
    from pipelines.engine.run_graph import Work
    from pipelines.scene.load_scene import LoadedScene

Printed = Generator[str, None, int | None]  # the lines that a command prints, and its exit code if it is not 0

COMMANDS = {  # in the order a user needs them: name, of the module too; one line
    "new": "write a commented scene file to change",
    "check": "check a scene file; print its ratios, frequencies, forces and cost",
    "run": "simulate, compare with a healthy control, diagnose and report",
    "simulate": "simulate the machine and write its signals only",
    "runs": "list, open, compare or clean up finished runs",
    "diagnose": "find the damaged component in a recording or a finished run",
    "features": "compute the features of recordings, runs or a data set",
    "compare": "compare features and spectra of recordings",
    "orders": "analyse a run-up by orders of a shaft",
    "export": "write the signals of a run as CSV, MATLAB or UFF file",
    "gears": "compute mesh stiffness, transmission error and load sharing of each pair",
    "design": "search for the best flank modifications of a pair",
    "inspect": "write pictures of gears in mesh and of the casing",
    "housing": "read a housing file and propose its bearing seats",
    "casing": "mesh and reduce the casing: natural frequencies, responses, matrices",
    "modes": "print the natural frequencies of the whole machine",
    "converge": "refine one setting and estimate the discretisation error",
    "tradeoff": "measure time and accuracy of every model and setting",
    "starts": "repeat a simulation from other initial states; print mean and spread",
    "detect": "estimate the probability of detection over damage size and noise",
    "spread": "estimate the scatter of features over a population, and its causes",
    "calibrate": "estimate keys of a scene from recordings of a healthy machine",
    "campaign": "simulate the scenes of a plan as a labelled data set",
    "dataset": "summarise, check or export a data set",
    "verify": "check the claims of a published study against simulations",
    "explain": "print which steps a run would compute or reuse, and why",
    "schema": "print the JSON schema of scenes, for editors",
    "completion": "print the script that completes commands in a shell",
    "cache": "print info on the cache of computed steps; verify or clear it",
}
RUN_HELP = "result folder, scene name (its newest result), or number that `gearcase runs` prints"
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

Argument = tuple[tuple[str, ...], dict[str, Any]]  # what `add_argument` of argparse takes


def argument(*names: str, **how: Any) -> Argument:
    """An argument of a command, see `argparse.ArgumentParser.add_argument`."""
    return names, how


QUIET = argument("-q", "--quiet", action="store_true", help="print results, warnings and errors only")
VERBOSE = argument(
    "-v",
    "--verbose",
    action="store_true",
    default=argparse.SUPPRESS,
    help="log each step, and print the traceback of an error",
)
JSON = argument("--json", action="store_true", help="print the results as JSON, for programs")
RUN = argument("run", metavar="RUN", type=path, help=RUN_HELP)
RUN_FOLDER = argument("--out", metavar="FOLDER", type=path, help="result folder (default: ./runs/<scene>/<timestamp>)")
MACHINE = argument(
    "--machine",
    metavar="FILE",
    type=path,
    help="machine of the recording: a file with teeth, speed and sensors, or a scene",
)
START = argument(
    "--start", type=from_zero, metavar="T", default=0.0, help="ignore the signals before this time, s (default 0)"
)
NOISE = argument(
    "--noise", metavar="RMS", type=from_zero, default=0.0, help="add white sensor noise, m/s2 rms (default 0)"
)
DRY_RUN = argument(
    "--dry-run", action="store_true", help="print number of runs, time and disk space, and simulate nothing"
)
SCENES_AT_ONCE = argument(
    "--processes", type=count, metavar="N", help="scenes simulated at the same time (default: number of cores)"
)
STEPS_AT_ONCE = argument(
    "--processes",
    type=count,
    metavar="N",
    help="number of parts of the computation (meshes, motions, pictures) that run at the same time (default 2)",
)
SCENE = (  # a scene, and what is changed in it
    argument("scene", metavar="SCENE", type=path, help="name of a shipped scene, or a path that ends in .toml"),
    argument(
        "--set",
        metavar="KEY=VALUE",
        dest="settings",
        action="append",
        default=[],
        help="change one value of the scene, as in --set stages.1.face_width_mm=32; "
        "items of a list are counted from 1; repeatable",
    ),
    argument(
        "--preset",
        choices=PRESETS,
        help="accuracy of meshes and time step, from coarse (draft) to fine (reference); --set overrides it (default: "
        "as in the scene)",
    ),
    QUIET,
)
WORK = (*SCENE, STEPS_AT_ONCE)  # a scene, and how its steps are built


def campaign_arguments(study: str) -> tuple[Argument, ...]:
    """Options of a study that simulates a campaign."""
    folder = f"result folder (default: ./campaigns/{study}-<scene>)"
    return argument("--out", metavar="FOLDER", type=path, help=folder), DRY_RUN, SCENES_AT_ONCE


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Keeps the line breaks of examples; a little wider than the default."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=30, width=110)
        self._action_max_length = 14  # of the longest command, which argparse indents further than it counts


class Parser(argparse.ArgumentParser):
    """Prints what is wrong with an argument, escaped and cut to a bounded length."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=Formatter, allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """Usage and the message on standard error; exit code 2."""
        from pipelines.io.shown_text import shown

        head, tail = message[:_MESSAGE_END], message[_MESSAGE_END:]
        if len(tail) > _MESSAGE_END:
            tail = f" ... {tail[-_MESSAGE_END:]}"
        self.print_usage(sys.stderr)
        if "arguments are required: ACTION" in message:
            names = next(a.choices for a in self._actions if isinstance(a, argparse._SubParsersAction))
            tail += f". Give one of {', '.join(names)}"
        help_of = f"{self.prog} COMMAND" if self.prog == "gearcase" else self.prog
        hint = f"{_nearest(message, self._option_string_actions)}Help: {help_of} --help"
        self.exit(2, f"{self.prog}: error: {shown(head)}{shown(tail)}".rstrip(".") + f". {hint}\n")


def command_parser(top: argparse.ArgumentParser, command: str | None) -> argparse.ArgumentParser:
    """The parser of a command, or the given one without a command."""
    choices = (action.choices for action in top._actions if isinstance(action, argparse._SubParsersAction))
    return top if command is None else next(choices)[command]


def _nearest(message: str, options: Iterable[str]) -> str:
    """What was probably meant by a word that is not among the choices or options, or which commands have the option."""
    from pipelines.io.shown_text import nearest_name

    choice = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
    option = re.search(r"unrecognized arguments: (--[\w-]+)", message)
    name = ""
    if choice is not None:
        name = nearest_name(choice[1], re.findall(r"[\w-]+", choice[2]))
    elif option is not None:  # compared without dashes, which all options have in common
        name = nearest_name(option[1][2:], [one[2:] for one in options if one.startswith("--")])
        name, every = f"--{name}" if name else "", parser()
        having = [one for one in COMMANDS if option[1] in command_parser(every, one)._option_string_actions]
        if having and not name:
            return f"{option[1]} is an option of {', '.join(having)}. "
    return f"Did you mean {name}? " if name else ""


_MESSAGE_END = 180  # characters at the front and at the end of a message on arguments: choices stand at its end


def parser(commands: Container[str] = tuple(COMMANDS)) -> Parser:
    """The command line, with the arguments of these commands: of no others is the module imported."""
    top = Parser(prog="gearcase", description=PROLOGUE, epilog=EPILOGUE)
    top.add_argument("--version", action="store_true", help="print the version and exit")
    top.set_defaults(verbose=False)
    below = top.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for name, words in COMMANDS.items():
        sub = below.add_parser(name, help=words)
        if name in commands:
            _complete(sub, importlib.import_module(f"pipelines.cli.{name}"))
    return top


def _complete(sub: argparse.ArgumentParser, module: ModuleType) -> None:
    """Give the parser of a command its arguments and actions, with their texts and examples."""
    _describe(sub, module.ARGUMENTS, *help_and_example(module))
    for title, arguments in getattr(module, "GROUPS", {}).items():
        group = sub.add_argument_group(title)
        for names, how in arguments:
            group.add_argument(*names, **how)
    if actions := getattr(module, "ACTIONS", None):
        default = getattr(module, "DEFAULT_ACTION", "")
        title = f"actions (default: {default})" if default else "actions"
        below = sub.add_subparsers(dest="action", metavar="ACTION", title=title, required=not default)
        for name, (words, *rest) in actions.items():
            _describe(below.add_parser(name, help=words), *rest)


def help_and_example(module: ModuleType) -> tuple[str, str]:
    """The text of the help of a command, and its example."""
    text, _, example = (inspect.getdoc(module.main) or "").partition("\n\nExample\n-------\n")
    return text, example


def _describe(sub: argparse.ArgumentParser, arguments: Iterable[Argument], text: str, example: str) -> None:
    """Add arguments, sentences above them, and below them a command line with the main lines that it prints."""
    for names, how in (*arguments, VERBOSE):
        sub.add_argument(*names, **how)
    sub.description, sub.epilog = text, "example:\n" + textwrap.indent(example, "  ")


def scene_and_work(options: argparse.Namespace) -> tuple[LoadedScene, Work]:
    """The scene that is requested with its changes, and how its steps are built."""
    from pipelines.scene.presets import load_requested

    return load_requested(options), work_of(options)


def work_of(options: argparse.Namespace) -> Work:
    """How steps are built."""
    from pipelines.engine.run_graph import Work

    return Work(processes=options.processes, quiet=options.quiet)


def announce(options: argparse.Namespace) -> None:
    """Name command and scene on standard error, before the imports, which take a while."""
    from pipelines.io.shown_text import shown

    if not options.quiet:
        sys.stderr.write(f"gearcase {options.command} {shown(str(options.scene))}\n")
