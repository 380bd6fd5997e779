"""Features of the parametric housing: exact volumes, refusals with numbers, meshes with everything on."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from crashing import crash
from housings import housing_for_shafts, small_housing

from fem.casing.geometry.dimensions import HousingError, Sensor
from fem.casing.geometry.housing_features import Fillets, Flange, Ribs, Walls
from fem.casing.mesh.choose_mesher import FLAT, mesh_geometry
from fem.casing.mesh.gmsh_mesh import mesh_housing, session
from fem.casing.mesh.housing_solid import build_solid
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import Sizes, bending_wavelength
from fem.casing.models.casing_model import Structure
from fem.casing.models.craig_bampton import CraigBamptonCasing
from fem.casing.reduced.rigid_on_mounts import housing_mass
from fem.elements.materials import CAST_IRON, Material
from fem.elements.solids import mass_properties

RIBS = Ribs(thickness=0.008, height=0.012, per_boss=1, end_wall=2, cover=2)


@pytest.fixture(scope="module")
def small():
    return small_housing()


@pytest.fixture(scope="module")
def plain_volume(small):
    return volume(small)


def with_pads(housing, **more):
    return replace(
        housing,
        feet=replace(housing.feet, overhang=0.03, pad_diameter=0.028, pad_height=0.004, bolt_diameter=0.011, **more),
    )


def everything(housing):
    return replace(
        with_pads(housing),
        walls=Walls(end=0.008, floor=0.012, cover=0.008),
        flange=Flange(split=0.0, width=0.018, height=0.02),
        ribs=RIBS,
        fillets=Fillets(foot=0.005, inner=0.008),
    )


def volume(housing):
    """Of the solid itself (m3), by OpenCASCADE's integral over its surface, without a mesh."""
    with session() as gmsh:
        build_solid(gmsh, housing)
        ((_, tag),) = gmsh.model.getEntities(3)
        return gmsh.model.occ.getMass(3, tag) / 1e9


def test_the_solid_has_the_exact_volume(small, plain_volume):
    assert plain_volume == pytest.approx(housing_mass(small, 1.0)[0], rel=1e-9)


@pytest.mark.parametrize(
    "change",
    [{"walls": Walls(side=0.012, end=0.008, floor=0.014, cover=0.006)}, {"wall_thickness": 0.003}],
)
def test_every_wall_has_its_own_thickness(small, change):
    changed = replace(small, **change)
    assert changed.thinnest_wall == (0.006 if "walls" in change else 0.003)
    assert volume(changed) == pytest.approx(housing_mass(changed, 1.0)[0], rel=1e-9)


def test_ribs_add_their_plates(small, plain_volume):
    end = replace(small, ribs=replace(RIBS, per_boss=0, cover=0))
    assert volume(end) - plain_volume == pytest.approx(4 * 0.008 * 0.012 * small.height, rel=1e-9)
    cover = replace(small, ribs=replace(RIBS, per_boss=0, end_wall=0, cover=3))
    assert volume(cover) - plain_volume == pytest.approx(3 * 0.008 * 0.012 * small.width, rel=1e-9)
    under = replace(small, ribs=replace(RIBS, end_wall=0, cover=0))
    tall = sum(b.z - (b.diameter + b.boss_diameter) / 4 + small.axis_height for b in small.bores)
    assert volume(under) - plain_volume == pytest.approx(0.008 * 0.012 * tall, rel=1e-9)


def test_a_flange_above_the_bosses_is_a_frame(small, plain_volume):
    flange = Flange(split=0.06, width=0.015, height=0.016)
    length, width = small.length + 0.03, small.width + 0.03
    frame = (length * width - small.length * small.width) * 0.016
    assert volume(replace(small, flange=flange)) - plain_volume == pytest.approx(frame, rel=1e-9)


def test_a_flange_at_the_bores_stops_at_the_bosses(small, plain_volume):
    """The bearing seats stay what they were: two interrupted sides, two whole ends."""
    flange = Flange(split=0.0, width=0.015, height=0.016)
    length, width = small.length + 0.03, small.width + 0.03
    gone = 0.0
    for bore in small.bores:
        r, h = bore.boss_diameter / 2, 0.008  # a band of a circle: |z| < h
        gone += 0.015 * 2 * (h * np.sqrt(r**2 - h**2) + r**2 * np.arcsin(h / r))
    frame = (length * width - small.length * small.width) * 0.016 - gone
    assert volume(replace(small, flange=flange)) - plain_volume == pytest.approx(frame, rel=1e-6)


def test_bolt_pads_and_holes(small, plain_volume):
    """Overhang o, pad and hole: o L h + pi/4 (D^2 - d^2) h_pad - pi/4 d^2 h for each foot."""
    foot = 0.03 * 0.04 * 0.015 + np.pi / 4 * ((0.028**2 - 0.011**2) * 0.004 - 0.011**2 * 0.015)
    padded = with_pads(small)
    assert volume(padded) - plain_volume == pytest.approx(6 * foot, rel=1e-9)
    points = padded.ground_points()
    assert all(point[2] == pytest.approx(-0.08 - 0.015 - 0.004) for point in points.values())
    assert points["ground_2"][1] == -points["ground_1"][1] == pytest.approx(0.08 + 0.015)


