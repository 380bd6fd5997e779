"""Housings, their meshes, models and check-up."""

import threading
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from factored_casing import factored
from housings import housing_for_shafts, short_housing

from fem.casing.geometry.dimensions import HousingError, Sensor
from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.casing.models.casing_model import Structure
from fem.casing.models.craig_bampton import CraigBamptonCasing
from fem.casing.models.no_casing import NoCasing
from fem.casing.models.rigid_casing import RigidCasing
from fem.casing.models.static_casing import StaticCasing
from fem.casing.reduced.attachment import AttachmentError
from fem.casing.reduced.casing_modes import CasingModes, casing_modes, reduced_body
from fem.casing.reduced.checkup import check_up
from fem.casing.reduced.grounded import assembled_casing, asymmetry
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.reduced_body import BEARING_AXES
from fem.casing.reduced.reduction import reduce_body
from fem.casing.reduced.rigid_on_mounts import housing_mass
from fem.elements.facets import surface_weights
from fem.elements.materials import CAST_IRON
from fem.elements.solids import mass_properties

BAND = 3500.0


@pytest.fixture(scope="module")
def rig():
    return housing_for_shafts()


@pytest.fixture(scope="module")
def small():
    return short_housing()


@pytest.fixture(scope="module")
def mesh(small):
    return mesh_housing(small, element_size=0.04)


@pytest.fixture(scope="module")
def casing(mesh):
    return factored(assembled_casing(mesh, CAST_IRON))


@pytest.fixture(scope="module")
def reduction(casing):
    return reduce_body(casing.interface, casing.K_free, casing.M_free, highest=1.5 * BAND)


@pytest.fixture(scope="module")
def modes(casing, reduction):
    return casing_modes(casing, reduction, model="craig-bampton", band_limit=1.5 * BAND)


def test_rig_layout(rig):
    assert [b.name for b in rig.bores] == [f"bearing_{i}" for i in range(1, 9)]
    assert all((b.side < 0) == (int(b.name[-1]) % 2 == 1) for b in rig.bores)
    assert list(rig.ground_points()) == [f"ground_{i}" for i in range(1, 7)]
    assert [s.name for s in rig.sensors] == [f"sensor_{i}" for i in range(1, 10)]
    bore, sensor = next(one for one in rig.bores if one.name == "bearing_3"), rig.sensors[2].position
    distance = np.hypot(sensor[0] - bore.x, sensor[2] - bore.z)
    assert bore.diameter / 2 < distance < bore.boss_diameter / 2  # on the rim of its boss
    assert sensor[1] == -rig.width / 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"wall_thickness": 0.2}, "wall thickness 200 mm fills the housing"),
        (
            {"shaft_x": (0.0, 0.03, 0.18275, 0.31569)},
            r"bosses of bearing_1 and bearing_3 overlap by 42.5 mm \(limit: a ligament of 3 mm or more\)\. With the "
            r"thinnest rings allowed, 3 mm, the sum of their boss diameters is 121 mm\. Raise the distance of their "
            r"axes from 30 mm to 63.5 mm or more, or reduce bore_diameters_mm",
        ),
        (
            {"shaft_x": (0.0, 0.074, 0.18275, 0.31569)},
            r"leave a ligament of only 1.5 mm \(limit: a ligament of 3 mm or more\)\. Reduce the sum of their "
            r"boss diameters from 145 mm to 142 mm or less, or raise the distance of their axes from 74 mm to 75.5 mm",
        ),
        ({"shaft_x": (0.0, 0.07668, 0.18275, 0.45)}, "boss at x = 450 mm, z = 0 mm extends 40 mm beyond the inner"),
        (
            {"boss_diameters": (0.049, 0.08, 0.097, 0.12)},
            "boss ring is 1 mm thick, and must be at least 3 mm. Raise its boss_diameters_mm from 49 mm to "
            "53 mm or more, or reduce its bore_diameters_mm from 47 mm to 43 mm or less",
        ),
        ({"boss_length": 0.005}, "boss length 5 mm is less than the wall"),
        ({"boss_length": 0.16}, "reaches the opposite boss"),
        ({"foot_length": 0.2}, "feet of 200 mm meet"),
    ],
)
def test_unsound_housings_are_refused_with_numbers(change, message):
    with pytest.raises(HousingError, match=message):
        housing_for_shafts(**change)


def test_double_names_are_refused(rig):
    with pytest.raises(HousingError, match="'sensor_1' occurs 2 times"):
        replace(rig, sensors=(rig.sensors[0], rig.sensors[0]))


