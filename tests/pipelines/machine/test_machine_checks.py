"""What can be known before computing is refused before computing: by `check`, `explain` and `run` in the same words."""

import dataclasses
import math
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from mbd_rigs import no_casing, train

from fem.casing.geometry.locators import ByCylinder
from fem.casing.mesh.imported_housing import Seat
from fem.storage.cache_folder import cache_root
from mbd.parts.channels import channel_names, mesh_channels, motor_channels, shaft_channels
from mbd.parts.part_checks import MachineError
from mbd.system.statics import equilibrium
from mbd.system.system import assemble
from pipelines.cli.main import main
from pipelines.io.errors import Problems, SceneError
from pipelines.machine.bearing_loads import load_directions
from pipelines.machine.checks import cost
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.checks.design_warnings import design_warnings
from pipelines.machine.checks.strength import (
    STATIC_STRENGTH,
    TORSION_STRENGTH,
    contact_pressure,
    torques_along,
    torsions,
)
from pipelines.machine.checks.window_checks import bad_windows
from pipelines.machine.layout import lay_out
from pipelines.machine.machine_conversion import make_drivetrain
from pipelines.machine.scene_bearings import bearing_points, bearing_specs
from pipelines.machine.system_assembly import assemble_machine, assemble_system
from pipelines.runs.checked_scene import check_scene
from pipelines.scene.load_scene import load_scene
from pipelines.steps.run_plan import plan_run, scene_warnings

NO_WINDOWS = {"diagnosis.windows_s": {}}
FAULT = {"faults": [{"kind": "missing-tooth", "stage": 1, "gear": "wheel", "tooth": 0}], "control": "without-faults"}
LONG = {"simulation.end_s": 3.0, "drive.times_s": [0.0, 0.1, 3.0]}
SLOW = LONG | {"drive.times_s": [0.0, 1.0, 3.0]}
NU = {"model": "hertz", "designation": "NU205"}
LINEAR = {"model": "linear"}
ROPE = {
    "load.model": "rope", "load.rope_length_m": 0.01, "simulation.end_s": 3.0, "drive.times_s": [0.0, 0.1, 3.0],
}  # fmt: skip


def section(diameter, bore=0.0):
    return [{"start_mm": -140.0, "end_mm": 140.0, "diameter_mm": diameter, "bore_mm": bore}]


def seats(number, **changes):
    found = [dict(seat) for seat in load_scene("rig-step").tree["casing"]["housing"]["bearings"]]
    found[number - 1] |= changes
    return {"casing.housing.bearings": found}


def refusal(scene, settings):
    """The problems of a scene by path."""
    loaded = load_scene(scene, settings)
    with pytest.raises(SceneError) as refused:
        checked_machine(loaded.scene, loaded.source.shown)
    said = {problem.path: str(problem) for problem in refused.value.problems}
    assert all(text == text.rstrip() and ".. " not in text for text in said.values())
    return said


