"""Stated deviations of gears: the error of the mesh that they make, measured flanks from files, refusals."""

import csv
import math

import numpy as np
import pytest
import xarray

from benchmarks.gear_pairs import gear_pair
from fem.contact.deviating_teeth import deviating_law
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.faults.changed_law import damaged_law
from fem.contact.faults.worn_tooth import WornTooth
from fem.contact.models.iso import Iso
from fem.contact.teeth import tooth_terms, with_variants
from fem.gears.flank_deviations import sample_flank_deviations
from fem.gears.gear_checks import GeometryError
from fem.gears.path import path_points
from fem.gears.prescribed import (
    Eccentricity,
    MeasuredFlanks,
    PrescribedDeviations,
    ToothError,
    Wave,
    check_prescribed,
    single_tooth_terms,
)
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.checks.design_warnings import design_warnings
from pipelines.machine.machine_conversion import make_drivetrain, make_machine
from pipelines.machine.scene_flanks import prescribed_deviations
from pipelines.machine.system_assembly import assemble_machine
from pipelines.scene.load_scene import control_of, load_scene
from pipelines.scene.measured_flanks import measured_flanks

FLANKS = {"drive": 0, "coast": 1}
PAIRS = {
    "spur": gear_pair((20, 55), 2, 0, 20, bores_mm=(12.5, 17.5)),
    "right": gear_pair((20, 55), 2, 15, 20, bores_mm=(12.5, 17.5)),
    "left": gear_pair((20, 55), 2, 15, 20, bores_mm=(12.5, 17.5), hands=("left", "right")),
}
each_flank = pytest.mark.parametrize(
    ("name", "gear", "flank"),
    [(name, gear, flank) for name in PAIRS for gear in ("pinion", "wheel") for flank in FLANKS],
)


@pytest.fixture(scope="module")
def laws():
    return {name: Iso(slices=9).laws(pair) for name, pair in PAIRS.items()}


def revolution(law, pair, gear, given, points=1024):
    """Rotation of the gear (rad) and no-load error (m) over one revolution."""
    teeth = getattr(pair, gear).teeth
    deviating, terms = deviating_law(law, pair, gear, np.zeros(teeth), given)
    cycle = np.arange(points) * teeth / points
    return 2 * np.pi * cycle / teeth, LawEvaluator(deviating).no_load(cycle, **{gear: terms})


def line_of_action(pair, flank):
    """Unit vector of the force on the wheel, x from pinion to wheel; the pinion turns from x to y."""
    alpha = pair.working_pressure_angle
    return np.array([math.sin(alpha), math.cos(alpha) if flank == "drive" else -math.cos(alpha)])


@each_flank
def test_eccentricity_moves_the_error_by_its_part_along_the_line_of_action(laws, name, gear, flank):
    """The axis of the teeth circles about the shaft: tooth 0 of the pinion points to +x at c = 0, the wheel's to -x."""
    pair, amount, angle = PAIRS[name], 25e-6, 0.8
    given = PrescribedDeviations(eccentricity=Eccentricity(amount=amount, angle=angle))
    turned, error = revolution(laws[name][FLANKS[flank]], pair, gear, given)
    ahead = turned + angle
    if gear == "pinion":
        moved = amount * np.array([np.cos(ahead), np.sin(ahead)])
        expected = -line_of_action(pair, flank) @ moved
    else:
        moved = amount * np.array([-np.cos(ahead), np.sin(ahead)])
        expected = line_of_action(pair, flank) @ moved
    assert error == pytest.approx(expected, abs=1e-3 * amount)
    assert np.ptp(error) / 2 == pytest.approx(amount, rel=1e-3)


def test_eccentricity_is_seen_under_load_too(laws):
    pair, law, amount = PAIRS["right"], laws["right"][0], 12e-6
    given = PrescribedDeviations(eccentricity=Eccentricity(amount=amount))
    deviating, terms = deviating_law(law, pair, "pinion", np.zeros(20), given)
    cycle = np.arange(200) * 0.1
    error = LawEvaluator(deviating).approach_at(2000.0, cycle, pinion=terms)
    once = abs(np.fft.fft(error - LawEvaluator(law).approach_at(2000.0, cycle))[1]) * 2 / cycle.size
    assert once == pytest.approx(amount, rel=0.01)