def test_mesh_has_the_mass_of_the_housing(small, mesh):
    meshed, exact = mass_properties(mesh.nodes, mesh.elements, 7200.0), housing_mass(small, 7200.0)
    assert meshed[0] == pytest.approx(exact[0], rel=5e-5)
    assert np.abs(meshed[1] - exact[1]).max() < 1e-5
    assert np.abs(meshed[2] - exact[2]).max() < 1e-4 * np.trace(exact[2])


def test_patches_have_the_area_of_bores_and_feet(small, mesh):
    for bore in small.bores:
        area = surface_weights(mesh.nodes, mesh.patch(bore.name))[2].sum()
        assert area == pytest.approx(np.pi * bore.diameter * bore.boss_length, rel=1e-3)
    for name in mesh.patches("ground_"):
        assert surface_weights(mesh.nodes, mesh.patch(name))[2].sum() == pytest.approx(0.03**2, rel=1e-9)
    volume = np.einsum("fd,fd->", *_facet_moments(mesh)) / 3  # the whole surface is closed
    assert abs(volume) == pytest.approx(mass_properties(mesh.nodes, mesh.elements, 1.0)[0], rel=1e-2)


def _facet_moments(mesh):
    """Mean place and area vector of each facet (flat approximation)."""
    corners = mesh.nodes[mesh.facets[:, :3]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    return corners.mean(axis=1), normal


def test_same_input_same_mesh_in_any_thread(small, mesh):
    found = []
    worker = threading.Thread(target=lambda: found.append(mesh_housing(small, element_size=0.04)))
    worker.start()
    worker.join()
    assert found[0].digest() == mesh.digest()


def test_mesh_and_modes_are_stored(mesh, modes, tmp_path):
    for record, kind in ((mesh, CasingMesh), (modes, CasingModes)):
        record.save(tmp_path / "record.h5")
        assert kind.load(tmp_path / "record.h5").digest() == record.digest()


def test_element_size_out_of_range_is_refused(small):
    with pytest.raises(MeshError, match="element size 1000 mm is out of range"):
        mesh_housing(small, element_size=1.0)
    with pytest.raises(MeshError, match="no patch 'bearing_9'; known: ground_1"):
        mesh_housing(small, element_size=0.05).patch("bearing_9")


def frequency_errors(casing, found, band):
    """Frequencies of the reduced over those of the full grounded model up to a band (Hz), less 1."""
    theta, _ = block_lanczos(casing.interface.factor.solve, casing.M_free, smallest=(2 * np.pi * band) ** -2.0)
    return found.frequencies[: len(theta)] * 2 * np.pi * np.sqrt(theta) - 1.0


def test_check_up_passes(casing, reduction):
    found = check_up(casing, reduction)
    assert found.failures == ()
    assert dict(zip(found.item_names, found.items, strict=True))["rigid_eigenvalue"] < 1e-8
    errors = frequency_errors(casing, found, BAND)
    assert len(errors) >= 3
    assert errors.min() > -1e-9  # from above
    assert errors.max() < 1e-3
    text = found.report()
    assert "static_response" in text
    assert "FAIL" not in text


def test_check_up_finds_a_wrong_reduction(casing, reduction):
    wrong = replace(reduction, stiffness=reduction.stiffness * 1.01, modes=reduction.modes * 1.001)
    assert set(check_up(casing, wrong).failures) >= {"static_response", "modal_mass_identity"}


def test_reduced_body_has_interface_and_recovered_rows(small, modes):
    body = CraigBamptonCasing(band=BAND).recovery(Structure(housing=small)).build(modes=(modes, None))
    assert body.coordinate_names[:6] == tuple(f"bearing_1:{a}" for a in ("ux", "uy", "uz", "rx", "rz")) + (
        "bearing_2:ux",
    )
    assert np.array_equal(body.row("bearing_2:uz"), np.eye(len(body.mass))[7])
    assert len(body.row_names) == 10 + 3 * len(small.sensors)
    one = reduced_body(modes, sensors=[place for place in small.sensors if place.name == "sensor_2"])
    assert len(one.row_names) == 10 + 3
    assert np.array_equal(one.row("sensor_2:uz"), body.row("sensor_2:uz"))


def test_sensor_rows_read_the_full_model(casing, reduction, modes, small):
    """Static response of a sensor to a bearing force, against the full model at the nearest node."""
    mesh = casing.mesh
    node = mesh.facets[mesh.facet_patch < 0][10, 0]
    sensor = Sensor(name="sensor_1", position=tuple(mesh.nodes[node]))
    body = reduced_body(modes, sensors=[sensor])
    load = casing.interface.rows.T @ np.eye(10)[2]
    full = casing.expanded(casing.interface.factor.solve(load))
    q = la.solve(body.stiffness, body.row("bearing_1:uz"))
    found = np.array([body.row(f"sensor_1:{axis}") @ q for axis in ("ux", "uy", "uz")])
    assert found == pytest.approx(full[3 * node : 3 * node + 3], abs=1e-5 * np.abs(full).max())


def test_every_mode_has_the_damping_ratio_asked(modes):
    body = reduced_body(modes, damping=0.02)
    square, phi = la.eigh(body.stiffness, body.mass)
    assert np.allclose(phi.T @ body.damping @ phi, np.diag(0.04 * np.sqrt(square)), atol=1e-7 * np.sqrt(square[-1]))


def test_a_sensor_away_from_the_casing_is_refused(modes):
    with pytest.raises(AttachmentError, match="from the nearest point of the surface"):
        reduced_body(modes, sensors=[Sensor(name="sensor_1", position=(0.0, 1.0, 0.0))])


def test_model_none_has_rows_without_coordinates(small):
    body = NoCasing().reduce(bearings={bore.name: small.bore_centre(bore) for bore in small.bores})
    assert body.rows.shape == (10, 0)
    assert body.row("bearing_2:rz").size == 0
    assert NoCasing().reduce(bearings={"bearing_1": (0.0, -0.1, 0.0)}).point_names == ("bearing_1",)


def test_model_rigid_moves_as_one_body(small):
    body = RigidCasing(mount_stiffness=1e8, damping_ratio=0.0).reduce(small, CAST_IRON)
    mass, centre, _ = housing_mass(small, CAST_IRON.density)
    assert body.mass[0, 0] == mass
    assert np.diag(body.stiffness)[:3] == pytest.approx(4e8)
    assert not body.damping.any()
    lift = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert all(body.row(f"bearing_{i}:uz") @ lift == 1.0 for i in (1, 2))
    turn = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])  # about x: uz = y
    assert body.row("bearing_2:uz") @ turn == pytest.approx(
        small.bore_centre(next(one for one in small.bores if one.name == "bearing_2"))[1]
    )
    assert body.row("bearing_2:rx") @ turn == 1.0
    assert body.row("sensor_9:uy") @ turn == pytest.approx(centre[2] - small.sensors[-1].position[2])


