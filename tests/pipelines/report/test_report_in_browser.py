"""The report as it is looked at: on a screen, on a telephone, on paper; charts that zoom without a network."""

import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from browser import CHROMIUM, browser
from report_pages import body_of
from synthetic import MESH, WHEEL, response

from pipelines.diagnosis.control_diagnosis import DiagnosisSettings, diagnose
from pipelines.report import page
from pipelines.report.figures.plots import StiffnessPlot
from pipelines.report.first_figures import average_figure, envelope_figure
from pipelines.report.first_screen import screen_parts
from pipelines.report.report import write_report
from pipelines.steps import pictures

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None or sys.platform == "win32", reason="needs Chromium"),
]

SCREEN, TELEPHONE = (1280, 800), (390, 844)
PAPER = (703, 1000)  # an A4 sheet less its margins, CSS pixels
BOXES = """(selectors) => selectors.map((selector) => {
  const box = document.querySelector(selector).getBoundingClientRect();
  return [box.left, box.top, box.right, box.bottom];
})"""


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Nine sensors, four shafts with many numbers, every section."""
    windows = {"lifting": (0.5, 2.5), "lowering": (3.0, 5.0)}
    settings = DiagnosisSettings(
        revolution_frequency=WHEEL, mesh_frequency=MESH, windows=windows, sensor="sensor_3", axis="z"
    )
    runs = {"missing tooth": response(sensors=3), "healthy": response("healthy", sensors=3)}
    diagnosis = diagnose(runs["missing tooth"], runs["healthy"], replace(settings, rope_mode={"lifting": 7.9}))
    place = np.linspace(-27.5, 27.5, 1800)
    own = diagnosis.envelopes["faulty", "lifting"]
    average = average_figure(
        place,
        np.exp(-(place**2)),
        0.1 * np.cos(place),
        across="teeth",
        marked=(-1.0, 1.0),
        marked_name="tooth 21",
    )
    envelope = envelope_figure(own.frequency[:120], own.amplitude[:120], marked=[(WHEEL, "f_r")], band="1 to 2 kHz")
    first = screen_parts(
        sentences=[
            "A tooth of gear 2 (55 teeth, shaft 2) is damaged: tooth 21 +- 1.",
            "The rms of the difference signal lies 14.2 dB over the healthy recordings, p = 0.002 after Holm's "
            "correction; false alarms: 1 in 300 (0.01 to 1.8 %).",
        ],
        found=True,
        figures=[
            ("Speed of the motor", "900 rpm"),
            ("Tooth meshing f_m", "300 Hz"),
            ("Turns of shaft 2, f_r", "5.4545 Hz"),
            ("Gear looked at", "stage 1 wheel, 55 teeth"),
            ("Channel", "sensor_3, z"),
        ],
        evidence=[
            page.picture(average, "Average over 9 turns of shaft 2 without its mesh orders."),
            page.picture(envelope, "Envelope spectrum in the chosen band."),
        ],
        ranking=[(f"gear {i}", 14.2 - i, "0.002", "") for i in range(1, 8)],
    )
    gears = [
        {"stage": 1 + i // 2, "gear": ("pinion", "wheel")[i % 2], **{f"number {k} mm": 123.456 for k in range(14)}}
        for i in range(6)
    ]
    cycle = np.linspace(0.0, 4.0, 81)
    contents = {
        "title": "Quay-crane hoist rig, one tooth of the stage 1 wheel missing, container on its rope",
        "first": first,
        "diagnoses": (diagnosis,),
        "gears": gears,
        "stiffness": pictures.stiffness(
            [StiffnessPlot(title="Stage 1", cycle=cycle, healthy=2e8 + 1e7 * np.cos(cycle))]
        ),
        "runs": runs,
        "windows": windows,
        "sensor": "sensor_3",
        "energy": [{"part": f"mesh {i}", **{f"{k} J": 1.234e-5 for k in range(7)}} for i in range(40)],
    }
    facts = {
        "steps": [{"seconds": 1.5, **{f"column {k}": 1234.5 for k in range(22)}}],
        "keys": {f"step {i}": "0123456789abcdef" * 2 for i in range(9)},
    }
    path = tmp_path_factory.mktemp("report") / "report.html"
    return write_report(path, contents["title"], body_of(**contents), facts)


def boxes(shown, *selectors):
    return shown.value(f"({BOXES})({list(selectors)})")


def test_the_first_screen_holds_verdict_numbers_figures_and_ranking(shown, report):
    shown.show(report, *SCREEN)
    wanted = ("#verdict", "#numbers", "#evidence figure:nth-child(1)", "#evidence figure:nth-child(2)", "#ranking")
    found = boxes(shown, *wanted)
    for left, top, right, bottom in found:
        assert left >= 0
        assert top >= 0
        assert right <= SCREEN[0]
        assert bottom <= SCREEN[1]
    assert [box[1] for box in found] == sorted(box[1] for box in found)
    assert shown.complaints() == []


def test_a_telephone_shows_the_same_order_without_scrolling_sideways(shown, report):
    shown.show(report, *TELEPHONE)
    found = boxes(shown, "#verdict", "#numbers", "#evidence figure:nth-child(1)", "#evidence figure:nth-child(2)")
    assert all(before[3] <= after[1] for before, after in zip(found, found[1:], strict=False))
    assert found[1][3] <= TELEPHONE[1]  # verdict, speed, f_m and f_r before the thumb moves
    shown.value("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
    assert shown.value("document.documentElement.scrollWidth") <= TELEPHONE[0]
    assert shown.complaints() == []


def test_letters_of_the_first_figures_can_be_read_on_a_telephone(shown, report):
    shown.show(report, *TELEPHONE)
    letters = "[...document.querySelectorAll('#evidence svg text')]"
    heights = shown.value(f"{letters}.map((text) => text.getBoundingClientRect().height)")
    assert min(heights) > 8.0


def test_a_chart_zooms_where_the_mouse_is_dragged_and_comes_back(shown, report):
    shown.show(report, *SCREEN)
    shown.value("document.querySelector('#zoom .u-over').scrollIntoView({block: 'center'})")
    ((left, top, right, bottom),) = boxes(shown, "#zoom .u-over")
    middle = (top + bottom) / 2
    shown.drag((left + 0.2 * (right - left), middle), (left + 0.4 * (right - left), middle))
    scale = "(({min, max}) => [min, max])(document.getElementById('zoom').charts[0].scales.x)"
    low, high = shown.value(scale)
    assert (low, high) == pytest.approx((1.0, 2.0), abs=0.02)
    shown.value("document.querySelector('#zoom button[title=narrower]').click()")
    low, high = shown.value(scale)
    assert high - low == pytest.approx(0.5, abs=0.02)
    shown.value("document.querySelector('#zoom button[title=\"the whole\"]').click()")
    assert shown.value(scale) == pytest.approx((0.0, 5.0), abs=1e-3)
    assert shown.complaints() == []


def test_every_channel_and_window_is_drawn_with_its_own_numbers(shown, report):
    shown.show(report, *SCREEN)
    top = "Math.max(...document.getElementById('zoom').charts[0].data.at(-1))"  # the run of the scene is drawn last
    choose = "((list, i) => { list.value = i; list.onchange(); })(document.querySelector('select[name=\"%s\"]'), %d)"
    own, signal = shown.value(top), response(sensors=3).acceleration.sel(sensor="sensor_3", axis="z")
    assert own == pytest.approx(float(signal.max()), rel=1e-4)
    shown.value(choose % ("Channel", 4))
    assert shown.value(top) != pytest.approx(own, rel=1e-3)
    shown.value(choose % ("Window of the spectra", 1))
    titles = shown.value("[...document.querySelectorAll('#zoom h3')].map((title) => title.textContent)")
    assert sum("lowering" in title for title in titles) == 2
    assert shown.complaints() == []


def test_figures_that_stand_still_give_way_to_charts_that_zoom_on_the_screen_alone(shown, report):
    shown.show(report, *SCREEN)
    seen = "getComputedStyle(document.querySelector('%s')).display"
    assert (shown.value(seen % "#zoom"), shown.value(seen % ".static")) == ("block", "none")
    shown.ask("Emulation.setEmulatedMedia", media="print")
    assert (shown.value(seen % "#zoom"), shown.value(seen % ".static")) == ("none", "block")
    shown.ask("Emulation.setEmulatedMedia", media="")
    shown.ask("Emulation.setScriptExecutionDisabled", value=True)
    shown.show(report, *SCREEN)
    shown.ask("Emulation.setScriptExecutionDisabled", value=False)
    assert (shown.value(seen % "#zoom"), shown.value(seen % ".static")) == ("none", "block")


def test_paper_shows_everything_and_cuts_no_table(shown, report, tmp_path):
    shown.show(report, *PAPER)
    shown.ask("Emulation.setEmulatedMedia", media="print")
    shown.value("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
    wide = "[...document.querySelectorAll('table, svg, pre')]"
    rights = shown.value(f"{wide}.map((element) => element.getBoundingClientRect().right)")
    assert len(rights) > 20
    assert max(rights) <= PAPER[0]
    rolled = "[...document.querySelectorAll('.wide, figure > div')].filter((e) => e.scrollWidth > e.clientWidth).length"
    assert shown.value(rolled) == 0
    shown.ask("Emulation.setEmulatedMedia", media="")
    shown.show(report, *SCREEN)
    shown.printed(tmp_path / "report.pdf")
    pages = len(re.findall(rb"/Type\s*/Page\b", (tmp_path / "report.pdf").read_bytes()))
    assert pages >= 5  # what is folded on the screen is printed, too
    assert shown.value("document.querySelectorAll('details[open]').length") == 1
