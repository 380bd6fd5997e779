"""Gear units in REXS: geometry of the two public files, frames and power flow, and the scene that is written."""

import math

import numpy as np
import pytest
from rexs_units import PLAIN, Document, Row, axes, json_text, packed, unit, xml

from pipelines.io.errors import InputError, SceneError
from pipelines.io.toml_text import read_toml
from pipelines.machine.checks.collisions import find_collisions
from pipelines.machine.layout import lay_out
from pipelines.machine.machine_conversion import make_drivetrain
from pipelines.rexs.files import read_document
from pipelines.rexs.gear_unit_reading import read_gear_unit
from pipelines.rexs.rexs_scene import new_scene_from_rexs
from pipelines.rexs.scene_text import scene_text
from pipelines.rexs.stage_tables import stage_table
from pipelines.runs.checked_scene import check_scene
from pipelines.scene.load_scene import load_scene, scene_of_tree

# Numbers of the public files, both Apache-2.0:
# api/src/test/resources/SEW_3-stage_cylindrical_gearbox_1.0.rexs of fva-net/rexs-api-java, and
# test/example_models/FVA-Industriegetriebe_2stufig_1-4.rexs of BearinxSimulationSuite/REXSapi.
SEW = (
    Row((23, 67), 1.0, 30.0, (16.0, 11.0), (0.581, 0.5131), 53.0, 117.47677801890632, (154.0, 156.5)),
    Row((13, 76), 1.25, -10.0, (23.0, 15.0), (0.521, -0.094), 57.0, 3.3310739238719993, (175.0, 177.5)),
    Row((14, 87), 1.5, 10.0, (41.0, 36.0), (0.536, -0.4815), 77.0, -115.77001197095069, (227.0, 227.0)),
)
SEW_AXES = (  # v and w of support_vector, mm
    (0.0, 0.0),
    (47.02148907341676, -24.45362069957225),
    (50.33350037591513, 32.45007497243242),
    (-19.008575782311063, -1.026431327759056),
)
FVA = (
    Row((27, 51), 4.5, 21.0, (50.0, 50.0), (0.231415, 0.231415), 190.0, 180.0, (47.0, 47.0)),
    Row((23, 34), 6.5, -10.0, (74.0, 74.0), (0.15074, 0.15074), 190.0, 0.0, (155.0, 155.0)),
)
FVA_AXES = ((0.0, 0.0), (0.0, -190.0), (0.0, 0.0))
UNITS = {
    "SEW": {"rows": SEW, "speed": 1400.0, "torque": 4.724562306435156, "lengths": (100.0, 300.0), "diameter": 8.0},
    "FVA": {"rows": FVA, "speed": 1234.0, "torque": 456.0, "lengths": (-20.0, 240.0), "diameter": 60.0},
}


def drawn(layout):
    """Torque of the load, N m."""
    return layout.resisting_torques[layout.loaded]


@pytest.fixture
def written(tmp_path):
    """The path of a document as a file."""

    def write(document, name="box.rexs"):
        path = tmp_path / name
        path.write_text(xml(document) if isinstance(document, Document) else document, encoding="utf-8")
        return path

    return write


@pytest.fixture
def scene_of(written):
    """Text and tree of the scene of a document."""

    def make(document):
        made = scene_text(read_gear_unit(read_document(written(document))), "box")
        return made, read_toml(made.text)

    return make


@pytest.mark.parametrize("name", UNITS)
def test_profile_shifts_of_the_public_units_give_their_centre_distances(written, name):
    gears = read_gear_unit(read_document(written(unit(**UNITS[name]))))
    for number, row in enumerate(UNITS[name]["rows"], 1):
        pair = stage_table(gears, number, [])[1]
        tight = type(pair)(pinion=pair.pinion, wheel=pair.wheel)
        assert 1000 * tight.axis_distance == pytest.approx(row.distance, rel=2e-6)


@pytest.mark.parametrize(("name", "places"), [("SEW", SEW_AXES), ("FVA", FVA_AXES)])
def test_shafts_of_the_public_units_lie_where_their_files_say(scene_of, name, places):
    """x is -v, z is w, the first shaft is the origin."""
    _, tree = scene_of(unit(**UNITS[name]))
    layout = lay_out(scene_of_tree(tree).scene)
    for (x, z), (v, w) in zip(layout.axes, places, strict=True):
        assert (1000 * x, 1000 * z) == pytest.approx((-v, w), abs=1e-6)


def test_the_output_torque_of_the_sew_unit_is_its_rated_one(scene_of):
    """4.7246 N m at the input are 500 N m at the output."""
    _, tree = scene_of(unit(**UNITS["SEW"]))
    assert drawn(lay_out(scene_of_tree(tree).scene)) == pytest.approx(500.0, rel=1e-5)


