"""Best speed by all lines of a vibration, and the shafts whose sidebands confirm it.

The angle that follows from a single line may be wrong by a factor, since the line may be a mesh order or a sideband. In
an order spectrum over this angle all lines are sharp, so that every factor can be tried on the same spectrum. The score
of a speed is a sum over stages and shafts: the mean level of the mesh orders of a stage, and that of the sidebands of a
shaft. Each is in standard deviations over its median for all speeds of the search. Lines of other stages and rational
multiples such as 4/3 cause scores at wrong speeds.

Mesh orders alone do not reveal wrong tooth numbers: f_m1 / f_m2 = z_2 / z_3 does not depend on z_1. A shaft is
therefore confirmed only by the spacing of its sidebands. Lines of other shafts are omitted, and the spacing is varied
within SPACINGS. Three conditions must hold:

- At the spacing by the tooth numbers the mean level is significant, and clearly higher than at the spacings of gears
  with one tooth more or less.
- It remains significant, and not much lower, without the sidebands at multiples of 2, 3 and 5 of the order of the
  shaft. If the true speed is a rational multiple, only these are lines, and the others are as high as noise.
- Midway between the sidebands, where lines are if the true speed is half of it, the level is clearly lower.

The nearest sidebands alone, or all of them, must meet the conditions. If either are significant and the last two
conditions do not hold, the shaft is not confirmed.

References
----------
Leclere, Andre & Antoni (2016), Mech. Syst. Signal Process. 81, 375-386 (many orders as evidence of one speed);
Randall (2011), Vibration-based Condition Monitoring, Wiley, section 5.4 (sidebands of gears and their spacing).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from fem.numerics.sinc_interpolation import interpolated
from pipelines.signals.orders.kinematics import Kinematics, Shaft

HARMONICS = 5  # of a mesh
SIDEBANDS = 20  # on either side, at most up to half of the teeth
FEW = 3  # nearest sidebands, which are also evaluated separately, since often there are no others
CONFIRMED = 6.0  # standard deviations, of the sidebands at the spacing of a shaft
REMAINING = 3.0  # the same without those at multiples of a factor
SHARE = 0.25  # of the level of all sidebands, also required without those; true speeds have 0.4 or more, others 0.1
CLEARLY = 2.0  # times the level at the spacings of gears with one tooth more or less
FACTORS = (2, 3, 5)  # at half the true speed, for example, only every second multiple of the order is a line
SPACINGS = 0.3  # search range about the spacing by the tooth numbers, relative
_SEGMENT, _SEGMENTS = 1 << 17, 8  # samples of a spectrum, and largest number of averaged spectra
_PADDED = 2  # zero padding: lines per independent line of the spectrum
_LOBE = 2  # lines from the middle of a main lobe to its end (Hann)
NO_SIDEBANDS = "its mesh lines have no sidebands at its revolution frequency"
_FRACTION = "the spacing of its sidebands is a multiple or a fraction of the order of this shaft"
_RESOLVED = 10  # lines between the sidebands of a shaft whose lines are omitted


class OrderLevels:
    """Order spectrum in dB over the floor around each line, averaged over channels; `per_order` lines per order."""

    def __init__(self, signals: Sequence[np.ndarray], angle: np.ndarray) -> None:
        turns = (angle[-1] - angle[0]) / (2.0 * np.pi)
        count = len(angle)
        size = min(count, _SEGMENT)
        self.per_order = _PADDED * turns * size / count
        place = np.interp(np.linspace(angle[0], angle[-1], count), angle, np.arange(count))
        starts = np.unique(np.linspace(0, count - size, min(_SEGMENTS, -(-count // size))).astype(int))
        window = np.hanning(size + 1)[:-1]
        levels = []
        for signal in signals:
            pieces = (interpolated(signal, place[start : start + size]) for start in starts)
            power = np.mean([np.abs(np.fft.rfft(window * one, _PADDED * size)) ** 2 for one in pieces], axis=0)
            level = 10.0 * np.log10(power + np.finfo(float).tiny)
            levels.append(np.maximum(level - _floor(level, 2.0 * self.per_order), 0.0))
        self.values = np.mean(levels, axis=0)
        self.used = np.ones(len(self.values))  # 0 for omitted lines

    def mean(self, orders: Iterator[np.ndarray]) -> np.ndarray:
        """Mean level (speed,) over lines; each item of `orders` (speed,) is a line. 0 without lines in the spectrum."""
        total, number = np.zeros(1), np.zeros(1)
        for order in orders:
            line = np.rint(order * self.per_order).astype(int)
            within = (line > _LOBE * _PADDED) & (line < len(self.values))
            line = np.where(within, line, 0)
            used = self.used[line] * within
            total, number = total + self.values[line] * used, number + used
        return total / np.maximum(number, 1.0)

    def leave_out(self, orders: Iterable[float]) -> None:
        """Omit the main lobes of these lines, and of no others, from the following means."""
        self.used[:] = 1.0
        reach = _LOBE * _PADDED - 1
        for order in orders:
            line = round(order * self.per_order)
            self.used[max(line - reach, 0) : line + reach + 1] = 0.0


def _floor(level: np.ndarray, width: float) -> np.ndarray:
    """Floor of a spectrum: medians of blocks of `width` lines, interpolated linearly."""
    ends = np.linspace(0, len(level), max(2, round(len(level) / max(width, 32.0))) + 1).astype(int)
    medians = [np.median(level[first:last]) for first, last in zip(ends[:-1], ends[1:], strict=True)]
    return np.interp(np.arange(len(level)), 0.5 * (ends[:-1] + ends[1:]), medians)


def best_speed(levels: OrderLevels, kinematics: Kinematics, lowest: float, highest: float) -> tuple[float, float]:
    """The factor of the speed with the highest score, and the second best score relative to it.

    Parameters
    ----------
    levels : over an angle that is proportional to that of the machine
    kinematics : with gears
    lowest, highest : range of the factor
    """
    meshes = kinematics.mesh_orders()
    fastest = max(meshes.values())
    step = 0.5 / (HARMONICS * fastest * levels.per_order)
    factors = np.exp(np.arange(np.log(lowest), np.log(highest), step / highest))
    score = np.zeros(len(factors)) + sum(
        _deviations(levels.mean(harmonic * mesh * factors for harmonic in range(1, HARMONICS + 1)))
        for mesh in meshes.values()
    )
    score += sum(
        _deviations(levels.mean((mesh + side) * shaft.ratio * factors for mesh, side in _sidebands(kinematics, shaft)))
        for shaft in kinematics.shafts
    )
    best = int(np.argmax(score))
    others = np.abs(factors / factors[best] - 1.0) > _LOBE * _PADDED / (fastest * levels.per_order)
    return float(factors[best]), float(score[others].max() / score[best])


def unconfirmed(levels: OrderLevels, kinematics: Kinematics) -> dict[str, str]:
    """The shafts whose sideband spacing is not confirmed, each with the reason.

    Parameters
    ----------
    levels : over the angle of the first shaft
    kinematics : with gears
    """
    return {
        shaft.name: reason for shaft in kinematics.shafts if (reason := _unconfirmed(levels, kinematics, shaft.name))
    }


def _unconfirmed(levels: OrderLevels, kinematics: Kinematics, name: str) -> str:
    """The reason why the spacing of a shaft is not confirmed; empty if it is."""
    lines = [harmonic * mesh for mesh in kinematics.mesh_orders().values() for harmonic in range(1, HARMONICS + 1)]
    for other in kinematics.shafts:
        if other.name != name and other.ratio * levels.per_order > _PADDED * _RESOLVED:
            lines += [(mesh + side) * other.ratio for mesh, side in _sidebands(kinematics, other)]
    levels.leave_out(lines)
    reasons = [_unlike(levels, kinematics, kinematics.shaft(name), reach) for reach in (FEW, SIDEBANDS)]
    return _FRACTION if _FRACTION in reasons else reasons[-1] if all(reasons) else ""


def _unlike(levels: OrderLevels, kinematics: Kinematics, shaft: Shaft, reach: int) -> str:
    """The reason why `reach` sidebands on either side do not confirm the spacing of a shaft; empty if they do."""
    resolution = 0.5 / (levels.per_order * shaft.ratio * reach)
    spacings = np.arange(-SPACINGS, SPACINGS, resolution)
    neighbours = [g.teeth / (g.teeth + more) - 1.0 for g in kinematics.gears_on(shaft.name) for more in (-1, 1)]
    tried = 1.0 + np.concatenate([[0.0], neighbours, spacings])
    lines = list(_sidebands(kinematics, shaft, reach))

    def deviations(factor: int) -> np.ndarray:
        kept = [(mesh, side) for mesh, side in lines if factor == 1 or (mesh + side) % factor]
        found = levels.mean((mesh + side * tried) * shaft.ratio for mesh, side in kept)
        between = levels.mean((mesh + side + 0.5) * shaft.ratio * tried[:1] for mesh, side in kept)
        return _deviations(np.append(found, between), slice(1 + len(neighbours), -1))

    level = deviations(1)
    shown, between, other = level[0], level[-1], level[1 : 1 + len(neighbours)].max(initial=0.0)
    if max(shown, other) < CONFIRMED:
        return NO_SIDEBANDS
    if other > shown / CLEARLY:
        found = "another number of teeth" if other > shown else "one tooth more or less, too"
        return f"its sidebands have the spacing of a gear with {found}"
    if between > shown / CLEARLY or min(deviations(one)[0] for one in FACTORS) < max(REMAINING, SHARE * shown):
        return _FRACTION
    return ""


def _sidebands(kinematics: Kinematics, shaft: Shaft, reach: int = SIDEBANDS) -> Iterator[tuple[int, int]]:
    """Mesh orders of a shaft, in its orders, each with the distance of one of their sidebands."""
    for gear in kinematics.gears_on(shaft.name):
        for harmonic in range(1, HARMONICS + 1):
            for number in range(1, min(reach, gear.teeth // 2) + 1):
                for side in (-number, number):
                    yield harmonic * gear.teeth, side


def _deviations(level: np.ndarray, among: slice = slice(None)) -> np.ndarray:
    """Deviations of levels from the median, in robust standard deviations; both are those of the levels `among`."""
    middle = np.median(level[among])
    return (level - middle) / (1.4826 * np.median(np.abs(level[among] - middle)) + np.finfo(float).tiny)