def test_inner_fillets_fill_the_edges_of_the_cavity(small, plain_volume):
    """12 edges lose (1 - pi/4) r^2 per length, 8 corners (1 - pi/6) r^3 of the cube of side 2 r each eighth."""
    r, (low, high) = 0.006, small.cavity
    edges = (4.0 - np.pi) * r**2 * float((high - low - 2 * r).sum())
    corners = (8.0 - 4.0 * np.pi / 3.0) * r**3
    assert volume(replace(small, fillets=Fillets(inner=r))) - plain_volume == pytest.approx(edges + corners, rel=1e-6)


def test_foot_fillets_add_a_little(small, plain_volume):
    for housing, before in ((small, plain_volume), (with_pads(small), None)):
        added = volume(replace(housing, fillets=Fillets(foot=0.005))) - (before or volume(housing))
        edge = (1 - np.pi / 4) * 0.005**2  # per length of rounded edge: 40 mm at the wall, or three sides at the floor
        assert 0.9 * 6 * edge * 0.04 < added < 6 * edge * 0.13


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"walls": Walls(floor=0.1, cover=0.07)}, "floor and cover are 170 mm thick together"),
        (
            {"flange": Flange(split=0.078, width=0.01, height=0.02)},
            "flange from z = 68 mm to 88 mm is not on the walls",
        ),
        (
            {"flange": Flange(split=0.052, width=0.01, height=0.02)},
            r"the flange is .* outside the boss of bearing_3 \(negative: inside; allowed: 3 mm or more, or -3 mm or",
        ),
        ({"ribs": replace(RIBS, end_wall=14)}, "rib 1 of the -x wall and rib 2 of the -x wall leave only 2.66"),
        ({"ribs": replace(RIBS, per_boss=3, thickness=0.02)}, "3 ribs of 20 mm under bearing_1 reach 31.6"),
        ({"ribs": Ribs(thickness=0.01, height=0.01)}, "there are no ribs"),
        ({"fillets": Fillets(foot=0.02)}, r"foot fillet radius is 20 mm \(limit: 0 to below 15 mm"),
        ({"fillets": Fillets(inner=0.0001)}, r"inner fillet radius is 0.1 mm; faces below 0.5 mm cannot be meshed"),
    ],
)  # fmt: skip
def test_unsound_features_are_refused_with_numbers(small, change, message):
    with pytest.raises(HousingError, match=message):
        replace(small, **change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": (0.0,)}, "1 feet along each side wall"),
        ({"pad_diameter": 0.02}, "or none"),
        ({"pad_diameter": 0.05, "pad_height": 0.003}, r"do not fit on the foot \(limit 40 mm\)"),
        ({"pad_diameter": 0.03, "pad_height": 0.003, "bolt_diameter": 0.012}, "extend 18 mm beyond"),
        ({"bolt_diameter": 0.012, "overhang": 0.03}, "bolt holes of 12 mm need bolt pads"),
    ],
)
def test_unsound_feet_are_refused_with_numbers(small, change, message):
    with pytest.raises(HousingError, match=message):
        replace(small, feet=replace(small.feet, **change))


def test_a_fillet_that_opencascade_cannot_make_is_refused_with_the_remedy(small):
    with pytest.raises(MeshError, match=r"edges of the foot fillets with a radius of 14\.9 mm.*Use a smaller radius"):
        mesh_housing(replace(small, fillets=Fillets(foot=0.0149)), element_size=0.04)


def test_a_housing_with_everything_on_is_meshed(small):
    housing = everything(small)
    mesh = mesh_housing(housing, element_size=0.06)
    assert mesh.quality > 0.05
    assert [n for n in mesh.patch_names if n.startswith("ground")] == [f"ground_{i}" for i in range(1, 7)]
    meshed = mass_properties(mesh.nodes, mesh.elements, 1.0)[0]
    assert meshed == pytest.approx(volume(housing), rel=5e-3)  # coarse: fillets are met in flat facets


def test_ribs_that_touch_are_refused_without_rounding_noise(small):
    pitch = small.width / 15  # of 14 ribs
    with pytest.raises(HousingError, match="rib 1 of the -x wall and rib 2 of the -x wall touch"):
        replace(small, ribs=replace(RIBS, end_wall=14, thickness=pitch))


def test_the_remedy_for_a_coarser_mesh_names_the_size_of_the_scene():
    assert "casing.element_size_mm below 10 " in Sizes(element=0.010).times(1.3).smaller


def stepped(housing, step):
    """The first foot ends `step` (m) before the rib under the first boss; both start at the underside of the floor."""
    ribs, feet = Ribs(thickness=0.008, height=0.02, per_boss=1), replace(housing.feet, overhang=0.02)
    edge = housing.bores[0].x - ribs.thickness / 2 - step
    return replace(housing, ribs=ribs, feet=replace(feet, x=(edge - feet.length / 2, *feet.x[1:])))


