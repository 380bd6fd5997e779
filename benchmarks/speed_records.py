"""Speeds found in the vibration of simulated records, judged: right, conditional, refused or wrong.

python -m benchmarks.speed_records FOLDER [PART] makes the records of a part (`judged`, `calibration`) that are not yet
in the folder, which takes an hour, and prints a table. A speed is the slope of the found angle over the true one. It is
right within 1e-4, and wrong if that of any shaft without a condition is not.

A record is a healthy or a damaged bench, reducer or hoist rig with plane mesh laws, at a speed that drifts by 0.2 %,
with random pitch deviations, load and sensor noise. Records of calibration have random speeds and loads; those that
are judged lie near the operating points, where there are healthy baselines.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray

import gearcase
from pipelines.scene.merge import Whole
from pipelines.signals.orders.kinematics import Gear, Kinematics, Shaft
from pipelines.signals.orders.rotation import RotationError
from pipelines.signals.orders.rotation_of import rotation_of

START = 0.5  # s; the run-up is over
RIGHT = 1e-4  # of a speed
Teeth = tuple[tuple[int, int], ...]
TEETH: dict[str, Teeth] = {
    "bench": ((25, 62),),
    "reducer": ((23, 67), (21, 59)),
    "rig": ((20, 55), (21, 62), (22, 65)),
}


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
        "bench", 3.0, 12800.0, 39.0, ((1500.0, 100.0), (1100.0, 60.0), (1750.0, 130.0)), "load.torque_N_m",
        {"faults": []},
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
KINDS = {
    "nominal off by 25 %": ("healthy", 0.0, 0.25, False),
    "off by 35 to 60 %": ("healthy", 0.35, 0.60, False),
    "wrong tooth numbers": ("healthy", 0.0, 0.10, True),
    "damaged, off by 25 %": ("faulty", 0.0, 0.25, False),
}


def judged(specimen: Specimen, run: xarray.Dataset, kind: str) -> str:
    """What comes of a record whose machine file has a wrong nominal speed or wrong teeth, drawn by its seed."""
    _, least, most, wrong = KINDS[kind]
    random = np.random.default_rng([specimen.seed, 2, list(KINDS).index(kind)])
    teeth = TEETH[specimen.bed]
    off = random.uniform(least, most) * random.choice([-1, 1])
    true = run.shaft_angle.sel(shaft="shaft_1").values
    true = np.abs(true - true[0])
    frequency = true[-1] / (2 * np.pi) / float(run.time[-1] - run.time[0])
    given = train(wrong_teeth(random, teeth) if wrong else teeth, frequency * (1 + off))
    try:
        found = rotation_of(run[["acceleration"]], given)
    except RotationError:
        return "refused"
    time = run.time.values - float(run.time.mean())
    factor = (time @ found.angle) / (time @ true)
    errors = {
        one.name: factor * one.ratio / other.ratio - 1
        for one, other in zip(given.shafts, train(teeth, frequency).shafts, strict=True)
    }
    if any(abs(error) > RIGHT for name, error in errors.items() if name not in found.conditional):
        return "wrong"
    return "conditional" if given.shafts[0].name in found.conditional else "right"


def wrong_teeth(random: np.random.Generator, teeth: Teeth) -> Teeth:
    """One tooth more or less of one gear, or the first two stages transposed."""
    choice = int(random.integers(2 * len(teeth) + (len(teeth) > 1)))
    if choice == 2 * len(teeth):
        return (teeth[1], teeth[0], *teeth[2:])
    changed = [list(pair) for pair in teeth]
    changed[choice // 2][choice % 2] += int(random.choice([-1, 1]))
    return tuple((pair[0], pair[1]) for pair in changed)


def train(teeth: Teeth, frequency: float) -> Kinematics:
    """Pairs in series."""
    ratios = np.cumprod([1.0, *(driving / driven for driving, driven in teeth)])
    return Kinematics(
        shafts=tuple(Shaft(name=f"shaft_{number}", ratio=float(ratio)) for number, ratio in enumerate(ratios, 1)),
        gears=tuple(
            Gear(name=f"stage {stage} {name}", shaft=f"shaft_{stage + place}", stage=stage, teeth=pair[place])
            for stage, pair in enumerate(teeth, 1)
            for place, name in enumerate(("pinion", "wheel"))
        ),
        frequency=frequency,
    )


def main(folder: str, part: str = "judged") -> None:
    """Judge the records of a part and print how many of each kind are right, conditional, refused or wrong."""
    counts = {kind: Counter[str]() for kind in KINDS}
    for specimen in specimens(part, *PARTS[part]):
        run = record(specimen, Path(folder))
        for kind, (state, *_) in KINDS.items():
            if state == ("faulty" if specimen.fault else "healthy"):
                verdict = judged(specimen, run, kind)
                counts[kind][verdict] += 1
                print(specimen.name, kind, verdict, flush=True)
    print(*(f"{kind}: {dict(count)}" for kind, count in counts.items()), sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
