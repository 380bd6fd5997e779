"""Faults of bearings in a scene: what is refused, what the diagnosis looks for, what it finds beside a broken tooth."""

import pytest

import gearcase
from pipelines.cli.main import main
from pipelines.diagnosis.control_diagnosis import diagnose
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene

OUTER = {
    "kind": "bearing-spall", "shaft": 1, "bearing": 1, "on": "outer-ring", "width_mm": 1.0, "depth_um": 50.0,
    "angle_deg": 110.0,
}  # fmt: skip
INNER = {**OUTER, "bearing": 2, "on": "inner-ring"}
ELEMENT = {**OUTER, "on": "element"}
TOOTH = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}
BENCH = {  # one stage at 3,000 rpm in rolling bearings and a rigid casing; error-free gears
    "bearings": {"model": "hertz", "designation": "6205"}, "deviations.enabled": False,
    "drive.times_s": [0.0, 0.3], "drive.speeds_rpm": [3000.0, 3000.0], "simulation.end_s": 0.3,
    "diagnosis.gear": "pinion", "diagnosis.windows_s": {"lifting": [0.05, 0.3]},
    "diagnosis.envelope_band_Hz": [1500.0, 4500.0],
}  # fmt: skip
PER = {"BPFO": 3.5848, "BPFI": 5.4152, "2 BSF": 4.7135}  # of the shaft: 6205, Bearing Data Center


def scene(*faults, **changes):
    return load_scene("minimal", BENCH | {"control": "without-faults", "faults": list(faults)} | changes).scene


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shaft": 3}, "faults.1.shaft = 3: there is no such shaft. Set 1 to 2"),
        ({"bearing": 3}, "faults.1.bearing = 3: there is no such bearing. Set 1 to 2"),
        ({"on": "cage"}, "must be one of outer-ring, inner-ring, element"),
        ({"width_mm": 0.0}, "greater than 0"),
        ({"stage": 1}, "is not a key of"),
    ],
)
def test_a_spall_that_is_nowhere_is_refused(change, message):
    with pytest.raises(SceneError, match=message.replace("[", r"\[")):
        scene(OUTER | change)


def test_the_models_of_a_scene_are_those_of_its_bearings_and_not_the_unused_default():
    own = {"shafts.1.bearings": [BENCH["bearings"]] * 2, "bearings": {"model": "linear"}}
    assert load_scene("minimal", own).scene.models()["bearings"] == ["hertz", "linear"]


def test_a_spall_needs_rolling_elements():
    with pytest.raises(SceneError, match=r'has the model linear.*Set bearings.model = "hertz"'):
        scene(OUTER, bearings={"model": "linear"})
    bearings = [{"model": "rigid"}, {"model": "hertz", "designation": "6205"}]
    with pytest.raises(SceneError, match=r"Set shafts.1.bearings.1.model"):
        scene(OUTER, **{"shafts.1.bearings": bearings})
    assert scene(OUTER | {"bearing": 2}, **{"shafts.1.bearings": bearings}).spalls


@pytest.mark.parametrize(
    ("faults", "message"),
    [
        ([OUTER | {"width_mm": 50.0}], "faults.1: spall on the outer ring: width_mm = 50"),
        ([TOOTH, OUTER, INNER | {"depth_um": 2000.0}], "faults.3: spall on the inner ring: depth_um = 2000"),
        (
            [OUTER, OUTER | {"angle_deg": 111.0}],
            "faults.2: two spalls on the outer ring overlap: the angle between their centres is 1 deg",
        ),
    ],
)
def test_a_spall_that_does_not_fit_is_named_by_its_number(faults, message):
    with pytest.raises(SceneError, match=message):
        checked_machine(scene(*faults), "scene")


