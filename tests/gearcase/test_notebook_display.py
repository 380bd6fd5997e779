"""What a notebook shows of records and results: every field with its unit, texts escaped, no peak lost."""

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

import gearcase
from fem.storage import shown_html
from fem.storage.large_array_file import StoredArray
from fem.storage.records import Record, array, integer, names, scalar, text
from pipelines.diagnosis.uncertainty.bar_records import Band, LineBar, LineBars
from pipelines.diagnosis.verdict import Evidence, Finding, Verdict


@dataclass(frozen=True, eq=False, kw_only=True)
class Measured(Record):
    plotted = ("frequency", "amplitude")
    title: str = text()
    runs: int = integer()
    speed: float = scalar(units="rad/s")
    sensors: tuple[str, ...] = names("sensor")
    frequency: np.ndarray = array("bin", units="Hz")
    amplitude: np.ndarray = array("bin", units="m s-2", infinite=True)
    shapes: np.ndarray = array("sensor", "bin", units="kg", dtype=int)


def measured(bins=5, **changes):
    given = {
        "title": "<script>alert(1)</script>",
        "runs": 3,
        "speed": 12.25,
        "sensors": ("left & right", "top"),
        "frequency": np.arange(bins),
        "amplitude": np.linspace(0.5, 2.5, bins),
        "shapes": np.zeros((2, bins)),
    }
    return Measured(**(given | changes))


def cells(page):
    """The rows of the first table as texts; the page is well-formed."""
    found = ET.fromstring(f"<div>{page}</div>")
    return [["".join(cell.itertext()) for cell in row] for row in found.find("table").iter("tr")]


def test_a_record_shows_every_field_with_its_unit():
    rows = {name: (value, shape, unit) for name, value, shape, unit in cells(measured()._repr_html_())[1:]}
    assert list(rows) == [field.name for field in fields(Measured)]
    assert rows["speed"] == ("12.25", "", "rad/s")
    assert rows["amplitude"] == ("0.5 to 2.5", "bin 5", "m s-2")
    assert rows["shapes"] == ("0", "sensor 2 x bin 5", "kg")
    assert rows["sensors"][0] == "left & right, top"


def test_texts_are_escaped():
    page = measured()._repr_html_()
    assert "<script" not in page
    assert "left &amp; right" in page


def test_a_record_draws_what_it_names():
    drawn = ET.fromstring(f"<div>{measured()._repr_html_()}</div>").find("svg")
    assert [line.tag for line in drawn].count("polyline") == 1
    assert {"frequency, Hz", "m s-2", "amplitude"} <= set(drawn.itertext())


@pytest.mark.parametrize("values", [np.full(5, np.inf), np.array([])])
def test_nothing_is_drawn_of_nothing(values):
    assert "<svg" not in measured(len(values), amplitude=values)._repr_html_()


def test_a_long_curve_keeps_its_peak():
    values = np.zeros(100_000)
    values[54_321] = 7.0
    picture = shown_html.curves("x", np.arange(100_000.0), "y", {"line": values})
    heights = [float(pair.split(",")[1]) for pair in re.search(r'points="([^"]*)"', picture)[1].split()]
    assert len(heights) < 1000
    assert max(heights) - min(heights) == pytest.approx(150.0)


def test_what_is_stored_in_a_file_is_not_read(tmp_path):
    kept = StoredArray.create(tmp_path / "values.npy", (2, 5))
    (tmp_path / "values.npy").unlink()
    assert ["shapes", "in a file", "sensor 2 x bin 5", "kg"] in cells(measured(shapes=kept)._repr_html_())


def test_a_verdict_shows_its_findings():
    evidence = Evidence(features=("fm4",), sensor="top", axis="z", increase=12.0, deviation=9.0, limit=6.0, p=0.0005)
    one = Finding(component="<wheel>", evidence=evidence, damaged=True, repeating=True, alike=("pinion",), tooth=None)
    found = Verdict(
        findings=(one,),
        different=True,
        damaged=True,
        p_different=0.001,
        changes=(),
        exact=False,
        healthy=20,
        at_speed=False,
        outlying=(),
        tested=0,
        false_differences=(),
        false_alarms=(),
        left_out=(),
        not_examined=(),
    )
    assert cells(found._repr_html_())[1] == ["<wheel>", "+12.0", "top z", "0.0005", "-", "pinion"]
    assert repr(found) == "<Verdict: damaged, against 20 healthy recordings; first <wheel>, +12.0 dB>"
    level = replace(one, evidence=replace(evidence, increase=-7e-15))
    assert cells(replace(found, findings=(level,))._repr_html_())[1][1] == "+0.0"


def test_a_reduced_body_and_a_study_show_themselves():
    body = gearcase.ReducedMatrices(
        stiffness=np.diag([5.0, 6.0]),
        mass=np.eye(2),
        basis=np.zeros((9, 2)),
        coordinate_names=("a:ux", "mode_1"),
        report="",
    )
    assert cells(body._repr_html_())[1:] == [["a:ux", "5", "1"], ["mode_1", "6", "1"]]
    study = gearcase.converge(gearcase.Scene.from_file("minimal"), "slices")
    assert repr(body) == "<ReducedMatrices: 2 coordinates, from 9 equations>"
    assert repr(study) == f"<RefinementStudy: slices, {len(study.levels)} levels, {len(study.quantities)} quantities>"
    assert [row[:2] for row in cells(study._repr_html_())[1:]] == [[name, unit] for name, unit in study.units.items()]


def test_results_of_a_scene_show_themselves():
    scene = gearcase.Scene.from_file("minimal")
    assert ["load.container_kg", "114.0"] in cells(scene._repr_html_())
    pair = gearcase.laws(scene)[0]
    row = cells(pair._repr_html_())[1]
    assert row[:3] == ["secant", "healthy", "N/m"]
    assert float(row[4]) == pytest.approx(float(pair.curve().secant.mean()), rel=1e-4)
    assert "<polyline" in pair._repr_html_()
    checked = gearcase.check(scene)
    assert str(checked).splitlines()[0] == scene.title
    assert len(str(checked)) < 2000
    stage = cells(checked._repr_html_())[1]
    assert stage[:4] == ["1", "20/55", "2.75", "300"]
    casing = cells(gearcase.casing(scene)._repr_html_())
    assert casing[0] == ["mode", "Hz", "+- Hz"]
    assert len(casing) == 7
    linear = gearcase.modes(scene, up_to=300)
    assert repr(pair) == f"<PairLaws: stage 1, 20/55 teeth, model iso, {pair.force:.5g} N, healthy>"
    assert repr(linear).startswith(f"<LinearModes: {len(linear.frequencies)} modes, ")
    modes = cells(linear._repr_html_())
    assert modes[1][0] == "frequencies"
    assert modes[1][3] == "Hz"


def test_error_bars_show_themselves():
    known, unknown = Band(low=-0.1, high=0.25, source="time step", share=1.0), None
    lines = [
        LineBar(
            window="steady",
            kind="mesh",
            label="f_m",
            frequency=300.0,
            level=0.5,
            detected=True,
            numerical=one,
            inputs=known,
        )
        for one in (known, unknown)
    ]
    page = LineBars(bars=tuple(lines), notes=("Inputs: the damping.",))._repr_html_()
    assert [row[4:] for row in cells(page)[1:3]] == [["-0.10 to +0.25"] * 2, ["-", "-0.10 to +0.25"]]
    assert "Inputs: the damping." in page
