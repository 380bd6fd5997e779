"""`gearcase inspect`: stress of loaded teeth, their mesh in files, and what every picture must say and show."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace

import meshio
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from rendering import drawn
from time_limit import HANGING

from benchmarks.gear_pairs import thick_rimmed_pair
from fem.contact.faults.chipped_tooth import ChippedTooth
from fem.contact.models.iso import Iso
from fem.contact.models.solid import Solid
from fem.contact.models.solid_stress import root_stress
from fem.gears.modifications import PairModifications
from pipelines.io.errors import InputError
from pipelines.io.user_files import writable_file
from pipelines.machine.flanks_spec import FlanksSpec
from pipelines.report.figures import tooth_mesh_pictures
from pipelines.report.figures.colours import GONE
from pipelines.report.figures.damage import drawn_tooth
from pipelines.report.figures.gear_frame import placed, scene_frame
from pipelines.report.figures.labelled_pictures import casing_figure, gear_figure
from pipelines.report.figures.picture_geometry import shown_cycle
from pipelines.report.figures.plots import StiffnessPlot
from pipelines.report.figures.render import render_gears, render_mesh, render_stress, show_mesh
from pipelines.report.figures.tooth_mesh_frames import MeshView, mesh_frames, passage
from pipelines.report.figures.tooth_mesh_pictures import mesh_figure, write_film, write_still
from pipelines.report.figures.tooth_stress_pictures import (
    FORMATS,
    StressView,
    stress_figure,
    teeth_in_mesh,
    write_teeth,
)
from pipelines.report.figures.views import GearPairView, Picture
from pipelines.runs.root_stress import _stress_steps, root_stresses
from pipelines.runs.single_results import scene_graph
from pipelines.scene.load_scene import load_scene
from pipelines.steps import stress

LOAD = 1200.0
COARSE = Solid(slices=5, refinement=0.6, positions=8)


def state_of(pair, record, law, wheel, index=24):
    """Loaded teeth with the terms `wheel` of the wheel's teeth at c = index / 8."""
    flanks = FlanksSpec(
        pair=pair, modifications=PairModifications(), pinion_damage=(), wheel_damage=(), pinion_wear=(), wheel_wear=()
    )
    return stress.build(flanks, COARSE, index, LOAD, np.zeros(20), wheel, record=record, laws=(law, law))


@pytest.fixture(scope="module", params=[("right", "left"), pytest.param(("left", "right"), marks=pytest.mark.slow)])
def solved(request):
    """Pair, healthy state, and (right hand alone) the state without wheel tooth 3."""
    pair = thick_rimmed_pair(12.0, hands=request.param)
    record, law = COARSE.compliance(pair), Iso(slices=5).law(pair, "drive")
    gone = np.where(np.arange(55) == 3, np.inf, 0.0)
    healthy = state_of(pair, record, law, np.zeros(55))
    return pair, healthy, state_of(pair, record, law, gone) if request.param[0] == "right" else None


def corner_volumes(teeth):
    p = teeth.points[teeth.cells]
    return np.einsum("ci,ci->c", np.cross(p[:, 1] - p[:, 0], p[:, 3] - p[:, 0]), p[:, 4] - p[:, 0])


def test_both_gears_touch_along_the_contact_lines(solved):
    """The nearest nodes of either gear to a loaded contact point lie within an element; cells are right side out."""
    pair, healthy, _ = solved
    teeth = teeth_in_mesh(pair, healthy)
    assert corner_volumes(teeth).min() > 0.0
    places = teeth.line_points[np.isfinite(teeth.line_load)]
    element = 0.25 * pair.pinion.normal_module + pair.face_width / 32
    for number in (1, 2):
        nodes = teeth.points[np.unique(teeth.cells[teeth.gear == number])]
        away = np.linalg.norm(nodes[:, None] - places, axis=2).min(axis=0)
        assert away.max() < element
    hot = teeth.points[np.argsort(teeth.von_mises)[-5:]]
    assert np.linalg.norm(hot[:, None] - places, axis=2).min(axis=1).max() < pair.pinion.normal_module


