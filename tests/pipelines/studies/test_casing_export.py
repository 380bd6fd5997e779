"""The reduced casing in files of other programs, pictures of its modes, and the store of its modes."""

import re
import sys
from dataclasses import dataclass, replace
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import scipy.io
import scipy.linalg as la
from factored_casing import factored
from housings import short_housing
from rendering import drawn

from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.models.rigid_casing import RigidCasing
from fem.casing.reduced.casing_modes import casing_modes, natural_modes, reduced_body
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.reduced_body import ReducedBody
from fem.casing.reduced.reduction import reduce_body
from fem.elements.materials import CAST_IRON
from pipelines.cli.casing import _texts, band_words, casing_mode_table, missed_error, part_table, reduction_words
from pipelines.cli.main import main
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph, Step, explain
from pipelines.io.errors import InputError
from pipelines.io.user_files import writable_file
from pipelines.report.figures.frame_files import film_page
from pipelines.report.figures.mode_pictures import ModeView, mode_figure, write_mode
from pipelines.runs.single_results import Casing, mode_shapes
from pipelines.studies.housings.casing_export import FORMATS, write_mat, write_uff, write_vtu


@pytest.fixture(scope="module")
def housing():
    return short_housing()


@pytest.fixture(scope="module")
def elastic(housing):
    """Mesh, modes and body of a small casing."""
    mesh = mesh_housing(housing, element_size=0.05)
    casing = factored(assembled_casing(mesh, CAST_IRON))
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=4)
    modes = casing_modes(casing, reduction, model="craig-bampton", band_limit=2000.0)
    return mesh, modes, reduced_body(modes, sensors=housing.sensors[:2])


def test_a_matlab_file_holds_the_body(elastic, tmp_path):
    _, _, body = elastic
    write_mat(body, tmp_path / "casing.mat")
    found = scipy.io.loadmat(tmp_path / "casing.mat", simplify_cells=True)
    for name in ("mass", "stiffness", "damping", "rows", "point_positions"):
        assert np.array_equal(found[name], getattr(body, name))
    assert list(found["row_names"]) == list(body.row_names)
    body.save(tmp_path / "casing.h5")
    assert ReducedBody.load(tmp_path / "casing.h5").digest() == body.digest()


def test_a_universal_file_is_read_back_with_nodes_modes_and_responses(housing, tmp_path):
    pyuff = pytest.importorskip("pyuff")
    one = replace(housing, sensors=housing.sensors[:1])
    body = RigidCasing(mount_stiffness=1e8, damping_ratio=0.02).reduce(one, CAST_IRON)
    write_uff(body, tmp_path / "casing.uff", title="a casing", band=3000.0)
    sets = pyuff.UFF(str(tmp_path / "casing.uff")).read_sets()
    kinds = [s["type"] for s in sets]
    square, phi = la.eigh(body.stiffness, body.mass)
    assert kinds.count(55) == 6
    assert kinds.count(58) == 3 * 3 * 2  # three axes of a sensor, three forces at two bearings
    nodes = sets[kinds.index(2411)]
    assert np.column_stack([nodes["x"], nodes["y"], nodes["z"]]) == pytest.approx(body.point_positions, abs=1e-9)
    mode = sets[kinds.index(55) + 2]
    assert mode["freq"] == pytest.approx(np.sqrt(square[2]) / (2 * np.pi), rel=1e-4)
    place = body.point_names.index("bearing_2")
    assert mode["r3"][place] == pytest.approx(body.row("bearing_2:uz") @ phi[:, 2], rel=1e-4, abs=1e-6)
    response = next(s for s in sets if s["type"] == 58 and (s["rsp_dir"], s["ref_dir"]) == (3, 3))
    omega = 2 * np.pi * response["x"][100]
    dynamic = body.stiffness - omega**2 * body.mass + 1j * omega * body.damping
    into = body.point_names[int(response["ref_node"]) - 1]
    exact = -(omega**2) * body.row("sensor_1:uz") @ la.solve(dynamic, body.row(f"{into}:uz"))
    assert response["data"][100] == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize(("ending", "package"), [("uff", "pyuff"), ("op4", "pyyeti"), ("pch", "pyyeti")])
