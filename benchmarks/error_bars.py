"""Error bars of the rig against simulated casings and meshes: `python -m benchmarks.error_bars [OUTPUT.json]`.

Two questions, for every line 10 dB over its floor in one run:

    draws    44 drawn casings are simulated; how many of their levels lie within the bars, how wide are the bars over
             the 5 to 95 % of these levels, and how far is what was predicted for each casing from its simulation
    meshes   the casing is meshed with other elements of other sizes; how many of their levels lie within the bars, and
             does the bar of each mesh reach to the level of the finest one
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions
from fem.casing.reduced.reduced_body import ReducedBody
from fem.casing.uncertainty.casing_samples import CasingSamples, near_modes, sampled_frequencies
from fem.casing.uncertainty.modal_form import ModalForm, modal_form
from mbd.output.trajectory import Trajectory
from pipelines.diagnosis.control_diagnosis import Diagnosis, diagnose
from pipelines.diagnosis.uncertainty.bar_records import LineBars
from pipelines.diagnosis.uncertainty.sampled_bars import casing_errors
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph, Step
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.system_assembly import assemble_machine, assemble_system
from pipelines.scene.load_scene import load_scene
from pipelines.signals.analysis import analyse
from pipelines.signals.response import make_response
from pipelines.steps.error_bars import machine_bars
from pipelines.steps.motion import moved
from pipelines.steps.result_steps import bars_step, casing_taken
from pipelines.steps.run_plan import plan_run

OUTPUT = Path(__file__).parent / "results" / "error_bars.json"
SHORT: dict[str, Any] = {
    "casing.band_Hz": 3500.0,
    "simulation.end_s": 2.6,
    "diagnosis.windows_s": {"lifting": [0.5, 2.5]},
}


def tetrahedra(size: float, nodes: int = 20, **other: float) -> dict[str, Any]:
    """Settings of an extrapolated mesh, size in mm."""
    return {
        "casing.element": f"tetrahedron-{nodes}",
        "casing.extrapolated": True,
        "casing.element_size_mm": size,
        **other,
    }


def hexahedra(size: float) -> dict[str, Any]:
    """Settings of an extrapolated mesh of cubic hexahedra, size in mm."""
    return {
        "casing.element": "hexahedron-32",
        "casing.extrapolated": True,
        "casing.element_size_mm": size,
    }


FIRST = "hexahedra-32 28"
FINEST = "hexahedra-32 18"
MESHES = {
    FIRST: hexahedra(28.0),
    "hexahedra-32 37": hexahedra(37.0),
    FINEST: hexahedra(18.0),
    "tetrahedra-20 33": tetrahedra(33.0),
    "tetrahedra-20 28": tetrahedra(28.0),
    "tetrahedra-20 24": tetrahedra(24.0),
    "tetrahedra-10 17.6": tetrahedra(17.6, 10, **{"casing.bore_element_size_mm": 7.0}),
}
DRAWS, SEED = 44, 7


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshRun:
    """A run of the rig on one mesh, and what its bars are made of."""

    model: MachineModel
    motion: Trajectory
    taken: Mapping[str, Any]


def mesh_run(settings: Mapping[str, Any]) -> MeshRun:
    """The rig with a missing tooth in a casing of one mesh."""
    plan = plan_run(load_scene("rig-missing-tooth", {**SHORT, **settings}), with_control=False, both_loads=False)
    model = plan.machine
    step = Step(
        name="inputs",
        kind="inputs",
        build=machine_bars,
        takes={"laws": model.law_names, **casing_taken(plan.graph)},
    )
    outcome = Work(processes=1).build(plan.graph, ["simulate", *step.inputs])
    return MeshRun(model=model, motion=outcome.value("simulate"), taken=step.received(outcome.value))


def first_bars() -> tuple[Diagnosis, LineBars]:
    """Diagnosis and bars of the first mesh, against its healthy control."""
    loaded = load_scene("rig-missing-tooth", {**SHORT, **MESHES[FIRST]})
    plan = plan_run(loaded, both_loads=False)
    step, case = bars_step(plan), plan.cases[0]
    assert case.control is not None
    assert case.own.machine.diagnosis is not None
    outcome = Work(processes=1).build(Graph([*plan.graph, step]), [step.name, case.own.step, case.control.step])
    runs = (make_response(outcome.value(case.own.step), case.own.machine.labels),
            make_response(outcome.value(case.control.step), case.control.machine.labels))  # fmt: skip
    return diagnose(*runs, case.own.machine.diagnosis), outcome.value(step.name)


def levels(motion: Trajectory, model: MachineModel, diagnosis: Diagnosis, bars: LineBars) -> np.ndarray:
    """Levels (line,) of a motion in dB, without sensor noise."""
    run = make_response(motion, model.labels | {"sensor_noise_m_s2": 0.0})
    found = analyse(run, diagnosis.settings, band=diagnosis.band)
    spectra = [(found.envelopes if bar.kind == "envelope" else found.spectra)[bar.window] for bar in bars.bars]
    lines = [one.lines([bar.frequency])[0] for one, bar in zip(spectra, bars.bars, strict=True)]
    return np.asarray(20.0 * np.log10(np.array(lines)))


def numerical(bars: LineBars) -> np.ndarray:
    """Low and high ends (2, line), dB."""
    return np.array([[bar.numerical.low, bar.numerical.high] for bar in bars.bars if bar.numerical]).T


def inside(found: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Which changes (..., line) lie between the ends (2, line)."""
    return (found >= ends[0]) & (found <= ends[1])


