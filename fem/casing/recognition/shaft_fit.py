"""Assignment of the bores of a file to the bearing seats of shafts, and the resulting position of the file.

    x = origin + x_file @ axes

Coaxial bores form a line in which a shaft can run. Two lines placed on two shaft axes give the rotation about y and the
origin in the frame of the machine; the other shafts and the bearings along y rate this fit. Every pair of lines with
the distance of the two shafts, within a tolerance, is tried, with y in both directions of the bores.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from fem.casing.recognition.housing_contents import FoundBore

OFF = 0.002  # m, or
OFF_SHARE = 0.03  # of the distance: tolerance of centre distances between file and machine
_ONE_LINE = 1e-4  # m
_IN_PLACE = 1e-4  # m: beyond it all seats are shifted by the middle of their deviations
_AS_IT_IS = 2.999  # trace of a rotation by less than 2 degrees
_PARALLEL = math.cos(math.radians(0.5))


@dataclass(frozen=True, kw_only=True)
class FittedShaft:
    """A shaft: its axis at (x, z), y of its bearings in the casing, its diameter there; a seat is wider (m)."""

    x: float
    z: float
    bearings: tuple[tuple[str, float], ...]
    diameter: float


@dataclass(frozen=True, eq=False, kw_only=True)
class SeatFit:
    """A bearing in its bore: distance `off` of the axes of bore and shaft, and the middle of the seat along y (m)."""

    bearing: str
    shaft: int  # from 0
    bore: FoundBore
    off: float
    y: float  # of the bearing
    middle: float  # of the seat, in the frame of the machine


@dataclass(frozen=True, eq=False, kw_only=True)
class ShaftFit:
    """Position of the file in the frame of the machine, and the bearing seats found."""

    origin: np.ndarray  # (3,) m
    axes: np.ndarray  # (3, 3), directions of the file's x, y, z, one per row
    seats: tuple[SeatFit, ...]

    @property
    def off(self) -> float:
        """Largest distance (m) between a shaft and the axis of its seat."""
        return max((seat.off for seat in self.seats), default=math.inf)

    def placed(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the file in the frame of the machine, m."""
        return self.origin + points @ self.axes


_Line = tuple[np.ndarray, list[FoundBore]]  # bores about one axis along the common direction, and its point


def fit_shafts(bores: Sequence[FoundBore], shafts: Sequence[FittedShaft]) -> ShaftFit | None:
    """The best position of the file; None if no two bores have the distance of two shafts.

    Fits are ranked by the number of bearings in seats, the least deviation, and the fewest incomplete bores. Among
    equal ones a file that need not be rotated is best, then one of whose axes x, y, z one points up rather than down,
    then wider bores at thicker shafts, then the least rotation.

    Parameters
    ----------
    bores : of the file, m
    shafts : shafts of the machine with bearings in the casing
    """
    wide = [bore for bore in bores if bore.diameter > min((shaft.diameter for shaft in shafts), default=0.0)]
    found = [fit for axis in _directions(wide) for fit in _fits(_lines(wide, axis), axis, shafts)]
    found = [fit for fit in found if fit.seats]

    def worth(fit: ShaftFit) -> tuple[float, ...]:
        taken = len({(seat.bore.number) for seat in fit.seats})
        open_bores = sum(seat.bore.angle < 6.0 for seat in fit.seats)
        turned = round(float(np.trace(fit.axes)), 6)
        alike = sum(shafts[seat.shaft].diameter * seat.bore.diameter for seat in fit.seats)
        up = fit.axes[:, 2]
        upright = up[np.abs(up).argmax()] > 0.0
        return taken, -round(fit.off, 5), -open_bores, turned > _AS_IT_IS, upright, round(alike, 9), turned

    return max(found, key=worth, default=None)


def _directions(bores: Sequence[FoundBore]) -> list[np.ndarray]:
    """Directions of the bores, one of each group of parallel ones."""
    found: list[np.ndarray] = []
    for bore in bores:
        if all(abs(bore.axis @ other) < _PARALLEL for other in found):
            found.append(bore.axis)
    return found


def _lines(bores: Sequence[FoundBore], axis: np.ndarray) -> list[_Line]:
    lines: list[_Line] = []
    for bore in bores:
        if abs(bore.axis @ axis) < _PARALLEL:
            continue
        across = bore.centre - axis * (bore.centre @ axis)
        for point, own in lines:
            if np.linalg.norm(across - point) < _ONE_LINE:
                own.append(bore)
                break
        else:
            lines.append((across, [bore]))
    return lines


