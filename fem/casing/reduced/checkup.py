"""Check-up of a reduced casing: the usual checks of a structural analyst before its use.

Before grounding (free body): symmetry, K R = 0, mass, centre of gravity and inertia from R^T M R against the mesh
integral, and the six rigid body modes in three ways: from geometry (R itself), from the stiffness (u_i = -K_ii^-1 K_ig
R_g for given motions of the feet), and from the eigenvalues of the body condensed to its six feet.

After grounding (for a casing on mounts: on the reference springs, which are stiffer than any mount): the reaction to
gravity, definiteness, block forms of the reduced matrices, the static response of the interface against the full model,
modal effective masses, optionally the frequencies of the full grounded model.

`fem.casing.reduced.sturm_count` has verified that no mode is missing.

The list follows the practice of NASTRAN-based Craig-Bampton checks (Young, Primer on the Craig-Bampton method, 2000).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from fem.casing.reduced.grounded import AssembledCasing
from fem.casing.reduced.reduction import Reduction
from fem.casing.reduced.undamped_modes import on_springs, undamped_modes
from fem.elements.solids import rigid_body_modes
from fem.storage.records import Record, array, names, scalar

_VECTORS = 4  # random sign vectors, for checks of matrix blocks
_ITEMS = {  # limit and meaning of every item
    "stiffness_asymmetry": (1e-12, "max |(K - K^T) x| over max |K|, x of random signs"),
    "mass_asymmetry": (1e-12, "max |(M - M^T) x| over max |M|, x of random signs"),
    "grounding": (1e-9, "max |K R| over max |K| max |R|: a rigid motion needs no force"),
    "rigid_from_stiffness": (1e-6, "rigid motion of the feet carries the body rigidly, largest relative deviation"),
    "rigid_eigenvalue": (1e-6, "sixth over seventh eigenvalue of the free body condensed to its feet"),
    "mass_error": (1e-9, "mass from R^T M R against the mesh integral"),
    "centre_error": (1e-9, "centre of gravity, the same, over the radius of gyration"),
    "inertia_error": (1e-8, "inertia tensor, the same"),
    "reaction_error": (1e-7, "reaction of the feet to gravity against the weight"),
    "reduced_mass_definite": (1.0, "number of eigenvalues of the reduced mass that are not positive"),
    "reduced_stiffness_definite": (1.0, "number of eigenvalues of the reduced stiffness that are not positive"),
    "modal_mass_identity": (1e-8, "max |Phi^T M Phi x - x| of the modes, x of random signs"),
    "interface_to_modes": (1e-6, "max |Phi^T K Psi x| of modes and constraint modes, relative, x of random signs"),
    "static_response": (1e-8, "interface response to gravity along x, y, z, reduced against full model"),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class CheckUp(Record):
    """Deviations of a reduced casing from exact properties; all relative unless stated."""

    item_names: tuple[str, ...] = names("item")  # of `_ITEMS`
    items: np.ndarray = array("item", units="1")
    mass: float = scalar(units="kg")
    centre: np.ndarray = array("axis", units="m")
    inertia: np.ndarray = array("axis", "axis", units="kg m2")
    frequencies: np.ndarray = array("mode", units="Hz")  # of the grounded reduced body

    @property
    def failures(self) -> tuple[str, ...]:
        """Names of the items beyond their limits."""
        found = zip(self.item_names, self.items, strict=True)
        return tuple(name for name, value in found if not value < _ITEMS[name][0])

    def report(self) -> str:
        """The check-up as text: every item with its limit, then mass properties."""
        lines = ["Checks of the reduced casing"]
        for name, value in zip(self.item_names, self.items, strict=True):
            limit, meaning = _ITEMS[name]
            verdict = "ok  " if value < limit else "FAIL"
            lines.append(f"  {verdict} {name:<27} {value:9.2e}  (limit {limit:.0e})  {meaning}")
        x, y, z = 1000 * self.centre
        lines.append(f"  mass {self.mass:.6g} kg, centre of gravity ({x:.6g}, {y:.6g}, {z:.6g}) mm")
        lines.append("  inertia about it (kg m2): " + "; ".join(" ".join(f"{v:.5g}" for v in r) for r in self.inertia))
        return "\n".join(lines)


def check_up(casing: AssembledCasing, reduction: Reduction) -> CheckUp:
    """Check a reduction with the loads of `casing` against its full model."""
    mass, centre, inertia = casing.mass_properties
    R, MR = casing.rigid, casing.inertial
    held = on_springs(reduction.stiffness, casing.springs)
    items = {
        **casing.free_body,
        **_rigid_items(casing, reduction, R, MR, mass, inertia),
        **_reduced_items(casing, reduction, held, casing.expansion.T @ MR[:, :3]),
    }
    return CheckUp(
        item_names=tuple(items),
        items=np.array(list(items.values())),
        mass=mass,
        centre=centre,
        inertia=inertia,
        frequencies=undamped_modes(held, reduction.mass)[0],
    )


def _rigid_items(
    casing: AssembledCasing, reduction: Reduction, R: np.ndarray, MR: np.ndarray, mass: float, inertia: np.ndarray
) -> dict[str, float]:
    """Rigid body items of the free body, and the reaction to gravity of the grounded one."""
    block = R.T @ MR
    gyration = math.sqrt(np.trace(inertia) / (2.0 * mass))
    first_moment = np.array([block[2, 4], block[0, 5], block[1, 3]])
    feet = _on_clamped_feet if casing.ground == "fixed" else _on_springs
    motion, together, condensed, reaction = feet(casing, reduction, R, MR)
    value = np.sort(abs(la.eigh(condensed, motion.T @ motion, eigvals_only=True)))
    return {
        "rigid_from_stiffness": float(abs(together - R).max() / abs(R).max()),
        "rigid_eigenvalue": float(value[5] / value[6]) if len(value) > 6 else 0.0,
        "mass_error": float(abs(np.diag(block)[:3] / mass - 1.0).max()),
        "centre_error": float(abs(first_moment).max() / (mass * gyration)),
        "inertia_error": float(abs(block[3:, 3:] - inertia).max() / np.trace(inertia)),
        "reaction_error": float(abs(reaction + mass * np.eye(3)).max() / mass),
    }


def _on_clamped_feet(
    casing: AssembledCasing, reduction: Reduction, R: np.ndarray, MR: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Motions of single feet (n, 6 feet), of all feet as one body (n, 6), condensed stiffness, reaction to gravity.

    The stiffness is condensed to the motions of single feet; the reaction (3, 3) is that to unit gravity.

    Each foot moves as a rigid patch, six columns per foot; the other unknowns follow by the stiffness, free of forces.
    """
    E, clamped, motion = casing.expansion, casing.clamped, casing.foot_motions
    K_clamped, led = casing.K_clamped, motion[clamped]
    motion -= E @ reduction.loaded[:, :-3]
    together = motion.reshape(len(R), -1, 6).sum(axis=1)
    condensed = led.T @ (K_clamped @ motion)
    gravity = K_clamped @ (E @ reduction.loaded[:, -3:])
    return motion, together, 0.5 * (condensed + condensed.T), R[clamped, :3].T @ (gravity - MR[clamped, :3])


