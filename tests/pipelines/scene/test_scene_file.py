"""Scene files: extends, --set, every problem at once in plain words, commented copies that stand alone."""

import tomllib

import pytest

from pipelines.io.errors import InputError, SceneError
from pipelines.io.toml_text import format_document
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.scene.load_scene import control_differences, control_of, load_scene, shipped_names
from pipelines.scene.merge import settings_tree
from pipelines.scene.new import new_scene

SHIPPED = shipped_names()


def write(folder, text, name="my.toml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def problems(source, *settings):
    with pytest.raises(SceneError) as caught:
        load_scene(source, settings)
    return {problem.path: str(problem) for problem in caught.value.problems}


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scene_resolves_to_text_that_loads_to_the_same_scene(name, tmp_path):
    loaded = load_scene(name)
    assert load_scene(write(tmp_path, loaded.resolved())).scene == loaded.scene


def test_extends_merges_tables_and_replaces_values(tmp_path):
    base = load_scene("minimal").scene
    path = write(tmp_path, 'extends = "minimal"\n[drive]\ncoupling_stiffness_N_m_per_rad = 5000.0\n')
    changed = load_scene(path).scene
    assert changed.drive.coupling_stiffness_N_m_per_rad == 5000.0
    assert changed.drive.times_s == base.drive.times_s
    assert changed.model_copy(update={"drive": base.drive}) == base


def test_extends_is_relative_to_the_file_that_says_it(tmp_path):
    (tmp_path / "deep").mkdir()
    write(tmp_path / "deep", 'extends = "minimal"\ntitle = "base"\n', "base.toml")
    path = write(tmp_path, 'extends = "deep/base.toml"\n[load]\ncontainer_kg = 90\n')
    loaded = load_scene(path)
    assert (loaded.scene.title, loaded.scene.load.container_kg) == ("base", 90.0)


def test_a_title_is_not_inherited_with_other_faults(tmp_path):
    assert load_scene(write(tmp_path, 'extends = "bench"\nfaults = []\n')).scene.title == "my, which extends bench"
    assert "chipped" in load_scene(write(tmp_path, 'extends = "bench"\n[load]\nposition_mm = 0\n')).scene.title


def test_one_item_of_an_array_is_changed_by_its_number(tmp_path):
    path = write(tmp_path, 'extends = "rig-healthy"\n[stages.2]\nface_width_mm = 19.0\n')
    for loaded in (load_scene(path), load_scene("rig-healthy", ["stages.2.face_width_mm=19"])):
        widths = [stage.face_width_mm for stage in loaded.scene.stages]
        assert widths == [12.0, 19.0, 28.0]


def test_another_model_takes_what_it_knows_and_drops_the_rest(tmp_path):
    scene = load_scene("rig-healthy", ["casing.model=rigid", "load.model=static-torque"]).scene
    assert scene.casing.model == "rigid"
    assert scene.casing.housing.length_mm == 600.0
    assert scene.load.drum_radius_mm == 100.0
    found = problems(write(tmp_path, 'extends = "rig-healthy"\n[casing]\nmodel = "rigid"\nband_Hz = 900.0\n'))
    assert "is not a key of [casing]" in found["casing.band_Hz"]  # written by the user: not dropped


@pytest.mark.parametrize(
    ("text", "value"),
    [("32", 32), ("3.5", 3.5), ("rigid", "rigid"), ('"a b"', "a b"), ("[1, 2]", [1, 2]), ("true", True), ("1e3", 1e3)],
)
def test_settings_are_read_as_toml_or_bare_words(text, value):
    assert settings_tree([f"a.b={text}"])[0] == {"a": {"b": value}}


def test_settings_from_python_are_the_same():
    written = load_scene("minimal", ["load.container_kg=80", "stages.1.mesh.slices=5"])
    given = load_scene("minimal", {"load.container_kg": 80, "stages.1.mesh.slices": 5})
    assert written.scene == given.scene


def test_a_table_as_a_value_replaces_the_whole_table():
    assert load_scene("rig-healthy", ["diagnosis.windows_s={}"]).scene.diagnosis.windows_s == {}
    changed = load_scene("rig-healthy", {"diagnosis.windows_s": {"up": [1, 2]}}).scene
    assert changed.diagnosis.windows_s == {"up": (1, 2)}


POSITIVE = "must be greater than 0 mm. Correct the value."
BAD = """\
extends = "rig-healthy"
title = 3
cotrol = "x"
[stages.1]
module_mm = -2
face_widht_mm = 12
mesh = { model = "plaen" }
[stages.7]
module_mm = 2
[casing]
band_Hz = "high"
[casing.housing]
wall_thickness_mm = 0
[load]
model = "static-torque"
container_kg = nan
[drive]
times_s = [0.0, 2.0, 1.0, 3, 4, 5]
[simulation]
container_kg = 3
"""


@pytest.mark.parametrize(
    ("setting", "text"),
    [
        ("=3", "--set =3: has no key. Write KEY=VALUE"),
        ("preset=fine", "is not a key of the scene. Use the option --preset."),
        ("stages.1.torque_N_m=[5, 6]", "is not a key of [stages.1]. The load gives the torque of a stage"),
        ("stages.1.torqe_N_m=5", "The load gives the torque of a stage: set it in [load], or use --torque"),
        ("losses.friction=3", "losses.model: is missing. Set model to one of none, efficiency, coulomb."),
        ("casing.housing.model=cad", 'casing.housing.model = "cad": must be one of parametric, step, mesh, matrices.'),
    ],
)
def test_a_key_that_stands_elsewhere_or_is_missing_is_answered_with_what_to_write(setting, text):
    with pytest.raises(SceneError) as raised:
        load_scene("bench", [setting])
    assert text in str(raised.value)


def test_a_list_in_an_item_of_a_list_is_written_without_the_number_of_the_item(tmp_path):
    table = '[[shafts]]\nbearing_positions_mm = [0, 50]\n[[shafts.%sbearings]]\nmodel = "rigid"\n'
    found = problems(write(tmp_path, 'extends = "minimal"\n' + table % "1."))
    assert found["shafts.1.1"].endswith("write its tables without the number: [shafts.NAME] or [[shafts.NAME]].")
    found = problems(write(tmp_path, 'extends = "minimal"\n' + table % ""))
    assert not any("bearings" in path for path in found)


def test_a_number_outside_its_range_is_one_problem_though_a_list_is_possible():
    with pytest.raises(SceneError) as raised:
        load_scene("bench", ["casing.damping_ratio=5"])
    assert [str(problem) for problem in raised.value.problems] == [
        "casing.damping_ratio = 5: must be less than 1. Correct the value."
    ]


def test_every_problem_is_listed_at_once_with_value_limit_and_remedy(tmp_path):
    found = problems(write(tmp_path, BAD), "stages.2.face_width_mm=0", "a..b=2", "x", "load.q=[1")
    expected = {
        "stages.1.module_mm": "stages.1.module_mm = -2: must be at least 0.05 mm. Correct the value.",
        "stages.2.face_width_mm": f"stages.2.face_width_mm = 0: {POSITIVE}",
        "stages.1.face_widht_mm": "stages.1.face_widht_mm = 12: is not a key of [stages.1]. "
        "Did you mean face_width_mm?",
        "stages.1.mesh.model": 'stages.1.mesh.model = "plaen": must be one of iso, energy, plane, solid. '
        'Did you mean "plane"?',
        "stages.7": "stages.7: there is no item 7; stages has 3 items, numbered 1 to 3. Correct the number.",
        "cotrol": 'cotrol = "x": is not a key of the scene. Did you mean control?',
        "title": "title = 3: must be text. Put it in quotes, in a shell as in --set 'KEY=\"VALUE\"'. Meaning: one line "
        "that names the scene in every result.",
        "casing.band_Hz": 'casing.band_Hz = "high": must be a number in Hz. '
        "Write the number alone, without quotes and unit.",
        "simulation.container_kg": "simulation.container_kg = 3: is not a key of [simulation]. "
        "Did you mean load.container_kg?",
        "drive": "drive: times_s must increase strictly, but 1 s follows 2 s. Correct them.",
        "load.container_kg": "load.container_kg = nan: must be a finite number in kg. Correct the value.",
        "a..b": "a..b: is not the path of a key. Join keys by single dots, as in stages.1.face_width_mm.",
        "--set x": "--set x: has no value. Write KEY=VALUE, as in --set stages.1.face_width_mm=32.",
        "load.q": "load.q = [1: is not a TOML value. Write text in quotes, and lists as [1, 2].",
    }
    assert expected.items() <= found.items()
    assert set(found) - set(expected) == {"casing.housing.wall_thickness_mm"}


def test_a_missing_key_is_explained(tmp_path):
    text = load_scene("minimal").source.text.replace("face_width_mm = 12.0\n", "")
    assert problems(write(tmp_path, text)) == {
        "stages.1.face_width_mm": "stages.1.face_width_mm: is missing. Set face_width_mm = ...: common face width b."
    }


def test_what_contradicts_is_listed_line_by_line():
    found = problems("rig-healthy", "diagnosis.stage=9", "diagnosis.sensor=nowhere")
    assert len(found) == 1  # both without a path of their own
    with pytest.raises(SceneError) as caught:
        load_scene("rig-healthy", ["diagnosis.stage=9", "diagnosis.sensor=nowhere"])
    assert len(caught.value.problems) == 2


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("rig-helthy", "Did you mean rig-healthy"),
        ("nowhere.toml", "no such file"),
        ("mi.toml", "Did you mean my.toml"),
        ("broken.toml", "not valid TOML: .*line 2"),
        ("latin.toml", r"not UTF-8 text \(line 2\)"),
        ("circle.toml", "extends forms a circle"),
        (
            "lost.toml",
            r'^lost\.toml: 1 problem\n  extends = "minimall-not-there": there is no shipped .*\. Or delete extends\.$',
        ),
    ],
)
def test_a_file_that_cannot_be_used_is_named_with_the_remedy(tmp_path, monkeypatch, source, words):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, 'extends = "minimal"\n')
    write(tmp_path, "title = 'x'\na = = 3\n", "broken.toml")
    write(tmp_path, 'extends = "other.toml"\n', "circle.toml")
    write(tmp_path, 'extends = "circle.toml"\n', "other.toml")
    write(tmp_path, 'extends = "minimall-not-there"\n', "lost.toml")
    (tmp_path / "latin.toml").write_bytes("title = 'x'\n# Größe\n".encode("latin-1"))
    with pytest.raises(InputError, match=words):
        load_scene(source)


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    path = tmp_path / "my.toml"
    path.write_bytes(b"\xef\xbb\xbf" + b'extends = "minimal"\r\n[load]\r\ncontainer_kg = 90\r\n')
    assert load_scene(path).scene.load.container_kg == 90.0


