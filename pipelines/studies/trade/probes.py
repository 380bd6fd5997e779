"""Probes: quantities of a scene that trade-offs and refinement studies compare, from its finished steps.

gears         mean secant stiffness and peak-to-peak transmission error of each pair at its load
transmission  transmission error of each pair at its load, over one mesh cycle
casing        natural frequencies of the casing on its ground
modes         more of them, each with its shape at bearings and sensors, which identifies modes that change their order
frf           level of the accelerance from the first bearing to the monitored sensor, by third octave
machine       natural frequencies of small motion about the loaded equilibrium
signals       rms of each sensor in each window of constant speed
lines         levels of the lines of the fault in the envelope of the monitored sensor
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.engine.run_graph import Outcome
from pipelines.machine.machine_model import MachineModel
from pipelines.steps.pair_curves import law_names, pair_laws
from pipelines.studies.housings.responses import accelerances

FREQUENCIES = 10  # lowest ones that are compared
MODES = 30  # lowest ones that are compared by their shapes
POSITIONS = 256  # of a mesh cycle at which the transmission error is evaluated
OCTAVE_POINTS = 8  # frequencies per third octave
DECIBEL = "dB"


@dataclass(frozen=True, kw_only=True)
class Value:
    """One quantity of a scene; levels in dB are compared by their difference, all others by their ratio.

    `firm` is False if the value is not compared, such as a line that does not exceed its floor. `shape` contains the
    displacements of a mode.
    """

    name: str
    unit: str
    value: float
    firm: bool = True
    shape: tuple[float, ...] = ()


@dataclass(frozen=True)
class QuantityKind:
    """A kind of quantity: `steps` gives the names of the required steps, `read` the values from their outcome."""

    steps: Callable[[MachineModel], Sequence[str]]
    read: Callable[[MachineModel, Outcome], list[Value]]


def _gears(machine: MachineModel, outcome: Outcome) -> list[Value]:
    values = []
    for found in pair_laws(machine, outcome.value):
        number, curve = found.stage, found.stiffness()
        ripple = float(np.ptp(curve.transmission_error))
        values.append(Value(name=f"stage {number} stiffness", unit="N/um", value=float(curve.secant.mean()) / 1e6))
        values.append(Value(name=f"stage {number} TE peak-to-peak", unit="um", value=ripple * 1e6))
    return values


def _transmission(machine: MachineModel, outcome: Outcome) -> list[Value]:
    cycle = np.arange(POSITIONS) / POSITIONS
    return [
        Value(name=f"stage {found.stage} TE at {place:.4f}", unit="um", value=float(error) * 1e6)
        for found in pair_laws(machine, outcome.value)
        for place, error in zip(cycle, found.stiffness(cycle).transmission_error, strict=True)
    ]


def _natural_modes(outcome: Outcome, count: int) -> list[Value]:
    from scipy.linalg import eigh

    body = outcome.value("casing")
    last = min(count, len(body.mass)) - 1
    if last < 0:
        return []
    squares, vectors = eigh(body.stiffness, body.mass, subset_by_index=(0, last))
    moving = [name.endswith((":ux", ":uy", ":uz")) for name in body.row_names]
    shapes = body.rows[moving] @ vectors
    return [
        Value(
            name=f"casing mode {number}",
            unit="Hz",
            value=float(np.sqrt(max(square, 0.0))) / (2 * np.pi),
            shape=tuple(shape.tolist()),
        )
        for number, (square, shape) in enumerate(zip(squares, shapes.T, strict=True), 1)
    ]


def _frf(machine: MachineModel, outcome: Outcome) -> list[Value]:
    """Level of the Frobenius norm of the 3 x 3 accelerance (m/s2 per N) in the third octaves up to 5 kHz."""
    if not machine.sensors:
        return []
    body = outcome.value("casing")
    out = np.array([body.row(f"{machine.monitored.sensor}:{axis}") for axis in ("ux", "uy", "uz")])
    into = np.array([body.row(f"bearing_1:{axis}") for axis in ("ux", "uy", "uz")])
    values = []
    for centre in 1000.0 * 2.0 ** (np.arange(-10, 8) / 3):
        frequencies = centre * 2.0 ** ((np.arange(OCTAVE_POINTS) + 0.5) / OCTAVE_POINTS / 3 - 1 / 6)
        squares = np.abs(accelerances(body, out, into, frequencies)) ** 2
        level = 10 * np.log10(squares.sum() / OCTAVE_POINTS)
        values.append(Value(name=f"FRF at {centre:.0f} Hz", unit=DECIBEL, value=float(level)))
    return values


def _machine(machine: MachineModel, outcome: Outcome) -> list[Value]:
    from mbd.system.linearised import linear_modes
    from pipelines.machine.system_assembly import assemble_machine, assemble_system

    assembled = assemble_machine(machine.parts, [outcome.value(name) for name in machine.law_names])
    modes = linear_modes(assemble_system(assembled, outcome.value("casing"), machine.recorded))
    return [
        Value(name=f"machine mode {number}", unit="Hz", value=float(frequency))
        for number, frequency in enumerate(modes.frequencies[:FREQUENCIES], 1)
    ]


def _signals(machine: MachineModel, outcome: Outcome) -> list[Value]:
    """RMS of the resultant of the three axes of every sensor (without a casing, of every journal)."""
    from pipelines.signals.analysis import channel, channel_names
    from pipelines.signals.response import make_response

    run = make_response(outcome.value("simulate"), machine.labels)
    windows = machine.monitored.windows or {"whole run": (0.0, machine.motion.end)}
    values = []
    for window, (start, end) in windows.items():
        piece = run.sel(time=slice(start, end))
        for name in channel_names(run):
            signal = channel(piece, name).values.astype(float)
            rms = float(np.sqrt((signal**2).sum(axis=1).mean()))
            values.append(Value(name=f"{name} rms, {window}", unit="m/s2", value=rms))
    return values


def _lines(machine: MachineModel, outcome: Outcome) -> list[Value]:
    from pipelines.signals.analysis import analyse
    from pipelines.signals.measured_speed import at_measured_speed
    from pipelines.signals.response import make_response

    settings = machine.diagnosis
    if settings is None or not machine.faults:
        return []
    run = make_response(outcome.value("simulate"), machine.labels)
    if not settings.speed_is_known:
        settings = at_measured_speed(settings, (run,))
    found = analyse(run, settings, stream=1)
    orders = np.arange(1, settings.envelope_harmonics + 1)
    places = orders * settings.revolution_frequency
    values = []
    for window, envelope in found.envelopes.items():
        levels, floors = 20 * np.log10(envelope.lines(places)), 20 * np.log10(envelope.floors(places))
        values += [
            Value(
                name=f"envelope {order} f_r, {window}",
                unit=DECIBEL,
                value=float(level),
                firm=bool(level - floor >= settings.floor_limit),
            )
            for order, level, floor in zip(orders, levels, floors, strict=True)
        ]
    return values


PROBES = {
    "gears": QuantityKind(law_names, _gears),
    "transmission": QuantityKind(law_names, _transmission),
    "casing": QuantityKind(lambda _: ["casing"], lambda _, outcome: _natural_modes(outcome, FREQUENCIES)),
    "modes": QuantityKind(lambda _: ["casing"], lambda _, outcome: _natural_modes(outcome, MODES)),
    "frf": QuantityKind(lambda _: ["casing"], _frf),
    "machine": QuantityKind(lambda machine: [*machine.law_names, "casing"], _machine),
    "signals": QuantityKind(lambda _: ["simulate"], _signals),
    "lines": QuantityKind(lambda _: ["simulate"], _lines),
}