def _fits(lines: Sequence[_Line], axis: np.ndarray, shafts: Sequence[FittedShaft]) -> Iterator[ShaftFit]:
    for y in (axis, -axis):
        for turn, place in _turns(lines, y, shafts):
            fit = _along(lines, shafts, turn, place)
            if fit is not None:
                yield fit


def _turns(
    lines: Sequence[_Line], y: np.ndarray, shafts: Sequence[FittedShaft]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Rotations `axes` (3, 3) and origins (3,), the latter without their part along y."""
    if len(shafts) == 1:
        turn = _nearest_turn(y)
        for point, _ in lines:
            yield turn, np.array([shafts[0].x, 0.0, shafts[0].z]) - (point @ turn) * [1.0, 0.0, 1.0]
        return
    places = np.array([[shaft.x, shaft.z] for shaft in shafts])
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    one, two = np.unravel_index(int(apart.argmax()), apart.shape)
    wanted = float(apart[one, two])
    for (first, _), (second, _) in permutations(lines, 2):
        span = second - first
        if abs(np.linalg.norm(span) - wanted) > max(OFF, OFF_SHARE * wanted):
            continue
        step = (places[two] - places[one]) / wanted
        x_or_z = span / np.linalg.norm(span)
        normal = np.cross(x_or_z, y)  # with this direction, x x y = z
        file_frame = np.array([x_or_z, y, normal])
        machine = np.array([[step[0], 0.0, step[1]], [0.0, 1.0, 0.0], [-step[1], 0.0, step[0]]])
        turn = file_frame.T @ machine
        middle = 0.5 * (places[one] + places[two])
        at = 0.5 * (first + second) @ turn
        yield turn, np.array([middle[0] - at[0], 0.0, middle[1] - at[2]])


def _nearest_turn(y: np.ndarray) -> np.ndarray:
    """The least rotation from the direction y of the file to y of the machine."""
    target = np.array([0.0, 1.0, 0.0])
    if y @ target < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.cross(y, target)
    skew = np.array([[0.0, -cross[2], cross[1]], [cross[2], 0.0, -cross[0]], [-cross[1], cross[0], 0.0]])
    turn: np.ndarray = (np.eye(3) + skew + skew @ skew / (1.0 + y @ target)).T
    return turn


def _along(
    lines: Sequence[_Line], shafts: Sequence[FittedShaft], turn: np.ndarray, place: np.ndarray
) -> ShaftFit | None:
    """The fit shifted along y so that most bearings are in seats."""
    of_shaft: list[tuple[float, list[tuple[FoundBore, float]]]] = []
    for shaft in shafts:
        at = np.array([point @ turn + place for point, _ in lines])
        distance = np.hypot(at[:, 0] - shaft.x, at[:, 2] - shaft.z)
        for number in np.argsort(distance):
            seats = [bore for bore in lines[number][1] if bore.diameter > shaft.diameter]
            if seats:
                break
        if not seats or distance[number] > OFF + OFF_SHARE * math.hypot(shaft.x, shaft.z):
            return None
        of_shaft.append((float(distance[number]), [(bore, float((bore.centre @ turn)[1])) for bore in seats]))
    shifts = [
        y - middle
        for shaft, (_, seats) in zip(shafts, of_shaft, strict=True)
        for _, y in shaft.bearings
        for _, middle in seats
    ]
    best: tuple[tuple[int, float], float, list[SeatFit]] | None = None
    for shift in sorted(set(np.round(shifts, 6))):
        found, taken = [], set()
        for index, (shaft, (off, seats)) in enumerate(zip(shafts, of_shaft, strict=True)):
            for name, y in shaft.bearings:
                bore, middle = min(seats, key=lambda one: abs(one[1] + shift - y))
                if bore.number not in taken:
                    taken.add(bore.number)
                    found.append(SeatFit(bearing=name, shaft=index, bore=bore, off=off, y=y, middle=middle + shift))
        score = (len(found), -sum(abs(seat.middle - seat.y) for seat in found))
        if best is None or score > best[0]:
            best = score, float(shift), found
    if best is None:
        return None
    _, shift, seats_there = best
    past = [seat.y - seat.middle for seat in seats_there]
    between = 0.5 * (min(past) + max(past)) if max(map(abs, past)) > _IN_PLACE else 0.0
    return ShaftFit(
        origin=place + [0.0, shift + between, 0.0],
        axes=turn,
        seats=tuple(replace(seat, middle=seat.middle + between) for seat in seats_there),
    )


def tilt(bores: Sequence[FoundBore]) -> tuple[np.ndarray, float]:
    """The axis of the file nearest to the direction of the widest bores, and the angle (rad) between the two."""
    axis = bores[0].axis
    nearest = np.eye(3)[int(np.abs(axis).argmax())]
    return nearest, math.acos(min(1.0, float(abs(axis @ nearest))))