def test_displacements_of_both_gears_close_the_contact(solved):
    """Seen along the line of action the pinion's flank moves back and the wheel's ahead, together less than delta."""
    pair, healthy, _ = solved
    teeth = teeth_in_mesh(pair, healthy)
    alpha = pair.working_pressure_angle
    along = teeth.displacement @ [np.sin(alpha), np.cos(alpha), 0.0]
    places = teeth.line_points[np.isfinite(teeth.line_load)]
    for number, sign in ((1, -1.0), (2, 1.0)):
        nodes = np.unique(teeth.cells[teeth.gear == number])
        nearest = nodes[np.linalg.norm(teeth.points[nodes][:, None] - places, axis=2).argmin(axis=0)]
        assert (sign * along[nearest] > 0.0).all()


def test_a_missing_tooth_leaves_its_rim_and_loads_its_neighbours(solved):
    pair, healthy, faulty = solved
    if faulty is None:
        pytest.skip("solved for the right hand")
    whole, teeth = teeth_in_mesh(pair, healthy), teeth_in_mesh(pair, faulty)
    own = teeth.cells[(teeth.gear == 2) & (teeth.tooth_pair == 3)]
    radius = np.hypot(teeth.points[own][..., 0] - pair.axis_distance, teeth.points[own][..., 1])
    assert len(own) > 0
    assert radius.mean(axis=1).max() < pair.wheel.root_radius
    assert len(whole.cells) > len(teeth.cells)
    assert np.isnan(teeth.line_load[faulty.pair == 3]).all()
    assert np.isfinite(whole.line_load[healthy.pair == 3]).any()
    assert teeth.von_mises.max() > 1.3 * whole.von_mises.max()
    for state in (healthy, faulty):
        assert state.line_load.sum() * pair.face_width / COARSE.slices == pytest.approx(LOAD, rel=1e-9)


def test_the_root_stress_is_that_of_a_cantilever_on_the_fillet_and_grows_beside_a_missing_tooth(solved):
    """ISO 6336-3: sigma_F0 = F_t / (b m_n) Y_F Y_S Y_beta, with Y_F Y_S from 2 to 4; two pairs share the load."""
    pair, healthy, faulty = solved
    nominal = LOAD * np.cos(pair.working_pressure_angle) / pair.face_width / pair.pinion.normal_module / 1e6
    rows = root_stresses(pair, teeth_in_mesh(pair, healthy))
    assert [row["gear"] for row in rows] == ["pinion", "wheel"]
    for row, gear in zip(rows, (pair.pinion, pair.wheel), strict=True):
        above_root = row["diameter mm"] / 2000 - gear.root_radius
        x, y, z = row["place"] - [(gear is pair.wheel) * pair.axis_distance, 0.0, 0.0]
        assert [2000 * np.hypot(x, y), 1000 * z] == pytest.approx([row["diameter mm"], row["y mm"]])
        assert 0.0 < above_root < 0.8 * gear.normal_module
        assert abs(row["y mm"]) <= 500 * pair.face_width * (1 + 1e-9)
        assert 1.0 * nominal < row["root stress MPa"] < 4.0 * nominal
    if faulty is not None:
        beside = root_stresses(pair, teeth_in_mesh(pair, faulty))[1]
        assert beside["tooth pair"] != 3
        assert beside["root stress MPa"] > 1.3 * rows[1]["root stress MPa"]


def test_root_stresses_by_unit_forces_are_those_of_the_field(solved):
    """Both superpose the same finite elements; the unit forces are interpolated between positions on the path."""
    pair, healthy, _ = solved
    law = Iso(slices=5).law(pair, "drive")
    loads = healthy.line_load[:, :: healthy.hand]  # along y
    for root, field in zip(
        root_stress(pair, replace(COARSE, positions=32)), (healthy.pinion, healthy.wheel), strict=True
    ):
        everywhere = replace(root, distance=np.ones_like(root.distance))  # no place near a contact
        (found,) = everywhere.of(law, np.array([healthy.cycle]), healthy.pair[None], loads[None])
        exact = field.von_mises[:, field.root].reshape(len(field.pair), len(root.face), -1).max(axis=2)
        assert abs(found - exact).max() < 0.01 * exact.max()
        first = np.where(np.arange(len(loads))[:, None] == 0, loads, 0.0)
        of_all = root.of(law, np.array([healthy.cycle]), healthy.pair[None], first[None])
        alone = root.of(law, np.array([healthy.cycle]), healthy.pair[None, :1], loads[None, :1])
        np.testing.assert_allclose(alone[0, 0], of_all[0, 0], rtol=1e-9)