@each_flank
def test_waves_give_ghost_orders(laws, name, gear, flank):
    """A crest is material: the error is the wave turned over, at its own order and no other."""
    pair, order, phase = PAIRS[name], 47, 0.6
    given = PrescribedDeviations(waves=(Wave(order=order, amplitude=1e-6, phase=phase),))
    error = revolution(laws[name][FLANKS[flank]], pair, gear, given)[1]
    lines = np.fft.rfft(error) * 2 / error.size
    assert lines[order] == pytest.approx(-1e-6 * np.exp(1j * phase), abs=2e-9)
    lines[order] = 0.0
    assert np.abs(lines).max() < 5e-9


def test_a_wave_stays_on_its_flank(laws):
    given = PrescribedDeviations(waves=(Wave(order=30, amplitude=1e-6, flank="coast"),))
    drive, coast = (revolution(law, PAIRS["spur"], "wheel", given)[1] for law in laws["spur"])
    assert drive == pytest.approx(0.0, abs=1e-15)
    assert np.ptp(coast) == pytest.approx(2e-6, rel=0.01)


@pytest.mark.parametrize(("gear", "tooth"), [("pinion", 3), ("wheel", 17)])
def test_a_pitch_error_moves_one_tooth(gear, tooth):
    """More material touches earlier, by the error along the line of action."""
    pair = PAIRS["right"]
    given = PrescribedDeviations(teeth=(ToothError(tooth=tooth, pitch=10e-6),))
    clearance, slope = single_tooth_terms(pair, gear, "drive", given)
    own = getattr(pair, gear)
    assert clearance[tooth] == pytest.approx(-10e-6 * math.cos(own.transverse_pressure_angle))
    assert np.flatnonzero(clearance).tolist() == [tooth]
    assert not slope.any()
    assert not single_tooth_terms(pair, gear, "coast", given)[0].any()


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_a_profile_slope_adds_material_towards_the_tip(gear):
    pair = PAIRS["spur"]
    given = PrescribedDeviations(teeth=(ToothError(tooth=2, profile_slope=8e-6),))
    clearance, slope = single_tooth_terms(pair, gear, "drive", given)
    ends = [clearance[2] + slope[2] * xi for xi in (pair.xi_start, pair.xi_end)]
    at_tip, at_root = reversed(ends) if gear == "pinion" else ends
    assert (at_tip, at_root) == pytest.approx((-4e-6, 4e-6))


def test_damage_keeps_its_place_on_a_deviating_gear(laws):
    pair = PAIRS["right"]
    worn = damaged_law(laws["right"][0], pair, "wheel", [WornTooth(depth=6e-6)])
    terms = tooth_terms(55, variant=np.arange(55) == 4)
    given = PrescribedDeviations(eccentricity=Eccentricity(amount=9e-6))
    both, called = deviating_law(worn, pair, "wheel", terms, given)
    alone, others = deviating_law(laws["right"][0], pair, "wheel", np.zeros(55), given)
    plain = alone.wheel_variant_gap[others[:, -1].astype(int) - 1]
    assert (plain >= 0.0).all()
    gaps = both.wheel_variant_gap[called[:, -1].astype(int) - 1] - plain
    assert gaps[4] == pytest.approx(6e-6)
    assert np.delete(gaps, 4, axis=0) == pytest.approx(0.0, abs=1e-18)


def seeded_file(path, pair, gear, terms):
    """The seeded deviations of both flanks at points of the flanks, as a measuring machine would write them."""
    xi = np.linspace(pair.xi_start, pair.xi_end, 41)
    points = path_points(pair, xi)
    radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
    face = np.linspace(-0.5, 0.5, 21)
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["tooth", "flank", "diameter_mm", "position_mm", "deviation_um"])
        for flank, given in terms.items():
            for tooth in range(len(given)):
                h, a1, a2, b1, b2, _ = given[tooth]
                for r, x in zip(radius, xi, strict=True):
                    for v in face:
                        gap = h + a1 * x + a2 * x**2 + b1 * v + b2 * v**2
                        rows.writerow([tooth, flank, 2e3 * r, 1e3 * v * pair.face_width, -1e6 * gap])


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_a_file_of_seeded_deviations_gives_their_law(laws, tmp_path, gear):
    pair, file = PAIRS["right"], tmp_path / "flanks.csv"
    teeth = getattr(pair, gear).teeth
    seeded = {flank: tooth_terms(teeth, **one) for flank, one in sample_flank_deviations(pair, gear, 6, 3).items()}
    seeded_file(file, pair, gear, seeded)
    given = PrescribedDeviations(measured=measured_flanks(str(file), "here", 1))
    cycle = np.linspace(0.0, 9.0, 60)
    for flank, law in zip(FLANKS, laws["right"], strict=True):
        deviating, terms = deviating_law(law, pair, gear, np.zeros(teeth), given)
        found = LawEvaluator(deviating).approach_at(3000.0, cycle, **{gear: terms})
        wanted = LawEvaluator(law).approach_at(3000.0, cycle, **{gear: seeded[flank]})
        sound = LawEvaluator(law).approach_at(3000.0, cycle)
        assert np.ptp(wanted - sound) > 1e-6
        off = np.abs(found - wanted) / np.ptp(wanted - sound)
        assert np.quantile(off, 0.9) < 0.01
        assert off.max() < 0.15  # tip edges: the file holds its last points there, seeded terms go on


