"""Units of the channels of a recording: accelerations, voltages and times, and their factors to SI."""

from __future__ import annotations

from collections.abc import Mapping

GRAVITY = 9.80665  # m/s2 in a g (ISO 80000-3)
ACCELERATIONS: Mapping[str, float] = {"m/s2": 1.0, "mm/s2": 1e-3, "g": GRAVITY, "mg": 1e-3 * GRAVITY}
VOLTAGES: Mapping[str, float] = {"V": 1.0, "mV": 1e-3}
TIMES: Mapping[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
_SPELLINGS = {
    "ms2": "m/s2", "m/s/s": "m/s2", "ms-2": "m/s2", "gn": "g", "volt": "V", "volts": "V", "v": "V", "mv": "mV",
    "sec": "s", "seconds": "s", "second": "s", "msec": "ms", "usec": "us", "\u00b5s": "us", "\u03bcs": "us",
}  # fmt: skip


def plain_units(text: str) -> str:
    """Units as gearcase writes them: "m/s^2", "m/s**2", "m/s\u00b2" are all m/s2. What is not known stays as it is."""
    plain = text.strip().replace("\u00b2", "2").replace("**", "").replace("^", "").replace(" ", "")
    if plain.lower() in _SPELLINGS:
        return _SPELLINGS[plain.lower()]
    known = next((unit for unit in (*ACCELERATIONS, *TIMES) if unit == plain.lower()), None)
    return known or (plain if plain in VOLTAGES else text.strip())


def may_be_acceleration(units: str) -> bool:
    """Whether a channel with these units can be a sensor: unsaid, an acceleration or a voltage."""
    return not units or plain_units(units) in (*ACCELERATIONS, *VOLTAGES)
