"""Casing on mount springs, rigid and mean couplings, loaded axes, damping tables, modes cut without finite elements."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from factored_casing import factored
from housings import short_housing
from scipy.sparse.linalg import splu

from fem.casing.mesh.gmsh_mesh import mesh_housing
from fem.casing.reduced.attachment import AttachmentError
from fem.casing.reduced.casing_modes import casing_modes, kept_modes, natural_modes, reduced_body
from fem.casing.reduced.checkup import check_up
from fem.casing.reduced.damping import damping_ratios
from fem.casing.reduced.fewer_modes import kept
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.halves import reduced_and_counted
from fem.casing.reduced.lanczos import EigenError, block_lanczos
from fem.casing.reduced.reduced_body import BEARING_AXES
from fem.casing.reduced.reduction import ReductionError, reduce_body
from fem.casing.reduced.reduction_error import full_response, reduced_response, sensor_rows, state_error, third_octaves
from fem.casing.reduced.sturm_count import count_fixed_modes
from fem.elements.materials import CAST_IRON
from fem.numerics.elimination import plan_elimination
from fem.storage.ledger import counting

BAND = 3000.0
MOUNTS = ((2e7, 3e7, 5e7),)


@pytest.fixture(scope="module")
def housing():
    return short_housing()


@pytest.fixture(scope="module")
def mesh(housing):
    return mesh_housing(housing, element_size=0.06)


def reduced(casing, **options):
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, **options)
    limit = options.get("highest", 0.0)
    return reduction, casing_modes(casing, reduction, model="craig-bampton", band_limit=limit)


@pytest.fixture(scope="module")
def fixed(mesh):
    casing = factored(assembled_casing(mesh, CAST_IRON))
    return casing, *reduced(casing, highest=1.5 * BAND)


@pytest.fixture(scope="module")
def sprung(mesh):
    casing = factored(assembled_casing(mesh, CAST_IRON, ground="springs"))
    return casing, *reduced(casing, highest=1.5 * BAND)


def full_frequencies(casing, springs, highest):
    from fem.numerics.linear_solver import factorize

    solve = factorize(casing.K_free + casing.rows.T @ sp.diags_array(springs) @ casing.rows).solve
    theta, _ = block_lanczos(solve, casing.M_free, smallest=(2 * np.pi * highest) ** -2)
    return 1 / (2 * np.pi * np.sqrt(theta))


def frequencies(body):
    return np.sqrt(np.abs(la.eigh(body.stiffness, body.mass, eigvals_only=True))) / (2 * np.pi)


def test_a_casing_on_springs_passes_its_check_up(sprung):
    casing, reduction, _ = sprung
    found = check_up(casing, reduction)
    assert found.failures == ()


def test_without_mounts_the_body_is_free(sprung):
    """Six motions of the reduced body need no force, and carry the mass."""
    _, _, modes = sprung
    value = la.eigh(modes.stiffness, modes.mass, eigvals_only=True)
    assert abs(value[:6]).max() < 1e-7 * value[6]
    natural = natural_modes(modes, mounts=((1.0, 1.0, 1.0),))
    assert natural.effective_mass[:6, :3].sum(axis=0) == pytest.approx(modes.total_mass, rel=1e-6)


def test_mounts_change_without_finite_elements_and_agree_with_the_full_model(sprung):
    casing, _, modes = sprung
    for mounts in (MOUNTS, ((1e9, 1e9, 1e9),), tuple((1e7 * (i + 1), 2e7, 4e7) for i in range(4))):
        with counting() as counts:
            body = reduced_body(modes, mounts=mounts)
        assert not counts
        full = full_frequencies(casing, modes.springs(mounts), BAND)
        found = frequencies(body)[: len(full)]
        assert (found >= full * (1 - 1e-9)).all()
        assert (found / full - 1).max() < 1e-3
    assert "ground_4:uz" in body.row_names


def test_soft_mounts_give_the_rigid_model_and_stiff_ones_lift_the_frequencies(sprung, housing):
    from fem.casing.models.rigid_casing import RigidCasing

    _, _, modes = sprung
    soft = frequencies(reduced_body(modes, mounts=((1e4, 1e4, 1e4),)))[:6]
    rigid = frequencies(RigidCasing(mount_stiffness=1e4).reduce(housing, CAST_IRON))
    assert soft == pytest.approx(rigid, rel=2e-3)
    assert (frequencies(reduced_body(modes, mounts=MOUNTS))[:6] > soft).all()


def test_mounts_that_do_not_fit_are_refused(sprung, fixed):
    with pytest.raises(ValueError, match="needs mounts"):
        reduced_body(sprung[2])
    with pytest.raises(ValueError, match="takes no mounts"):
        reduced_body(fixed[2], mounts=MOUNTS)
    with pytest.raises(ReductionError, match=r"has 2 rows, and the casing has 4 feet\. Give one row .* or 4 rows"):
        reduced_body(sprung[2], mounts=MOUNTS * 2)
    with pytest.raises(ValueError, match="needs a positive one"):
        reduced_body(sprung[2], mounts=((1e7, 0.0, 1e7),))
    assert sprung[2].springs(((0.05, 0.05, 0.05),)).max() == 0.05  # as soft as one likes


def test_rigid_patches_leave_a_floor_that_modes_do_not_remove(mesh, fixed):
    """Against the full model without any patch: mean motion (RBE3) converges to it, rigid patches (RBE2) stay above."""
    casing = fixed[0]
    full = full_frequencies(casing, casing.springs, BAND)
    stiff = factored(assembled_casing(mesh, CAST_IRON, attachment="rigid"))
    error = {}
    for name, held in (("mean", casing), ("rigid", stiff)):
        for factor in (1.5, 3.0):
            reduction = reduce_body(held.interface, held.K_free, held.M_free, highest=factor * BAND)
            found = frequencies(casing_modes(held, reduction, model="craig-bampton", band_limit=factor * BAND))
            error[name, factor] = (found[: len(full)] / full - 1).max()
    assert error["mean", 3.0] < 1e-5
    assert error["rigid", 3.0] > 1e-3
    assert error["rigid", 3.0] == pytest.approx(error["rigid", 1.5], rel=0.2)


def test_rigid_patches_move_as_rigid_bodies_and_pass_the_check_up(mesh):
    for ground in ("fixed", "springs"):
        casing = factored(assembled_casing(mesh, CAST_IRON, attachment="rigid", ground=ground))
        reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=5)
        assert check_up(casing, reduction).failures == ()
    unit = casing.expanded(casing.interface.rows.T.toarray()[:, -5:]).reshape(-1, 3, 5)
    nodes = np.unique(mesh.patch("bearing_2"))
    assert unit[nodes, 0, 0] == pytest.approx(1.0)  # ux of the last bearing
    assert unit[nodes, 0, 4] == pytest.approx(-(mesh.nodes[nodes, 1] - mesh.point("bearing_2")[1]))  # rz


def test_axes_that_carry_nothing_cost_no_coordinates(mesh, fixed):
    """A body without some axes is the larger one with these axes free of force."""
    loaded = dict.fromkeys(mesh.patches("bearing_"), ("ux", "uz"))
    casing = factored(assembled_casing(mesh, CAST_IRON, interfaces=loaded))
    few = reduced_body(reduced(casing, highest=1.5 * BAND)[1])
    many = reduced_body(fixed[2])
    assert few.coordinate_names[:3] == ("bearing_1:ux", "bearing_1:uz", "bearing_2:ux")
    assert few.row_names == tuple(f"{b}:{a}" for b, axes in loaded.items() for a in axes)
    inside = frequencies(many)[frequencies(many) < BAND]
    assert frequencies(few)[: len(inside)] == pytest.approx(inside, rel=1e-3)
    first, second = (b.rows @ la.solve(b.stiffness, b.rows.T) for b in (few, many))
    place = [many.row_names.index(name) for name in few.row_names]
    assert first == pytest.approx(second[np.ix_(place, place)], rel=1e-7, abs=1e-9 * abs(second).max())


def test_a_single_bearing_is_enough(mesh):
    casing = factored(assembled_casing(mesh, CAST_IRON, interfaces={"bearing_2": BEARING_AXES}))
    reduction, modes = reduced(casing, highest=BAND)
    assert check_up(casing, reduction).failures == ()
    assert len(modes.interface_names) == 5


def test_fewer_modes_without_finite_elements_equal_a_new_computation(fixed):
    casing, _, modes = fixed
    low = 2000.0
    _, anew = reduced(casing, highest=low)
    with counting() as counts:
        cut = reduced_body(modes, limit=low)
    assert not counts
    expected = reduced_body(anew)
    assert cut.coordinate_names == expected.coordinate_names
    assert frequencies(cut) == pytest.approx(frequencies(expected), rel=1e-7)
    assert abs(np.diag(cut.stiffness)) == pytest.approx(abs(np.diag(expected.stiffness)), rel=1e-6)
    with pytest.raises(ValueError, match="modes to 9000 Hz requested, known to 4500 Hz"):
        reduced_body(modes, limit=9000.0)


def test_as_few_modes_as_an_error_allows(fixed):
    _, _, modes = fixed
    springs, exact = np.zeros(10), frequencies(reduced_body(modes))
    inside = exact[exact <= BAND]
    numbers = []
    for error in (1e-2, 1e-3, 1e-5):
        chosen = kept_modes(modes, springs, frequency_error=error)
        found = frequencies(reduced_body(modes, frequency_error=error))[: len(inside)]
        assert (found / inside - 1).max() <= error
        fewer = kept(modes.mode_set, chosen.n_fixed - 1) if chosen.n_fixed else None
        if fewer is not None:
            assert (frequencies(fewer)[: len(inside)] / inside - 1).max() > error
        numbers.append(chosen.n_fixed)
    assert numbers == sorted(numbers)
    assert numbers[-1] > numbers[0]


def test_the_law_of_inertia_counts_the_modes_that_are_found(fixed, sprung):
    for casing, reduction, _ in (fixed, sprung):
        for limit in (1800.0, 1.5 * BAND):
            counted = count_fixed_modes(casing.interface, casing.K_free, casing.M_free, limit)
            assert counted == (reduction.frequencies[: reduction.n_fixed] < limit).sum()


def test_a_missed_mode_is_an_error(fixed, monkeypatch):
    casing = fixed[0]
    held = (casing.subspaces, casing.loads)
    reduction, counted = reduced_and_counted(*held, highest=1.5 * BAND)
    assert reduction.n_fixed == counted
    assert np.array_equal(reduction.modes, fixed[1].modes)  # the same numbers beside the count as without
    monkeypatch.setattr("fem.casing.reduced.halves.count_fixed_modes", lambda *_: counted + 1)
    with pytest.raises(EigenError, match=f"{counted} fixed-interface modes found below 4500 Hz, {counted + 1} exist"):
        reduced_and_counted(*held, highest=1.5 * BAND)


def test_sensor_axes_turn_the_rows(fixed, housing):
    _, _, modes = fixed
    plain = housing.sensors[0]
    c, s = np.cos(0.4), np.sin(0.4)
    axes = ((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0))
    straight, turned = (reduced_body(modes, sensors=[x]).rows[-3:] for x in (plain, replace(plain, axes=axes)))
    assert turned == pytest.approx(np.array(axes) @ straight)


def test_damping_follows_a_table_over_frequency(fixed):
    table = ((0.0, 0.01), (1000.0, 0.03))
    body = reduced_body(fixed[2], damping=table)
    square, phi = la.eigh(body.stiffness, body.mass)
    omega = np.sqrt(square)
    zeta = np.diag(phi.T @ body.damping @ phi) / (2 * omega)
    assert zeta == pytest.approx(np.minimum(0.01 + 0.02 * omega / (2 * np.pi * 1000.0), 0.03), rel=1e-6)


@pytest.mark.parametrize(("ratio", "gate"), [(0.0, 1e-3), (0.01, 6e-3)])
def test_full_response_agrees_with_all_modes(fixed, housing, ratio, gate):
    """Few modes with the powers of K^-1 M, against a dense eigensolution with the damping of every mode.

    What is left is the damping of the modes beyond the limit.
    """
    casing, reduction, _ = fixed
    # a small model: the reduced basis of many modes stands for the mesh
    basis = reduction.basis
    K, M = basis.T @ (casing.K_free @ basis), basis.T @ (casing.M_free @ basis)
    rows = casing.interface.rows @ basis
    square, phi = la.eigh(K, M)
    number = int((np.sqrt(square) < 2 * np.pi * 1.5 * 2000.0).sum())
    readings = sensor_rows(casing, housing.sensors[:1]) @ basis
    at = np.array([300.0, 1400.0, 1900.0])
    loads, sensors, zeta = sp.csr_matrix(rows), sp.csr_matrix(readings), np.full(number, ratio)
    found = full_response(lambda X: la.solve(K, X), M, 1 / square[:number], phi[:, :number], zeta, loads, sensors, at)
    for response, omega in zip(found, 2 * np.pi * at, strict=True):
        every = 1 / (square - omega**2 + 2j * ratio * np.sqrt(square) * omega)
        exact = (readings @ phi * every) @ (rows @ phi).T
        assert abs(response - exact).max() < gate * abs(exact).max()


def test_error_statement_of_the_default_reduction(fixed, housing):
    casing, _, modes = fixed
    body = reduced_body(modes, sensors=housing.sensors)
    found = state_error(casing, body, band=BAND, sensors=housing.sensors, damping=0.01)
    assert found.response_errors.shape == (len(found.third_octaves), 2, len(housing.sensors))
    assert 0 < found.frequency_errors.max() < 1e-3
    assert found.response_errors.max() < 0.06
    assert "norm of the difference" in found.report()
    wrong = body.replaced(stiffness=1.01 * body.stiffness)  # half a percent in every frequency
    shifted = state_error(casing, wrong, band=BAND, sensors=housing.sensors, damping=0.01)
    assert shifted.frequency_errors == pytest.approx(0.00499, abs=1e-3)
    assert shifted.response_errors.max() > 0.1


def direct_response(casing, beta, readings, at):
    """(K (1 + i w beta) - w^2 M) u = b of the whole mesh, one complex factorisation per frequency, without any mode."""
    order = plan_elimination(casing.K_free, 3).order
    K, M = (matrix[order][:, order].tocsc() for matrix in (casing.K_free, casing.M_free))
    loads, readings = casing.interface.rows.T.toarray()[order], readings[:, order]
    out = []
    for omega in 2 * np.pi * at:
        dynamic = ((1 + 1j * omega * beta) * K - omega**2 * M).tocsc()
        lu = splu(dynamic, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        out.append(readings @ lu.solve(loads.astype(complex)))
    return np.array(out)


STIFFNESS_DAMPING = ((0.0, 0.0), (50.0 * BAND, 0.5))  # zeta = beta omega / 2, 1 % at the band
BETA = 0.02 / (2 * np.pi * BAND)


def test_the_full_response_agrees_with_direct_solutions_of_the_mesh(fixed, housing):
    """Damping in proportion to the stiffness is modal damping, and viscous damping in physical coordinates, too.

    The hybrid expansion leaves out the damping of the modes beyond its limit only: 2.4 zeta of their share.
    """
    casing, _, modes = fixed
    sensors, at = housing.sensors[-1:], np.array([0.2, 0.7, 1.0]) * BAND
    readings = sensor_rows(casing, sensors)
    direct = direct_response(casing, BETA, readings, at)
    solve, rows = casing.interface.factor.solve, casing.interface.rows
    theta, phi = block_lanczos(solve, casing.M_free, smallest=(2 * np.pi * 1.5 * BAND) ** -2)
    zeta = damping_ratios(STIFFNESS_DAMPING, 1 / (2 * np.pi * np.sqrt(theta)))
    stated = full_response(solve, casing.M_free, theta, phi, zeta, rows, readings, at)
    assert abs(stated - direct).max() < 6e-3 * abs(direct).max()
    body = reduced_body(modes, sensors=sensors, damping=STIFFNESS_DAMPING)
    found = reduced_response(body, casing.coordinate_names, [sensors[0].name], at)
    assert np.linalg.norm(found - direct) < 0.01 * np.linalg.norm(direct)


@pytest.mark.slow
def test_the_error_statement_agrees_with_direct_solutions_of_the_mesh(fixed, housing):
    """The errors that it prints for two third octaves, of a good body and of one with every frequency 0.25 % too high.

    Its own uncertainty is the damping of the modes beyond its limit, here 0.2 % of the response.
    """
    casing, _, modes = fixed
    sensors = housing.sensors[-1:]
    thirds, lines = third_octaves(BAND)
    chosen = [int(abs(thirds - f).argmin()) for f in (1250.0, 2000.0)]
    at = lines.reshape(len(thirds), -1)[chosen]
    direct = direct_response(casing, BETA, sensor_rows(casing, sensors), at.ravel())
    good = reduced_body(modes, sensors=sensors, damping=STIFFNESS_DAMPING)
    for body, least in ((good, 0.0), (good.replaced(stiffness=1.005 * good.stiffness), 0.02)):
        statement = state_error(casing, body, band=BAND, sensors=sensors, damping=STIFFNESS_DAMPING)
        found = reduced_response(body, casing.coordinate_names, [sensors[0].name], at.ravel())
        for number, bearing in enumerate(statement.bearings):
            columns = [i for i, n in enumerate(casing.coordinate_names) if n.startswith(f"{bearing}:u")]
            off, size = (
                np.linalg.norm(h[..., columns].reshape(len(chosen), -1), axis=1) for h in (found - direct, direct)
            )
            assert statement.response_errors[chosen, number, 0] == pytest.approx(off / size, rel=0.05, abs=4e-3)
            assert (off / size).max() > least


def test_third_octaves_end_at_the_band():
    middle, lines = third_octaves(5000.0)
    assert middle[[0, 10]] == pytest.approx([100.0, 1000.0])
    assert len(lines) == 24 * len(middle)
    assert lines.max() < 5000.0
    assert (np.diff(lines) > 0).all()


def test_rigid_patches_that_touch_are_refused(mesh):
    shared = replace(mesh, facet_patch=np.where(mesh.facet_patch == 5, 4, mesh.facet_patch))
    touching = np.array(shared.facet_patch)
    half = np.flatnonzero(touching == 4)[:3]
    touching[half] = 5
    with pytest.raises(AttachmentError, match="cannot both be rigid"):
        factored(assembled_casing(replace(mesh, facet_patch=touching), CAST_IRON, attachment="rigid"))


def test_frequencies_of_a_smooth_body_converge_with_fourth_order():
    from benchmarks.sphere import exact_frequency, frequency

    exact = exact_frequency()
    errors = [frequency(n)[0] / exact - 1 for n in (4, 6)]
    assert 0 < errors[1] < 2e-4
    assert np.log(errors[0] / errors[1]) / np.log(6 / 4) > 3.0
