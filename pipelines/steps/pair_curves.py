"""Mesh stiffness of the gear pairs of a scene at their loads, healthy and with their faults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipelines.plant.assembly import mesh_faults

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray

    from fem.contact.evaluation.curves import StiffnessCurve
    from fem.contact.law import MeshLaw
    from fem.gears.geometry import GearPair
    from pipelines.plant.plant import Plant

PITCHES_SHOWN = 3.0  # to each side of a damaged tooth
POSITIONS = 241  # over these pitches
_COLUMNS = {
    "secant": ("N/m", "force over the approach since first touch"),
    "tangent": ("N/m", "slope of the force over the approach"),
    "transmission_error": ("m", "approach at the force"),
    "no_load_error": ("m", "approach at first touch"),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class PairLaws:
    """The mesh laws of a gear pair with its load and its faults; deviations are left out."""

    stage: int  # from 1
    pair: GearPair
    drive: MeshLaw
    coast: MeshLaw
    force: float  # N, on the line of action, at the load of the scene
    pinion_faults: np.ndarray  # (tooth,) m or (tooth, 6), see `fem.contact.teeth`
    wheel_faults: np.ndarray
    faults: str  # "missing tooth", "" for a healthy pair
    cycle: float  # mesh cycle at which the first damaged tooth meshes

    def stiffness(
        self, cycle: np.ndarray | None = None, *, faulty: bool = False, force: float | None = None
    ) -> StiffnessCurve:
        """The curves of the drive flank in one state, over 200 positions of one mesh cycle by default."""
        from fem.contact.evaluation.curves import stiffness_curve

        return stiffness_curve(
            self.drive,
            self.force if force is None else force,
            cycle,
            clearance_pinion=self.pinion_faults if faulty else None,
            clearance_wheel=self.wheel_faults if faulty else None,
        )

    def curve(self, cycle: np.ndarray | None = None, *, force: float | None = None) -> xarray.Dataset:
        """Stiffness over the mesh cycle k(c), healthy and, where the scene has faults, faulty.

        Parameters
        ----------
        cycle : float (n,), mesh cycles; three to each side of the first damaged tooth by default, one without faults
        force : N, on the line of action; that of the scene by default

        Returns
        -------
        secant, tangent (N/m), transmission_error, no_load_error (m), all (state, cycle)
        """
        import xarray

        if cycle is None:
            shown = np.linspace(-PITCHES_SHOWN, PITCHES_SHOWN, POSITIONS)
            cycle = self.cycle + shown if self.faults else np.linspace(0.0, 1.0, 200, endpoint=False)
        states = {"healthy": False, "faulty": True} if self.faults else {"healthy": False}
        curves = [self.stiffness(cycle, faulty=faulty, force=force) for faulty in states.values()]
        data = {
            name: (("state", "cycle"), np.array([getattr(curve, name) for curve in curves]), _words(units, text))
            for name, (units, text) in _COLUMNS.items()
        }
        where = {"state": list(states), "cycle": ("cycle", np.asarray(cycle, float), _words("1", "mesh cycle"))}
        told = {"stage": self.stage, "model": self.drive.model, "force_N": curves[0].force, "faults": self.faults}
        return xarray.Dataset(data, coords=where, attrs=told)


def pair_laws(plant: Plant, laws: Sequence[tuple[MeshLaw, MeshLaw]]) -> tuple[PairLaws, ...]:
    """The pairs of a plant by stage; `laws` of drive and coast flank."""
    found = []
    for number, (flanks, mesh, facts) in enumerate(zip(laws, plant.machine.meshes, plant.facts.stages, strict=True), 1):
        faults = plant.faults_of(number)
        single = [fault.tooth for fault in faults if fault.tooth is not None]
        pinion, wheel = mesh_faults(mesh)
        found.append(
            PairLaws(
                stage=number,
                pair=mesh.pair,
                drive=flanks[0],
                coast=flanks[1],
                force=facts.shown_force,
                pinion_faults=pinion,
                wheel_faults=wheel,
                faults=", ".join(dict.fromkeys(fault.kind.replace("-", " ") for fault in faults)),
                cycle=float(single[0]) if single else 0.0,
            )
        )
    return tuple(found)


def _words(units: str, text: str) -> dict[str, str]:
    return {"units": units, "long_name": text}