def _on_springs(
    casing: AssembledCasing, reduction: Reduction, R: np.ndarray, MR: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """As `_on_clamped_feet`, for feet on springs: the ground under the springs moves, three columns per foot."""
    at_feet, motion = np.flatnonzero(casing.springs), reduction.loaded[:, :-3]
    feet = np.array([casing.mesh.point(name) for name in casing.mesh.patches("ground_")])
    ground = rigid_body_modes(feet, casing.mass_properties[1])
    forces = casing.springs[at_feet, None] * (casing.rows[at_feet] @ reduction.loaded[:, -3:])
    condensed, motion = motion.T @ (casing.K_free @ motion), casing.expansion @ motion
    return motion, motion @ ground, condensed, -ground[:, :3].T @ forces


def _reduced_items(
    casing: AssembledCasing, reduction: Reduction, held: np.ndarray, gravity: np.ndarray
) -> dict[str, float]:
    """Definiteness, block forms by products of full matrices with random vectors, static response of the interface."""
    b = reduction.constraint.shape[1]
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (b + reduction.modes.shape[1], _VECTORS))
    omega = np.maximum(2 * math.pi * reduction.frequencies, 1.0)[:, None]
    scale = np.sqrt(np.diag(reduction.stiffness)[:b, None])
    at_interface = reduction.constraint @ (signs[:b] / scale)
    between = reduction.modes.T @ (casing.K_free @ at_interface) / omega
    identity = reduction.modes.T @ (casing.M_free @ (reduction.modes @ signs[b:]))
    exact = scale * (casing.rows @ reduction.loaded[:, -3:])
    found = scale * la.solve(held, reduction.projected(gravity))[:b]
    static = abs(found - exact).max(initial=0.0) / abs(exact).max(initial=np.finfo(float).tiny)
    return {
        "reduced_mass_definite": float((_scaled_eigenvalues(reduction.mass) <= 0.0).sum()),
        "reduced_stiffness_definite": float((_scaled_eigenvalues(held) <= 0.0).sum()),
        "modal_mass_identity": float(abs(identity - signs[b:]).max(initial=0.0)),
        "interface_to_modes": float(abs(between).max(initial=0.0)),
        "static_response": float(static),
    }


def _scaled_eigenvalues(matrix: np.ndarray) -> np.ndarray:
    root = np.sqrt(abs(np.diag(matrix)))
    return la.eigvalsh(matrix / np.outer(root, root)) if len(matrix) else np.ones(1)