def test_a_missing_package_is_named_before_anything_is_computed(ending, package, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.setattr("pipelines.runs.single_results.build_casing", lambda *_, **__: pytest.fail("computed"))
    assert main(["casing", "minimal", "--export", str(tmp_path / f"casing.{ending}")]) != 0
    assert f"needs the package {package}: pip install" in capsys.readouterr().err


def test_modes_as_vtu_keep_the_order_of_the_nodes(elastic, tmp_path):
    mesh, modes, body = elastic
    natural = natural_modes(modes)
    assert natural.frequencies == pytest.approx(
        np.sqrt(la.eigh(body.stiffness, body.mass, eigvals_only=True)) / (2 * np.pi), rel=1e-9
    )
    write_vtu(mesh, modes, natural, tmp_path / "modes.vtu", band=float(natural.frequencies[2]))
    found = meshio.read(tmp_path / "modes.vtu")
    assert len(found.point_data) == 3
    assert np.array_equal(found.cells_dict["tetra10"], mesh.elements)
    corners, middle = mesh.elements[:, :4], mesh.elements[:, 4:]
    ends = corners[:, [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]]]  # the order of VTK
    off = found.points[middle] - found.points[ends].mean(axis=2)
    assert np.median(np.linalg.norm(off, axis=2)) < 1e-12
    shape = mode_shapes(modes, natural, [0])[0]
    assert np.linalg.norm(shape, axis=1).max() == pytest.approx(1.0)
    held = np.unique(mesh.patch("ground_1"))
    assert not shape[held].any()


def test_effective_masses_stay_below_the_mass_and_are_printed(elastic):
    natural = natural_modes(elastic[1])
    assert (natural.effective_mass.sum(axis=0) <= natural.total * (1 + 1e-9)).all()
    text = casing_mode_table(natural, 3)
    assert "about z %" in text
    assert "+-" not in text
    assert len(text.splitlines()) == 3 + 3 + 1


def test_a_mode_shape_of_a_casing_stands_still_at_clamped_feet(elastic):
    mesh, modes, body = elastic
    fields = {"mesh": mesh, "modes": modes, "checkup": None, "limits": None, "error": None, "records": (), "band": 1e3}
    casing = Casing(body=body, natural=natural_modes(modes), **fields)
    for mode in range(3):
        length = np.linalg.norm(casing.shape(mode), axis=1)
        assert length.max() == pytest.approx(1.0)
        assert length[modes.nodes[:, 2].argmin()] < 1e-9
    with pytest.raises(InputError, match="mode 999"):
        casing.shape(999)
    with pytest.raises(InputError, match="craig-bampton"):
        replace(casing, modes=None).shape(0)


def test_a_mode_has_one_frequency_and_its_error_band(elastic):
    natural = natural_modes(elastic[1])
    bands = np.full(len(natural.frequencies), np.nan)
    bands[1] = 1.234
    rows = [line.split() for line in casing_mode_table(natural, 2, bands).splitlines()[1:]]
    assert rows[0][:4] == ["mode", "Hz", "+-", "Hz"]
    assert [row[:3] for row in rows[2:4]] == [
        ["1", f"{natural.frequencies[0]:.2f}", "-"],
        ["2", f"{natural.frequencies[1]:.2f}", "1.23"],
    ]


def test_modes_that_are_not_shown_and_modes_without_a_band_are_explained(elastic):
    _, modes, body = elastic
    fields = {"mesh": None, "checkup": None, "limits": None, "error": None, "records": (), "band": 1e3}
    casing = Casing(body=body, modes=modes, natural=natural_modes(modes), **fields)
    casing = replace(casing, checkup=SimpleNamespace(report=lambda: ""))
    total = len(casing.frequencies)
    assert f"Modes 1 to 2 of {total}. To print more, set --modes." in list(_texts(casing, 2))
    assert not [text for text in _texts(casing, total) if text.startswith("Modes 1")]
    limits = SimpleNamespace(orders=np.full(2, np.nan))
    assert "-: no band." in band_words(limits, 0.99, np.array([np.nan, 0.01]))
    assert "-: no band." not in band_words(limits, 0.99, np.array([0.02, 0.01]))


def test_the_band_of_a_frequency_holds_its_own_extrapolated_frequency_and_the_band_of_that(elastic):
    _, modes, body = elastic
    natural = natural_modes(modes)
    frequencies = natural.frequencies[:4]
    limits = SimpleNamespace(
        frequencies=frequencies / 0.99,
        correction=0.01,
        limits=frequencies * (1.0 + np.array([0.0, 0.02, -0.03, 0.0])),
        bands=0.01 * frequencies,
    )
    casing = Casing(
        body=body,
        mesh=None,
        modes=modes,
        natural=natural,
        checkup=None,
        limits=limits,
        error=None,
        records=(),
        band=1.0,
    )
    assert casing.bands[:4] / frequencies == pytest.approx([0.01, 0.03, 0.04, 0.01])
    assert np.isnan(casing.bands[4:]).all()
    sprung = replace(casing, modes=SimpleNamespace(ground="springs"))  # six motions on the mounts come first
    assert np.isnan(sprung.bands[:6]).all()
    assert sprung.bands[6:10] / natural.frequencies[6:10] == pytest.approx([0.01, 0.03, 0.04, 0.01])


