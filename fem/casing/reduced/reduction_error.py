"""Error statement of a reduced casing: its frequencies and bearing-to-sensor responses compared with the full model.

Modal damping of the full model would need all its modes. Its response is therefore the sum of the damped modes up to a
limit well above the band, and of the remaining spectrum by powers of K^-1 M on the loads (hybrid expansion):

    H(w) = sum_k c phi_k phi_k^T b / (w_k^2 - w^2 + 2 i zeta_k w_k w)
           + sum_p w^(2p) c (Q K^-1 M)^p Q K^-1 b,   p = 0 .. P - 1,   Q = 1 - sum_k phi_k phi_k^T M

The truncation error of the second sum is (w/w_next)^(2P) of it: 4e-3 at the end of the band for P = 7 and modes to 1.5
times the band. The damping of modes beyond the limit is neglected (at most 2.4 zeta of their share). The same modes
give the frequencies of the full model.

Reference: Leung (1978), J. Sound Vib. 59(4), 563-580; Qu (2000), AIAA J. 38(2), 340-347.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.casing.geometry.dimensions import Sensor
from fem.casing.parts.casing_choices import MOUNTS
from fem.casing.reduced.damping import DampingRatio, damping_ratios, ratios_with_parts
from fem.casing.reduced.grounded import GROUND_AXES, AssembledCasing, ForcedPoint, point_rows
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.reduced_body import MODES_OVER_BAND, ReducedBody
from fem.casing.reduced.undamped_modes import undamped_modes
from fem.numerics.linear_solver import factorize
from fem.storage.records import Record, array, names, scalar

_POWERS = 7
LINES = 24  # frequencies per third octave: their spacing is half the half-power bandwidth at 1 % damping
LOWEST = 100.0  # Hz, middle of the first third octave


@dataclass(frozen=True, eq=False, kw_only=True)
class ErrorStatement(Record):
    """Deviation of a reduced casing from its full model.

    A pair is a bearing (forces along its load-carrying axes) and a sensor (three axes). Its error in a third octave is
    the norm of the difference of all its responses over the norm of those of the full model.
    """

    band: float = scalar(units="Hz")
    full_frequencies: np.ndarray = array("mode", units="Hz")  # of the grounded full model, up to the band
    frequency_errors: np.ndarray = array("mode", units="1")  # reduced over full - 1
    third_octaves: np.ndarray = array("third", units="Hz")  # mid frequencies
    bearings: tuple[str, ...] = names("bearing")
    sensors: tuple[str, ...] = names("sensor")
    response_errors: np.ndarray = array("third", "bearing", "sensor", units="1")

    def report(self) -> str:
        """The statement as text."""
        worst = int(abs(self.frequency_errors).argmax()) if len(self.frequency_errors) else 0
        lines = [f"Error of the reduced casing against the full model, to {self.band:g} Hz"]
        if len(self.full_frequencies):
            lines.append(
                f"  {len(self.full_frequencies)} natural frequencies: largest error "
                f"{100 * self.frequency_errors[worst]:.2g} % at {self.full_frequencies[worst]:.1f} Hz"
            )
        if not self.response_errors.size:
            return "\n".join(lines)
        place = np.unravel_index(int(self.response_errors.argmax()), self.response_errors.shape)
        lines += [
            f"  responses of {len(self.sensors)} sensors to {len(self.bearings)} bearings, norm of the difference over "
            "norm of the response in third octaves:",
            f"    largest {100 * self.response_errors.max():.2g} %: {self.bearings[place[1]]} to "
            f"{self.sensors[place[2]]} at {self.third_octaves[place[0]]:.0f} Hz",
            "    Hz        " + " ".join(f"{f:7.0f}" for f in self.third_octaves),
            "    largest % " + " ".join(f"{100 * e:7.2g}" for e in self.response_errors.max(axis=(1, 2))),
        ]
        return "\n".join(lines)


def state_error(
    casing: AssembledCasing,
    body: ReducedBody,
    *,
    band: float,
    sensors: Sequence[Sensor],
    damping: DampingRatio,
    loss_factors: Mapping[str, float] | None = None,
    springs: np.ndarray | None = None,
) -> ErrorStatement:
    """Compare a reduced casing with its full model; as expensive as the reduction.

    Parameters
    ----------
    casing : full model
    body : reduced from it
    band : Hz, up to which both are compared
    sensors : sensors of the compared responses, along their axes
    damping, loss_factors : of the full model, as given for the body
    springs : (interface,) N/m of the mounts, if the casing is on springs

    Raises
    ------
    ValueError : the body has no row of a requested sensor
    """
    mounts = 0.0 if springs is None else casing.rows.T @ sp.diags_array(springs) @ casing.rows
    solve = factorize(casing.K_free + mounts).solve
    smallest = (2.0 * math.pi * MODES_OVER_BAND * band) ** -2.0
    theta, phi = block_lanczos(solve, casing.M_free, smallest=smallest)
    full = 1.0 / (2.0 * math.pi * np.sqrt(theta))
    reduced, _ = undamped_modes(body.stiffness, body.mass)
    inside = full[full <= band][: len(reduced)]
    thirds, frequencies = third_octaves(band)
    loads = casing.rows
    bearing_rows = np.array([not n.startswith("ground_") for n in casing.coordinate_names])
    used = loads[np.flatnonzero(bearing_rows)]
    readings = sensor_rows(casing, sensors) if sensors else sp.csr_matrix((0, loads.shape[1]))
    zeta = _ratios(casing, theta, phi, damping, loss_factors or {}, springs)
    exact = full_response(solve, casing.M_free, theta, phi, zeta, used, readings, frequencies)
    names_used = [n for n, is_bearing in zip(casing.coordinate_names, bearing_rows, strict=True) if is_bearing]
    found = reduced_response(body, names_used, [s.name for s in sensors], frequencies)
    bearings = tuple(dict.fromkeys(name.split(":")[0] for name in names_used))
    moving = np.array([[n.startswith(f"{bearing}:u") for bearing in bearings] for n in names_used], float)
    shape = len(thirds), LINES, len(sensors), 3, len(names_used)
    off, size = ((abs(h) ** 2).reshape(shape).sum(axis=(1, 3)) @ moving for h in (found - exact, exact))
    return ErrorStatement(
        band=band,
        full_frequencies=inside,
        frequency_errors=reduced[: len(inside)] / inside - 1.0,
        third_octaves=thirds,
        bearings=bearings,
        sensors=tuple(sensor.name for sensor in sensors),
        response_errors=np.sqrt(off / size).transpose(0, 2, 1),
    )


def _ratios(
    casing: AssembledCasing,
    theta: np.ndarray,
    phi: np.ndarray,
    damping: DampingRatio,
    loss_factors: Mapping[str, float],
    springs: np.ndarray | None,
) -> np.ndarray:
    """Zeta (mode,) of the modes of the full model, see `fem.casing.reduced.damping`."""
    ratios = damping_ratios(damping, 1.0 / (2.0 * math.pi * np.sqrt(theta)))
    if not loss_factors:
        return ratios
    parts, held = dict(casing.parts), casing.rows
    if springs is not None:
        parts[MOUNTS] = sp.csr_matrix(held.T @ sp.diags_array(springs) @ held)
    shares = np.array([theta * np.einsum("ik,ik->k", phi, parts[name] @ phi) for name in loss_factors])
    return ratios_with_parts(ratios, shares, list(loss_factors.values()))


def third_octaves(band: float) -> tuple[np.ndarray, np.ndarray]:
    """Mid frequencies (base ten, IEC 61260) from 100 Hz to the band, and `LINES` frequencies in each, none beyond."""
    number = np.arange(math.ceil(10.0 * math.log10(max(band, LOWEST) / LOWEST) - 0.5) + 1)
    middle = LOWEST * 10.0 ** (number / 10.0)
    ends = np.minimum(np.outer(middle, [10.0**-0.05, 10.0**0.05]), band)
    middle, ends = middle[ends[:, 0] < ends[:, 1]], ends[ends[:, 0] < ends[:, 1]]
    steps = (np.arange(LINES) + 0.5) / LINES
    return middle, (ends[:, :1] * (ends[:, 1:] / ends[:, :1]) ** steps).ravel()


def sensor_rows(casing: AssembledCasing, sensors: Sequence[Sensor]) -> sp.csr_matrix:
    """Rows (3 sensor, n) of the displacements along the sensor axes in the full model."""
    nodal = casing.expansion[: 3 * len(casing.mesh.nodes)]
    points = (ForcedPoint(sensor=sensor, axes=GROUND_AXES) for sensor in sensors)
    return sp.csr_matrix(sp.vstack([point_rows(casing.mesh, point) @ nodal for point in points]))


def full_response(
    solve: Callable[[np.ndarray], np.ndarray],
    M: sp.csr_matrix,
    theta: np.ndarray,
    phi: np.ndarray,
    zeta: np.ndarray,
    loads: sp.csr_matrix,
    readings: sp.csr_matrix,
    frequencies: np.ndarray,
) -> np.ndarray:
    """Displacement responses (frequency, reading, load) of the full model.

    Parameters
    ----------
    solve : X (n, k) -> K^-1 X
    M : sparse (n, n), SI
    theta, phi, zeta : 1/omega^2 (m,) s2, modes (n, m) orthonormal in M, damping ratios (m,)
    loads, readings : sparse rows (l, n), (r, n)
    frequencies : (f,) Hz
    """
    square = 1.0 / theta
    left, right = readings @ phi, (loads @ phi).T
    X, rest = loads.T.toarray(), []
    for _ in range(_POWERS):
        X = solve(X)
        X -= phi @ (phi.T @ (M @ X))  # otherwise round-off of the lowest modes, amplified by the powers, would dominate
        rest.append(readings @ X)
        X = M @ X
    out = np.empty((len(frequencies), readings.shape[0], loads.shape[0]), complex)
    for number, omega in enumerate(2.0 * math.pi * frequencies):
        modal = left / (square - omega**2 + 2j * zeta * np.sqrt(square) * omega)
        out[number] = modal @ right + sum(omega ** (2 * p) * term for p, term in enumerate(rest))
    return out


def reduced_response(
    body: ReducedBody, loads: Sequence[str], sensors: Sequence[str], frequencies: np.ndarray
) -> np.ndarray:
    """Displacement responses (frequency, reading, load) of a reduced body; a sensor has three readings.

    Parameters
    ----------
    body : reduced casing
    loads : names of rows, as "bearing_1:ux"
    sensors : names of sensors
    frequencies : (f,) Hz

    Raises
    ------
    ValueError : the body has no row of that name
    """
    try:
        B = np.array([body.row(name) for name in loads]).reshape(len(loads), -1).T
        C = np.array([body.row(f"{name}:{axis}") for name in sensors for axis in ("ux", "uy", "uz")])
    except KeyError as error:
        raise ValueError(f"the reduced casing cannot be compared: {error.args[0]}") from error
    C = C.reshape(3 * len(sensors), len(body.mass))
    out = np.empty((len(frequencies), len(C), B.shape[1]), complex)
    for number, omega in enumerate(2.0 * math.pi * frequencies):
        dynamic = body.stiffness - omega**2 * body.mass + 1j * omega * body.damping
        out[number] = C @ np.linalg.solve(dynamic, B)
    return out
