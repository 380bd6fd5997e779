"""What `gearcase design` costs and finds: `python -m benchmarks.design [PART ...]`.

speed: processor seconds of 2,000 candidates at 12 torques, model `solid` with 15 slices, 32 positions in the mesh cycle
front: hypervolume of the fronts that are searched, divided by that of exhaustive grids with two and three variables
robust: 90 % quantiles of peak-to-peak transmission error over pairs whose seeds the search has not seen
sensors: rms of the acceleration of the bench without its fault, simulated with the designs that `robust` found, and
    with the one of the least 90 % quantile of `level` in the same search
slices: transmission error of the front with 15 and with 61 slices of the face
helical: tip relief of a helical pair 23/81, for which a published study found 31 % less transmission error
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from fem.gears.modifications import PairModifications
from pipelines.engine.run_graph import Work
from pipelines.runs.single_results import build_pairs
from pipelines.scene.load_scene import LoadedScene, changed, load_scene
from pipelines.steps import flank_candidates
from pipelines.studies.design.design_study import DesignOptions, DesignStudy, design_study

TORQUES = tuple(float(torque) for torque in range(5, 65, 5))
SOLID = {"stages.1.mesh.model": "solid", "stages.1.mesh.slices": 15}
GRIDS = {
    400: ("both.tip_relief.amount_um=0:40", "both.tip_relief.length_mm=1:4"),
    1300: ("both.tip_relief.amount_um=0:30", "both.tip_relief.length_mm=1:4:0.2", "both.lead_crowning_um=0:12"),
}
ROBUST = ("both.tip_relief.amount_um=0:30:2", "both.tip_relief.length_mm=1:4:0.5", "both.lead_crowning_um=0:12:2")
FRESH = range(1001, 1201)  # seeds
MACHINES = range(2101, 2141)  # seeds
GRADE, MISALIGNMENT = 6, 10e-6  # ISO 1328-1; m over the face width
HELICAL: dict[str, Any] = {  # 23/81 teeth, 50 N m, helical: published; all else is assumed
    "stages.1.pinion_teeth": 23, "stages.1.wheel_teeth": 81, "stages.1.module_mm": 1.5,
    "stages.1.helix_angle_deg": 15.0, "stages.1.face_width_mm": 15.0,
}  # fmt: skip


def study(scene: str, settings: Mapping[str, Any], **options: Any) -> DesignStudy:
    """A search without output."""
    return design_study(changed(load_scene(scene), settings), DesignOptions(**options), Work())


def speed() -> None:
    """Processor seconds with the mesh law in the cache."""
    build_pairs(changed(load_scene("bench"), SOLID), Work())
    vary = ("both.tip_relief.amount_um=1:40", "both.tip_relief.length_mm=1:3.7:0.3", "both.lead_crowning_um=0:8:2")
    start = time.process_time()
    count = len(study("bench", SOLID, vary=vary, torques=TORQUES).designs.index)
    print(f"{count} candidates, {len(TORQUES)} torques: {time.process_time() - start:.1f} s")


def front() -> None:
    """Reference point: 10 % of the range beyond the worst values of the exhaustive front."""
    from pymoo.indicators.hv import HV

    for most, vary in GRIDS.items():
        options: dict[str, Any] = {"vary": vary, "minimize": ("te", "pressure")}
        grid = study("bench", {}, **options, evaluations=10_000).designs
        best = grid.objectives[grid.front]
        least, span = best.min(axis=0), np.ptp(best, axis=0)
        volume = HV(ref_point=np.full(2, 1.1))
        for seed in (1, 2, 3):
            found = study("bench", {}, **options, evaluations=most, seed=seed).designs
            share = volume((found.objectives[found.front] - least) / span) / volume((best - least) / span)
            print(f"{len(vary)} variables, seed {seed}: {share:.6f} with {len(found.index)} of {len(grid.index)}")


def robust(scene: str = "bench", settings: Mapping[str, Any] = {}, torques: tuple[float, ...] = ()) -> None:
    """The claim: the quantile of the robust design is lower than those of the nominal optimum and the unmodified pair.

    It holds if the 95 % bootstrap interval of both differences, over the same pairs, is below 0.
    """
    settings = {**settings, "deviations.iso_grade": GRADE}
    options: dict[str, Any] = {"vary": ROBUST, "torques": torques}
    deviating = {"samples": 20, "misalignment": MISALIGNMENT}
    studies = [study(scene, settings, **options, **further) for further in ({}, deviating)]
    best = [one.designs.task.variables.modifications(one.designs.values(one.designs.front[0])) for one in studies]
    conditions = replace(studies[1].designs.task.conditions, samples=tuple(FRESH), positions=128)
    pair = build_pairs(changed(load_scene(scene), settings), Work())[0]
    found = flank_candidates.build(conditions, [PairModifications(), *best], laws=(pair.unmodified, pair.unmodified))
    error = 1e6 * found.peak_to_peak.mean(axis=2)
    names = ("unmodified", "nominal", "robust")
    values = [[], *(one.designs.values(one.designs.front[0]) for one in studies)]
    for name, own, chosen in zip(names, error, values, strict=True):
        mean, quantile = own[1:].mean(), np.quantile(own[1:], 0.9)
        print(f"{scene}, {name} {chosen}: without deviations {own[0]:.3f}, mean {mean:.3f}, q90 {quantile:.3f} um")
    again = np.random.default_rng(1).integers(0, len(FRESH), (10_000, len(FRESH)))
    quantiles = np.quantile(error[:, 1:][:, again], 0.9, axis=2)
    for name, other in zip(names[:2], quantiles[:2], strict=True):
        low, high = np.quantile(quantiles[2] - other, (0.025, 0.975))
        print(f"{scene}, q90 of robust less that of {name}: {low:+.3f} to {high:+.3f} um")


def sensors() -> None:
    """Paired levels, with their 95 % bootstrap intervals, over machines with other deviations and misalignments."""
    import gearcase

    given = {"deviations.iso_grade": GRADE, "deviations.include": ["pitch", "profile", "helix"]}
    bench = gearcase.Scene.from_file("bench").changed({**given, "faults": [], "simulation.end_s": 1.2})
    values = {"unmodified": (0, 1.0, 0), "nominal": (8, 2.5, 0), "robust": (4, 3.5, 4), "robust level": (4, 4.0, 4)}
    found: dict[str, list[np.ndarray]] = {name: [] for name in values}
    for seed in MACHINES:
        skew = 1e6 * MISALIGNMENT * np.random.default_rng([seed, 6336]).uniform(-1.0, 1.0)
        for name, (amount, length, crowning) in values.items():
            change: dict[str, Any] = {"deviations.seed": seed, "stages.1.misalignment.out_of_plane_um": skew}
            for gear in ("pinion", "wheel"):
                change[f"stages.1.{gear}.tip_relief"] = {"amount_um": amount, "length_mm": length}
                change[f"stages.1.{gear}.lead_crowning_um"] = crowning
            signal = gearcase.simulate(bench.changed(change)).acceleration.sel(time=slice(0.6, None))
            rest = [axis for axis in signal.dims if axis != "sensor"]
            found[name].append(np.sqrt((signal**2).mean(rest)).values)
    levels = {name: 20 * np.log10(np.array(rms)) for name, rms in found.items()}
    again = np.random.default_rng(1).integers(0, len(MACHINES), (10_000, len(MACHINES)))
    for name in list(values)[1:]:
        change_dB = levels[name] - levels["unmodified"]
        low, high = np.quantile(change_dB[again].mean(axis=1), (0.025, 0.975), axis=0)
        for number, mean in enumerate(change_dB.mean(axis=0)):
            print(f"{name}, sensor {number + 1}: {mean:+.2f} dB ({low[number]:+.2f} to {high[number]:+.2f})")


def slices() -> None:
    """The designs of a front, with the values of a search, on finer slices."""
    options: dict[str, Any] = {"vary": ROBUST, "minimize": ("te", "pressure")}
    coarse = study("bench", SOLID, **options)
    scene: LoadedScene = changed(load_scene("bench"), SOLID | {"stages.1.mesh.slices": 61})
    law = build_pairs(scene, Work())[0].unmodified
    task = coarse.designs.task
    given = [PairModifications() if at is None else task.variables.modifications(coarse.designs.values(at))
             for at in coarse.candidates]  # fmt: skip
    conditions = replace(task.conditions, positions=256, loaded=("pressure",))
    fine = flank_candidates.build(conditions, given, laws=(law, law))
    errors, pressures = 1e6 * fine.peak_to_peak[:, 0].mean(axis=1), fine.loaded["pressure"][:, 0] / 1e6
    for row, error, pressure in zip(coarse.rows(), errors, pressures, strict=True):
        words = f"te {row['te um']:.4f} and {error:.4f} um, pressure {row['pressure MPa']:.0f} and {pressure:.0f} MPa"
        print(f"{row['design']}: {words}")


def helical() -> None:
    """RMS about the mean and first order, without and with the published relief (0.10 mm), and with the own optimum."""
    pair = build_pairs(changed(load_scene("pair"), HELICAL), Work())[0]
    long = (pair.pair.transverse_contact_ratio - 1.0) * 1e3 * pair.pair.base_pitch
    print(f"contact ratios {pair.pair.transverse_contact_ratio:.3f} and {pair.pair.overlap_ratio:.3f}")
    own = study("pair", HELICAL, torques=(50.0,))
    conditions = replace(own.designs.task.conditions, positions=256, loaded=("pressure",))
    variables, chosen = own.designs.task.variables, own.designs.values(own.designs.front[0])
    cases: dict[str, Any] = {"unmodified": [0, 1.0], "optimum": chosen}
    cases |= {f"100 um over {long / part:.2f} mm": [100, long / part] for part in (8, 4, 2, 1)}
    given = [variables.modifications(values) for values in cases.values()]
    found = flank_candidates.build(conditions, given, laws=(pair.unmodified, pair.unmodified))
    levels, pressures = 1e6 * found.error[:, 0].std(axis=1), found.loaded["pressure"][:, 0] / 1e9
    first = 20 * np.log10(found.orders[:, 0, 0, 0] / found.orders[0, 0, 0, 0])
    for name, error, level, order, pressure in zip(cases, found.error[:, 0], levels, first, pressures, strict=True):
        words = f"mean {1e6 * error.mean():.2f} um, RMS {level:.4f} um ({100 * (level / levels[0] - 1):+.0f} %)"
        print(f"{name}: {words}, order 1 {order:+.1f} dB, pressure {pressure:.2f} GPa")
    print(f"optimum: {chosen}")
    robust("pair", HELICAL, (50.0,))


if __name__ == "__main__":
    for name in sys.argv[1:] or ("speed", "front", "robust", "sensors", "slices", "helical"):
        globals()[name]()
