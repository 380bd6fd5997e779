"""A gear pair over its load: transmission error and mesh orders, and the load of flanks and roots along the face.

Pressure and root stress at a place of the face are the largest of one tooth over its engagement.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from fem.contact.evaluation.contact_pattern import contact_pattern
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.mesh_cycle import ORDERS, MeshCycle, mesh_cycle, order_amplitudes
from fem.contact.law import MeshLaw
from fem.contact.models.solid_stress import RootStress
from fem.gears.geometry import GearPair
from pipelines.io.user_files import whole_file
from pipelines.steps.pair_curves import quantity

TORQUE_SHARES = (0.25, 0.5, 0.75, 1.0)  # of the torque of the scene
TORQUES = 12  # in equal steps up to the largest one
POSITIONS = 128  # in the mesh cycle
FORMATS = (".png", ".svg", ".pdf", ".nc")
_CONTENT = {
    "transmission_error": (("torque", "position"), "m", "approach at the torque"),
    "peak_to_peak": (("torque",), "m", "peak-to-peak transmission error"),
    "order_amplitude": (("torque", "order"), "m", "amplitude of an order of the mesh frequency"),
    "face_load_factor": (("torque",), "1", "largest mean line load along the face over its mean, K_H beta"),
    "line_load": (("torque", "face"), "N/m", "mean line load of all tooth pairs"),
    "pressure": (("torque", "face"), "Pa", "largest Hertz pressure on the active flanks"),
    "root_stress": (
        ("torque", "gear", "root_face"),
        "Pa",
        "largest von Mises stress of the loaded fillets",
    ),
    "pattern": (("pattern_torque", "diameter", "pattern_face"), "Pa", "largest Hertz pressure on the pinion's flank"),
}


def load_map(
    pair: GearPair,
    laws: Mapping[str, MeshLaw],
    torques: Sequence[float],
    roots: Sequence[RootStress],
    *,
    sense: int = 1,
    tilt: float = 0.0,
) -> xarray.Dataset:
    """Quantities of a pair without faults over the torque on its pinion.

    Parameters
    ----------
    pair, laws : the gears in mesh, and laws of the drive flank by the name of their state
    torques : N m; contact patterns are those of the first, the middle and the last one
    roots : stresses of the fillets of pinion and wheel by unit forces
    sense : +1 if the face coordinate of the laws runs along the global y, else -1
    tilt : rad, in the face coordinate of the laws

    Returns
    -------
    the variables of `_CONTENT` over (state, ...): torque (N m), position (mesh cycles), face (m, along the global y)

    Raises
    ------
    LawError : a force is not reached
    """
    given = sorted(set(torques))
    torque = np.unique([float(f"{one:.9g}") for one in [*given, *np.arange(1, TORQUES + 1) * given[-1] / TORQUES]])
    shown, radius = np.unique([given[0], given[len(given) // 2], given[-1]]), pair.pinion.base_radius
    nodes = np.unique(np.round(np.concatenate([one.face for one in roots]), 12))[::sense]
    found = []
    for name, law in laws.items():
        cycle = mesh_cycle(pair, LawEvaluator(law), torque / radius, tilt, POSITIONS)
        face, every = law.face_coordinate[::sense], range(torque.size)
        teeth = np.zeros(law.pinion_teeth), np.zeros(law.wheel_teeth)
        patterns = [contact_pattern(name, pair, law, "pinion", 0, one / radius, teeth, tilt=tilt) for one in shown]
        found.append(
            {
                "transmission_error": cycle.error,
                "peak_to_peak": np.ptp(cycle.error, axis=1),
                "order_amplitude": order_amplitudes(cycle.error),
                "face_load_factor": [cycle.face_load_factor(n) for n in every],
                "line_load": [cycle.line_load(n)[::sense] for n in every],
                "pressure": [cycle.pressure(n)[::sense] for n in every],
                "root_stress": [[_along_face(one, nodes, law, cycle, n) for one in roots] for n in every],
                "pattern": [one.pressure[:, ::sense] for one in patterns],
            }
        )
    return xarray.Dataset(
        {
            name: (("state", *dims), np.array([one[name] for one in found]), quantity(units, text))
            for name, (dims, units, text) in _CONTENT.items()
        },
        coords={
            "state": list(laws),
            "torque": ("torque", torque, quantity("N m", "on the pinion")),
            "pattern_torque": ("pattern_torque", shown, quantity("N m", "on the pinion")),
            "position": ("position", cycle.cycle, quantity("1", "mesh cycles")),
            "order": ("order", np.arange(1, ORDERS + 1), quantity("1", "of the mesh frequency")),
            "gear": ["pinion", "wheel"],
            "face": ("face", sense * face, quantity("m", "y from mid face")),
            "root_face": ("root_face", sense * nodes, quantity("m", "y from mid face")),
            "pattern_face": ("pattern_face", sense * patterns[0].face[::sense], quantity("m", "y from mid face")),
            "diameter": ("diameter", patterns[0].diameter, quantity("m", "diameter on the pinion")),
        },
        attrs={"pitch_diameter": 2 * pair.working_radii[0]},
    )


def _along_face(root: RootStress, face: np.ndarray, law: MeshLaw, cycle: MeshCycle, load: int) -> np.ndarray:
    """Largest root stress (face,), Pa, of one gear at a load of the cycle."""
    stress = root.of(law, cycle.cycle, *cycle.line_loads(load)).max(axis=(0, 1))
    return np.interp(face, root.face[:: root.turn], stress[:: root.turn])


def root_rows(stage: int, found: xarray.Dataset, torques: Sequence[float]) -> list[dict[str, Any]]:
    """Rows with the largest root stresses of a map at some of its torques (N m)."""
    largest = 1e-6 * found.root_stress.max("root_face")
    return [
        {"stage": stage, "state": state, "torque N m": torque}
        | {
            f"{gear} MPa": float(largest.sel(state=state, gear=gear).sel(torque=torque, method="nearest"))
            for gear in ("pinion", "wheel")
        }
        for state in found.state.values.tolist()
        for torque in sorted(set(torques))
    ]


def write_load_map(title: str, found: xarray.Dataset, path: Path) -> Path:
    """Write the data as netCDF, or a figure of them."""
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.report.figures.load_map_plots import load_map_figure

    if path.suffix.lower() != ".nc":
        save_figure(load_map_figure(title, found), path, dpi=115)
        return path
    with whole_file(path) as partial:
        partial.write_bytes(found.to_netcdf(engine="h5netcdf"))
    return path
