"""Natural frequencies of a corrected casing with springs and masses at its seats.

    python -m benchmarks.mode_correction SCENE ELEMENT MM FINE_ELEMENT FINE_MM

A casing of one mesh is compared with one of a finer mesh: with free seats, with springs at every seat, and with masses
there. The stiffness is that of the mesh, with one factor for all modes, or with the frequency of every compared mode
corrected. The finer casing has one factor.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from fem.casing.reduced.casing_modes import CasingModes
from fem.casing.reduced.undamped_modes import undamped_modes
from fem.casing.uncertainty.extrapolation import measured_limits
from pipelines.engine.run_graph import Work
from pipelines.runs.single_results import scene_graph
from pipelines.scene.load_scene import load_scene

MODES = 20  # compared
SEATS = {"free": (0.0, 0.0), "1e8 N/m": (1e8, 0.0), "1e9 N/m": (1e9, 0.0), "5 kg": (0.0, 5.0)}  # stiffness, mass


def corrected_motion(stiffness: np.ndarray, mass: np.ndarray, ratios: np.ndarray) -> np.ndarray:
    """A = r_m (I + Phi (diag(r/r_m) - I) Phi^T M), with the modes Phi and r_m, the mean of the ratios r.

    A^T K A has the modes Phi with r times their frequencies, and r_m^2 times all other stiffness.
    """
    if not len(ratios):
        return np.eye(len(mass))
    _, shapes = la.eigh(stiffness, mass, subset_by_index=(0, len(ratios) - 1))
    mean = float(ratios.mean())
    return mean * np.eye(len(mass)) + shapes @ ((ratios - mean)[:, None] * (shapes.T @ mass))


@dataclass(frozen=True)
class Extrapolated:
    """Modes of a casing on its mesh, and the ratios of its extrapolated to its computed frequencies."""

    modes: CasingModes
    ratios: np.ndarray

    def stiffness(self, ratios: np.ndarray) -> np.ndarray:
        """Corrected stiffness."""
        A = corrected_motion(self.modes.stiffness, self.modes.mass, ratios)
        return np.asarray(A.T @ self.modes.stiffness @ A)

    @property
    def one_factor(self) -> np.ndarray:
        """The mean ratio for all modes."""
        return np.full(1, self.ratios.mean())

    def frequencies(self, ratios: np.ndarray, spring: float, mass: float) -> np.ndarray:
        """The lowest frequencies, Hz, with springs (N/m) and masses (kg) at all seats."""
        names = self.modes.interface_names
        seat = np.array([name.startswith("bearing") and name.split(":")[1] in ("ux", "uy", "uz") for name in names])
        added = np.append(seat, np.zeros(len(self.modes.mass) - len(seat)))
        K, M = self.stiffness(ratios) + np.diag(spring * added), self.modes.mass + np.diag(mass * added)
        return undamped_modes(K, M)[0][:MODES]

    def seat_flexibility(self, ratios: np.ndarray) -> float:
        """Mean radial flexibility of the seats, m/N."""
        names = self.modes.interface_names
        radial = [i for i, n in enumerate(names) if n.startswith("bearing") and n.split(":")[1] in ("ux", "uz")]
        return float(np.diag(la.inv(self.stiffness(ratios)))[radial].mean())


def extrapolated(scene: str, element: str, size: str) -> Extrapolated:
    """The casing of a scene with elements of one kind and size (mm)."""
    settings = {"casing.element": element, "casing.element_size_mm": float(size), "casing.extrapolated": True}
    graph, _ = scene_graph(load_scene(scene, settings))
    coarser = graph.steps["casing"].takes["coarser"]
    outcome = Work().build(graph, ["casing modes", *coarser])
    modes = outcome.value("casing modes")[0]
    limits = measured_limits(modes, [outcome.value(name) for name in coarser])
    return Extrapolated(modes, limits.limits / limits.frequencies)


def main(scene: str, *kinds: str) -> None:
    """Print mean and standard deviation of the differences, in %."""
    coarse, fine = extrapolated(scene, *kinds[:2]), extrapolated(scene, *kinds[2:])
    corrections = {"none": np.zeros(0), "one factor": coarse.one_factor, "every mode": coarse.ratios}
    for seats, (spring, mass) in SEATS.items():
        wanted = fine.frequencies(fine.one_factor, spring, mass)
        for name, ratios in corrections.items():
            off = 100.0 * (coarse.frequencies(ratios, spring, mass) / wanted - 1.0)
            print(f"seats {seats:8} correction {name:10} {off.mean():+.3f} % mean, {off.std():.3f} % scatter")
    for name, ratios in corrections.items():
        off = coarse.seat_flexibility(ratios) / fine.seat_flexibility(fine.one_factor) - 1.0
        print(f"flexibility of the seats, correction {name:10} {100.0 * off:+.3f} %")


if __name__ == "__main__":
    main(*sys.argv[1:])
