"""Pages of the site that are made from the code: every public name of Python, every command, every file."""

import importlib
import inspect
import re
from pathlib import Path

from benchmarks.modules import tables

GROUPS = (  # of the public names
    ("Scenes", ("Scene", "check", "Checked")),
    ("Gears, casing and natural frequencies", ("laws", "PairLaws", "casing", "Casing", "modes", "LinearModes")),
    ("Matrices of another program", ("reduce", "Point", "ReducedMatrices")),
    ("Simulation and finished runs", ("simulate", "run", "open_run", "spectrum", "StepProgress")),
    ("Diagnosis", ("diagnose", "Diagnosis", "error_bars", "LineBars")),
    ("Recordings", ("open_recording", "judge", "Verdict", "compare", "features")),
    ("Data sets", ("campaign", "Finished", "open_dataset", "pieces")),
    ("Design of flanks, scatter between machines", ("design", "DesignStudy", "spread", "FeatureSpread")),
    ("Accuracy", ("converge", "RefinementStudy", "tradeoff", "Tradeoff")),
    ("Errors", ("InputError", "SceneError", "WorkError")),
)
HEAD = "<!-- made by reference_pages.py -->\n\n"


def write(folder: Path) -> None:
    """Write the pages of the reference; what has not changed is left alone, so that it is not built again."""
    for name, text in {**python_pages(), **command_pages(), "modules.md": f"{HEAD}# Modules\n\n{tables()}\n"}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def python_pages() -> dict[str, str]:
    """A page per name of the public door, and their list."""
    import gearcase

    pages = {}
    for name in gearcase.__all__:
        found = getattr(gearcase, name)
        kind = "autofunction" if not isinstance(found, type) else "autoclass"
        if isinstance(found, type) and issubclass(found, Exception):
            kind = "autoexception"
        options = "\n:members:" if kind == "autoclass" else ""
        directive = f"```{{eval-rst}}\n.. {kind}:: gearcase.{name}{options.replace(chr(10), chr(10) + '   ')}\n```\n"
        pages[f"python/{name}.md"] = f"{HEAD}# {name}\n\n{directive}"
    assert {name for _, names in GROUPS for name in names} == set(gearcase.__all__)
    tables = [
        f"\n## {title}\n\n| name | description |\n| --- | --- |\n"
        + "".join(f"| [{name}]({name}.md) | {_first_sentence(getattr(gearcase, name))} |\n" for name in names)
        for title, names in GROUPS
    ]
    names = [name for _, names in GROUPS for name in names]
    pages["python/index.md"] = listing("Python, name by name", names, "".join(tables))
    return pages


def _first_sentence(found: object) -> str:
    """How a docstring begins, in one line of a table."""
    paragraph = inspect.getdoc(found).partition("\n\n")[0].replace("\n", " ").replace("|", "\\|").replace("<", "\\<")
    return re.split(r"(?<=[\w)`]\.)\s", paragraph)[0]


def command_pages() -> dict[str, str]:
    """A page per command: its help, and that of its actions."""
    from pipelines.cli.command_line import COMMANDS, help_and_example, parser

    top = parser()
    below = _actions(top)
    pages = {}
    for name, words in COMMANDS.items():
        example = help_and_example(importlib.import_module(f"pipelines.cli.{name}"))[1].partition("\n")[0]
        helps = [_help(below[name]), *map(_help, _actions(below[name]).values())]
        blocks = "\n".join(f"```text\n{text.rstrip()}\n```\n" for text in helps)
        pages[f"commands/{name}.md"] = (
            f"{HEAD}# gearcase {name}\n\n{words[0].upper()}{words[1:]}.\n\n```sh\n{example}\n```\n\n{blocks}"
        )
    rows = "\n".join(f"| [{name}]({name}.md) | {words} |" for name, words in COMMANDS.items())
    table = f"\n| command | does |\n| --- | --- |\n{rows}\n"
    pages["commands/index.md"] = listing("Commands", list(COMMANDS), table)
    return pages


def listing(title: str, names: list[str], text: str) -> str:
    """A page whose tables lead to others."""
    return f"{HEAD}# {title}\n{text}\n```{{toctree}}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"


def _actions(parser):
    """Parsers below a parser by name."""
    groups = [action.choices for action in parser._actions if hasattr(action, "add_parser")]
    return groups[0] if groups else {}


def _help(parser) -> str:
    """Help at a width that a page shows."""
    return parser.format_help()
