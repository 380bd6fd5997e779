"""Mesh models and faults of teeth by name: scene tables fit them, unknown names are refused, each has its own key."""

import dataclasses
from typing import Literal, get_args, get_origin

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from benchmarks.scene_keys import values
from fem.casing.models.casing_registry import CASINGS, casing_class
from fem.contact.faults.fault_registry import FAULTS, fault_class
from fem.contact.models.mesh_model_registry import MODELS, loaded_model, mesh_model
from fem.contact.slice_frame import ModelError
from fem.elements.solid_elements import CHOICES
from fem.gears.gear_checks import GeometryError
from fem.options import check_options, option
from mbd.integrators.methods import METHODS, make_integrator
from pipelines.engine.code_version import reachable
from pipelines.engine.storage import class_modules
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene, validate
from pipelines.scene.merge import Merged
from pipelines.scene.tables.casing import CASING_TABLES, FlexibleBase
from pipelines.scene.tables.derived import table
from pipelines.scene.tables.faults import FaultTable
from pipelines.scene.tables.simulation import SimulationTable
from pipelines.scene.tables.stages import MeshModel
from pipelines.steps.machine_steps import machine_steps

PAIR = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))


def tables(union, discriminator):
    """Scene tables by name."""
    found = {}
    for member in get_args(get_args(union)[0]):
        literal = member.model_fields[discriminator].annotation
        assert get_origin(literal) is Literal
        found |= dict.fromkeys(get_args(literal), member)
    return found


MESHES = tables(MeshModel, "model")


def own_code(step):
    """Modules that the key of a step holds."""
    return reachable(step.build.__module__, *step.modules, *class_modules(step.spec))


def extremes(table):
    """Least and greatest values that a table takes, by key."""
    for key, field in table.model_fields.items():
        for limit in field.metadata:
            for bound in ("ge", "le"):
                if hasattr(limit, bound):
                    yield key, getattr(limit, bound)


def test_every_scene_table_has_a_model_and_every_model_a_table():
    assert set(MESHES) == set(MODELS)
    assert set(tables(FaultTable, "kind")) == set(FAULTS)
    assert [one.model_fields["model"].default for one in CASING_TABLES] == [n for n in CASINGS if n != "matrices"]
    for one in CASING_TABLES:
        assert not issubclass(one, FlexibleBase) or get_args(one.model_fields["element"].annotation) == CHOICES


@pytest.mark.parametrize("name", MESHES)
def test_a_model_takes_all_that_its_table_lets_through(name):
    assert MESHES[name]().made() == mesh_model(name)()
    for key, bound in extremes(MESHES[name]):
        assert getattr(loaded_model(MESHES[name](**{key: bound}).made(), 1e5), key) == bound


@pytest.mark.parametrize("name", MODELS)
def test_the_laws_of_both_flanks_carry_the_name_of_their_model(name):
    model = loaded_model(mesh_model(name)(slices=5), 1e5)
    model.check(PAIR)
    if model.seconds == 0.0:
        assert [(law.model, law.flank) for law in model.laws(PAIR)] == [(name, "drive"), (name, "coast")]


def test_an_unknown_name_is_refused_with_those_that_are_known():
    with pytest.raises(ModelError, match="'shell' is unknown; known: iso, energy, plane, solid"):
        mesh_model("shell")
    with pytest.raises(GeometryError, match="'bent-tooth' is unknown; known: missing-tooth"):
        fault_class("bent-tooth")
    with pytest.raises(ValueError, match="'euler' is unknown; known: exponential, trapezoidal"):
        make_integrator("euler", None, 1e-5)


@pytest.mark.parametrize("name", MODELS)
def test_the_key_of_a_law_takes_the_code_of_its_own_model_alone(name):
    stage = machine_steps(make_machine(load_scene("minimal", [f"stages.1.mesh.model={name}"]).scene))[0]
    code = set(own_code(stage))
    assert MODELS[name][0] in code
    assert not code & {module for other, (module, _) in MODELS.items() if other != name}


