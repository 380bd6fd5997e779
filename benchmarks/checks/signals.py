"""Kinematic frequencies of the rig and known signals through the spectra."""

from __future__ import annotations

import numpy as np

from benchmarks.checks.record import Check, Subject, Values
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.signals.spectrum import amplitude_spectrum, cut, envelope, envelope_spectrum, whole_revolutions

RATE, MESH = 10_000.0, 300.0
WHEEL = MESH / 55


def _rig() -> Values:
    first = make_machine(load_scene("rig-healthy").scene).facts.stages[0]
    return [first.mesh_frequency, first.wheel_frequency]


def _revolutions() -> Values:
    segment = whole_revolutions((0.5, 2.5), RATE, WHEEL)
    return [segment.revolutions, segment.samples]


def _modulated_tone() -> Values:
    """Carrier, sideband and modulation depth of 2 (1 + 0.3 cos 2 pi f_r t) cos 2 pi f_m t, and the line's place."""
    time = np.arange(50_000) / RATE
    signal = 2 * (1 + 0.3 * np.cos(2 * np.pi * WHEEL * time + 0.4)) * np.cos(2 * np.pi * MESH * time + 1)
    segment = whole_revolutions((0.5, 2.5), RATE, WHEEL)
    piece, band = cut(signal, RATE, segment), (150.0, 450.0)
    carrier, side = amplitude_spectrum(piece, segment).lines([MESH, MESH + WHEEL])
    found = envelope_spectrum(piece, segment, band)
    depth = found.lines([WHEEL])[0] / envelope(piece, segment, band).mean()
    return [float(v) for v in (carrier, side, depth, found.frequency[np.argmax(found.amplitude)])]


SUBJECT = Subject("Frequencies and spectra", (
    Check("f_m and f_r of the stage 1 wheel at 900 rpm",
          "quay-crane hoist study, Springer 978-981-97-1876-4, chapter 15", "Hz", (300.0, 5.4545), 1e-5, _rig,
          "test_spectrum.py::test_nine_wheel_revolutions_of_the_20_55_stage_are_16500_samples"),
    Check("revolutions and samples of the lifting window at 10 kHz", "exact", "", (9, 16_500), 1e-12, _revolutions,
          "test_spectrum.py::test_nine_wheel_revolutions_of_the_20_55_stage_are_16500_samples"),
    Check("amplitude-modulated tone: carrier, sideband, modulation depth, modulation frequency (Hz)", "exact", "",
          (2.0, 0.3, 0.3, WHEEL), 1e-8, _modulated_tone,
          "test_spectrum.py::test_envelope_gives_modulation_frequency_and_depth"),
))  # fmt: skip
