"""Error bars of the lines of a run from samples of uncertain inputs of its casing, without a further simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fem.casing.reduced.casing_modes import CasingModes
from fem.casing.uncertainty.casing_samples import (
    CasingSamples,
    joined,
    near_modes,
    nominal_samples,
    sampled_damping,
    sampled_frequencies,
    single_errors,
)
from fem.casing.uncertainty.extrapolation import RIGID_MOTIONS, LowestModes, measured_limits
from fem.casing.uncertainty.frequency_errors import FrequencyErrors, frequency_errors
from fem.casing.uncertainty.modal_form import ModalForm, modal_form
from mbd.system.blocked_forces import machine_at_seats
from mbd.system.statics import equilibrium
from mbd.system.system import System
from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.uncertainty.bar_records import SAMPLES, Band, LineBar, LineBars, band
from pipelines.diagnosis.uncertainty.casing_changes import CasingPath
from pipelines.diagnosis.uncertainty.line_changes import CutRun, envelope_changes, spectrum_changes
from pipelines.signals.analysis import channel, sampling
from pipelines.signals.line_table import LineTable
from pipelines.signals.spectrum import cut

if TYPE_CHECKING:
    import xarray

SEED = 1
SEATS, SHAPES, STEP = "modes above and seats", "shapes of casing modes", "time step"
DAMPING = "damping of the casing"
MISSED = 1.0  # dB: a larger difference from the recorded line means that forces other than the bearings' excite it

_LEFT_OUT = (
    "Not in the error bars: the error of the mesh law, which gearcase converge --over gear-mesh and --over slices "
    "estimate; the effect of the deviations, which gearcase run --seeds shows; modes above the band of the "
    "reduced casing; and the stiffness of bearing seats, feet and mounts."
)


class BarsError(ValueError):
    """Error bars cannot be computed; the message states the reason."""


def casing_errors(modes: CasingModes | None, coarser: Sequence[LowestModes]) -> FrequencyErrors | None:
    """Errors of the natural frequencies of an extrapolated casing by its mesh, None for other casings.

    Parameters
    ----------
    modes, coarser : modes of an extrapolated casing on its mesh, and on the coarser ones; None and empty for others
    """
    if modes is None or not coarser:
        return None
    first = RIGID_MOTIONS if modes.ground == "springs" else 0
    return frequency_errors(measured_limits(modes, coarser), first)


def line_bars(
    run: xarray.Dataset,
    diagnosis: Diagnosis,
    system: System,
    errors: FrequencyErrors | None,
    damping_spread: float,
    remedy: str,
) -> LineBars:
    """Error bars of all lines of a diagnosis that exceed their floor by the limit of its settings.

    Parameters
    ----------
    run : signals of the diagnosed run
    diagnosis : its lines
    system : the machine in the casing of the run
    errors : of the natural frequencies of the casing, None if they are not known
    damping_spread : relative; in 90 % of the samples the damping ratios are multiplied by a factor between
        1/(1 + damping_spread) and 1 + damping_spread
    remedy : setting that makes unknown errors known

    Raises
    ------
    BarsError : the casing does not move, or carries no bearing
    MachineError, EquilibriumError : the machine has no loaded equilibrium about which it could be linearised
    """
    body = system.layout.casing
    if not len(body.coordinate_names):
        raise BarsError("No error bars: the bearings are on the ground, so the signals do not depend on a casing.")
    form, found, missed = modal_form(body), list[LineBar](), list[str]()
    for window in diagnosis.settings.windows:
        lines = diagnosis.lines.where(window=window).of("envelope", "sideband", "mesh", "shaft")
        lines = lines.at(np.flatnonzero(lines.over_floor >= diagnosis.settings.floor_limit).tolist())
        if len(lines):
            found += _window_bars(_Window(run, diagnosis, window, system, form), lines, errors, damping_spread, missed)
    return LineBars(bars=tuple(found), notes=_notes(missed, remedy if errors is None else "", damping_spread))


class _Window:
    """A window of the run with the transfer path from the bearings to the sensor."""

    def __init__(self, run: xarray.Dataset, diagnosis: Diagnosis, name: str, system: System, form: ModalForm) -> None:
        settings, segment = diagnosis.settings, diagnosis.segments[name]
        self.name, self.band, self.settings, self.form = name, diagnosis.band, settings, form
        self.step_error = float(run.attrs.get("step_error", 0.0))
        rate, _ = sampling(run)
        body = system.layout.casing
        forces = run.bearing_force.transpose("time", "bearing", "axis")
        on_casing = [b for b in forces.bearing.values if f"{b}:ux" in body.row_names]
        if not on_casing:
            raise BarsError("No error bars: no bearing is mounted on the casing, so its excitation is not known.")
        places = [f"{bearing}:u{axis}" for bearing in on_casing for axis in forces.axis.values]
        first = round(segment.start * rate)
        speed = run.motor_speed.isel(motor=0, time=slice(first, first + round(segment.duration * rate)))
        axes = list("xyz" if settings.axis == "resultant" else settings.axis)
        self.cut = CutRun(
            segment=segment,
            signal=cut(channel(run, settings.sensor).sel(axis=axes).values, rate, segment),
            forces=cut(forces.sel(bearing=on_casing).values.reshape(run.time.size, -1), rate, segment),
        )
        self.path = CasingPath(
            form=form,
            near=near_modes(form, max(self.band[1], settings.highest_line)),
            machine=machine_at_seats(system, equilibrium(system, float(speed.mean()))),
            sensor=np.array([body.row(f"{settings.sensor}:u{axis}") for axis in axes]),
            forced=np.array([body.row(place) for place in places]),
        )

    def changes(self, lines: LineTable, casings: CasingSamples) -> tuple[np.ndarray, np.ndarray]:
        """Changes of lines (sample, line), dB, and the error of the path (line,), dB; 0 for lines of the envelope."""
        levels, missed = np.zeros((len(casings), len(lines))), np.zeros(len(lines))
        enveloped = np.array([kind == "envelope" for kind in lines.kind])
        if (~enveloped).any():
            levels[:, ~enveloped], missed[~enveloped] = spectrum_changes(
                self.cut, self.path, lines.frequency[~enveloped].tolist(), casings
            )
        if enveloped.any():
            levels[:, enveloped] = envelope_changes(
                self.cut,
                self.path,
                lines.order[enveloped].tolist(),
                self.settings.revolution_frequency,
                self.band,
                casings,
            )
        return levels, missed


def _window_bars(
    window: _Window, lines: LineTable, errors: FrequencyErrors | None, damping_spread: float, missed: list[str]
) -> list[LineBar]:
    form, near = window.form, window.path.near
    parts = [nominal_samples(form, near), sampled_damping(form, near, damping_spread, SAMPLES, SEED)]
    if errors is not None:
        parts += [sampled_frequencies(form, near, errors, SAMPLES, SEED), single_errors(form, near, errors)]
    levels, off = window.changes(lines, joined(parts))
    inputs, rest = levels[1 : 1 + SAMPLES], levels[1 + SAMPLES :]
    missed += [f"{window.name} {lines.label[i]}" for i in np.flatnonzero(abs(off) > MISSED)]
    numerical: list[Band | None] = [None] * len(lines)
    if errors is not None:
        numerical = list(_numerical(window, rest[:SAMPLES], rest[SAMPLES:]))
    return [
        LineBar(
            window=window.name,
            kind=lines.kind[i],
            label=lines.label[i],
            frequency=float(lines.frequency[i]),
            level=float(lines.faulty[i]),
            detected=bool(lines.detected[i]),
            numerical=numerical[i],
            inputs=band(inputs[:, i], {DAMPING: 1.0}),
        )
        for i in range(len(lines))
    ]


def _numerical(window: _Window, sampled: np.ndarray, single: np.ndarray) -> Sequence[Band]:
    """Numerical uncertainty of each line, from the errors of the casing modes and of the time step.

    The error of the time step has the same relative size for every line. The part of the variance that no single error
    causes is attributed to mode mixing.
    """
    step = 20.0 / np.log(10.0) * window.step_error
    sampled = sampled + step * np.random.default_rng(SEED).standard_normal(sampled.shape)
    names = [f"casing mode at {frequency:.0f} Hz" for frequency in window.form.frequencies[: window.path.near]]
    alone = abs(single[1:] - single[0])
    found = []
    for line, changes in enumerate(sampled.T):
        sources = dict(zip((*names, SEATS), alone[:, line].tolist(), strict=True)) | {STEP: step}
        shapes = float(np.var(changes)) - sum(change**2 for change in sources.values())
        found.append(band(changes, sources | {SHAPES: math.sqrt(max(shapes, 0.0))}))
    return found


def _notes(missed: Sequence[str], remedy: str, damping_spread: float) -> tuple[str, ...]:
    """Sentences on the errors that the error bars contain and omit.

    Parameters
    ----------
    missed : names of lines that forces other than those of the bearings excite, too
    remedy : setting that makes the error of the casing mesh known, "" if it is known
    damping_spread : relative spread of the damping ratios, 5 to 95 %
    """
    numerical = (
        f"Numerical uncertainty: 5 to 95 % of {SAMPLES} samples. Each sample changes the natural frequencies of the "
        "casing within their uncertainty bands, and adds an error of the time step."
    )
    if remedy:
        numerical = (
            f"The discretisation error of the casing is not known: {remedy}. Only the effect of uncertain damping is "
            "shown."
        )
    damping = (
        f"Uncertain damping: 5 to 95 % of {SAMPLES} samples. Each sample multiplies all damping ratios of the casing "
        f"by one factor, in 90 % of the samples between {1 / (1 + damping_spread):.2g} and {1 + damping_spread:.2g}. "
        "This range is an assumption; diagnosis.damping_spread sets it."
    )
    incomplete = (
        "These lines are excited by further forces than those of the bearings, so their error bars are incomplete: "
        f"{', '.join(missed)}."
    )
    return (numerical, damping, _LEFT_OUT, *([incomplete] if missed else []))