LOST_FILE = {"model": "table", "times_s": {"file": "lost.csv", "column": "t"}, "forces_N": [1.0]}
REFUSED = [
    (
        "rig-healthy",
        {"forces": [{"model": "casing-force", "point": "sensor_1", "axis": "z", "force": LOST_FILE}]},
        "forces.1.force.times_s.file",
        "there is no such file",
    ),
    # bearings
    ("minimal", {"bearings": {"model": "hertz", "designation": "6206-2RS"}}, "bearings.designation", "Similar: 6206"),
    ("minimal", {"bearings": {"model": "hertz", "designation": "nu 208"}}, "bearings.designation", "Similar: NU208"),
    (
        "minimal",
        {"shafts.2.bearings": [LINEAR, {"model": "hertz", "designation": "9999"}]},
        "shafts.2.bearings.2.designation",
        "not in the catalogue",
    ),
    ("minimal", {"bearings": NU}, "shafts.1", "shaft 1 can move along its axis freely"),
    ("minimal", {"bearings": {**LINEAR, "cross_stiffness_N_per_um": 300.0}}, "bearings", "not positive definite"),
    (
        "minimal",
        {
            "bearings": {
                "model": "hertz", "kind": "ball", "elements": 9, "element_diameter_mm": 20.0, "pitch_diameter_mm": 40.0,
            }
        },
        "bearings",
        "overlap",
    ),
    # mesh laws
    ("minimal", {"stages.1.face_width_mm": 0.048}, "stages.1", "less than half a module"),
    ("minimal", {"stages.1.helix_angle_deg": 36.0}, "stages.1.mesh", "limit 30 deg of ISO 6336-1"),
    (
        "minimal",
        {
            "stages.1.mesh": {"model": "energy"},
            "stages.1.wheel": {"rim_thickness_mm": 8.0, "web_thickness_mm": 5.0},
        },
        "stages.1.mesh",
        "solid gear bodies only",
    ),
    # parts on their shafts
    (
        "minimal",
        {
            "disks": [
                {
                    "shaft": 2, "position_mm": 900.0, "mass_kg": 1.0, "polar_inertia_kg_m2": 0.01,
                    "diametral_inertia_kg_m2": 0.01,
                }
            ]
        },
        "disks.1.position_mm",
        "not on shaft 2, which extends from -140 to 140 mm",
    ),
    ("minimal", {"load.drum_positions_mm": [0.0, 500.0]}, "load.drum_positions_mm", "y = 500 mm is not on shaft 2"),
    ("minimal", {"shaft_model.element_length_mm": 0.1}, "shafts.1", "coordinates, more than"),
    ("minimal", ROPE, "load", "are wound up at t ="),
    # strength
    ("minimal", {"load.container_kg": 11400.0}, "stages.1", "the best gear steel bears 2640 MPa"),
    ("minimal", {"gear_material.elastic_modulus_GPa": 0.01}, "stages.1", "modules"),
    ("minimal", {"shafts.2.sections": section(6.0)}, "shafts.2.sections.1.diameter_mm", "shaft 2 is too thin"),
    ("minimal", {"shafts.1.sections": section(4.0)}, "shafts.1.sections.1.diameter_mm", "shaft 1 is too thin"),
    ("minimal", {"drive.speeds_rpm": [0.0, 1e9, -1e9]}, "drive.speeds_rpm", "would move at 2.351e+06 m/s"),
    ("minimal", {"drive.speeds_rpm": [0.0, -1e308, 1e308]}, "drive.speeds_rpm", "steel bursts at 569 m/s"),
    # casing
    (
        "minimal",
        {"shafts.1.bearing_positions_mm": [-60.0, 65.0]},
        "shafts.1.bearing_positions_mm",
        "bearing_1 at y = -60 mm is 5 mm away from the middle of its boss at -65 mm",
    ),
    ("rig-healthy", {"casing.element_size_mm": 1000.0}, "casing.element_size_mm", "is out of range"),
    ("rig-healthy", {"casing.element_size_mm": 1.5}, "casing.element_size_mm", "million nodes or more"),
    # walls of 10 mm around 300 x 160 x 200 mm, 2.8e6 mm3, in regular tetrahedra of 1.5^3 / (6 sqrt 2) = 0.398 mm3
    ("bench", {"casing.element_size_mm": 1.5}, "casing.element_size_mm", "give about 7.0 million tetrahedra"),
    (
        "rig-step",
        seats(3, through_mm=[78.68, -135.0, 0.0]),
        "casing.housing.bearings.3.through_mm",
        "2.004 mm away from that of shaft 2 at x 76.6755, z 0 mm (limit 0.5 mm)",
    ),
    ("rig-step", seats(1, axis=[0.0, 0.0, 1.0]), "casing.housing.bearings.1.axis", "must run along y"),
    ("rig-step", seats(1, diameter_mm=48.0), "casing.housing.bearings.1", "nearest cylinders along it: diameter 47 mm"),
    (
        "rig-step",
        {"shafts.2.bearing_positions_mm": [-130.0, 135.0]},
        "shafts.2.bearing_positions_mm",
        "bearing_3 at y = -130 mm is 5 mm away from the middle of its seat at -135 mm",
    ),
    ("rig-step", {"casing.housing.unit": "inch"}, "casing.housing.file", "declares its unit of length as mm"),
    # diagnosis
    (
        "minimal",
        {**FAULT, **SLOW, "diagnosis.windows_s": {"start": [0.0, 2.0]}},
        "diagnosis.windows_s.start",
        "at constant highest speed: 1 to 3 s",
    ),
    (
        "minimal",
        {**FAULT, **LONG, "diagnosis.windows_s": {"short": [1.0, 2.0]}},
        "diagnosis.windows_s.short",
        "has 5.5 revolutions of the stage 1 wheel",
    ),
    ("minimal", {**FAULT, **LONG, "drive.speeds_rpm": [0.0, 0.0, 0.0]}, "drive.speeds_rpm", "all speeds are 0"),
    (
        "minimal",
        {**FAULT, **LONG, "simulation.output_rate_Hz": 1000.0, "diagnosis.windows_s": {"w": [0.2, 3.0]}},
        "simulation.output_rate_Hz",
        "needs lines up to 621.8 Hz",
    ),
    (
        "minimal",
        {
            **FAULT, **LONG, "simulation.output_rate_Hz": 2000.0, "diagnosis.windows_s": {"w": [0.2, 3.0]},
            "diagnosis.envelope_band_Hz": "resonance",
        },
        "diagnosis.envelope_band_Hz",
        "no strip of 300 Hz",
    ),
    # size
    ("minimal", {"simulation.step_us": 1e-9}, "simulation.step_us", "1e+15 time steps in 1 s, more than 1e+09"),
    ("minimal", {"simulation.step_us": 1e-300}, "simulation.step_us", "more than 1e+09"),
    (
        "minimal",
        {"simulation.end_s": 3600.0, "simulation.output_rate_Hz": 200000.0, "drive.times_s": [0.0, 1.0, 3600.0]},
        "simulation.output_rate_Hz",
        "more than 8 GB",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("scene", "settings", "path", "words"), REFUSED)
def test_refused_before_computing_by_key_with_value_and_limit(scene, settings, path, words):
    found = refusal(scene, settings)
    assert words in found[path], found


def test_a_bearing_outside_its_boss_is_one_problem():
    loaded = load_scene("minimal", {"shafts.1.bearing_positions_mm": [-65.0, 100.0]})
    with pytest.raises(SceneError, match=r"1 problem\n.* bearing_2 at y = 100 mm is 35 mm away from the middle"):
        checked_machine(loaded.scene, "minimal")


def test_everything_is_refused_at_once():
    settings = {
        "bearings": {"model": "hertz", "designation": "6206X"},
        "simulation.step_us": 1e-9,
        "shafts.2.sections": section(6.0),
    }
    assert set(refusal("minimal", settings)) == {
        "bearings.designation", "simulation.step_us", "shafts.2.sections.1.diameter_mm",
    }  # fmt: skip


@pytest.mark.parametrize("command", ["check", "explain", "simulate", "run"])
def test_every_command_refuses_in_the_same_words(command, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = [
        "--set",
        'bearings={model="hertz",designation="6206-2RS"}',
        "--set",
        "shafts.2.sections.1.diameter_mm=6",
    ]
    assert main([command, "minimal", *settings]) == 2
    said = capsys.readouterr().err
    assert "scene minimal: 2 problems" in said
    assert 'bearings.designation = "6206-2RS": is not in the catalogue' in said
    assert "shafts.2.sections.1.diameter_mm = 6: shaft 2 is too thin for 27.95 N m" in said
    assert not (tmp_path / "runs").exists()


def test_a_wavelength_needs_the_thickness_of_an_imported_wall():
    scene = load_scene("rig-step", {"casing.elements_per_wavelength": 6.0}).scene
    housing = scene.casing.housing.model_copy(update={"wall_thickness_mm": None})
    without = scene.model_copy(update={"casing": scene.casing.model_copy(update={"housing": housing})})
    with pytest.raises(SceneError, match=r"casing\.housing\.wall_thickness_mm: is needed"):
        checked_machine(without, "rig-step")


def free_bytes(monkeypatch, **free):
    """Disks with so many free bytes under the cache and elsewhere."""

    def disk_usage(folder):
        inside = Path(folder).resolve() in (cache_root(), *cache_root().parents)
        return SimpleNamespace(free=free["cache"] if inside else free["elsewhere"])

    monkeypatch.setattr(cost.shutil, "disk_usage", disk_usage)


def test_signals_that_find_no_room_are_refused_before_the_work(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    free_bytes(monkeypatch, cache=1e12, elsewhere=1e6)
    with pytest.raises(SceneError, match=r"signals of 1 simulation take about 1\.16 MB in runs, 1 MB are free"):
        plan_run(load_scene("minimal"))


def test_a_full_cache_stops_only_signals_that_memory_cannot_hold(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    free_bytes(monkeypatch, cache=0.0, elsewhere=1e12)
    plan_run(load_scene("minimal"))
    long = {"simulation.end_s": 1000.0, "drive.times_s": [0.0, 0.2, 1000.0], "drive.speeds_rpm": [0.0, 900.0, 900.0]}
    with pytest.raises(SceneError, match=r"signals of 1 simulation take about 2\.32 GB in .*, 0 B are free"):
        plan_run(load_scene("minimal", long))


def test_check_says_what_a_run_costs(capsys):
    assert main(["check", "minimal"]) == 0
    assert "1 simulation of 5e+04 time steps and 1e+04 samples of 29 signals" in capsys.readouterr().out


def test_check_counts_the_signals_of_each_simulation():
    rope = cost.cost(make_drivetrain(load_scene("rig-healthy").scene))
    torque = cost.cost(make_drivetrain(load_scene("rig-healthy", {"load.model": "static-torque"}).scene))
    assert torque.channels < rope.channels
    found = cost.estimate([*plan_run(load_scene("rig-missing-tooth")).machines.values()])
    assert f"4 simulations of 1e+05 time steps and 5e+04 samples of {rope.channels} or {torque.channels}" in found
    on_disk = 2 * rope.bytes + 2 * torque.bytes + 0.5 * 2 * rope.bytes  # cache; two files of the result folder
    assert found.endswith(f"{cost.words(on_disk)} on disk")


def test_the_time_of_a_step_grows_with_every_sixteen_slices_of_a_stage():
    train = [make_drivetrain(load_scene("minimal", {"stages.1.mesh.slices": n}).scene) for n in (1, 16, 17, 33)]
    one, full, two, three = (cost.cost(each).seconds for each in train)
    assert one == full < two
    assert three - two == pytest.approx(two - full)


@pytest.mark.parametrize("scene", ["minimal", "rig-healthy"])
def test_the_channels_counted_are_those_recorded(scene):
    loaded = load_scene(scene).scene
    motors = [name for n in range(loaded.drive.motors) for name in motor_channels(f"motor_{n}")]
    shafts = [name for n in range(len(loaded.shafts)) for name in shaft_channels(f"shaft_{n}")]
    meshes = [name for n in range(len(loaded.stages)) for name in mesh_channels(f"mesh_{n}")]
    others = SimpleNamespace(channel_names=(*motors, *shafts, *meshes))
    drums = (0.0,) * len(loaded.load.drum_positions_mm or (0, 0))
    load = loaded.load.made().load("shaft_2", drums)
    recorded = SimpleNamespace(components=(others, *bearing_specs(loaded, Problems()), load))
    names = channel_names(recorded, tuple(sensor.name for sensor in loaded.sensors))
    assert cost.cost(make_drivetrain(loaded)).channels == len(names)


def test_the_output_rate_is_held_against_the_fastest_mesh():
    settings = {"stages.2.pinion_teeth": 150, "stages.2.wheel_teeth": 160, "simulation.output_rate_Hz": 7500.0}
    scene = load_scene("rig-healthy", settings).scene
    told = [text for text in design_warnings(scene, make_drivetrain(scene)) if "output_rate_Hz" in text]
    assert [("stage 2, 818.2 Hz" in text) for text in told] == [True]


@pytest.mark.parametrize(("band", "warned"), [(2000.0, True), (5000.0, False)])
def test_signals_beyond_the_modes_of_the_casing_are_a_warning_with_the_band_needed(band, warned):
    scene = load_scene("rig-healthy", {"casing.band_Hz": band}).scene  # its signals reach 5000 Hz
    found = design_warnings(scene, make_drivetrain(scene))
    assert any("keeps modes of the casing to 3000 Hz" in t and "casing.band_Hz to 3334" in t for t in found) == warned


@pytest.mark.parametrize(("step", "warned"), [(500.0, True), (100.0, False)])
def test_a_step_above_the_sampling_interval_is_a_warning_with_the_step_used(step, warned):
    scene = load_scene("minimal", {"simulation.step_us": step}).scene
    found = design_warnings(scene, make_drivetrain(scene))
    assert any("step_us = 500 is above the sampling interval" in t and "is 100 us" in t for t in found) == warned


@pytest.mark.parametrize(
    ("rpm", "remedy"),
    [(50_000.0, r"Set \d+ or more, 4 times"), (180_000.0, r"Reduce drive.speeds_rpm: \d+ would be needed, 200000 is")],
)
def test_the_remedy_for_high_speeds_is_a_rate_only_where_it_is_possible(rpm, remedy):
    scene = load_scene("minimal", {"drive.speeds_rpm": [0.0, rpm, rpm]}).scene
    found = {one.path: one.remedy for one in bad_windows(scene, make_drivetrain(scene))}
    assert re.match(remedy, found["simulation.output_rate_Hz"])


def test_a_window_in_the_run_up_is_a_warning_where_nothing_is_compared():
    settings = {"faults": FAULT["faults"], **SLOW, "diagnosis.windows_s": {"start": [0.0, 2.0]}}
    scene = load_scene("minimal", settings).scene
    found = design_warnings(scene, make_drivetrain(scene))
    assert any("the mean speed of the motors in this window is" in text for text in found)


@pytest.mark.parametrize(("ground", "warned"), [("fixed", True), ("springs", False)])
def test_mounts_of_a_casing_that_is_held_are_a_warning(ground, warned):
    mounts = {"casing.ground": ground, "casing.mounts_N_per_um": [[100.0, 100.0, 200.0]]}
    scene = load_scene("rig-healthy", mounts).scene
    found = design_warnings(scene, make_drivetrain(scene))
    assert any("mounts_N_per_um is ignored" in text for text in found) == warned


def test_gears_and_faults_in_another_unit_are_a_warning():
    relief = {"amount_um": 0.006, "length_mm": 0.007}
    crack = {"kind": "cracked-tooth", "stage": 1, "gear": "wheel", "tooth": 7, "depth_mm": 0.0015}
    given = {"stages.1.helix_angle_deg": 0.2269, "stages.1.pinion.tip_relief": relief, "faults": [crack]}
    scene = load_scene("bench", given).scene
    found = [text for text in design_warnings(scene, make_drivetrain(scene)) if "unusual" in text]
    assert [text.partition(" if it is in ")[2] for text in found] == [
        "rad: 0.2269 rad = 13.0004 deg", "mm: 0.006 mm = 6 um", "m: 0.007 m = 7 mm", "m: 0.0015 m = 1.5 mm",
    ]  # fmt: skip
    shipped = load_scene("bench").scene
    assert not [text for text in design_warnings(shipped, make_drivetrain(shipped)) if "unusual" in text]


def test_sensors_at_one_place_or_in_another_unit_are_a_warning():
    places = {"sensors.1.position_mm": [0.0, -0.08, 0.035], "sensors.2.position_mm": [0.0, -0.08, 0.035]}
    scene = load_scene("bench", places).scene
    found = " ".join(design_warnings(scene, make_drivetrain(scene)))
    assert "sensors.1.position_mm: motor_side is 80 mm inside the outer walls" in found
    assert "sensors.2.position_mm: brake_side is at the place of motor_side" in found
    plain = load_scene("bench").scene
    assert not [text for text in design_warnings(plain, make_drivetrain(plain)) if "sensors" in text]


def test_contact_pressure_of_spur_gears_is_that_of_two_cylinders():
    """At the pitch point p = sqrt(F E*/(pi b R)), F along the line of action; the factor Z_eps aside."""
    scene = load_scene("minimal", {"stages.1.helix_angle_deg": 0.0, **NO_WINDOWS}).scene
    pair = lay_out(scene).pairs[0]
    torque, alpha = 20.0, pair.working_pressure_angle
    radii = [gear.reference_radius * math.sin(alpha) for gear in (pair.pinion, pair.wheel)]
    radius = 1 / sum(1 / r for r in radii)
    modulus = pair.pinion_material.plane_strain_modulus / 2
    force = torque / pair.pinion.base_radius / pair.face_width
    hertz = math.sqrt(force * modulus / (math.pi * radius))
    overlap = math.sqrt((4 - pair.transverse_contact_ratio) / 3)
    assert contact_pressure(pair, torque) == pytest.approx(hertz * overlap, rel=2e-4)


def test_torsion_follows_the_torque_along_the_shaft():
    """Between motor and pinion half the input torque; between wheel and drums half the output torque."""
    scene = load_scene("minimal", {"shafts.2.sections": section(20.0, 10.0)}).scene
    layout = lay_out(scene)
    for entering in torques_along(scene, layout):
        assert sum(torque for _, torque in entering) == pytest.approx(0.0, abs=1e-12)
    first, second = torsions(scene, layout)
    assert first.torque == pytest.approx(20.3285 / 2, rel=1e-4)
    assert second.torque == pytest.approx(55.9033 / 2, rel=1e-4)
    hollow = math.pi / 16 * (0.02**4 - 0.01**4) / 0.02
    assert second.stress == pytest.approx(second.torque / hollow, rel=1e-12)
    assert second.stress < TORSION_STRENGTH < STATIC_STRENGTH


def test_the_seat_found_on_the_solid_is_the_seat_of_its_mesh():
    """The grid over the cylinders gives the bearing points that the surface mesh gives."""
    from fem.casing.mesh.gmsh_mesh import find_seats
    from pipelines.machine.scene_casing import housing

    scene = load_scene("rig-step").scene
    layout = lay_out(scene)
    made = housing(scene.casing.housing, (), layout, bearing_points(scene, layout))
    assert isinstance(made.seats[0], Seat)
    assert isinstance(made.seats[0].locator, ByCylinder)
    for seat, point in zip(made.seats, find_seats(made).values(), strict=True):
        assert point == pytest.approx(seat.shaft_point, abs=2e-6)


def test_a_motion_without_stiffness_names_the_soft_shaft():
    machine = train()
    first = machine.shafts[0]
    soft = dataclasses.replace(first, elastic_modulus=1e-10)
    with pytest.raises(MachineError, match=f"The softest shaft in torsion is {soft.name} with"):
        assemble(dataclasses.replace(machine, shafts=(soft, *machine.shafts[1:])), no_casing())


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("rig-healthy", {"casing.mounts_N_per_um": [[100.0, 100.0, 200.0]] * 2}, r"has 2 rows, .* has 6 feet"),
        ("rig-step", {"casing.housing.grounds": [{"point_mm": [0.0, 0.0, -60.0]}] * 2}, "needs 3 feet or more"),
    ],
)
def test_mounts_that_do_not_fit_the_feet_are_refused_before_the_mesh(name, settings, words):
    loaded = load_scene(name, {"casing.ground": "springs", **settings})
    with pytest.raises(SceneError, match=words):
        checked_machine(loaded.scene, loaded.source.shown)


def test_one_load_that_is_too_large_is_one_problem():
    """It exceeds both the static strength and the deflection at which linear elasticity holds."""
    with pytest.raises(SceneError) as refused:
        check_scene(load_scene("pair", {"load.torque_N_m": 1e5}))
    assert len(refused.value.problems) == 1
    assert "the best gear steel bears 2640 MPa" in str(refused.value)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"load.rope_direction_deg": 90.0},
        {"load.rope_direction_deg": 0.0, "stages.1.pinion_hand": "left"},
    ],
)
def test_the_direction_of_the_load_of_a_bearing_is_that_of_the_equilibrium(changes):
    """Shafts on two bearings are statically determinate, so bending and contacts do not change the directions."""
    scene = load_scene("minimal", {"bearings": {"model": "linear"}, "deviations.enabled": False} | changes).scene
    machine = checked_machine(scene, "minimal")
    laws = [spec.mesh.laws(spec.pair) for spec in machine.laws]
    recorded = dataclasses.replace(machine.recorded, sensors=())
    system = assemble_system(assemble_machine(machine.parts, laws), no_casing(), recorded)
    rest, found = equilibrium(system).displacement, load_directions(machine)
    for bearing in machine.parts.bearings:
        x, _, z = (bearing.stiffness_matrix @ bearing.rows(system.layout) @ rest)[:3]
        assert abs(math.remainder(found[bearing.name] - math.atan2(z, x), 2 * math.pi)) < math.radians(0.5)