def test_a_crack_alone_has_one_state_because_the_elements_are_those_of_a_healthy_tooth():
    crack = {"kind": "cracked-tooth", "stage": 1, "gear": "wheel", "tooth": 3, "depth_mm": 1.0}
    gone = {"kind": "missing-tooth", "stage": 1, "gear": "wheel", "tooth": 7}

    def names(*faults):
        machine = scene_graph(load_scene("minimal", {"faults": list(faults)}))[1]
        return [step.name for step in _stress_steps(machine, 1, 24, LOAD)[1:]]

    assert names(crack) == ["stress of healthy teeth of stage 1"]
    assert names(crack, gone) == [f"stress of {state} teeth of stage 1" for state in ("healthy", "faulty")]


@pytest.mark.parametrize("ending", [".vtu", ".inp", ".msh", ".bdf"])
def test_files_of_teeth_are_read_back(solved, tmp_path, ending):
    pair, _, faulty = solved
    if faulty is None:
        pytest.skip("written for the right hand")
    teeth = teeth_in_mesh(pair, faulty)
    path = tmp_path / f"teeth{ending}"
    frame = scene_frame((0.1, 0.2), (0.1, 0.1), 0.03, -1)  # a wheel below the pinion, which turns about -y
    write_teeth(teeth, path, frame)
    found = meshio.read(path)
    (block,) = found.cells
    assert block.type == "hexahedron"
    assert len(found.points) == len(np.unique(teeth.cells))
    assert np.allclose(found.points[block.data], placed(teeth.points[teeth.cells], frame), rtol=0.0, atol=1e-9)
    if ending in (".vtu", ".msh"):
        assert np.allclose(found.point_data["von Mises stress, Pa"][block.data], teeth.von_mises[teeth.cells])
        moved = found.point_data["displacement, m"][block.data]
        assert np.allclose(moved, teeth.displacement[teeth.cells] @ frame[:3, :3].T, rtol=1e-9, atol=1e-15)
    if ending == ".inp":
        assert {name: len(cells[0]) for name, cells in found.cell_sets.items()} == {
            "pinion": np.sum(teeth.gear == 1), "wheel": np.sum(teeth.gear == 2)
        }  # fmt: skip
    else:
        key = {".vtu": "group", ".msh": "gmsh:physical", ".bdf": "nastran:ref"}[ending]
        assert np.array_equal(np.concatenate(found.cell_data[key]), teeth.gear)


def test_an_unknown_ending_is_refused():
    with pytest.raises(InputError, match=r"name must end in \.vtu or \.inp or \.msh or \.bdf"):
        writable_file("teeth.stl", "--mesh", FORMATS)


def words(figure):
    """Everything a figure says."""
    found = [text.get_text() for text in figure.findobj(lambda item: hasattr(item, "get_text"))]
    return "\n".join(found)


def blank(**places):
    return Picture(image=np.full((60, 100, 3), 255, np.uint8), places=dict.fromkeys(places, (50.0, 30.0)) | places)


PLACES = {
    "root": (45.0, 25.0),
    "origin": (50.0, 30.0),
    "x": (60.0, 30.0),
    "y": (50.0, 20.0),
    "z": (55.0, 25.0),
    "pinion": (30.0, 30.0),
    "wheel": (70.0, 30.0),
}


@pytest.fixture(scope="module")
def mesh_view():
    """Three frames around the passage of the missing wheel tooth 3."""
    pair = thick_rimmed_pair(12.0)
    law = Iso(slices=5).law(pair, "drive")
    cycles = passage(3.0, 3)
    gone = np.where(np.arange(55) == 3, np.inf, 0.0)
    even = np.zeros(20), np.zeros(55)
    return MeshView(
        title="A pair: stage 1, 20/55 teeth",
        gears=GearPairView(pair=pair),
        damaged=GearPairView(pair=pair, marked=("wheel", 3)),
        marked="missing tooth 3 of the wheel",
        model=law.model,
        force=LOAD,
        cycles=cycles,
        states=(
            mesh_frames("healthy", pair, law, LOAD, cycles, *even),
            mesh_frames("missing tooth", pair, law, LOAD, cycles, np.zeros(20), gone),
        ),
    )


