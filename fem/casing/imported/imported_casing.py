"""The casing of a machine from imported matrices: bearings and feet are given by their nodes, then reduced."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.linalg as la

from fem.casing.geometry.dimensions import Sensor
from fem.casing.imported.imported_body import ImportedBody, MatrixError
from fem.casing.imported.matrix_checks import MatrixCheck, check_matrices, rigid_motion
from fem.casing.imported.matrix_files import MatrixFiles, read_body
from fem.casing.imported.reduce_at_points import Point, ReducedImportedBody, reduce_imported_body
from fem.casing.parts.casing_choices import Attachment
from fem.casing.parts.feet import foot_sums
from fem.casing.reduced.casing_modes import CasingModes
from fem.casing.reduced.checkup import CheckUp
from fem.casing.reduced.grounded import GROUND_AXES
from fem.casing.reduced.undamped_modes import mode_names, on_springs, undamped_modes
from fem.numerics.message_places import in_mm

_OFF = 0.0005  # m: largest distance of a single node from its bearing point, and
_OFF_SHARE = 0.3  # of the middle of several nodes, as a share of their mean distance from it
_CHECKED = ("reduced_mass_definite", "reduced_stiffness_definite")  # `MatrixCheck` checks the file itself


@dataclass(frozen=True, kw_only=True)
class ImportedMatrices:
    """Imported matrices with the node numbers of bearings and feet; `origin` (m): origin of the file."""

    files: MatrixFiles
    seats: tuple[tuple[str, tuple[int, ...], tuple[float, float, float]], ...]  # name, nodes, bearing point (m)
    grounds: tuple[tuple[int, ...], ...]
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sensors: tuple[Sensor, ...] = ()


def file_digests(files: MatrixFiles) -> tuple[str, ...]:
    """SHA-256 of every file of a body. ForeignError if one is missing."""
    found = []
    for name in (files.stiffness, files.mass, files.nodes, files.equations, files.rows):
        if name is None:
            continue
        try:
            with Path(name).open("rb") as file:
                found.append(hashlib.file_digest(file, "sha256").hexdigest())
        except OSError as error:
            raise MatrixError(f"{name}: cannot be read ({error.strerror})") from error
    return tuple(found)


def imported_casing(
    housing: ImportedMatrices,
    *,
    model: str,
    interfaces: Mapping[str, Sequence[str]],
    ground: str,
    attachment: Attachment,
    limit: float | None,
) -> tuple[CasingModes, CheckUp]:
    """The reduced casing of imported matrices, with its check-up.

    Parameters
    ----------
    housing : files, bearings and feet
    model, ground, attachment : as in `CasingModes`
    interfaces : axes that carry loads, by bearing
    limit : Hz, highest frequency of the modes kept; None for static condensation

    Raises
    ------
    ForeignError : files, nodes or the body cannot be used; the message lists the errors of the check-up
    """
    body, check = checked_body(housing)
    points = {name: Point(nodes=nodes, axes=GROUND_AXES) for name, nodes in _feet(housing) if ground == "springs"}
    for name, nodes, wanted in housing.seats:
        points[name] = Point(nodes=nodes, place=wanted, axes=tuple(interfaces[name]), coupling=attachment)
    feet = tuple(name for name, _ in _feet(housing))
    held = [] if ground == "springs" else sorted({number for nodes in housing.grounds for number in nodes})
    reduced = reduce_imported_body(body, points, held=held, sprung=feet if ground == "springs" else (), band=limit)
    return _modes(housing, reduced, check, model, ground, attachment, limit), _check_up(reduced, check)


def checked_body(housing: ImportedMatrices) -> tuple[ImportedBody, MatrixCheck]:
    """The imported body in the frame of the scene, and its check-up without errors; raises as `imported_casing`."""
    if file_digests(housing.files) != housing.files.digests:
        raise MatrixError(f"{housing.files.stiffness} was changed while the scene was being built; run again")
    body = read_body(housing.files)
    body = replace(body, places=body.places + np.array(housing.origin))
    check = check_matrices(body)
    if not body.located:
        raise MatrixError(f"{body.name} holds no node coordinates; set nodes_file")
    if check.wrong:
        raise MatrixError(f"{body.name}: {'; '.join(check.wrong)}")
    for name, nodes, wanted in housing.seats:
        _check_place(body, name, nodes, wanted)
    for _, nodes in _feet(housing):
        for number in nodes:
            body.place(number)
    return body, check


def _feet(housing: ImportedMatrices) -> list[tuple[str, tuple[int, ...]]]:
    return [(f"ground_{number}", nodes) for number, nodes in enumerate(housing.grounds, 1)]


def _check_place(body: ImportedBody, name: str, nodes: tuple[int, ...], wanted: tuple[float, float, float]) -> None:
    places = np.array([body.place(number) for number in nodes])
    reach = float(np.linalg.norm((places - wanted)[:, [0, 2]], axis=1).mean())
    off = float(np.linalg.norm(places.mean(axis=0) - wanted))
    limit = max(_OFF, _OFF_SHARE * reach if len(nodes) > 1 else 0.0)
    if off > limit:
        raise MatrixError(
            f"{name}: the middle of its {len(nodes)} nodes at {in_mm(places.mean(axis=0))} is "
            f"{1000 * off:.4g} mm from the bearing at {in_mm(wanted)} "
            f"(limit {1000 * limit:.3g} mm). Correct the nodes, origin_mm or units"
        )


def _modes(
    housing: ImportedMatrices,
    reduced: ReducedImportedBody,
    check: MatrixCheck,
    model: str,
    ground: str,
    attachment: str,
    limit: float | None,
) -> CasingModes:
    body, reduction = reduced.body, reduced.reduction
    basis = reduced.expansion @ reduction.basis
    R = rigid_motion(body, check.centre)
    nodal = np.zeros((len(body.numbers), 3, basis.shape[1]), np.float32)
    moving, where = body.displacements
    nodal[where, body.axis[moving]] = basis[moving]
    nodal[body.passive] = (body.rows @ basis).reshape(-1, *nodal.shape[1:])
    places = dict(reduced.places)
    for name, nodes in _feet(housing):
        places.setdefault(name, np.mean([body.place(number) for number in nodes], axis=0))
    foot_stiffness, foot_inertia = _clamped_feet(housing, reduced, body.mass @ R[:, :3], ground)
    return CasingModes(
        model=model,
        solver=reduced.interface.factor.name,
        ground=ground,
        attachment=attachment,
        mass=reduction.mass,
        stiffness=reduction.stiffness,
        coordinate_names=(*reduced.coordinate_names, *mode_names(reduction.n_fixed, len(reduction.frequencies))),
        fixed_frequencies=reduction.frequencies,
        band_limit=0.0 if limit is None else limit,
        counted=-1,
        unknowns=reduced.expansion.shape[1],
        participation=basis.T @ (body.mass @ R),
        foot_stiffness=foot_stiffness,
        foot_inertia=foot_inertia,
        part_names=(),
        part_stiffness=np.zeros((0, *reduction.mass.shape)),
        total_mass=check.mass,
        centre=check.centre,
        inertia=check.inertia,
        point_names=tuple(places),
        point_positions=np.array(list(places.values())),
        nodes=body.places,
        facets=np.zeros((0, 3), np.int32),
        basis=nodal,
        notes=body.notes,
    )


def _clamped_feet(
    housing: ImportedMatrices, reduced: ReducedImportedBody, MX: np.ndarray, ground: str
) -> tuple[np.ndarray, np.ndarray]:
    """The two terms of `fem.casing.parts.feet`; zeros where the feet are on springs."""
    body, interface, count = reduced.body, reduced.interface, 3 * len(housing.grounds)
    if ground == "springs":
        return np.zeros((count, len(reduced.coordinate_names))), np.zeros((count, 3))
    unknowns = [
        np.flatnonzero(np.isin(body.node, nodes) & (body.axis == axis))
        for nodes in housing.grounds
        for axis in range(3)
    ]
    sums = foot_sums(unknowns, len(body.node))
    displaced = interface.inverse(reduced.expansion.T @ MX)
    forces = sums @ body.stiffness @ reduced.expansion
    return forces @ interface.constraint, sums @ MX - forces @ displaced


def _check_up(reduced: ReducedImportedBody, check: MatrixCheck) -> CheckUp:
    """The items of the check-up that need no mesh."""
    reduction = reduced.reduction
    held = on_springs(reduction.stiffness, reduced.springs)
    frequencies, _ = undamped_modes(held, reduction.mass)
    return CheckUp(
        item_names=_CHECKED,
        items=np.array([(la.eigvalsh(reduction.mass) <= 0.0).sum(), (frequencies <= 0.0).sum()]),
        mass=check.mass,
        centre=check.centre,
        inertia=check.inertia,
        frequencies=frequencies,
    )