def test_an_error_that_is_not_reached_and_what_the_bands_leave_out_are_stated(elastic):
    _, modes, body = elastic
    natural = natural_modes(modes)
    known = natural.frequencies[:4]
    limits = SimpleNamespace(
        frequencies=known,
        correction=0.0,
        limits=known,
        bands=np.array([0.01, 0.03, 0.04, 0.01]) * known,
        orders=np.full(4, 2.4),  # from several element sizes
    )
    fields = {"mesh": elastic[0], "modes": modes, "checkup": None, "error": None, "records": (), "band": 1e3}
    casing = Casing(body=body, natural=natural, limits=limits, requested_error=0.01, **fields)
    assert missed_error(casing) == (
        "casing.error = 1 % is not reached: half of the natural frequencies have uncertainty bands above 2 %. "
        'Set casing.element = "tetrahedron-20", or a smaller casing.error for smaller elements.'
    )
    cubic = replace(casing, limits=SimpleNamespace(**vars(limits) | {"orders": np.full(4, np.nan)}))
    assert missed_error(cubic).endswith("above 2 %. Set a smaller casing.error for smaller elements.")
    assert missed_error(replace(casing, requested_error=0.021)) == ""
    assert missed_error(replace(casing, requested_error=None)) == ""
    assert "casing.band_Hz = 1000 Hz" in reduction_words(to_band=True, band=1e3)
    assert "--error-check computes it up to 1000 Hz" in reduction_words(to_band=False, band=1e3)


def test_an_unknown_ending_is_refused():
    with pytest.raises(InputError, match=r"must end in \.h5 or \.mat or .* or \.uff or \.vtu"):
        writable_file("casing.txt", "--export", FORMATS)


def mode_view(elastic):
    mesh, modes, _ = elastic
    natural = natural_modes(modes)
    shape = mode_shapes(modes, natural, [0])[0]
    return ModeView(
        title="Casing of <a & b>",
        number=1,
        frequency=float(natural.frequencies[0]),
        nodes=mesh.nodes,
        facets=mesh.facets,
        shape=shape,
    )


def test_a_page_needs_nothing_but_itself():
    page = film_page("<a & b>", [b"one", b"two"], "phase", ["0", "180"], 70)
    assert "&lt;a &amp; b&gt;" in page
    assert not re.search(r"(src|href)=\"?http", page)
    assert page.count('"b25l"') == 1


def test_a_mode_is_drawn_with_8_percent_of_the_diagonal(monkeypatch):
    """A block with a diagonal of 1.3 m: the largest displacement is drawn as 0.104 m, after a quarter period."""
    pytest.importorskip("pyvista")
    from pipelines.report.figures import render
    from pipelines.report.figures.renderer import draw_mode

    monkeypatch.setattr(render, "_render", lambda drawn, title, arrays, *others, **more: arrays)
    nodes = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 1.2]])
    shape = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.5], [0.6, 0.8, 0.0], [0.0, 0.2, 0.0]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    arrays = render.render_mode(nodes, triangles, shape, 16)
    drawn = []
    move = draw_mode(SimpleNamespace(add_mesh=lambda mesh, **looks: drawn.append((mesh, looks))), arrays)
    ((body, looks),) = [one for one in drawn if one[1].get("scalars") == "amplitude"]
    np.testing.assert_allclose(body["amplitude"], [0.0, 0.5, 1.0, 0.2])
    assert looks["clim"] == (0.0, 1.0)
    for number, swing in ((0, 0.0), (4, 0.104), (12, -0.104)):
        move(number)
        np.testing.assert_allclose(body.points, nodes + swing * shape, atol=1e-7)