def drawn_body(body: ReducedBody, form: ModalForm, draws: CasingSamples, number: int) -> ReducedBody:
    """The casing with the number `number` of some draws.

    Parameters
    ----------
    body, form : the casing that they were drawn about, and its modes
    draws : the casings
    number : from 0
    """
    near, turn = draws.squares.shape[1], draws.turns[number]
    squares = np.concatenate([draws.squares[number], form.squares[near:] * (1.0 + draws.stiffening[number])])
    ratios = form.ratios.copy()
    ratios[:near] *= draws.damping[number]
    shapes = np.hstack([form.shapes[:, :near] @ turn, form.shapes[:, near:]])
    weighted = body.mass @ shapes
    return replace(
        body,
        stiffness=(weighted * squares) @ weighted.T,
        damping=(weighted * (2.0 * ratios * np.sqrt(squares))) @ weighted.T,
    )


def simulated_samples(first: MeshRun, diagnosis: Diagnosis, bars: LineBars) -> np.ndarray:
    """Levels (draw, line) of drawn casings that are simulated, dB over those of the run."""
    model, body = first.model, first.taken["body"]
    errors = casing_errors(first.taken["modes"][0], first.taken["coarser"])
    assert errors is not None
    form = modal_form(body)
    near = near_modes(form, max(diagnosis.band[1], diagnosis.settings.highest_line))
    draws = sampled_frequencies(form, near, errors, DRAWS, SEED)
    machine = assemble_machine(model.parts, first.taken["laws"])
    own, found = levels(first.motion, model, diagnosis, bars), []
    for number in range(DRAWS):
        other = drawn_body(body, form, draws, number)
        system = assemble_system(machine, other, model.recorded, model.motion.band)
        found.append(levels(moved(system, model.motion), model, diagnosis, bars) - own)
        print(f"draw {number + 1} of {DRAWS}", flush=True)
    return np.array(found)


def main(arguments: Sequence[str]) -> None:
    """Simulate, compare, write."""
    diagnosis, bars = first_bars()
    ends, first = numerical(bars), mesh_run(MESHES[FIRST])
    drawn = simulated_samples(first, diagnosis, bars)
    scatter = np.percentile(drawn, (5.0, 95.0), axis=0)
    runs = {name: mesh_run(settings) for name, settings in MESHES.items()}
    level = {name: levels(run.motion, run.model, diagnosis, bars) for name, run in runs.items()}
    others = {name: level[name] - level[FIRST] for name in MESHES if name != FIRST}
    own = {}
    for name, run in runs.items():
        found = machine_bars(run.model, make_response(run.motion, run.model.labels), diagnosis, **run.taken)
        if name != FINEST and isinstance(found, LineBars) and all(bar.numerical for bar in found.bars):
            own[name] = inside(level[FINEST] - level[name], numerical(found))
    pooled = np.concatenate([inside(drawn, ends), inside(np.array(list(others.values())), ends)])
    results = {
        "conditions": conditions(),
        "lines": [f"{bar.kind} {bar.label}" for bar in bars.bars],
        "bars dB": ends.T.round(3).tolist(),
        "median width dB": float(np.median(ends[1] - ends[0])),
        "draws": DRAWS,
        "draws covered": float(inside(drawn, ends).mean()),
        "width over scatter of draws, median": float(np.median((ends[1] - ends[0]) / (scatter[1] - scatter[0]))),
        "meshes dB": {name: change.round(3).tolist() for name, change in others.items()},
        "meshes covered": {name: float(inside(change, ends).mean()) for name, change in others.items()},
        "draws and meshes covered": float(pooled.mean()),
        f"own bars that reach {FINEST}": {name: float(found.mean()) for name, found in own.items()},
    }
    path = Path(arguments[0]) if arguments else OUTPUT
    path.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main(sys.argv[1:])