@pytest.mark.parametrize("name", SHIPPED)
def test_new_writes_a_commented_copy_that_stands_alone(name, tmp_path):
    path = new_scene(tmp_path / "my.toml", name)
    text = path.read_text(encoding="utf-8")
    copied, original = load_scene(path).scene, load_scene(name).scene
    assert copied.model_copy(update={"control": original.control}) == original
    assert "extends" not in tomllib.loads(text)
    comments = [line for line in load_scene(name).source.text.splitlines() if line.startswith("#")]
    assert all(comment in text for comment in comments)
    assert text.count("#") >= len(comments)
    with pytest.raises(InputError, match="not overwritten"):
        new_scene(path, name)


def test_new_wants_a_toml_name_in_a_folder_that_exists(tmp_path):
    with pytest.raises(InputError, match=r"must end in \.toml"):
        new_scene(tmp_path / "my.txt")
    with pytest.raises(InputError, match="cannot be written"):
        new_scene(tmp_path / "nowhere" / "my.toml")


def test_a_control_follows_the_settings_of_its_scene(tmp_path):
    settings = ["load.container_kg=800", "stages.1.face_width_mm=13", "faults.1.tooth=3", "title=mine"]
    for source in ("rig-missing-tooth", new_scene(tmp_path / "my.toml", "rig-missing-tooth")):
        loaded = load_scene(source, settings)
        control = control_of(loaded)
        assert control.scene.faults == ()
        assert control.scene.load.container_kg == 800.0
        assert control_differences(loaded, control) == []


