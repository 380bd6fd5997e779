"""Pictures: solids have the right volume, labels the right places, and a dead renderer stops nothing."""

import logging
import sys

import numpy as np
import pytest
from synthetic import box, gear_outline, key_points

from pipelines import pictures
from pipelines.callouts import casing_figure, gear_figure, spread
from pipelines.pictures import CasingView, GearPairView, LeftOut, Picture, render_casing, render_gears
from pipelines.plots import StiffnessPlot
from pipelines.solids import enclosed_volume, gear_surface, prism_surface, without_tooth


def area(outline):
    x, y = outline.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def pair():
    return GearPairView(
        pinion_outline=gear_outline(20, 0.002),
        wheel_outline=gear_outline(55, 0.002, np.pi + np.pi / 55),
        pinion_teeth=20,
        wheel_teeth=55,
        pinion_bore=0.01,
        wheel_bore=0.02,
        pinion_twist=10.0,
        wheel_twist=-3.6,
        face_width=0.012,
        centre_distance=0.075,
        missing_gear="wheel",
        missing_angle=np.pi + np.pi / 55 + 8 * np.pi / 55,
    )


def test_gear_surface_encloses_area_times_width():
    outline = gear_outline(20, 0.002)
    bore = 0.01 * np.column_stack([np.cos(a := np.arctan2(*outline.T[::-1])), np.sin(a)])
    points, quads = gear_surface(outline, 0.01, 0.0, 0.012)
    exact = (area(outline) - area(bore)) * 0.012
    assert enclosed_volume(points, quads) == pytest.approx(exact, rel=1e-12)
    twisted = enclosed_volume(*gear_surface(outline, 0.01, 10.0, 0.012, layers=41))
    assert twisted == pytest.approx(exact, rel=2e-3)  # walls are facets between the layers


def test_missing_tooth_and_the_rest_make_the_whole_gear():
    outline = gear_outline(20, 0.002)
    rest, tooth = without_tooth(outline, 20, 2 * np.pi * 7 / 20)
    root = 0.02 - 1.25 * 0.002
    arc = root**2 / 2 * (2 * np.pi / 20)  # sector under the tooth
    fan = area(np.vstack([tooth, [[0, 0]]])) - arc
    assert area(rest) == pytest.approx(area(outline) - fan, rel=2e-3)
    assert np.hypot(*tooth.T).max() == pytest.approx(0.022)
    middle = np.arctan2(*tooth.mean(axis=0)[::-1]) % (2 * np.pi)
    assert middle == pytest.approx(2 * np.pi * 7 / 20, abs=0.02)
    volume = enclosed_volume(*prism_surface(tooth, 0.0, 0.012))
    assert volume == pytest.approx(area(tooth) * 0.012, rel=1e-12)


def test_labels_do_not_overlap_and_stay_near():
    wanted = [10.0, 11.0, 12.0, 100.0, 101.0, 300.0]
    found = np.array(spread(wanted, 20.0))
    assert np.diff(found).min() >= 20.0 - 1e-9
    assert found[1] == pytest.approx(11.0)
    assert found[-1] == 300.0
    assert found[3:5].mean() == pytest.approx(100.5)


def test_pictures_show_gears_and_casing_where_they_are_said_to_be():
    gears = render_gears(pair(), (420, 340))
    if isinstance(gears, LeftOut):
        pytest.skip(gears.reason)
    assert gears.image.shape == (340, 420, 3)
    column, row = (round(v) for v in gears.places["gone"])
    near = gears.image[row - 6 : row + 7, column - 6 : column + 7].reshape(-1, 3).astype(int)
    assert (near[:, 0] - near[:, 1:].max(axis=1)).max() > 60  # red: the tooth that is gone
    assert (gears.image[0, 0] == 255).all()
    figure = gear_figure(
        gears, StiffnessPlot(title="Stage 1", cycle=[0, 1], healthy=np.array([2e8, 2e8])), {"gone": "tooth 4"}
    )
    assert "tooth 4" in {text.get_text() for text in figure.axes[0].texts}

    nodes, triangles = box()
    points = key_points()
    casing = render_casing(CasingView(nodes=nodes, triangles=triangles, points=points), (700, 450))
    assert isinstance(casing, Picture)
    for name, channel in (("bearing_3", 0), ("sensor_3", 1)):
        column, row = (round(v) for v in casing.places[name])
        colour = casing.image[row, column].astype(int)
        assert colour[channel] == colour.max()
        assert colour.max() - colour.min() > 60
    labels = {text.get_text() for text in casing_figure(casing).axes[0].texts}
    assert set(points) <= labels
    assert {"x", "y", "z"} <= labels


@pytest.mark.parametrize(
    ("program", "what", "package"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "SIGSEGV", "libegl1 (or libosmesa6)"),
        ("raise ImportError('libGL.so.1: cannot open shared object file')", "libGL.so.1", "install libgl1 with"),
        ("pass", "wrote no picture", "libegl1"),
        ("import time; time.sleep(60)", "more than 1 s", "run again"),
    ],
)
def test_a_dead_renderer_leaves_one_picture_out(monkeypatch, caplog, program, what, package):
    monkeypatch.setattr(pictures, "RENDERER", ("-c", program))
    monkeypatch.setattr(pictures, "TIMEOUT", 1.0 if "sleep" in program else 30.0)
    with caplog.at_level(logging.WARNING):
        found = render_gears(pair())
    assert isinstance(found, LeftOut)
    assert found.reason.startswith("The picture of the gear pair is left out")
    assert what in found.reason
    assert package in found.reason
    assert found.reason in caplog.text
    assert "pyvista" not in sys.modules
