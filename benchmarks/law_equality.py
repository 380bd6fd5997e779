"""Mesh laws of two versions of the code at random states: `python -m benchmarks.law_equality FOLDER [STATES]`.

FOLDER is a worktree of the other version. It evaluates the same laws at the same states in a child process. Every
answer is compared on its own scale, but at least on a millionth of the median.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.law import MeshLaw
from fem.contact.teeth import tooth_terms

CLOSE = 1e-9
SWITCHING = 1e-3  # share of the states whose second derivatives may differ, at a switch of contact
STATES = 10_000
NAMES = ("F", "M", "U", "F by delta", "F by psi", "M by psi", "U by c")
PAIRS: dict[str, dict[str, Any]] = {
    "iso": {"mesh": {"model": "iso"}},
    "iso helical": {"mesh": {"model": "iso"}, "helix_angle_deg": 15.0},
    "energy": {"mesh": {"model": "energy"}, "helix_angle_deg": 15.0},
    "plane": {"mesh": {"model": "plane"}},
    "plane helical": {"mesh": {"model": "plane"}, "helix_angle_deg": 15.0},
    "solid": {"mesh": {"model": "solid", "slices": 15}, "helix_angle_deg": 15.0},
    "solid wide": {"mesh": {"model": "solid", "slices": 31}, "helix_angle_deg": 20.0, "face_width_mm": 40.0},
}
TOOTH = {"stage": 1, "gear": "wheel", "tooth": 3}
FAULTS: dict[str, dict[str, Any]] = {
    "chipped": {"kind": "chipped-tooth", **TOOTH, "depth_mm": 1.2, "extent_mm": 8.0},
    "cracked": {"kind": "cracked-tooth", **TOOTH, "depth_mm": 1.5},
    "cracked corner": {"kind": "cracked-tooth", **TOOTH, "depth_mm": 1.5, "extent_mm": 8.0},
    "spalled": {"kind": "spalled-tooth", **TOOTH, "height_mm": 1.0, "length_mm": 8.0, "depth_um": 100.0},
    "worn": {"kind": "worn-tooth", **TOOTH, "depth_um": 20.0},
}
FAULTY = ("plane helical", "solid")
Case = dict[str, Any]


def cases() -> Iterator[tuple[str, Case]]:
    """Name, law, tooth terms and nominal force of every law that is compared."""
    import gearcase

    rig = gearcase.laws(gearcase.Scene.from_file("rig-missing-tooth"))
    for number, pair in enumerate(rig, 1):
        for law in (pair.drive, pair.coast):
            yield f"rig {number} {law.flank}", _case(law, pair)
    for name, stage in PAIRS.items():
        scene = gearcase.Scene.from_file("pair")
        table = {**scene.to_dict()["stages"][0], **stage}
        yield name, _case((pair := gearcase.laws(scene.changed(stages=[table]))[0]).drive, pair)
        for fault, given in FAULTS.items() if name in FAULTY else ():
            try:
                pair = gearcase.laws(scene.changed(stages=[table], faults=[given]))[0]
            except gearcase.SceneError as error:
                sys.stdout.write(f"{name}, {fault}: {error}\n")
                continue
            yield f"{name}, {fault}", _case(pair.drive, pair)


def _case(law: MeshLaw, pair: Any) -> Case:
    """Law with the faults of the pair and deviations of about grade 6 on every tooth."""
    draw, teeth = np.random.default_rng(2), []
    evaluator = LawEvaluator(law)
    for terms in evaluator.teeth(pair.pinion_faults, pair.wheel_faults):
        sizes = {"clearance": 3e-6, "profile_slope": 3e-6, "profile_curvature": 2e-6, "lead_slope": 4e-6}
        deviations = tooth_terms(
            len(terms), **{name: draw.normal(0.0, size, len(terms)) for name, size in sizes.items()}
        )
        teeth.append(terms + deviations)
    return {"law": law, "teeth": teeth, "force": pair.force}


def states(case: Case, count: int) -> np.ndarray:
    """Cycle, delta and psi (count, 3), half of them near the damaged tooth."""
    law, draw = case["law"], np.random.default_rng(5)
    evaluator, width = LawEvaluator(law), float(law.slice_width.sum())
    damaged = [t for t in case["teeth"] if (t[:, 5] > 0).any() or np.isinf(t[:, 0]).any()]
    cycle = draw.uniform(-200.0, 200.0, count)
    if damaged:
        tooth = int(np.argmax((damaged[0][:, 5] > 0) | np.isinf(damaged[0][:, 0])))
        offset = law.wheel_tooth_offset if damaged[0] is case["teeth"][1] else 0
        middle = (tooth - offset) * law.cycle_sign
        cycle[::2] = (middle - law.cycle_offset) * law.cycle_sign + draw.uniform(-2.5, 2.5, cycle[::2].size)
    some = draw.uniform(-200.0, 200.0, 50)
    first = float(np.median(evaluator.no_load(some)))
    bent = float(np.median(evaluator.approach_at(case["force"], some))) - first
    loaded = bent * 10.0 ** draw.uniform(-2.0, 0.5, count)
    loaded[::10] = bent * draw.uniform(-1.0, 1.0, loaded[::10].size)
    loaded[1::20] = bent * draw.uniform(30.0, 100.0, loaded[1::20].size)
    delta, psi = first + loaded, draw.normal(0.0, 1.0, count) * np.abs(loaded) / width
    psi[::3] *= 0.02
    return np.stack([cycle, delta, psi], axis=1)


def answers(case: Case, at: np.ndarray) -> np.ndarray:
    """Answers (state, 7): F, M, U, their slopes by delta and psi, and the slope of U by the cycle."""
    return np.stack(LawEvaluator(case["law"]).evaluate(*at.T, *case["teeth"]), axis=1)


def differences(case: Case, own: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Differences (state, 7) over the scales of force, moment, energy, stiffnesses and slope of the energy."""
    half = float(case["law"].slice_width.sum()) / 2
    typical = np.median(np.abs(other[np.abs(other[:, 0]) > 0.0]), axis=0)
    force, energy, stiff = (np.maximum(np.abs(other[:, k]), 1e-6 * typical[k]) for k in (0, 2, 3))
    slope = np.maximum(np.abs(other[:, 6]), energy)
    scales = force, force * half, energy, stiff, stiff * half, stiff * half**2, slope
    return np.abs(own - other) / np.stack(scales, axis=1)


