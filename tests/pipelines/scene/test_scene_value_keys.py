"""Every value of a scene is in the key of a step, or in a short list of what is read after the steps.

Each value of some scenes, which between them hold every field of every table, is changed alone. A value that got lost
on the way to the keys would let a result serve a scene that it does not belong to.
"""

import typing

import pytest
from pydantic import BaseModel

from fem.options import inlined, options_of
from mbd.parts.part_checks import MachineError
from pipelines.engine.storage import digest
from pipelines.io.errors import InputError
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.scene.scene import Scene
from pipelines.scene.tables.derived import key_of
from pipelines.scene.tables.scene_table import Table
from pipelines.steps.machine_steps import machine_steps

END = {"amount_um": 5.0, "length_mm": 2.0, "shape": "linear"}
GEAR = {
    "rack_addendum": 1.0, "rack_dedendum": 1.25, "rack_tip_radius": 0.3, "rim_thickness_mm": 6.0,
    "web_thickness_mm": 6.0, "tip_relief": {"amount_um": 5.0, "length_mm": 1.0}, "end_relief_plus_y": END,
    "end_relief_minus_y": END, "thickness_allowance_um": -20.0, "root_relief": {"amount_um": 4.0, "length_mm": 1.0},
    "deviations": {
        "eccentricity_um": 8.0, "eccentricity_angle_deg": 30.0,
        "waves": [{"order": 33, "amplitude_um": 0.5, "phase_deg": 20.0, "flank": "coast"}],
        "teeth": [{"tooth": 4, "pitch_um": 3.0, "profile_slope_um": 2.0, "flank": "coast"}],
    },
}  # fmt: skip
FAULTS = [
    {"kind": "missing-tooth", "stage": 1, "gear": "wheel", "tooth": 3},
    {"kind": "chipped-tooth", "stage": 1, "gear": "wheel", "tooth": 7, "extent_mm": 4.0, "depth_mm": 1.0},
    {"kind": "cracked-tooth", "stage": 1, "gear": "wheel", "tooth": 9, "depth_mm": 1.0, "far_depth_mm": 0.5,
     "extent_mm": 5.0},
    {"kind": "worn-tooth", "stage": 1, "gear": "wheel", "tooth": 11, "depth_um": 3.0, "place": "profile",
     "diameters_mm": [108.0, 110.0, 112.0], "parts": [0.0, 1.0, 0.5], "extent_mm": 4.0, "fading": True},
    {"kind": "spalled-tooth", "stage": 1, "gear": "wheel", "tooth": 13, "height_mm": 1.0, "length_mm": 3.0,
     "depth_um": 80.0, "diameter_mm": 110.0, "position_mm": 1.0},
    {"kind": "pitted-tooth", "stage": 1, "gear": "wheel", "tooth": 15, "height_mm": 1.0, "length_mm": 3.0,
     "density": 0.1, "pit_mm": 0.2, "diameter_mm": 110.0, "position_mm": 1.0},
    {"kind": "worn-tooth", "stage": 1, "gear": "wheel", "depth_um": 3.0, "place": "pitch", "width_mm": 2.0},
]  # fmt: skip
SPALL = {"kind": "bearing-spall", "shaft": 2, "bearing": 1, "on": "inner-ring", "width_mm": 1.0, "depth_um": 30.0}
HERTZ = {
    "model": "hertz", "kind": "roller", "elements": 12, "element_diameter_mm": 8.0, "pitch_diameter_mm": 40.0,
    "contact_angle_deg": 12.0, "roller_length_mm": 9.0,
}  # fmt: skip
BALL = {"model": "hertz", "designation": "6205", "inner_conformity": 0.52, "outer_conformity": 0.53, "cage_slip": 0.01}
LINEAR = {"model": "linear", "vertical_stiffness_N_per_um": 90.0}
HOUSING = {
    "side_wall_thickness_mm": 11.0, "end_wall_thickness_mm": 11.0, "floor_thickness_mm": 11.0,
    "cover_thickness_mm": 11.0, "foot_pitch_mm": 110.0, "foot_overhang_mm": 20.0, "pad_diameter_mm": 16.0,
    "pad_height_mm": 5.0, "bolt_diameter_mm": 6.0,
    "ribs": {"thickness_mm": 8.0, "height_mm": 20.0, "per_boss": 1},
    "flange": {"width_mm": 12.0, "height_mm": 16.0},
    "joint": {"bolt": "M6", "pitch_mm": 70.0, "positions_mm": [[60.0, 86.0]], "outer_diameter_mm": 15.0,
              "stiffness_N_per_um": [500.0, 300.0]},
}  # fmt: skip
JOINT = {
    "bolt": "M12", "through_mm": [0.0, 0.0, 10.0], "normal": [0.0, 0.0, 1.0], "clamped_mm": [15.0, 20.0],
    "tapped": True, "positions_mm": [[100.0, 50.0, 10.0], [-100.0, 50.0, 10.0]], "outer_diameter_mm": 30.0,
    "stiffness_N_per_um": [500.0, 300.0],
}  # fmt: skip
TORQUE = {"model": "torque", "shaft": 2, "position_mm": 0.0, "times_s": [0.0, 0.5], "torques_N_m": [0.0, 12.0]}
SWEEP = {"model": "sweep", "start_s": 0.1, "end_s": 0.4, "from_Hz": 10.0, "to_Hz": 500.0, "ramp_s": 0.05}
EXCITATIONS = [
    {"model": "torque-ripple", "shaft": 2, "position_mm": 0.0, "amplitude_N_m": 2.0, "order": 6.0},
    {"model": "unbalance", "shaft": 2, "position_mm": 0.0, "unbalance_g_mm": 40.0},
    {"model": "bent-shaft", "shaft": 2, "position_mm": 10.0, "bow_um": 30.0, "straight_at_mm": [-20.0, 25.0]},
    {"model": "shaft-force", "shaft": 2, "position_mm": 0.0, "axis": "x", "force": SWEEP | {"amplitude_N": 30.0}},
    {"model": "casing-force", "point": "sensor_3", "axis": "x",
     "force": {"model": "table", "times_s": [0.0, 0.5], "forces_N": [0.0, 12.0]}},
    {"model": "base-acceleration", "axis": "x", "acceleration": SWEEP | {"amplitude_m_s2": 3.0}},
    {"model": "base-acceleration", "axis": "x",
     "acceleration": {"model": "table", "times_s": [0.0, 0.5], "accelerations_m_s2": [0.0, 12.0]}},
]  # fmt: skip
SHAFTS = [
    {"sections": [{"start_mm": -100.0, "end_mm": 100.0, "diameter_mm": 25.0, "bore_mm": 2.0}],
     "bearing_positions_mm": [-65.0, 65.0], "bearing_supports": ["casing", "ground"],
     "bearings": [LINEAR, {"model": "rigid"}]},
    {"sections": [{"start_mm": -140.0, "end_mm": 140.0, "diameter_mm": 35.0}],
     "bearing_positions_mm": [-65.0, 65.0], "bearing_supports": ["casing", "ground"], "bearings": [HERTZ, BALL]},
    {"sections": [{"start_mm": -140.0, "end_mm": 140.0, "diameter_mm": 35.0}], "bearing_positions_mm": [-65.0, 65.0]},
]  # fmt: skip
COUPLING = {
    "shafts": [2, 3], "positions_mm": [140.0, -140.0], "torsional_stiffness_N_m_per_rad": 1e4,
    "radial_stiffness_across_N_per_um": 2.0, "tilt_stiffness_across_N_m_per_rad": 50.0,
}  # fmt: skip
DISK = {
    "shaft": 2, "position_mm": 30.0, "mass_kg": 1.0, "polar_inertia_kg_m2": 0.1, "diametral_inertia_kg_m2": 0.1,
    "eccentricity_um": 20.0,
}  # fmt: skip
ROPE = {
    "model": "rope", "ground_level_m": -1.0, "rope_direction_deg": 90.0, "shaft": 2,
    "drum_positions_mm": [-140.0, 140.0],
}  # fmt: skip
ROTOR = {
    "inertia_kg_m2": 0.01, "coupling_stiffness_N_m_per_rad": 2000.0, "coupling_damping_N_m_s_per_rad": 0.5,
}  # fmt: skip
INDUCTION = {
    "model": "induction-motor", "shaft": 1, "position_mm": 90.0, "synchronous_rpm": 1000.0, "rated_rpm": 960.0,
    "rated_torque_N_m": 20.0, "breakdown_ratio": 2.4, **ROTOR,
}  # fmt: skip
MOTOR_ALONE = ("model", "synchronous_rpm", "rated_rpm", "rated_torque_N_m", "breakdown_ratio")
CONTROLLED = {
    "model": "controlled-motor", "shaft": 1, "position_mm": 80.0, "times_s": [0.0, 0.3], "speeds_rpm": [800.0, 900.0],
    "proportional_N_m_s_per_rad": 2.0, "integral_N_m_per_rad": 20.0, "limit_N_m": 60.0, "starting_torque_N_m": 5.0,
}  # fmt: skip
ELASTIC = {
    "model": "craig-bampton", "ground": "springs", "bore_element_size_mm": 10.0, "foot_element_size_mm": 10.0,
    "frequency_error": 1e-3,
    "damped_parts": [{"name": "joints", "loss_factor": 0.1},
                     {"name": "side", "loss_factor": 0.03, "box_mm": [[-80.0, -90.0, -70.0], [-50.0, 90.0, -20.0]]}],
}  # fmt: skip
GROUNDS = [{"group": "B"}, {"point_mm": [0.0, 0.0, -144.0]}, {"box_mm": [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]}]

