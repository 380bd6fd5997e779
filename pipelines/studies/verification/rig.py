"""The eight cases of the rig, simulated for several seeds of the deviations, and their measures.

The cases are with and without the missing tooth, with the container on its rope and as a constant torque, and with and
without friction. One simulation contains lifting and lowering. The cases are the shipped scenes with another seed and
friction, and only sensor 3 is recorded.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray

from pipelines.diagnosis.control_diagnosis import STATES
from pipelines.engine.run_graph import Work
from pipelines.scene.load_scene import LoadedScene, load_scene
from pipelines.scene.presets import preset_on
from pipelines.signals.analysis import DiagnosisSettings
from pipelines.signals.features.feature_table import labelled_array
from pipelines.signals.response import make_response
from pipelines.studies.trade.measured_variants import build_variants
from pipelines.studies.verification.measures import Levels, fault_levels, load_levels
from pipelines.studies.verification.published_claims import ClaimEvidence

LOADS = ("rope", "static-torque")
LOSSES: Mapping[str, Mapping[str, Any]] = {
    "none": {"losses.model": "none"},
    "friction": {"losses.model": "coulomb", "losses.tooth_friction": 0.05, "losses.bearing_friction": 0.0015},
}
SCENES = {
    ("faulty", "rope"): "rig-missing-tooth",
    ("faulty", "static-torque"): "rig-missing-tooth-torque",
    ("healthy", "rope"): "rig-healthy",
    ("healthy", "static-torque"): "rig-healthy-torque",
}
SENSOR = {"name": "sensor_3", "position_mm": [76.7, -150.0, 35.5]}  # as in the scenes; others would cost time alone
STRETCHES = {  # s; the ramps last from 0.2 to 0.3 s and from 2.6 to 2.9 s
    "steady": ((0.5, 2.5), (3.0, 5.0)),
    "start": ((0.2, 0.5),),
    "reversal": ((2.6, 3.0),),
}


@dataclass(frozen=True, kw_only=True)
class RigCase:
    """One simulation."""

    losses: str
    load: str
    seed: int
    state: str

    @property
    def name(self) -> str:
        """For progress."""
        return f"{self.state}, {self.load}, losses {self.losses}, seed {self.seed}"


def cases(seeds: int) -> Iterator[RigCase]:
    """Eight cases for each of the seeds 1, 2, ..."""
    for seed, losses, load, state in itertools.product(range(1, seeds + 1), LOSSES, LOADS, STATES):
        yield RigCase(losses=losses, load=load, seed=seed, state=state)


def scene_of(case: RigCase, preset: str) -> LoadedScene:
    """The shipped scene of a case with its seed and friction, and the settings of the preset."""
    own = {"deviations.seed": case.seed, "sensors": [SENSOR], **LOSSES[case.losses]}
    return preset_on(load_scene(SCENES[case.state, case.load], own), preset)


def simulated(seeds: int, preset: str, work: Work) -> ClaimEvidence:
    """Simulate all cases, or take them from the cache, and read the measures.

    Parameters
    ----------
    seeds : number of seeds of the deviations, two or more for a standard error
    preset : see `pipelines.scene.presets`
    work : how steps are computed

    Raises
    ------
    SceneError, WorkError : a scene does not fit, or a step failed; finished ones stay in the cache
    """
    scenes = {case.name: scene_of(case, preset) for case in cases(seeds)}
    built = build_variants(scenes, lambda _: ["simulate"], work, ("step", "energy"))
    machines = {case: built[case.name][0] for case in cases(seeds)}
    settings_by_load = {  # by load
        case.load: machine.diagnosis
        for case, machine in machines.items()
        if machine.diagnosis is not None and case.state == "faulty"
    }

    def run(case: RigCase) -> xarray.Dataset:
        return make_response(built[case.name][1].value("simulate"), machines[case].labels)

    levels: dict[tuple[str, ...], Levels] = {}
    loads: dict[tuple[str, ...], Levels] = {}
    for seed, losses in itertools.product(range(1, seeds + 1), LOSSES):
        runs = {
            (state, load): run(RigCase(losses=losses, load=load, seed=seed, state=state))
            for state in STATES
            for load in LOADS
        }
        for load, settings in settings_by_load.items():
            pair = fault_levels(runs["faulty", load], runs["healthy", load], settings)
            levels |= {(losses, load, str(seed), *where): found for where, found in pair.items()}
        for stretch, found in _load_levels(runs, settings_by_load["rope"]).items():
            loads[losses, str(seed), stretch] = found
    return ClaimEvidence(
        levels=_table(levels, ("losses", "load", "seed", "state", "window", "measure")),
        loads=_table(loads, ("losses", "seed", "stretch", "measure")),
    )


def _load_levels(runs: Mapping[tuple[str, str], xarray.Dataset], settings: DiagnosisSettings) -> dict[str, Levels]:
    """Measures by interval of time, averaged over the windows of an interval."""
    rope, torque = runs["faulty", "rope"], runs["faulty", "static-torque"]
    out = {}
    for stretch, windows in STRETCHES.items():
        found = [load_levels(rope, torque, settings.sensor, settings.axis, times) for times in windows]
        out[stretch] = {name: float(np.mean([one[name] for one in found])) for name in found[0]}
    return out


def _table(found: Mapping[tuple[str, ...], Levels], dims: tuple[str, ...]) -> xarray.DataArray:
    """An array with named axes from values by their labels."""
    flat = {(*place, measure): value for place, levels in found.items() for measure, value in levels.items()}
    return labelled_array(flat, dims).assign_attrs(units="dB")