def stress_view(pair, healthy, faulty):
    return StressView(
        title="A pair: stage 1, 20/55 teeth",
        gears=GearPairView(pair=pair),
        damaged=GearPairView(pair=pair, marked=("wheel", 3)),
        marked="missing tooth 3 of the wheel",
        note="",
        model="model solid, refinement 0.6, 5 slices along the face",
        force=LOAD,
        cycle=3.0,
        names=("healthy", "missing tooth"),
        states=(teeth_in_mesh(pair, healthy), teeth_in_mesh(pair, faulty)),
        roots=((31.0, np.zeros(3)), (42.0, np.zeros(3))),
    )


def test_the_mesh_picture_says_what_it_shows(mesh_view):
    said = words(mesh_figure(mesh_view, [blank(**PLACES)] * 2, 1, 1e5))
    for phrase in (
        "A pair: stage 1, 20/55 teeth", "mesh cycle 3.000", "load 1200 N", "model iso", "contact lines",
        "line load, N/mm",
        "missing tooth 3 of the wheel", "pinion", "wheel", "stiffness, N/µm", "share, %", "12 mm", "healthy",
    ):  # fmt: skip
        assert phrase in said


def test_the_stress_picture_says_what_it_shows(solved):
    pair, healthy, faulty = solved
    if faulty is None:
        pytest.skip("solved for the right hand")
    said = words(stress_figure(stress_view(pair, healthy, faulty), [blank(**PLACES)] * 2, 5e8))
    for phrase in (
        "A pair: stage 1, 20/55 teeth", "mesh cycle 3", "load 1200 N", "model solid, refinement 0.6", "contact lines",
        "von Mises stress, MPa", "largest root stress", "31 MPa at the roots",
        "missing tooth 3 of the wheel", "pinion", "wheel", "face width 12 mm", "healthy",
    ):  # fmt: skip
        assert phrase in said


def reddish(image):
    """Pixels near the colour of the damaged tooth."""
    away = image.astype(float) / 255 - np.array(to_rgb(GONE))
    red = image[..., 0].astype(int) - image[..., 1:].max(axis=2).astype(int)
    return int(((np.abs(away).max(axis=2) < 0.35) & (red > 60)).sum())


def saturated(image):
    """Sum of how much redder than anything else the red pixels are."""
    red = image[..., 0].astype(int) - image[..., 1:].max(axis=2)
    return int(np.maximum(red - 60, 0).sum())


@pytest.mark.slow
def test_a_tooth_that_is_damaged_but_there_is_drawn_solid():
    pair, marked = thick_rimmed_pair(12.0), ("wheel", 3)
    view = GearPairView(pair=pair, marked=marked, cycle=shown_cycle(pair, marked))
    tooth = drawn_tooth(pair, None, "wheel", [ChippedTooth(depth=2e-3, extent=6e-3, end="-y")])
    there, gone = (drawn(render_gears, replace(view, tooth=one), (400, 320)) for one in (tooth, None))
    assert min(reddish(there.image), reddish(gone.image)) > 20
    assert saturated(there.image) > 1.2 * saturated(gone.image)
    curve = StiffnessPlot(title="Stage 1", cycle=np.array([0.0, 1.0]), healthy=np.array([2e8, 2e8]))
    said = words(gear_figure(there, curve, {"marked": "cracked tooth 3", "pinion": "pinion, 20 teeth"}, "A pair"))
    for phrase in ("A pair", "cracked tooth 3", "pinion, 20 teeth", "mesh cycle", "stiffness, N/µm"):
        assert phrase in said