@pytest.mark.parametrize(
    ("on", "away", "warned"), [("outer-ring", 80, 0), ("outer-ring", 100, 1), ("inner-ring", 100, 0)]
)
def test_a_spall_outside_the_load_zone_is_named_with_an_angle_inside(on, away, warned):
    balls = {"bearings": {"model": "hertz", "designation": "6205"}}
    load = math.degrees(load_directions(make_drivetrain(load_scene("minimal", balls).scene))["bearing_1"])
    spall = {"kind": "bearing-spall", "shaft": 1, "bearing": 1, "on": on, "width_mm": 1.0, "depth_um": 50.0}
    loaded = load_scene("minimal", balls | {"faults": [spall | {"angle_deg": load - away}]})
    found = [one for one in design_warnings(loaded.scene, make_drivetrain(loaded.scene)) if "load zone" in one]
    assert len(found) == warned
    assert all(one.endswith(f"Set angle_deg = {load:.0f}") for one in found)
    assert f"load at {load:.0f} deg" in str(check_scene(loaded))


@pytest.mark.parametrize(("end", "warned"), [(0.6, True), (2.6, False)])
def test_a_window_that_does_not_resolve_the_pass_order_of_a_spall_is_named_before_the_run(end, warned):
    """2 BSF is 235.7 Hz, and 13 x shaft_2 is 235.3 Hz."""
    spall = {"kind": "bearing-spall", "shaft": 1, "bearing": 1, "on": "element", "width_mm": 1.0, "depth_um": 50.0}
    balls = {"bearings": {"model": "hertz", "designation": "6205"}, "faults": [spall]}
    drive = {"drive": {"times_s": [0.0, end], "speeds_rpm": [3000.0, 3000.0]}, "simulation.end_s": end}
    teeth = {"stages.1.pinion_teeth": 21, "stages.1.wheel_teeth": 58}
    loaded = load_scene("minimal", balls | drive | teeth | {"diagnosis.windows_s": {"lifting": [0.1, end]}})
    words = " ".join(design_warnings(loaded.scene, make_drivetrain(loaded.scene)))
    named = (
        "the pass order of the spall on the rolling element of bearing_1 is not examined: its pass frequency (235.67"
    )
    assert (named in words) == warned
    assert (" not separated from 13 x shaft_2 (235.34 Hz); the window has 0.5 s, 1.6 s are enough" in words) == warned


def test_a_machine_at_rest_has_signals_but_no_diagnosis():
    scene = load_scene("rig-healthy", {"drive.speeds_rpm": [0.0] * 6, "control": None}).scene
    assert scene.diagnosis.windows_s
    assert checked_machine(scene, "rest").diagnosis is None


def test_only_a_run_that_is_diagnosed_warns_of_its_diagnosis():
    loaded = load_scene("minimal", FAULT | {"control": None, "diagnosis.gear": "pinion"})
    plan = plan_run(loaded)
    more = set(scene_warnings(loaded, plan)) - set(scene_warnings(loaded, plan, diagnosed=False))
    assert len(more) == 2
    assert all("diagnos" in one for one in more)
