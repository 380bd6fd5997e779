"""Lines of a faulty run, compared with those of its healthy control.

A fault on one tooth repeats with the revolution frequency f_r of its shaft. It modulates the mesh vibration, which
causes harmonics of f_r in the envelope and sidebands n f_m + k f_r in the spectrum. Pitch deviations cause the same
lines in a healthy run. A line is therefore detected only if it is at least 6 dB over the control with the same
deviations and at least 10 dB over the local floor, both with the stated sensor noise. The band of the envelope is
chosen from the healthy run, see `pipelines.signals.analysis`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fem.storage import shown_html
from pipelines.signals.analysis import DiagnosisError, DiagnosisSettings, analyse, noise_of
from pipelines.signals.line_table import IN_ENVELOPE, LineTable, joined, level
from pipelines.signals.measured_speed import at_measured_speed
from pipelines.signals.motion_warnings import chance_of_run
from pipelines.signals.shaft_lines import readable
from pipelines.signals.spectrum import Segment, Spectrum

if TYPE_CHECKING:
    import xarray

__all__ = ["Diagnosis", "DiagnosisError", "DiagnosisSettings", "diagnose"]

STATES = ("faulty", "healthy")
_LINES_SHOWN = 12
LINE_WIDTH = 2.0  # bins; a rope mode this close to a line cannot be distinguished from it


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis:
    """Lines of a faulty run and its control, with the spectra from which they were taken."""

    settings: DiagnosisSettings
    load: str
    deviations: str  # "off" | "seed <n>"
    noise: float  # m/s2 rms, added to both runs
    chance: str  # why the difference of the runs can be chance, "" if it is not; then no line is detected
    band: tuple[float, float]  # Hz
    segments: Mapping[str, Segment]  # window -> segment
    lines: LineTable
    spectra: Mapping[tuple[str, str], Spectrum]  # (state, window)
    envelopes: Mapping[tuple[str, str], Spectrum]

    def __repr__(self) -> str:
        return f"<Diagnosis: {self.load}, deviations {self.deviations}, {self._words()}>"

    def _words(self) -> str:
        return f"{int(self.lines.detected.sum())} of {len(self.lines)} lines detected"

    def _repr_html_(self) -> str:
        """The lines with the largest increase over the control, and the spectra of the first window, for a notebook."""
        units, window = self.lines.units(), next(iter(self.settings.windows))
        rising = self.lines.at(np.argsort(-self.lines.difference)[:_LINES_SHOWN].tolist())
        names = ("window", "kind", "label", "frequency", "faulty", "healthy", "difference", "detected")
        rows = [[row[name] for name in names] for row in rising.to_dicts()]
        title = f"{self._words()}; the {len(rows)} with the largest increase over the control"
        heads = [name if units[name] in ("", "1") else f"{name}, {units[name]}" for name in names]
        table = shown_html.table(title, heads, rows)
        amplitudes = {state: self.spectra[state, window].amplitude for state in STATES}
        across = self.spectra["faulty", window].frequency
        return table + shown_html.curves(f"Hz, {window}", across, "m/s2", amplitudes)


def diagnose(faulty: xarray.Dataset, healthy: xarray.Dataset, settings: DiagnosisSettings) -> Diagnosis:
    """Compare two runs of one scene that differ only in the fault.

    Parameters
    ----------
    faulty, healthy : Datasets with acceleration (time, sensor, axis) in m/s2 of equal sampling, and the equal
        attributes load, seed ("none" for error-free gears) and sensor_noise_m_s2

    Raises
    ------
    DiagnosisError : sensor missing; the shaft does not turn at f_r, or, if its speed was not known, its speed varies
        too much
    SpectrumError : a window contains no whole revolution
    """
    if not settings.speed_is_known:
        settings = at_measured_speed(settings, (faulty, healthy))
    control = analyse(healthy, settings, stream=0)
    damaged = analyse(faulty, settings, stream=1, band=control.band)
    analyses = {"faulty": damaged, "healthy": control}
    spectra = {(state, name): a.spectra[name] for state, a in analyses.items() for name in settings.windows}
    envelopes = {(state, name): a.envelopes[name] for state, a in analyses.items() for name in settings.windows}
    load, deviations = str(faulty.attrs["load"]), deviation_name(faulty.attrs)
    lines = joined(_window_lines(settings, name, load, deviations, spectra, envelopes) for name in settings.windows)
    end = max(end for _, end in settings.windows.values())
    chance = chance_of_run(faulty, end) or chance_of_run(healthy, end)
    if chance:
        lines = replace(lines, detected=np.zeros_like(lines.detected))
    return Diagnosis(
        settings=settings,
        load=load,
        deviations=deviations,
        noise=noise_of(faulty),
        chance=chance,
        band=control.band,
        segments=control.segments,
        lines=lines,
        spectra=spectra,
        envelopes=envelopes,
    )


def deviation_name(labels: Mapping[str, Any]) -> str:
    """ "off" for error-free gears (label seed "none"), else "seed <n>"."""
    seed = str(labels.get("seed", "none"))
    return "off" if seed == "none" else f"seed {seed}"


def _window_lines(
    settings: DiagnosisSettings,
    window: str,
    load: str,
    deviations: str,
    spectra: Mapping[tuple[str, str], Spectrum],
    envelopes: Mapping[tuple[str, str], Spectrum],
) -> LineTable:
    f_r, f_m = settings.revolution_frequency, settings.mesh_frequency
    resolution, top = (float(envelopes["faulty", window].frequency[i]) for i in (1, -1))
    sides = range(-settings.sideband_orders, settings.sideband_orders + 1)
    on_bins = [("envelope", 0, k) for k in range(1, settings.envelope_harmonics + 1)]
    on_bins += [("sideband" if k else "mesh", n, k) for n in settings.mesh_harmonics for k in sides]
    found = [_Line(kind, _label(n, k), n, k, n * f_m + k * f_r, 0.0) for kind, n, k in on_bins]
    found += _placed_lines(settings, resolution, top)
    kind, label, harmonic, order, place, reach = (np.array(column) for column in zip(*found, strict=True))
    frequency, between = place.copy(), slice(len(on_bins), None)
    frequency[between] = np.round(place[between] / resolution) * resolution  # the nearest bin
    is_envelope = np.isin(kind, IN_ENVELOPE)
    columns: dict[str, np.ndarray] = {}
    for state in STATES:
        columns[state], columns[f"{state}_floor"] = np.empty((2, len(found)))
        for spectrum, rows in ((envelopes[state, window], is_envelope), (spectra[state, window], ~is_envelope)):
            columns[state][rows] = spectrum.lines(place[rows], reach[rows])
            columns[f"{state}_floor"][rows] = spectrum.floors(frequency[rows])
    difference = level(columns["faulty"], columns["healthy"])
    over_floor = level(columns["faulty"], columns["faulty_floor"])
    rope = float(settings.rope_mode.get(window, 0.0))
    offset = np.abs(order) * f_r
    offset[between] = frequency[between]
    return LineTable(
        load_case=(load,) * len(found),
        deviations=(deviations,) * len(found),
        window=(window,) * len(found),
        kind=tuple(kind),
        label=tuple(label),
        order=order,
        mesh_harmonic=harmonic,
        frequency=frequency,
        difference=difference,
        over_floor=over_floor,
        healthy_over_floor=level(columns["healthy"], columns["healthy_floor"]),
        detected=(difference >= settings.difference_limit) & (over_floor >= settings.floor_limit),
        rope_mode=np.full(len(found), rope),
        near_rope=(rope > 0) & (np.abs(offset - rope) <= LINE_WIDTH * resolution),
        **columns,
    )


class _Line(NamedTuple):
    """A line n f_m + k f_r, or one between bins: its amplitude is the largest within `reach` (Hz) of its place (Hz)."""

    kind: str
    label: str
    mesh_harmonic: int
    order: int
    place: float
    reach: float


def _placed_lines(settings: DiagnosisSettings, resolution: float, top: float) -> list[_Line]:
    """Lines of bearings and shafts that a spectrum with the resolution (Hz) contains, up to `top` (Hz)."""
    least = resolution / 2  # excludes the mean
    found = [_Line("bearing", name, 0, 0, f, 0.0) for name, f in settings.bearings.items() if least < f <= top]
    for spall in settings.passes:
        for name, k, f in spall.monitored():
            reach = max(resolution, spall.spread * f)
            if least < f < top - reach:
                found.append(_Line("pass", name, 0, k, f, reach))
    turning = [line for fault in settings.turning for line in fault.monitored()]
    found += [_Line("shaft", name, 0, k, f, resolution) for name, k, f in turning if readable(f, resolution, top)]
    return list(dict.fromkeys(found))  # faults of one shaft have the same lines


def _label(n: int, k: int) -> str:
    order = "" if k == 0 else (f"{abs(k)} f_r" if abs(k) > 1 else "f_r")
    if n == 0:
        return order
    mesh = "f_m" if n == 1 else f"{n} f_m"
    return mesh if k == 0 else f"{mesh} {'+' if k > 0 else '-'} {order}"