def test_model_static_has_only_interface_coordinates(mesh, casing, small):
    model, structure = StaticCasing(), Structure(housing=replace(small, sensors=small.sensors[2:3]), material=CAST_IRON)
    modes, check = model.reduction(structure).build(mesh=mesh)
    assert check.failures == ()
    body = model.recovery(structure).build(modes=(modes, check))
    assert body.model == "static"
    assert body.mass.shape == (10, 10)
    assert la.inv(body.stiffness) == pytest.approx(la.inv(casing.interface.stiffness), rel=1e-9)


def test_one_call_does_all_stages(small):
    body = CraigBamptonCasing(band=500.0, element_size=0.05).reduce(small, CAST_IRON)
    assert body.model == "craig-bampton"
    assert la.eigvalsh(body.mass).min() > 0
    assert la.eigvalsh(body.damping).min() > -1e-6 * np.abs(body.damping).max()


def test_stiffer_material_scales_frequencies(mesh):
    """Hz go with the root of E: a check of units from material to modes."""
    found = []
    for E in (1e9, 4e9):
        casing = factored(
            assembled_casing(mesh, replace(CAST_IRON, elastic_modulus=E), interfaces={"bearing_1": BEARING_AXES})
        )
        reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=0, enrich=False)
        found.append(np.sqrt(la.eigvalsh(reduction.stiffness, reduction.mass)))
    soft, stiff = found
    assert stiff == pytest.approx(2 * soft, rel=1e-6)


@pytest.mark.slow
def test_rig_housing_passes_its_check_up(rig):
    model = CraigBamptonCasing(band=2000.0, element_size=0.03)
    casing = factored(assembled_casing(model.meshed(Structure(housing=rig)).stage.build(), CAST_IRON))
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=3000.0)
    found = check_up(casing, reduction)
    assert found.failures == ()
    assert frequency_errors(casing, found, 2000.0).max() < 1e-3


@pytest.mark.parametrize("error", [1e-9, -1.0])
def test_one_entry_that_differs_from_its_mirror_is_measured_at_its_size(error):
    places, values = np.random.default_rng(1).random((2, 300, 300))
    half = sp.csr_array(np.where(places < 0.02, values, 0.0))
    whole = (half + half.T).tolil()
    assert asymmetry(whole.tocsr()) < 1e-14
    whole[3, 40] += error * whole.tocsr().max()
    assert asymmetry(whole.tocsr()) == pytest.approx(abs(error), rel=1e-5)
