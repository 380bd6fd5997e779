"""The house: known rooms, imports that go down the list of rooms, no circle of files."""

import ast
from functools import cache
from graphlib import CycleError, TopologicalSorter

import pytest
import sources
from sources import module_name, nodes

ROOMS = (  # from the ground up: a room imports from itself and from what stands above it in this list
    "fem",
    "fem.storage",
    "fem.processes",
    "fem.numerics",
    "fem.elements",
    "fem.gears",
    "fem.contact",
    "fem.contact.evaluation",
    "fem.contact.wheels",
    "fem.contact.faults",
    "fem.contact.models",
    "fem.casing.geometry",
    "fem.casing.mesh",
    "fem.casing.enrichment",
    "fem.casing.recognition",
    "fem.casing.parts",
    "fem.casing.reduced",
    "fem.casing.uncertainty",
    "fem.casing.imported",
    "fem.casing.models",
    "mbd.elements",
    "mbd.parts",
    "mbd.forces",
    "mbd.excitations",
    "mbd.system",
    "mbd.integrators",
    "mbd.output",
    "pipelines.io",
    "pipelines.scene.tables",
    "pipelines.scene",
    "pipelines.engine",
    "pipelines.signals",
    "pipelines.signals.orders",
    "pipelines.signals.features",
    "pipelines.machine",
    "pipelines.machine.checks",
    "pipelines.rexs",
    "pipelines.recordings",
    "pipelines.diagnosis",
    "pipelines.diagnosis.uncertainty",
    "pipelines.diagnosis.comparison",
    "pipelines.report.figures",
    "pipelines.report",
    "pipelines.steps",
    "pipelines.runs",
    "pipelines.datasets",
    "pipelines.studies.housings",
    "pipelines.studies.detect",
    "pipelines.studies.design",
    "pipelines.studies.spread",
    "pipelines.studies.calibrate",
    "pipelines.studies.trade",
    "pipelines.studies.verification",
    "pipelines.cli",
    "gearcase",
)


FILES = {module_name(path): path for path in sources.FILES}


@cache
def imported(name):
    """Modules of ours that a module imports, inside functions and for types alone too."""
    found = set()
    for node in nodes(FILES[name]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            full = {alias.name: f"{node.module}.{alias.name}" for alias in node.names}
            found |= {one if one in FILES else node.module for one in full.values()}
    return (found & FILES.keys()) - {name}


def room(name):
    if name in ROOMS and FILES[name].name != "__init__.py":
        return name  # a file that is a room of its own
    return name if FILES[name].name == "__init__.py" else name.rpartition(".")[0]


MODULES = [name for name in FILES if FILES[name].name != "__init__.py"]


def test_every_room_is_known():
    assert not {room(name) for name in MODULES} - set(ROOMS)


def test_imports_go_down_the_list_of_rooms():
    above = [
        f"{name} of {room(name)} imports {other}"
        for name in MODULES
        for other in sorted(imported(name))
        if ROOMS.index(room(other)) > ROOMS.index(room(name))
    ]
    assert not above, "\n".join(above)


def test_no_circle_of_imports():
    try:
        tuple(TopologicalSorter({name: imported(name) for name in FILES}).static_order())
    except CycleError as circle:
        pytest.fail(" -> ".join(circle.args[1]))


def test_the_architecture_page_lists_the_folders_in_the_order_of_their_imports():
    page = (sources.ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    listed = [
        line.split("`")[1] for line in page.splitlines() if line.startswith(("| `fem/", "| `mbd/", "| `pipelines/"))
    ]
    folders = [name.split(".")[:2] for name in ROOMS if "." in name]
    assert listed == list(dict.fromkeys("/".join(folder) for folder in folders))


def test_a_file_name_repeats_only_beside_its_command_table_step_or_python_function():
    outer = ("pipelines.cli", "pipelines.scene.tables", "pipelines.steps", "gearcase")
    files = [module_name(path) for path in sources.FILES if path.stem != "__init__"]
    names = [name.rpartition(".")[2] for name in files if not name.startswith(outer)]
    assert sorted(name for name in set(names) if names.count(name) > 1) == []


def test_no_function_outside_compiled_code_has_more_than_eight_positional_parameters():
    compiled = ("stored", "inner", "by_address")
    many = [
        f"{module_name(path)}.{node.name}"
        for path in sources.FILES
        for node in nodes(path)
        if isinstance(node, ast.FunctionDef)
        and len(node.args.posonlyargs + node.args.args) > 8
        and not any(ast.unparse(one).startswith(compiled) for one in node.decorator_list)
    ]
    assert many == []


def test_a_class_name_repeats_only_for_one_idea_on_two_floors():
    places = {}
    for path in sources.FILES:
        for node in nodes(path):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places.setdefault(node.name, []).append(module_name(path).partition(".")[0])
    repeated = {name: tuple(sorted(rooms)) for name, rooms in places.items() if len(rooms) > 1}
    assert repeated == {
        "Gear": ("fem", "pipelines"),  # its geometry; its place in the kinematics
        "Scene": ("gearcase", "pipelines"),  # as Python sees it; its tables
        "TorqueCurve": ("mbd", "pipelines"),  # as a force; its table
    }
