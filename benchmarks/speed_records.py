"""Simulated records of the shipped machines for the judgement of speeds found in vibration: made once, kept in a folder.

A record is a healthy or a damaged bench, reducer or hoist rig with plane mesh laws, at a speed that drifts by 0.2 %,
with random pitch deviations, load and sensor noise. Records of calibration have random speeds and loads; those that
are judged lie near the operating points, where there are healthy baselines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray

import gearcase
from pipelines.scene.merge import Whole

START = 0.5  # s; the run-up is over


class Bed(NamedTuple):
    """A machine: scene, length s, rate Hz, step us, (rpm, load) of its operating points, key of the load, changes."""

    scene: str
    seconds: float
    rate: float
    step: float
    points: tuple[tuple[float, float], ...]
    load: str
    changes: dict[str, Any]


_PLANE = Whole({"model": "plane"})
BEDS = {
    "bench": Bed(
        "bench", 3.0, 12800.0, 39.0, ((1500.0, 100.0), (1100.0, 60.0), (1750.0, 130.0)), "load.torque_N_m", {"faults": []}
    ),
    "reducer": Bed("reducer", 5.0, 12800.0, 39.0, ((1400.0, 1.0), (1000.0, 1.0)), "", {}),
    "rig": Bed(
        "rig-healthy-torque", 6.5, 5000.0, 100.0, ((900.0, 1000.0),), "load.container_kg",
        {f"stages.{stage}.mesh": _PLANE for stage in (1, 2, 3)},
    ),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Specimen:
    """A record to make: machine, speed in rpm, load, sensor noise in m/s2, seed of everything random, fault."""

    name: str
    bed: str
    rpm: float
    load: float
    noise: float
    seed: int
    fault: dict[str, Any] | None = None


def specimens(part: str, first: int, healthy: dict[str, int], faulty: dict[str, int]) -> Iterator[Specimen]:
    """Healthy and damaged machines of a part: `calibration`, `judged` or `baseline` (so many at every point)."""
    seed = first
    for damaged, counts in ((False, healthy), (True, faulty)):
        for bed, count in counts.items():
            points = BEDS[bed].points
            for number in range(count * (len(points) if part == "baseline" else 1)):
                seed += 1
                random = np.random.default_rng(seed)
                rpm, load = points[number % len(points)]
                wide = part == "calibration"
                rpm *= random.uniform(0.6, 1.2) if wide else random.uniform(0.997, 1.003)
                load *= random.uniform(0.3, 1.2) if wide else random.uniform(0.98, 1.02)
                noise = 0.01 if part == "baseline" else float(random.choice([0.01, 0.03, 0.1]))
                fault = _fault(random, bed) if damaged else None
                name = f"{part}-{bed}-{'faulty' if damaged else 'healthy'}-{number}"
                yield Specimen(name=name, bed=bed, rpm=rpm, load=load, noise=noise, seed=seed, fault=fault)


def _fault(random: np.random.Generator, bed: str) -> dict[str, Any]:
    stage = int(random.integers(1, {"bench": 1, "reducer": 2, "rig": 3}[bed] + 1))
    place = {"stage": stage, "gear": str(random.choice(["pinion", "wheel"])), "tooth": int(random.integers(20))}
    if random.uniform() < 0.5:
        return place | {"kind": "missing-tooth"}
    return place | {"kind": "chipped-tooth", "extent_mm": 8.0, "depth_mm": 2.5}


def record(specimen: Specimen, folder: Path) -> xarray.Dataset:
    """The record of a specimen with `acceleration` (time, sensor, axis) and `shaft_angle`; from the folder if there."""
    path = folder / f"{specimen.name}.nc"
    if not path.exists():
        made = _simulated(specimen)
        made.to_netcdf(path.with_suffix(".part"), engine="h5netcdf")
        path.with_suffix(".part").rename(path)
    return xarray.load_dataset(path, engine="h5netcdf")


def _simulated(specimen: Specimen) -> xarray.Dataset:
    bed = BEDS[specimen.bed]
    random = np.random.default_rng([specimen.seed, 1])
    times = np.linspace(0.2, bed.seconds, 12)
    drift = np.cumsum(random.standard_normal(12))
    drift = 1.0 + 0.002 * (drift - drift.mean()) / np.abs(drift - drift.mean()).max()
    settings: dict[str, Any] = bed.changes | {
        "control": "none", "deviations.seed": specimen.seed,
        "simulation.end_s": bed.seconds, "simulation.output_rate_Hz": bed.rate, "simulation.step_us": bed.step,
        "diagnosis.windows_s": Whole({}),
        "drive.times_s": [0.0, *times.tolist()], "drive.speeds_rpm": [0.0, *(specimen.rpm * drift).tolist()],
    }  # fmt: skip
    if bed.load:
        settings[bed.load] = specimen.load
    if specimen.fault:
        settings["faults"] = [specimen.fault]
    run = gearcase.simulate(gearcase.Scene.from_file(bed.scene).changed(settings)).sel(time=slice(START, None))
    noisy = run.acceleration + specimen.noise * random.standard_normal(run.acceleration.shape)
    return xarray.Dataset({"acceleration": noisy.astype(np.float32), "shaft_angle": run.shaft_angle}, attrs={})


PARTS = {
    "calibration": (1000, {"bench": 36, "reducer": 26, "rig": 18}, {"bench": 18, "reducer": 12, "rig": 10}),
    "judged": (5000, {"bench": 42, "reducer": 30, "rig": 20}, {"bench": 16, "reducer": 14, "rig": 10}),
    "baseline": (9000, dict.fromkeys(BEDS, 8), {}),
}