def test_a_control_that_differs_in_more_than_the_fault_is_told(tmp_path):
    path = write(tmp_path, 'extends = "rig-missing-tooth"\n[stages.1]\nface_width_mm = 13.0\n')
    loaded = load_scene(path)
    assert control_differences(loaded, control_of(loaded)) == ["stages.1.face_width_mm: 13.0 -> 12.0"]


def test_a_copy_of_a_variant_keeps_the_comments_of_both_and_the_values_of_the_variant(tmp_path):
    write(
        tmp_path,
        """# lighter
extends = "rig-healthy"
[load]
container_kg = 500.0   # half a load
[stages.1]
mesh = { model = "iso" }  # quick
""",
    )
    text = new_scene(tmp_path / "copy.toml", str(tmp_path / "my.toml")).read_text(encoding="utf-8")
    assert text.startswith("# lighter\n#\n# From the scene that it extends, rig-healthy:\n# The 1:4 test rig")
    assert "# half a load" in text
    assert 'mesh = { model = "iso", ' in text
    assert "# quick" in text
    assert "[gear_material]                       # case-hardened steel" in text
    assert load_scene(tmp_path / "copy.toml").scene.stages[0].mesh.model == "iso"
    assert load_scene(tmp_path / "copy.toml").scene.load.container_kg == 500.0