@pytest.mark.parametrize(("name", "number"), [("SEW", 1), ("SEW", 2), ("SEW", 3), ("FVA", 1), ("FVA", 2)])
def test_derived_dimensions_follow_iso_21771(written, name, number):
    """Written down here once more; undercut is left to the pair itself."""
    row = UNITS[name]["rows"][number - 1]
    pair = stage_table(read_gear_unit(read_document(written(unit(**UNITS[name])))), number, [])[1]
    beta, alpha_n, m = math.radians(row.helix), math.radians(20.0), row.module
    alpha_t = math.atan(math.tan(alpha_n) / math.cos(beta))
    d = [z * m / math.cos(beta) for z in row.teeth]
    d_b = [one * math.cos(alpha_t) for one in d]
    shortening = row.distance - sum(d) / 2 - m * sum(row.shifts)
    d_a = [one + 2 * m * (1 + x) + 2 * shortening for one, x in zip(d, row.shifts, strict=True)]
    d_f = [one - 2 * m * (1.25 - x) for one, x in zip(d, row.shifts, strict=True)]
    alpha_wt = math.acos(sum(d_b) / 2 / row.distance)
    path = sum(math.sqrt((a / 2) ** 2 - (b / 2) ** 2) for a, b in zip(d_a, d_b, strict=True))
    pitch = math.pi * d_b[0] / row.teeth[0]
    width = min(row.middles[0] + row.widths[0] / 2, row.middles[1] + row.widths[1] / 2)
    width -= max(row.middles[0] - row.widths[0] / 2, row.middles[1] - row.widths[1] / 2)
    for gear, place in ((pair.pinion, 0), (pair.wheel, 1)):
        found = [2000 * r for r in (gear.reference_radius, gear.tip_radius, gear.root_radius, gear.base_radius)]
        assert found == pytest.approx([d[place], d_a[place], d_f[place], d_b[place]], rel=1e-9)
    assert pair.working_pressure_angle == pytest.approx(alpha_wt, rel=1e-9)
    assert pair.overlap_ratio == pytest.approx(width * abs(math.sin(beta)) / (math.pi * m), rel=1e-9)
    if not any(pair.shortened_by_undercut):
        ratio = (path - row.distance * math.sin(alpha_wt)) / pitch
        assert pair.transverse_contact_ratio == pytest.approx(ratio, rel=1e-9)


def test_given_tip_and_root_circles_are_kept(written):
    document = unit().changed("cylindrical_gear", {"tip_diameter": (48.1, "mm"), "root_diameter": (38.2, "mm")})
    pinion = stage_table(read_gear_unit(read_document(written(document))), 1, [])[1].pinion
    assert (2000 * pinion.tip_radius, 2000 * pinion.root_radius) == pytest.approx((48.1, 38.2))


def test_a_tip_diameter_that_is_no_tip_circle_is_named_and_not_taken(scene_of):
    """The FVA file has 1 mm at a gear of module 6.5."""
    made, tree = scene_of(unit().changed("cylindrical_gear", {"tip_diameter": (1.0, "mm")}))
    assert "tip_diameter = 1 mm of the file is no tip circle" in made.text.replace("\n#   ", " ")
    assert tree["stages"][0]["pinion"]["tip_alteration_mm"] == tree["stages"][0]["wheel"]["tip_alteration_mm"]


def test_xml_json_and_zip_hold_the_same_document(tmp_path):
    document = unit()
    files = {"a.rexs": xml(document).encode(), "b.rexsj": json_text(document).encode()}
    files |= {"c.rexsz": packed("model.rexs", xml(document)), "d.rexsz": packed("model.rexsj", json_text(document))}
    texts = []
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
        text = scene_text(read_gear_unit(read_document(tmp_path / name)), "box").text
        texts.append(text.replace(str(tmp_path / name), "file"))
    assert texts[1:] == texts[:1] * 3


def test_a_unit_turned_in_space_gives_the_same_scene(scene_of):
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    _, wanted = scene_of(unit())
    _, found = scene_of(unit().turned(rotation))
    for one, other in zip(found["stages"], wanted["stages"], strict=True):
        for key in ("direction_deg", "position_mm", "face_width_mm"):
            assert one[key] == pytest.approx(other[key], rel=1e-9)
    for one, other in zip(found["shafts"], wanted["shafts"], strict=True):
        assert one["bearing_positions_mm"] == pytest.approx(other["bearing_positions_mm"], rel=1e-9)


def test_a_shaft_whose_own_axis_points_backwards_gives_the_same_scene(scene_of):
    """Shaft 2 from its other end: its sections and bearings are symmetric, so only its frame changes."""
    _, wanted = scene_of(unit())
    v, w = axes(PLAIN)[1]
    turned = {"support_vector": ([160.0, v, w], "mm"), "u_axis_vector": ([-1.0, 0.0, 0.0], "mm")}
    _, found = scene_of(unit().changed("shaft", turned, 1))
    assert found["shafts"] == wanted["shafts"]
    assert found["stages"] == wanted["stages"]