def test_pictures_show_contact_lines_and_the_missing_tooth_in_the_faulty_half_alone(mesh_view):
    most = max(float(np.nanmax(state.load)) for state in mesh_view.states)
    found = [
        drawn(render_mesh, gears, mesh_view.cycles, state, most, (300, 210))
        for gears, state in zip((mesh_view.gears, mesh_view.damaged), mesh_view.states, strict=True)
    ]
    healthy, faulty = (pictures[1].image for pictures in found)
    assert (healthy < 250).any(axis=2).mean() > 0.2
    assert reddish(healthy) == 0
    assert (np.abs(healthy.astype(int) - faulty).max(axis=2) > 40).sum() > 100
    colourful = healthy.max(axis=2).astype(int) - healthy.min(axis=2)
    assert (colourful > 70).sum() > 20  # contact lines; the gears are pale
    red = faulty[..., 0].astype(int) - faulty[..., 1:].max(axis=2)
    assert (red > 40).sum() > 100 > (healthy[..., 0].astype(int) - healthy[..., 1:].max(axis=2) > 40).sum()


@pytest.mark.slow
def test_film_and_page_hold_every_frame(mesh_view, tmp_path, monkeypatch):
    from PIL import Image

    monkeypatch.setattr(tooth_mesh_pictures, "render_mesh", lambda *_: [blank(**PLACES)] * 3)
    assert write_still(mesh_view, tmp_path / "mesh_1") == tmp_path / "mesh_1.png"
    told = []
    files = write_film(mesh_view, tmp_path / "mesh_1", lambda *counts: told.append(counts))
    count = len(mesh_view.cycles)
    assert told == [(number, count) for number in range(1, count + 1)]
    assert [path.suffix for path in files] == [".gif", ".html"]
    with Image.open(files[0]) as film:
        assert film.n_frames == 3
    page = files[1].read_text(encoding="utf-8")
    assert "http" not in page
    assert page.count("data:image/png;base64,") >= 1
    assert "mesh cycle 3.000" in page
    assert 'type="range" min="0" max="2"' in page


def test_the_stress_picture_is_coloured(solved):
    pair, _, faulty = solved
    if faulty is None:
        pytest.skip("drawn for the right hand")
    state = teeth_in_mesh(pair, faulty)
    gears = GearPairView(pair=pair, marked=("wheel", 3))
    picture = drawn(render_stress, gears, 3.0, state, float(state.von_mises.max()), state.points[0], (400, 250))
    image = picture.image.astype(int)
    assert (image < 250).any(axis=2).mean() > 0.3
    assert reddish(picture.image) > 20  # the edges of the missing tooth
    assert (image.max(axis=2) < 45).sum() > 20  # contact lines
    assert (image[..., 0] > image[..., 2] + 80).sum() > 20  # orange and yellow: high stress
    assert ((image[..., 2] > 110) & (image[..., 2] > image[..., 1] + 60)).sum() > 20  # blue and violet: low stress


def test_no_display_is_said_with_the_remedy(mesh_view, monkeypatch):
    if not sys.platform.startswith("linux"):
        pytest.skip("windows open without DISPLAY")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(InputError, match=r"no display.*ssh -X.*mesh_<stage>\.html"):
        show_mesh(mesh_view)


WINDOW = """
from pathlib import Path
import test_stress_pictures
test_stress_pictures.show_mesh(test_stress_pictures.mesh_view.__wrapped__(), Path({image!r}))
"""


@pytest.mark.slow
def test_the_window_opens_on_a_virtual_screen(tmp_path):
    if shutil.which("xvfb-run") is None:
        pytest.skip("xvfb-run is not installed")
    image = tmp_path / "screen.png"
    done = subprocess.run(
        ["xvfb-run", "-a", sys.executable, "-c", WINDOW.format(image=str(image))],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    from matplotlib.image import imread

    assert (imread(image)[..., :3] < 0.98).any(axis=2).mean() > 0.2


def test_the_casing_picture_has_its_own_title():
    points = {"ground_1": (10.0, 10.0), "sensor_1": (90.0, 10.0), "origin": (50.0, 50.0)}
    picture = blank(**points, x=(60.0, 50.0), y=(50.0, 40.0), z=(55.0, 45.0))
    said = words(casing_figure(picture, "Casing and key points of a rig"))
    for phrase in ("Casing and key points of a rig", "ground_1", "sensor points (1)"):
        assert phrase in said
