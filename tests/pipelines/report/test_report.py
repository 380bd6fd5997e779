"""Reports and exports: the answer on the first screen, one file, nothing from outside."""

import base64
import csv
import json
import re
from html.parser import HTMLParser
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_pages import body_of
from scipy.io import loadmat
from synthetic import MESH, WHEEL, response

from pipelines.diagnosis.control_diagnosis import DiagnosisSettings, diagnose
from pipelines.diagnosis.result_export import export
from pipelines.io.text_table import cell, grid
from pipelines.report import page
from pipelines.report.chart_data import extremes, largest, views
from pipelines.report.figures.plots import StiffnessPlot, drive_figure, stiffness_figure, waveform_figure
from pipelines.report.figures.views import LeftOut
from pipelines.report.first_figures import average_figure, envelope_figure
from pipelines.report.first_screen import screen_parts
from pipelines.report.page import typeset
from pipelines.report.report import write_report
from pipelines.steps import pictures

LEFT_OUT = "The picture of the gear pair is left out: off-screen rendering ended with SIGSEGV. Install libegl1."
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
    )
    return diagnose(runs["missing tooth"], runs["healthy"], settings)


AVERAGE = {
    "place": np.arange(55.0),
    "value": np.sin(np.arange(55.0)),
    "reference": np.zeros(55),
    "across": "teeth",
    "marked": (20.0, 22.0),
    "marked_name": "tooth 21",
}
ENVELOPE = {"line": np.arange(60.0), "amplitude": np.ones(60), "marked": [(5.4545, "f_r")], "band": "1 to 2 kHz"}
FIRST = {
    "sentences": ["One tooth of the stage 1 wheel missing.", "False alarms: 1 in 300 (0.01 to 1.8 %)."],
    "found": True,
    "figures": [("Speed", "900 rpm"), ("Tooth meshing f_m", "300 Hz"), ("Turns of shaft 2, f_r", "5.4545 Hz")],
    "evidence": [
        page.picture(average_figure(**AVERAGE), "Average over 9 turns."),
        page.picture(envelope_figure(**ENVELOPE), "Envelope spectrum."),
    ],
    "ranking": [(f"gear {i}", 14.0 - i, "-", "") for i in range(7)],
}


class Page(HTMLParser):
    """Checks that elements close, and collects ids, tables, headings, words and what would be fetched."""

    VOID = ("meta", "img", "br")

    def __init__(self, text):
        super().__init__()
        self.open, self.seen, self.fetched, self.ids = [], {}, [], []
        self.headings, self.columns, self.words = [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.seen[tag] = self.seen.get(tag, 0) + 1
        self.fetched += [value for name, value in attrs if name in ("src", "href", "srcset")]
        self.ids += [value for name, value in attrs if name == "id"]
        if tag == "thead":
            self.columns.append(0)
        if tag == "th":
            self.columns[-1] += 1
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)
        if not {"script", "style"} & set(self.open):
            self.words.append(data)


def written(folder, contents, facts=MappingProxyType({})):
    path = write_report(folder / "report.html", contents["title"], body_of(**contents), facts)
    text = path.read_text(encoding="utf-8")
    return text, Page(text)


@pytest.fixture(scope="module")
def full(tmp_path_factory, runs, diagnosis):
    contents = {
        "sensor": "sensor_3",
        "title": "Hoist with a missing tooth",
        "first": screen_parts(**FIRST),
        "diagnoses": (diagnosis,),
        "seeds": (diagnosis,),
        "summary": {"motor speed": "900 rpm", "coordinates": 212},
        "gears": ({"stage": 1, "gear": "pinion", "z": 20}, {"stage": 1, "gear": "wheel", "z": 55}),
        "stiffness": pictures.stiffness([CURVE]),
        "gear_picture": LeftOut(reason=LEFT_OUT),
        "runs": runs,
        "windows": WINDOWS,
        "energy": ({"part": "mesh 1", "residual": 1e-4},),
    }
    facts = {
        "steps": ({"step": "laws", "seconds": 1.25}, {"step": "run", "seconds": 3.0}),
        "gearcase": "0.1.0",
        "models": {"mesh": "plane"},
    }
    return written(tmp_path_factory.mktemp("full"), contents, facts)