def test_netcdf_and_csv_say_the_same_and_turn_with_the_shaft(tmp_path):
    values = np.arange(2 * 2 * 3 * 2, dtype=float).reshape(2, 2, 3, 2)
    data = xarray.DataArray(
        values,
        dims=("flank", "tooth", "diameter_mm", "position_mm"),
        coords={
            "flank": ["drive", "coast"],
            "tooth": [4, 5],
            "diameter_mm": [38.0, 40.0, 42.0],
            "position_mm": [-5, 8],
        },
        name="deviation_um",
    )
    data.to_netcdf(tmp_path / "flanks.nc", engine="h5netcdf")
    with (tmp_path / "flanks.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["tooth", "flank", "diameter_mm", "position_mm", "deviation_um"])
        for (f, t, d, p), value in np.ndenumerate(values):
            rows.writerow([(4, 5)[t], ("drive", "coast")[f], (38, 40, 42)[d], (-5, 8)[p], value])
    first, second = (measured_flanks(str(tmp_path / f"flanks.{end}"), "here", 1) for end in ("nc", "csv"))
    for one in (first, second):
        assert one.tooth.tolist() == [4, 5]
        assert one.radius == pytest.approx([0.019, 0.02, 0.021])
        assert one.face == pytest.approx([-0.005, 0.008])
        assert one.deviation == pytest.approx(values / 1e6)
    turned = measured_flanks(str(tmp_path / "flanks.csv"), "here", -1)
    assert turned.face == pytest.approx([-0.008, 0.005])
    assert turned.deviation == pytest.approx(values[..., ::-1] / 1e6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n", "the columns are a, b"),
        ("tooth,flank,diameter_mm,position_mm,deviation_um\n", "no points"),
        ("tooth,flank,diameter_mm,position_mm,deviation_um\n1,left,40,0,1\n", "line 2: flank is left"),
        (
            "tooth,flank,diameter_mm,position_mm,deviation_um\n1,drive,x,0,1\n",
            "column diameter_mm: x is not a number",
        ),
        ("tooth,flank,diameter_mm,position_mm,deviation_um\n1,drive,40,0,1\n1,drive,40,0,2\n", "is there twice"),
        ("tooth,flank,diameter_mm,position_mm,deviation_um\n1,drive,40,0,1\n1,drive,41,2,2\n", "2 of 4 points"),
        (
            "tooth,flank,diameter_mm,position_mm,deviation_um\n1.5,drive,40,0,1\n",
            "tooth must increase; teeth must be whole numbers",
        ),
    ],
)
def test_files_that_do_not_fit_are_refused_by_line(tmp_path, text, message):
    file = tmp_path / "flanks.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError, match=message):
        measured_flanks(str(file), "stages.1.wheel.deviations.flanks", 1)
    with pytest.raises(SceneError, match="no such file"):
        measured_flanks(str(tmp_path / "none.csv"), "here", 1)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (PrescribedDeviations(eccentricity=Eccentricity(amount=1e-3)), "eccentricity is 1000 um"),
        (PrescribedDeviations(waves=(Wave(order=161, amplitude=1e-6),)), "Set 1 to 160"),
        (PrescribedDeviations(teeth=(ToothError(tooth=20, pitch=1e-6),)), "there is no tooth 20"),
        (PrescribedDeviations(teeth=(ToothError(tooth=2, pitch=-3e-4),)), "pitch of tooth 2"),
        (
            PrescribedDeviations(
                measured=MeasuredFlanks(
                    tooth=np.array([1]),
                    radius=np.array([0.02]),
                    face=np.zeros(1),
                    deviation=np.full((2, 1, 1, 1), 3e-4),
                )
            ),
            "largest measured deviation",
        ),
    ],
)
def test_absurd_deviations_are_refused(given, message):
    with pytest.raises(GeometryError, match=message):
        check_prescribed(PAIRS["spur"].pinion, given, 64)