def main(folder: Path, count: int) -> int:
    """Compare all laws; returns the number of those that differ by more than is allowed."""
    wrong = 0
    with tempfile.TemporaryDirectory() as place:
        given, found = Path(place) / "given", Path(place) / "found"
        known = [(name, case, states(case, count)) for name, case in cases()]
        given.write_bytes(pickle.dumps([(case, at) for _, case, at in known]))
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        program = f"import runpy; runpy.run_path({__file__!r})['evaluate_all']({str(given)!r}, {str(found)!r})"
        subprocess.run([sys.executable, "-c", program], cwd=folder, env=environment, check=True)
        for (name, case, at), others in zip(known, pickle.loads(found.read_bytes()), strict=True):
            one = differences(case, answers(case, at), others)
            values = float(one[:, :3].max())
            slopes = float((one[:, 3:].max(axis=1) > CLOSE).mean())
            bad = not (values <= CLOSE and slopes <= SWITCHING)
            wrong += bad
            typical = "  ".join(f"{n} {v:.0e}" for n, v in zip(NAMES, np.quantile(one, 0.999, axis=0), strict=True))
            sys.stdout.write(f"{name:28} {'DIFFERS' if bad else 'equal':8} largest {values:.1e}, ")
            sys.stdout.write(f"second derivatives of {slopes:.2%} of the states; 99.9 %: {typical}\n")
            sys.stdout.flush()
    return wrong


def evaluate_all(given: str, found: str) -> None:
    """In the child: answers of the laws and states in one file into another."""
    Path(found).write_bytes(pickle.dumps([answers(*one) for one in pickle.loads(Path(given).read_bytes())]))


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1]).resolve(), int(sys.argv[2]) if sys.argv[2:] else STATES) > 0)
