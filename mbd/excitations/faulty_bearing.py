"""Rolling bearing with spalls or cage slip: the elements of `mbd.forces.rolling_bearing`, one by one.

With the true rotation Psi of the shaft in its lifting sense (angle of the motor and torsion), the elements are at

    theta_e = start - sense (chi - lag(chi)) + e 2 pi/Z,   chi = (1 - gamma)/2 Psi,

a spall of the inner ring is at its angle - sense Psi, and an element has rolled by D_m/D (1 + gamma) of the cage's
angle. It rolls on the outer ring: slip is between the elements and the inner ring, which drives them. Over a spall the
two races of an element are further away from one another, along its line of contact, by the drop of `drop_at` at both
its contacts: its approach is delta - drop. The potential of the bearing contains the drop, and the forces follow from
it. It depends on the angle besides the rows. That parametric work is audited, because dU/d angle jumps where an element
passes from one edge to the other (see `mbd.elements.element`).

Not modelled: impacts of elements on the cage, the inertia of elements and cage, damping by the motion over the spall.

An element, a circle of radius r in the rolling plane, turns about the edge of the spall as it comes in and goes out:
its centre follows a circular arc about that edge, tangent to its path on the undamaged race. At the distance s from the
nearer edge, measured along the chord, it has come closer to the race by

    drop = min(depth, r - sqrt(r^2 - s^2) -+ (rho - sqrt(rho^2 - s^2))),

with the radius rho of the race in the rolling plane, minus for the outer race, which is hollow, plus for the inner one.
At most it is the sagitta of the element across the chord of the spall, measured from the race. The same holds for a
spall in the element, whose two edges roll over the race. A deep spall is left with a corner at its middle, where the
element goes over from one edge to the other; a shallow one lets it roll along the bottom.

References
----------
Sawalhi & Randall (2008), Mech. Syst. Signal Process. 22, 1924-1951, part I (depth of a local fault over its angle);
Sawalhi & Randall (2011), Mech. Syst. Signal Process. 25, 846-870 (entry on an arc, impact where the element meets the
other edge).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fem.numerics.inner_functions import inner
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import ENERGY, FROZEN_ENERGY, WIDTH, Answer, Element, Motion, rule
from mbd.elements.rule_call import call_rule, rule_number
from mbd.excitations.cage_slip import CageSlip, lag_at
from mbd.excitations.spall import SURFACES, Spall, check_overlap, race_radius
from mbd.forces.rolling_bearing import COUNT, FIRST, RATE, START, RollingContacts
from mbd.parts.bearings import BearingSpec
from mbd.parts.part_checks import MachineError
from mbd.parts.rolling_elements import pass_frequencies

SOUND, GAP, SENSE, RATIO, CAGE, ROLL, ELEMENT, OUTER, INNER, REACH, SPALLS, KNOTS, REST = range(13)
ON, WIDTH_OF, DEPTH, ANGLE, SPALL = range(5)  # places of the numbers of a spall; SPALL is how many there are
ROWS = 5
FULL = 2.0 * math.pi
STEEP = 0.9  # of the element's radius: further from the edge every spall of `DEEPEST` is at its bottom


@inner()
def drop_at(place, width, depth, surface, element, race):
    """Drop (m) of an element over a spall.

    Parameters
    ----------
    place : m, of the contact along the surface, from the middle of the spall
    width, depth : m, of the spall
    surface : m, radius of the surface that has it
    element, race : m, radii of the element and of the race, the latter negative where it bulges
    """
    inside = 0.5 * width - abs(place)
    if inside <= 0.0:
        return 0.0
    across = surface * math.sin(inside / surface)
    if across >= STEEP * element:
        return depth
    return min(depth, _sagitta(element, across) - _sagitta(race, across))


@inner()
def _sagitta(radius, across):
    """r - sqrt(r^2 - s^2) without cancellation; negative with the radius."""
    return across * across / (radius + math.copysign(math.sqrt(radius * radius - across * across), radius))


@rule(__file__)
def faulty_rule(values, motion, answer):
    """Force on the rows ux uy uz rx rz of the inner against the outer ring.

    ``values`` in the order of the constants above: rule of the healthy bearing, the one of its numbers that is a gap
    between the races, kinematics, radii; then the spalls, the walk of the cage, and the numbers of the healthy bearing.
    """
    first = REST + SPALL * int(values[SPALLS])
    sound = values[first + 2 * int(values[KNOTS]) :]
    spalls = values[REST:first].reshape((int(values[SPALLS]), SPALL))
    walk = values[first : first + 2 * int(values[KNOTS])].reshape((int(values[KNOTS]), 2))
    count = int(sound[COUNT])
    pitch = FULL / count
    turned = values[RATIO] * motion.angle + motion.seen[0]
    cage = values[CAGE] * turned
    cage -= lag_at(cage, pitch, walk)
    one, gap = sound.copy(), FIRST + int(values[GAP])
    one[COUNT], one[RATE] = 1.0, 0.0
    chosen, sense = int(values[SOUND]), values[SENSE]
    empty = motion.held[:0]
    asked = len(motion.before) > 0
    now = Motion(0.0, 0.0, 0.0, motion.u, motion.v, motion.seen, motion.u[:0], empty, motion.read_force, empty)
    old = Motion(0.0, 0.0, 0.0, motion.before, motion.v, motion.seen, motion.u[:0], empty, motion.read_force, empty)
    log, none, waste = np.zeros(len(answer.log)), np.zeros(ROWS), np.zeros((ROWS, WIDTH))
    here = Answer(
        answer.elastic, answer.stiffness, answer.lost, answer.lost_by_u, answer.lost_by_v, none, waste, log
    )  # fmt: skip
    there = Answer(answer.frozen, answer.frozen_stiffness, none, waste, waste, none, waste, log)
    for e in range(count):
        one[START] = sound[START] - sense * cage + e * pitch
        one[gap] = sound[gap] + _drop(values, spalls, one[START], sense * turned, values[ROLL] * cage, e)
        call_rule(chosen, one, now, here)
        answer.log[ENERGY] += log[ENERGY]
        if asked:
            call_rule(chosen, one, old, there)
            answer.log[FROZEN_ENERGY] += log[ENERGY]


@inner()
def _drop(values, spalls, place, shaft, rolled, e):
    """Drop (m) of element ``e`` at the angle ``place``; the shaft has turned by ``shaft`` (rad) about +y, and the
    element by ``rolled`` (rad) in the cage."""
    element, outer, inner_race, reach = values[ELEMENT], values[OUTER], values[INNER], values[REACH]
    total = 0.0
    for k in range(len(spalls)):
        on, width, depth, angle = spalls[k, ON], spalls[k, WIDTH_OF], spalls[k, DEPTH], spalls[k, ANGLE]
        if on == 0.0:
            total += drop_at(outer * reach * _wrapped(place - angle), width, depth, outer, element, outer)
        elif on == 1.0:
            away = _wrapped(place - angle + shaft)
            total += drop_at(inner_race * reach * away, width, depth, -inner_race, element, inner_race)
        elif e == 0:
            outward, inward = _wrapped(rolled + angle), _wrapped(rolled + angle + 0.5 * FULL)
            total += drop_at(element * outward, width, depth, element, element, outer)
            total += drop_at(element * inward, width, depth, element, element, inner_race)
    return total


@inner()
def _wrapped(angle):
    """Angle between -pi and pi."""
    return angle - FULL * math.floor(angle / FULL + 0.5)


@dataclass(frozen=True, kw_only=True)
class FaultyContacts:
    """Contacts of a bearing with spalls or cage slip; ``contacts`` are those of the healthy bearing."""

    contacts: RollingContacts
    spalls: tuple[Spall, ...] = ()
    slip: CageSlip | None = None

    def __post_init__(self) -> None:
        for spall in self.spalls:
            spall.check(self.contacts.elements)
        check_overlap(self.spalls, self.contacts.elements)

    def values(self, sense: int, ratio: float) -> np.ndarray:
        """Numbers of the rule from the sense of the shaft about +y and its angle per motor angle."""
        elements = self.contacts.elements
        per = pass_frequencies(elements)
        knots = np.zeros((0, 2)) if self.slip is None else self.slip.walk(FULL / elements.count)
        numbers = np.zeros(REST)
        numbers[SOUND], numbers[GAP] = rule_number(self.contacts.rule), 0 if elements.kind == "ball" else 3
        numbers[SENSE], numbers[RATIO], numbers[CAGE], numbers[ROLL] = sense, ratio, per.cage, per.spin / per.cage
        numbers[ELEMENT], numbers[REACH] = elements.diameter / 2, math.cos(elements.contact_angle)
        numbers[OUTER], numbers[INNER] = (race_radius(elements, race) for race in SURFACES[:2])
        numbers[SPALLS], numbers[KNOTS] = len(self.spalls), len(knots)
        shapes = [(SURFACES.index(s.on), s.width, s.depth, s.angle) for s in self.spalls]
        return np.concatenate([numbers, np.ravel(shapes), knots.ravel(), self.contacts.values(0.0)])

    def element(self, lay: Coordinates, bearing: BearingSpec) -> Element:
        """Force of the bearing; the element also observes the rotation of the shaft at the bearing."""
        return replace(
            self.contacts.element(lay, bearing),
            kind="faulty rolling bearing",
            rule=faulty_rule,
            values=self.values(lay.sense(bearing.shaft), lay.ratios[bearing.shaft]),
            seen=lay.angle_row(bearing.shaft, bearing.y)[None],
            audited=True,
        )


def with_faults(bearing: BearingSpec, spalls: Sequence[Spall] = (), slip: CageSlip | None = None) -> BearingSpec:
    """A rolling bearing with spalls or cage slip; without either, the bearing itself.

    Raises
    ------
    MachineError : the bearing has no rolling elements, or a spall does not fit
    """
    if not spalls and slip is None:
        return bearing
    if not isinstance(bearing.inside, RollingContacts):
        raise MachineError(
            f"bearing {bearing.name}: model {bearing.model} has no rolling elements for spalls or a cage to slip. Give "
            'it the model "hertz".'
        )
    return replace(bearing, inside=FaultyContacts(contacts=bearing.inside, spalls=tuple(spalls), slip=slip))