MATRICES = {  # any file that is there: it is read by a step
    "model": "matrices", "file": "rig-housing.step", "units": "t-mm-s", "grounds": [{"nodes": [1, 2]}],
    "bearings": [{"name": f"bearing_{n}", "nodes": [10 * n, 10 * n + 1]} for n in range(1, 5)],
}  # fmt: skip


def dotted(path, table):
    return {f"{path}.{key}": value for key, value in table.items()}


SCENES = {
    "details": ("minimal", {
        "stages.1.pinion": GEAR | {"rim_thickness_mm": None, "web_thickness_mm": None}, "stages.1.wheel": GEAR,
        "stages.1.centre_distance_mm": 76.9, "stages.1.backlash_um": 300.0, "stages.1.mesh": {"model": "plane"},
        "stages.1.pinion_shaft": 1, "stages.1.wheel_shaft": 2, "stages.1.cycle_at_start": 0.1,
        "deviations.include": ["pitch", "helix"],
        "faults": FAULTS, "forces": [TORQUE, *EXCITATIONS], **dotted("load", ROPE), **dotted("casing", ELASTIC),
        **dotted("casing.housing", HOUSING), "losses": {"model": "coulomb"},
        "film": {"model": "squeeze"}, "probes": [{"name": "probe", "shaft": 2, "position_mm": 20.0}],
        "shaft_model.model": "timoshenko",
        "drive.shaft": 1, "drive.brake_torque_N_m": 20.0, "simulation.start": 1,
    }),
    "joined": ("minimal", {
        "shafts": SHAFTS, "couplings": [COUPLING], "disks": [DISK], "load.shaft": 3, "casing": {"model": "none"},
        "faults": [SPALL], "bearings": {"model": "hertz", "designation": "6208"},
        "sensors": [], "stages.1.mesh": {"model": "solid"}, "losses": {"model": "efficiency"},
    }),
    "imported": ("rig-step", {
        "casing.elements_per_wavelength": 30.0, "stages.1.mesh": {"model": "energy"}, "casing.housing.solids": [1],
        "casing.housing.joint": JOINT,
    }),
    "mesh file": ("rig-step", {
        "casing.housing.model": "mesh", "casing.housing.bearings.1": {"name": "bearing_1", "group": "A"},
        "casing.housing.grounds": GROUNDS,
    }),
    "matrices": ("minimal", {"casing.model": "static", "casing.housing": MATRICES}),
    "rigid": ("minimal", {
        "load.model": "rope-pendulum", "casing.housing.foot_fillet_mm": 3.0, "casing.housing.inner_fillet_mm": 3.0,
        "stages.1.pinion.tip_relief": {"amount_um": 5.0, "diameter_mm": 43.0, "shape": "linear"},
    }),
    "torques": ("minimal", {
        "drive": {"model": "torque", "torque_N_m": 20.0, "start_rpm": 900.0, "highest_rpm": 950.0, "shaft": 1,
                  "position_mm": -90.0, "motors": 1, **ROTOR},
        "load": {"model": "torque", "speeds_rpm": [0.0, 400.0], "torques_N_m": [0.0, 40.0], "shaft": 2,
                 "position_mm": 100.0},
        "forces": [INDUCTION, CONTROLLED], "diagnosis.windows_s": {}, "simulation.channels": ["bearing-misalignment"],
    }),
    "motors": ("minimal", {
        "drive": {"motors": 2, "start_rpm": 900.0, **{k: v for k, v in INDUCTION.items() if k in MOTOR_ALONE}},
        "load": {"model": "torque", "times_s": [0.0, 0.4], "torques_N_m": [0.0, 40.0]}, "diagnosis.windows_s": {},
    }),
    "controlled": ("minimal", {
        "drive": {"motors": 1, **{k: v for k, v in CONTROLLED.items() if k not in ("shaft", "position_mm")}},
        "diagnosis.windows_s": {},
    }),
    "rope": ("rig-missing-tooth", {"casing.model": "static", "bearings": LINEAR}),
    "hexahedra": ("minimal", {
        "casing.model": "static", "casing.element": "hexahedron-32",
        "casing.error": "0.2%",
    }),
}  # fmt: skip
AFTER_THE_STEPS = {  # words, what is looked for in finished signals, and what only its own choice reads
    "Scene.title", "Scene.control", "TorqueDrive.highest_rpm",
    "Monitored.sensor", "Monitored.axis", "Monitored.stage", "Monitored.gear",
    "_WindowsBase.windows_s", "Monitored.envelope_band_Hz", "Monitored.noise_m_s2",
    "Monitored.damping_spread",
}  # fmt: skip
ALONE_IT_CANNOT = {  # of two stages one would have no shaft; of two seats one would have no bearing; one sensor;
    # a file there is none of
    "CasingForce.point", "ColumnTable.file", "ColumnTable.column", "ImportedTable.file",
    "GearDeviationsTable.flanks", "MeasuredFlanksTable.file",
    "MatricesHousingTable.equations_file", "MatricesHousingTable.rows_file", "MatricesHousingTable.file",
    "MatricesHousingTable.mass_file", "MatricesHousingTable.nodes_file", "NodeSeatTable.name",
    "SeatBase.name", "StageTable.pinion_shaft", "StageTable.wheel_shaft",
}  # fmt: skip