BACKWARDS = np.diag([-1.0, -1.0, 1.0])  # axes u, v, w of a shaft that points against the others


def backwards(document):
    """Shaft 2 with its origin at its other end; its sections and the places of its bearings are symmetric."""
    place = {"support_vector": ([160.0, *axes(PLAIN)[1]], "mm"), "u_axis_vector": ([-1.0, 0.0, 0.0], "mm")}
    return document.changed("shaft", place, 1)


def numbers(document, kind):
    return [number for number, (one, *_) in document.components.items() if one == kind]


def test_the_thrust_of_a_bearing_has_the_direction_of_its_shaft(written):
    """The bearing at y = 10 mm of shaft 2 takes thrust along +y: along +u at u = 10, or along -u at u = 150 mm."""
    kind = "rolling_bearing_with_catalog_geometry"
    found = [
        read_gear_unit(read_document(written(document))).shafts[1].bearings
        for document in (
            unit().changed(kind, {"axial_force_absorption": "positive"}, 2),
            backwards(unit()).changed(kind, {"axial_force_absorption": "negative"}, 3),
        )
    ]
    directions = [{bearing.y: bearing.axial for bearing in bearings} for bearings in found]
    assert directions == [{10.0: "positive", 150.0: "both_directions"}] * 2


def test_the_speed_of_a_shaft_has_the_direction_of_its_axis(scene_of):
    """Of shaft 2, forwards and from its other end."""
    speed = {"rotational_speed": (-400.0, "1 / min"), "defines_speed": True}
    _, wanted = scene_of(unit(speed=None).changed("shaft", speed, 1))
    speed["rotational_speed"] = (400.0, "1 / min")
    _, found = scene_of(backwards(unit(speed=None)).changed("shaft", speed, 1))
    assert found["drive"] == wanted["drive"]
    assert found["stages"] == wanted["stages"]
    _, other = scene_of(unit(speed=None).changed("shaft", speed, 1))
    assert other["stages"] != wanted["stages"]


def test_places_relative_to_a_shaft_that_points_backwards_give_the_same_scene(scene_of):
    """Shaft 3 is given in the frame of shaft 2, the pinion on it in that of shaft 3."""
    kind = "rolling_bearing_with_catalog_geometry"
    positive = {"axial_force_absorption": "positive"}
    whole = unit().changed(kind, positive, 4)
    _, wanted = scene_of(whole)
    second, third = ([x, *place] for x, place in zip((160.0, 0.0), axes(PLAIN)[1:], strict=True))
    one, two = numbers(whole, "shaft")[1:]
    placed = {
        "support_vector": (list(BACKWARDS @ np.subtract(third, second)), "mm"),
        "u_axis_vector": ([-1.0, 0.0, 0.0], "mm"),
        "reference_component_for_position": one,
    }
    on_it = {"support_vector": ([110.0, 0.0, 0.0], "mm"), "reference_component_for_position": two}
    document = backwards(whole).changed("shaft", placed, 2).changed("cylindrical_gear", on_it, 3)
    made, found = scene_of(document)
    assert found["shafts"] == wanted["shafts"]
    assert any("positive direction only" in note.reason for note in made.notes)
    for one, other in zip(found["stages"], wanted["stages"], strict=True):
        assert one["position_mm"] == pytest.approx(other["position_mm"])
        assert one["direction_deg"] == pytest.approx(other["direction_deg"])


def test_an_input_that_turns_backwards_reverses_the_frame(scene_of):
    """A half turn about z keeps hands, and makes the speed positive."""
    _, wanted = scene_of(unit())
    _, found = scene_of(unit(speed=-1200.0, torque=-60.0))
    assert found["drive"] == wanted["drive"]
    for one, other in zip(found["stages"], wanted["stages"], strict=True):
        assert one["position_mm"] == -other["position_mm"]
        assert one["pinion_hand"] == other["pinion_hand"]
        directions = [math.radians(table["direction_deg"]) for table in (one, other)]
        assert math.cos(directions[0]) == pytest.approx(-math.cos(directions[1]))
        assert math.sin(directions[0]) == pytest.approx(math.sin(directions[1]))


def test_negative_power_makes_a_shaft_the_output(scene_of):
    """The same file with a braking torque: power goes the other way through every pair."""
    _, found = scene_of(unit(torque=-60.0))
    assert [one["pinion_teeth"] for one in found["stages"]] == [44, 61]
    layout = lay_out(scene_of_tree(found).scene)
    assert drawn(layout) == pytest.approx(60.0)
    assert layout.turns == pytest.approx(1200 / 60 * 20 * 19 / (61 * 44))


