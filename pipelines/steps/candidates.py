"""Step `candidates`: what a gear pair with modified flanks does under load, for many modifications.

Modifications do not change the compliances, so each candidate is a few static contact problems with the same mesh law.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fem.contact.evaluation.mesh_cycle import ORDERS, MeshCycle, mesh_cycle, order_amplitudes
from fem.contact.faults.changed_law import modified_law
from fem.contact.law import MeshLaw
from fem.contact.teeth import LawError, checked_terms
from fem.gears.deviations import RandomDeviations
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications
from pipelines.machine.assembly import clearances
from pipelines.machine.parts import GearTeeth


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Loads and deviations under which candidates are compared.

    forces : (load,) N along the line of action, ascending
    positions : in a mesh cycle
    samples : seeds of the deviations; the nominal pair is evaluated as well
    grade : ISO 1328-1 tolerance class of the samples
    misalignment : half width (m over the face) of their uniform distribution of misalignments
    loaded : the quantities at the greatest force are computed, too
    """

    pair: GearPair
    forces: tuple[float, ...]
    positions: int = 32
    samples: tuple[int, ...] = ()
    grade: int = 5
    misalignment: float = 0.0
    loaded: tuple[str, ...] = ()

    def cycles(self, law: MeshLaw) -> Iterator[MeshCycle]:
        """The nominal pair, then each sample with the mean of the deviations of its teeth."""
        forces = np.array(self.forces)
        yield mesh_cycle(self.pair, law, forces, 0.0, self.positions)
        for seed in self.samples:
            tilt = self.misalignment * np.random.default_rng([seed, 6336]).uniform(-1.0, 1.0) / self.pair.face_width
            teeth = (
                np.broadcast_to(terms.mean(axis=0), terms.shape) for terms in sampled_teeth(self.pair, self.grade, seed)
            )
            yield mesh_cycle(self.pair, law, forces, tilt, self.positions, *teeth)


@dataclass(frozen=True, eq=False, kw_only=True)
class CandidateResults:
    """Arrays over (candidate, sample, ...), SI; sample 0 is the nominal pair. NaN: the candidate is not possible."""

    peak_to_peak: np.ndarray  # (candidate, sample, load), m
    orders: np.ndarray  # (candidate, sample, load, order), m
    loaded: dict[str, np.ndarray]  # (candidate, sample) by name, at the greatest force


def sampled_teeth(pair: GearPair, grade: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Terms (tooth, 6) of the teeth of pinion and wheel with random deviations of pitch, profile and helix."""
    gears = [
        GearTeeth(
            deviations=RandomDeviations(grade=grade, seed=1000 * seed + number, include=("pitch", "profile", "helix")),
            prescribed=None,
            clearances=(),
            damaged=(),
        )
        for number in range(2)
    ]
    found = clearances(pair, *gears)
    return tuple(  # type: ignore[return-value]
        checked_terms(name, getattr(pair, name).teeth, found[f"drive_clearance_{name}"]) for name in ("pinion", "wheel")
    )


def build(
    conditions: Conditions, candidates: Sequence[PairModifications], *, laws: tuple[MeshLaw, MeshLaw]
) -> CandidateResults:
    """Evaluate candidates.

    Parameters
    ----------
    conditions, candidates : loads and deviations, and the modifications of the pair
    laws : of the pair without modifications
    """
    shape = len(candidates), 1 + len(conditions.samples)
    ranges = np.full((*shape, len(conditions.forces)), np.nan)
    orders = np.full((*ranges.shape, ORDERS), np.nan)
    loaded = {name: np.full(shape, np.nan) for name in conditions.loaded}
    for number, modifications in enumerate(candidates):
        try:
            law = modified_law(laws[0], conditions.pair, modifications)
            for sample, cycle in enumerate(conditions.cycles(law)):
                ranges[number, sample] = np.ptp(cycle.error, axis=1)
                orders[number, sample] = order_amplitudes(cycle.error)
                for name, values in loaded.items():
                    values[number, sample] = getattr(cycle, name)()
        except (GeometryError, LawError):  # reliefs that overlap, or a force that is not reached
            ranges[number] = orders[number] = np.nan
    return CandidateResults(peak_to_peak=ranges, orders=orders, loaded=loaded)
