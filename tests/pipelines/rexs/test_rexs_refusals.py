"""What of a REXS file is refused, in words; and bearings by designation, by rolling elements, by dimensions."""

import math

import pytest
from rexs_units import PLAIN, Row, packed, unit, xml

import gearcase
from mbd.parts.rolling_elements import RollingElements
from pipelines.cli.main import main
from pipelines.io.errors import InputError
from pipelines.machine.layout import lay_out
from pipelines.machine.scene_bearings import rolling_bearings
from pipelines.rexs import files
from pipelines.rexs.document import RexsError
from pipelines.rexs.files import read_document
from pipelines.rexs.rexs_scene import new_scene_from_rexs
from pipelines.scene.load_scene import load_scene

CATALOGUE = "rolling_bearing_with_catalog_geometry"


SHAFTS = [number for number, one in unit().components.items() if one[0] == "shaft"]
ENDS = ("begin", "end")


@pytest.fixture
def imported(tmp_path):
    """What reading a document gives, and the scene that it wrote."""

    def make(document):
        path = tmp_path / "box.rexs"
        path.write_text(xml(document), encoding="utf-8")
        (tmp_path / "my.toml").unlink(missing_ok=True)
        target, made = new_scene_from_rexs(tmp_path / "my.toml", path)
        return made, load_scene(str(target)).scene

    return make


def row_with(**changes):
    return (Row(**{**vars(PLAIN[0]), **changes}), PLAIN[1])


def with_second_section(start):
    """The plain unit with a further section on its first shaft."""
    document = unit()
    size = {f"{side}_diameter_{end}": (20.0 * (side == "outer"), "mm") for side in ("outer", "inner") for end in ENDS}
    document = document.added("shaft_section", u_coordinate_on_shaft=(start, "mm"), length=(10.0, "mm"), **size)
    document.relations.append(("assembly", {"assembly": SHAFTS[0], "part": max(document.components)}))
    return document


UNFIT = {  # a document, and the words that refuse it
    "planets": (unit().added("planetary_stage", "P1"), "P1 .*planets and turning carriers are not modelled"),
    "internal gear": (unit().added("ring_gear"), "internal gears are not modelled"),
    "bevel gear": (unit().added("bevel_gear"), "shafts must be parallel"),
    "coupling": (unit().added("coupling"), r"write \[\[couplings\]\] into the scene"),
    "crossed shafts": (
        unit().changed("shaft", {"u_axis_vector": ([0.0, 1.0, 0.0], "mm")}, 1),
        "shaft 2 .*not parallel to that of the first shaft",
    ),
    "skew frame": (unit().changed("shaft", {"w_axis_vector": ([1.0, 0.0, 1.0], "mm")}), "not perpendicular"),
    "no place": (unit().changed("shaft", {"support_vector": None}, 2), "shaft 3 .*has no place"),
    "short vector": (
        unit().changed("shaft", {"support_vector": ([0.0, 1.0], "mm")}),
        "has 2 numbers, and must have 3 finite ones",
    ),
    "circle of places": (
        unit()
        .changed("shaft", {"reference_component_for_position": SHAFTS[1]})
        .changed("shaft", {"reference_component_for_position": SHAFTS[0]}, 1),
        "refers in a circle to itself",
    ),
    "unit of something else": (
        unit().changed("cylindrical_gear", {"face_width": (20.0, "N m")}),
        'face_width has the unit "N m" instead of one like "mm"',
    ),
    "not a number": (unit().changed("shaft_section", {"length": ("long", "mm")}), 'length = "long" is not a finite'),
    "infinite": (unit().changed("shaft_section", {"length": ("inf", "mm")}), "not a finite number"),
    "missing": (unit().changed("cylindrical_gear", {"normal_module": None}), "normal_module is missing"),
    "other module": (unit().changed("cylindrical_gear", {"normal_module": (3.0, "mm")}), "normal_module is 3 at"),
    "same hands": (
        unit().changed("cylindrical_gear", {"helix_angle_reference_diameter": (20.0, "deg")}, 1),
        "helix_angle_reference_diameter is 20 at .* and 20 at .*opposite helices",
    ),
    "unlike flanks": (
        unit().changed("cylindrical_gear_flank", {"addendum_modification_coefficient": 0.3}),
        "is 0.3 on the left flank and 0.2 on the right one",
    ),
    "faces apart": (unit(row_with(middles=(20.0, 90.0))), "do not overlap along the shafts"),
    "axes apart": (
        unit().changed("cylindrical_stage", {"center_distance": (90.0, "mm")}),
        "center_distance is 90 mm, but the axes .* are at a distance of 86.6",
    ),
    "jammed": (unit(row_with(distance=86.0)), "stage 1 .*the teeth jam"),
    "gear off its shaft": (unit().changed("shaft_section", {"length": (20.0, "mm")}), "its middle, y = .* is not on"),
    "gap in a shaft": (with_second_section(165.0), "a section ends at y = 160 mm, the next starts at 165 mm"),
    "sections that overlap": (with_second_section(155.0), "a section ends at y = 160 mm, the next starts at 155 mm"),
    "no bearing": (unit().without(CATALOGUE), "has no bearing"),
    "no gears": (unit().without("cylindrical_stage"), "has no cylindrical_stage"),
    "several speeds": (unit().changed("gear_unit", {"number_of_gears": 2}), "several gears to change between"),
    "new version": (unit(version="2.0"), 'version "2.0" is not supported. Export the file in version 1.0 to 1.6'),
}


