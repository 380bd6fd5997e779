"""CasingModes: the expensive result of a casing reduction, and the cheap step from it to a ReducedBody.

Sensors are recovered from the basis on the surface nodes; damping comes from the modes of the grounded reduced body.
Changing either costs no factorisation and no eigensolution of the mesh.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from fem.casing.body import ReducedBody
from fem.casing.coupling import nearest_surface_point
from fem.casing.grounded import BEARING_AXES, GroundedCasing
from fem.casing.housing import Sensor
from fem.casing.reduction import Reduction
from fem.elasticity import mass_properties, rigid_body_modes
from fem.records import Record, array, integer, names, scalar, text


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingModes(Record):
    """Reduced matrices of a grounded casing and its basis on the surface."""

    model: str = text()  # "static" | "craig-bampton"
    solver: str = text()  # which code factorised the stiffness
    mass: np.ndarray = array("coordinate", "coordinate", units="SI")
    stiffness: np.ndarray = array("coordinate", "coordinate", units="SI")
    coordinate_names: tuple[str, ...] = names("coordinate")  # interface, "mode_1", ..., "inertia_1", ...
    fixed_frequencies: np.ndarray = array("mode", units="Hz")  # fixed-interface modes, then inertia corrections
    band_limit: float = scalar(units="Hz")  # every fixed-interface mode below it is kept
    unknowns: int = integer()  # of the grounded mesh
    participation: np.ndarray = array("coordinate", "motion", units="SI")  # T^T M R, R about the centre of gravity
    total_mass: float = scalar(units="kg")
    centre: np.ndarray = array("axis", units="m")  # of gravity
    inertia: np.ndarray = array("axis", "axis", units="kg m2")  # about the centre
    point_names: tuple[str, ...] = names("point")  # ground and bearing points
    point_positions: np.ndarray = array("point", "axis", units="m")
    surface_nodes: np.ndarray = array("surface_node", "axis", units="m")
    facets: np.ndarray = array("facet", "facet_corner", units="1", dtype=np.int32)  # into surface_nodes
    surface_basis: np.ndarray = array("surface_node", "axis", "coordinate", units="SI", dtype=np.float32)

    @property
    def interface_names(self) -> tuple[str, ...]:
        """Names of the physical coordinates."""
        return tuple(name for name in self.coordinate_names if ":" in name)


def casing_modes(casing: GroundedCasing, reduction: Reduction, *, model: str, band_limit: float) -> CasingModes:
    """Collect what later stages need of a reduction."""
    mesh, n = casing.mesh, len(casing.mesh.nodes)
    basis = reduction.basis
    extra = reduction.modes.shape[1] - reduction.n_fixed
    mode_names = [f"mode_{i + 1}" for i in range(reduction.n_fixed)] + [f"inertia_{i + 1}" for i in range(extra)]
    mass, centre, inertia = mass_properties(mesh.nodes, mesh.elements, casing.material.density)
    force = (casing.M @ rigid_body_modes(mesh.nodes, centre))[casing.free]
    surface, facets = np.unique(mesh.facets, return_inverse=True)
    everywhere = np.zeros((3 * n, basis.shape[1]), np.float32)
    everywhere[casing.free] = basis
    return CasingModes(
        model=model,
        solver=casing.interface.factor.name,
        mass=reduction.mass,
        stiffness=reduction.stiffness,
        coordinate_names=casing.coordinate_names + tuple(mode_names),
        fixed_frequencies=reduction.frequencies,
        band_limit=band_limit,
        unknowns=len(casing.free),
        participation=basis.T @ force,
        total_mass=mass,
        centre=centre,
        inertia=inertia,
        point_names=mesh.patch_names,
        point_positions=mesh.patch_points,
        surface_nodes=mesh.nodes[surface],
        facets=facets.reshape(mesh.facets.shape),
        surface_basis=everywhere.reshape(n, 3, -1)[surface],
    )


def modal_damping(mass: np.ndarray, stiffness: np.ndarray, ratio: float) -> np.ndarray:
    """C = M Phi diag(2 zeta omega) Phi^T M of the modes of (K, M): the same damping ratio in every mode.

    Parameters
    ----------
    mass, stiffness : float (n, n), positive definite
    ratio : zeta, 0 <= zeta < 1; ValueError otherwise
    """
    if not 0.0 <= ratio < 1.0:
        raise ValueError(f"casing damping ratio is {ratio!r}; give a value from 0 to below 1 (cast iron about 0.01)")
    if not len(mass):
        return np.zeros((0, 0))
    square, phi = la.eigh(stiffness, mass)
    weighted = mass @ phi
    return (weighted * (2.0 * ratio * np.sqrt(np.maximum(square, 0.0)))) @ weighted.T


def reduced_body(modes: CasingModes, *, sensors: Sequence[Sensor] = (), damping_ratio: float = 0.01) -> ReducedBody:
    """The casing as the multibody model sees it; three rows per sensor asked, moved to the nearest surface point.

    Raises
    ------
    CouplingError : a sensor far from the surface
    ValueError : damping ratio out of range
    """
    rows, row_names = [], []
    for index, name in enumerate(modes.interface_names):
        rows.append(np.eye(len(modes.mass))[index])
        row_names.append(name)
    places = dict(zip(modes.point_names, modes.point_positions, strict=True))
    for sensor in sensors:
        corners, weights, place = nearest_surface_point(modes.surface_nodes, modes.facets, np.array(sensor.position))
        shape = np.einsum("a,adk->dk", weights, modes.surface_basis[corners].astype(float))
        rows += list(np.array(sensor.axes) @ shape)
        row_names += [f"{sensor.name}:{axis}" for axis in ("ux", "uy", "uz")]
        places[sensor.name] = place
    return ReducedBody(
        model=modes.model,
        mass=modes.mass,
        stiffness=modes.stiffness,
        damping=modal_damping(modes.mass, modes.stiffness, damping_ratio),
        coordinate_names=modes.coordinate_names,
        row_names=tuple(row_names),
        rows=np.array(rows).reshape(len(rows), len(modes.mass)),
        point_names=tuple(places),
        point_positions=np.array(list(places.values())),
    )


def grounded_body(bearings: Mapping[str, Sequence[float]]) -> ReducedBody:
    """The rung `none`: bearings held by the ground; no coordinates, rows without entries."""
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
        point_names=tuple(bearings),
        point_positions=np.array([list(place) for place in bearings.values()], float).reshape(-1, 3),
    )
