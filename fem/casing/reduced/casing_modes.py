"""CasingModes: the stored result of a casing reduction, its natural modes with effective masses, and its ReducedBody.

Sensors are recovered from the basis on the nodes. Mount springs are added to the coordinates of the feet. Damping
follows from the modes of the grounded reduced body. `fem.casing.reduced.fewer_modes` selects fewer modes. A change of
any of these needs no factorisation or eigensolution of the mesh.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fem.casing.geometry.dimensions import Sensor
from fem.casing.parts.casing_choices import MOUNTS, DampingRatio
from fem.casing.parts.feet import foot_sums
from fem.casing.reduced.attachment import nearest_surface_point
from fem.casing.reduced.damping import energy_shares, modal_damping
from fem.casing.reduced.fewer_modes import ModeSet, fewest_modes, kept
from fem.casing.reduced.grounded import GROUND_AXES, AssembledCasing
from fem.casing.reduced.reduced_body import BEARING_AXES, ReducedBody
from fem.casing.reduced.reduction import Reduction, ReductionError
from fem.casing.reduced.undamped_modes import mode_names, on_springs, undamped_modes
from fem.storage.records import Record, array, integer, names, scalar, text

Mounts = Sequence[Sequence[float]]  # stiffness in x, y, z (N/m): one row for all feet, or one per foot in their order


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingModes(Record):
    """Reduced matrices of a grounded casing and its basis on the mesh.

    On springs the matrices are those of the free body; `reduced_body` adds the mounts.
    """

    model: str = text()  # "static" | "craig-bampton"
    solver: str = text()  # library that factorised the stiffness
    ground: str = text()  # "fixed" | "springs"
    attachment: str = text()  # "mean" | "rigid"
    mass: np.ndarray = array("coordinate", "coordinate", units="SI")
    stiffness: np.ndarray = array("coordinate", "coordinate", units="SI")
    coordinate_names: tuple[str, ...] = names("coordinate")  # interface, "mode_1", ..., "inertia_1", ...
    fixed_frequencies: np.ndarray = array("mode", units="Hz")  # fixed-interface modes, then inertia corrections
    band_limit: float = scalar(units="Hz")  # every fixed-interface mode below it is kept
    counted: int = integer()  # fixed-interface modes below the limit (Sturm-sequence count); -1: not counted
    unknowns: int = integer()  # of the grounded mesh
    participation: np.ndarray = array("coordinate", "motion", units="SI")  # T^T M R, R about the centre of gravity
    foot_stiffness: np.ndarray = array("foot_axis", "interface", units="SI")  # of clamped feet, see
    foot_inertia: np.ndarray = array("foot_axis", "axis", units="kg")  # `fem.casing.parts.feet`; 0 on springs
    part_names: tuple[str, ...] = names("part")  # parts with separate damping, see `fem.casing.parts.regions`
    part_stiffness: np.ndarray = array("part", "coordinate", "coordinate", units="SI")  # their part of `stiffness`
    total_mass: float = scalar(units="kg")
    centre: np.ndarray = array("axis", units="m")  # of gravity
    inertia: np.ndarray = array("axis", "axis", units="kg m2")  # about the centre
    point_names: tuple[str, ...] = names("point")  # ground and bearing points
    point_positions: np.ndarray = array("point", "axis", units="m")
    nodes: np.ndarray = array("node", "axis", units="m")
    facets: np.ndarray = array("facet", "facet_corner", units="1", dtype=np.int32)  # the surface, into nodes
    basis: np.ndarray = array("node", "axis", "coordinate", units="SI", dtype=np.float32)
    element_size: float = dataclasses.field(default=0.0, metadata=scalar(units="m").metadata)  # 0: not known
    notes: tuple[str, ...] = dataclasses.field(default=(), metadata=names("note").metadata)  # warnings

    @property
    def interface_names(self) -> tuple[str, ...]:
        """Names of the physical coordinates."""
        return tuple(name for name in self.coordinate_names if ":" in name)

    @property
    def mode_set(self) -> ModeSet:
        """The matrices with their numbers of coordinates."""
        n_fixed = sum(name.startswith("mode_") for name in self.coordinate_names)
        return ModeSet(self.stiffness, self.mass, len(self.interface_names), n_fixed, np.eye(len(self.mass)))

    def springs(self, mounts: Mounts | None) -> np.ndarray:
        """Stiffness (interface,) added by the mounts of the feet.

        Raises
        ------
        ReductionError : not one row or one per foot
        ValueError : mounts of a fixed casing, none of one on springs, none positive
        """
        if (mounts is not None) != (self.ground == "springs"):
            need = "needs mounts" if mounts is None else "takes no mounts"
            raise ValueError(f"casing with ground {self.ground!r} {need}; set casing.ground to fit")
        out = np.zeros(len(self.interface_names))
        if mounts is None:
            return out
        feet = [name for name in self.point_names if name.startswith("ground_")]
        rows = np.asarray(mounts, float)
        if rows.shape not in ((1, 3), (len(feet), 3)):
            raise ReductionError(
                f"casing.mounts_N_per_um has {len(rows)} rows, and the casing has {len(feet)} feet. Give one row of x, "
                f"y, z for all feet, or {len(feet)} rows."
            )
        if not (np.isfinite(rows).all() and (rows > 0.0).all()):
            raise ValueError(f"mount stiffness is {rows.min():g} N/m; every mount needs a positive one in x, y and z")
        out[: 3 * len(feet)] = np.broadcast_to(rows, (len(feet), 3)).ravel()  # the feet are the first points
        return out


def casing_modes(
    casing: AssembledCasing, reduction: Reduction, *, model: str, band_limit: float, counted: int = -1
) -> CasingModes:
    """Collect the data of a reduction for later stages.

    Parameters
    ----------
    casing, reduction : full model and its reduction
    model : name of the casing model
    band_limit : Hz, below which every fixed-interface mode was kept
    counted : fixed-interface modes below it (Sturm-sequence count); -1: not counted
    """
    mesh = casing.mesh
    mass, centre, inertia = casing.mass_properties
    foot_stiffness, foot_inertia = _clamped_feet(casing, reduction)
    return CasingModes(
        model=model,
        solver=reduction.solver,
        ground=casing.ground,
        attachment=casing.attachment,
        mass=reduction.mass,
        stiffness=reduction.stiffness,
        coordinate_names=casing.coordinate_names + mode_names(reduction.n_fixed, len(reduction.frequencies)),
        fixed_frequencies=reduction.frequencies,
        band_limit=band_limit,
        counted=counted,
        unknowns=casing.unknowns,
        participation=reduction.projected(casing.expansion.T @ casing.inertial),
        foot_stiffness=foot_stiffness,
        foot_inertia=foot_inertia,
        part_names=tuple(casing.parts),
        part_stiffness=_of_parts(casing, reduction),
        total_mass=mass,
        centre=centre,
        inertia=inertia,
        point_names=mesh.patch_names,
        point_positions=mesh.patch_points,
        nodes=mesh.nodes,
        facets=mesh.facets,
        basis=_expanded(casing, reduction).reshape(len(mesh.nodes), 3, -1),
        element_size=mesh.element_size,
    )


def _of_parts(casing: AssembledCasing, reduction: Reduction) -> np.ndarray:
    """T^T K_p T (part, coordinate, coordinate)."""
    found = [reduction.projected(stiffness @ reduction.basis) for stiffness in casing.parts.values()]
    return np.array(found).reshape(len(found), *reduction.mass.shape)


def _clamped_feet(casing: AssembledCasing, reduction: Reduction) -> tuple[np.ndarray, np.ndarray]:
    """The two terms of `fem.casing.parts.feet`; zeros for feet on springs."""
    mesh, displaced = casing.mesh, reduction.loaded[:, -3:]
    feet = [np.unique(mesh.patch(name)) for name in mesh.patches("ground_")]
    if casing.ground == "springs":
        return np.zeros((3 * len(feet), len(casing.springs))), np.zeros((3 * len(feet), 3))
    sums = foot_sums([3 * nodes + axis for nodes in feet for axis in range(3)], len(casing.inertial))
    forces = sums[:, casing.clamped] @ casing.K_clamped @ casing.expansion
    displaced = displaced - reduction.constraint @ (casing.rows @ displaced)
    return forces @ reduction.constraint, sums @ casing.inertial[:, :3] - forces @ displaced


def _expanded(casing: AssembledCasing, reduction: Reduction) -> np.ndarray:
    """T on all unknowns of the mesh in single precision, a few columns at a time."""
    out, place = np.empty((3 * len(casing.mesh.nodes), len(reduction.mass)), np.float32), 0
    for whole in (reduction.constraint, reduction.modes):
        for start in range(0, whole.shape[1], 32):
            some = whole[:, start : start + 32]
            out[:, place : place + some.shape[1]] = casing.expanded(some)
            place += some.shape[1]
    return out


def kept_modes(
    modes: CasingModes, springs: np.ndarray, *, limit: float | None = None, frequency_error: float | None = None
) -> ModeSet:
    """The modes kept in a reduced body.

    Parameters
    ----------
    modes : all stored modes
    springs : (interface,) N/m, of the mounts
    limit : Hz, fixed-interface modes up to it; all by default
    frequency_error : if given, the fewest modes with which every frequency up to two thirds of the limit deviates at
        most by this share from that with all modes up to the limit
    """
    whole = modes.mode_set
    if limit is None:
        limit = modes.band_limit
    if limit > modes.band_limit * (1.0 + 1e-12):
        raise ValueError(f"modes to {limit:g} Hz requested, known to {modes.band_limit:g} Hz; increase casing.band_Hz")
    whole = kept(whole, int((whole.fixed_frequencies <= limit).sum()))
    if frequency_error is None:
        return whole
    return kept(whole, fewest_modes(whole, springs, band=limit / 1.5, frequency_error=frequency_error))


def reduced_body(
    modes: CasingModes,
    *,
    sensors: Sequence[Sensor] = (),
    damping: DampingRatio = 0.01,
    mounts: Mounts | None = None,
    limit: float | None = None,
    frequency_error: float | None = None,
    stiffness_factor: float = 1.0,
    loss_factors: Mapping[str, float] | None = None,
) -> ReducedBody:
    """The reduced body of a casing, for the multibody model.

    Parameters
    ----------
    modes : of the casing
    sensors : three rows each, moved to the nearest surface point
    damping : modal damping ratio, or rows (Hz, ratio)
    mounts : stiffness of every foot (N/m), only for modes of a casing on springs
    limit, frequency_error : see `kept_modes`
    stiffness_factor : of all but the mounts, see `fem.casing.uncertainty.extrapolation`
    loss_factors : of parts with separate damping, by name; `damping` is that of the rest

    Raises
    ------
    AttachmentError : a sensor far from the surface
    ValueError : mounts that do not fit, more modes than stored, an unknown part
    """
    springs = modes.springs(mounts)
    chosen = kept_modes(modes, springs, limit=limit, frequency_error=frequency_error)
    b, stiffness = chosen.n_interface, on_springs(stiffness_factor * chosen.stiffness, springs)
    known = part_matrices(modes, chosen, springs, stiffness_factor)
    if unknown := [name for name in loss_factors or () if name not in known]:
        raise ValueError(f"casing: no part {unknown[0]!r} has a loss factor; known: {', '.join(known) or 'none'}")
    parts = [(known[name], eta) for name, eta in (loss_factors or {}).items()]
    rows, row_names = [*np.eye(b, len(stiffness))], list(modes.interface_names)
    places = dict(zip(modes.point_names, modes.point_positions, strict=True))
    for sensor in sensors:
        corners, weights, place = nearest_surface_point(modes.nodes, modes.facets, np.array(sensor.position))
        shape = np.einsum("a,adk->dk", weights, modes.basis[corners].astype(float)) @ chosen.basis
        for axis, row in zip(GROUND_AXES, np.array(sensor.axes, float) @ shape, strict=True):
            if f"{sensor.name}:{axis}" not in modes.interface_names:  # unless it is a forced point
                rows.append(row)
                row_names.append(f"{sensor.name}:{axis}")
        places[sensor.name] = place
    return ReducedBody(
        model=modes.model,
        mass=chosen.mass,
        stiffness=stiffness,
        damping=modal_damping(chosen.mass, stiffness, damping, parts),
        coordinate_names=modes.interface_names + mode_names(chosen.n_fixed, len(stiffness) - b),
        row_names=tuple(row_names),
        rows=np.array(rows).reshape(len(rows), len(stiffness)),
        ground_inertia=chosen.basis.T @ modes.participation[:, :3],
        row_shifts=_row_shifts(row_names, sensors),
        point_names=tuple(places),
        point_positions=np.array(list(places.values())),
        foot_stiffness=_foot_rows(modes, springs, stiffness_factor, len(stiffness)),
        foot_inertia=modes.foot_inertia,
        stiffness_factor=stiffness_factor,
        notes=modes.notes,
    )


def part_matrices(modes: CasingModes, chosen: ModeSet, springs: np.ndarray, factor: float) -> dict[str, np.ndarray]:
    """Stiffness (coordinate, coordinate) of every part by its name, including mounts if there are any.

    Parameters
    ----------
    modes, chosen, springs : the casing, its kept modes, and its mounts (interface,) in N/m
    factor : of all but the mounts
    """
    found = {
        name: factor * (chosen.basis.T @ stiffness @ chosen.basis)
        for name, stiffness in zip(modes.part_names, modes.part_stiffness, strict=True)
    }
    if springs.any():
        found[MOUNTS] = np.diag(np.append(springs, np.zeros(len(chosen.mass) - len(springs))))
    return found


def _foot_rows(modes: CasingModes, springs: np.ndarray, factor: float, size: int) -> np.ndarray:
    """Force (3 feet, coordinate) of the ground on the feet: through clamped nodes, or through mounts."""
    rows = np.zeros((len(modes.foot_stiffness), size))
    rows[:, : len(springs)] = factor * modes.foot_stiffness
    at = np.flatnonzero(springs)  # of the feet along x, y, z, the first coordinates
    rows[at, at] -= springs[at]
    return rows


def _row_shifts(row_names: Sequence[str], sensors: Sequence[Sensor]) -> np.ndarray:
    """Motion (row, 3) of every row when the body moves by 1 along x, y, z."""
    axes = {sensor.name: np.array(sensor.axes, float) for sensor in sensors}
    shifts = np.zeros((len(row_names), 3))
    for shift, name in zip(shifts, row_names, strict=True):
        point, axis = name.split(":")
        if axis in GROUND_AXES:
            shift[:] = axes.get(point, np.eye(3))[GROUND_AXES.index(axis)]
    return shifts


@dataclass(frozen=True, eq=False, kw_only=True)
class NaturalModes(Record):
    """Natural modes of a grounded casing."""

    frequencies: np.ndarray = array("mode", units="Hz")
    effective_mass: np.ndarray = array("mode", "motion", units="SI")  # kg; about the centre of gravity kg m2
    total: np.ndarray = array("motion", units="SI")  # mass and inertia of the body
    vectors: np.ndarray = array("coordinate", "mode", units="SI")  # of the stored coordinates, mass-normalised
    part_names: tuple[str, ...] = names("part")
    shares: np.ndarray = array("part", "mode", units="1")  # share of each part in the strain energy


def natural_modes(
    modes: CasingModes, mounts: Mounts | None = None, *, limit: float | None = None, stiffness_factor: float = 1.0
) -> NaturalModes:
    """Frequencies, effective masses (phi^T M R)^2 and shapes.

    Parameters
    ----------
    modes, mounts, limit, stiffness_factor : those of `reduced_body`
    """
    springs = modes.springs(mounts)
    chosen = kept_modes(modes, springs, limit=limit)
    stiffness = on_springs(stiffness_factor * chosen.stiffness, springs)
    frequencies, phi = undamped_modes(stiffness, chosen.mass)
    vectors = chosen.basis @ phi
    parts = part_matrices(modes, chosen, springs, stiffness_factor)
    return NaturalModes(
        frequencies=frequencies,
        effective_mass=(vectors.T @ modes.participation) ** 2,
        total=np.concatenate([np.full(3, modes.total_mass), np.diag(modes.inertia)]),
        vectors=vectors,
        part_names=tuple(parts),
        shares=energy_shares(list(parts.values()), phi, stiffness),
    )


def grounded_body(bearings: Mapping[str, Sequence[float]]) -> ReducedBody:
    """The model `none`: bearings held by the ground; no coordinates, rows without entries."""
    row_names = [f"{name}:{axis}" for name in bearings for axis in BEARING_AXES]
    nothing = np.zeros((0, 0))
    return ReducedBody(
        model="none",
        mass=nothing,
        stiffness=nothing,
        damping=nothing,
        coordinate_names=(),
        row_names=tuple(row_names),
        rows=np.zeros((len(row_names), 0)),
        ground_inertia=np.zeros((0, 3)),
        row_shifts=np.zeros((len(row_names), 3)),
        point_names=tuple(bearings),
        point_positions=np.array([list(place) for place in bearings.values()], float).reshape(-1, 3),
        foot_stiffness=nothing,
        foot_inertia=np.zeros((0, 3)),
    )