@pytest.mark.parametrize("name", UNFIT)
def test_what_no_scene_holds_is_refused_in_words(imported, name):
    document, words = UNFIT[name]
    with pytest.raises(RexsError, match=words):
        imported(document)


def test_torque_that_comes_in_at_three_shafts_is_refused(imported):
    document = unit().added("external_load", transmits_torque=True)
    document.relations.append(("assembly", {"assembly": SHAFTS[1], "part": max(document.components)}))
    with pytest.raises(RexsError, match="3 shafts have an external_load that transmits torque"):
        imported(document)


def test_the_free_end_of_a_train_is_the_input_of_a_torque_at_the_other(imported):
    document = unit().changed("external_load", {"transmits_torque": False}, 0)
    _, scene = imported(document.changed("external_load", {"torque_around_u_axis": (-400.0, "N m")}, 1))
    assert [stage.pinion_teeth for stage in scene.stages] == [20, 19]


def test_a_document_type_is_refused_before_an_entity_grows(tmp_path):
    bomb = '<?xml version="1.0"?><!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><model>&b;</model>'
    path = tmp_path / "bomb.rexs"
    for encoding in ("utf-8", "utf-16"):
        path.write_bytes(bomb.replace("?>", f' encoding="{encoding}"?>', 1).encode(encoding))
        with pytest.raises(RexsError, match="document type"):
            read_document(path)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.rexs", b"<model", "not valid XML"),
        ("a.rexs", b"<box/>", "its root is <box>"),
        ("a.rexs", b'<model version="1.4"><components><component id="x"/></components></model>', "a whole number"),
        ("a.rexs", b'<?xml version="1.0" encoding="none-such"?><model/>', "not valid XML"),
        (
            "a.rexs",
            b'<model><components><component id="1"/><component id="1"/></components></model>',
            "have the same id",
        ),
        ("a.rexsj", b"{", "not valid JSON"),
        ("a.rexsj", b"[]", "is in the place of a REXS object"),
        ("a.rexsj", b'{"model": {"version": "1.4", "components": 3}}', "components is 3, and must be a list"),
        ("a.rexsj", b'{"model":' * 100_000, "not valid JSON"),
        ("a.rexsz", b"no archive", "not a ZIP archive"),
        ("a.rexsz", packed("readme.txt", "hello"), "holds 0 REXS documents"),
    ],
)
def test_files_that_are_no_rexs_are_refused_in_words(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(RexsError, match=words):
        read_document(tmp_path / name)


def test_an_archive_that_unpacks_without_end_is_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MOST_BYTES", 5000)
    (tmp_path / "a.rexsz").write_bytes(packed("model.rexs", " " * 1_000_000))
    with pytest.raises(RexsError, match=r"more than 0\.005 MB"):
        read_document(tmp_path / "a.rexsz")


def test_a_name_that_is_no_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_document(tmp_path / "nothing.rexs")


NEEDED = {
    "shaft": ("support_vector", "u_axis_vector", "w_axis_vector"),
    "shaft_section": ("u_coordinate_on_shaft", "length", "outer_diameter_begin", "inner_diameter_end"),
    "cylindrical_gear": ("face_width", "number_of_teeth", "normal_module", "helix_angle_reference_diameter"),
    "cylindrical_gear_flank": ("normal_pressure_angle", "addendum_modification_coefficient"),
    "cylindrical_stage": ("center_distance",),
    CATALOGUE: ("u_coordinate_on_shaft_inner_side",),
}


@pytest.mark.parametrize(("kind", "key"), [(kind, key) for kind, keys in NEEDED.items() for key in keys])
def test_a_value_that_is_needed_and_missing_is_named(imported, kind, key):
    with pytest.raises(RexsError, match=key):
        imported(unit().changed(kind, {key: None}))


def test_a_bearing_in_the_catalogue_has_its_rolling_elements(imported):
    _, scene = imported(unit())
    found = rolling_bearings(scene)
    assert len(found) == 6
    assert {bearing.elements.count for bearing in found} == {9}
    assert {round(bearing.elements.diameter * 1000, 3) for bearing in found} == {7.94}


@pytest.mark.parametrize(("name", "size", "rating"), [("6205", 25, 7800), ("6207", 35, 15300), ("6308", 40, 25000)])
def test_balls_estimated_from_dimensions_and_rating_are_those_of_the_catalogue(imported, name, size, rating):
    """Ratings as printed in the SEW file; diameters to 2.1 %, number to one ball."""
    outside = {"6205": 52, "6207": 72, "6308": 90}[name]
    size = {"inner_diameter": (float(size), "mm"), "outer_diameter": (float(outside), "mm")}
    size |= {"catalogue_designation": "unknown", "radial_static_load_rating": (rating / 1000, "kN")}
    _, scene = imported(unit().changed(CATALOGUE, size))
    found, known = rolling_bearings(scene)[0].elements, RollingElements(designation=name)
    assert found.diameter == pytest.approx(known.diameter, rel=0.021)
    assert found.pitch_diameter == pytest.approx(known.pitch_diameter, rel=0.015)
    assert abs(found.count - known.count) <= 1


def test_a_floating_bearing_carries_no_thrust(imported):
    made, scene = imported(unit().changed(CATALOGUE, {"axial_force_absorption": "no_direction"}))
    table = scene.shafts[0].bearings[0]
    assert table.axial_stiffness_N_per_um <= 1e-3 * table.radial_stiffness_N_per_um
    assert any("carries no thrust" in note.reason for note in made.notes)


def test_thrust_in_one_direction_is_named(imported):
    made, _ = imported(unit().changed(CATALOGUE, {"axial_force_absorption": "negative"}))
    assert any("negative direction only" in note.reason for note in made.notes)


def test_rolling_elements_of_the_file_are_taken_as_they_are(imported):
    document = unit()
    bearing = next(number for number, one in document.components.items() if one[0] == CATALOGUE)
    row = {"number_of_rolling_elements": 13, "reference_diameter": (38.5, "mm"), "pressure_angle": (0.0, "deg")}
    document = document.added("rolling_bearing_row", **row, significant_contact_length_inner_ring=(8.0, "mm"))
    document = document.added("rolling_element", diameter_of_rolling_element=(7.5, "mm"))
    last = max(document.components)
    document.relations.append(("ordered_assembly", {"assembly": bearing, "part": last - 1}))
    document.relations.append(("ordered_assembly", {"assembly": last - 1, "part": last}))
    _, scene = imported(document.changed(CATALOGUE, {"bearing_type": "radial_roller_bearing"}))
    table = scene.shafts[0].bearings[0]
    assert (table.kind, table.elements, table.element_diameter_mm) == ("roller", 13, 7.5)
    assert (table.pitch_diameter_mm, table.roller_length_mm) == (38.5, 8.0)


COAXIAL = (  # the output on the axis of the input
    PLAIN[0],
    Row(**{**vars(PLAIN[0]), "angle": PLAIN[0].angle - 180.0, "helix": -20.0, "middles": (110.0, 110.0)}),
)


def with_pilot(axial):
    """A coaxial unit whose input shaft runs in its output shaft, in a bearing that takes thrust as given."""
    document = unit(COAXIAL)
    data = {"u_coordinate_on_shaft_inner_side": (80.0, "mm"), "inner_diameter": (15.0, "mm")}
    document = document.added("concept_bearing", "pilot", **data, axial_force_absorption=axial)
    roles = {"assembly": max(document.components), "inner_part": SHAFTS[0], "outer_part": SHAFTS[2]}
    document.relations.append(("side", roles))
    return document


def test_thrust_between_two_shafts_has_the_direction_of_the_inner_one(imported):
    made, _ = imported(with_pilot("negative"))
    assert any("negative direction only" in note.reason for note in made.notes)


def test_a_bearing_between_two_shafts_leaves_both_turning(imported):
    made, scene = imported(with_pilot("no_direction"))
    (joint,) = scene.couplings
    assert (joint.shafts, joint.positions_mm) == ((1, 3), (80.0, 80.0))
    assert (joint.torsional_stiffness_N_m_per_rad, joint.axial_stiffness_N_per_um) == (0.0, 0.0)
    assert joint.radial_stiffness_N_per_um == pytest.approx(60.0)
    assert [len(shaft.bearing_positions_mm) for shaft in scene.shafts] == [2, 2, 2]
    assert lay_out(scene).ratio == pytest.approx((61 / 20) ** 2)
    assert any("between two shafts" in note.reason for note in made.notes)


def test_the_command_says_what_was_assumed(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "box.rexs").write_text(xml(unit()), encoding="utf-8")
    assert main(["new", "my.toml", "--from", "box.rexs"]) == 0
    out = capsys.readouterr().out
    assert "assumed: casing.model = none" in out
    assert "my.toml written from box.rexs." in out
    assert main(["check", "my.toml"]) == 0


@pytest.mark.slow
def test_an_imported_unit_transmits_its_torque(imported, tmp_path):
    """A whole run with report; at speed the mean force of both flanks of stage 1 is the torque over the base radius."""
    made, _ = imported(unit())
    scene = gearcase.Scene.from_file(made.path).changed({"simulation.end_s": 0.3})
    response = gearcase.run(scene, out=tmp_path / "result").sel(stage=1, time=slice(0.15, 0.3))
    mean = float((response.mesh_force - response.coast_force).mean())
    transverse = math.atan(math.tan(math.radians(20)) / math.cos(math.radians(20)))
    radius = 20 * 2e-3 / math.cos(math.radians(20)) / 2 * math.cos(transverse)
    assert (tmp_path / "result" / "report.html").exists()
    assert mean == pytest.approx(60.0 / radius, rel=2e-3)
