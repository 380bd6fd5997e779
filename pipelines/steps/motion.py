"""Stage `simulate`: machine in its casing, from equilibrium through the speed profile."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.engine.step import Built
from pipelines.scene.scene import Scene

if TYPE_CHECKING:
    from fem.casing.reduced.body import ReducedBody
    from fem.contact.law import MeshLaw
    from mbd.output.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True)
class MotionSpec:
    """The scene without all that the motion does not depend on, see `pipelines.steps.graph.motion_scene`."""

    scene: Scene


def build(spec: MotionSpec, body: ReducedBody, *laws: tuple[MeshLaw, MeshLaw], folder: Path | None = None) -> Built:
    """The trajectory of the wanted channels, with energy balance and counters; its values stay in a file in `folder`.

    Raises
    ------
    OSError : the file cannot be written
    """
    import numpy as np

    from mbd.accuracy.repeatability import other_start
    from mbd.simulate import Settings, simulate
    from mbd.system.statics import equilibrium
    from mbd.system.system import assemble
    from pipelines.plant.channels import wanted_channels
    from pipelines.plant.layout import lay_out
    from pipelines.plant.machine import machine
    from pipelines.plant.teeth import mesh_inputs

    scene, table = spec.scene, spec.scene.simulation
    layout = lay_out(scene)
    train = machine(scene, layout, mesh_inputs(scene, layout, list(laws)))
    system = assemble(train, body, wanted_channels(scene, train), table.band_Hz)
    settings = Settings(
        end=table.end_s,
        output_rate=table.output_rate_Hz,
        step=table.step_us / 1_000_000,
        integrator=table.integrator,
    )
    start = None
    if table.start:
        start = other_start(system, equilibrium(system, float(train.profile.speed(np.zeros(1))[0])), table.start)
    trajectory = simulate(system, settings, start=start, file=folder / "values.npy" if folder else None)
    return Built(trajectory, ledger(trajectory, system.basis.shape[1], rope=bool(train.load.coordinates)))


def ledger(trajectory: Trajectory, coordinates: int, *, rope: bool) -> dict[str, int]:
    """Counts of the run."""
    counts = {name: trajectory.counter(name) for name in trajectory.counter_names if name == "steps"}
    return {
        "simulations": 1,
        "coordinates": coordinates,
        "rope_coordinates": int(rope),
        "time_steps": counts.get("steps", 0),
        "channels": len(trajectory.channel_names),
    }
