"""Step `candidates`: what a gear pair with modified flanks does under load, for many modifications.

Modifications do not change the compliances, so each candidate is a few static contact problems with the same mesh law.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fem.contact.evaluation.evaluator import LawEvaluator, Teeth
from fem.contact.evaluation.mesh_cycle import ORDERS, MeshCycle, mesh_cycle, order_amplitudes
from fem.contact.faults.changed_law import modified_law
from fem.contact.law import MeshLaw
from fem.contact.models.solid_stress import RootStress
from fem.contact.teeth import LawError, tooth_terms
from fem.gears.flank_deviations import sample_flank_deviations
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications

if TYPE_CHECKING:
    from pipelines.steps.mesh_response import SensorResponse

LOADED: Mapping[str, Callable[[MeshCycle, Sequence[RootStress]], float]] = {  # at the greatest force
    "pressure": lambda cycle, _: cycle.pressure().max(),
    "load-factor": lambda cycle, _: cycle.face_load_factor(),
    "root-stress": lambda cycle, roots: max(
        one.of(cycle.evaluator.law, cycle.cycle, *cycle.line_loads()).max() for one in roots
    ),
}


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Loads and deviations under which candidates are compared.

    forces : (load,) N along the line of action, ascending
    positions : in a mesh cycle
    samples : seeds of the deviations; the nominal pair is evaluated as well
    grade : ISO 1328-1 tolerance class of the samples; None: misalignment only
    misalignment : half width (m over the face) of their uniform distribution of misalignments
    loaded : names in `LOADED` that are computed, too
    """

    pair: GearPair
    forces: tuple[float, ...]
    positions: int = 32
    samples: tuple[int, ...] = ()
    grade: int | None = 5
    misalignment: float = 0.0
    loaded: tuple[str, ...] = ()

    def states(self) -> Iterator[tuple[float, tuple[Teeth, Teeth]]]:
        """Tilt (rad) and teeth of the nominal pair, then those of each sample."""
        yield 0.0, (None, None)
        for seed in self.samples:
            tilt = self.misalignment * np.random.default_rng([seed, 6336]).uniform(-1.0, 1.0) / self.pair.face_width
            yield tilt, (None, None) if self.grade is None else _mean_teeth(self.pair, self.grade, seed)


@dataclass(frozen=True, eq=False, kw_only=True)
class CandidateResults:
    """Arrays over (candidate, sample, ...), SI; sample 0 is the nominal pair. NaN: the candidate is not possible."""

    error: np.ndarray  # (candidate, load, position), m, of the nominal pair
    peak_to_peak: np.ndarray  # (candidate, sample, load), m
    orders: np.ndarray  # (candidate, sample, load, order), m
    loaded: dict[str, np.ndarray]  # (candidate, sample) by name, at the greatest force
    levels: np.ndarray  # (candidate, sample, load, sensor), m/s2 rms
    sensors: tuple[str, ...]

    @classmethod
    def joined(cls, parts: Sequence[CandidateResults], order: np.ndarray) -> CandidateResults:
        """The candidates of several results, in another order."""

        def each(arrays: Iterable[np.ndarray]) -> np.ndarray:
            return np.concatenate(list(arrays))[order]

        return cls(
            error=each(one.error for one in parts),
            peak_to_peak=each(one.peak_to_peak for one in parts),
            orders=each(one.orders for one in parts),
            loaded={name: each(one.loaded[name] for one in parts) for name in parts[0].loaded},
            levels=each(one.levels for one in parts),
            sensors=parts[0].sensors,
        )


def _mean_teeth(pair: GearPair, grade: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Terms (tooth, 6) of pinion and wheel: the mean of the profile and helix deviations on all teeth.

    Pitch deviations have a mean of zero.
    """
    found = []
    for number, name in enumerate(("pinion", "wheel")):
        drive = sample_flank_deviations(pair, name, grade, 1000 * seed + number, profile=True, helix=True)["drive"]
        terms = tooth_terms(getattr(pair, name).teeth, **drive)
        found.append(np.broadcast_to(terms.mean(axis=0), terms.shape))
    return found[0], found[1]


def build(
    conditions: Conditions,
    candidates: Sequence[PairModifications],
    *,
    laws: tuple[MeshLaw, MeshLaw],
    roots: Sequence[RootStress] = (),
    response: SensorResponse | None = None,
) -> CandidateResults:
    """Evaluate candidates.

    Parameters
    ----------
    conditions, candidates : loads and deviations, and the modifications of the pair
    laws, roots : of the pair without modifications; the stresses of its fillets by unit forces, for root stress
    response : of the sensors to the mesh, for their levels; None: no sensors
    """
    shape = len(candidates), 1 + len(conditions.samples)
    error = np.full((len(candidates), len(conditions.forces), conditions.positions), np.nan)
    ranges = np.full((*shape, len(conditions.forces)), np.nan)
    orders = np.full((*ranges.shape, ORDERS), np.nan)
    loaded = {name: np.full(shape, np.nan) for name in conditions.loaded}
    sensors = () if response is None else response.sensors
    levels = np.full((*ranges.shape, len(sensors)), np.nan)
    pair, forces, states = conditions.pair, np.array(conditions.forces), list(conditions.states())
    for number, modifications in enumerate(candidates):
        try:
            evaluator = LawEvaluator(modified_law(laws[0], pair, modifications))
            for sample, (tilt, teeth) in enumerate(states):
                cycle = mesh_cycle(pair, evaluator, forces, tilt, conditions.positions, teeth)
                if not sample:
                    error[number] = cycle.error
                ranges[number, sample] = np.ptp(cycle.error, axis=1)
                orders[number, sample] = order_amplitudes(cycle.error)
                for name, values in loaded.items():
                    values[number, sample] = LOADED[name](cycle, roots)
                if response is not None:
                    levels[number, sample] = [response.levels(cycle, force) for force in forces]
        except (GeometryError, LawError):  # reliefs that overlap, or a force that is not reached
            ranges[number] = orders[number] = np.nan
    return CandidateResults(
        error=error, peak_to_peak=ranges, orders=orders, loaded=loaded, levels=levels, sensors=sensors
    )
