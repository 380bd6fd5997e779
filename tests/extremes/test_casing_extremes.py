"""Extremes of a casing: the right answer or a clear refusal, never a silent wrong one."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
from factored_casing import factored
from housings import small_housing

from fem.casing.geometry.dimensions import HousingError, Sensor
from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.models.casing_model import Structure
from fem.casing.models.static_casing import StaticCasing
from fem.casing.reduced.casing_modes import casing_modes, reduced_body
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.reduction import reduce_body
from fem.casing.reduced.reduction_error import reduced_response
from fem.casing.reduced.rigid_on_mounts import housing_mass, rigid_body
from fem.elements.materials import Material
from fem.elements.solids import mass_properties


def single(**changes):
    """A housing with one bearing only."""
    housing = small_housing(**changes)
    return replace(housing, bores=housing.bores[:1], sensors=())


@pytest.fixture(scope="module")
def mesh():
    return mesh_housing(single(), element_size=0.05)


def material(E=110e9, nu=0.26, density=7200.0):
    return Material(name="cast iron, changed", elastic_modulus=E, poisson_ratio=nu, density=density)


def reduced(mesh, iron, highest):
    casing = factored(assembled_casing(mesh, iron))
    return casing_modes(
        casing,
        reduce_body(casing.interface, casing.K_free, casing.M_free, highest=highest),
        model="craig-bampton",
        band_limit=highest,
    )


@pytest.fixture(scope="module")
def usual(mesh):
    return reduced(mesh, material(), 2500.0)


def frequencies(modes):
    return np.sqrt(la.eigvalsh(modes.stiffness, modes.mass)) / (2 * np.pi)


@pytest.mark.parametrize(
    ("change", "factor"),
    [({"E": 1e9}, 110**-0.5), ({"E": 1e15}, (1e15 / 110e9) ** 0.5), ({"density": 1.0}, 7200**0.5)],
)
def test_frequencies_go_with_the_root_of_stiffness_over_density(mesh, usual, change, factor):
    """From rubber-like to all but rigid, and as the mass vanishes: similarity is exact."""
    modes = reduced(mesh, material(**change), 2500.0 * factor)
    assert len(modes.mass) == len(usual.mass)
    assert frequencies(modes) == pytest.approx(factor * frequencies(usual), rel=1e-6)


def test_a_stiff_housing_tends_to_the_rigid_model(mesh):
    """On equal mounts, to 1e6 GPa: the accelerance across all mount modes tends to the rigid one as 1/E."""
    mounts, sensor = 2e7, Sensor(name="sensor_1", position=(0.03, 0.0, 0.08))
    rigid = rigid_body(mesh, density=7200.0, mount_stiffness=mounts, damping_ratio=0.01, sensors=[sensor])
    loads = [f"bearing_1:{axis}" for axis in ("ux", "uy", "uz")]
    at = np.linspace(20.0, 600.0, 59)
    acceleration = -((2 * np.pi * at[:, None, None]) ** 2)
    exact = acceleration * reduced_response(rigid, loads, ["sensor_1"], at)
    moduli, errors = (1e11, 1e13, 1e15), []
    for E in moduli:
        casing = factored(assembled_casing(mesh, material(E=E), ground="springs"))
        highest = 2500.0 * (E / 110e9) ** 0.5
        reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=highest)
        modes = casing_modes(casing, reduction, model="craig-bampton", band_limit=highest)
        body = reduced_body(modes, sensors=[sensor], mounts=((mounts,) * 3,))
        found = acceleration * reduced_response(body, loads, ["sensor_1"], at)
        errors.append(np.linalg.norm(found - exact) / np.linalg.norm(exact))
    rate = -np.diff(np.log(errors)) / np.diff(np.log(moduli))
    assert rate == pytest.approx(1.0, abs=0.1)
    assert errors[-1] < 2e-4


def test_a_nearly_incompressible_housing_does_not_lock(mesh, usual):
    """At equal shear modulus the walls bend with E / (1 - nu^2), a little stiffer; locking would multiply it."""
    E = 110e9 * 1.49 / 1.26
    modes = reduced(mesh, material(E=E, nu=0.49), 2500.0)
    ratio = frequencies(modes)[0] / frequencies(usual)[0]
    assert 1.0 < ratio < np.sqrt(E * (1 - 0.26**2) / (110e9 * (1 - 0.49**2))) * 1.02


THICK = {
    "wall_thickness": 0.06, "width": 0.4, "height": 0.4, "axis_height": 0.2, "length": 0.5, "left": -0.2,
    "boss_length": 0.07, "bore_diameters": (0.02, 0.02), "boss_diameters": (0.058, 0.058),
}  # fmt: skip


EXTREMES = pytest.mark.parametrize(
    ("change", "size"),
    [({"wall_thickness": 0.003}, 0.05), (THICK, 0.08), ({"length": 3.2, "left": -1.6}, 0.16)],
    ids=["wall 3 mm", "wall 60 mm", "aspect 1:20"],
)


@EXTREMES
def test_thin_thick_and_long_housings_are_meshed_with_the_right_mass(change, size):
    housing = single(**change)
    mesh = mesh_housing(housing, element_size=size)
    assert mesh.quality > 0.1
    exact = housing_mass(housing, 7200.0)
    assert mass_properties(mesh.nodes, mesh.elements, 7200.0)[0] == pytest.approx(exact[0], rel=2e-4)


@pytest.mark.slow
@EXTREMES
def test_thin_thick_and_long_housings_pass_the_check_up(change, size):
    model = StaticCasing(element_size=size)
    structure = Structure(housing=small_housing(**change), material=material())
    modes, check = model.reduction(structure).build(mesh=model.meshed(structure).stage.build())
    assert check.failures == ()
    assert (la.eigvalsh(modes.stiffness) > 0.0).all()


def test_a_60_mm_wall_with_thin_boss_rings_is_refused():
    with pytest.raises(HousingError, match="boss ring is 9 mm thick, and must be at least 18 mm"):
        small_housing(wall_thickness=0.06)


def test_a_sensor_on_the_edge_of_a_bore_reads_the_bore(mesh, usual):
    """On the rim the motion is that of the seat within the strain over its length; the place stays on the rim."""
    housing = single()
    bore = housing.bores[0]
    rim = (bore.x, bore.side * housing.width / 2, bore.z + bore.diameter / 2)
    body = reduced_body(usual, sensors=[Sensor(name="sensor_1", position=rim)])
    place = body.point_positions[body.point_names.index("sensor_1")]
    assert np.linalg.norm(place - rim) < 2e-4
    q = la.solve(body.stiffness, body.row("bearing_1:uz"))
    assert body.row("sensor_1:uz") @ q == pytest.approx(body.row("bearing_1:uz") @ q, rel=0.3)


def test_sensor_axes_turn_what_it_reads(usual):
    """A turned sensor reads the same vector in its own axes."""
    c, s = np.cos(0.3), np.sin(0.3)
    axes = ((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0))
    place = (0.03, 0.0, 0.08)
    straight, turned = (
        reduced_body(usual, sensors=[Sensor(name="sensor_1", position=place, **more)]) for more in ({}, {"axes": axes})
    )
    rows = [np.array([b.row(f"sensor_1:{a}") for a in ("ux", "uy", "uz")]) for b in (straight, turned)]
    assert np.allclose(rows[1], np.array(axes) @ rows[0], rtol=0, atol=1e-15)
