"""Damping by part: every part damps a mode in proportion to its share of the strain energy."""

import numpy as np
import pytest
import scipy.linalg as la
from factored_casing import factored
from housings import small_housing

from fem.casing.enrichment.added_unknowns import added_functions
from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.mesh.mesh import MeshError
from fem.casing.parts.regions import Region
from fem.casing.reduced.casing_modes import casing_modes, natural_modes, reduced_body
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.reduction import reduce_body
from fem.casing.reduced.reduction_error import state_error
from fem.elements.materials import CAST_IRON
from pipelines.io.errors import SceneError
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene

BAND = 1500.0
FAR = np.inf
COVER = Region(name="cover", low=(-FAR, -FAR, 0.0), high=(FAR, FAR, FAR))
FEET = Region(name="feet", low=(-FAR, -FAR, -FAR), high=(FAR, FAR, -0.08))
MOUNTS = ((2e7, 3e7, 5e7),)


@pytest.fixture(scope="module")
def mesh():
    return mesh_housing(small_housing(), element_size=0.07)


@pytest.fixture(scope="module", params=["fixed", "springs"])
def casing(request, mesh):
    return factored(assembled_casing(mesh, CAST_IRON, ground=request.param, regions=(COVER, FEET)))


@pytest.fixture(scope="module")
def modes(casing):
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, highest=1.5 * BAND)
    return casing_modes(casing, reduction, model="craig-bampton", band_limit=1.5 * BAND)


def mounts(modes):
    return MOUNTS if modes.ground == "springs" else None


def ratios(body):
    square, phi = la.eigh(body.stiffness, body.mass)
    return np.einsum("ik,ij,jk->k", phi, body.damping, phi) / (2 * np.sqrt(square))


def stiffness_of(mesh, chosen):
    """Of some elements (bool)."""
    return added_functions(mesh, CAST_IRON, held=()).matrices(np.flatnonzero(chosen))[0]


def test_parts_of_the_stiffness_add_up(mesh):
    """All elements together, in two halves, give the stiffness of the housing."""
    middle = mesh.nodes[mesh.elements[:, :4]].mean(axis=1)
    halves = [stiffness_of(mesh, chosen) for chosen in (middle[:, 2] > 0, middle[:, 2] <= 0)]
    whole = assembled_casing(mesh, CAST_IRON, ground="springs").K_free
    assert abs(halves[0] + halves[1] - whole).max() < 1e-12 * abs(whole).max()


def test_without_loss_factors_every_mode_has_the_ratio_of_the_casing(modes):
    plain = reduced_body(modes, damping=0.013, mounts=mounts(modes))
    assert ratios(plain) == pytest.approx(0.013, rel=1e-8)
    same = dict.fromkeys(("cover", "feet"), 0.026)
    body = reduced_body(modes, damping=0.013, mounts=mounts(modes), loss_factors=same)
    assert ratios(body) == pytest.approx(0.013, rel=1e-8)


def test_a_mode_is_damped_by_its_shares_of_the_strain_energy(casing, modes):
    """Shares from the fields of the mesh, mode by mode; the rest of the energy has the ratio of the casing."""
    body = reduced_body(
        modes, damping=0.01, mounts=mounts(modes), loss_factors={"feet": 0.0, "cover": 0.2}, stiffness_factor=0.98
    )
    square, phi = la.eigh(body.stiffness, body.mass)
    fields = modes.basis.reshape(-1, len(square)).astype(float) @ phi[:, :12]
    expected = np.full(12, 0.01)
    for region, zeta in ((COVER, 0.1), (FEET, 0.0)):
        middle = casing.mesh.nodes[casing.mesh.elements[:, :4]].mean(axis=1)
        chosen = ((middle > region.low) & (middle < region.high)).all(axis=1)
        K = 0.98 * stiffness_of(casing.mesh, chosen)
        expected += np.einsum("ik,ik->k", fields, K @ fields) / square[:12] * (zeta - 0.01)
    assert ratios(body)[:12] == pytest.approx(expected, rel=1e-5)
    assert np.ptp(expected) > 0.02


def test_shares_of_natural_modes_are_parts_of_the_whole(modes):
    found = natural_modes(modes, mounts(modes))
    sprung = modes.ground == "springs"
    assert found.part_names == (("cover", "feet", "mounts") if sprung else ("cover", "feet"))
    assert (found.shares > -1e-12).all()
    assert (found.shares.sum(axis=0) < 1 + 1e-9).all()
    if sprung:  # the body is stiff beside soft mounts: they store nearly all of its six lowest motions
        soft = natural_modes(modes, ((1e5, 1e5, 1e5),))
        assert (soft.shares[2, :6] > 0.99).all()


