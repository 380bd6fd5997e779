"""Pictures: solids have the right volume, labels the right places, and a dead renderer stops nothing."""

import logging
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.path import Path
from rendering import drawn, enclosed_volume
from synthetic import box, gear_outline, key_points

from benchmarks.gear_pairs import gear_pair
from pipelines.report.figures import render, render_failures
from pipelines.report.figures.labelled_pictures import casing_figure, gear_figure, spread
from pipelines.report.figures.picture_geometry import casing_surface, shown_cycle
from pipelines.report.figures.plots import StiffnessPlot
from pipelines.report.figures.render import render_casing, render_gears
from pipelines.report.figures.tooth_surfaces import gear_surface, outline, prism_surface, twist, without_tooth
from pipelines.report.figures.views import GearPairView, NotRendered, Picture


def area(outline):
    x, y = outline.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def pair():
    gears = gear_pair((20, 55), 2, 12, 12, bores_mm=(10, 20))
    return GearPairView(pair=gears, marked=("wheel", 4), cycle=shown_cycle(gears, ("wheel", 4)))


def test_gear_surface_encloses_area_times_width():
    section = gear_outline(20, 0.002)
    bore = 0.01 * np.column_stack([np.cos(a := np.arctan2(*section.T[::-1])), np.sin(a)])
    points, quads = gear_surface(section, 0.01, 0.0, 0.012)
    exact = (area(section) - area(bore)) * 0.012
    assert enclosed_volume(points, quads) == pytest.approx(exact, rel=1e-12)
    twisted = enclosed_volume(*gear_surface(section, 0.01, 10.0, 0.012, layers=41))
    assert twisted == pytest.approx(exact, rel=2e-3)  # walls are facets between the layers


def test_missing_tooth_and_the_rest_make_the_whole_gear():
    section = gear_outline(20, 0.002)
    rest, tooth = without_tooth(section, 20, 2 * np.pi * 7 / 20)
    root = 0.02 - 1.25 * 0.002
    arc = root**2 / 2 * (0.84 * 2 * np.pi / 20)  # sector under the tooth, foot to foot
    fan = area(np.vstack([tooth, [[0, 0]]])) - arc
    assert area(rest) == pytest.approx(area(section) - fan, rel=2e-3)
    assert np.hypot(*tooth.T).max() == pytest.approx(0.022)
    middle = np.arctan2(*tooth.mean(axis=0)[::-1]) % (2 * np.pi)
    assert middle == pytest.approx(2 * np.pi * 7 / 20, abs=0.02)
    volume = enclosed_volume(*prism_surface(tooth, 0.0, 0.012))
    assert volume == pytest.approx(area(tooth) * 0.012, rel=1e-12)


@pytest.mark.parametrize("missing", [("wheel", 3), ("pinion", 0)])
def test_gears_of_the_picture_touch_at_the_pitch_point_without_overlap(missing):
    gears = gear_pair((20, 55), 2, 12, 12, bores_mm=(10, 15))
    view = GearPairView(pair=gears, marked=missing, cycle=shown_cycle(gears, missing))
    sections = {name: outline(getattr(gears, name), view.zero_angle(name)) for name in ("pinion", "wheel")}
    pinion, wheel = sections["pinion"], sections["wheel"] + [gears.axis_distance, 0.0]
    pitch_point = np.array([gears.working_radii[0], 0.0])
    for section in (pinion, wheel):
        along = np.roll(section, -1, axis=0) - section
        part = np.clip(np.einsum("ij,ij->i", pitch_point - section, along) / np.sum(along**2, axis=1), 0, 1)
        distance = np.linalg.norm(section + part[:, None] * along - pitch_point, axis=1).min()
        assert distance < 6e-6  # chords of the involute
    assert area(pinion) > 0
    chord = 6e-6
    assert not Path(wheel).contains_points(pinion, radius=-chord).any()
    assert not Path(pinion).contains_points(wheel, radius=-chord).any()
    # opposite hands: at the pitch point both teeth lean the same way
    assert twist(gears.pinion) * gears.working_radii[0] == pytest.approx(-twist(gears.wheel) * gears.working_radii[1])
    _, tooth = without_tooth(sections[missing[0]], getattr(gears, missing[0]).teeth, view.marked_angle)
    middle = tooth.mean(axis=0)
    assert np.arctan2(*middle[::-1]) == pytest.approx((view.marked_angle + np.pi) % (2 * np.pi) - np.pi, abs=1e-6)


def test_the_casing_surface_keeps_the_surface_alone():
    nodes, triangles = box()
    padded = np.vstack([nodes[:3], [[9.0, 9.0, 9.0]], nodes[3:]])  # a node inside the body, of no facet
    shifted = np.where(triangles >= 3, triangles + 1, triangles)
    kept, corners = casing_surface(padded, np.column_stack([shifted, shifted]))
    np.testing.assert_array_equal(kept[corners], nodes[triangles])
    assert len(kept) == 8