def inputs(scene):
    """What the key of every step holds besides code: by name, its spec and what it takes."""
    return {stage.name: (stage.kind, digest(stage.spec), stage.inputs) for stage in machine_steps(make_machine(scene))}


def declared(table):
    """The fields of a table by name, with the class that declares them; not what tells the kinds of a table apart."""
    found = {}
    for owner in table.__mro__[::-1]:
        found |= {name: f"{owner.__name__}.{name}" for name in vars(owner).get("__annotations__", {})}
    classes = getattr(table, "kinds", [table.made_of] if hasattr(table, "made_of") else [])
    for made_of in (*classes, *(part for kind in classes for _, part in inlined(kind))):
        for field, one in options_of(made_of):
            owner = next(c for c in made_of.__mro__ if field.name in vars(c).get("__annotations__", {}))
            found[key_of(field.name, one)] = f"{owner.__name__}.{key_of(field.name, one)}"
    return {name: found[name] for name in table.model_fields if name not in ("model", "kind")}


def values(table, path=()):
    """Path, field, value and the words among which it may choose, of everything in a table and the tables in it."""
    for name, field in declared(type(table)).items():
        value = getattr(table, name)
        inner = value if isinstance(value, tuple) else (value,)
        for number, one in enumerate(inner):
            if isinstance(one, BaseModel):
                yield from values(one, (*path, name, number) if isinstance(value, tuple) else (*path, name))
        yield (*path, name), field, value, words(type(table).model_fields[name].annotation)