def test_one_mount_of_two_springs_damps_as_a_spring_of_their_loss_factors():
    """A mass between the ground and two springs, loss factors 0.1 and 0.3: the complex spring, to the second order."""
    from fem.casing.reduced.damping import modal_damping

    k, eta = np.array([3e6, 1e6]), np.array([0.1, 0.3])
    mass, stiffness = np.array([[2.0]]), np.array([[k.sum()]])
    parts = [(np.array([[one]]), loss) for one, loss in zip(k, eta, strict=True)]
    zeta = modal_damping(mass, stiffness, 0.5, parts)[0, 0] / (2 * np.sqrt(stiffness[0, 0] * mass[0, 0]))
    exact = np.sqrt((k @ (1 + 1j * eta)) / mass[0, 0])
    assert zeta == pytest.approx((eta @ k) / k.sum() / 2, rel=1e-12)
    assert zeta == pytest.approx(exact.imag / abs(exact), rel=0.01)


def test_fewer_modes_keep_the_damping_of_the_lowest(modes):
    """Shares follow the shapes at first order, frequencies at second: what fewer modes leave out is 0.5 % of them."""
    losses = {"cover": 0.1}
    many, few = (
        reduced_body(modes, mounts=mounts(modes), loss_factors=losses, limit=limit) for limit in (1.5 * BAND, 1200.0)
    )
    assert len(few.mass) < len(many.mass)
    assert ratios(few)[:4] == pytest.approx(ratios(many)[:4], rel=0.01)


def test_the_error_statement_gives_the_full_model_the_same_damping(casing, modes):
    sensors = small_housing().sensors[:1]
    losses = {"cover": 0.1} | ({"mounts": 0.2} if modes.ground == "springs" else {})
    body = reduced_body(modes, sensors=sensors, mounts=mounts(modes), loss_factors=losses)
    given = {"band": BAND, "sensors": sensors, "damping": 0.01, "springs": modes.springs(mounts(modes))}
    same, other = (state_error(casing, body, loss_factors=one, **given) for one in (losses, {}))
    assert same.response_errors.max() < 0.1
    assert other.response_errors.max() > 2 * same.response_errors.max()


def test_parts_that_are_not_there_are_refused(mesh, modes):
    with pytest.raises(ValueError, match=r"no part 'lid' has a loss factor; known: cover, feet"):
        reduced_body(modes, mounts=mounts(modes), loss_factors={"lid": 0.1})
    nowhere = Region(name="lid", low=(1.0, 1.0, 1.0), high=(2.0, 2.0, 2.0))
    with pytest.raises(MeshError, match="lid: no element lies in it"):
        factored(assembled_casing(mesh, CAST_IRON, regions=(nowhere,)))
    lower = Region(name="sump", low=(-FAR, -FAR, -FAR), high=(FAR, FAR, 0.0))
    with pytest.raises(MeshError, match=r"feet and sump share \d+ elements"):
        factored(assembled_casing(mesh, CAST_IRON, regions=(FEET, lower)))


ELASTIC = {"casing.model": "static", "casing.element_size_mm": 60.0}


def test_damped_parts_of_a_scene_in_si():
    parts = [
        {"name": "cover", "loss_factor": 0.02},
        {"name": "mounts", "loss_factor": 0.1},
        {"name": "wall", "loss_factor": 0.3, "box_mm": [[-80.0, -90.0, -70.0], [-50.0, 90.0, 60.0]]},
    ]
    scene = load_scene("minimal", ELASTIC | {"casing.ground": "springs", "casing.damped_parts": parts}).scene
    machine = make_machine(scene)
    assert machine.casing.recovery(machine.structure).loss_factors == {"cover": 0.02, "mounts": 0.1, "wall": 0.3}
    cover, wall = machine.casing.regions(machine.structure)
    assert (cover.name, cover.low[2]) == ("cover", pytest.approx(0.07))  # the top of the cavity
    assert (wall.low, wall.high) == ((-0.08, -0.09, -0.07), (-0.05, 0.09, 0.06))


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ([{"name": "mounts", "loss_factor": 0.1}], "has no mounts"),
        ([{"name": "lid", "loss_factor": 0.1}], '"lid" needs box_mm'),
        ([{"name": "cover", "loss_factor": 2.0}], "less than 2"),
        (
            [{"name": "feet", "loss_factor": 0.1, "box_mm": [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]}],
            "found without box_mm",
        ),
        (
            [{"name": "lid", "loss_factor": 0.1, "box_mm": [[0.0, 0.0, 0.0], [1.0, -1.0, 1.0]]}],
            "must be above the first in x, y and z",
        ),
        ([{"name": "feet", "loss_factor": 0.1}] * 2, "feet occurs 2 times"),
    ],
)
def test_damped_parts_that_do_not_fit_a_scene_are_refused(parts, message):
    with pytest.raises(SceneError, match=message):
        load_scene("minimal", ELASTIC | {"casing.damped_parts": parts})
