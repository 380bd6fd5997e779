"""The features: name, unit, formula and source of each. docs/features.md is made from these definitions.

Symbols: x is the signal in the window less its mean, < > the mean. y is the time-synchronous average of x over the
turns of a shaft, Y_k its peak amplitude at order k of the shaft, z the number of teeth of a gear on it. r is y without
the orders 0, 1 and all multiples of z; d is r without the orders 2 and n z +- 1. e is the squared envelope of x without
orders 0, 1 and n z, above half of the lowest mesh order. w is this part of x, whitened: each line divided by the rms
amplitude of the lines around it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

RMS, ONE, ACCELERATION, NONE = "rms", "1", "1 um/s2", "none"  # references of levels; ISO 1683:2015 for accelerations
_REFERENCE = 1e-6  # m/s2
_ISO, _DYER = "ISO 13373-1:2002, 5", "Dyer & Stewart (1978), J. Mech. Des. 100(2), 229-235"
_STEWART = "Stewart (1977), as in Zakrajsek, Townsend & Decker (1993), NASA TM-105950"
_MCFADDEN = "McFadden (1986), J. Vib. Acoust. 108(2), 165-170"
_AVERAGE = "McFadden (1987), Mech. Syst. Signal Process. 1(1), 83-95"
_HANNA = "Hanna et al. (2011), US patent 7,912,659"
_HO = "Ho & Randall (2000), Mech. Syst. Signal Process. 14(5), 763-788"
_BORGHESANI = "Borghesani et al. (2013), Mech. Syst. Signal Process. 36(2), 370-384"
_RANDALL = "Randall & Antoni (2011), Mech. Syst. Signal Process. 25(2), 485-520"


@dataclass(frozen=True)
class Definition:
    """A feature of a `component`: its `unit`, the `reference` of its level, `words` for tables, `formula` and `source`.

    The level is 20 log10 of value / reference; "rms" is the rms of the channel in the same window.
    """

    component: str
    name: str
    words: str
    formula: str
    source: str
    unit: str = "1"
    reference: str = ONE


_acceleration = partial(Definition, unit="m/s2", reference=RMS)


def _mesh(number: int, suffix: str, side: int) -> Definition:
    order = f"{number} z".removeprefix("1 ") + (f" {side:+d}".replace("+", "+ ").replace("-", "- ") if side else "")
    words = f"{number} x mesh{f', {side:+d}' if side else ''}"
    return _acceleration("gear", f"mesh_{number}{suffix}", words, f"Y_k at k = {order}", _MCFADDEN)


DEFINITIONS = (
    _acceleration("whole machine", "rms", "rms", "sqrt <x^2>", _ISO, reference=ACCELERATION),
    _acceleration("whole machine", "peak", "peak", "max abs x", _ISO, reference=ACCELERATION),
    Definition("whole machine", "crest_factor", "crest factor", "max abs x / sqrt <x^2>", _ISO),
    Definition("whole machine", "kurtosis", "kurtosis", "<x^4> / <x^2>^2; 3 for Gaussian noise", _DYER),
    Definition(
        "whole machine",
        "skewness",
        "skewness",
        "<x^3> / <x^2>^1.5; it has a sign and therefore no level",
        _DYER,
        reference=NONE,
    ),
    _acceleration("shaft", "order_1", "1x", "Y_1; turns weighted by a Hann window", _AVERAGE),
    _acceleration("shaft", "order_2", "2x", "Y_2; turns weighted by a Hann window", _AVERAGE),
    _acceleration("shaft", "tsa_rms", "average", "sqrt <(y - <y>)^2>", _AVERAGE),
    _acceleration("shaft", "tsa_peak_to_peak", "average, peak to peak", "max y - min y", _AVERAGE),
    Definition("shaft", "tsa_kurtosis", "kurtosis of the average", "<(y - <y>)^4> / <(y - <y>)^2>^2", _AVERAGE),
    *(_mesh(number, suffix, side) for number in (1, 2, 3) for suffix, side in (("", 0), ("_lower", -1), ("_upper", 1))),
    _acceleration("gear", "residual_rms", "residual signal", "sqrt <r^2>", _STEWART),
    _acceleration("gear", "difference_rms", "difference signal", "sqrt <d^2>", _STEWART),
    Definition("gear", "fm4", "FM4", "<d^4> / <d^2>^2", _STEWART),
    Definition("gear", "fm0", "FM0", "(max y - min y) / (Y_z + Y_2z + Y_3z)", _STEWART),
    Definition("gear", "sideband_ratio", "sideband ratio", "sum of Y_(z-6) ... Y_(z+6) without Y_z, / Y_z", _HANNA),
    Definition(
        "gear, or shaft without known gears",
        "envelope_orders",
        "envelope",
        "root of the sum of squares of the amplitudes of e at orders 1 to 5, / <e>",
        _HO,
    ),
    Definition(
        "gear",
        "tooth_contrast",
        "energy of one tooth",
        "sqrt(max E_i / median E_i); E_i is the mean of e while tooth i is in mesh",
        _MCFADDEN,
    ),
    Definition(
        "gear", "whitened_kurtosis", "kurtosis of the whitened average", "kurtosis of the average of w", _BORGHESANI
    ),
    Definition(
        "gear",
        "whitened_contrast",
        "energy of one tooth, whitened",
        "as tooth_contrast, of the squared envelope of w",
        _BORGHESANI,
    ),
    Definition(
        "gear",
        "average_contrast",
        "energy of one tooth, whitened average",
        "as tooth_contrast, of the squared envelope of the average of w",
        _BORGHESANI,
    ),
    Definition(
        "rolling bearing",
        "pass_order",
        "pass order in the envelope",
        "The lines of the squared envelope spectrum of w at 1, 2 and 3 times an order are divided by the median within "
        "10 % of 1, 2 and 3 times the pass order. The value is the geometric mean of the three ratios, for the order "
        "within 2 % of the pass order at which it is largest. The largest ratio counts at most 20 dB more than the "
        "second; lines at multiples of shaft speeds have the ratio 1 and are not in the median.",
        _RANDALL,
    ),
    Definition(
        "rolling element",
        "pass_sidebands",
        "pass order and sidebands in the envelope",
        "as pass_order, for 15 lines: those at 1, 2, 3 times 2 BSF, each with two sidebands on each side at multiples "
        "of FTF",
        _RANDALL,
    ),
)
BY_NAME = {one.name: one for one in DEFINITIONS}


def reference_value(name: str, rms: float) -> float:
    """Reference of the level of a feature, in its unit, NaN if it has no level; `rms` (m/s2) is that of the channel."""
    return {RMS: rms, ONE: 1.0, ACCELERATION: _REFERENCE, NONE: math.nan}[BY_NAME[name].reference]