def test_a_report_is_one_sound_file_that_fetches_nothing(full):
    text, page = full
    assert page.open == []
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in page.fetched)
    of_scripts = re.sub(r"/\*! https://github.com/leeoniya/uPlot [^*]*\*/", "", text)
    assert not re.search(r"https?://|@import|url\((?!#)", of_scripts)
    assert "The MIT License" in text
    assert len(text) < 5e6


def test_no_two_elements_of_a_report_have_one_id_and_every_reference_is_there(full):
    text, page = full
    assert len(page.ids) == len(set(page.ids))
    referred = set(re.findall(r'url\(#([^)]+)\)|href="#([^"]+)"', text))
    assert referred
    assert {name for pair in referred for name in pair if name} <= set(page.ids)


def test_the_first_screen_has_verdict_numbers_figures_and_ranking_in_this_order(full):
    text, page = full
    wanted = ["missing.", "False alarms: 1 in 300", "900 rpm", "300 Hz", "5.4545 Hz"]
    wanted += ["tooth 21", "Average over 9 turns.", "Envelope spectrum.", "gear 0", "Signals and spectra"]
    words = "\n".join(page.words)
    places = [words.index(word) for word in wanted]
    assert places == sorted(places)
    assert words.index("gear 4") < words.index("2 more components") < words.index("gear 5")
    assert text.index('id="ranking"') < text.index("<h2>")


def test_an_average_is_shown_with_its_difference_from_the_control():
    upper, lower = average_figure(**AVERAGE).axes
    np.testing.assert_array_equal(upper.lines[1].get_ydata(), AVERAGE["value"])
    np.testing.assert_array_equal(lower.lines[0].get_ydata(), AVERAGE["value"] - AVERAGE["reference"])
    assert len(average_figure(**AVERAGE | {"reference": None}).axes) == 1


def test_what_follows_the_first_screen_is_folded_but_for_the_signals(full):
    text, page = full
    assert page.headings == [
        "Signals and spectra",
        "How it was decided",
        "Levels",
        "Healthy and faulty",
        "Windows side by side",
        "All lines",
        "What was run",
        "Gears",
        "Stiffness",
        "Speed",
        "Energy balance",
        "Cost",
        "Provenance",
    ]
    assert re.findall(r'id="([^"]*)" open', text) == ["signals-and-spectra"]
    assert LEFT_OUT in text


def test_letters_of_figures_are_text(full):
    text, page = full
    assert "amplitude, m/s²</text>" in text
    assert page.seen["svg"] == 10  # first screen 2, signals 1, spectra 2, healthy and faulty 2, windows, k, speed
    assert "img" not in page.seen


def test_zooming_charts_hold_every_sample_of_the_verdict_and_4000_points_of_the_others(full, runs):
    text, _ = full
    data = json.loads(re.search(r'id="zoom-data">(.*?)</script>', text)[1])
    assert [run["name"] for run in data["runs"]] == ["missing tooth", "healthy"]
    assert [channel["name"] for channel in data["channels"]][:2] == ["sensor_3 z", "sensor_3 x"]
    assert len(data["channels"]) == 9
    own = unpacked(data["channels"][0]["traces"][0][0])
    np.testing.assert_allclose(own, runs["missing tooth"].acceleration.sel(sensor="sensor_3", axis="z"), rtol=1e-6)
    other = unpacked(data["channels"][4]["traces"][0][1])
    assert len(other) <= 4000
    signal = runs["healthy"].acceleration.sel(sensor="sensor_1", axis="y").values
    assert np.ptp(other) == pytest.approx(np.ptp(signal), rel=1e-3)