def test_labels_do_not_overlap_and_stay_near():
    wanted = [10.0, 11.0, 12.0, 100.0, 101.0, 300.0]
    found = np.array(spread(wanted, 20.0))
    assert np.diff(found).min() >= 20.0 - 1e-9
    assert found[1] == pytest.approx(11.0)
    assert found[-1] == 300.0
    assert found[3:5].mean() == pytest.approx(100.5)


def test_pictures_show_gears_and_casing_where_they_are_said_to_be():
    gears = drawn(render_gears, pair(), (420, 340))
    assert gears.image.shape == (340, 420, 3)
    column, row = (round(v) for v in gears.places["marked"])
    near = gears.image[row - 6 : row + 7, column - 6 : column + 7].reshape(-1, 3).astype(int)
    assert (near[:, 0] - near[:, 1:].max(axis=1)).max() > 60  # red: the tooth that is gone
    assert (gears.image[0, 0] == 255).all()
    figure = gear_figure(
        gears, StiffnessPlot(title="Stage 1", cycle=[0, 1], healthy=np.array([2e8, 2e8])), {"marked": "tooth 4"}
    )
    assert "tooth 4" in {text.get_text() for text in figure.axes[0].texts}

    nodes, triangles = box()
    points = key_points()
    casing = render_casing(nodes, triangles, points, (700, 450))
    assert isinstance(casing, Picture)
    for name, channel in (("bearing_3", 0), ("sensor_3", 1)):
        column, row = (round(v) for v in casing.places[name])
        colour = casing.image[row, column].astype(int)
        assert colour[channel] == colour.max()
        assert colour.max() - colour.min() > 60
    labels = {text.get_text() for text in casing_figure(casing).axes[0].texts}
    assert set(points) <= labels
    assert {"x", "y", "z"} <= labels


KILL = "import os, signal; os.kill(os.getpid(), signal.{})"


@pytest.mark.parametrize(
    ("program", "graphics", "limit", "what", "remedy"),
    [
        (KILL.format("SIGSEGV"), False, None, "SIGSEGV, which happens without EGL", "libegl1 (or libosmesa6)"),
        (KILL.format("SIGSEGV"), True, None, "the cause is not known", "run again"),
        (KILL.format("SIGSEGV"), True, 1200.0, "SIGSEGV under a memory limit of 1200 MB", "raise the limit"),
        (KILL.format("SIGSEGV"), False, 64e3, "SIGSEGV, which happens without EGL", "libegl1 (or libosmesa6)"),
        (KILL.format("SIGKILL"), False, None, "killed, which the system does when memory runs out", "raise the limit"),
        (KILL.format("SIGTERM"), False, None, "ended with SIGTERM", "run again"),
        ("raise MemoryError", False, None, "MemoryError", "raise the limit"),
        ("raise ImportError('libvtk.so: failed to map segment from shared object')", False, 500.0, "map", "raise"),
        ("raise ImportError('libGL.so.1: cannot open shared object file')", True, None, "libGL.so.1", "libgl1 with"),
        ("import a_module_that_is_not_there", True, None, "need a_module_that_is_not_there", "python -m pip install"),
        ("raise ValueError('odd')", False, None, "ValueError: odd", "run again"),
        ("pass", False, None, "wrote no picture", "libegl1"),
        ("import time; time.sleep(600)", True, None, "more than 1 s", "run again"),
    ],
)
def test_a_dead_renderer_leaves_one_picture_out(monkeypatch, caplog, program, graphics, limit, what, remedy):
    monkeypatch.setattr(render, "command", lambda _: [sys.executable, "-c", program])
    if "sleep" in program:
        monkeypatch.setattr(render, "TIMEOUT", 1.0)
    monkeypatch.setattr(render_failures, "graphics_found", lambda: graphics)
    monkeypatch.setattr(render_failures, "memory_limit", lambda: limit)
    monkeypatch.setitem(sys.modules, "pyvista", None)  # drawing happens in a child: an import in this process fails
    with caplog.at_level(logging.WARNING), pytest.raises(NotRendered) as found:
        render_gears(pair())
    reason = str(found.value)
    assert reason.startswith("The picture of the gear pair is left out")
    assert what in reason
    assert remedy in reason
    assert ("apt-get" in reason) == ("lib" in remedy)
    assert reason in caplog.text


LIMITED = """
import resource, sys
sys.path[:0] = {path!r}
from pipelines.report.figures.render_failures import memory_limit
resource.setrlimit(resource.RLIMIT_AS, ({limit} * 2**20, resource.RLIM_INFINITY))
print(memory_limit())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits as POSIX has them")
def test_a_limit_of_memory_is_known():
    code = LIMITED.format(path=sys.path, limit=4000)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(done.stdout) == 4000.0
