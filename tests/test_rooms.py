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
    "fem.casing.hexahedra",
    "fem.casing.meshing",
    "fem.casing.edges",
    "fem.casing.survey",
    "fem.casing.parts",
    "fem.casing.reduced",
    "fem.casing.mesh_error",
    "fem.casing.uncertain",
    "fem.casing.foreign",
    "fem.casing.models",
    "mbd.elements",
    "mbd.parts",
    "mbd.torques",
    "mbd.excitations",
    "mbd.coordinates",
    "mbd.reference",
    "mbd.forces",
    "mbd.bearing_faults",
    "mbd.system",
    "mbd.integrators",
    "mbd.energy",
    "mbd.output",
    "mbd.accuracy",
    "mbd",
    "pipelines.border",
    "pipelines.scene.tables",
    "pipelines.scene",
    "pipelines.signals",
    "pipelines.plant.torques",
    "pipelines.plant",
    "pipelines.plant.checks",
    "pipelines.rexs",
    "pipelines.engine",
    "pipelines.bars",
    "pipelines.figures.teeth",
    "pipelines.figures",
    "pipelines.housings",
    "pipelines.orders",
    "pipelines.features",
    "pipelines.recordings",
    "pipelines.diagnosis",
    "pipelines.comparison",
    "pipelines.report",
    "pipelines.steps",
    "pipelines.runs",
    "pipelines.runs.listed",
    "pipelines.dataset",
    "pipelines.campaign",
    "pipelines.dataset.passes",
    "pipelines.detect",
    "pipelines.trade",
    "pipelines.verification",
    "pipelines.commands.finished",
    "pipelines.commands.studies",
    "pipelines.commands",
    "pipelines",
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