def test_a_spectrum_that_zooms_has_the_lines_of_the_diagnosis(full, diagnosis):
    text, _ = full
    data = json.loads(re.search(r'id="zoom-data">(.*?)</script>', text)[1])
    number = next(i for i, view in enumerate(data["views"]) if view["title"] == "Spectrum")
    trace = data["channels"][0]["traces"][number][0]
    amplitude = 10 ** unpacked(trace)
    at = int(np.argmax(amplitude))
    assert trace["start"] + at * trace["step"] == pytest.approx(MESH)
    assert len(amplitude) == len(diagnosis.spectra["faulty", "lifting"].amplitude)


def test_spectra_that_zoom_have_marks_from_the_first_harmonic_on():
    settings = DiagnosisSettings(
        revolution_frequency=WHEEL, mesh_frequency=MESH, windows={"lifting": WINDOWS["lifting"]}, sensor="sensor_3"
    )
    _, spectrum, envelope = views(settings, (1500.0, 4500.0))
    assert spectrum["marks"][:2] == [(MESH, "fₘ"), (2 * MESH, "2 fₘ")]
    assert envelope["marks"][:2] == [(WHEEL, "fᵣ"), (2 * WHEEL, "2 fᵣ")]


def unpacked(trace):
    numbers = np.frombuffer(base64.b64decode(trace["data"]), "<f4" if trace["kind"] == "f4" else "<i2")
    return numbers * trace["scale"]


@given(st.integers(1, 500), st.integers(0, 2**32 - 1))
def test_a_thinned_signal_keeps_its_extremes(samples, seed):
    values = np.random.default_rng(seed).normal(size=samples)
    kept, stretch = extremes(values, 40)
    assert len(kept) <= 40
    assert (kept.min(), kept.max()) == (values.min(), values.max())
    lines, width = largest(values, 40)
    assert len(lines) <= 40
    assert lines.max() == values.max()
    assert (stretch == 1) == (width == 1) == (samples <= 40)


def test_a_run_without_control_shows_its_signals_and_spectra_and_names_nothing_that_is_absent(tmp_path, runs):
    settings = DiagnosisSettings(
        revolution_frequency=WHEEL, mesh_frequency=MESH, windows={"steady": (0.5, 1.5)}, sensor="sensor_3", axis="z"
    )
    contents = {
        "sensor": "sensor_3",
        "title": "Minimal",
        "stiffness": pictures.stiffness([CURVE]),
        "runs": {"healthy": runs["healthy"]},
        "settings": settings,
    }
    text, page = written(tmp_path, contents)
    assert page.headings == ["Signals and spectra", "Levels", "Stiffness", "Speed"]
    assert 'class="missing"' not in text
    assert 'id="verdict"' not in text


def test_a_report_of_nothing_has_its_title_alone(tmp_path):
    _, page = written(tmp_path, {"title": "Nothing"})
    assert page.headings == []
    assert "".join(page.words).split() == ["Nothing", "Nothing"]


def test_a_table_is_never_wider_than_paper(tmp_path):
    values = {f"{k} Hz": k for k in range(14)}
    gears = [{"stage": 1 + i // 2, "gear": ("pinion", "wheel")[i % 2], **values} for i in range(6)]
    steps = [{"seconds": 1.0, **{f"column {k}": k for k in range(20)}}]
    _, page = written(tmp_path, {"title": "Wide", "gears": gears}, {"steps": steps})
    assert page.columns == [7, 9, 9, 7]
    words = [word for word in page.words if word.strip()]
    assert words[words.index("stage 1 pinion") + 5] == "stage 3 wheel"
    assert words.count("seconds") == 3


def test_words_of_a_scene_cannot_break_the_page(tmp_path):
    contents = {"sensor": "sensor_3", "title": '<script>alert("1")</script>', "summary": {"a<b": "c&d"}}
    text, _ = written(tmp_path, contents)
    assert "<script>alert" not in text
    assert "a&lt;b" in text
    assert typeset("`gearcase detect` finds it") == "<code>gearcase detect</code> finds it"
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