def test_a_picture_of_a_mode_names_size_and_colours(elastic):
    from pipelines.report.figures.views import Picture

    places = {"origin": (0.0, 0.0), "x": (5.0, 0.0), "y": (0.0, 5.0), "z": (3.0, 3.0)}
    picture = Picture(image=np.full((20, 30, 3), 255, np.uint8), places=places)
    figure = mode_figure(mode_view(elastic), picture, np.array([0.3, 0.4, 1.2]))
    left, bar = figure.axes
    assert "body 300 x 400 x 1200 mm (x, y, z)" in left.texts[-1].get_text()
    assert bar.get_ylim() == (0.0, 1.0)
    assert np.linalg.norm(mode_view(elastic).shape, axis=1).max() == pytest.approx(1.0)


def test_the_strain_energy_of_parts_and_the_rest_is_all():
    natural = SimpleNamespace(
        shares=np.array([[0.25, 0.0], [0.5, 0.125]]), part_names=("walls", "ribs"), frequencies=[100.0, 200.0]
    )
    rows = [line.split() for line in part_table(natural, np.array([0.02, 0.03]), 2).splitlines()[-2:]]
    assert rows == [["1", "100.00", "2", "25.00", "50.00", "25.00"], ["2", "200.00", "3", "0.00", "12.50", "87.50"]]


def test_a_sheet_holds_a_still_of_every_mode_at_its_largest_deflection(elastic, tmp_path, monkeypatch):
    from pipelines.report.figures import mode_pictures
    from pipelines.report.figures.views import Picture

    places = {"origin": (0.0, 0.0), "x": (5.0, 0.0), "y": (0.0, 5.0), "z": (3.0, 3.0)}
    shades = []

    def render(nodes, triangles, shape, frames, size):
        shades.append(len(shades))
        return [Picture(image=np.full((20, 30, 3), 10 * number, np.uint8), places=places) for number in range(frames)]

    drawn_sheets = []
    sheet = mode_pictures.sheet_figure
    monkeypatch.setattr(mode_pictures, "render_mode", render)
    monkeypatch.setattr(mode_pictures, "sheet_figure", lambda *some: drawn_sheets.append(some) or sheet(*some))
    views = [replace(mode_view(elastic), number=n, frequency=100.0 * n) for n in range(1, 31)]
    done = []
    found = mode_pictures.write_modes(
        iter(views), len(views), f"{tmp_path}/casing-b", lambda *counts: done.append(counts)
    )
    assert done == [(n, 30) for n in range(1, 31)]
    assert [path.name for path in found] == ["casing-b-modes_1.png", "casing-b-modes_2.png"]
    assert all(path.stat().st_size > 1000 for path in found)
    assert len(shades) == 30
    assert [len(one[0]) for one in drawn_sheets] == [24, 6]
    assert {int(still.image[0, 0, 0]) for _, stills in drawn_sheets for still in stills} == {10}  # a quarter period
    titles = [axes.get_title() for axes in sheet(views[:5], drawn_sheets[0][1][:5]).axes]
    assert titles[4] == "mode 5: 500.0 Hz"


@pytest.mark.slow
def test_pictures_of_a_mode_move(elastic, tmp_path):
    from PIL import Image

    found = drawn(write_mode, mode_view(elastic), f"{tmp_path}/casing-b")
    assert [path.suffix for path in found] == [".png", ".gif", ".html"]
    with Image.open(found[1]) as film:
        assert film.n_frames == 16
        first = np.asarray(film.convert("RGB"), int)
        film.seek(4)
        assert (abs(np.asarray(film.convert("RGB"), int) - first).max(axis=2) > 60).mean() > 0.002


@dataclass(frozen=True)
class _Spec:
    band: float
    other: int


def produce(spec):
    """A stage whose result tells for which band it was made."""
    return f"up to {spec.band}"


def test_what_was_stored_for_a_higher_band_serves_a_lower_one(tmp_path):
    cache = Cache(tmp_path)

    def graph(band, other=1):
        return Graph([Step(name="a", kind="a", build=produce, spec=_Spec(band=band, other=other), enough="band")])

    assert run_graph(graph(300.0), cache, ["a"]).value("a") == "up to 300.0"
    assert run_graph(graph(500.0), cache, ["a"]).value("a") == "up to 500.0"
    outcome = run_graph(graph(200.0), cache, ["a"])
    assert outcome.value("a") == "up to 300.0"  # the smallest that is enough
    assert outcome.records[0].reused
    (status,) = explain(graph(400.0), cache)
    assert (status.action, status.reason) == ("reuse", "stored with a larger band")
    assert run_graph(graph(600.0), cache, ["a"]).value("a") == "up to 600.0"
    assert run_graph(graph(200.0, other=2), cache, ["a"]).value("a") == "up to 200.0"