STATED = (
    "stages.1.wheel.deviations.eccentricity_um=20",
    "stages.1.wheel.deviations.eccentricity_angle_deg=90",
    'stages.1.pinion.deviations.waves=[{order = 33, amplitude_um = 0.5, phase_deg = 180, flank = "drive"}]',
    'stages.1.pinion.deviations.teeth=[{tooth = 5, flank = "coast", pitch_um = 7}]',
)


def test_stated_deviations_of_a_scene_reach_the_meshes(laws):
    scene = load_scene("minimal", STATED).scene
    wheel, pinion = (prescribed_deviations(scene.stages[0], 1, gear, 1) for gear in ("wheel", "pinion"))
    assert wheel.eccentricity == Eccentricity(amount=20e-6, angle=math.pi / 2)
    assert pinion.waves == (Wave(order=33, amplitude=0.5e-6, phase=math.pi, flank="drive"),)
    assert pinion.teeth == (ToothError(tooth=5, pitch=7e-6, flank="coast"),)
    machine = make_machine(scene)
    pair = machine.parts.meshes[0].pair
    mesh = assemble_machine(machine.parts, [Iso(slices=5).laws(pair)]).meshes[0]
    assert len(mesh.drive.wheel_variant_gap) == len(mesh.coast.wheel_variant_gap) == pair.wheel.teeth
    assert (len(mesh.drive.pinion_variant_gap), len(mesh.coast.pinion_variant_gap)) == (pair.pinion.teeth, 0)
    plain = make_machine(load_scene("minimal").scene)
    healthy = assemble_machine(plain.parts, [Iso(slices=5).laws(pair)]).meshes[0]
    moved = mesh.coast_clearance_pinion[:, 0] - healthy.coast_clearance_pinion[:, 0]
    assert moved[5] == pytest.approx(-7e-6 * math.cos(pair.pinion.transverse_pressure_angle))
    assert np.delete(moved, 5) == pytest.approx(0.0, abs=1e-18)


def test_stated_deviations_stay_in_the_healthy_control_and_leave_with_all_others():
    bench = load_scene("bench", STATED[:1])
    control = control_of(bench)
    assert not control.scene.faults
    assert control.scene.stages[0].wheel.deviations.eccentricity_um == 20
    off = load_scene("bench", (*STATED[:1], "deviations.enabled=false")).scene
    assert make_machine(off).parts.meshes[0].wheel.prescribed is None
    assert any("these keys have no effect" in text for text in design_warnings(off, make_drivetrain(off)))


def test_what_no_gear_has_is_refused_or_questioned_with_its_place():
    with pytest.raises(SceneError, match=r"stages\.1\.wheel\.deviations.*eccentricity is 900 um"):
        checked_machine(load_scene("minimal", ("stages.1.wheel.deviations.eccentricity_um=900",)).scene, "minimal")
    with pytest.raises(SceneError, match=r"stages\.1\.pinion\.deviations\.flanks\.file.*no such file"):
        checked_machine(load_scene("minimal", ('stages.1.pinion.deviations.flanks.file="none.csv"',)).scene, "minimal")
    rough = load_scene("minimal", ("stages.1.wheel.deviations.eccentricity_um=190",)).scene
    assert any("if the unit is wrong" in text for text in design_warnings(rough, make_drivetrain(rough)))


def test_a_cracked_tooth_of_an_eccentric_gear_keeps_the_modes_of_its_crack(laws):
    pair, law = PAIRS["right"], laws["right"][0]
    modes = np.random.default_rng(2).uniform(0.0, 1e-6, (2, 3, law.face_coordinate.size, law.compliance.size))
    cracked = with_variants(law, "wheel", 0.0, 0.0, modes)
    given = PrescribedDeviations(eccentricity=Eccentricity(amount=5e-6))
    terms = tooth_terms(pair.wheel.teeth, variant=np.arange(pair.wheel.teeth) == 7)
    deviating, terms = deviating_law(cracked, pair, "wheel", terms, given)
    of_teeth = deviating.wheel_variant_modes[terms[:, -1].astype(int) - 1]
    np.testing.assert_array_equal(of_teeth[7], modes)
    assert not np.delete(of_teeth, 7, axis=0).any()