@pytest.mark.parametrize("element_size", [0.018, 0.014])
def test_a_foot_that_almost_coincides_with_a_rib_is_meshed(element_size):
    assert mesh_housing(stepped(housing_for_shafts(), 0.00025), element_size=element_size).quality > 0.05


def test_a_step_too_small_to_mesh_is_refused_with_its_place_and_parts():
    with pytest.raises(MeshError, match=r"0\.01 mm at .*ground_1 and rib 1 under bearing_1.*1\.8 mm or more"):
        mesh_housing(stepped(housing_for_shafts(), 0.00001), element_size=0.018)


@pytest.mark.slow
def test_a_housing_with_everything_on_is_reduced_and_stiffer():
    """On the whole rig: the check-up passes and ribs, flange and fillets raise the first mode."""
    plain, full = housing_for_shafts(), everything(housing_for_shafts())
    first = []
    for housing in (plain, replace(full, walls=plain.walls, feet=plain.feet)):
        model = CraigBamptonCasing(band=800.0, element_size=0.03)
        structure = Structure(housing=housing, material=CAST_IRON)
        modes, check = model.reduction(structure).build(mesh=model.meshed(structure).stage.build())
        assert check.failures == ()
        first.append(modes.fixed_frequencies[0])
    assert first[1] > 1.02 * first[0]


def test_bending_wavelength_of_a_steel_plate():
    """10 mm of steel at 1 kHz: lambda = sqrt(2 pi c_l t / (sqrt(12) f)), c_l = sqrt(E / (rho (1 - nu^2)))."""
    steel = Material(name="steel", elastic_modulus=206e9, poisson_ratio=0.3, density=7850.0)
    speed = np.sqrt(206e9 / (7850.0 * (1 - 0.3**2)))
    expected = np.sqrt(2 * np.pi * speed * 0.01 / (np.sqrt(12) * 1000.0))
    assert bending_wavelength(steel, 0.01, 1000.0) == pytest.approx(expected, rel=1e-12)
    assert bending_wavelength(steel, 0.01, 4000.0) == pytest.approx(expected / 2, rel=1e-12)


def test_elements_are_finer_at_bores_and_feet(small):
    coarse = mesh_housing(small, element_size=0.04)
    fine = mesh_housing(small, sizes=Sizes(element=0.04, bore=0.008, foot=0.012))
    for name in ("bearing_1", "ground_1"):
        assert len(fine.patch(name)) > 2 * len(coarse.patch(name))
    same = mesh_housing(small, sizes=Sizes(element=0.04, bore=0.1, foot=None))
    assert same.digest() == coarse.digest()


def test_elements_follow_fillets_that_are_smaller_than_they_are(small):
    """Straightened across a fillet, elements of 32 mm would fill it up: by 0.5 % of this body."""
    filleted = replace(small, fillets=Fillets(foot=0.009, inner=0.01))
    mesh = mesh_housing(filleted, element_size=0.032)
    meshed, _, _ = mass_properties(mesh.nodes, mesh.elements, 1.0)
    assert meshed == pytest.approx(volume(filleted), rel=3e-4)


def test_larger_elements_are_larger_around_bores_and_pads_too(small):
    """Three sizes tell an error only where it changes with all of them."""
    padded, sizes = with_pads(small), Sizes(element=0.045)
    fine, coarse = (mesh_housing(padded, sizes=one) for one in (sizes, sizes.times(1.7)))
    for name in ("bearing_1", "ground_1"):
        assert len(fine.patch(name)) > 1.5 * len(coarse.patch(name))
    assert sizes.times(0.5).at_foot(0.028) == pytest.approx(0.5 * sizes.at_foot(0.028))


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_a_closed_pipe_is_still_an_error_after_meshing_and_not_the_end_of_the_process():
    code = (
        "import os; from fem.casing.mesh.gmsh_mesh import session\n"
        "with session(): pass\n"
        "end, start = os.pipe(); os.close(end)\n"
        "try: os.write(start, b'x')\n"
        "except BrokenPipeError: print('told')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "told"), done.stderr


def test_sensor_axes_must_be_orthonormal():
    Sensor(name="sensor_1", position=(0, 0, 0), axes=((0, 1, 0), (-1, 0, 0), (0, 0, 1)))
    with pytest.raises(HousingError, match="they are not orthogonal"):
        Sensor(name="sensor_1", position=(0, 0, 0), axes=((1, 0, 0), (1, 1, 0), (0, 0, 1)))


def test_a_crash_of_the_mesher_is_an_error_with_a_remedy(monkeypatch):
    """gmsh ends its process on some flat tetrahedra, so that it meshes these in a process of its own."""
    housing = small_housing()
    monkeypatch.setattr("fem.casing.mesh.gmsh_mesh.mesh_housing", crash)
    with pytest.raises(MeshError, match=r"^the mesher crashed \(SIGABRT\); set another casing.element_size_mm"):
        mesh_geometry(housing, Sizes(element=1.1 * FLAT * housing.thinnest_wall))