def test_the_key_of_a_damaged_law_takes_the_code_of_its_own_faults_alone():
    fault = {"kind": "chipped-tooth", "stage": 1, "gear": "wheel", "tooth": 3, "extent_mm": 4.0, "depth_mm": 1.0}
    scene = load_scene("minimal", {"faults": [fault]}).scene
    stage = next(stage for stage in machine_steps(make_machine(scene)) if stage.kind == "flanks")
    code = set(own_code(stage))
    assert {FAULTS["chipped-tooth"][0]} == code & {module for module, _ in FAULTS.values()}


@pytest.mark.parametrize("name", get_args(SimulationTable.model_fields["integrator"].annotation))
def test_the_key_of_a_motion_takes_the_code_of_its_own_integrator_alone(name):
    scene = load_scene("minimal", [f"simulation.integrator={name}"]).scene
    motion = machine_steps(make_machine(scene))[-1]
    code = set(own_code(motion))
    assert {METHODS[name][0]} == code & {module for module, _ in METHODS.values()}


def test_units_are_the_ends_of_keys():
    tables_of = tables(FaultTable, "kind")
    common = {"kind": "worn-tooth", "stage": 1, "gear": "wheel", "tooth": 3, "depth_um": 4.0}
    worn = tables_of["worn-tooth"](**common, place="pitch", width_mm=2.0).made()
    assert (worn.depth, worn.place, worn.width) == (4e-6, "pitch", 2e-3)
    profile = tables_of["worn-tooth"](**common, place="profile", diameters_mm=(39.0, 41.0)).made()
    assert profile.diameters == (0.039, 0.041)


@pytest.mark.parametrize("kind", FAULTS)
def test_a_fault_adds_compliance_and_gaps_that_are_not_negative(kind):
    options = {
        "missing-tooth": {},
        "chipped-tooth": {"extent": 4e-3, "depth": 1e-3},
        "cracked-tooth": {"depth": 1e-3},
        "spalled-tooth": {"height": 1e-3, "length": 4e-3, "depth": 1e-4},
        "pitted-tooth": {"height": 1e-3, "density": 0.1, "pit": 3e-4},
        "worn-tooth": {"depth": 5e-6},
    }[kind]
    fault = fault_class(kind)(**options)
    fault.check(PAIR.wheel)
    law = mesh_model("iso")(slices=6).laws(PAIR)[0]
    compliance, gap = fault.compliance(law, PAIR, "wheel"), fault.gap(law, PAIR, "wheel")
    assert compliance.shape == (6, law.compliance.size)
    assert (compliance >= 0.0).all()
    assert (gap >= 0.0).all()
    added = np.isinf(fault.clearance) or compliance.any() or gap.any()
    assert added
    assert fault.changes_flank == (not np.isinf(fault.clearance))


@pytest.mark.parametrize("name", ["static", "craig-bampton"])
def test_the_key_of_casing_modes_takes_the_code_of_its_own_model_alone(name):
    scene = load_scene("rig-healthy", [f"casing.model={name}"]).scene
    stage = next(stage for stage in machine_steps(make_machine(scene)) if stage.kind == "casing-modes")
    code = set(own_code(stage))
    assert {CASINGS[name][0]} == code & {module for module, _ in CASINGS.values()}


def test_an_unknown_casing_is_refused_with_those_that_are_known():
    with pytest.raises(ValueError, match="'foam' is unknown; known: none, rigid, static, craig-bampton"):
        casing_class("foam")


@pytest.mark.parametrize("most", [5.0, 7.0])
def test_a_range_is_stated_once(most):
    """A limit of an option is that of the object, of the message, of the schema and of the page of keys."""
    fields = [("depth", float, option(0.001, unit="mm", gt=0, le=most, text="depth of it"))]
    part = dataclasses.make_dataclass("Part", fields, frozen=True, kw_only=True)
    made = table(part)
    assert made(depth_mm=most).made() == part(depth=most / 1000)
    with pytest.raises(SceneError, match=f"depth_mm = 9.0: must be at most {most:g} mm"):
        validate(Merged({"depth_mm": 9.0}), made, "scene")
    with pytest.raises(ValueError, match=f"depth = 9 mm: must be above 0 and at most {most:g} mm"):
        check_options(part(depth=0.009), ValueError)
    assert made.model_json_schema()["properties"]["depth_mm"]["maximum"] == most
    assert values(made.model_fields["depth_mm"], "depth_mm") == f"above 0 and at most {most:g} mm"
