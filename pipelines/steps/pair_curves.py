"""Mesh stiffness of the gear pairs of a scene at their loads, healthy and with faults."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications
from pipelines.machine.flanks_spec import FlanksSpec
from pipelines.machine.scene_flanks import Fault, first_tooth_fault
from pipelines.machine.system_assembly import Laws
from pipelines.machine.tooth_terms import mesh_faults
from pipelines.steps.flanks import build_modified

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

    from fem.contact.evaluation.stiffness_curve import StiffnessCurve
    from fem.contact.law import MeshLaw
    from pipelines.machine.machine_model import MachineModel

PITCHES_SHOWN = 3.0  # on each side of a damaged tooth
POSITIONS = 241  # in this range
_COLUMNS = {
    "secant": ("N/m", "force over the approach since first touch"),
    "tangent": ("N/m", "slope of the force over the approach"),
    "transmission_error": ("m", "approach at the force"),
    "no_load_error": ("m", "approach at first touch"),
}


@dataclass(frozen=True, kw_only=True)
class Passage:
    """A damaged tooth in mesh; at the mesh cycle `cycle` it touches at the pitch point at mid face."""

    name: str  # "missing tooth 3 of the wheel"
    cycle: float


@dataclass(frozen=True, eq=False, kw_only=True)
class PairState:
    """A gear pair with its load and its faults, without deviations."""

    stage: int  # from 1
    pair: GearPair
    flanks: FlanksSpec  # added to the law of the pair without modifications; without damage of teeth
    sense: int  # +1 where the face coordinate of the laws runs along the global y, else -1
    force: float  # N, along the line of action, at the load of the scene
    pinion_faults: np.ndarray  # (tooth,) m or (tooth, 6), see `fem.contact.teeth`
    wheel_faults: np.ndarray
    faults: str  # "missing tooth", "" for a healthy pair
    passages: tuple[Passage, ...]  # of all damaged teeth, first the one that pictures show

    @property
    def cycle(self) -> float:
        """Mesh cycle at which the first damaged tooth is in mesh; 0 for a healthy pair."""
        return self.passages[0].cycle if self.passages else 0.0

    def with_laws(self, laws: Laws, unmodified_laws: Laws) -> PairLaws:
        """The pair with its mesh laws; `unmodified_laws` are those without modifications and faults."""
        healthy, _ = build_modified(self.flanks, unmodified=unmodified_laws)
        involute = PairModifications(misalignment=self.flanks.modifications.misalignment)
        unmodified, _ = build_modified(replace(self.flanks, modifications=involute), unmodified=unmodified_laws)
        return PairLaws(**vars(self), drive=laws[0], coast=laws[1], healthy=healthy, unmodified=unmodified)


@dataclass(frozen=True, eq=False, kw_only=True)
class PairLaws(PairState):
    """The mesh laws of a gear pair with its load and its faults, without deviations."""

    drive: MeshLaw
    coast: MeshLaw
    healthy: MeshLaw  # drive flank without faults
    unmodified: MeshLaw  # drive flank without faults and modifications, but with misalignment

    @property
    def modified(self) -> bool:
        """True if the flanks are modified."""
        given = self.flanks.modifications
        return given != PairModifications(misalignment=given.misalignment)

    def law(self, *, faulty: bool = False, modified: bool = True) -> MeshLaw:
        """Law of the drive flank in one state, see `stiffness`."""
        return self.drive if faulty else self.healthy if modified else self.unmodified

    def teeth(self, *, faulty: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Terms of the teeth of pinion and wheel, see `fem.contact.teeth`; zero without faults."""
        if faulty:
            return self.pinion_faults, self.wheel_faults
        return np.zeros(self.pair.pinion.teeth), np.zeros(self.pair.wheel.teeth)

    def stiffness(
        self,
        cycle: np.ndarray | None = None,
        *,
        faulty: bool = False,
        modified: bool = True,
        force: float | None = None,
        tilt: float | None = 0.0,
    ) -> StiffnessCurve:
        """The stiffness curves of the drive flank in one state.

        Parameters
        ----------
        cycle : float (n,), mesh cycles; by default 200 positions in one mesh cycle
        faulty : with the faults
        modified : with the modifications of the flanks; False also excludes the faults
        force : along the line of action, N; by default that of the scene
        tilt : of the gears in the plane of action along the face coordinate of the law, rad; None: force at mid face
        """
        from fem.contact.evaluation.stiffness_curve import stiffness_curve

        return stiffness_curve(
            self.law(faulty=faulty, modified=modified),
            self.force if force is None else force,
            cycle,
            psi=tilt,
            clearance_pinion=self.pinion_faults if faulty else None,
            clearance_wheel=self.wheel_faults if faulty else None,
        )

    def curve(self, cycle: np.ndarray | None = None, *, force: float | None = None) -> xarray.Dataset:
        """Stiffness over the mesh cycle k(c), healthy and, if the scene has faults, faulty.

        Parameters
        ----------
        cycle : float (n,), mesh cycles; by default three on each side of the first damaged tooth, or one without faults
        force : along the line of action, N; by default that of the scene

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
            name: (("state", "cycle"), np.array([getattr(curve, name) for curve in curves]), quantity(units, text))
            for name, (units, text) in _COLUMNS.items()
        }
        where = {"state": list(states), "cycle": ("cycle", np.asarray(cycle, float), quantity("1", "mesh cycle"))}
        told = {"stage": self.stage, "model": self.drive.model, "force_N": curves[0].force, "faults": self.faults}
        return xarray.Dataset(data, coords=where, attrs=told)

    def pattern(
        self,
        gear: str = "pinion",
        tooth: int = 0,
        *,
        faulty: bool = False,
        modified: bool = True,
        force: float | None = None,
        tilt: float | None = 0.0,
    ) -> xarray.DataArray:
        """The contact pattern: greatest Hertzian pressure on the flank of a tooth over its whole engagement.

        Parameters
        ----------
        gear, tooth : "pinion" or "wheel", and the number of the tooth
        faulty, modified, force, tilt : as in `stiffness`

        Returns
        -------
        pressure (diameter, face) in Pa, NaN without contact; `diameter` (m) on the gear from the root of the flank to
        its tip, `face` (m) from mid face along the face coordinate of the law
        """
        import xarray

        from fem.contact.evaluation.contact_pattern import contact_pattern

        found = contact_pattern(
            self.faults if faulty else "healthy",
            self.pair,
            self.law(faulty=faulty, modified=modified),
            gear,
            tooth,
            self.force if force is None else force,
            self.teeth(faulty=faulty),
            tilt=tilt,
        )
        where = {
            "diameter": ("diameter", found.diameter, quantity("m", f"diameter on the {gear}")),
            "face": ("face", found.face, quantity("m", "face coordinate from mid face")),
        }
        words = quantity("Pa", "Hertz pressure")
        return xarray.DataArray(found.pressure, where, ("diameter", "face"), "pressure", words)

    def __repr__(self) -> str:
        return f"<PairLaws: {self._words()}, {self.faults or 'healthy'}>"

    def _words(self) -> str:
        teeth = f"{self.pair.pinion.teeth}/{self.pair.wheel.teeth} teeth"
        return f"stage {self.stage}, {teeth}, model {self.drive.model}, {self.force:.5g} N"

    def _repr_html_(self) -> str:
        """Table of the curves and plot of the secant stiffness, for a notebook."""
        from fem.storage import shown_html

        found = self.curve()
        states = [str(state) for state in found.state.values]
        rows = [
            (name.replace("_", " "), state, units, float(values.min()), float(values.mean()), float(values.max()))
            for name, (units, _) in _COLUMNS.items()
            for state, values in zip(states, found[name].values, strict=True)
        ]
        secant = dict(zip(states, found.secant.values, strict=True))
        page = shown_html.table(self._words(), ("curve", "state", "unit", "least", "mean", "greatest"), rows)
        return page + shown_html.curves("mesh cycle", found.cycle.values, "secant stiffness, N/m", secant)


def acting(found: PairLaws) -> float:
    """Mesh cycle at which the faults change the transmission error most; 0 without faults."""
    if not found.faults:
        return 0.0
    error = found.curve().transmission_error
    moved = np.abs(error.sel(state="faulty").values - error.sel(state="healthy").values)
    return float(error.cycle.values[int(moved.argmax())])


def law_names(machine: MachineModel) -> tuple[str, ...]:
    """Names of the steps whose results `pair_laws` needs."""
    return tuple(dict.fromkeys([*machine.law_names, *machine.healthy_law_names]))


def pair_states(machine: MachineModel) -> tuple[PairState, ...]:
    """The pairs of a machine by stage, without mesh laws."""
    found = []
    for number, (mesh, facts) in enumerate(zip(machine.parts.meshes, machine.facts.stages, strict=True), 1):
        faults = machine.faults_of(number)
        pinion, wheel = mesh_faults(mesh)
        found.append(
            PairState(
                stage=number,
                pair=mesh.pair,
                flanks=machine.flanks[number - 1].healthy,
                sense=machine.layout.pinion_senses[number - 1],
                force=facts.shown_force,
                pinion_faults=pinion,
                wheel_faults=wheel,
                faults=", ".join(dict.fromkeys(fault.kind.replace("-", " ") for fault in faults)),
                passages=passages(faults, number),
            )
        )
    return tuple(found)


def pair_laws(machine: MachineModel, law: Callable[[str], Laws]) -> tuple[PairLaws, ...]:
    """The pairs of a machine by stage; `law` returns the laws of both flanks for each of the `law_names`."""
    names = zip(pair_states(machine), machine.law_names, machine.healthy_law_names, strict=True)
    return tuple(state.with_laws(law(name), law(unmodified)) for state, name, unmodified in names)


def passages(faults: tuple[Fault, ...], stage: int) -> tuple[Passage, ...]:
    """Passages of the damaged teeth of a stage (from 1) with all their faults; tooth 0 stands for all teeth."""
    first = first_tooth_fault(faults, stage)
    ordered = sorted(faults, key=lambda fault: fault != first)
    teeth: dict[tuple[str, int | None], list[str]] = {}
    for fault in ordered:
        teeth.setdefault((fault.gear, fault.tooth), []).append(fault.kind.replace("-", " "))
    return tuple(
        Passage(
            name=f"{' and '.join(kinds)} {f'of the {gear}, all teeth' if tooth is None else f'{tooth} of the {gear}'}",
            cycle=float(tooth or 0),
        )
        for (gear, tooth), kinds in teeth.items()
    )


def engagement(pair: GearPair) -> tuple[float, float]:
    """First and last mesh cycle of the whole pitches in which a tooth pair is in mesh, relative to its contact at the
    pitch point at mid face."""
    middle, half = (pair.xi_start + pair.xi_end) / 2, math.ceil(pair.total_contact_ratio) / 2
    return middle - half, middle + half


def quantity(units: str, text: str) -> dict[str, str]:
    return {"units": units, "long_name": text}
