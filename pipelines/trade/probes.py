"""What people care about, read from finished stages: each probe names the stages it needs and gives named values.

gears     mean secant stiffness and peak-to-peak transmission error of each pair at its load
casing    natural frequencies of the grounded casing
machine   natural frequencies of small motion about the loaded rest
signals   rms of each sensor in each constant-speed window
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipelines.build import Outcome
from pipelines.derived import derive
from pipelines.layout import lay_out
from pipelines.scene import Scene

if TYPE_CHECKING:
    import xarray

LEAST_LINE_LOAD = 100e3  # N/m, where the scene loads a pair with nothing
FREQUENCIES = 10  # lowest ones that are compared


@dataclass(frozen=True, kw_only=True)
class Value:
    """One number of a scene with its unit."""

    name: str
    unit: str
    value: float


@dataclass(frozen=True)
class Probe:
    """`stages` names what must be built for a scene, `read` takes the values from it."""

    stages: Callable[[Scene], Sequence[str]]
    read: Callable[[Scene, Outcome], list[Value]]


def _laws(scene: Scene) -> list[str]:
    return [f"law_{number}" for number in range(1, len(scene.stages) + 1)]


def _gears(scene: Scene, outcome: Outcome) -> list[Value]:
    from fem.contact.curves import stiffness_curve

    layout, values = lay_out(scene), []
    facts = derive(scene, layout).stages
    for number, (name, pair, fact) in enumerate(zip(_laws(scene), layout.pairs, facts, strict=True), 1):
        curve = stiffness_curve(outcome.value(name)[0], fact.mesh_force or LEAST_LINE_LOAD * pair.face_width)
        ripple = float(np.ptp(curve.transmission_error))
        values.append(Value(name=f"stage {number} stiffness", unit="N/um", value=float(curve.secant.mean()) / 1e6))
        values.append(Value(name=f"stage {number} TE peak-to-peak", unit="um", value=ripple * 1e6))
    return values


def _casing(scene: Scene, outcome: Outcome) -> list[Value]:
    from scipy.linalg import eigh

    modes = outcome.value("casing modes")
    squares = eigh(modes.stiffness, modes.mass, eigvals_only=True, subset_by_index=(0, FREQUENCIES - 1))
    return [
        Value(name=f"casing mode {number}", unit="Hz", value=float(np.sqrt(square)) / (2 * np.pi))
        for number, square in enumerate(squares, 1)
    ]


def _machine(scene: Scene, outcome: Outcome) -> list[Value]:
    from mbd.linearised import linear_modes
    from mbd.system import assemble
    from pipelines.machine import machine
    from pipelines.parts import mesh_inputs
    from pipelines.response import wanted_channels

    layout = lay_out(scene)
    train = machine(scene, layout, mesh_inputs(scene, layout, [outcome.value(name) for name in _laws(scene)]))
    modes = linear_modes(assemble(train, outcome.value("casing"), wanted_channels(scene, train)))
    return [
        Value(name=f"machine mode {number}", unit="Hz", value=float(frequency))
        for number, frequency in enumerate(modes.frequencies[:FREQUENCIES], 1)
    ]


def _signals(scene: Scene, outcome: Outcome) -> list[Value]:
    return rms_values(outcome.value("response"), scene)


def rms_values(run: xarray.Dataset, scene: Scene) -> list[Value]:
    """Root mean square over the three axes of every sensor (of every journal without a casing) in every window."""
    from pipelines.analysis import channel, channel_names

    windows = scene.diagnosis.windows_s or {"whole run": (0.0, scene.simulation.end_s)}
    values = []
    for window, (start, end) in windows.items():
        piece = run.sel(time=slice(start, end))
        for name in channel_names(run):
            signal = channel(piece, name).values
            rms = float(np.sqrt((signal**2).sum(axis=1).mean()))
            values.append(Value(name=f"{name} rms, {window}", unit="m/s2", value=rms))
    return values


PROBES = {
    "gears": Probe(_laws, _gears),
    "casing": Probe(lambda _: ["casing modes"], _casing),
    "machine": Probe(lambda scene: [*_laws(scene), "casing"], _machine),
    "signals": Probe(lambda _: ["response"], _signals),
}