def test_a_torque_at_the_output_is_that_at_the_input_over_the_ratio(scene_of):
    ratio = 61 * 44 / (20 * 19)
    document = unit(torque=None).changed("external_load", {"torque_around_u_axis": (-60.0 * ratio, "N m")}, 1)
    document = document.changed("external_load", {"torque_around_u_axis": None}, 0)
    _, found = scene_of(document)
    assert drawn(lay_out(scene_of_tree(found).scene)) == pytest.approx(60.0 * ratio)
    assert found["stages"] == scene_of(unit())[1]["stages"]


def test_the_most_frequent_load_case_is_taken_and_the_others_are_listed(scene_of):
    document = unit(torque=None, speed=None)
    number = {one[1]: n for n, one in document.components.items()}
    load = next(n for n, one in document.components.items() if one[0] == "external_load")
    for case, (share, speed, torque) in enumerate([(20, 543.0, 567.0), (80, 3456.0, 34.5)], 1):
        document.cases[case] = {
            number["unit"]: {"load_duration_fraction": (float(share), "%")},
            number["shaft 1"]: {"rotational_speed": (speed, "1 / min")},
            load: {"torque_around_u_axis": (torque, "N m")},
        }
    made, tree = scene_of(document)
    assert tree["drive"]["speeds_rpm"] == [0.0, 3456.0, 3456.0]
    assert "# load case 1 (20 % of the time): 543 rpm, 567 N m at the input" in made.text


def test_speed_and_torque_that_the_file_lacks_are_left_to_the_user(written, tmp_path):
    path, made = new_scene_from_rexs(tmp_path / "my.toml", written(unit(speed=None, torque=None)))
    assert set(made.missing) == {"drive.speeds_rpm", "load.torque_N_m"}
    with pytest.raises(SceneError, match=r"(?s)drive\.speeds_rpm.*load: has no torque. Set torque_N_m"):
        load_scene(path)


def test_the_scene_passes_the_check_without_a_change(written, tmp_path):
    path, _ = new_scene_from_rexs(tmp_path / "my.toml", written(unit()))
    found = check_scene(load_scene(str(path)))
    assert found.machine.facts.total_ratio == pytest.approx(61 * 44 / (20 * 19))
    assert found.warnings == ()


def test_every_note_stands_in_the_scene(scene_of):
    made, _ = scene_of(unit().added("lubricant", "oil"))
    text = made.text.replace("\n#   ", " ")
    assert len(made.notes) > 10
    for note in made.notes:
        assert f"- {note.where}" in text
        assert note.reason in text


def test_faces_that_overlap_in_part_mesh_in_their_common_part(scene_of):
    rows = (Row(**{**vars(PLAIN[0]), "middles": (48.0, 52.0)}), PLAIN[1])
    made, tree = scene_of(unit(rows))
    assert tree["stages"][0]["face_width_mm"] == pytest.approx(17.0)  # 42 to 59
    assert tree["stages"][0]["position_mm"] == pytest.approx(50.5)
    assert "the pinion is 22 mm wide" in made.text


def test_a_conical_stretch_becomes_steps_of_its_mean_diameters(scene_of):
    made, tree = scene_of(unit().changed("shaft_section", {"outer_diameter_end": (24.0, "mm")}))
    sections = tree["shafts"][0]["sections"]
    assert [one["diameter_mm"] for one in sections] == [20.5, 21.5, 22.5, 23.5]
    assert [sections[0]["start_mm"], sections[-1]["end_mm"]] == [0.0, 160.0]
    assert "conical; a scene has cylinders" in made.text


def test_a_file_is_never_overwritten(written, tmp_path):
    new_scene_from_rexs(tmp_path / "my.toml", written(unit()))
    with pytest.raises(InputError, match="exists already"):
        new_scene_from_rexs(tmp_path / "my.toml", written(unit()))


@pytest.mark.parametrize(("diameter", "clash"), [(50.0, False), (60.0, True)])
def test_a_shaft_inside_the_bore_of_a_gear_on_its_axis_is_no_collision(scene_of, diameter, clash):
    """The FVA unit is coaxial: its input ends inside its hollow output shaft, whose gear has a bore of 60 mm."""
    size = {f"outer_diameter_{end}": (diameter, "mm") for end in ("begin", "end")}
    _, tree = scene_of(unit(**UNITS["FVA"]).changed("shaft_section", size))
    scene = scene_of_tree(tree).scene
    found = [
        problem for problem in find_collisions(scene, make_drivetrain(scene)) if "stage 2 wheel" in problem.message
    ]
    assert any("intersects the section of shaft 1 " in problem.message for problem in found) is clash