def test_what_is_written_as_toml_reads_back_equal():
    tree = {
        "a": 1, "b": 0.1 + 0.2, "c": 1e-300, "d": -0.0, "e": True, "text": 'quote " back \\ tab \t line \n é',
        "list": [1, 2.5], "empty": {}, "odd key.": 1, "table": {"x": {"y": "z"}},
        "items": [{"k": 1}, {"k": [{"q": 2}]}],
    }  # fmt: skip
    assert tomllib.loads(format_document(tree)) == tree


@pytest.mark.parametrize(
    ("setting", "path", "words"),
    [
        ("shafts.1.bearing_positions_mm=[]", "shafts.1.bearing_positions_mm", "has 0 items"),
        ("diagnosis.windows_s={ x = [0.5] }", "diagnosis.windows_s.x", "too few values"),
        ('stages.1.pinion_teeth="20"', "stages.1.pinion_teeth", "whole number"),
        ("stages.1.module_mm=true", "stages.1.module_mm", "must be a number"),
        ('drive.speeds_rpm=[0, "900", 900]', "drive.speeds_rpm.2", "must be a number"),
        ("deviations.enabled=1", "deviations.enabled", "true or false"),
    ],
)
def test_nothing_is_guessed_from_a_value_of_another_kind(setting, path, words):
    assert words in problems("minimal", setting)[path]


@pytest.mark.parametrize("band", ["[400, 100]", "[100, 9000]"])
def test_an_envelope_band_rises_and_fits_the_output_rate(band):
    found = "".join(problems("minimal", f"diagnosis.envelope_band_Hz={band}").values())
    assert "the second frequency must be above the first, and below half" in found


def test_a_tooth_is_missing_once():
    fault = '{ kind = "missing-tooth", stage = 1, gear = "wheel", tooth = 2 }'
    assert "several faults that exclude one another" in "".join(
        problems("minimal", f"faults=[{fault}, {fault}]").values()
    )


def test_a_sensor_far_from_the_housing_is_refused():
    scene = load_scene("minimal", ["sensors.1.position_mm=[7000, -80, 35]"]).scene
    with pytest.raises(SceneError, match="6810 mm outside the housing"):
        checked_machine(scene, "minimal")


def test_a_motion_shorter_than_one_sample_is_refused():
    settings = {"simulation.end_s": 0.004, "simulation.output_rate_Hz": 100.0, "diagnosis.windows_s": {}}
    with pytest.raises(SceneError, match=r"0\.004 is shorter than one sample.*at least 0\.01"):
        load_scene("minimal", settings)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"casing.coupling": "rigid"},
            r"casing\.coupling = \"rigid\": is not a key of \[casing\]\. Did you mean attachment\?",
        ),
        (
            {"faults": [{"kind": "bent-tooth", "stage": 1, "gear": "wheel"}]},
            r"faults\.1\.kind = \"bent-tooth\": must be one of",
        ),
        ({"faults": [{"stage": 1, "gear": "wheel", "tooth": 1}]}, r"faults\.1\.kind: is missing"),
        ({"casing": {"model": "foam"}}, r"casing\.model = \"foam\": must be one of"),
    ],
)
def test_a_key_of_an_earlier_version_and_an_unknown_kind_are_named(settings, message):
    with pytest.raises(SceneError, match=message):
        load_scene("rig-healthy", settings)
