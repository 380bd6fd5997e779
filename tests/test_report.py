"""Reports and exports: one file, nothing from outside, nothing missing without its reason."""

import csv
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from scipy.io import loadmat
from synthetic import MESH, WHEEL, response

from pipelines.border.grid import Grid, GridError
from pipelines.figures.plots import StiffnessPlot, drive_figure, stiffness_figure, waveform_figure
from pipelines.figures.views import LeftOut
from pipelines.report.contents import cell, grid
from pipelines.report.page import typeset
from pipelines.report.report import ReportContents, write_report
from pipelines.signals.diagnosis import DiagnosisSettings, diagnose
from pipelines.signals.export import ExportError, export

WINDOWS = {"lifting": (0.5, 2.5), "lowering": (3.0, 5.0)}
CYCLE = np.linspace(0, 4, 81)
CURVE = StiffnessPlot(
    title="Stage 1",
    cycle=CYCLE,
    healthy=2e8 + 1e7 * np.cos(2 * np.pi * CYCLE),
    label="missing tooth",
    faulty=2e8 - 1e8 * np.exp(-((CYCLE - 2) ** 2)),
)


@pytest.fixture(scope="module")
def runs():
    return {"missing tooth": response(), "healthy": response("healthy")}


@pytest.fixture(scope="module")
def diagnosis(runs):
    settings = DiagnosisSettings(
        revolution_frequency=WHEEL,
        mesh_frequency=MESH,
        windows=WINDOWS,
        sensor="sensor_3",
        rope_mode={"lifting": 7.9},
        fault="one tooth of the stage 1 wheel missing",
    )
    return diagnose(runs["missing tooth"], runs["healthy"], settings)