def test_pass_frequencies_are_looked_for_with_the_sidebands_of_the_load_zone():
    machine = make_machine(scene(OUTER, INNER, ELEMENT))
    outer, inner, element = machine.diagnosis.passes
    turn = 50.0
    assert outer.frequency == pytest.approx(PER["BPFO"] * turn, rel=1e-4)
    assert outer.spacing == 0.0  # it stays in the load zone
    assert inner.frequency == pytest.approx(PER["BPFI"] * turn, rel=1e-4)
    assert inner.spacing == pytest.approx(turn)
    assert element.frequency == pytest.approx(PER["2 BSF"] * turn, rel=2e-4)
    assert element.spacing == pytest.approx(0.39828 * turn, rel=2e-4)  # of the cage
    assert [name for name, _, _ in inner.monitored()][1:3] == ["bearing_2 BPFI - f_shaft_1", "bearing_2 BPFI"]
    assert make_machine(scene()).diagnosis.passes == ()


def test_a_spall_is_looked_for_at_the_rates_of_its_own_bearing():
    sizes = [{"model": "hertz", "designation": name} for name in ("6206", "6205")]
    (inner,) = make_machine(scene(INNER, **{"shafts.1.bearings": sizes})).diagnosis.passes
    assert inner.frequency == pytest.approx(PER["BPFI"] * 50.0, rel=1e-4)


def test_a_scene_without_its_faults_keeps_the_slip_of_its_cages_alone():
    slipping = BENCH["bearings"] | {"cage_slip": 0.01}
    healthy, faulty = (make_machine(scene(*faults, bearings=slipping)).parts for faults in ([], [OUTER]))
    assert faulty.bearings[1:] == healthy.bearings[1:]
    assert faulty.bearings[0].inside.slip == healthy.bearings[0].inside.slip
    assert len(faulty.bearings[0].inside.spalls) == 1
    assert not healthy.bearings[0].inside.spalls
    seeds = {bearing.inside.slip.seed for bearing in healthy.bearings}
    assert len(seeds) == 4  # every cage its own
    again = make_machine(scene(bearings=slipping, **{"deviations.seed": 2})).parts
    assert seeds.isdisjoint({bearing.inside.slip.seed for bearing in again.bearings})


FAULTS = {"outer": [OUTER], "inner": [INNER], "element": [ELEMENT], "compound": [TOOTH, OUTER]}


@pytest.fixture(scope="module")
def diagnoses():
    """A spall of each kind, and one beside a missing tooth, against the same gearbox without them."""
    runs = {
        name: gearcase.simulate(gearcase.Scene.from_file("minimal").changed(BENCH | {"faults": faults}))
        for name, faults in {"healthy": [], **FAULTS}.items()
    }
    return {
        name: diagnose(runs[name], runs["healthy"], make_machine(scene(*faults)).diagnosis)
        for name, faults in FAULTS.items()
    }


@pytest.mark.parametrize("name", ["outer", "inner", "element"])
def test_a_spall_raises_its_lines_and_the_control_does_not(diagnoses, name):
    """Twenty decibels at every harmonic; a healthy bearing has weak lines at BPFO only, by its varying compliance."""
    found = diagnoses[name]
    (spall,) = found.settings.passes
    own = spall.own(found.lines)
    harmonics = own.at([i for i, label in enumerate(own.label) if " + " not in label and " - " not in label])
    assert harmonics.detected.all()
    assert harmonics.difference.min() > 20.0
    sidebands = int(own.detected.sum()) - int(harmonics.detected.sum())
    assert sidebands >= (0 if name == "outer" else 6)
    if name != "outer":
        assert harmonics.healthy_over_floor[0] < found.settings.floor_limit


def test_check_lists_pass_frequencies_and_faults(tmp_path, capsys):
    path, spalled = tmp_path / "spalled.toml", BENCH | {"control": "without-faults", "faults": [TOOTH, OUTER]}
    path.write_text(gearcase.Scene.from_file("minimal").changed(spalled).to_toml(), encoding="utf-8")
    assert main(["check", str(path)]) == 0
    text = capsys.readouterr().out
    row = next(line for line in text.splitlines() if line.split()[:1] == ["bearing_1"] and "at x" not in line)
    assert [float(word) for word in row.split()[3:]] == pytest.approx([179.24, 270.76, 117.84, 19.914], rel=2e-4)
    assert "faults: missing-tooth 0 of the stage 1 pinion, spall on the outer ring of bearing_1" in text