def words(annotation):
    """The words among which a field may choose."""
    own = [arg for arg in typing.get_args(annotation) if isinstance(arg, str)]
    return own + [word for arg in typing.get_args(annotation) for word in words(arg)]


def others(value, choices):
    """Other values of the same kind."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int | float):
        small = [value + 1, value - 1] if isinstance(value, int) else [value * 1.01, value * 0.99, value + 0.01]
        return [*small, value // 2 if isinstance(value, int) else value / 2]
    if isinstance(value, str):
        twice = [f"{2 * float(value[:-1])}%"] if value.endswith("%") else []
        return [word for word in (*choices, "6206", f"{value}9", *twice) if word != value]
    if isinstance(value, tuple) and value:
        ends = [[*value[:-1], other] for other in others(value[-1], choices)]
        return (
            [*ends, [*value[1:], value[0]]]
            + [[other, *value[1:]] for other in others(value[0], choices)]
            + [list(value[:-1])]
        )
    if isinstance(value, dict):
        return [value | {key: other} for key, item in value.items() for other in others(item, choices)]
    return []


def changed(scene, path, value):
    tree = scene.model_dump()
    place = tree
    for key in path[:-1]:
        place[key] = list(place[key]) if isinstance(place[key], tuple) else place[key]
        place = place[key]
    place[path[-1]] = value
    return Scene.model_validate(tree)


def reaches_a_key(scene, path, choices, value, before, tries):
    """Whether one of so many other values changes the inputs of a step; None if none can stand there alone."""
    tried = 0
    for other in others(value, choices):
        try:
            found = inputs(changed(scene, path, other))
        except (ValueError, MachineError, InputError):
            continue
        tried += 1
        if found != before or tried == tries:
            return found != before
    return False if tried else None


@pytest.fixture(scope="module")
def reached():
    """By field of a table: whether a change of it reached the key of a step in one of the scenes."""
    found = {}
    for name, settings in SCENES.values():
        scene = load_scene(name, settings).scene
        before = inputs(scene)
        for path, field, value, choices in values(scene):
            if value and isinstance(value[0] if isinstance(value, tuple) else value, BaseModel):
                found[field] = True  # by what is in it
            elif not found.get(field):
                tries = 3 if field in AFTER_THE_STEPS else 100
                answer = reaches_a_key(scene, path, choices, value, before, tries)
                found[field] = found.get(field) if answer is None else answer
    return found


def test_every_value_of_a_scene_is_in_the_key_of_a_step_or_read_after_the_steps(reached):
    assert {field for field, found in reached.items() if found is False} - AFTER_THE_STEPS == set()


def test_what_is_read_after_the_steps_is_in_no_key(reached):
    assert {field for field in AFTER_THE_STEPS if reached[field] is not False} == set()


def tables(base=Table):
    for table in base.__subclasses__():
        yield table
        yield from tables(table)


def test_every_field_of_every_table_was_changed(reached):
    scene = (table for table in tables() if table.__module__.startswith("pipelines.scene"))  # not those of plans
    ours = ("fem.", "mbd.", "pipelines.")  # a test makes tables of dataclasses of its own
    of_scenes = (table for table in scene if getattr(table, "made_of", table).__module__.startswith(ours))
    every = {field for table in of_scenes for field in declared(table).values()}
    assert {field for field in every if reached.get(field) is None} == ALONE_IT_CANNOT
