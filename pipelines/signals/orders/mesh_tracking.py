"""The angle of a machine from its vibration alone, by the phase of its mesh orders.

The phase of a line of order o is o times the angle of the first shaft. The method iterates:

1. `pipelines.signals.orders.speed_search` gives a first estimate of the angle.
2. Each mesh order is demodulated with the estimate, x(t) exp(-i o angle(t)), and averaged under Hann windows of TURNS
   turns of the slower shaft of the pair. The sidebands of that shaft fall on zeros of these windows.
3. The remaining phase, divided by o, is the error of the angle. Lines are weighted by the steadiness of their phase,
   the channels of a line by its largest principal component. The corrected angle is the next estimate.

The steadiest line may be another one than the assumed mesh order, which makes the angle wrong by a factor.
`pipelines.signals.orders.speed_evidence` finds this factor, and the shafts that confirm it.

Limits: within a window of length L a line must move by less than the width 1/L of its main lobe. The speed may thus
change by at most 1/(o L^2) Hz per second, where o is the lowest mesh order. A modulation of the phase of all lines that
is slower than 1/L cannot be distinguished from a change of speed.

References
----------
Bonnardot, El Badaoui, Randall, Daniere & Guillet (2005), Mech. Syst. Signal Process. 19(4), 766-785 (angle from the
phase of a mesh line); Urbanek, Barszcz & Antoni (2013), Mech. Syst. Signal Process. 38(1), 96-102; Peeters, Antoni,
Leclere, Verstraeten & Helsen (2022), Mech. Syst. Signal Process. 167, 108533 (many lines, weighted).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipelines.signals.orders.kinematics import Kinematics
from pipelines.signals.orders.revolutions import HIGHEST
from pipelines.signals.orders.rotation import Rotation, RotationError
from pipelines.signals.orders.smoothing import smooth
from pipelines.signals.orders.speed_evidence import HARMONICS, OrderLevels, best_speed, unconfirmed
from pipelines.signals.orders.speed_search import RANGE, speed_path

TURNS = 2  # of the slower shaft in a window of the phase
SIDEBANDS = 2  # of each shaft on either side, in the first search
CHANNELS = 6  # used at most, those with the steadiest mesh orders
WIDER = 0.35  # relative search range of the final speed; wider than RANGE to notice a better speed beyond it
MARGIN = 0.7  # of the best score; the second best has up to 0.57 for correct teeth, 0.75 or more for a wrong speed
SWING = 3e-4  # rad, oscillation of a geared shaft within a mesh cycle, which no window resolves
ROUNDS = 4  # iterations
FEWEST_WINDOWS = 6
STEADY = 0.6  # rad, largest rms of the second difference of a steady phase; for a random phase it is 1.8
LARGEST = 2.5  # rad, largest second difference; near pi, the phase may have slipped by a whole turn
NEIGHBOURS = (
    4.0 / 3.0
)  # noise power at low frequencies, relative: windows that overlap by half have a correlation of 1/6


class _Line(NamedTuple):
    """A demodulated mesh order: order, phasor (window,), rms and maximum of the second difference of its phase, rad."""

    order: float
    phasor: np.ndarray
    scatter: float
    largest: float


def track(signals: Sequence[np.ndarray], rate: float, kinematics: Kinematics) -> Rotation:
    """The rotation from the vibration alone.

    Parameters
    ----------
    signals : float (time,) of every channel, all finite
    rate : sampling rate, Hz
    kinematics : with gears and a nominal speed that is known within RANGE

    Raises
    ------
    RotationError : numbers of teeth or nominal speed are not known, the recording is too short, no mesh order has a
        steady phase, or the speed changes too fast
    """
    if not kinematics.gears or kinematics.frequency is None:
        missing = "its nominal speed" if kinematics.gears else "the teeth of its gears"
        raise RotationError(
            f"no angle, no tachometer, and {missing} unknown: the speed cannot be found in the vibration. Record a "
            f"tachometer, or give a machine file with {missing}, or with speed and its uncertainty."
        )
    nominal = kinematics.frequency
    stage, mesh = max(kinematics.mesh_orders().items(), key=lambda item: item[1])
    slow = min(kinematics.shaft(gear.shaft).ratio for gear in kinematics.gears if gear.stage == stage)
    seconds = TURNS / (slow * nominal)
    _check_length(len(signals[0]) / rate, seconds, stage)
    change = 1.0 / (mesh * seconds**2)
    orders = mesh * np.arange(1, HARMONICS + 1)
    orders = orders[orders * nominal * (1.0 + RANGE) < HIGHEST * rate]
    if not len(orders):
        raise RotationError(
            f"the mesh frequency of stage {stage} at {1.0 + RANGE:g} times speed_rpm, "
            f"{(1.0 + RANGE) * mesh * nominal:.4g} Hz, is above {HIGHEST * rate:.4g} Hz ({HIGHEST:g} of the sampling "
            f"rate of {rate:g} Hz). Correct speed_rpm or the unit of time, sample faster, or record a tachometer."
        )
    search = _search_orders(kinematics, rate)
    middles, speeds = speed_path(signals, rate, search, nominal, 2.0 * seconds, change)
    time = np.arange(len(signals[0])) / rate
    turned = np.interp(time, middles, speeds)
    angle = 2.0 * np.pi * np.concatenate([[0.0], np.cumsum(0.5 * (turned[1:] + turned[:-1]))]) / rate
    size = round(seconds * rate)
    signals = _clearest(signals, angle, orders, size)
    unsteady = (
        "the speed cannot be found from the mesh vibration, for one of four reasons: no line at a mesh order of "
        f"stage {stage} has a steady phase, shaft 1 does not turn at {60.0 * nominal:.5g} rpm within "
        f"{100 * RANGE:g} %, its speed changes by more than {change:.3g} Hz per second, or strong impacts of a bearing "
        "or tooth hide the mesh orders. Give a machine file with another speed_rpm, or, if there are impacts, with "
        "speed and its uncertainty, such as speed = { rpm = 1460, uncertainty_percent = 2 }. Or record a tachometer "
        'or the speed, such as speed = { channel = "n", units = "rpm" }, which a run-up needs, or cut the recording to '
        "a part at steady speed."
    )
    angle, _, _ = _tracked(signals, angle, orders, size, unsteady, most=1)
    angle = _at_best_speed(signals, angle, rate, kinematics)
    before = float(angle[-1] - angle[0])
    size = round(TURNS * len(angle) / (slow * before / (2.0 * np.pi)))
    _check_length(len(angle) / rate, size / rate, stage)
    angle, error, used = _tracked(signals, angle, orders, size, unsteady)
    if abs(float(angle[-1] - angle[0]) / before - 1.0) > 2.0 * np.pi / (mesh * before):
        raise RotationError(unsteady)
    return Rotation(
        angle=np.maximum.accumulate(angle - angle[0]),
        source=f"phase of {used} mesh line{'s' if used > 1 else ''} of stage {stage} in the vibration",
        error=float(np.hypot(error, SWING)) / float(angle[-1] - angle[0]),
        absolute=False,
        conditional=unconfirmed(OrderLevels(signals, angle), kinematics),
    )


def _check_length(duration: float, seconds: float, stage: int) -> None:
    """Raise RotationError for a recording with fewer than FEWEST_WINDOWS windows of the phase."""
    if duration < (FEWEST_WINDOWS + 1) * seconds / 2:
        raise RotationError(
            f"the recording lasts {duration:.3g} s; to find the speed from the mesh of stage {stage} takes "
            f"{(FEWEST_WINDOWS + 1) * seconds / 2:.3g} s at this speed. Correct speed_rpm, or use a longer recording "
            "or one with a tachometer."
        )


def _tracked(
    signals: Sequence[np.ndarray],
    angle: np.ndarray,
    orders: np.ndarray,
    size: int,
    unsteady: str,
    most: int = HARMONICS,
) -> tuple[np.ndarray, float, int]:
    """Angle from at most `most` of the steadiest lines, uncertainty of its total increase, and number of lines used."""
    error, used = np.inf, 0
    for _ in range(ROUNDS):
        lines = sorted(
            (_at_rest(signals, angle, order, size) for order in orders), key=lambda one: one.scatter / one.order
        )
        steady = [line for line in lines if line.scatter < STEADY and line.largest < LARGEST][:most]
        if not steady:
            raise RotationError(unsteady)
        angle, error = _corrected(steady, angle, size)
        used = len(steady)
    return angle, error, used


def _at_best_speed(signals: Sequence[np.ndarray], angle: np.ndarray, rate: float, kinematics: Kinematics) -> np.ndarray:
    """The angle, corrected by the factor that fits the lines of all gears best.

    Raises
    ------
    RotationError : the corrected speed is outside RANGE, or another one fits nearly as well
    """
    nominal = kinematics.frequency or 0.0
    speed = float(angle[-1] - angle[0]) / (2.0 * np.pi) * rate / (len(angle) - 1)
    factor, second = best_speed(
        OrderLevels(signals, angle), kinematics, *((1.0 + side * WIDER) * nominal / speed for side in (-1, 1))
    )
    found = f"the lines of the gears fit best at {60.0 * factor * speed:.5g} rpm"
    if abs(factor * speed / nominal - 1.0) > RANGE:
        raise RotationError(
            f"{found}, which is more than {100 * RANGE:g} % from speed_rpm = {60.0 * nominal:.5g}. Correct speed_rpm "
            "or teeth, set speed with its uncertainty, or record a tachometer."
        )
    if second > MARGIN:
        raise RotationError(
            f"{found}, but another speed within {100 * WIDER:g} % of speed_rpm = {60.0 * nominal:.5g} has "
            f"{100 * second:.0f} % of its score; at most {100 * MARGIN:g} % is accepted. Correct teeth or speed_rpm, "
            "set speed with its uncertainty, use a longer recording, or record a tachometer."
        )
    return factor * angle


def _search_orders(kinematics: Kinematics, rate: float) -> dict[float, float]:
    """Weights of the first search by order: mesh orders of all pairs with sidebands of their shafts, below half the
    sampling rate.

    A sideband has half the weight of its inner neighbour. With equal weights, a mesh order without sidebands would
    give the same score if it were taken for a sideband.
    """
    found: dict[float, float] = {}
    top = HIGHEST * rate / ((kinematics.frequency or 0.0) * (1.0 + RANGE))
    for gear in kinematics.gears:
        ratio = kinematics.shaft(gear.shaft).ratio
        for harmonic in range(1, HARMONICS + 1):
            for k in range(-SIDEBANDS, SIDEBANDS + 1):
                order = round(ratio * (harmonic * gear.teeth + k), 9)
                if 0.0 < order < top:
                    found[order] = max(found.get(order, 0.0), 0.5 ** abs(k))
    return found


def _clearest(signals: Sequence[np.ndarray], angle: np.ndarray, orders: np.ndarray, size: int) -> Sequence[np.ndarray]:
    """The CHANNELS channels whose steadiest mesh order has the steadiest phase."""
    if len(signals) <= CHANNELS:
        return signals
    scatter = [min(_at_rest([signal], angle, order, size).scatter for order in orders) for signal in signals]
    return [signals[i] for i in np.argsort(scatter)[:CHANNELS]]


def _at_rest(signals: Sequence[np.ndarray], angle: np.ndarray, order: float, size: int) -> _Line:
    """A mesh order, demodulated with the angle, from all channels together."""
    window = np.hanning(size + 1)[:-1]
    carrier = np.exp(-1j * order * angle)
    view = np.lib.stride_tricks.sliding_window_view
    phasors = np.array([view(signal * carrier, size)[:: size // 2] @ window for signal in signals])
    _, vectors = np.linalg.eigh(phasors @ phasors.conj().T)
    phasor = vectors[:, -1].conj() @ phasors
    second = np.angle(phasor[2:] * phasor[:-2] * phasor[1:-1].conj() ** 2)
    return _Line(order, phasor, float(np.sqrt(np.mean(second**2))), float(np.abs(second).max()))


def _corrected(lines: list[_Line], angle: np.ndarray, size: int) -> tuple[np.ndarray, float]:
    """The corrected angle (time,) and the standard uncertainty of its total increase, rad.

    The uncertainty is the larger of two estimates: from the scatter of the phase about its smooth curve, and from the
    differences between the lines.
    """
    from scipy.interpolate import CubicSpline

    orders = np.array([line.order for line in lines])
    weights = (orders / np.array([line.scatter for line in lines])) ** 2
    weights /= weights.sum()
    steps = np.array([np.angle(line.phasor[1:] * line.phasor[:-1].conj()) / line.order for line in lines])
    off = np.concatenate([[0.0], np.cumsum(weights @ steps)])
    left = np.array([_residual(line, off) for line in lines])
    off = off + weights @ left
    half = size // 2
    middles = half * (1 + np.arange(len(off)))
    after = -(-(len(angle) - middles[-1]) // half)
    found = smooth(angle[middles] + off, 1, after)
    nodes = half * np.arange(len(found.values))
    climb = np.sqrt(NEIGHBOURS) * found.climb
    if len(lines) > 1:
        place = np.linspace(-0.5, 0.5, left.shape[1])
        slopes = left @ place / (place @ place)
        slopes -= weights @ slopes
        climb = max(climb, float(np.sqrt(weights @ slopes**2 / (len(lines) - 1))))
    return CubicSpline(nodes, found.values)(np.arange(len(angle))), climb


def _residual(line: _Line, off: np.ndarray) -> np.ndarray:
    """Phase of a line after the correction `off`, in rad of the first shaft, without its mean."""
    phasor = line.phasor * np.exp(-1j * line.order * off)
    return np.angle(phasor * np.conj(phasor.sum())) / line.order