class Page(HTMLParser):
    """Counts elements, checks that they close, and collects what would be fetched."""

    VOID = ("meta", "img", "br")

    def __init__(self, text):
        super().__init__()
        self.open, self.seen, self.fetched, self.headings = [], {}, [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.seen[tag] = self.seen.get(tag, 0) + 1
        self.fetched += [value for name, value in attrs if name in ("src", "href", "srcset")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


def test_full_report_answers_first_and_fetches_nothing(tmp_path, runs, diagnosis):
    reason = "The picture of the gear pair is left out: off-screen rendering ended with SIGSEGV. Install libegl1."
    contents = ReportContents(
        sensor="sensor_3",
        title="Hoist with a missing tooth",
        diagnoses=(diagnosis,),
        seeds=(diagnosis,),
        summary={"motor speed": "900 rpm", "coordinates": 212},
        gears=({"stage": 1, "gear": "pinion", "z": 20}, {"stage": 1, "gear": "wheel", "z": 55}),
        stiffness=(CURVE,),
        gear_picture=LeftOut(reason=reason),
        runs=runs,
        windows=WINDOWS,
        steps=({"step": "laws", "seconds": 1.25}, {"step": "run", "seconds": 3.0}),
        energy=({"part": "mesh 1", "residual": 1e-4},),
        provenance={"gearcase": "0.1.0", "models": {"mesh": "plane"}},
    )
    text = write_report(tmp_path / "report.html", contents).read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in page.fetched)
    assert not re.search(r"https?://|@import|url\(", text)
    assert page.seen["img"] == 9  # stiffness, drive, signals, 2 spectra, 2 healthy-faulty, lifting-lowering, seconds
    body = text[text.index("<body>") :]
    assert body.index("One tooth of the stage 1 wheel missing: seen") < body.index("What was run")
    assert reason in text
    assert "this casing model has no mesh to show" in text
    assert "only one of them was given" in text
    assert page.headings[0] == "What was run"
    assert len(page.headings) == 14


def test_short_report_has_no_empty_sections(tmp_path, runs):
    settings = DiagnosisSettings(
        revolution_frequency=WHEEL, mesh_frequency=MESH, windows={"steady": (0.5, 1.5)}, sensor="sensor_3", axis="z"
    )
    contents = ReportContents(
        sensor="sensor_3",
        title="Minimal",
        stiffness=(CURVE,),
        runs={"healthy": runs["healthy"]},
        settings=settings,
        short=True,
    )
    text = write_report(tmp_path / "report.html", contents).read_text(encoding="utf-8")
    assert Page(text).headings == ["Stiffness", "Speed", "Signals", "Spectra"]
    assert "Not part of this run: what was run, gears, casing, healthy and faulty" in text
    assert 'class="missing"' not in text
    assert 'class="answer' not in text


def test_report_without_control_says_so(tmp_path):
    text = write_report(tmp_path / "report.html", ReportContents(sensor="sensor_3", title="No control")).read_text(
        encoding="utf-8"
    )
    assert "No diagnosis: the scene names no healthy control" in text
    assert text.count('class="missing"') == 14


def test_words_of_a_scene_cannot_break_the_page(tmp_path):
    contents = ReportContents(
        sensor="sensor_3", title='<script>alert("1")</script>', summary={"a<b": "c&d"}, short=True
    )
    text = write_report(tmp_path / "report.html", contents).read_text(encoding="utf-8")
    assert "<script" not in text
    assert "a&lt;b" in text
    assert typeset("2 f_m - f_r at sensor_3") == "2 <i>f</i><sub>m</sub> - <i>f</i><sub>r</sub> at sensor_3"


def test_figures_have_titles_units_and_legends(runs):
    drive = drive_figure(runs["healthy"], WINDOWS)
    assert [axes.get_ylabel() for axes in drive.axes] == ["speed, rpm", "force, kN"]
    names = [text.get_text() for text in drive.axes[0].get_legend().get_texts()]
    assert names == ["motor 1", "motor 2", "input shaft"]
    assert max(drive.axes[0].lines[0].get_ydata()) == pytest.approx(900)
    curve = stiffness_figure([CURVE]).axes[0]
    assert curve.get_ylabel() == "stiffness, N/µm"
    assert curve.lines[0].get_ydata().max() == pytest.approx(210)
    assert len(waveform_figure(runs, "sensor_3", "z", WINDOWS).axes) == 4
    no_rope = drive_figure(runs["healthy"].drop_vars("rope_force"), WINDOWS)
    assert len(no_rope.axes) == 1


def test_cells_and_grids():
    assert [cell(v) for v in (1.23456789, 3, None, True, ["a", 2.5])] == ["1.235", "3", "", "yes", "a, 2.5"]
    table = grid("T", [{"a": 1, "b": "x"}, {"a": -2.5, "c": "y|z"}])
    assert table.headers == ("a", "b", "c")
    assert table.numeric() == (True, False, False)
    assert "y\\|z" in table.to_markdown()
    with pytest.raises(GridError, match="row 0 has 1 cells for 2"):
        Grid(title="T", headers=("a", "b"), rows=(("1",),))


def test_csv_has_a_unit_in_every_header_and_every_sample(tmp_path):
    run = response(duration=0.02)
    rows = list(csv.reader(export(run, tmp_path / "r.csv", "csv").read_text(encoding="utf-8").splitlines()))
    header = rows[0]
    assert header[0] == "time [s]"
    assert all(name.endswith("]") for name in header)
    assert len(rows) == 1 + run.time.size
    column = header.index("acceleration sensor_3 z [m/s2]")
    values = np.array([float(row[column]) for row in rows[1:]])
    np.testing.assert_allclose(values, run.acceleration.sel(sensor="sensor_3", axis="z"), rtol=1e-8, atol=1e-12)
    assert len(header) == 1 + 9 + 2 + 4 + 4 + 3 + 3 + 24 + 1


def test_mat_comes_back_with_units_and_labels(tmp_path):
    run = response(duration=0.02)
    run.attrs["nothing"] = None
    content = loadmat(export(run, tmp_path / "r.mat", "mat"), simplify_cells=True)
    np.testing.assert_array_equal(content["acceleration"], run.acceleration.values)
    assert content["units"]["mesh_force"] == "N"
    assert content["labels"]["state"] == "missing-tooth"
    assert list(content["coordinates"]["axis"]) == ["x", "y", "z"]


def test_unknown_format_is_refused(tmp_path):
    with pytest.raises(ExportError, match="csv, mat"):
        export(response(duration=0.02), tmp_path / "r.xls", "xls")
