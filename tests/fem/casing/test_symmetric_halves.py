"""A casing with a mirror plane is reduced by its symmetric and its antisymmetric half: the same casing, sooner."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from factored_casing import factored
from housings import angle_casing, short_housing
from threadpoolctl import threadpool_limits

from fem.casing.enrichment.added_unknowns import added_functions
from fem.casing.geometry.dimensions import Sensor
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.sizes import Sizes
from fem.casing.reduced import halves
from fem.casing.reduced.grounded import ForcedPoint, assembled_casing
from fem.casing.reduced.halves import lowest, reduced_and_counted, subspaces_of
from fem.casing.reduced.reduction import reduce_body
from fem.casing.reduced.sturm_count import count_fixed_modes
from fem.elements.materials import CAST_IRON
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene

CUBIC = "hexahedron-32"
MESHES = {
    "angle": (15000.0, lambda: angle_casing(CUBIC)),
    "housing": (5000.0, lambda: mesh_geometry(short_housing(), Sizes(element=0.06), CUBIC)),
}


@pytest.fixture(autouse=True, scope="module")
def single_threads():
    """As the models of the casing run it: the halves are the threads."""
    with threadpool_limits(1):
        yield


@pytest.fixture(scope="module", params=["angle", pytest.param("housing", marks=pytest.mark.slow)])  # the same, larger
def body(request):
    """Highest frequency (Hz) of the modes, and a mesh with a mirror plane."""
    highest, made = MESHES[request.param]
    return highest, made()


@pytest.fixture(scope="module")
def mesh(body):
    return body[1]


@pytest.fixture(scope="module")
def fixed(mesh):
    """The casing on fixed feet, in one piece and divided."""
    return factored(assembled_casing(mesh, CAST_IRON)), assembled_casing(mesh, CAST_IRON, divided=True)


@pytest.fixture(scope="module")
def springs(mesh):
    """The same on springs."""
    held = {"ground": "springs"}
    return factored(assembled_casing(mesh, CAST_IRON, **held)), assembled_casing(mesh, CAST_IRON, **held, divided=True)


@pytest.mark.parametrize("ground", ["fixed", "springs"])
def test_both_halves_together_are_the_whole(ground, body, request):
    highest, _ = body
    casing, divided = request.getfixturevalue(ground)
    assert len(divided.subspaces) == 2
    found, number = reduced_and_counted(divided.subspaces, divided.loads, highest=highest)
    whole = casing.interface
    b = len(whole.stiffness)
    assert found.stiffness[:b, :b] == pytest.approx(whole.stiffness, rel=1e-9, abs=1e-10 * abs(whole.stiffness).max())
    for one, other in (
        (found.constraint, whole.constraint),
        (found.loaded, whole.loaded),
    ):
        assert one == pytest.approx(other, abs=1e-9 * abs(other).max())
    matrices = whole, casing.K_free, casing.M_free
    expected = reduce_body(*matrices, highest=highest)
    assert number == count_fixed_modes(*matrices, highest) == found.n_fixed > 3
    assert found.frequencies[:number] == pytest.approx(expected.frequencies[:number], rel=1e-9)
    held = np.diag(np.append(casing.springs, np.zeros(len(found.frequencies))))
    natural, of_whole = (la.eigh(one.stiffness + held, one.mass, eigvals_only=True) for one in (found, expected))
    assert natural == pytest.approx(of_whole, rel=1e-5)  # the residual to which the eigensolution converges
    assert found.modes.T @ (casing.M_free @ found.modes) == pytest.approx(np.eye(len(found.frequencies)), abs=1e-9)


@pytest.mark.parametrize("count", [1, 3, 12])
def test_none_of_the_lowest_modes_is_left_out(fixed, count):
    """However they fall to the halves: the first few may all be of one of them."""
    casing, divided = fixed
    found, modes = lowest(divided.subspaces, count)
    exact, _ = lowest(casing.subspaces, count)
    assert found == pytest.approx(exact, rel=1e-9)
    assert modes.T @ (casing.M_free @ modes) == pytest.approx(np.eye(count), abs=1e-9)


def test_halves_that_give_too_few_modes_are_solved_for_all_of_them(fixed, monkeypatch):
    """As where most of the lowest modes are of one half: here each is asked for two of twelve first."""
    monkeypatch.setattr(halves, "_SHARE", 0.1)
    (exact, _), (found, _) = (lowest(one.subspaces, 12) for one in fixed)
    assert found == pytest.approx(exact, rel=1e-9)


def test_each_half_moves_as_it_is_called(mesh, fixed):
    free = np.delete(mesh.nodes, fixed[0].clamped[::3] // 3, axis=0)
    key = np.round(free * 1e6).astype(int)
    place = {tuple(row): number for number, row in enumerate(key.tolist())}
    image = [place[x, -y, z] for x, y, z in key.tolist()]
    for half, parity in zip(fixed[1].subspaces, (1.0, -1.0), strict=True):
        amplitudes = np.random.default_rng(2).standard_normal(half.motions.shape[1])
        motion = (half.motions @ amplitudes)[: free.size].reshape(-1, 3)
        assert motion[image] * [1.0, -1.0, 1.0] == pytest.approx(parity * motion, abs=1e-12)


def test_a_casing_without_a_mirror_plane_stays_in_one_piece(mesh):
    """Wider on one side, a force at one point: half of it is not like the other half."""
    wider = angle_casing(CUBIC, move=lambda places: places * np.where(places[:, 1:2] > 0.0, [1.0, 1.2, 1.0], 1.0))
    assert len(assembled_casing(wider, CAST_IRON, divided=True).subspaces) == 1
    middles = mesh.nodes[mesh.facets[:, :4]].mean(axis=1)
    force = ForcedPoint(sensor=Sensor(name="side", position=tuple(middles[middles[:, 1].argmax()])), axes=("uz",))
    assert len(assembled_casing(mesh, CAST_IRON, forced=(force,), divided=True).subspaces) == 1


def test_functions_of_two_kinds_at_one_place_are_told_apart():
    """In the rig functions of edges lie at the middles of sides, where cubic ones are."""
    machine = make_machine(load_scene("rig-healthy").scene)
    mesh = machine.casing.meshed(machine.structure).stage.build()
    added = added_functions(mesh, machine.structure.material, held=mesh.patches("ground_"))
    places = np.round(added.places, 9)
    assert len(np.unique(places, axis=0)) < len(np.unique(np.column_stack([places, added.numbers // 100]), axis=0))
    assert len(np.unique(np.column_stack([places, added.numbers]), axis=0)) == len(added)


def test_springs_that_differ_from_side_to_side_keep_it_whole(springs):
    casing, _ = springs
    first = np.flatnonzero(casing.springs)[0]
    for factor, pieces in ((1.0, 2), (2.0, 1)):
        penalty = np.where(np.arange(len(casing.springs)) == first, factor, 1.0) * casing.springs
        body = (casing.added, casing.K_free, casing.M_free, casing.rows)
        assert len(subspaces_of(*body, expansion=casing.expansion, penalty=penalty)) == pieces
