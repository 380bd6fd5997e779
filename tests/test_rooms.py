"""The house: known rooms, imports that go down the list of rooms, no circle of files."""

import ast
from functools import cache
from graphlib import CycleError, TopologicalSorter

import pytest
import sources
from sources import module_name, nodes

ROOMS = (  # from the ground up: a room imports from itself and from what stands above it in this list
    "fem",
    "fem.processes",
    "fem.storage",
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
